"""Turns of motions in the plane: the return of a motion from the x axis to it.

A closed curve of x'' + f = 0 crosses the axis twice, once downwards, where f > 0, and once upwards.
One whole turn from each point of the axis with f > 0 therefore finds all closed curves.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from phaseplane.portrait import switched
from phaseplane.portrait.system import Grid, PhaseSystem, Window
from phaseplane.portrait.trajectories import Indices, Motions, motions

_ROOM = 2.0  # windows that a turn may lead beyond the sides
_MOST = 4000  # steps
_LANDINGS = 6  # corrections of the last step


class Turns(NamedTuple):
    """The ends of turns; NaN if a motion does not return.

    Parameters
    ----------
    far : x at the crossing on the other side
    back : x at the return
    time : duration of the turn, s
    """

    far: Grid
    back: Grid
    time: Grid


def turns(
    system: PhaseSystem,
    window: Window,
    starts: Grid,
    *,
    backwards: bool = False,
    tolerance: float = 1e-9,
    into: list[list[tuple[float, float]]] | None = None,
) -> Turns:
    """Follow one turn from (x, 0) for every x of `starts`, where f > 0.

    Parameters
    ----------
    backwards : whether time is reversed
    tolerance : of a step, in windows
    into : lists that receive the points of each motion
    """
    if switched.switches(system):
        rows = [
            switched.turn(
                system, window, start, backwards=backwards, tolerance=tolerance,
                into=into[k] if into is not None else None,
            )
            for k, start in enumerate(starts.tolist())
        ]  # fmt: skip
        return Turns(*(np.array(rows).reshape(-1, 3).T))
    sense = -1.0 if backwards else 1.0
    going = motions(system, window, starts, 0.0, sense, tolerance)
    count = len(starts)
    half = np.full(count, -sense)  # the sign of x' in this half of the turn
    crossed = np.zeros(count, int)
    found = Turns(*(np.full(count, np.nan) for _ in range(3)))
    for _ in range(_MOST):
        if not going.active.any():
            break
        moved, x0, v0, t0 = going.step()
        over = half[moved] * going.v[moved] < 0.0
        if over.any():
            which = moved[over]
            _land(going, which, x0[over], v0[over], t0[over])
            crossed[which] += 1
            half[which] *= -1.0
            half_way, home = which[crossed[which] == 1], which[crossed[which] == 2]
            found.far[half_way], found.back[home] = going.x[half_way], going.x[home]
            found.time[home] = np.abs(going.t[home])
            going.active[home] = False
        if into is not None:
            for k in moved.tolist():
                into[k].append((float(going.x[k]), float(going.v[k])))
        gone = ~window.holds(going.x[moved], going.v[moved], _ROOM)
        going.active[moved[gone]] = False
    return found


def _land(going: Motions, which: Indices, x0: Grid, v0: Grid, t0: Grid) -> None:
    """Shorten the last step so that it ends on the axis, by Newton's method with v' = -f."""
    x, v, t = going.x[which], going.v[which], going.t[which]
    sense = going.sense[which]
    h = np.abs(t - t0)
    step = h * np.clip(v0 / np.where(v0 == v, 1.0, v0 - v), 0.0, 1.0)
    low, high = np.zeros_like(h), h.copy()
    for _ in range(_LANDINGS):
        x, v, _error = going.tried(x0, v0, t0, sense, step)
        beyond = v * np.where(v0 == 0.0, -going.v[which], v0) < 0.0
        low, high = np.where(beyond, low, step), np.where(beyond, step, high)
        force = going.system.forces(x, v, t0 + sense * step)
        with np.errstate(all="ignore"):
            new = step + sense * v / force
        outside = ~((new > low) & (new < high))
        new = np.where(outside, 0.5 * (low + high), new)
        if np.all(np.abs(v) <= 1e-13 * going.window.height):
            break
        step = new
    going.x[which], going.v[which], going.t[which] = x, 0.0, t0 + sense * step
