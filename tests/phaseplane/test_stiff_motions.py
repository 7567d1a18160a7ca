"""Motions that are damped far faster than they change."""

from __future__ import annotations

from itertools import pairwise
from math import cos, exp, inf, nan, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from phaseplane.equations import Formula, motion, steps
from phaseplane.equations.dormand_prince import dormand_prince
from phaseplane.equations.radau import radau


@pytest.mark.parametrize("damping", [30.0, 1e3, 1e5, 1e8])
@pytest.mark.parametrize("start", [(1.0, 0.0), (1.0, 5.0)])
def test_a_stiff_damper_leaves_ten_digits_and_few_steps(damping, start):
    """x'' + c x' + x = 0: it took c steps a second, and rounding took the accelerations."""
    switching = Formula("c*v + x", {"c": damping}).switching
    fast = -0.5 * damping - sqrt(0.25 * damping**2 - 1.0)
    slow = 1.0 / fast
    x, v = start
    of_slow = (v - fast * x) / (slow - fast)
    of_fast = (slow * x - v) / (slow - fast)
    times = np.linspace(0.0, 20.0, 101)[1:]  # later than what is fast
    found = motion(switching, start, [0.0, *times])
    columns = found.displacements, found.velocities, found.accelerations
    for n, (column, digits) in enumerate(zip(columns, (1e-11, 2e-9, 5e-6), strict=True)):
        exact = of_slow * slow**n * np.exp(slow * times) + of_fast * fast**n * np.exp(fast * times)
        assert np.array(column[1:]) == pytest.approx(exact, rel=digits, abs=0.0)
    assert len(list(steps(switching, start, 0.0, 20.0))) < 1000


@pytest.mark.parametrize(
    ("f", "at_rest"),
    [
        ("1e4*v + 2e5*x - 1e5", 0.5),
        ("8e3*x*v + 2e5*(x - 0.3)", 0.3),
        ("3e4*x*v + 2e5*dead_zone(x, 0.258)", 0.258),
        ("1e4*v + 1e6*sin(x) - 5e5", pi / 6.0),
    ],
)
def test_a_stiff_motion_comes_to_rest_in_few_steps(f, at_rest):
    """Newton's method gave up where only the rounding of forces in balance moves: 1000 steps a second."""
    *_, last = steps(Formula(f).switching, (1.2, 0.0), 0.0, 30.0)
    assert last.last[:2] == pytest.approx((at_rest, 0.0), abs=1e-12)
    assert last.end - last.start > 0.5


def test_a_stiff_velocity_is_accurate_between_the_ends_of_steps():
    """It had three digits there, and fourteen at the ends."""
    damping, times = 2e6, np.linspace(0.1, 30.0, 301)
    found = motion(
        Formula("c*v + x - cos(7*t)", {"c": damping}).switching, (0.1, 0.0), [0.0, *times]
    )
    exact = _forced(damping, 7.0, 0.1, times)
    assert np.abs(np.array(found.velocities[1:]) - exact).max() < 1e-6 * np.abs(exact).max()


def _forced(c, w, start, t):
    """Return x' of x'' + c x' + x = cos w t from a place at rest, without what decays as exp(-c t)."""
    fast = -0.5 * c - sqrt(0.25 * c * c - 1.0)
    slow = 1.0 / fast
    one = 1.0 / complex(1.0 - w * w, c * w)  # x / e^iwt
    of_slow = (-(1j * w * one).real - fast * (start - one.real)) / (slow - fast)
    return (1j * w * one * np.exp(1j * w * t)).real + of_slow * slow * np.exp(slow * t)


def test_a_relaxation_oscillation():
    """Van der Pol's, of mu = 1000, against scipy: which took a thousand times as many steps."""
    times = np.linspace(0.0, 1000.0, 41)
    switching = Formula("1000*(x^2 - 1)*v + x").switching
    found = motion(switching, (2.0, 0.0), times.tolist())
    exact = solve_ivp(
        lambda _t, y: [y[1], -1000.0 * (y[0] ** 2 - 1.0) * y[1] - y[0]], (0.0, 1000.0), [2.0, 0.0],
        method="Radau", rtol=1e-10, atol=1e-13, t_eval=times,
    )  # fmt: skip
    assert found.displacements == pytest.approx(exact.y[0], abs=1e-8)
    assert found.velocities == pytest.approx(exact.y[1], rel=1e-6)
    assert len(list(steps(switching, (2.0, 0.0), 0.0, 1000.0, longest=20.0))) < 2000


def test_a_stiff_motion_that_switches():
    """A damper that is stiff in one direction alone, against scipy."""
    times = np.linspace(0.0, 20.0, 81)
    found = motion(Formula("x - sin(t) + 1e4*max(v, 0)").switching, (0.0, 0.0), times.tolist())
    exact = solve_ivp(
        lambda t, y: [y[1], sin(t) - y[0] - 1e4 * max(y[1], 0.0)], (0.0, 20.0), [0.0, 0.0],
        method="Radau", rtol=1e-9, atol=1e-12, t_eval=times, max_step=0.05,
    )  # fmt: skip
    assert found.switches == pytest.approx([pi, 2.0 * pi], abs=2e-4)
    assert found.displacements == pytest.approx(exact.y[0], abs=1e-9)
    assert found.velocities == pytest.approx(exact.y[1], abs=1e-8)


def test_the_order_of_a_step():
    """Of one step, 6, as that of Dormand and Prince: halved, it has a 64th of the error."""
    errors = {method: [] for method in (radau, dormand_prince)}
    for method, found in errors.items():
        for h in (0.4, 0.2, 0.1):
            x, v, a, *_ = method(lambda v, x, t: -x - 0.2 * v + cos(t), 0.0, 1.0, 0.5, -0.1, h)
            exact = solve_ivp(
                lambda t, y: [y[1], -y[0] - 0.2 * y[1] + cos(t)], (0.0, h), [1.0, 0.5],
                method="DOP853", rtol=1e-13, atol=1e-15,
            )  # fmt: skip
            found.append(abs(v - exact.y[1, -1]))
            assert a == pytest.approx(-x - 0.2 * v + cos(h), abs=1e-9)
    for found in errors.values():
        assert all(45.0 < more / less < 90.0 for more, less in pairwise(found))


@pytest.mark.parametrize(
    "f",
    [
        lambda v, x, t: nan,
        lambda v, x, t: inf if t > 0.1 else -x,
        lambda v, x, t: 1e9 * v**3 * exp(min(v, 99.0)),
    ],
)
def test_a_step_that_does_not_converge_has_no_small_error(f):
    *_, v_error, _ = radau(f, 0.0, 1.0, 1.0, -1.0, 0.5)
    assert not v_error < 0.1  # nor if it is not a number
