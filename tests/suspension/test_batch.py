"""Many runs at once: the same as one by one, failures beside results, and bad input."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension import models
from phaseplane.suspension.batch import (
    Outcome,
    outputs_at_end,
    outputs_over_time,
    run_many,
    runs,
    series,
)
from phaseplane.suspension.batch.series import Ended, Series
from phaseplane.suspension.characteristics import function
from phaseplane.suspension.declared import SOLVER_PARAMETERS, initial
from phaseplane.suspension.model import Model
from phaseplane.suspension.outputs import SOLVER_OUTPUTS, motion
from phaseplane.suspension.session import Session, SimulationError, simulate
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variable import Value, number, parameter
from phaseplane.suspension.variables import MODELS, ROAD_SHAPES, ParameterError

TIMES = [0.02 * k for k in range(26)]
OUTPUTS = ["body_displacement", "wheel_velocity", "body_acceleration"]
SHAPES = ["flat", "bump", "obstacle", "sine", "step", "ramp", "plank", "sequence", "table"]


def test_failures_are_records_with_their_reason() -> None:
    bad = [
        {},
        {"unsprung_mass": 0.0},
        {"spring.rote": 1.0},
        {"spring.cubic": -1e9, "road.height": 0.3},
        {"solver.method": "exact", "spring.cubic": 1e5},
    ]
    fine, massless, misspelt, diverged, curved = run_many("QuarterCar", bad, TIMES, OUTPUTS)
    assert fine.ok
    assert "unsprung_mass = 0" in massless.failure
    assert "spring.rate" in misspelt.failure
    assert " s, in step " in diverged.failure
    assert 0 < len(diverged.columns["body_displacement"]) < len(TIMES)
    assert "curved" in curved.failure


def test_what_functions_of_a_user_raise_is_a_failure_of_their_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As a system is built, at the start, or in a step; not what a shorter step avoids in another run."""

    def force(x: float) -> float:
        if x < -0.5:
            raise ZeroDivisionError(f"no force at {x:g}")
        return x

    law = function(force, lambda _x: 1.0)

    def system(p: Mapping[str, Value]) -> System:
        mass = {1.0: 1.0, 2.0: 2.0}[number(p, "mass")]
        return System(("x",), ((mass,),), (Element("spring", (1.0,), law),), scales=(1.0,))

    declared = (
        parameter("mass", 1.0, "mass", "kg"), *initial({"x": "the mass"}), *SOLVER_PARAMETERS,
        *motion("x", "the mass"), *SOLVER_OUTPUTS,
    )  # fmt: skip
    monkeypatch.setitem(models.ALL, "Brittle", Model("", declared, system))
    monkeypatch.setitem(MODELS, "Brittle", declared)
    given = [(1.0, 0.4), (2.0, 0.9), (1.0, 0.499999), (4.0, 0.4), (2.0, -0.9), (2.0, 0.4)]
    sets = [{"mass": mass, "initial.x_displacement": x} for mass, x in given]
    times = [0.1 * k for k in range(101)]
    found = run_many("Brittle", sets, times, ["x_displacement"], workers=1)
    assert [one.ok for one in found] == [True, False, True, False, False, True]
    where, _, what = found[1].failure.partition(": ")
    assert re.fullmatch(r"at [23]\.\d* s, in step \d+", where)
    assert what.startswith("ZeroDivisionError: no force at -0.5")
    assert 25 < len(found[1].columns["x_displacement"]) < 32
    assert found[3].failure == "KeyError: 4.0"
    assert found[4].failure == "at 0 s, in step 0: ZeroDivisionError: no force at -0.9"
    session = Session("Brittle", sets[1])
    with pytest.raises(SimulationError) as ended:
        session.advance(times[-1])
    assert (str(ended.value), session.ok) == (found[1].failure, False)
    with pytest.raises(ParameterError, match=r"^ZeroDivisionError: no force at -0\.9$"):
        Session("Brittle", sets[4])
    for k in (0, 2, 5):
        (alone,) = run_many("Brittle", [sets[k]], times, ["x_displacement"])
        same = found[k].columns["x_displacement"] == alone.columns["x_displacement"]
        assert same.all()


@pytest.fixture
def goes(monkeypatch: pytest.MonkeyPatch) -> list[list[Ended]]:
    """The runs that are made in one go, again and again."""
    made: list[list[Ended]] = []
    go = Series.go

    def noted(*given: Any) -> list[Ended]:
        made.append(go(*given))
        return made[-1]

    monkeypatch.setattr(Series, "go", noted)
    return made


def test_each_run_has_its_own_start_and_its_own_contact(goes: list[list[Ended]]) -> None:
    """Several in one go, which the switches of a few end: the log of one has no room for all."""
    cars = [
        {
            "initial.body_displacement": 0.001 * k, "initial.wheel_velocity": 0.1 * (k % 5),
            "road.shape": "sine", "road.height": 0.02 + 0.001 * k, "damper.rebound_limit": 300.0,
        }
        for k in range(45)
    ]  # fmt: skip
    times = [0.02 * k for k in range(16)]
    names, ends = ["body_displacement", "contact_force", "airborne"], outputs_at_end("QuarterCar")
    found = run_many("QuarterCar", cars, times, names, workers=1, at_end=ends)
    assert max(map(len, goes)) > 4
    assert len(goes) > 4  # of two halves
    lifted = 0
    for car, outcome in zip(cars, found, strict=True):
        (single,) = run_many("QuarterCar", [car], times, names, at_end=ends)
        assert told(outcome) == told(single)
        wanted = simulate("QuarterCar", car, times, [*names, *ends])
        assert all(list(outcome.columns[name]) == wanted[name] for name in names)
        assert all(outcome.at_end[name] == wanted[name][-1] for name in ends)
        lifted += outcome.at_end["airborne_time"] > 0.0
    assert 5 < lifted < len(cars)


@pytest.mark.parametrize("end", [0.02, 0.3])
def test_a_start_in_flight_is_told_as_a_single_run_tells_it(end: float) -> None:
    told = ["airborne", "lift_off_count", "last_lift_off", "last_touchdown"]
    cars: list[dict[str, object]] = [
        {"road.shape": "flat", "initial.wheel_displacement": x} for x in (0.05, 0.0, 0.03)
    ]
    times = [0.0, 0.005, 0.01, end]
    for car, run in zip(cars, run_many("QuarterCar", cars, times, told), strict=True):
        for name, values in simulate("QuarterCar", car, times, told).items():
            if name != "time":
                assert list(run.columns[name]) == values, (car, name)


def test_more_runs_than_are_made_in_one_go(goes: list[list[Ended]]) -> None:
    """As many as a go may have and some more, with a run among them that fails."""
    cars: list[dict[str, object]] = [{"speed": 10.0 + 0.1 * k} for k in range(150)]
    cars[70] = {"speed": 10.0, "spring.cubic": -1e9, "road.height": 0.3}
    ends = ["airborne_time", "step_count"]
    found = run_many("QuarterCar", cars, TIMES, ["body_displacement"], workers=1, at_end=ends)
    assert 60 < max(map(len, goes)) < len(cars) // 2
    for car, outcome in zip(cars, found, strict=True):
        (single,) = run_many("QuarterCar", [car], TIMES, ["body_displacement"], at_end=ends)
        assert told(outcome) == told(single)


@pytest.mark.slow
def test_a_pause_for_the_log_comes_when_it_comes_to_the_run_alone() -> None:
    """Fixed steps stop there to look about, and give up a run that takes too many."""

    def car(speed: float, **other: float) -> dict[str, object]:
        return {
            "road.shape": "sine", "road.length": 0.5, "road.height": 0.004, "speed": speed,
            "solver.method": "equilibrium", "solver.step": 1e-3, **other,
        }  # fmt: skip

    first = car(5.9, sprung_mass=300.0)
    for speed in (9.0, 10.0, 10.7, 12.0):
        second = car(speed, sprung_mass=294.0)
        given = "QuarterCar", [0.0, 154.9], ["body_displacement"]
        ends = ["lift_off_count", "step_count"]
        cars = [first, second] * 2  # half of them in one go
        _, behind, *_ = run_many(given[0], cars, *given[1:], workers=1, at_end=ends)
        (single,) = run_many(given[0], [second], *given[1:], workers=1, at_end=ends)
        assert told(behind) == told(single)


@pytest.mark.parametrize("model", ["QuarterCar", "HalfCar"])
@pytest.mark.parametrize("shape", [shape for shape in ROAD_SHAPES if shape != "input"])
def test_runs_over_every_road_are_what_each_is_alone(
    shape: str, model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The road is made for all of them at once, the runs two in one go."""
    monkeypatch.setattr(series, "_MOST_RUNS", 2)
    common = {"road.shape": shape, "road.table": "0:0, 0.2:0.03, 0.5:0", "road.profile_length": 3.0,
              "road.sequence": "bump 0.05 1, gap 0.5, plank 0.03 0.5, pothole 0.02 0.4"}  # fmt: skip
    cars = [
        {
            **common, "speed": 10.0 + 2.0 * k, "road.length": 0.3 + 0.1 * k,
            "road.start": 0.01 * (k + 1), "road.height": 0.03 + 0.01 * k,
            "road.ramp_length": 0.05 + 0.01 * k,
        }
        for k in range(4)
    ]  # fmt: skip
    side = "rear_" * (model == "HalfCar")
    if side:
        cars = [car | {"cg_to_front": 1.1 + 0.1 * k} for k, car in enumerate(cars)]
    outputs = ["ground_elevation", "ground_velocity", "body_displacement", "contact_force"]
    names = [side + name for name in outputs]
    times = [0.003 * k for k in range(80)]
    cars *= 2  # a worker takes half of them at a time
    found = run_many(model, cars, times, names, workers=1)
    for car, outcome in zip(cars, found, strict=True):
        assert outcome.ok
        wanted = simulate(model, car, times, names)
        for name in names:
            assert list(outcome.columns[name]) == wanted[name], name


def test_progress_reaches_one() -> None:
    seen: list[float] = []
    run_many("OneDof", [{}] * 40, TIMES, ["body_displacement"], progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert run_many("OneDof", [], TIMES, ["body_displacement"]) == []


@pytest.mark.parametrize(
    ("model", "times", "outputs", "reason"),
    [
        ("QuarterCart", TIMES, OUTPUTS, "QuarterCar"),
        ("QuarterCar", [], OUTPUTS, "at least one"),
        ("QuarterCar", [0.0, 1.0, 0.5], OUTPUTS, "ascend"),
        ("QuarterCar", TIMES, ["body_displacment"], "body_displacement"),
    ],
)
def test_bad_input_is_refused(
    model: str, times: list[float], outputs: list[str], reason: str
) -> None:
    with pytest.raises(ParameterError, match=reason):
        run_many(model, [{}], times, outputs)


def test_a_batch_without_workers_is_refused() -> None:
    with pytest.raises(ParameterError, match="workers = -3: must be at least 1"):
        run_many("OneDof", [{}], TIMES, ["body_displacement"], workers=-3)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("spring.cubic", [0.0, 1e4, 0.0, 2e4]),
        ("damper.bump_limit", [0.0, 100.0, 200.0, 0.0]),
        ("damper.saturation_force", [0.0, 100.0, 200.0, 300.0]),
        ("road.start", [0.0, 0.01, -0.02, 0.05]),
        ("friction", [0.0, 20.0, -1.0, 30.0]),
        ("speed", ["36 km/h", 10.0, "20 m/s", 15]),
        ("unsprung_mass", [30.0, 0.0, 20.0, float("nan")]),
        ("lift_off", [True, 1, False, 1.0]),
        ("road.table", ["", "0:0, 1:0.02", [1], "0:0, 1:0.02"]),
        ("initial.wheel_velocity", [0.0, 0.1, -0.1, 0.0]),
        ("solver.tolerance", [10.0 ** (-k / 4) for k in range(4, 20)]),
    ],
)
def test_systems_of_several_kinds_are_what_each_is_alone(name: str, values: list[object]) -> None:
    cars = [
        {
            name: value,
            "sprung_mass": 250.0 + 10.0 * k,
            "road.shape": "table" * (name == "road.table") or "bump",
        }
        for k, value in enumerate(values)
    ] * 2  # a worker takes half of them at a time
    outputs = ["body_displacement", "contact_force", "tyre_deflection"]
    together = run_many("QuarterCar", cars, TIMES[:11], outputs, workers=1)
    for car, one in zip(cars, together, strict=True):
        (alone,) = run_many("QuarterCar", [car], TIMES[:11], outputs, workers=1)
        assert told(one) == told(alone)


def test_runs_are_made_when_their_systems_have_too_many_numbers(
    monkeypatch: pytest.MonkeyPatch, goes: list[list[Ended]]
) -> None:
    cars = [{"speed": 10.0 + k} for k in range(9)]
    whole = run_many("QuarterCar", cars, TIMES, OUTPUTS, workers=1)
    assert len(goes) == 2  # a worker takes half of them at a time
    goes.clear()
    monkeypatch.setattr(runs, "_MOST_NUMBERS", 150)
    parts = run_many("QuarterCar", cars, TIMES, OUTPUTS, workers=1)
    assert len(goes) > 4
    assert list(map(told, whole)) == list(map(told, parts))


TEXTS: dict[str, list[object]] = {
    "road.shape": list[object](SHAPES),
    "road.sequence": ["bump 0.05 1, gap 0.5, plank 0.03 0.5", "step 0.01"],
    "road.table": ["0:0, 1:0.05, 2:0", "0:0, 1:0.02"],
    "solver.method": ["extrapolated", "extrapolated", "equilibrium", "tangent"],
    "solver.tolerance": [1e-3, 1e-6],
    "solver.step": [0.0, 0.0, 1e-3],
    "damper.table": ["", "-1:-900, 0:0, 1:2000", "1:2, 3"],
    "damper.deflection_table": ["", "-0.05:2, 0:1, 0.05:2"],
    "spring.table": ["", "-0.1:-2000, 0:0, 0.1:1500"],
    "body_force.table": ["", "0:0, 0.1:200, 0.2:0"],
    "force.table": ["", "0:0, 0.1:5, 0.2:0"],
}


@st.composite
def many(draw: st.DrawFn, model: str) -> list[dict[str, object]]:
    """Sets that differ in a few parameters of any kind, some of them wrong."""
    declared = [v for v in MODELS[model] if v.causality == "parameter"]
    varied = draw(st.lists(st.sampled_from(declared), min_size=1, max_size=5, unique_by=id))
    sets = []
    for _ in range(draw(st.integers(2, 6))):
        car: dict[str, object] = {}
        for variable in varied:
            stem = variable.name.removeprefix("front.").removeprefix("rear.")
            if stem in TEXTS:
                car[variable.name] = draw(st.sampled_from(TEXTS[stem]))
            elif isinstance(variable.start, bool):
                car[variable.name] = draw(st.booleans())
            elif isinstance(variable.start, float):
                size = variable.start or 100.0
                car[variable.name] = size * draw(st.sampled_from([0.0, 0.5, 1.0, 1.7, -1.0]))
        sets.append(car)
    return sets


def alone(model: str, car: dict[str, object], outputs: list[str]) -> tuple[object, ...]:
    """What a batch of one run gives."""
    ends = outputs_at_end(model)
    (outcome,) = run_many(model, [car], TIMES[:6], outputs, at_end=ends, workers=1)
    return told(outcome)


def told(outcome: Outcome) -> tuple[object, ...]:
    columns = {name: [float(x).hex() for x in column] for name, column in outcome.columns.items()}
    return columns, outcome.failure, dict(outcome.at_end)


@pytest.mark.parametrize("model", list(MODELS))
def test_no_run_shows_what_came_before_it(model: str) -> None:
    """Whatever changes from run to run, each is to the bit what it is alone, failures among them."""
    outputs, ends = outputs_over_time(model), outputs_at_end(model)

    @settings(max_examples=25)
    @given(many(model))
    def check(sets: list[dict[str, object]]) -> None:
        sets = sets * 2  # a worker takes half of them at a time
        found = run_many(model, sets, TIMES[:6], outputs, at_end=ends, workers=1)
        for car, outcome in zip(sets, found, strict=True):
            assert told(outcome) == alone(model, car, outputs)

    check()


def test_side_by_side_is_one_after_the_other() -> None:
    """In threads, with runs among them that fail, diverge, or pause for many steps."""
    cars: list[dict[str, object]] = [{"speed": 10.0 + 0.5 * k} for k in range(60)]
    cars[3] = {"unsprung_mass": -1.0}
    cars[5] = {"spring.cubic": -1e9, "road.height": 0.3}
    cars[9] = cars[10] = {"solver.method": "equilibrium", "solver.step": 2e-5}
    cars[20] = {"lift_off": False, "road.shape": "sine"}
    single, threads = (
        run_many("QuarterCar", cars, TIMES, OUTPUTS, workers, at_end=["step_count"])
        for workers in (1, 3)
    )
    assert list(map(told, single)) == list(map(told, threads))
    assert [k for k, outcome in enumerate(single) if not outcome.ok] == [3, 5]
    assert single[9].at_end["step_count"] > 20_000
