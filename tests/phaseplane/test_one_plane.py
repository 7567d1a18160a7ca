"""The construction of one degree of freedom: points, readings, auxiliary curves, bad input."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import inf, nan, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import cubic, damper, linear, power
from worked_example import column

from phaseplane.constructions import RULES, OneDofPlane, Start, Window, construct_motion

MASS, RATE = 300.0, 15000.0


def car(**changes) -> OneDofPlane:
    data = {
        "mass": MASS,
        "spring": cubic(RATE, 2.0e6),
        "damper": damper(2000.0, 500.0),
        "road": roads.bump(0.05, 4.0, 10.0),
    }
    return OneDofPlane(**(data | changes))


@given(
    y=st.floats(-0.1, 0.1),
    rate=st.floats(-2.0, 2.0),
    scale=st.floats(0.1, 10.0),
    start=st.floats(0.0, 0.4),
    duration=st.floats(1e-4, 0.02),
)
def test_the_foot_of_the_normal_is_minus_delta(y, rate, scale, start, duration):
    one = car(scale=scale, initial_deflection=y, initial_rate=rate)
    points = one.points("contact", one.initial, Window(start, duration))
    road = one.road
    mean = (road.rate(start + duration) - road.rate(start)) / duration
    phi = rate * (2000.0 if rate > 0.0 else 500.0)
    delta_ = (phi + 2.0e6 * y**3) / RATE + mean * MASS / RATE
    assert points["D"].imag == 0.0
    assert points["D"].real == pytest.approx(-scale * delta_, rel=1e-12, abs=1e-13 * scale)
    assert points["P"] == pytest.approx(scale * complex(y, rate / sqrt(RATE / MASS)))
    assert points["A"].imag == points["P"].imag
    assert points["A*"].real == points["A"].real


def test_free_vibration_keeps_time():
    one = OneDofPlane(MASS, linear(RATE), linear(0.0), initial_deflection=0.03)
    period = 2.0 * pi * sqrt(MASS / RATE)
    last = construct_motion(one, step=period / 40, steps=40).frames[-1]
    assert last.points["P'"] == pytest.approx(0.03 + 0j, abs=1e-14)


def test_the_auxiliary_curve_of_a_damper_alone_is_one_and_bends_at_its_corners():
    one = car(spring=linear(RATE), damper=damper(2000.0, 500.0, 300.0, 0.0, 100.0))
    drawing = construct_motion(one, step=0.01, duration=1.0)
    (curve,) = drawing.curves[:1]
    assert [c.role for c in drawing.curves].count("auxiliary") == 1
    assert curve.label == ""
    omega = sqrt(RATE / MASS)
    for rate in (0.0, 0.15):
        corner = complex(-2000.0 * rate / RATE, rate / omega)
        assert min(abs(z - corner) for z in curve.vertices) < 1e-12
    for frame in drawing:
        a = frame.points["A"]
        chord = min(abs(z - a) for z in curve.vertices)
        assert chord < 0.02 * abs(curve.vertices[-1] - curve.vertices[0])


def test_a_spring_that_bends_gives_a_family_of_curves_through_round_deflections():
    drawing = construct_motion(car(), step=0.01, duration=1.0)
    family = [curve for curve in drawing.curves if curve.role == "auxiliary"]
    assert len(family) > 3
    for curve in family:
        y = float(curve.label.removeprefix("y = ").removesuffix(" cm")) / 100.0
        on_axis = min(curve.vertices, key=lambda z: abs(z.imag))
        assert on_axis.real == pytest.approx(-2.0e6 * y**3 / RATE, abs=1e-12)


def test_the_curves_reach_over_the_motion_in_round_steps():
    for height in (0.01, 0.05, 0.3):
        drawing = construct_motion(car(road=roads.bump(height, 4.0, 10.0)), step=0.01, duration=1.0)
        y = column(drawing, "suspension_deflection")
        joined = [curve.label for curve in drawing.curves if curve.role == "auxiliary"]
        labels = [label for one in joined for label in one.split(" and ")]
        values = [float(t.removeprefix("y = ").removesuffix(" cm")) / 100.0 for t in labels]
        (step,) = {round(b - a, 9) for a, b in pairwise(values)}
        assert f"{step:.0e}"[0] in "125"
        assert f"{step:.3e}"[1:5] == ".000"
        assert y.min() - step < values[0] <= y.min()
        assert y.max() <= values[-1] < y.max() + step
        assert 4 <= len(values) <= 8


@given(y=st.floats(-0.1, 0.1), rate=st.floats(-2.0, 2.0))
def test_between_two_drawn_curves_and_beyond_the_outer_ones_it_is_interpolated(y, rate):
    levels = np.array([-0.03, 0.01, 0.04])
    one = car(auxiliary_levels=tuple(levels), initial_deflection=y, initial_rate=rate)
    phi = rate * (2000.0 if rate > 0.0 else 500.0)
    low = 0 if y < levels[1] else 1
    (a, b), (at_a, at_b) = levels[low : low + 2], 2.0e6 * levels[low : low + 2] ** 3
    bend = at_a + (at_b - at_a) * (y - a) / (b - a)
    found = one.points("contact", one.initial, Window(0.0, 0.01))["A"]
    assert found.real == pytest.approx(-(phi + bend) / RATE, rel=1e-12, abs=1e-14)


def test_the_turn_angle_stands_on_its_arm_and_gives_the_length_of_the_step():
    drawing = construct_motion(car(), step=0.005, duration=0.2)
    turned = 0
    for frame in drawing:
        normal = abs(frame.points["P"] - frame.points["D"])
        vertex, on_arm, on_other = (frame.points[n] for n in ("W", "N", "N'"))
        assert on_arm - vertex == pytest.approx(normal)
        if normal > 1e-9:
            turn = np.angle((on_other - vertex) / (on_arm - vertex))
            assert turn == pytest.approx(0.005 * sqrt(RATE / MASS))
            turned += 1
    assert turned > 30


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": -1.0}, r"mass = -1\.0: must be finite and greater than 0"),
        ({"mass": nan}, "mass = nan"),
        ({"scale": 0.0}, r"scale = 0\.0"),
        ({"initial_deflection": inf}, "initial_deflection = inf"),
        ({"spring": linear(0.0)}, "rate at zero deflection is 0 N/m"),
        ({"damper": lambda rate, y: 5.0 + rate}, "damper has the force 5 N at rest"),
        ({"damper": 3.0}, "damper = 3.0: must be a Characteristic or a function"),
        ({"spring": lambda y: y}, "must be a Characteristic"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        car(**changes)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"step": 0.0, "duration": 1.0}, "step = 0.0 s: must be positive"),
        ({"step": nan, "duration": 1.0}, "step = nan"),
        ({"step": 0.3, "duration": 1.0}, r"would turn the normal .* 2\.12 rad.*0\.2221 s.*try"),
        ({"step": 0.01, "duration": -1.0}, "duration = -1.0 s"),
        ({"step": 0.01, "steps": 0}, "steps = 0"),
        ({"step": 0.01}, "either the duration or the number"),
        ({"step": 0.01, "steps": 1, "duration": 1.0}, "either the duration or the number"),
    ],
)
def test_a_march_that_leads_nowhere_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        construct_motion(car(), **arguments)


def test_a_construction_that_leaves_the_sheet_says_when():
    stiff = car(spring=cubic(RATE, 1e12), initial_deflection=0.1)
    with pytest.raises(ArithmeticError, match=r"diverges after .* s; try a step shorter"):
        construct_motion(stiff, step=0.02, duration=2.0)


def test_a_car_far_off_the_road_is_constructed():
    one, far = (
        construct_motion(
            OneDofPlane(MASS, linear(RATE), linear(500.0), initial_deflection=y),
            step=0.02,
            duration=1.0,
        )
        for y in (0.1, 1e5)
    )
    ends = [drawing.frames[-1].readings["suspension_deflection"] for drawing in (one, far)]
    assert ends[1] == pytest.approx(1e6 * ends[0], rel=1e-9)


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.name)
def test_a_damper_too_steep_for_the_step_is_refused(rule):
    """The points would leap from one side of the axis to the other."""
    step, slope = 1e-3, 2.4e7
    one = car(damper=damper(slope, 378.0), road=roads.constant(), initial_deflection=-0.03)
    why = rf"0\.001 s from 0(\.001)? s on .* by {step * slope / MASS:.0f} times .* step of 1\.[23]e-05 s$"
    with pytest.raises(ArithmeticError, match=why):
        construct_motion(one, rule, step=step, duration=0.1)
    short = construct_motion(one, rule, step=1.2e-5, duration=0.03)
    creeping = column(short, "suspension_deflection")
    assert np.abs(creeping + 0.03).max() < 1e-4


def test_damping_is_followed_up_to_twice_the_velocity_in_a_step():
    moving = car(road=roads.constant(), initial_rate=0.5)
    near, beyond = (replace(moving, damper=linear(k * MASS / 1e-3)) for k in (1.97, 2.13))
    rates = column(construct_motion(near, step=1e-3, duration=0.5), "suspension_deflection_rate")
    assert abs(rates[-1]) < 1e-2
    with pytest.raises(ArithmeticError, match=r"would change the velocity by 2\.13 times"):
        construct_motion(beyond, step=1e-3, duration=0.5)


@pytest.mark.parametrize(
    ("law", "impulse"),
    [(damper(2000.0, 500.0), 5.0),
     (lambda rate, y: 500.0 * (1.0 - 30.0 * y) * rate, 5.75)],  # stiffer the further it is closed
)  # fmt: skip
def test_a_kerb_pushes_through_the_damper_like_a_ramp_that_is_ever_steeper(law, impulse):
    """An upward kerb compresses: it meets the damper's bump rate, whatever the motion before."""
    kerb, mass = roads.step(0.01, 0.0323), 300.0
    one = OneDofPlane(mass, linear(15000.0), law, kerb)
    drawing = construct_motion(one, step=0.001, duration=0.25)
    at = next(f for f in drawing if f.event == "jolt")
    assert at.time == 0.0323
    assert at.readings["suspension_deflection"] == pytest.approx(-0.01)
    assert at.readings["body_displacement"] == pytest.approx(0.0, abs=1e-15)
    assert at.readings["body_velocity"] == pytest.approx(impulse / mass)
    ramp = roads.ramp(0.01, 0.0001, 20.0, 0.0323)
    steep = construct_motion(replace(one, road=ramp), step=0.001, duration=0.25)
    end = [d.frames[-1].readings["body_displacement"] for d in (drawing, steep)]
    assert end[0] == pytest.approx(end[1], abs=3e-7)


def test_a_kerb_under_a_damper_whose_force_grows_faster_than_its_rate_is_refused():
    """The ramp that replaces it would push the harder the steeper it is."""
    kerb, orifice = roads.step(0.01, 0.0323), power(300.0, 1.5)
    with pytest.raises(ValueError, match=r"would push without limit .*; give the road a ramp"):
        construct_motion(car(damper=orifice, road=kerb), step=1e-3, duration=0.05)


@pytest.mark.parametrize(
    ("damper", "road"),
    [
        (power(300.0, 0.5, linear_below=0.01), roads.step(0.01, 0.0323)),
        (power(300.0, 1.5), roads.table([(0.0, 0.0), (0.0323, 0.0), (0.06, 0.005)])),  # a kink
    ],
)
def test_a_jolt_pushes_neither_at_a_kink_nor_through_a_damper_that_is_level_far_out(damper, road):
    drawing = construct_motion(car(damper=damper, road=road), step=1e-3, duration=0.05)
    at = next(f for f in drawing if f.event == "jolt")
    assert at.readings["body_velocity"] == pytest.approx(0.0, abs=1e-5)


def test_a_step_whose_sum_of_times_is_rounded_past_a_kink_of_the_road_meets_it_once():
    start, kink = 0.007824072216581357, 0.025910995829313176
    assert start + (kink - start) > kink
    one = OneDofPlane(MASS, linear(RATE), linear(0.0), roads.ramp(0.02, 0.4, 10.0, kink))
    begin = Start(start, "contact", one.initial)
    _, at = construct_motion(one, step=0.05, steps=1, start=begin).frames
    assert at.time == kink
    assert at.readings["suspension_deflection_rate"] == pytest.approx(-0.5)
