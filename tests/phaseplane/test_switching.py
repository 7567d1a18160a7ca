"""Equations that switch: their pieces, their motion, their construction and their portraits."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise
from math import acos, cos, exp, isnan, nan, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from phaseplane.scenarios.simulate.solving import solve
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import damper, linear
from phaseplane.suspension.models import build
from scipy.integrate import solve_ivp

from phaseplane.constructions import (
    RULES,
    ElastoplasticPlane,
    EquationPlane,
    OneDofPlane,
    construct_motion,
    family,
    rule_named,
)
from phaseplane.equations import Formula, motion, steps
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    compute_portrait,
    equilibria,
    followed,
    limit_cycles,
    of_coordinate,
)
from phaseplane.portrait.returns import turns

number = st.floats(-3.0, 3.0)
WINDOW = Window(-4.0, 4.0, -4.0, 4.0)


def portrayed(text: str, **parameters: float) -> PhaseSystem:
    formula = Formula(text, parameters)
    return PhaseSystem(
        formula.function, period=formula.period or 0.0, on_arrays=formula.on_arrays,
        switching=formula.switching,
    )  # fmt: skip


@given(number, number, st.floats(0.0, 3.0))
def test_pieces_are_what_they_are_called(x, v, d):
    def value(text: str) -> float:
        return Formula(text, {"d": d}).function(v, x, 0.0)

    sign = (x > 0) - (x < 0)
    assert value("sign(x)") == sign
    assert value("relay(x, d)") == pytest.approx(sign if abs(x) > d else 0.5 * sign * (abs(x) == d))
    assert value("saturation(x, d)") == pytest.approx(min(max(x, -d), d), abs=1e-15)
    assert value("dead_zone(x, d)") == pytest.approx(sign * max(abs(x) - d, 0.0), abs=1e-15)
    assert value("backlash(x, 2*d)") == pytest.approx(value("dead_zone(x, d)"), abs=1e-15)


@given(
    st.sampled_from([
        "relay(x, 0.5)*v + saturation(v, 1)", "max(x, v, 0.1) - min(x, 2*v)", "abs(x)*abs(v)",
        "dead_zone(x - abs(v), 0.3)", "copysign(x, v) + sign(sign(x) + 0.5*v)", "backlash(x, 1)^3",
    ]),
    number, number,
)  # fmt: skip
def test_pieces_by_their_signs_are_the_pieces(text, x, v):
    assume(v != 0.0)  # there copysign goes by the sign of zero
    formula = Formula(text)
    assert formula.switching.value(v, x, 0.0) == pytest.approx(
        formula.function(v, x, 0.0), rel=1e-12, abs=1e-12
    )
    assert formula.on_arrays(np.array([v]), np.array([x]), np.array([0.0])) == pytest.approx(
        formula.function(v, x, 0.0), rel=1e-12, abs=1e-12
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x + mu*v", "'mu' is not known.*give its value in .parameters., such as mu = 1.0"),
        ("relay(x, 1, 2)", "relay takes 1 or 2 values, not 3"),
        ("saturation(x)", "saturation takes 2 values, not 1"),
        ("max(x)", "max takes at least 2 values, not 1"),
        ("sin()", "sin takes 1 value, not 0"),
        ("x'' + x = 0", "not a formula; write f of x'' . f = 0 alone, with v for x'"),
        ("ẋ + x", "did you mean 'v'?"),
        ("x if x > 0 else 0", "write cases by sign, abs, max"),
        ("1,5*x", "write numbers with a point"),
        ("x² + v", "write powers with"),
        ("v*|v| + x", "write abs.x. for"),
        ("sin x", "write arguments in brackets"),
        ("lambda*x", "lambda is reserved: write λ"),
        ("ln(x + 2)", "did you mean 'log'?"),
        ("heaviside(x)", r"did you mean '0.5\*\(1 \+ sign"),
        ("e^x", r"did you mean 'exp\(1\)'.*Otherwise give its value"),
    ],
)
def test_what_is_wrong_with_a_formula_is_said(text, message):
    with pytest.raises(ValueError, match=message):
        Formula(text)


def test_a_parameter_cannot_be_called_like_what_a_formula_knows():
    for name in ("v", "t", "sin", "pi", "2x", "a b"):
        with pytest.raises(ValueError, match="cannot name a parameter"):
            Formula("x", {name: 1.0})


@pytest.mark.parametrize(
    "text",
    [
        "x + R*sign(v)", "x + 2*R*sign(v) - R*sign(2*v)", "x - 2*R*sign(-v) - R*sign(v/R)",
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


def test_a_driven_mass_with_friction_breaks_loose_in_its_construction():
    """x'' + x + R sign(x') = F cos(t) from x = 0.5: it waits until 0.5 - F cos(t) = R, and no longer."""
    switching = Formula("x + 0.3*sign(v) - 0.5*cos(t)").switching
    drawing = construct_motion(
        EquationPlane(switching, initial_displacement=0.5), step=0.02, duration=6.0
    )
    first = next(frame for frame in drawing if frame.scheme == "contact")
    assert first.time == pytest.approx(acos(0.4), abs=1e-9)
    known = motion(switching, (0.5, 0.0), drawing.frames.times)
    found = [frame.readings["displacement"] for frame in drawing]
    assert found == pytest.approx(known.displacements, abs=2e-4)


def test_a_construction_of_rest_has_one_step():
    resting = EquationPlane(Formula("x + 0.3*sign(v)").switching, initial_displacement=0.2)
    drawing = construct_motion(resting, step=0.1, duration=2.0)
    (frame,) = drawing
    assert frame.scheme == "rest"
    assert frame.points["P'"] == frame.points["P"]
    moving = replace(resting, initial_displacement=1.0)
    sheet = family(moving, [(0.2, 0.0)], step=0.1, duration=2.0)
    assert [curve.label for curve in sheet.curves if curve.role == "trail"] == ["(0.2, 0)"]


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


@pytest.mark.parametrize(
    "text", ["dead_zone(x, -1)", "saturation(x, -2)", "relay(x, -d)", "backlash(x, d - 1)"]
)
def test_negative_widths_are_refused(text: str):
    with pytest.raises(
        ValueError, match=r"the second value of \w+ is -[\d.]+; it must be at least 0"
    ):
        Formula(text, {"d": 0.1})
    assert Formula(text.replace("-", "+"), {"d": 0.1}).names <= {"d"}


@pytest.mark.parametrize("width", ["10^400", "exp(1000)", "d/0"])
def test_widths_beyond_all_numbers_are_refused(width: str):
    with pytest.raises(ValueError, match=r"value of saturation is (inf|nan); it must be .* finite"):
        Formula(f"saturation(x, {width})", {"d": 0.1})


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


def test_a_slide_that_has_come_to_rest_takes_no_short_steps():
    """On x + T x' = 0 at the origin nothing moves but rounding, whose error is none of the motion."""
    switching = Formula("sign(x + 0.3*v) - 0.3*max(0, sin(2.006*t))").switching
    made = steps(switching, (0.0, 0.0), 0.0, 8.0, longest=0.16)
    assert len(list(islice(made, 500))) < 500


def test_a_motion_that_cannot_go_on_says_until_when():
    found = motion(Formula("-v^2 - 1").switching, (0.0, 0.0), np.linspace(0, 3, 301).tolist())
    assert "grows without bound" in found.complaint
    assert found.times[-1] == pytest.approx(0.5 * pi, abs=0.011)  # x' = tan t


# Construction.


def test_the_construction_of_dry_friction_is_exact_and_ends_its_steps_on_the_switch():
    """Every step turns P about -+R, where the auxiliary curve jumps from -R to R."""
    friction = 0.3
    one = EquationPlane(
        Formula("x + R*sign(v)", {"R": friction}).switching, initial_displacement=2.05
    )
    drawing = construct_motion(one, rule_named("delta"), step=0.21, duration=20.0)
    assert drawing.end is not None
    assert drawing.end.time == pytest.approx(3.0 * pi)
    assert drawing.end.event == drawing.end.scheme == "rest"
    assert drawing.end.readings["displacement"] == pytest.approx(0.25 * -1.0, abs=1e-9)
    for frame in drawing:
        foot = frame.points["D"].real / one.scale
        assert abs(foot) == pytest.approx(friction, abs=1e-12)
        assert foot * (frame.readings["velocity"] or -1.0 * frame.points["P"].real) < 0.0
    (curve,) = [c for c in drawing.curves if c.role == "auxiliary"]
    on_axis = [z.real / one.scale for z in curve.vertices if abs(z.imag) < 1e-6 * one.scale]
    assert (min(on_axis), max(on_axis)) == pytest.approx((-friction, friction))
    aside = {round(z.real / one.scale, 9) for z in curve.vertices if abs(z.imag) > 1e-6 * one.scale}
    assert aside == {-friction, friction}  # upright but for the jump: nothing slanted


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("sign(x + 0.3*v)", 2.0),
        ("x + 0.3*sign(v) + 0.5*cos(1.1*t)", 2.0),
        ("x + 3*dead_zone(x, 0.5)", 2.0),
        # held at a velocity that is no rest; one switch passes while another holds
        ("0.3*x + sin(x) + 3*relay(v, 0.2)", 2.0),
        ("0.6*sin(x) + 0.3*sign(v + 0.3*x) - 0.4*max(sin(3*t), 0)", -0.1),
    ],
)
def test_the_construction_keeps_its_order_through_switches(text, start):
    formula = Formula(text)
    one = EquationPlane(formula.switching, initial_displacement=start)
    errors = []
    for step in (0.1, 0.05, 0.025):
        drawing = construct_motion(one, rule_named("delta"), step=step, duration=6.0)
        assert drawing.instants[-1].time == 6.0
        known = motion(formula.switching, (start, 0.0), [f.time for f in drawing])
        errors.append(
            max(abs(f.readings["displacement"] - x)
                for f, x in zip(drawing, known.displacements, strict=True))
        )  # fmt: skip
    assert errors[0] / errors[2] > 11.0
    assert errors[2] < 2e-3


@pytest.mark.parametrize("at", [0.7, 1.0, 1.05])
@pytest.mark.parametrize("step", [0.1, 0.05])
def test_a_force_that_switches_at_the_end_of_a_step_does_so_there(at, step):
    """The steps of a circle are exact; and the mass rests until then."""
    formula = Formula("x + 0.3*sign(v) - 0.5*sign(t - t_on) - 0.5", {"t_on": at})
    drawing = construct_motion(EquationPlane(formula.switching), step=step, duration=3.0)
    expected = [0.7 * (1.0 - cos(max(f.time - at, 0.0))) for f in drawing]
    assert [f.readings["displacement"] for f in drawing] == pytest.approx(expected, abs=1e-9)


def test_a_car_with_dry_friction_sticks_and_slips_in_its_plane():
    """The body stays on the axle until the road's acceleration overcomes the friction."""
    one = OneDofPlane(
        mass=100.0, spring=linear(1e4), damper=linear(0.0), friction=30.0,
        road=roads.sine(0.01, 2.0, 2.0),
    )  # fmt: skip
    drawing = construct_motion(one, rule_named("delta"), step=2e-3, duration=1.0)
    at_rest = [f for f in drawing if f.scheme == "rest"]
    assert at_rest
    for frame in at_rest:
        assert frame.points["D"] == frame.points["Q"]
        assert frame.readings["suspension_deflection_rate"] == pytest.approx(0.0, abs=1e-12)
        balance = 100.0 * one.road.derivatives(frame.time)[2]
        held = balance + 1e4 * frame.readings["suspension_deflection"]
        assert abs(held) <= 30.0 * (1.0 + 1e-6)
        control = frame.readings["control_body_acceleration"]
        assert frame.readings["body_acceleration"] == pytest.approx(control, abs=1e-9)

    def slope(t, y):
        return y[1], -(1e4 * y[0] + 30.0 * np.tanh(y[1] / 1e-6)) / 100.0 - one.road.derivatives(t)[
            2
        ]

    known = solve_ivp(
        slope, (0.0, 1.0), (0.0, one.initial_rate), method="BDF", rtol=1e-8, atol=1e-10
    )
    end = drawing.end
    assert end is not None
    assert end.readings["suspension_deflection"] == pytest.approx(known.y[0, -1], abs=2e-5)


force = st.floats(-20.0, 20.0)
switched = st.one_of(
    st.builds(
        OneDofPlane, mass=st.just(300.0), spring=st.just(linear(15000.0)),
        damper=st.just(damper(2000.0, 500.0)), friction=st.floats(5.0, 500.0),
        road=st.builds(roads.sine, st.floats(0.005, 0.02), st.floats(0.7, 4.0), st.just(20.0)),
        initial_deflection=st.floats(-0.05, 0.05), initial_rate=st.floats(-1.0, 1.0),
    ),
    st.builds(
        ElastoplasticPlane, mass=st.just(100.0), damping=st.floats(0.0, 200.0),
        spring_rate=st.just(5000.0), yield_force=st.just(6.0),
        initial_displacement=st.floats(-0.01, 0.01), initial_velocity=st.floats(-0.3, 0.3),
        load=st.tuples(force, force, force).map(
            lambda forces: roads.table([(0.1 * k, f) for k, f in enumerate((0.0, *forces, 0.0))])
        ),
    ),
)  # fmt: skip


@settings(max_examples=40)
@given(switched, st.sampled_from(list(RULES)), st.floats(0.02, 0.25))
def test_every_step_begins_within_the_limits_of_its_mode(plane, rule, turn):
    """So friction acts against the velocity, and a spring yields only outwards."""
    step = turn / plane.angular_frequency
    for frame in construct_motion(plane, RULES[rule], step=step, steps=20):
        states = tuple(frame.points[name] for name in "PR" if name in frame.points)
        assert min(plane.margins(frame.mode, states, frame.time), default=0.0) > -1e-9


# Portraits.


def test_curves_of_dry_friction_are_circles_that_end_on_the_stretch_of_rest():
    (found,) = followed(portrayed("x + 0.3*sign(v)"), WINDOW, [2.05], [0.0])
    below = found[: int(np.argmax(found[1:, 1] >= 0.0)) + 1]
    assert np.hypot(below[:, 0] - 0.3, below[:, 1]) == pytest.approx(1.75, abs=1e-6)
    assert found[-1] == pytest.approx([-0.25, 0.0], abs=1e-7)


def test_curves_of_a_relay_end_in_the_origin_along_its_line():
    (found,) = followed(portrayed("sign(x + 0.3*v)"), WINDOW, [2.0], [0.0])
    assert np.hypot(*found[-1]) < 1e-4
    late = found[np.abs(found[:, 1]) < 0.2][-50:]
    assert late[:, 0] + 0.3 * late[:, 1] == pytest.approx(0.0, abs=1e-7)


def test_backwards_a_curve_is_the_one_that_it_came_along():
    system = portrayed("x + 0.3*sign(v)")
    (there,) = followed(system, WINDOW, [1.0], [1.0])
    middle = there[len(there) // 4]
    (back,) = followed(system, WINDOW, [middle[0]], [middle[1]], -1.0)
    assert np.hypot(*(back - [1.0, 1.0]).T).min() < 0.06


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("d", [0.15, -0.05])
def test_half_turns_with_dry_friction_are_about_the_ends_of_the_stretch_of_rest(d, backwards):
    """x'' - 2d x' + x + R sign(x') = 0: forwards about R first, where x' < 0, backwards about -R."""
    friction, turned = 0.3, sqrt(1.0 - d * d)
    q = exp((-d if backwards else d) * pi / turned)
    centre = -friction if backwards else friction
    x = np.array([0.25, 0.7, 1.5, 2.5])
    far = centre - q * (x - centre)
    back = -centre - q * (far + centre)
    if not backwards:  # a motion that comes to the stretch of rest stays there
        far[(x < friction) | (np.abs(far) < friction)] = nan
        back[np.isnan(far) | (np.abs(back) < friction)] = nan
    into = [[(float(start), 0.0)] for start in x]
    system = portrayed("-2*d*v + x + R*sign(v)", d=d, R=friction)
    made = turns(system, WINDOW, x, backwards=backwards, into=into)
    assert made.far == pytest.approx(far, abs=1e-8, nan_ok=True)
    assert made.back == pytest.approx(back, abs=1e-8, nan_ok=True)
    assert made.time == pytest.approx(np.where(np.isnan(back), nan, 2.0 * pi / turned), nan_ok=True)
    for start, points in zip(x, into, strict=True):
        (x1, v1), *_ = points[1:] or [(start, 0.0)]
        assert v1 * centre <= 0.0
        assert x1 <= start


def test_the_limit_cycle_of_negative_damping_and_dry_friction():
    """x'' - 2d x' + x + R sign(x') = 0: half turns about +-R grow by q = exp(d pi / w).

    A half turn from x to -x closes the cycle: x + R = q (x - R).
    """
    d, friction = 0.15, 0.5
    turned = sqrt(1.0 - d * d)
    q = exp(d * pi / turned)
    (cycle,) = limit_cycles(portrayed("-2*d*v + x + R*sign(v)", d=d, R=friction), WINDOW)
    assert cycle.crossing == pytest.approx(friction * (q + 1.0) / (q - 1.0), rel=1e-6)
    assert cycle.period == pytest.approx(2.0 * pi / turned, rel=1e-6)
    assert cycle.multiplier == pytest.approx(q * q, rel=1e-3)
    assert cycle.kind == "repels"


@pytest.mark.slow
def test_the_section_of_a_driven_mass_with_friction_is_den_hartogs():
    """J. P. Den Hartog, Trans. ASME 53 (1931): without stops, x at the turn from the closed form."""
    friction, force, w = 0.1, 0.5, 0.8
    shown = compute_portrait(
        portrayed("x + R*sign(v) - F*cos(w*t)", R=friction, F=force, w=w), WINDOW, periods=60
    )
    assert shown.section is not None
    (attractor,) = shown.section.attractors
    x, v = attractor[-1]
    beta = 1.0 / w
    response = beta**2 / (beta**2 - 1.0)
    damping = beta * np.sin(beta * pi) / (1.0 + np.cos(beta * pi))
    amplitude = force * sqrt(response**2 - (friction / force) ** 2 * damping**2)
    formula = Formula("x + R*sign(v) - F*cos(w*t)", {"R": friction, "F": force, "w": w})
    times = np.linspace(0.0, 2.0 * pi / w, 4001)
    found = motion(formula.switching, (float(x), float(v)), times.tolist())
    assert max(found.displacements) == pytest.approx(amplitude, rel=1e-5)


def test_a_vehicle_with_dry_friction_has_its_stretch_of_rest():
    """The friction of a leaf spring over its rate, to both sides."""
    system = build("OneDof", {"friction": 300.0})
    rate = system.elements[0].spring.tangent(0.0)
    section = of_coordinate(system)
    (rest,) = equilibria(section, Window(-0.1, 0.1, -1.0, 1.0))
    assert (rest.x, rest.until) == pytest.approx((-300.0 / rate, 300.0 / rate), rel=1e-6)
    (curve,) = followed(section, Window(-0.1, 0.1, -1.0, 1.0), [0.08], [0.0])
    assert curve[-1, 1] == 0.0
    assert abs(curve[-1, 0]) <= 300.0 / rate * (1.0 + 1e-9)


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
