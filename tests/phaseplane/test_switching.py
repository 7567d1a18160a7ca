"""Motions of equations that switch."""

from __future__ import annotations

from importlib import import_module
from itertools import count, islice, pairwise
from math import cos, exp, isnan, log, pi, sin, sqrt

import numpy as np
import pytest
from phaseplane.scenarios.simulate.solving import solve
from scipy.integrate import solve_ivp

from phaseplane.constructions import (
    EquationPlane,
    construct_motion,
)
from phaseplane.equations import Formula, Step, motion, steps


@pytest.mark.parametrize(
    "text",
    [
        "x + R*sign(v)", "x + 2*R*sign(v) - R*sign(2*v)", "x - 2*R*sign(-v) - R*sign(v/R)",
        "x + R*sign(v^3)", "x + 2*R*sign(v) - R*sign(2*v^3)",
        "x + R*sign(v*v*v)", "x + 2*R*sign(v) + R*sign(-2*v*v^2)", "x + R*sign(v*exp(x)*v*v/R)",
        "x + 2*R*sign(R*v*exp(x)) - R*sign(exp(x)*v)",
        "x + 2*R*sign(0*v) + R*sign(v)", "x + abs(0*x)*v + R*sign(v)",
    ],
)  # fmt: skip
def test_dry_friction_takes_the_same_from_every_swing_and_then_holds(text):
    """x'' + x + R sign(x') = 0: half circles about -+R, until |x| <= R."""
    friction, start = 0.3, 2.05
    times = np.linspace(0.0, 6.0 * pi, 601).tolist()
    found = motion(Formula(text, {"R": friction}).switching, (start, 0.0), times)
    turns = [start - 2.0 * friction * k for k in range(4)]  # the last is inside the stretch of rest
    for t, x in zip(found.times, found.displacements, strict=True):
        k = min(int(t / pi), 3)
        side = (-1.0) ** k
        moving = side * friction + (turns[k] - friction) * side * cos(t - k * pi)
        assert x == pytest.approx(side * turns[3] if k == 3 else moving, abs=1e-9)
    assert found.switches == pytest.approx([pi, 2.0 * pi, 3.0 * pi], abs=1e-9)
    assert found.velocities[-1] == found.accelerations[-1] == 0.0


def test_a_relay_slides_down_its_line():
    """x'' + sign(x + T x') = 0 slides on x + T x' = 0 where |x'| < T: x = x0 exp(-t/T)."""
    lag = 0.8
    found = motion(
        Formula("sign(x + T*v)", {"T": lag}).switching, (0.4, -0.5), np.linspace(0, 6, 61).tolist()
    )
    for t, x, v, a in list(zip(*found[:4], strict=True))[1:]:
        decay = 0.4 * exp(-t / lag)
        assert (x, v, a) == pytest.approx((decay, -decay / lag, decay / lag**2), abs=1e-9)


def test_a_driven_mass_with_friction_waits_until_the_drive_is_stronger():
    """x'' + R sign(x') = F sin(t): it starts where F sin t = R."""
    found = motion(
        Formula("0.5*sign(v) - sin(t)").switching, (0.0, 0.0), np.linspace(0, 1, 101).tolist()
    )
    begins = pi / 6.0
    for t, x in zip(found.times, found.displacements, strict=True):
        known = 0.0
        if t > begins:  # twice integrated from there
            s = t - begins
            known = cos(begins) * s - (np.sin(t) - np.sin(begins)) - 0.25 * s * s
        assert x == pytest.approx(known, abs=1e-9)
    assert found.switches == pytest.approx([begins], abs=1e-9)


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_a_mass_that_its_base_just_carries_along(amplitude: float):
    """x'' + x + R sign(x' - A sin t) = 0: carried along x + A cos t is constant, here R."""
    friction = 0.3
    found = motion(
        Formula("x + 0.3*sign(v - A*sin(t))", {"A": amplitude}).switching,
        (friction - amplitude, 0.0),
        np.linspace(0.0, 40.0, 401).tolist(),
    )
    assert found.complaint == ""
    expected = [friction - amplitude * cos(t) for t in found.times]
    assert found.displacements == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(
    ("text", "velocity", "expected"),
    [("0.1*x + 0.1*v*abs(v) + 3*sign(v - 0.5*cos(t))", 0.5, lambda t: 0.5 * sin(t)),
     ("0.1*x + 0.2*sign(v) + 3*sign(v - 0.5*cos(t))", 0.5, lambda t: 0.5 * sin(t)),
     ("0.1*x + 2*sign(v - 0.4*cos(t)) + 3*sign(v - 0.5*cos(t))", 0.5, lambda t: 0.5 * sin(t)),
     ("x + 0.2*sign(v) + 3*sign(v - 0.1*(1 - cos(t)))", 0.0, lambda t: 0.1 * (t - sin(t))),
     ("x + 2*sign(v) + sign(v - max(t - 5, 0)) + sign(v - 0.5*(1 - t))", 0.0, lambda t: 0.0),
     ("x + 2*sign(v) - 1.5*sign(v - 0.5*(1 - t)) - 1", 0.0,
      lambda t: 0.5 - 0.5 * cos(max(t - 1.0, 0.0)))],
)  # fmt: skip
def test_a_mass_does_not_rest_where_the_velocity_of_its_base_passes_zero(text, velocity, expected):
    """It is held by its base, with drag or friction that turn with it; or held until its base turns."""
    times = np.linspace(0.0, 4.0, 81).tolist()
    found = motion(Formula(text).switching, (0.0, velocity), times)
    assert found.complaint == ""
    assert found.displacements == pytest.approx([expected(t) for t in times], abs=1e-8)


@pytest.mark.parametrize(
    ("text", "plain"),
    [("sign(sign(x))", "sign(x)"), ("sign(relay(x, 0.1))", "relay(x, 0.1)"),
     ("abs(sign(x))*x", "x"), ("x + 0.3*sign(2*sign(v))", "x + 0.3*sign(v)")],
)  # fmt: skip
def test_signs_of_signs_switch_with_them(text: str, plain: str):
    times = np.linspace(0.0, 20.0, 41).tolist()
    found, known = (motion(Formula(f).switching, (0.5, 0.0), times) for f in (text, plain))
    assert found.displacements == pytest.approx(known.displacements, abs=1e-8)


@pytest.mark.parametrize("text", ["min(x, 2)^1.5", "saturation(x, 1)^0.5", "sqrt(max(x, 2*x))"])
def test_a_root_of_pieces_is_undefined_where_it_is(text: str):
    """Beyond a guard |u| is slightly negative, and its root 0; where u itself is, there is none."""
    formula = Formula(text)
    assert isnan(formula.function(0.0, -0.3, 0.0))
    assert isnan(formula.switching.value(0.0, -0.3, 0.0))
    assert "not a number" in motion(formula.switching, (0.5, -1.0), [0.0, 2.0]).complaint


@pytest.mark.parametrize("text", ["x + 0.2*sign(sqrt(x - 0.5))*v", "x + 2 + sign(log(x - 0.5))"])
@pytest.mark.parametrize(("start", "reached"), [(1.0, True), (0.2, False)])
def test_an_equation_is_undefined_where_the_sign_of_something_undefined_is(
    text: str, start: float, reached: bool
):
    formula = Formula(text)
    assert isnan(formula.switching.value(0.0, 0.2, 0.0))
    found = motion(formula.switching, (start, 0.0), np.linspace(0.0, 3.0, 61))
    assert "not a number" in found.complaint
    assert all(x >= 0.5 for x in found.displacements) == reached
    assert (len(found.times) > 10) == reached
    why = "the construction diverges after" if reached else "initial_force = nan: must be finite$"
    with pytest.raises((ArithmeticError, ValueError), match=why):
        construct_motion(
            EquationPlane(formula.switching, initial_displacement=start), step=0.1, duration=3.0
        )


def test_a_switch_of_time_alone_is_no_part_of_rest():
    """Friction holds x while the drive helps; it starts when the sign of the drive changes, at pi."""
    formula = Formula("sign(x) + R*sign(v) - 0.5*sign(sin(t))", {"R": 0.667})
    found = motion(formula.switching, (1.761, 0.0), [0.0, 3.0, 4.0, 4.5])
    for t, x in zip(found.times, found.displacements, strict=True):
        fallen = 0.5 * (1.5 - 0.667) * max(0.0, t - pi) ** 2
        assert x == pytest.approx(1.761 - fallen, abs=1e-9)


def test_a_drive_that_begins_with_the_motion_moves_it_from_rest():
    """x'' + x + c x' max(1, |x|) = F max(0, sin t): the drive is zero at the start, and grows."""
    text = "0.5*v*max(1, abs(x)) + relay(x + 0.2*v, 0.3) - 0.3*max(0, sin(t))"
    found = motion(Formula(text).switching, (0.0, 0.0), [0.0, 0.5, 1.0])
    known = solve_ivp(
        lambda t, y: (y[1], 0.3 * np.sin(t) - 0.5 * y[1]), (0.0, 1.0), (0.0, 0.0),
        t_eval=[0.0, 0.5, 1.0], rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    assert found.displacements == pytest.approx(known.y[0], abs=1e-9)


def test_a_slide_goes_on_where_it_meets_another_switch():
    """On x + T x' = 0 the motion slides past x' = -0.2, where the relay lets go."""
    lag, speed = 0.3, 0.2
    found = motion(
        Formula("0.767*relay(v, 0.2) + sign(x + T*v)", {"T": lag}).switching, (0.108, 0.0),
        np.linspace(0.0, 3.0, 301).tolist(),
    )  # fmt: skip
    sliding = [(t, x) for t, x, v in zip(*found[:3], strict=True) if -0.95 * speed < v and t > 0.3]
    (first, start) = sliding[0]
    for t, x in sliding:
        assert x == pytest.approx(start * exp(-(t - first) / lag), abs=1e-9)
    assert found.complaint == ""


def test_a_motion_through_the_corner_of_two_switches_goes_on():
    """x' = 0.2 and x = 0 are met together to rounding; nothing holds the motion there."""
    text, start = "R*relay(v, 0.2) + copysign(R, x) + k*x", (0.341, 0.0)
    times = np.linspace(0.0, 8.0, 81).tolist()
    found = motion(Formula(text, {"R": 0.689, "k": 0.795}).switching, start, times)
    late = [abs(v) for t, v in zip(found.times, found.velocities, strict=True) if t > 3.3]
    assert max(late) > 0.1
    # the relay at x' = 0.2 takes energy, the spring with its preload keeps it
    energy = [
        0.5 * v * v + 0.689 * abs(x) + 0.3975 * x * x for x, v in zip(*found[1:3], strict=True)
    ]
    assert all(b <= a + 1e-9 for a, b in pairwise(energy))
    assert energy[-1] == pytest.approx(energy[40], abs=1e-9)


def test_two_relays_come_to_rest_in_finite_time():
    """x'' + sign(x) + R sign(x') = 0: swings shrink by (1 - R)/(1 + R), as their times by its root."""
    friction = 0.5
    shrink = (1.0 - friction) / (1.0 + friction)
    quarter = sqrt(2.0 / (1.0 - friction)) + sqrt(2.0 * shrink / (1.0 + friction))
    rest = quarter / (1.0 - sqrt(shrink))
    found = motion(
        Formula("sign(x) + 0.5*sign(v)").switching, (1.0, 0.0), [0.0, 0.9 * rest, 1.1 * rest]
    )
    assert abs(found.displacements[1]) > 1e-6
    assert found.times[-1] == pytest.approx(1.1 * rest)
    assert abs(found.displacements[2]) < 1e-9


@pytest.mark.parametrize(
    "text",
    ["(x^2 - 1)*v + x", "x + 20*dead_zone(x, 1) + 0.1*v", "x*abs(x) + 0.2*v - 0.3*cos(1.2*t)",
     "saturation(5*x, 1) + 0.1*v*abs(v)"],
)  # fmt: skip
def test_motions_are_those_of_scipy(text):
    formula = Formula(text)
    times = np.linspace(0.0, 15.0, 16)
    found = motion(formula.switching, (1.5, 0.5), times.tolist())
    known = solve_ivp(
        lambda t, y: (y[1], -formula.function(y[1], y[0], t)), (0.0, 15.0), (1.5, 0.5),
        method="DOP853", t_eval=times, rtol=1e-11, atol=1e-13, max_step=2e-2,
    )  # fmt: skip
    assert found.displacements == pytest.approx(known.y[0], abs=3e-8)
    assert found.velocities == pytest.approx(known.y[1], abs=3e-7)


@pytest.mark.parametrize(("length", "time"), [(1e-9, 1.0), (1e6, 1.0), (1.0, 1e-4), (1e-6, 1e4)])
@pytest.mark.parametrize(
    ("text", "start"),
    [("(X^2 - 1)*V + X", (0.5, 0.0)), ("X + 20*dead_zone(X, 1) + 0.1*V", (1.5, 0.0)),
     ("X + 0.3*sign(V) - 0.5*cos(t/T)", (0.5, 0.0))],
)  # fmt: skip
def test_a_motion_does_not_depend_on_the_units(text, start, length, time):
    """With x in units of L and t in units of T: to nine digits, though x is as small as 1e-9."""

    def moved(length: float, time: float) -> list[float]:
        scaled = text.replace("X", "(x/L)").replace("V", "(v*T/L)")
        formula = Formula(f"L/T^2*({scaled})", {"L": length, "T": time})
        x, v = start
        times = [time * s for s in np.linspace(0.0, 12.0, 25).tolist()]
        found = motion(formula.switching, (x * length, v * length / time), times)
        return [displacement / length for displacement in found.displacements]

    assert moved(length, time) == pytest.approx(moved(1.0, 1.0), abs=1e-7)


@pytest.mark.parametrize("start", [5e-324, 1e-310])
def test_a_motion_that_is_too_small_for_ten_digits(start: float) -> None:
    found = motion(Formula("x").switching, (start, 0.0), [0.0, 1.0, 2.0])
    assert len(found.times) == 3
    assert max(map(abs, found.displacements)) <= 1.01 * start


def test_a_slide_that_has_come_to_rest_takes_no_short_steps():
    """On x + T x' = 0 at the origin nothing moves but rounding, whose error is none of the motion."""
    switching = Formula("sign(x + 0.3*v) - 0.3*max(0, sin(2.006*t))").switching
    made = steps(switching, (0.0, 0.0), 0.0, 8.0, longest=0.16)
    assert len(list(islice(made, 500))) < 500


def test_a_motion_that_cannot_go_on_says_until_when():
    found = motion(Formula("-v^2 - 1").switching, (0.0, 0.0), np.linspace(0, 3, 301).tolist())
    assert "grows without bound" in found.complaint
    assert found.times[-1] == pytest.approx(0.5 * pi, abs=0.011)  # x' = tan t


def test_a_motion_lands_on_the_jump_of_an_angle():
    """atan2(x, -1) jumps by 2 pi at x = 0; no energy is lost there."""
    found = motion(Formula("atan2(x, -1)").switching, (1.0, 0.0), np.linspace(0.0, 50.0, 401))
    x, v = np.abs(found.displacements), np.array(found.velocities)
    energy = 0.5 * v**2 + pi * x - x * np.arctan(x) + 0.5 * np.log1p(x**2)
    assert energy == pytest.approx(pi - 0.25 * pi + 0.5 * log(2.0), abs=2e-9)
    assert np.diff(found.switches) == pytest.approx(2.0 * found.switches[0], abs=1e-8)


@pytest.mark.parametrize(("text", "reached"), [("x^3 - v", 13.0), ("x^3 - 0.5*v", 23.0)])
def test_a_motion_that_grows_ever_faster_ends_before_all_its_steps(text, reached):
    """It took all four million, minutes, and then said that no step is short enough."""
    made = count()
    found = motion(
        Formula(text).switching, (-2.0, 0.0), np.linspace(0.0, 50.0 * reached, 501).tolist(),
        lambda _time: next(made) < 300_000,
    )  # fmt: skip
    assert next(made) < 200_000
    assert "more than 4 million steps" in found.complaint
    assert found.times[-1] > reached


@pytest.mark.parametrize("text", ["x - cos(t)", "x - 1e-3*v", "x + x^3 - sin(t)*t"])
def test_a_motion_that_grows_goes_on(text):
    """Its many steps are of one length, or as a power of time."""
    found = motion(Formula(text).switching, (1.0, 0.0), [0.0, 1500.0])
    assert found.complaint == ""


def test_a_motion_at_the_end_of_where_f_is_known_does_not_creep():
    """Steps too short to move x, of which each is made, went on for minutes."""
    made = count()
    found = motion(
        Formula("asin(x)*(1 + 99/x^2)").switching, (1.0, 1.0), [0.0, 1.0],
        lambda _time: next(made) < 300_000,
    )  # fmt: skip
    assert next(made) < 40_000
    assert "the acceleration is not a number there" in found.complaint


def test_a_motion_that_is_held_for_a_while_goes_on():
    """It was given up, as if f ended there, while its damper was still too stiff for it to move."""
    found = motion(Formula("1e7*exp(-20*t)*v + x").switching, (1.0, 1.0), [0.0, 1.0, 10.0])
    assert found.complaint == ""
    exact = solve_ivp(
        lambda t, y: [y[1], -1e7 * exp(-20.0 * t) * y[1] - y[0]], (0.0, 10.0), [1.0, 1.0],
        method="Radau", rtol=1e-9, atol=1e-12,
    )  # fmt: skip
    assert found.displacements[-1] == pytest.approx(exact.y[0, -1], abs=1e-7)


def test_a_motion_of_too_many_steps_says_so(monkeypatch):
    monkeypatch.setattr(import_module("phaseplane.equations.stepping"), "MOST_STEPS", 100)
    assert "steps would be needed" in motion(Formula("x").switching, (1.0, 0.0), [0, 100]).complaint


@pytest.mark.parametrize(
    "text",
    [
        "x + 0.3*sign(v)*abs(v)^1.7", "x + v*sqrt(abs(v))", "x + 0.1*sign(v)*sqrt(abs(v))",
        "x + copysign(0.1*v^2, v)", "copysign(x^2, x)", "max(x, 0)^1.5",
        "x + 0.5*max(x - 0.2, 0)^1.5", "sign(x)*abs(x)^0.5",
    ],
)  # fmt: skip
def test_powers_of_magnitudes_pass_where_these_are_zero(text: str) -> None:
    """Neither do motions stop there, nor is a step refused; against scipy."""
    formula = Formula(text)
    times = np.linspace(0.0, 12.0, 25)
    given = {"equation": text, "displacement_start": 1.0, "velocity_start": 0.0}
    found = solve(given, times)[0]["displacement"]
    reference = solve_ivp(
        lambda t, y: [y[1], -formula.function(y[1], y[0], t)], (0.0, 12.0), [1.0, 0.0], "DOP853",
        times, rtol=1e-9, atol=1e-11, max_step=0.02,
    )  # fmt: skip
    assert np.abs(found - reference.y[0]).max() < 1e-6


def test_a_mass_rests_only_where_a_force_holds_it() -> None:
    switching = Formula("x + 0.1*v").switching
    assert not switching.rests((), 1.0, 0.0)
    dry = Formula("x + 0.3*sign(v)").switching
    assert dry.rests((0,), 0.2, 0.0)
    assert not dry.rests((0,), 0.4, 0.0)


def test_a_row_at_a_switch_is_not_of_a_step_that_is_all_rounding():
    """The step from 0.5 s to the next number had a velocity of differences of its ends."""
    times = np.linspace(0.0, 2.0, 21)
    found = motion(Formula("saturation(0.5, t)").switching, (0.0, 0.0), times.tolist())
    expected = np.where(times < 0.5, -0.5 * times**2, 0.125 - 0.5 * times)
    assert found.velocities == pytest.approx(expected, rel=1e-10, abs=1e-15)


def test_between_its_ends_a_step_is_the_polynomial_of_fifth_degree():
    x = np.polynomial.Polynomial([0.3, -1.0, 0.5, 2.0, -0.7, 0.9])
    v, a = x.deriv(), x.deriv(2)
    step = Step(0.2, 0.7, *((float(x(t)), float(v(t)), float(a(t))) for t in (0.2, 0.7)), ())
    for t in (0.2, 0.33, 0.6, 0.7):
        assert step.at(t) == pytest.approx((x(t), v(t)), rel=1e-13)


@pytest.mark.parametrize("after", [0.7, 0.65])
def test_a_guard_changes_its_sign_through_a_pole_too(after: float):
    # x'' = 1 until then, -1 after it
    system = Formula(f"saturation(1, 1/(t - {after}))").switching
    found = motion(system, (0.0, 0.0), [0.0, after, 1.5])
    assert found.switches == pytest.approx([after], rel=1e-12)
    assert found.velocities == pytest.approx([0.0, after, 2.0 * after - 1.5], rel=1e-9)
    assert not found.complaint


def test_a_guard_changes_its_sign_through_a_pole_of_the_velocity():
    found = motion(Formula("max(5, saturation(tan(v), 3))").switching, (0.0, 0.0), [0.0, 1.5])
    assert not found.complaint
    assert found.velocities == pytest.approx([0.0, -7.5], rel=1e-9)


def test_a_guard_has_a_slope_at_the_edge_of_where_it_is_defined():
    """At t = 0 the play sqrt(t) begins to grow around a mass at rest."""
    found = motion(Formula("backlash(v, sqrt(t))").switching, (0.5, 0.0), [0.0, 1.0])
    assert not found.complaint
    assert found.displacements == [0.5, 0.5]
