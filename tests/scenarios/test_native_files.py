"""Files of native FMUs in scenes and lists: what was chosen when they were packed is known."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import phaseplane
from phaseplane.scenarios.scene.fmus import find_fmu
from phaseplane.scenarios.studies.problems import find_problem
from phaseplane.scenarios.studies.project_solvers import through_fmu
from phaseplane.scenarios.studies.reference import truth
from phaseplane.scenarios.studies.workbench import Workbench
from phaseplane.vehicle_fmus.native import compilers, pack


@pytest.fixture(scope="module")
def car(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compilers, "FLAGS", ("-std=c99", "-O1", "-ffp-contract=off", "-w"))
        patch.setattr(compilers, "has_zig", lambda: False)
        (file,) = pack.build(
            ["QuarterCar"], tmp_path_factory.mktemp("car"),
            parameters={"QuarterCar": {"friction": 30.0}},
        )  # fmt: skip
    return file


def invoked(*arguments: str) -> tuple[int, str, str]:
    done = phaseplane(*arguments)
    return done.exit_code, done.stdout, done.stderr


@pytest.mark.slow
def test_it_is_known_as_a_model_of_the_package(car: Path) -> None:
    found = find_fmu(str(car))
    assert found.is_ours
    assert {"road.shape", "lift_off", "spring.table", "damper.rebound_limit"} <= found.fixed
    assert not {"sprung_mass", "friction"} & found.fixed
    assert found.parameters()["friction"].start == 30.0


@pytest.mark.slow
def test_its_parameters_are_listed_by_when_they_can_be_set(car: Path) -> None:
    status, text, _ = invoked("list", str(car))
    assert status == 0
    chosen, before, during = text.partition("set before a run")
    assert "  road.shape" in chosen
    assert "  lift_off" in chosen
    assert "  sprung_mass" not in chosen
    assert "  sprung_mass" in before + during
    assert "  friction" in during


def test_a_scene_is_refused_another_structure_and_told_what_to_do(car: Path) -> None:
    status, _, why = invoked("run", str(car), "--set", "lift_off=false")
    assert status == 2
    assert "packed for true" in why
    assert "phaseplane build --native --set lift_off=" in why
    assert why.count("\n") == 1
    _, _, why = invoked("run", str(car), "--set", "payload=30")
    assert "payload = 30 kg: this FMU was packed for 0 kg, and" in why
    status, _, why = invoked("run", str(car), "--set", "spring.table=-1:-9,0:0,1:9")
    assert (status, "was packed without one, and" in why) == (2, True)


def test_a_scene_runs_it_and_measures_between_its_rows(car: Path, tmp_path: Path) -> None:
    folder = str(tmp_path / "out")
    status, text, why = invoked("run", str(car), "--set", "duration=0.3 s", "-o", folder)
    assert status == 0, why
    assert "lift-off" in text


def test_its_accuracy_is_measured(car: Path, tmp_path: Path) -> None:
    """The file itself is stepped, with the parameters that it was packed with; a refusal is told."""
    scene = tmp_path / "kerb.toml"
    scene.write_text(f"fmu = '{car}'\nduration = 0.2\nparameters.sprung_mass = 320\n")
    problem = find_problem(str(scene))
    assert (problem.file, problem.parameters["friction"]) == (car, 30.0)
    bench = Workbench(problem, truth(problem))
    run = through_fmu(bench, 1e-8)
    assert np.abs(run() - bench.true).max() < 1e-7 * np.abs(bench.true).max()
    with pytest.raises(
        RuntimeError, match=r"solver\.tolerance: the structure .* does not allow this"
    ):
        through_fmu(bench, 1e-3)()
