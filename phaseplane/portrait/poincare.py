"""Poincare sections: motions under periodic excitation, sampled once per period."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, islice

import numpy as np

from phaseplane.portrait import switched
from phaseplane.portrait.system import Grid, PhaseSystem, Window
from phaseplane.portrait.trajectories import Motions, motions

_GONE = 4.5  # windows beyond the sides: motions farther out after a period are abandoned
_LOST = 100.0  # the same within a period: there, errors in windows ask for too many digits
_MOST = 16_000  # steps of a section
_MOST_SWITCHED = 60  # periods of motions with switches, which are followed one by one
_MOST_SWITCHED_STEPS = 150_000  # of these motions together
_TRANSIENT = 0.5  # of the periods, of a dissipative system
_LONGEST = 12  # longest period of a periodic motion, in periods of the excitation
_CLOSES, _SAME, _SETTLED = 1e-5, 1e-3, 1e-7  # windows


@dataclass(frozen=True, slots=True)
class Section:
    """The Poincare section of a driven system.

    Parameters
    ----------
    period : of the excitation, s
    points : states (x, x') of many motions at the starts of periods, shape (n, 2)
    transient, periods : numbers of periods of each motion that are left out at the beginning, and kept
    attractors : the states of attracting periodic motions, shape (m, 2) for one that repeats after m
        periods
    """

    period: float
    points: Grid
    transient: int
    periods: int
    attractors: tuple[Grid, ...]


def section(
    system: PhaseSystem, window: Window, start: tuple[float, float], periods: int = 100
) -> Section:
    """Return the section of a driven system at the starts of periods, from states all over a window.

    If the system is dissipative on average, the first half of the periods is left out.

    Parameters
    ----------
    start : state of an additional motion
    periods : of each motion; fewer if they would take too long, or if all have settled before

    Raises
    ------
    ValueError : a system without a period.
    """
    if not system.driven:
        raise ValueError("the system has no period: give that of the excitation")
    x0, _ = window.centre
    lattice = np.stack(window.grid(5, 5), axis=-1).reshape(-1, 2)
    starts = np.vstack([0.2 * np.array(window.centre) + 0.8 * lattice, start])
    rows = [starts]
    if switched.switches(system):
        periods = min(periods, _MOST_SWITCHED)
    for row in islice(_by_periods(system, window, starts), periods):
        rows.append(np.column_stack([x0 + system.wrapped(row[:, 0] - x0), row[:, 1]]))
        apart = _apart(system, rows[-1], rows[-2]) / [window.width, window.height]
        apart = apart[np.isfinite(apart).all(axis=1)]
        # all have settled in motions of the drive's period: what follows is the same again
        if not len(apart) or apart.max() < _SETTLED:
            break
    states = np.array(rows)
    transient = int(_TRANSIENT * (len(rows) - 1)) if _dissipates(system, window) else 0
    kept = states[transient:]
    points = kept.reshape(-1, 2)
    return Section(
        system.period, points[np.isfinite(points).all(axis=1)], transient, len(kept),
        _attractors(system, states, window) if transient else (),
    )  # fmt: skip


def _by_periods(system: PhaseSystem, window: Window, starts: Grid) -> Iterator[Grid]:
    """Yield the states of all motions after every period; NaN for those that are gone."""
    if switched.switches(system):
        gone = (np.nan, np.nan), 0
        every = [switched.samples(system, window, (x, v), _GONE) for x, v in starts.tolist()]
        made = 0
        while made <= _MOST_SWITCHED_STEPS:
            states, counts = zip(*(next(one, gone) for one in every), strict=True)
            made = sum(counts)
            yield np.array(states)
        return
    going = motions(system, window, starts[:, 0], starts[:, 1], tolerance=1e-7)
    steps = 0
    for k in count(1):
        going.x[:] = system.wrapped(going.x)  # an angle that goes round and round stays near
        steps += _go_on(system, window, going, k)
        going.active[~window.holds(going.x, going.v, _GONE)] = False
        yield np.where(going.active[:, None], np.array([going.x, going.v]).T, np.nan)
        if steps > _MOST:
            return


def _apart(system: PhaseSystem, one: Grid, other: Grid) -> Grid:
    """Return the differences of states, the shorter way round where x is an angle."""
    difference = one - other
    difference[..., 0] = system.wrapped(difference[..., 0])
    return np.abs(difference)


def _dissipates(system: PhaseSystem, window: Window) -> bool:
    """Return whether areas of the plane shrink on average: the mean of df/dx' is above 0."""
    x, v = window.grid(21, 21)
    dv = 1e-6 * window.height
    slopes = [
        system.forces(x, v + dv, t) - system.forces(x, v - dv, t)
        for t in system.period * np.array([0.1, 0.35, 0.6, 0.85])
    ]
    return float(np.nanmean(slopes)) / (2.0 * dv) > 1e-9 / system.period


def _attractors(system: PhaseSystem, states: Grid, window: Window) -> tuple[Grid, ...]:
    """Return the different periodic motions that motions end in; states by period, motion, (x, x')."""
    sides = np.array([window.width, window.height])
    found: list[Grid] = []
    for motion in states.transpose(1, 0, 2):
        for m in range(1, min(_LONGEST, len(motion) // 2) + 1):
            # over twice as many periods, so that a slow approach is not taken for a return
            if not (_apart(system, motion[-m:], motion[-2 * m : -m]) / sides).max() < _CLOSES:
                continue
            turn = motion[-m:]
            known = any(
                len(other) == m
                and (_apart(system, other, turn[-1]) / sides).max(axis=1).min() < _SAME
                for other in found
            )
            if not known:
                found.append(turn)
            break
    return tuple(found)


def _go_on(system: PhaseSystem, window: Window, going: Motions, period: int) -> int:
    """Step to the end of a period, counted from 1, or until lost; return the number of steps."""
    end = period * system.period
    steps = 0
    active = going.active.copy()
    while going.active.any():
        left = end - going.t
        arrived = left <= 1e-12 * end
        going.active &= ~arrived
        if not going.active.any():
            break
        going.step(np.maximum(left, 1e-300))
        going.active &= window.holds(system.wrapped(going.x), going.v, _LOST)
        steps += 1
    going.active[:] = active & (end - going.t <= 1e-9 * end)
    going.t[going.active] = end
    return steps
