"""The reference results packed beside the FMUs: what the FMUs give, and what independent code gives."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.util import read_csv
from phaseplane.suspension.models import FILES
from phaseplane.vehicle_fmus.build import build
from phaseplane.vehicle_fmus.reference import reference_files
from vehicle_reference import solved


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the reference of every model consists of."""
    folder = tmp_path_factory.mktemp("references")
    for model in FILES:
        for name, content in reference_files(model, {}).items():
            (folder / name).write_bytes(content)
    return folder


def options(packed: Path, model: str) -> dict[str, float]:
    lines = (packed / f"{model}_ref.opt").read_text().splitlines()
    return {key: float(value) for key, value in (line.split(",") for line in lines)}


def test_the_fmu_gives_its_reference(model: str, fmus: dict[str, Path], packed: Path) -> None:
    reference = read_csv(str(packed / f"{model}_ref.csv"))
    names = reference.dtype.names[1:]
    given = options(packed, model)
    inputs = packed / f"{model}_in.csv"
    result = simulate_fmu(
        str(fmus[model]), output=names, output_interval=given["StepSize"],
        start_time=given["StartTime"], stop_time=given["StopTime"],
        input=read_csv(str(inputs)) if inputs.exists() else None,
    )  # fmt: skip
    assert result["time"] == pytest.approx(reference["time"], abs=1e-12)
    for name in names:
        peak = np.abs(reference[name]).max()
        assert np.abs(result[name] - reference[name]).max() <= 5 * given["RelTol"] * peak, name
    if inputs.exists():  # the step of the input does something
        last = next(name for name in names if name.endswith("displacement"))
        without = simulate_fmu(str(fmus[model]), output=[last], output_interval=given["StepSize"])
        assert np.abs(without[last] - reference[last]).max() > 0.1 * np.abs(reference[last]).max()


def test_the_reference_is_what_independent_code_gives(packed: Path) -> None:
    reference = read_csv(str(packed / "QuarterCar_ref.csv"))
    independent = solved("ap57_lift_off")
    before = independent.times <= 0.5  # from then on there is a force on the body
    assert independent.times == pytest.approx(reference["time"], abs=1e-12)
    for name in ("body_displacement", "body_velocity", "wheel_displacement", "wheel_velocity"):
        exact = independent.motion[name][before]
        found = reference[name][before]
        assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max(), name


@pytest.mark.slow
def test_what_is_written(tmp_path: Path) -> None:
    files = {f.name for f in build(["QuarterCar", "Road"], tmp_path, references=True)}
    assert files == {
        "QuarterCar.fmu", "QuarterCar_ref.csv", "QuarterCar_in.csv", "QuarterCar_ref.opt",
        "QuarterCar_readme.txt", "Road.fmu", "Road_ref.csv", "Road_ref.opt", "Road_readme.txt",
    }  # fmt: skip
    assert set(options(tmp_path, "Road")) == {"StartTime", "StopTime", "StepSize", "RelTol"}
    assert "tolerance of 1e-12" in (tmp_path / "Road_readme.txt").read_text()


def test_start_values_count(tmp_path: Path) -> None:
    given: dict[str, Any] = {"road.height": 0.02}
    plain, lower = (reference_files("OneDof", start)["OneDof_ref.csv"] for start in ({}, given))
    (tmp_path / "plain.csv").write_bytes(plain)
    (tmp_path / "lower.csv").write_bytes(lower)
    found = [read_csv(str(tmp_path / f"{name}.csv")) for name in ("plain", "lower")]
    heights = [np.abs(result["ground_elevation"]).max() for result in found]
    assert heights == pytest.approx([0.05, 0.02])


def test_without_the_energy_ledger_its_entries_are_left_out() -> None:
    """They were written as nan, with which nothing agrees."""
    text = reference_files("OneDof", {"solver.energy": False})["OneDof_ref.csv"].decode()
    assert "nan" not in text
    assert '"stored_energy"' in text
    assert "dissipated_energy" not in text
