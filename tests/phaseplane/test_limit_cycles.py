"""Limit cycles of portraits: relaxation, close and semi-stable cycles, and what has none."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, pi, sqrt
from typing import Any

import numpy as np
import pytest
from phase_systems import WIDE, of
from scipy.integrate import solve_ivp

from phaseplane.equations import Formula
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    limit_cycles,
    window_of,
)


def van_der_pol(mu: float) -> tuple[float, float]:
    """Amplitude and period of the cycle, by another method: Radau's, event by event."""

    def axis(_t: float, state: Any) -> float:
        return float(state[1])

    axis.direction = -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(
        lambda _t, y: [y[1], -mu * (y[0] ** 2 - 1.0) * y[1] - y[0]], (0.0, 4.0 * mu + 30.0),
        [2.0, 0.0], method="Radau", rtol=1e-9, atol=1e-11, events=axis,
    )  # fmt: skip
    times, states = solution.t_events[0], solution.y_events[0]
    return float(states[-1][0]), float(times[-1] - times[-2])


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("mu", [1.0, 5.0, 10.0, 20.0, 50.0])
def test_relaxation_cycles_in_high_windows(mu: float, sense: float) -> None:
    amplitude, period = van_der_pol(mu)
    window = Window(-3.0, 3.0, -2.0 * mu - 2.0, 2.0 * mu + 2.0)
    (cycle,) = limit_cycles(of(lambda v, x: sense * mu * (x * x - 1.0) * v + x), window)
    assert cycle.crossing == pytest.approx(amplitude, abs=2e-6)
    assert cycle.period == pytest.approx(period, rel=2e-6)
    assert cycle.attracts == (sense > 0.0)
    assert cycle.curve[:, 1].max() > mu


def radial(*radii: float, power: int = 1, size: float = 1.0) -> PhaseSystem:
    """x'' + x + size (r^2 - r1^2)(r^2 - r2^2)... x' = 0: circles as cycles."""

    def function(v: Any, x: Any) -> Any:
        square = x * x + v * v
        product = size
        for r in radii:
            product = product * (square - r * r)
        return x + product**power * v

    return of(function)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radii", "size", "attracts"),
    [
        ((1.0, 1.1), 1.0, [False, True]),
        ((1.0, 1.01), 1.0, [False, True]),
        ((2.0, 2.004), -0.05, [True, False]),
        ((0.5, 1.0, 3.0), 0.3, [True, False, True]),
    ],
)
def test_close_cycles_are_told_apart(
    radii: tuple[float, ...], size: float, attracts: list[bool]
) -> None:
    found = limit_cycles(radial(*radii, size=size), WIDE)
    assert [c.crossing for c in found] == pytest.approx(radii, abs=2e-5)
    assert [c.attracts for c in found] == attracts
    assert [c.period for c in found] == pytest.approx([2.0 * pi] * len(radii), abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [1.0, 0.98765, 2.5])
def test_a_cycle_that_attracts_from_one_side_is_found_and_said(radius: float) -> None:
    (cycle,) = limit_cycles(radial(radius, power=2), WIDE)
    assert cycle.kind == "semi-stable"
    assert cycle.crossing == pytest.approx(radius, abs=1e-3)
    assert not cycle.attracts


@pytest.mark.sampled
@pytest.mark.parametrize(
    "function",
    [
        lambda v, x: 0.2 * v + np.sin(x),
        lambda v, x: x + v**3,
        lambda v, x: x + 0.3 * x * v,  # closed curves all over
        lambda v, x: x + np.sign(v) * np.maximum(np.abs(v) - 0.5, 0.0),  # closed curves inside
        lambda v, x: x + 0.3 * np.sign(v),
        lambda v, x: x + ((x * x + v * v - 1.0) ** 2 + 0.01) * v,  # nearly one
        lambda v, x: np.sqrt(x),
        lambda v, x: x**3,
    ],
)
def test_what_has_no_limit_cycle(function: Callable[[Any, Any], Any]) -> None:
    assert limit_cycles(of(function), Window(-12.0, 12.0, -4.0, 4.0)) == []


def test_errors_that_motions_magnify_on_their_way_are_no_limit_cycles() -> None:
    """Reversible, so all turns close: motions meet on the right half, and part as much on the left."""
    reversible = of(lambda v, x: np.clip(5.0 * x, -1.0, 1.0) + x * v)
    assert limit_cycles(reversible, Window(-3.75, 3.75, -3.0, 3.0)) == []


def test_a_semi_stable_cycle_that_a_start_meets_is_found() -> None:
    """Its gain is nothing but an error of the steps, which a finer tolerance changes."""
    (cycle,) = limit_cycles(radial(1.0, power=2), Window(-4.0, 4.0, -4.0, 4.0))
    assert cycle.crossing == pytest.approx(1.0, abs=1e-3)
    assert cycle.semistable


@pytest.mark.slow
def test_a_cycle_around_three_equilibria_is_found_once() -> None:
    """Van der Pol's damping in a double well."""
    found = limit_cycles(of(lambda v, x: 0.3 * (x * x - 1.0) * v - x + x**3), WIDE)
    (outer,) = [c for c in found if c.crossing > 1.5]
    assert outer.attracts
    assert outer.curve[:, 0].min() < -1.5


def test_the_limit_cycle_of_a_clock_is_found_from_the_start_beside_it():
    """Half a turn multiplies the distance from the centre +-R by exp(-zeta pi / sqrt(1 - zeta^2))."""
    formula = Formula("0.1*v - 3*sign(v) + x")
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays, switching=formula.switching)
    (cycle,) = limit_cycles(system, window_of(system, 3.0, [(0.5, 0.0)]))
    shrink = exp(-0.05 * pi / sqrt(1.0 - 0.05**2))
    assert cycle.crossing == pytest.approx(3.0 * (1.0 + shrink) / (1.0 - shrink), rel=1e-6)
