"""Files of native FMUs in scenes and lists: what was chosen when they were packed is known."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import complaint, phaseplane, printed, settings, written
from phaseplane.scenarios.commands.build import build_models
from phaseplane.scenarios.scene.fmus import find_fmu
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate.runner import run
from phaseplane.scenarios.studies.problems import find_problem
from phaseplane.scenarios.studies.project_solvers import through_fmu
from phaseplane.scenarios.studies.reference import truth
from phaseplane.scenarios.studies.workbench import Workbench
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.vehicle_fmus.native import compilers, pack
from phaseplane.vehicle_fmus.reference import accepted_parameters

import phaseplane as phaseplane_package


def packed(folder: Path, parameters: dict[str, Any]) -> Path:
    """A quarter car packed with these parameters, soon compiled."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilers, "FLAGS", ("-std=c99", "-O1", "-ffp-contract=off", "-w"))
        patch.setattr(compilers, "has_zig", lambda: False)
        (file,) = pack.build(["QuarterCar"], folder, parameters={"QuarterCar": parameters})
    return file


@pytest.fixture(scope="module")
def car(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return packed(tmp_path_factory.mktemp("car"), {"friction": 30.0})


def test_a_car_packed_without_the_energy_ledger_runs(tmp_path: Path) -> None:
    """Its entries, which are not a number, were read, and the run ended at its start."""
    file = packed(tmp_path, {"solver.energy": False})
    scene = written(f'fmu = "{file.as_posix()}"\nduration = 0.1\n[show]\noutputs = "all"\n')
    found = run(load_scene(scene))
    assert "kinetic_energy" in found.columns
    assert not [*filter(needs_ledger, found.columns)]
    assert "energy_residual needs the energy ledger" in complaint(
        "run", scene, "--set", "show.measures=['energy_residual']"
    )


@pytest.mark.slow
def test_it_is_known_as_a_model_of_the_package(car: Path) -> None:
    found = find_fmu(str(car))
    assert found.is_ours
    assert {"road.shape", "lift_off", "spring.table", "damper.rebound_limit"} <= found.fixed
    assert not {"sprung_mass", "friction"} & found.fixed
    assert found.parameters()["friction"].start == 30.0


@pytest.mark.slow
def test_its_parameters_are_listed_by_when_they_can_be_set(car: Path) -> None:
    chosen, before, during = printed("list", car).partition("set before a run")
    assert "  road.shape" in chosen
    assert "  lift_off" in chosen
    assert "  sprung_mass" not in chosen
    assert "  sprung_mass" in before + during
    assert "  friction" in during


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("lift_off=false", "packed for true, and|phaseplane build --native --set lift_off="),
        ("payload=30", "payload = 30 kg: this FMU was packed for 0 kg, and"),
        ("spring.table=-1:-9,0:0,1:9", "was packed without one, and"),
    ],
)
def test_a_scene_is_refused_another_structure_and_told_what_to_do(
    car: Path, given: str, words: str
) -> None:
    said = complaint("run", car, "--set", given)
    assert all(part in said for part in words.split("|"))


def test_a_sweep_is_refused_another_structure_before_its_runs(car: Path) -> None:
    scene = written(f'fmu = "{car.as_posix()}"\nduration = 0.1\n')
    sweep = f'scene = "{scene}"\nmeasures = ["step_count"]\n[vary]\npayload = [0, 30]\n'
    said = complaint("sweep --through fmu", written(sweep, "loads.toml"))
    assert "vary.payload: payload = 30 kg: this FMU was packed for 0 kg, and" in said


def test_a_scene_runs_it_and_measures_between_its_rows(car: Path) -> None:
    assert "lift-off" in printed("run", car, *settings("duration=0.3 s"))


def test_its_accuracy_is_measured(car: Path) -> None:
    """The file itself is stepped, with the parameters that it was packed with; a refusal is told."""
    scene = written(f"fmu = '{car}'\nduration = 0.2\nparameters.sprung_mass = 320\n")
    problem = find_problem(scene)
    assert (problem.file, problem.parameters["friction"]) == (car, 30.0)
    bench = Workbench(problem, truth(problem))
    run = through_fmu(bench, 1e-8)
    assert np.abs(run() - bench.true).max() < 1e-7 * np.abs(bench.true).max()
    with pytest.raises(
        RuntimeError, match=r"solver\.tolerance: this FMU was packed for another structure"
    ):
        through_fmu(bench, 1e-3)()


@pytest.mark.slow
def test_build_says_that_an_fmu_of_the_other_kind_is_replaced(car: Path, tmp_path: Path) -> None:
    folder = tmp_path / "both"
    folder.mkdir()
    (folder / "OneDof.fmu").write_bytes(car.read_bytes())
    for wanted in ["an FMU that runs Python has replaced a native FMU", ""]:
        told = phaseplane("build OneDof -o", folder)
        assert told.exit_code == 0
        assert wanted in told.stderr
        assert bool(wanted) == bool(told.stderr)


def test_a_scene_is_packed_with_other_start_values(tmp_path: Path) -> None:
    """What is set for the scene's model is no start value of a model beside it."""
    name = written('fmu = "QuarterCar"\nduration = 1\n[parameters]\nspeed = 12\n', "car.toml")
    packed = []

    def recorded(
        models: list[str], _folder: Path, *, parameters: dict[str, dict[str, object]], **_: object
    ) -> list[Path]:
        packed.extend(accepted_parameters(models, parameters, {}))
        return []

    build_models([name, "OneDof"], tmp_path, recorded, ["speed=50 km/h"])
    speeds = {model: start["speed"] for model, start, _ in packed}
    assert speeds == pytest.approx({"QuarterCar": 50 / 3.6, "OneDof": 50 / 3.6})


@pytest.mark.slow
def test_events_are_those_of_the_file_with_its_start_values(car: Path) -> None:
    measures = ["lift_offs", "touchdowns"]
    run = phaseplane_package.run(car, duration=0.3, measures=measures)
    of_tyre = [event.time for event in run.events if event.element == "tyre"]
    assert of_tyre == sorted([*run.measures["lift_offs"], *run.measures["touchdowns"]])
    plain = phaseplane_package.run("QuarterCar", duration=0.3, measures=measures)
    assert run.measures != plain.measures


@pytest.mark.slow
def test_an_optimum_runs_the_file_with_its_own_start_values(car: Path) -> None:
    """Its friction of 30 N is no default of the model, which would run in this process."""
    written(f'fmu = "{car}"\nduration = 0.3\n', "car.toml")
    name = written('scene = "car.toml"\nminimise = "suspension_travel"\n[vary]\n'
                   "spring.rate = { from = 1e4, to = 2e4 }\n[search]\npopulation = 1\n"
                   "generations = 0\n", "study.toml")  # fmt: skip
    found = phaseplane_package.optimise(name).summary["measures"]["suspension_travel"]
    run = phaseplane_package.run("car.toml", measures=["suspension_travel"])
    assert found["before"] == pytest.approx(run.measures["suspension_travel"], rel=1e-9)
    plain = phaseplane_package.run("QuarterCar", duration=0.3, measures=["suspension_travel"])
    assert found["before"] != pytest.approx(plain.measures["suspension_travel"], rel=1e-6)
