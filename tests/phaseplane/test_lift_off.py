"""Lift-off U and touchdown V in the construction of the quarter car, and kerbs."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import damper, linear
from phaseplane.suspension.session import Session
from worked_example import C2, K2, KGF, STEP, M, ap57, by_scipy, column, m

from phaseplane.constructions import (
    RULES,
    OneDofPlane,
    Strut,
    Window,
    construct_motion,
    delta,
    frames,
    shortcut_flights,
    with_shortcuts,
)
from phaseplane.constructions.switching import _end_of

BY_FORCE = ap57(contact="force")
IN_ITS_DEFLECTION = {
    "tyre_stiffness": 0.0, "tyre_damping": 0.0, "tyre": Strut(linear(C2), linear(K2)),
}  # fmt: skip
"""The same tyre drawn like a nonlinear one, over y2 = x2 - xi."""


@pytest.fixture(scope="module")
def lift_off_and_touchdown() -> tuple[float, float]:
    _, switches = by_scipy(np.array([0.0, 0.15]), lift_off=True)
    lift_off, touchdown = switches
    return lift_off, touchdown


def test_lift_off_and_touchdown_converge(lift_off_and_touchdown):
    lift_off, touchdown = lift_off_and_touchdown
    assert 1e3 * touchdown == pytest.approx(65.6, abs=0.05)
    for step in (STEP, STEP / 2, STEP / 4, STEP / 8):
        found = {f.event: f.time for f in frames(BY_FORCE, step=step, duration=0.15) if f.event}
        assert list(found) == ["lift_off", "touchdown"]
        assert abs(found["lift_off"] - lift_off) < 7.0 * step**2
        assert abs(found["touchdown"] - touchdown) < 7.0 * step**2


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_steps_end_on_u_and_v(rule):
    """There B2Q2 = b x2st (AP57 eq. 28), so that B2 and B0 are one point."""
    car = ap57(plane_scales=(0.7, 3.1), contact="force")
    drawing = construct_motion(car, rule, step=STEP, duration=0.15)
    events = [frame for frame in drawing if frame.event]
    assert [f.event for f in events] == ["lift_off", "touchdown"]
    assert [f.scheme for f in events] == ["flight", "contact"]
    for frame in events:
        states = (frame.points["P1"], frame.points["P2"])
        points = car.points(frame.scheme, states, Window(frame.time))
        assert abs(points["B2"] - points["B0"]) < 1e-13
        length = (points["B2"] - points["Q2"]).real
        assert length == pytest.approx(3.1 * (M + m) * 9.80665 / C2, rel=1e-11)
        # the two constructions agree there: the tyre's force is continuous
        other = car.points("contact", states, Window(frame.time))
        flight = car.points("flight", states, Window(frame.time))
        assert abs(other["D1"] - flight["D1"]) < 1e-12
        assert abs(other["D2"] - flight["D2"]) < 1e-12


def test_steps_follow_one_another_without_a_gap():
    drawing = construct_motion(ap57(), step=STEP, duration=0.15)
    for frame, following in pairwise(drawing.frames):
        assert following.time == pytest.approx(frame.time + frame.duration, abs=1e-15)
        assert following.points["P1"] == frame.points["P1'"]
        assert following.points["P2"] == frame.points["P2'"]
    ends = {round((f.time + f.duration) / STEP, 6) for f in drawing}
    assert ends >= set(range(1, 61))
    assert len(drawing.frames) == 62
    flights = [f for f in drawing if f.scheme == "flight"]
    assert all(f.readings["contact_force"] == 0.0 for f in flights)
    assert column(drawing, "contact_force").min() > -1e-9
    assert all("C2" in f.points for f in drawing if f.scheme == "contact")
    assert all("C2" not in f.points for f in flights)


def test_in_flight_the_centre_of_mass_falls_freely():
    drawing = construct_motion(ap57(), step=STEP / 8, duration=0.15)
    flight = [frame.readings for frame in drawing if frame.scheme == "flight"]
    assert len(flight) > 100
    for read in flight:
        pull = M * read["body_acceleration"] + m * read["wheel_acceleration"]
        assert pull == pytest.approx(-(M + m) * 9.80665, rel=1e-10)


def test_a_wheel_that_hangs_in_the_air_falls_and_bounces():
    """A drop of half a metre: it begins in flight, and every flight ends with a touchdown."""
    car = ap57(
        road=roads.constant(),
        damper=linear(300.0),
        tyre_damping=100.0,
        initial=(0.0, 0.0, 0.5, 0.0),
    )
    drawing = construct_motion(car, step=0.001, duration=1.5)
    assert drawing.frames[0].scheme == "flight"
    events = [f.event for f in drawing if f.event]
    assert events[0] == "touchdown"
    assert len(events) >= 3
    assert all(one != other for one, other in pairwise(events))


def test_a_wheel_that_only_just_loses_the_road_does_not_hang_the_march():
    """Bumps about the height at which lift-off begins, with rules of the first order too."""
    for height in np.linspace(0.004, 0.02, 9):
        for rule in (RULES["tangent"], delta):
            made = list(frames(ap57(road=roads.bump(height, 1.0, 20.0)), rule, step=STEP, steps=40))
            events = [f.event for f in made if f.event]
            assert len(made) == 40 + len(events) or len(made) == 40
            assert all(f.duration > 0.0 for f in made)
            assert made[-1].time + made[-1].duration == pytest.approx(0.1, abs=1e-12)


class Touching(OneDofPlane):
    """Changes its mode at 10 ms, where the margin of the new mode is a rounding error and falls."""

    def margins(self, mode, states, time):
        if mode == "flight":
            return (1e-18 - 1e-3 * (time - 0.01),)
        return (0.01 - time if time < 0.013 else 1.0,)

    def points(self, mode, states, window):
        return super().points("contact", states, window)

    def scheme_of(self, mode):
        return "contact"

    def mode_after(self, mode, limits, states, time):
        return "flight" if mode == "contact" else "contact"

    def event(self, mode, successor):
        return "lift_off" if successor == "flight" else "touchdown"


def test_a_limit_that_is_only_touched_does_not_stop_the_march():
    one = Touching(1.0, linear(100.0), linear(0.0), initial_deflection=0.1)
    made = list(islice(frames(one, step=0.004, duration=0.02), 10))
    ends = [f.time + f.duration for f in made]
    assert ends == pytest.approx([0.004, 0.008, 0.01, 0.012, 0.016, 0.02])
    assert [f.event for f in made] == ["", "", "", "lift_off", "touchdown", ""]


def test_without_lift_off_the_wheel_sticks_to_the_road():
    drawing = construct_motion(ap57(lift_off=False), step=STEP, duration=0.15)
    assert {f.scheme for f in drawing} == {"contact"}
    assert not any(f.event for f in drawing)


def test_a_flight_that_begins_and_ends_within_one_step_is_found():
    """The wheel is off for 2.5 ms; the step from 38.5 ms to 42 ms ends on U and V."""
    car, step = ap57(road=roads.bump(0.0226, 1.0, 20.0)), 3.5e-3
    fine, long = (
        {f.event: f.time for f in frames(car, step=h, duration=0.1) if f.event}
        for h in (1e-4, step)
    )
    assert list(fine) == list(long) == ["lift_off", "touchdown"]
    assert {int(time / step) for time in long.values()} == {11}
    for event, time in long.items():
        assert abs(time - fine[event]) < 5e-4


def test_a_spike_of_the_road_within_one_step_is_found():
    """A dip of 8 ms under steps of 10 ms that begin before and end behind it."""
    car = ap57(
        road=roads.bump(-0.03, 0.16, 20.0, start=0.001), tyre_damping=0.0, damper=damper(0.0, 0.0)
    )
    fine, long = (
        [f.event for f in frames(car, step=step, duration=0.02) if f.event] for step in (1e-4, 1e-2)
    )
    assert fine[:2] == ["lift_off", "touchdown"]
    assert long == fine


# Contact by gap.


def test_touchdown_by_gap_is_where_the_unloaded_tyre_meets_the_road():
    """In the worked example at 71.9526 ms by DOP853; lift-off as by force, where N = 0."""
    for step in (STEP, STEP / 2, STEP / 4, STEP / 8):
        found = {f.event: f.time for f in frames(ap57(), step=step, duration=0.15) if f.event}
        by_force = {f.event: f.time for f in frames(BY_FORCE, step=step, duration=0.15) if f.event}
        assert found["lift_off"] == by_force["lift_off"]
        assert abs(found["touchdown"] - 0.0719526) < 7.0 * step**2


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_at_v_the_tyre_has_its_free_length_and_its_damper_presses_at_once(rule):
    car = ap57()
    drawing = construct_motion(car, rule, step=STEP, duration=0.15)
    lift_off, touchdown = (frame for frame in drawing if frame.event)
    assert abs(lift_off.readings["contact_force"]) < 1e-9
    read = touchdown.readings
    assert read["wheel_displacement"] == pytest.approx(
        car.axles[0].static_tyre_deflection, abs=1e-12
    )
    assert read["contact_force"] == pytest.approx(-100.0 * KGF * read["wheel_velocity"], rel=1e-9)
    assert read["contact_force"] > 1000.0


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_no_force_pulls_and_by_gap_none_acts_across_a_gap(contact):
    car = ap57(contact=contact, road=roads.sine(0.06, 1.5, 20.0))
    across = 0.0
    for frame in construct_motion(car, step=STEP / 4, duration=0.6):
        read, state = frame.readings, frame.points["P2"]
        gap = car.axles[0].gap(state, frame.time)
        assert read["contact_force"] > -1e-9
        if gap > 1e-9:
            across = max(across, read["contact_force"])
    assert (across == 0.0) == (contact == "gap")


@pytest.mark.parametrize("tyre", [{}, IN_ITS_DEFLECTION], ids=["x2", "y2"])
@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("height", [0.004, 0.012, 0.03])
def test_a_kerb_met_in_flight_is_that_of_the_run(contact, height, tyre):
    """By gap the two lower ones, which leave a gap, do nothing; of the highest one the rest acts."""
    up, at = 0.04, 0.01
    car = ap57(
        contact=contact, road=roads.step(height, at), initial=(0.0, 0.0, up, 0.0),
        damper=damper(200.0 * KGF, 50.0 * KGF), **tyre,
    )  # fmt: skip
    drawing = construct_motion(car, step=STEP / 8, duration=0.15)
    before, jolt = next((f, g) for f, g in pairwise(drawing.frames) if g.time == at)
    gap = car.axles[0].gap(before.points["P2'"], 0.0)
    push = (jolt.points["P2"] - before.points["P2'"]).imag
    assert 0.012 < gap < 0.03
    assert (push == 0.0) == (contact == "gap" and height < gap)
    parameters = {
        "contact": contact, "road.shape": "step", "road.height": height, "road.start": at,
        "initial.body_displacement": up, "initial.wheel_displacement": up,
    }  # fmt: skip
    run = Session("QuarterCar", parameters)
    run.advance(0.15)
    ended = drawing.end.readings
    for name in ("body_displacement", "wheel_displacement"):
        assert ended[name] == pytest.approx(run.value(name), abs=1e-4)
    last = [f.time for f in drawing if f.event == "touchdown"]
    if last:
        assert last[-1] == pytest.approx(run.value("last_touchdown"), abs=2e-5)


def test_an_unknown_rule_of_contact_is_refused():
    with pytest.raises(ValueError, match="contact = 'touch': must be one of gap, force"):
        ap57(contact="touch")


# AP57's shortcut for touchdown.


def test_the_shortcut_ends_the_flight_later():
    """Where x2 = x2st: in the worked example at 71.9526 ms by DOP853; V itself is at 65.6 ms."""
    for step, tolerance in ((STEP, 2e-5), (STEP / 8, 1e-6)):
        drawing = construct_motion(BY_FORCE, step=step, duration=0.15)
        (flight,) = shortcut_flights(BY_FORCE, drawing.frames, step=step)
        last = flight[-1]
        assert last.time + last.duration == pytest.approx(0.0719526, abs=tolerance)
        height = ap57().axles[0].wheel.displacement(last.points["P2'"])
        assert height == pytest.approx(ap57().axles[0].static_tyre_deflection, abs=1e-12)
        touchdown = next(f.time for f in drawing if f.event == "touchdown")
        assert touchdown < last.time


def test_the_shortcut_is_drawn_beside_the_march_and_changes_nothing():
    car = BY_FORCE
    drawing = construct_motion(car, step=STEP, duration=0.15)
    drawn = with_shortcuts(drawing, car)
    assert drawn.frames == drawing.frames
    curves = drawn.curves[len(drawing.curves) :]
    assert [curve.role for curve in curves] == ["shortcut", "shortcut"]
    lift_off = next(f for f in drawing if f.event == "lift_off")
    assert curves[0].vertices[0] == lift_off.points["P1"]
    assert curves[1].vertices[-1].real == pytest.approx(
        car.planes[1].displacement.at(car.axles[0].static_tyre_deflection).real
    )
    for other in (OneDofPlane(1.0, linear(1.0), linear(0.0)), ap57(friction=600.0)):
        with pytest.raises(ValueError, match="linear tyres and without dry friction"):
            with_shortcuts(drawing, other)


# Kerbs.


def test_a_kerb_pushes_the_wheel_through_the_damper_of_the_tyre():
    """P2 jumps by k2 h / (m Omega2), P1 against it; as a ramp does that is ever steeper."""
    height = 0.01
    car = ap57(road=roads.step(height, 0.0323))
    drawing = construct_motion(car, step=STEP / 4, duration=0.15)
    before, at = next((f, g) for f, g in pairwise(drawing.frames) if g.event == "jolt")
    push = 100.0 * KGF * height / m
    for plane, sense in zip(car.planes, (-1.0, 1.0), strict=True):
        jump = at.points[plane.state] - before.points[plane.state + "'"]
        bar = sense * push / plane.angular_frequency * plane.scaled_velocity.scale
        assert jump == pytest.approx(1j * bar, abs=1e-12)
    steep = construct_motion(
        ap57(road=roads.ramp(height, 0.002, 20.0, 0.0323)), step=STEP / 16, duration=0.15
    )
    end, wanted = (d.frames[-1].readings for d in (drawing, steep))
    for name in ("body_displacement", "wheel_displacement"):
        assert end[name] == pytest.approx(wanted[name], abs=5e-5)


def test_down_a_kerb_the_tyre_does_not_pull():
    car = ap57(road=roads.step(-0.02, 0.02))
    drawing = construct_motion(car, step=STEP, duration=0.1)
    before, at = next((f, g) for f, g in pairwise(drawing.frames) if g.time == 0.02)
    assert at.points["P2"] == before.points["P2'"]
    assert at.event == "lift_off" or at.readings["contact_force"] > 0.0
    without = replace(car, lift_off=False)
    jumped = next(f for f in construct_motion(without, step=STEP, duration=0.1) if f.time == 0.02)
    assert jumped.readings["wheel_velocity"] == pytest.approx(-100.0 * KGF * 0.02 / m)


def test_a_dip_between_two_looks_is_found():
    """A margin that is negative for 2 % of the window, between the looks at its quarters."""

    def left(part: float) -> float:
        return (part - 0.37) ** 2 - 1e-4

    course = [left(part) for part in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert min(course) > 0.0
    assert _end_of(course, left, 1.0, fresh=False) == pytest.approx(0.36, abs=1e-12)
    touched = [(part - 0.37) ** 2 + 1e-4 for part in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert _end_of(touched, lambda part: (part - 0.37) ** 2 + 1e-4, 1.0, fresh=False) is None
