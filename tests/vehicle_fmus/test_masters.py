"""The same experiment in hosts of others: libcosim, Ecos and FMPy agree."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from hosting import MASTERS, comparable_outputs, difference, in_master
from phaseplane.suspension.models import FILES
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import MODELS
from phaseplane.vehicle_fmus.build import build
from phaseplane.vehicle_fmus.systems import connections

STEP, STEPS = 0.005, 60
# one of each kind, where a model has it
START = {
    "spring.rate": 2e4, "front.spring.rate": 2e4, "rear.damper.table": "-1:-600, 0:0, 1:2500",
    "lift_off": False, "road.shape": "obstacle", "wheelbase": 2.0,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("master", MASTERS)
def test_another_master_gives_what_fmpy_gives(
    master: str, fmus: dict[str, Path], folders: dict[str, str], host: Any, tmp_path: Path
) -> None:
    expected, jobs = [], []
    for model in FILES:
        vehicle = host(folders[model])
        names = [v.name for v in comparable_outputs(vehicle.description)]
        known = {v.name for v in vehicle.description.modelVariables}
        start = {name: value for name, value in START.items() if name in known}
        assert start
        with vehicle.instance():
            vehicle.start(**{name.replace(".", "__"): value for name, value in start.items()})
            rows = []
            for k in range(STEPS):
                vehicle.step(k * STEP, (k + 1) * STEP)
                rows.append([vehicle.get(name) for name in names])
        expected.append(np.array(rows))
        jobs.append({"file": str(fmus[model]), "step": STEP, "steps": STEPS, "start": start,
                     "outputs": names})  # fmt: skip
    for job, fmpys, theirs in zip(jobs, expected, in_master(master, jobs, tmp_path), strict=True):
        apart = difference(theirs, fmpys)
        assert apart.max() < 1e-9, job["outputs"][apart.argmax()]
        assert np.abs(fmpys).max() > 0.04


# -- systems ---------------------------------------------------------------------------------------

SHOWN = {
    "OneDof": ["body_displacement", "suspension_deflection_rate"],
    "QuarterCar": ["body_displacement", "wheel_velocity", "contact_force"],
    "HalfCarRigidTyres": ["pitch_angle", "rear_spring_force"],
    "HalfCar": ["pitch_angle", "front_contact_force", "rear_contact_force"],
}


def on_road(model: str, step: float, steps: int, parameters: dict[str, Any]) -> np.ndarray:
    """A vehicle stepped with samples of its road, in this process."""
    wheelbase = 2.5
    road = Session("Road", {"wheelbase": wheelbase})
    vehicle = Session(model, {**parameters, "road.shape": "input"})
    rows = []
    for k in range(steps):
        for output, name in connections(model).items():
            vehicle.set_input(name, float(road.value(output)))
        vehicle.advance((k + 1) * step)
        road.advance((k + 1) * step)
        rows.append([vehicle.value(name) for name in SHOWN[model]])
    return np.array(rows)


@pytest.fixture(scope="module")
def ssps(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("systems")
    models = ["QuarterCar", "HalfCarRigidTyres"]  # one axle on a wheel, two on the road itself
    build(models, folder, ssp=True)
    return {model: folder / f"{model}.ssp" for model in models}


@pytest.mark.slow
@pytest.mark.parametrize("master", MASTERS)
def test_a_system_runs_as_its_parts_do(master: str, ssps: dict[str, Path], tmp_path: Path) -> None:
    jobs = []
    for model, ssp in ssps.items():
        if master == "libcosimpy":
            zipfile.ZipFile(ssp).extractall(tmp_path / model)
        file = tmp_path / model if master == "libcosimpy" else ssp
        jobs.append({"file": str(file), "step": 1e-3, "steps": 200, "outputs": SHOWN[model]})
    for model, theirs in zip(ssps, in_master(master, jobs, tmp_path), strict=True):
        ours = on_road(model, 1e-3, 200, {})
        assert difference(theirs, ours).max() < 1e-9


@pytest.mark.slow
def test_fmpy_runs_a_system(
    ssps: dict[str, Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    for model, ssp in ssps.items():
        result = simulate_ssp(str(ssp), stop_time=0.2, step_size=1e-3)
        found = np.array([result[f"vehicle.{name}"] for name in SHOWN[model]]).T
        assert difference(found, on_road(model, 1e-3, 200, {})).max() < 1e-9


@pytest.mark.parametrize("model", SHOWN)
def test_the_error_of_a_connected_road_is_of_second_order(model: str) -> None:
    exact = Session(model, {"solver.tolerance": 1e-10})
    exact.advance(0.2)
    truth = np.array([exact.value(name) for name in SHOWN[model]])
    counts = [200, 400, 800, 1600]
    errors = [
        np.abs(on_road(model, 0.2 / n, n, {"solver.tolerance": 1e-10})[-1] - truth)[0]
        for n in counts
    ]
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 1.7
    assert errors[-1] < 1e-3 * abs(truth[0])


def test_what_has_no_road_gets_no_system(tmp_path: Path) -> None:
    assert connections("Road") == {}
    files = build(["Road"], tmp_path, ssp=True)
    assert [file.name for file in files] == ["Road.fmu"]
    assert all(connections(model) for model in MODELS if model in SHOWN)


@pytest.mark.slow
def test_a_systems_own_values_go_where_they_belong(tmp_path: Path, host: Any) -> None:
    given = {"cg_to_rear": 1.5, "sprung_mass": 700.0, "road.height": 0.02, "speed": 10.0}
    build(["HalfCar"], tmp_path, parameters={"HalfCar": given}, ssp=True)
    with zipfile.ZipFile(tmp_path / "HalfCar.ssp") as archive:
        archive.extractall(tmp_path / "ssp")
    starts: dict[str, dict[str, str]] = {}
    for name in ("Road", "HalfCar"):
        description = host(str(tmp_path / "ssp" / "resources" / f"{name}.fmu")).description
        starts[name] = {v.name: v.start for v in description.modelVariables}
    assert starts["Road"]["wheelbase"] == "2.75"
    assert (starts["Road"]["road.height"], starts["Road"]["speed"]) == ("0.02", "10.0")
    assert starts["HalfCar"]["sprung_mass"] == "700.0"
    assert starts["HalfCar"]["road.shape"] == "input"
