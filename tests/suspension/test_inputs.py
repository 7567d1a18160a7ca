"""What a host sets goes on between its samples: second order, jumps as they are given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, pi, sin
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kernels import UNCOMPILED
from phaseplane.suspension import engine
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import variables
from phaseplane.vehicle_fmus.native.kernel_sources import plain_module

SMOOTH = {"solver.tolerance": 1e-10}
STRAIGHT = {"lift_off": False, "damper.rebound_rate": 900.0, "damper.bump_rate": 900.0}
END = 0.4  # s
REFINED = (1, 2, 4, 8)


# -- how one input goes on ----------------------------------------------------------------------------


class Line(NamedTuple):
    """A course as the integrator gets it: a value at a time, and its slope."""

    time: float
    value: float
    slope: float = 0.0

    def at(self, time: float) -> float:
        return self.value + self.slope * (time - self.time)


def road(**samples: Sequence[tuple[float, float]]) -> Any:
    """A run whose inputs, `elevation` and `velocity` of a road, have been set at some times."""
    signals = SimpleNamespace(count=1)
    net = SimpleNamespace(n=1, memory=plain_module("arrays").Memory(), signals=signals)
    integrator = SimpleNamespace(replace_signal=lambda *_: None, net=net)
    run = plain_module("runs.run").Run(integrator, -1.0, 2, [(0, 0, 1)], [], True)
    for time, i, value in sorted(
        (t, ("elevation", "velocity").index(name), x) for name, s in samples.items() for t, x in s
    ):
        run.time = time
        run.set_input(i, value)
    return run


def course(*samples: tuple[float, float]) -> Any:
    return road(elevation=samples)


def carried(run: Any, until: float) -> Line:
    run._find_course(0, until)
    return Line(run.course_time, run.course_value, run.course_slope)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(1e-4, 0.1), st.floats(0.5, 2.0))
def test_a_straight_course_is_carried_on_as_it_is(
    start: float, slope: float, step: float, ratio: float
) -> None:
    times = (0.0, step, step + ratio * step)
    line = carried(course(*((t, start + slope * t) for t in times)), times[-1] + step)
    assert line.at(times[-1]) == pytest.approx(start + slope * times[-1], abs=1e-9)
    assert line.slope == pytest.approx(slope, rel=1e-6, abs=1e-8 / step)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.integers(3, 6))
def test_a_jump_is_no_slope(before: float, after: float, jump: int) -> None:
    samples = [(0.1 * k, before if k < jump else after) for k in range(10)]
    for k in range(10):
        line = carried(course(*samples[: k + 1]), 0.1 * (k + 1))
        assert line == Line(*samples[k])


def test_of_two_slopes_the_smaller_one_counts_and_at_a_turn_none() -> None:
    assert course((0.0, 0.0), (1.0, 3.0), (2.0, 5.0)).inputs.slope(0, 3.0) == 2.0
    assert course((0.0, 0.0), (1.0, -2.0), (2.0, -5.0)).inputs.slope(0, 3.0) == -2.0
    assert course((0.0, 0.0), (1.0, 3.0), (2.0, 2.0)).inputs.slope(0, 3.0) == 0.0
    assert course((0.0, 0.0), (1.0, 3.0)).inputs.slope(0, 2.0) == 0.0


def test_a_later_call_at_the_same_instant_replaces_the_earlier_one() -> None:
    made = course((0.0, 0.0), (1.0, 1.0))
    made.time = 2.0
    made.set_input(0, 17.0)
    made.set_input(0, 2.0)
    assert (made.inputs.samples[0], list(made.inputs.sample_time[:3])) == (3, [0.0, 1.0, 2.0])
    assert list(made.inputs.sample_value[:3]) == [0.0, 1.0, 2.0]
    assert made.inputs.slope(0, 3.0) == 1.0


def test_a_host_that_falls_silent_leaves_the_value_as_it_was_set() -> None:
    made = course((0.0, 0.0), (0.1, 1.0), (0.2, 2.0))
    assert carried(made, 0.3).at(0.3) == pytest.approx(3.0)
    assert carried(made, 0.4).at(0.4) == pytest.approx(4.0)
    assert carried(made, 0.5).at(0.5) == 2.0


def test_a_road_follows_its_velocity_until_it_is_set_again() -> None:
    assert carried(road(elevation=[(1.0, 0.02)], velocity=[(1.0, 0.0)]), 2.0) == Line(1.0, 0.02)
    run = road(elevation=[(1.0, 0.02)], velocity=[(0.5, 0.3)])
    assert carried(run, 2.0) == Line(1.0, 0.02, 0.3)
    run.hand_over(2.0)
    run.time = 9.0
    assert carried(run, 10.0) == Line(1.0, 0.02, 0.3)
    # velocities alone: the mean over the interval
    run.time = 2.0
    run.set_input(1, 0.1)
    alone = carried(run, 3.0)
    assert (alone.value, alone.slope) == (pytest.approx(0.22), 0.1)


def test_a_road_given_by_its_velocity_alone_is_level_until_the_start() -> None:
    session = Session("QuarterCar", {"road.shape": "input"}, start_time=0.5)
    session.set_input("road_velocity", 0.2)
    session.advance(0.5)
    assert session.value("ground_elevation") == 0.0
    session.advance(0.75)
    assert session.value("ground_elevation") == pytest.approx(0.05)


# -- orders ------------------------------------------------------------------------------------------


def wave(t: float) -> float:
    return 1.0 - cos(11.0 * t)


def wave_rate(t: float) -> float:
    return 11.0 * sin(11.0 * t)


def driven(
    model: str,
    parameters: dict[str, object],
    inputs: dict[str, Callable[[float], float]],
    step: float,
) -> list[float]:
    """The first coordinate every 50 ms, with the inputs sampled at the start of every step."""
    session = Session(model, {**SMOOTH, **parameters})
    name = next(
        v.name for v in variables(model)
        if v.causality == "output" and v.name.endswith("displacement")
    )  # fmt: skip
    found = []
    steps = round(END / step)
    for k in range(steps):
        for which, its in inputs.items():
            session.set_input(which, its(k * step))
        session.advance((k + 1) * step)
        if (k + 1) % round(0.05 / step) == 0:
            found.append(float(session.value(name)))
    return found


def order(
    model: str, parameters: dict[str, object], inputs: dict[str, Callable[[float], float]]
) -> float:
    """By which power of the communication step the motion converges."""
    truth = np.array(driven(model, parameters, inputs, 0.0125 / 64))
    errors = [
        float(np.max(np.abs(np.array(driven(model, parameters, inputs, 0.0125 / n)) - truth)))
        for n in REFINED
    ]
    return float(-np.polyfit(np.log(REFINED), np.log(errors), 1)[0])


ROADS = {"OneDof": ("",), "QuarterCar": ("",), "HalfCarRigidTyres": ("front_", "rear_"),
         "HalfCar": ("front_", "rear_")}  # fmt: skip
FORCES = [
    (model, variable.name)
    for model in (*ROADS, "Elastoplastic")
    for variable in variables(model)
    if variable.causality == "input" and variable.name.endswith("force")
]


def straight(model: str) -> dict[str, object]:
    """Parameters without a corner, which would make orders uneven."""
    if model == "Elastoplastic":
        return {"yield_force": 1e3, "force.table": ""}
    found: dict[str, object] = {}
    for prefix in ("front.", "rear.") if "Half" in model else ("",):
        found |= {f"{prefix}damper.{side}_rate": 900.0 for side in ("rebound", "bump")}
    return found | ({"lift_off": False} if model in ("QuarterCar", "HalfCar") else {})


@pytest.mark.parametrize(("model", "name"), FORCES)
def test_a_force_from_outside_is_right_to_second_order(model: str, name: str) -> None:
    still: dict[str, object] = {"road.shape": "flat"} if model in ROADS else {}
    size = 400.0 if model in ROADS else 4.0
    found = order(model, {**straight(model), **still}, {name: lambda t: size * wave(t)})
    assert 1.8 < found < 2.4


@pytest.mark.parametrize("given", ["both", "elevation", "velocity"])
@pytest.mark.parametrize("model", ROADS)
def test_a_road_from_outside_is_right_to_second_order(model: str, given: str) -> None:
    inputs: dict[str, Callable[[float], float]] = {}
    for k, prefix in enumerate(ROADS[model]):
        if given != "velocity":
            inputs[f"{prefix}road_elevation"] = lambda t, k=k: 0.01 * wave(t) + 0.002 * k * t
        if given != "elevation":
            inputs[f"{prefix}road_velocity"] = lambda t, k=k: 0.01 * wave_rate(t) + 0.002 * k
    found = order(model, {**straight(model), "road.shape": "input"}, inputs)
    assert 1.75 < found < 2.4


def test_unequal_steps_and_samples_at_every_third_one_keep_the_order() -> None:
    def last(step: float, every: int) -> float:
        session = Session("QuarterCar", {**SMOOTH, **STRAIGHT, "road.shape": "flat"})
        time, k = 0.0, 0
        while time < END - 1e-12:
            if k % every == 0:
                session.set_input("body_force", 400.0 * wave(time))
            time = min(END, time + step * (0.7 if k % 2 else 1.3))
            session.advance(time)
            k += 1
        return float(session.value("body_displacement"))

    truth = last(END / 8192, 1)
    for every in (1, 3):
        coarse, fine = (abs(last(END / n, every) - truth) for n in (256, 1024))
        assert coarse > 11.0 * fine  # 16 times at second order, 4 times at first


# -- jumps -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("given", [("elevation", "velocity"), ("elevation",)])
@pytest.mark.parametrize("step", [0.01, 0.0025])
def test_a_kerb_at_a_sample_is_that_kerb(step: float, given: tuple[str, ...]) -> None:
    """A velocity set to zero is a velocity: the road stands still before and behind the kerb."""
    kerb = {"road.height": 0.03, "road.start": 0.05, "speed": 1.0}
    inside = Session("QuarterCar", {**SMOOTH, **STRAIGHT, **kerb, "road.shape": "step"})
    outside = Session("QuarterCar", {**SMOOTH, **STRAIGHT, "road.shape": "input"})
    for k in range(round(0.3 / step)):
        values = {"elevation": 0.03 * (k >= round(0.05 / step)), "velocity": 0.0}
        for what in given:
            outside.set_input(f"road_{what}", values[what])
        for session in (inside, outside):
            session.advance((k + 1) * step)
        for name in ("body_displacement", "wheel_displacement"):
            here, there = (float(session.value(name)) for session in (outside, inside))
            assert here == pytest.approx(there, abs=1e-8)


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("height", [0.04, -0.04])
def test_the_shorter_the_steps_the_more_a_kerb_in_flight_is_that_kerb(
    contact: str, height: float
) -> None:
    """It presses as long as the sample before is past: what hangs loose takes its share of that."""
    start = {"contact": contact, "initial.wheel_displacement": 0.03, "initial.wheel_velocity": 1.0}
    kerb = {"road.height": height, "road.start": 0.002, "speed": 1.0, "road.shape": "step"}
    inside = Session("QuarterCar", {**SMOOTH, **start, **kerb})
    inside.advance(0.004)
    errors = []
    for step in (1e-3, 1e-4, 1e-5):
        outside = Session("QuarterCar", {**SMOOTH, **start, "road.shape": "input"})
        for k in range(round(0.004 / step)):
            outside.set_input("road_elevation", height * (k >= round(0.002 / step)))
            outside.set_input("road_velocity", 0.0)
            outside.advance((k + 1) * step)
        here, there = (float(session.value("wheel_velocity")) for session in (outside, inside))
        errors.append(abs(here - there))
    assert errors[2] < max(0.2 * errors[1], 1e-6)
    assert errors[1] < max(0.2 * errors[0], 1e-6)


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_works_of_a_sampled_road_are_right_to_second_order(contact: str) -> None:
    """What the dampers take while the road goes on to the next sample counts, and no lift-off does."""
    parameters = {"contact": contact, "solver.tolerance": 1e-8}
    names = ("supplied_energy", "dissipated_energy", "stored_energy")
    inside = Session("QuarterCar", parameters)
    inside.advance(0.3)
    road = build("QuarterCar", parameters).signals["road"]
    for step, share in ((1e-3, 1e-3), (2.5e-4, 6e-5)):
        outside = Session("QuarterCar", {**parameters, "road.shape": "input"})
        for k in range(round(0.3 / step)):
            elevation, velocity, *_ = road.derivatives(k * step)
            outside.set_input("road_elevation", elevation)
            outside.set_input("road_velocity", velocity)
            outside.advance((k + 1) * step)
        for name in names:
            error = abs(float(outside.value(name)) - float(inside.value(name)))
            assert error < share * float(inside.value("supplied_energy")), (name, step)


def test_a_force_that_jumps_at_a_sample_is_that_force() -> None:
    once, always = (Session("OneDof", {**SMOOTH, "road.shape": "flat"}) for _ in range(2))
    once.advance(0.1)
    once.set_input("body_force", 700.0)
    for k in range(30):
        always.set_input("body_force", 700.0 * (k >= 10))
        always.advance(0.01 * (k + 1))
    once.advance(0.3)
    here, there = (float(session.value("body_displacement")) for session in (always, once))
    assert here == pytest.approx(there, abs=1e-9)
    assert here > 0.01


@pytest.mark.parametrize("kernel", [UNCOMPILED, engine.Integrator])
def test_switches_at_times_given_as_whole_numbers_have_times_that_are_none(kernel: Any) -> None:
    system = build("QuarterCar", {"road.shape": "input"})
    integrator = kernel(system, start=0)
    integrator.set_state([0.0, 0.0], [0.0, 0.0])
    assert type(integrator.time) is float
    integrator.advance(1, stop=True)
    integrator.set_signal(0, [-0.5, 0.0, 0.0, 0.0])
    (time, *_), *_ = integrator.log
    assert (time, type(time)) == (1.0, float)


def test_what_is_set_as_it_was_keeps_the_steps_of_an_internal_road() -> None:
    plain, told = Session("QuarterCar", {}), Session("QuarterCar", {})
    for k in range(50):
        for name in ("body_force", "road_elevation", "road_velocity"):
            told.set_input(name, 0.0)
        for session in (plain, told):
            session.advance(0.004 * (k + 1))
    for name in ("body_displacement", "wheel_velocity", "energy_residual", "step_count"):
        assert plain.value(name) == told.value(name)


@pytest.mark.parametrize("road", ["input", "bump"])
def test_rolling_back_forgets_what_was_set_since(road: str) -> None:
    """Samples are part of the state: what was set beyond a state restored never was."""

    def feed(session: Session, k: int, scale: float) -> None:
        t = 0.005 * k
        session.set_input("body_force", scale * 300.0 * sin(2.0 * pi * 3.0 * t))
        session.set_input("road_elevation", scale * 0.01 * wave(t))
        session.advance(t + 0.005)

    straight_on, back = (Session("QuarterCar", {"road.shape": road}) for _ in range(2))
    for k in range(30):
        feed(straight_on, k, 1.0)
        kept = back.snapshot()
        feed(back, k, -2.0)
        feed(back, k + 1, 5.0)
        back.restore(kept)
        feed(back, k, 1.0)
    for name in ("body_displacement", "wheel_velocity", "contact_force", "energy_residual"):
        assert back.value(name) == straight_on.value(name)


# -- a wheel in the air at the start -----------------------------------------------------------------


@pytest.mark.parametrize("road", ["flat", "input"])
def test_a_start_in_flight_is_told_as_airborne_and_counts_as_no_lift_off(road: str) -> None:
    session = Session("QuarterCar", {"road.shape": road, "initial.wheel_displacement": 0.05})
    assert session.value("airborne") is True
    assert session.value("contact_force") == 0.0
    session.advance(0.01)
    assert session.value("airborne") is True
    assert session.value("airborne_time") == pytest.approx(0.01, abs=1e-12)
    assert session.value("lift_off_count") == 0
    assert session.value("last_lift_off") == -1.0
    session.advance(0.2)
    landed = float(session.value("last_touchdown"))
    assert 0.01 < landed < 0.2
    counted = session.value("lift_off_count")
    if counted == 0:
        assert session.value("airborne_time") == pytest.approx(landed, abs=1e-12)
    assert session.messages[0] == ("event", "wheel in the air at the start")
    assert session.messages[1][1].startswith("touchdown at ")


def test_only_the_axle_that_hangs_in_the_air_is_airborne_at_the_start() -> None:
    session = Session("HalfCar", {"initial.rear_wheel_displacement": 0.06, "road.shape": "flat"})
    assert session.value("rear_airborne") is True
    assert session.value("front_airborne") is False
