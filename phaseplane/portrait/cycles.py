"""Limit cycles, as fixed points of the return to the x axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from phaseplane.portrait.system import Grid, PhaseSystem, Window

_STARTS = 24


@dataclass(frozen=True, slots=True)
class Cycle:
    """A closed curve of the plane, alone in its neighbourhood.

    Parameters
    ----------
    crossing : where it crosses the x axis downwards, its largest x
    period : s
    multiplier : by which the distance from it grows in one turn: it attracts where that is below 1
    curve : shape (points, 2): x and x'
    """

    crossing: float
    period: float
    multiplier: float
    curve: Grid

    @property
    def attracts(self) -> bool:
        """Whether motions nearby approach it."""
        return abs(self.multiplier) < 1.0


def limit_cycles(
    system: PhaseSystem, window: Window, centre: float = 0.0, longest: float = 1000.0
) -> list[Cycle]:
    """The limit cycles around a point of the x axis, inside out.

    Parameters
    ----------
    centre : x around which they turn
    longest : time of one turn at most, s
    """
    ahead = _attracting(system, window, centre, longest)
    # what repels attracts in reversed time, in which x' has the other sign
    reversed_time = replace(system, function=lambda v, x, t: system.function(-v, x, -t))
    back = [
        replace(c, multiplier=1.0 / c.multiplier, curve=c.curve * [1.0, -1.0])
        for c in _attracting(reversed_time, window, centre, longest)
    ]
    return sorted([*ahead, *back], key=lambda cycle: cycle.crossing)


def _attracting(system: PhaseSystem, window: Window, centre: float, longest: float) -> list[Cycle]:
    """The cycles that motions nearby approach."""

    def turn(x: float) -> float:
        """How much further out one turn from (x, 0) ends; not a number where it does not return."""
        end = _turned(system, x, centre, longest)
        return float("nan") if end is None else end[0] - x

    starts = np.linspace(centre, window.right, _STARTS + 1)[1:].tolist()
    gains = [turn(x) for x in starts]
    found = []
    for (a, b), (inner, outer) in zip(pairwise(starts), pairwise(gains), strict=True):
        if inner > 0.0 > outer:
            x = float(brentq(turn, a, b, xtol=1e-10 * (window.right - window.left)))
            end = _turned(system, x, centre, longest, points=600)
            assert end is not None
            h = 1e-4 * (b - a)
            multiplier = 1.0 + (turn(x + h) - turn(x - h)) / (2.0 * h)
            found.append(Cycle(x, end[1], multiplier, end[2]))
    return found


def _turned(
    system: PhaseSystem, x: float, centre: float, longest: float, points: int = 0
) -> tuple[float, float, Grid] | None:
    """One turn from (x, 0): where and when it comes back to the axis beyond the centre, and its curve."""

    def back(_t: float, state: Grid) -> float:
        return float(state[1])

    back.terminal = True  # type: ignore[attr-defined]
    halves = []
    state, time = [x, 0.0], 0.0
    for direction in (1.0, -1.0):  # up through the axis on the far side, then down on this one
        back.direction = direction  # type: ignore[attr-defined]
        half = solve_ivp(
            system.rates, (time, time + longest), state, events=back, method="DOP853",
            rtol=1e-9, atol=1e-12,
            first_step=1e-6, dense_output=points > 0,
        )  # fmt: skip
        if not len(half.t_events[0]):
            return None
        halves.append(half)
        state, time = [float(half.y_events[0][0][0]), 0.0], float(half.t_events[0][0])
        if (state[0] - centre) * direction >= 0.0:
            return None  # it turns around another point
    curve = np.empty((0, 2))
    if points:
        curve = np.vstack(
            [half.sol(np.linspace(half.t[0], half.t[-1], points // 2)).T for half in halves]
        )
    return state[0], time, curve
