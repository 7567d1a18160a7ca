"""A random road is as long as the run, in a scene and in a sweep; what ends before it is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import written
from phaseplane.scenarios.commands.build import build_models
from phaseplane.scenarios.results.report import report
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate.runner import run
from phaseplane.scenarios.sweeps.plan import load_plan
from phaseplane.scenarios.sweeps.report import format_sweep, summary_of, table_of
from phaseplane.scenarios.sweeps.running import sweep
from phaseplane.suspension.parts import road_from
from phaseplane.suspension.roads.extent import LENGTH, LONGEST
from small_sweep import sweep_file

SCENE = """
fmu = "QuarterCar"
duration = "20 s"
[parameters]
road.shape = "random"
speed = "80 km/h"
[show]
outputs = ["ground_elevation"]
output_interval = "100 ms"
measures = ["rms.ground_elevation"]
"""
SWEEP = """
scene = "car.toml"
measures = ["rms.ground_elevation"]
[vary]
speed = ["40 km/h", "80 km/h"]
"""


@pytest.fixture
def car() -> str:
    return written(SCENE, "car.toml")


@pytest.mark.slow
def test_a_random_road_is_as_long_as_the_run(car: str) -> None:
    scene = load_scene(car)
    assert scene.start_values[LENGTH] == scene.all_parameters[LENGTH] == 465.0
    # 444 m, and 20 m over which it fades out
    results = run(scene)
    assert results.summary["remarks"] == []
    assert abs(results.columns["ground_elevation"][-10:]).min() > 0.0
    assert results.summary["parameters"][LENGTH] == 465.0


@pytest.mark.parametrize(
    ("override", "length"),
    [("duration=5 s", 200.0), (f"{LENGTH}=150 m", 150.0)],
)
def test_no_shorter_than_the_default_and_as_named(car: str, override: str, length: float) -> None:
    overrides = [override, "show.outputs=[]", "show.measures=[]"]
    assert load_scene(car, overrides).all_parameters[LENGTH] == length


def test_other_roads_have_no_length_to_fit(car: str) -> None:
    assert LENGTH not in load_scene(car, ["road.shape=bump"]).start_values


def test_a_road_that_ends_is_said_in_report_and_summary(car: str) -> None:
    summary = run(load_scene(car, [f"{LENGTH}=200 m"])).summary
    said = "road ends at 9 s of 20 s (fading out from 8.1 s); it is level afterwards"
    assert summary["remarks"] == [said]
    told = report({**summary, "drawn": None, "problems": [], "files": []}, Path("out"))
    assert f"note             {said}" in told
    assert "200 m long with a 20 m fade at both ends" in told


@pytest.mark.slow
def test_all_runs_of_a_sweep_go_over_one_road_that_is_long_enough(car: str, tmp_path: Path) -> None:
    plan = load_plan(sweep_file(SWEEP))
    assert plan.road_length == 465.0
    assert plan.road_remarks() == []
    slow, fast = (plan.scene_of(point).all_parameters for point in plan.points)
    assert slow[LENGTH] == fast[LENGTH] == 465.0
    a, b = (road_from(parameters) for parameters in (slow, fast))
    assert a.value(6.0) == pytest.approx(b.value(3.0), rel=1e-12)
    # the process is given the same road
    alone = run(plan.scene_of(plan.points[1])).summary["measures"]["rms.ground_elevation"]["value"]
    rows, _ = sweep(plan, tmp_path / "journal", workers=1)
    assert rows[1].values == (pytest.approx(alone, rel=1e-9),)


@pytest.mark.parametrize(
    ("shape", "varied", "length"),
    [
        ("random", 'duration = ["1 s", "30 s"]', 687.0),
        pytest.param("random", "duration = [1, 1e308]", LONGEST, marks=pytest.mark.slow),
        ("bump", 'road.shape = ["bump", "random"]', 465.0),
        ("bump", 'speed = ["40 km/h", "80 km/h"]', None),
    ],
)
def test_a_sweep_over_other_keys_counts_them(shape: str, varied: str, length: float | None) -> None:
    written(SCENE.replace("random", shape), "car.toml")
    text = SWEEP.replace('speed = ["40 km/h", "80 km/h"]', varied)
    assert load_plan(sweep_file(text)).road_length == length


def test_a_sweep_says_how_many_roads_end(car: str, tmp_path: Path) -> None:
    written(SCENE.replace("[show]", 'road.profile_length = "300 m"\n[show]'), "car.toml")
    plan = load_plan(sweep_file(SWEEP))
    said = "the road ends before the run in 1 of 2 runs, at the earliest at 13.5 s of 20 s (run 1)"
    assert plan.road_remarks() == [said]
    rows, told = sweep(plan, tmp_path / "journal", workers=1)
    summary = {**summary_of(plan, rows, told), "files": [], "problems": []}
    assert summary["remarks"] == [said]
    assert said in format_sweep(plan, table_of(plan, rows), summary, tmp_path)


@pytest.mark.slow
def test_the_fmu_of_a_scene_has_the_road_of_its_run(car: str) -> None:
    (path, *_) = build_models([car], Path("fmus"))
    packed, scene = load_scene(str(path)), load_scene(car)
    assert packed.all_parameters[LENGTH] == scene.all_parameters[LENGTH] > 200.0
