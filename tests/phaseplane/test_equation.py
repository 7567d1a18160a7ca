"""The construction of any equation of second order: van der Pol, forced and time-dependent ones."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, log2, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from worked_example import column

from phaseplane.constructions import RULES, EquationPlane, Window, construct_motion, family, overlay
from phaseplane.equations import Formula


def van_der_pol(velocity: float, x: float, t: float) -> float:
    return (x * x - 1.0) * velocity + x


def forced(velocity: float, x: float, t: float) -> float:
    """Mathieu's equation with a force: f depends on t by itself and through x."""
    return 0.3 * velocity + (1.0 + 0.4 * cos(2.0 * t)) * x - 0.5 * sin(1.3 * t)


def exact(function, start: tuple[float, float], end: float) -> np.ndarray:
    def slope(t, z):
        return z[1], -function(z[1], z[0], t)

    return solve_ivp(slope, (0.0, end), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


@pytest.mark.slow
def test_van_der_pol_ends_on_its_limit_cycle():
    """Amplitude and period at mu = 1: 2.00861986..., 6.66328686... (from within and from without)."""
    for start in (0.3, 3.5):
        one = EquationPlane(van_der_pol, autonomous=True, initial_displacement=start)
        drawing = construct_motion(one, step=0.01, duration=45.0)
        x, v = column(drawing, "displacement"), column(drawing, "velocity")
        late = slice(len(x) // 2, None)
        assert x[late].max() == pytest.approx(2.00862, abs=2e-4)
        times = np.array([frame.time for frame in drawing])
        rising = [
            t - x0 * (u - t) / (x1 - x0)
            for (t, u), (x0, x1) in zip(pairwise(times), pairwise(x), strict=True)
            if t > 20.0 and x0 < 0.0 <= x1
        ]
        assert np.diff(rising) == pytest.approx(6.663287, abs=2e-3)
        assert np.all(np.abs(v[late]) < 2.7)


@given(
    st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.2, 5.0), st.floats(0.01, 2.0),
    st.floats(0.0, 10.0), st.floats(0.0, 0.1),
)  # fmt: skip
def test_the_foot_of_the_normal_is_minus_delta(x, velocity, omega, scale, start, duration):
    """X + delta = f / Omega^2, its mean over the window."""
    one = EquationPlane(
        forced, False, omega, scale, initial_displacement=x, initial_velocity=velocity
    )
    points = one.points("contact", one.initial, Window(start, duration))
    times = np.linspace(start, start + duration, 201)
    values = np.array([forced(velocity, x, t) for t in times])
    mean = np.trapezoid(values, times) / duration if duration > 1e-6 else values[0]
    assert points["D"].imag == 0.0
    read = (points["Q"] - points["D"]).real / scale
    assert read == pytest.approx(mean / omega**2, rel=1e-5, abs=1e-5 / omega**2)


@pytest.mark.parametrize("function", [van_der_pol, forced])
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_converges_with_its_order(rule, function):
    one = EquationPlane(function, initial_displacement=0.7, initial_velocity=-0.4)
    wanted = exact(function, (0.7, -0.4), 3.0)
    errors = []
    for n in (200, 400, 800):
        end = construct_motion(one, rule, step=3.0 / n, steps=n).frames[-1].points["P'"]
        errors.append(np.hypot(*(np.array(one.lienard.values(end)) - wanted)))
    assert log2(errors[1] / errors[2]) == pytest.approx(rule.order, abs=0.2)


def test_the_motion_does_not_depend_on_the_frequency_of_the_plane():
    wanted = exact(van_der_pol, (1.0, 0.0), 2.0)
    for omega in (0.5, 1.0, 2.0):
        one = EquationPlane(van_der_pol, True, omega, initial_displacement=1.0)
        end = construct_motion(one, step=0.002, steps=1000).frames[-1].points["P'"]
        assert one.lienard.values(end) == pytest.approx(wanted, abs=2e-5)


def test_readings_satisfy_the_equation():
    one = EquationPlane(forced, initial_displacement=1.0)
    drawing = construct_motion(one, step=0.05, duration=5.0)
    for frame in drawing:
        read = frame.readings
        force = forced(read["velocity"], read["displacement"], frame.time)
        assert read["acceleration"] == pytest.approx(-force, abs=1e-12)


def test_laid_over_an_exact_motion_it_drifts_by_the_local_error():
    times = np.linspace(0.0, 5.0, 101)
    rows = solve_ivp(
        lambda t, z: (z[1], -van_der_pol(z[1], z[0], t)), (0.0, 5.0), (1.0, 0.0),
        t_eval=times, rtol=1e-11, atol=1e-12,
    ).y  # fmt: skip
    one = EquationPlane(van_der_pol, True)
    drift = [
        max(column(overlay(one, times[::k], *rows[:, ::k]), "displacement_drift")) for k in (1, 2)
    ]
    assert drift[1] / drift[0] == pytest.approx(8.0, abs=2.5)


def test_between_auxiliary_curves_the_point_is_interpolated():
    """With curves ever closer the family gives the motion of P's own curve."""
    apart = []
    for count in (5, 9, 17):
        levels = tuple(np.linspace(-2.5, 2.5, count))
        one = EquationPlane(van_der_pol, True, initial_displacement=1.5, auxiliary_levels=levels)
        own = EquationPlane(van_der_pol, True, initial_displacement=1.5)
        ends = [
            construct_motion(c, step=0.02, duration=2.0).frames[-1].points["P'"] for c in (one, own)
        ]
        apart.append(abs(ends[0] - ends[1]) / one.scale)
        curves = one.curves(construct_motion(one, step=0.02, steps=3).frames)
        assert sum(len(curve.label.split(" and ")) for curve in curves) == count
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2] > 0.0
    on_a_curve = EquationPlane(
        van_der_pol, True, initial_displacement=1.0, auxiliary_levels=(-2.0, 1.0, 3.0)
    )
    own = EquationPlane(van_der_pol, True, initial_displacement=1.0)
    window = Window(0.0)
    assert on_a_curve.points("contact", on_a_curve.initial, window)["A"] == pytest.approx(
        own.points("contact", own.initial, window)["A"]
    )


def test_auxiliary_curves_that_look_the_same_are_one():
    """For a small swing of a pendulum the curves differ by x^3 / 6: by less than the width of a line."""

    def pendulum(v, x, t):
        return sin(x)

    small, large = (
        EquationPlane(pendulum, True, initial_displacement=x, scale=0.1 / x) for x in (0.02, 1.0)
    )
    (curve,) = small.curves(construct_motion(small, step=0.1, steps=20).frames)
    assert curve.label == ""
    assert len(large.curves(construct_motion(large, step=0.1, steps=20).frames)) > 2


def test_an_equation_that_runs_away_says_when():
    one = EquationPlane(lambda v, x, t: -(x**3), initial_displacement=1.0, initial_velocity=1.0)
    with pytest.raises(ArithmeticError, match=r"diverges after .* s; try a step shorter"):
        construct_motion(one, step=0.01, duration=20.0)


@pytest.mark.parametrize("size", [1.0, 3e4, 1e100])
@pytest.mark.parametrize(
    ("start", "push"),
    [
        ((1.0, 0.0), lambda t: 0.0), ((0.0, 1.0), lambda t: 0.0), ((0.0, 0.0), lambda t: 1.0),
        ((0.0, 0.0), sin), ((0.0, 0.0), lambda t: t), ((0.0, 0.0), lambda t: float(t > 3.0)),
        ((0.0, 0.0), lambda t: float(5.0 < t < 5.1)),
    ],
    ids=["displacement", "velocity", "force", "alternating", "growing", "late", "pulse"],
)  # fmt: skip
def test_a_motion_of_any_size_is_constructed_alike(size, start, push):
    one, many = (
        EquationPlane(
            lambda v, x, t, of=of: 0.1 * v + x - of * push(t),
            initial_displacement=of * start[0], initial_velocity=of * start[1],
        )
        for of in (1.0, size)
    )  # fmt: skip
    drawings = (construct_motion(plane, step=0.1, steps=60) for plane in (one, many))
    x, larger = (column(drawing, "displacement") for drawing in drawings)
    assert larger == pytest.approx(size * np.array(x), rel=1e-9, abs=1e-9 * size)


def test_of_several_starts_the_one_that_runs_away_is_named():
    """x'' = x'^3 from x' = 2 reaches infinity at 1/8 s."""
    still = EquationPlane(lambda v, x, t: x - v**3, initial_displacement=0.1)
    with pytest.raises(
        ArithmeticError, match=r"^from the start \(0, 2\) the construction diverges"
    ):
        family(still, [(0.2, 0.0), (0.0, 2.0)], step=0.1, duration=5.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"angular_frequency": 0.0}, r"angular_frequency = 0\.0"),
        ({"scale": -1.0}, r"scale = -1\.0"),
        ({"initial_velocity": inf}, "initial_velocity = inf"),
        ({"function": lambda v, x, t: float("nan")}, "initial_force = nan"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        EquationPlane(**({"function": van_der_pol} | changes))


@pytest.mark.parametrize("rule", ["delta", "osculating_circle", "tangent"])
def test_curves_from_further_starts_are_drawn_as_the_rule_steps(rule: str):
    """x'' + x = 0: arcs about the origin, by whatever rule that has arcs; else the tangents."""
    still = EquationPlane(lambda v, x, t: x)
    drawing = family(still, [(0.0, 2.0)], RULES[rule], step=0.5, duration=6.0)
    (curve,) = (c for c in drawing.curves if c.role == "trail")
    ways = abs(np.diff(curve.vertices))
    if rule == "tangent":
        assert len(ways) == 12
        return
    radius = abs(curve.vertices[0] - still.planes[0].displacement.origin)
    assert abs(np.array(curve.vertices)) == pytest.approx(radius)
    assert max(ways) <= 0.1 * radius


@pytest.mark.parametrize(
    ("text", "period"),
    [("sin(x + t)", 2.0 * pi), ("x*cos(2*t - v^2) + cos(3*t)", 2.0 * pi), ("tan(t/2) + x", 4.0 * pi),
     ("sin(x*t)", None), ("cos(t^2)", None), ("x + t", None), ("sin(t + 1/x)*x", 2.0 * pi)],
)  # fmt: skip
def test_the_period_of_a_drive_is_found_whatever_else_its_phase_depends_on(text, period):
    formula = Formula(text)
    assert formula.period == (period and pytest.approx(period))
    if period:
        values = [formula.function(0.4, 1.3, t) for t in (0.7, 0.7 + period)]
        assert values[1] == pytest.approx(values[0], abs=1e-9)
