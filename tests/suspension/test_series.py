"""Outputs of runs made in one call against those of runs stepped from instant to instant."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from phaseplane.suspension.batch import outputs_at_end, outputs_over_time, run_many
from phaseplane.suspension.models import build
from phaseplane.suspension.outputs import OfLedger, OfRun
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import MODELS, ParameterError, outputs

TIMES = [0.004 * k for k in range(101)]
STOPS = {
    "bump_stop.gap": 0.02, "bump_stop.stiffness": 3e5, "rebound_stop.gap": 0.02,
    "rebound_stop.stiffness": 3e5, "friction": 60.0, "damper.rebound_limit": 600.0,
    "damper.limit_slope": 200.0, "road.start": 0.01,
}  # fmt: skip
BOTH = {f"{axle}.{name}": x for axle in ("front", "rear") for name, x in STOPS.items()}
CARS: list[tuple[str, Mapping[str, object]]] = [
    ("OneDof", {}),
    ("QuarterCar", {}),
    ("QuarterCar", STOPS),
    ("QuarterCar", {**STOPS, "initial.body_displacement": -0.03, "initial.wheel_velocity": 0.5}),
    ("QuarterCar", {"spring.cubic": 1e6, "initial.body_displacement": 0.02}),
    ("QuarterCar", {"lift_off": False, "solver.tolerance": 1e-3}),
    ("HalfCarRigidTyres", {}),
    ("HalfCar", {"road.height": 0.08}),
    ("HalfCar", {name: x for name, x in BOTH.items() if "road" not in name}),
    ("Elastoplastic", {}),
]


@pytest.mark.parametrize(("model", "given"), CARS)
def test_every_output_is_what_stepping_gives_to_the_bit(
    model: str, given: Mapping[str, object]
) -> None:
    over, ends = outputs_over_time(model), outputs_at_end(model)
    assert len(over) == len(set(over))
    (run,) = run_many(model, [given], TIMES, over, at_end=ends, workers=1)
    assert run.ok
    wanted = simulate(model, given, TIMES, {*over, *ends})
    for name in over:
        assert list(run.columns[name]) == wanted[name], name
    for name in ends:
        assert run.at_end[name] == wanted[name][-1], name
    if "lift_off_count" in ends and not any(n.startswith(("lift", "initial")) for n in given):
        assert run.at_end["lift_off_count"] >= 1


@pytest.mark.parametrize(("model", "given"), CARS)
def test_columns_at_further_times_are_what_stepping_gives_to_the_bit(
    model: str, given: Mapping[str, object]
) -> None:
    further = [0.0013 * k for k in (*range(1, 9), 60, *range(100, 300))]
    names = outputs_over_time(model)
    wanted = simulate(model, given, [0.0, *further], names)
    for run in run_many(model, [given] * 3, TIMES, names, workers=1, closer=lambda _: further):
        assert list(run.closer["time"]) == further
        for name in names:
            assert list(run.closer[name]) == wanted[name][1:], name


@pytest.mark.parametrize("model", list(MODELS))
def test_every_declared_output_says_how_a_system_is_read(model: str) -> None:
    system = build(model, {})
    assert all(v.reading(system, v) for v in outputs(model).values() if v.reading is not None)
    assert {name for name, v in outputs(model).items() if v.reading is None} == set()


@pytest.mark.parametrize("model", ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"])
def test_what_is_left_out_is_of_the_run_or_adds_up(model: str) -> None:
    system, declared = build(model, {}), outputs(model)
    assert set(outputs_over_time(model)) <= set(declared)
    for name in set(declared) - {*outputs_over_time(model)}:
        reading = declared[name].reading(system, declared[name])
        assert isinstance(reading, (OfRun, OfLedger)) or reading.what == "airborne_time"


def test_a_run_that_fails_has_its_columns_up_to_there_and_no_end() -> None:
    bad = {"spring.cubic": -1e9, "road.height": 0.3}
    (run,) = run_many(
        "QuarterCar", [bad], TIMES, ["contact_force", "airborne"], at_end=["step_count"]
    )
    assert 0 < len(run.columns["contact_force"]) == len(run.columns["airborne"]) < len(TIMES)
    assert not run.at_end
    assert not run.ok


def test_what_only_the_end_tells_is_refused_over_time() -> None:
    with pytest.raises(ParameterError, match="a batch of QuarterCar has no output"):
        run_many("QuarterCar", [{}], TIMES, ["step_count"])
    with pytest.raises(ParameterError, match="a batch of QuarterCar has no output"):
        run_many("QuarterCar", [{}], TIMES, [], at_end=["body_displacement"])
