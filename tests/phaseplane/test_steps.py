"""Step rules: their geometry, their orders, and how they are drawn."""

from __future__ import annotations

from cmath import exp
from itertools import pairwise
from math import cos, isclose, log2, pi, sin

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from phaseplane.suspension.characteristics import cubic, linear
from scipy.integrate import solve_ivp

from phaseplane.constructions import (
    RULES,
    OneDofPlane,
    construct_motion,
    delta,
    rule_named,
    velocity,
)
from phaseplane.constructions import tangent as tangent_rule
from phaseplane.constructions.geometry import at_height, meet, turned

coordinate = st.floats(-1.0, 1.0)
points = st.builds(complex, coordinate, coordinate)
turns = st.floats(1e-3, 0.3).flatmap(lambda a: st.sampled_from((a, -a)))


def linear_construction(slope: complex, shift: float):
    """Feet on the real axis that depend on the state as they do with a linear damper and spring."""

    def construct(states):
        return tuple(complex((slope * p).real + shift, 0.0) for p in states), {}

    return construct


slopes = st.builds(complex, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@st.composite
def steps(draw):
    """State points of two planes, their feet, turn angles of opposite sense, the construction."""
    states = (draw(points), draw(points))
    construct = linear_construction(draw(slopes), draw(coordinate))
    feet, _ = construct(states)
    assume(all(abs(p - d) > 0.05 for p, d in zip(states, feet, strict=True)))
    turn = draw(turns)
    return states, feet, (turn, -2.0 * turn), construct


@pytest.mark.slow
@given(steps())
def test_tangent_is_perpendicular_to_the_normal_and_as_long_as_the_arc(step):
    states, feet, angles, _ = step
    move = RULES["tangent"].move(*step)
    for p, d, turn, successor in zip(states, feet, angles, move.successors, strict=True):
        normal, way = p - d, successor - p
        assert abs((normal.conjugate() * way).real) < 1e-12
        assert isclose(abs(way), abs(turn) * abs(normal), rel_tol=1e-9)
        assert (normal.conjugate() * way).imag * turn > 0.0


@given(steps())
def test_velocity_gives_the_point_of_the_tangent(step):
    one, other = RULES["tangent"].move(*step), velocity.move(*step)
    assert np.allclose(one.successors, other.successors, rtol=0.0, atol=1e-12)


@given(steps())
def test_mean_normal_goes_along_the_tangent_by_the_mean_length(step):
    states, feet, angles, construct = step
    predicted = RULES["tangent"].move(*step).successors
    new_feet, _ = construct(predicted)
    successors = RULES["mean_normal"].move(*step).successors
    for i, (p, d) in enumerate(zip(states, feet, strict=True)):
        mean = 0.5 * (abs(p - d) + abs(predicted[i] - new_feet[i]))
        assert isclose(abs(successors[i] - p), mean * abs(angles[i]), rel_tol=1e-9)
        assert abs(((p - d).conjugate() * (successors[i] - p)).real) < 1e-12


@given(steps())
def test_osculating_circle_goes_through_both_points_and_is_seen_under_the_turn_angle(step):
    states, feet, angles, construct = step
    move = RULES["osculating_circle"].move(*step)
    predicted = RULES["tangent"].move(*step).successors
    new_feet, _ = construct(predicted)
    for i, (p, d) in enumerate(zip(states, feet, strict=True)):
        successor, centre = move.successors[i], move.helpers["S{n}"][i]
        if successor == predicted[i]:
            continue  # no circle: the tangent stands in
        radius = abs(p - centre)
        assert isclose(abs(successor - centre), radius, rel_tol=1e-9, abs_tol=1e-12)
        # the centre lies on both normals
        assert abs(((p - d).conjugate() * (centre - d)).imag) < 1e-9 * (1.0 + radius)
        normal = predicted[i] - new_feet[i]
        assert abs((normal.conjugate() * (centre - predicted[i])).imag) < 1e-9 * (1.0 + radius)
        # the line of sight is the normal, turned
        sight = (successor - d) * exp(-1j * angles[i])
        assert abs((sight * (p - d).conjugate()).imag) < 1e-9 * (1.0 + abs(sight))


@given(steps())
def test_midpoint_circle_is_seen_from_midway_between_the_feet(step):
    states, feet, angles, construct = step
    move = RULES["midpoint_circle"].move(*step)
    predicted = RULES["tangent"].move(*step).successors
    new_feet, _ = construct(predicted)
    for i, (p, d) in enumerate(zip(states, feet, strict=True)):
        eye, successor = move.helpers["E{n}"][i], move.successors[i]
        assert abs(eye - 0.5 * (d + new_feet[i])) < 1e-12
        sight = (successor - eye) * exp(-1j * angles[i])
        assert abs((sight * (p - eye).conjugate()).imag) < 1e-9 * (1.0 + abs(sight))


@given(steps())
def test_mean_arc_circle_lays_the_mean_arc_off_on_the_circle(step):
    states, feet, angles, construct = step
    move = RULES["mean_arc_circle"].move(*step)
    predicted = RULES["tangent"].move(*step).successors
    new_feet, _ = construct(predicted)
    for i, (p, d) in enumerate(zip(states, feet, strict=True)):
        successor, centre = move.successors[i], move.helpers["S{n}"][i]
        radius = abs(p - centre)
        assume(radius > 1e-6)
        chord = abs(successor - p)
        assert isclose(abs(successor - centre), radius, rel_tol=1e-9)
        arc = 0.5 * (abs(p - d) + abs(predicted[i] - new_feet[i])) * abs(angles[i])
        assume(arc < pi * radius)
        assert isclose(chord, 2.0 * radius * sin(0.5 * arc / radius), rel_tol=1e-6, abs_tol=1e-9)
        way = ((p - d).conjugate() * (successor - p)).imag
        assert way * angles[i] > 0.0  # in the sense of the tangent


@given(steps())
def test_the_mean_is_taken_where_normals_differ_by_more_than_a_tenth(step):
    states, feet, _, construct = step
    plain, mean, chosen = (
        RULES[name].move(*step).successors
        for name in ("tangent", "mean_normal", "auto_mean_normal")
    )
    new_feet, _ = construct(plain)
    for i, (p, d) in enumerate(zip(states, feet, strict=True)):
        change = abs(abs(plain[i] - new_feet[i]) / abs(p - d) - 1.0)
        assume(abs(change - 0.1) > 1e-9)
        assert chosen[i] == (mean[i] if change > 0.1 else plain[i])


@given(steps())
def test_delta_turns_the_state_about_the_mean_foot(step):
    states, feet, angles, construct = step
    middle = tuple(turned(p, d, 0.5 * a) for p, d, a in zip(states, feet, angles, strict=True))
    mean_feet, _ = construct(middle)
    for p, d, a, q in zip(states, mean_feet, angles, delta.move(*step).successors, strict=True):
        assert isclose(abs(q - d), abs(p - d), rel_tol=1e-9, abs_tol=1e-12)
        assert abs(q - d - (p - d) * exp(1j * a)) < 1e-12


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_all_planes_are_predicted_before_any_is_corrected(rule):
    """A repeated construction is asked for all planes at once, at most once in a step."""
    asked = []

    def construct(states):
        asked.append(states)
        return tuple(complex(-0.1 * states[0].imag, 0.0) for _ in states), {}

    states = (1.0 + 0.5j, 0.3 - 0.2j)
    feet, _ = construct(states)
    asked.clear()
    rule.move(states, feet, (-0.1, 0.2), construct)
    assert len(asked) == (0 if rule.repeats is None else 1)
    assert all(p != q for one in asked for p, q in zip(one, states, strict=True))


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_at_rest_on_the_foot_nothing_moves(rule):
    move = rule.move((0.2 + 0j,), (0.2 + 0j,), (-0.1,), lambda p: ((0.2 + 0j,), {}))
    assert move.successors == (0.2 + 0j,)
    assert all(np.isfinite(p) for helper in move.helpers.values() for p in helper)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_normal_as_short_as_rounding_gives_no_direction(rule):
    """Where dry friction gives way the forces are in balance: P is on D."""
    one, other = (
        rule.move((0.2 + 0j,), (complex(0.2 + off),), (-0.1,), lambda p: ((0.25 + 0j,), {}))
        for off in (1e-16, -1e-16)
    )
    assert one.successors == pytest.approx(other.successors, abs=1e-12)


@pytest.mark.parametrize("name", ["osculating_circle", "midpoint_circle"])
def test_parallel_normals_leave_no_circle(name):
    """Where the feet move along with the state the curve is straight."""
    move = RULES[name].move((1j,), (0j,), (-0.1,), lambda p: ((complex(p[0].real, 0.0),), {}))
    (successor,) = move.successors
    assert abs(successor - (0.1 + 1j)) < 1e-3


def test_lines_cross_where_they_do():
    assert meet(0j, 1 + 1j, 2 + 0j, 0 + 2j) == pytest.approx(1 + 1j)
    assert meet(0j, 1 + 0j, 1j, 1 + 1j) is None
    assert at_height(2j, 4 - 2j, 0.0) == pytest.approx(2 + 0j)


# Free vibration: with nothing but the spring the curve is a circle (AP57 eq. 5).


def oscillator() -> OneDofPlane:
    return OneDofPlane(2.0, linear(50.0), linear(0.0), initial_deflection=0.1, initial_rate=0.2)


@pytest.mark.parametrize("name", ["delta", "osculating_circle", "midpoint_circle"])
def test_with_the_spring_alone_the_curve_is_a_circle(name):
    frames = construct_motion(oscillator(), RULES[name], step=0.03, steps=200).frames
    radius = abs(0.1 + 0.04j)
    assert max(abs(abs(frame.points["P'"]) - radius) for frame in frames) < 1e-14
    # and time runs as on a clock: Omega = 5 rad/s, clockwise
    wanted = (0.1 + 0.04j) * exp(-5j * 0.03 * 200)
    assert abs(frames[-1].points["P'"] - wanted) < 1e-13


def test_the_tangent_leaves_the_circle_outwards():
    frames = construct_motion(oscillator(), tangent_rule, step=0.03, steps=50).frames
    grown = abs(frames[-1].points["P'"]) / abs(frames[0].points["P"])
    assert grown == pytest.approx((1.0 + (5 * 0.03) ** 2) ** (50 / 2), rel=1e-12)


# Order: against a tight solution of a smooth nonlinear equation.

MASS, RATE, CUBIC = 1.0, 25.0, 400.0


def damping(rate: float, deflection: float) -> float:
    return (1.5 + 0.8 * rate) * rate * cos(2.0 * deflection)


def nonlinear_oscillator() -> OneDofPlane:
    return OneDofPlane(MASS, cubic(RATE, CUBIC), damping, initial_deflection=0.2, initial_rate=0.3)


@pytest.fixture(scope="module")
def end_of_the_nonlinear_oscillation() -> complex:
    def slope(t, z):
        y, v = z
        return v, -(RATE * y + CUBIC * y**3 + damping(v, y)) / MASS

    y, v = solve_ivp(slope, (0.0, 1.0), (0.2, 0.3), rtol=1e-11, atol=1e-13).y[:, -1]
    return complex(y, v / 5.0)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_converges_with_its_order(rule, end_of_the_nonlinear_oscillation):
    errors = []
    for n in (160, 320, 640):
        last = construct_motion(nonlinear_oscillator(), rule, step=1.0 / n, steps=n).frames[-1]
        errors.append(abs(last.points["P'"] - end_of_the_nonlinear_oscillation))
    orders = [log2(e / f) for e, f in pairwise(errors)]
    assert orders == pytest.approx([rule.order, rule.order], abs=0.12)


def test_rules_are_found_by_name():
    assert rule_named("delta") is delta
    with pytest.raises(ValueError, match=r"'delte' is unknown; rules are tangent, .*delta"):
        rule_named("delte")


@given(points, points, st.floats(-pi, pi))
def test_turning_keeps_the_distance(p, centre, angle):
    q = turned(p, centre, angle)
    assert isclose(abs(q - centre), abs(p - centre), rel_tol=1e-12, abs_tol=1e-15)
    way, seen = p - centre, q - centre
    assert abs(seen.real - (way.real * cos(angle) - way.imag * sin(angle))) < 1e-12
