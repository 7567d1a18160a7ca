"""Motions of equations that switch, for portraits: curves, turns and sections, one motion at a time.

Across a jump of f, and on a switch that holds a motion, only a step that ends there is right.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from math import hypot, inf, isnan, nan

import numpy as np
import numpy.typing as npt

from phaseplane.equations.roots import root
from phaseplane.equations.stepping import MotionError, Step, steps
from phaseplane.equations.switching import Switching
from phaseplane.portrait.system import Grid, PhaseSystem, Window

_TOLERANCE, _OF_SECTION = 1e-8, 1e-7
_STILL, _REST = 1e-7, 5  # of the window's sides; a motion rests after so many steps this short
_CRAWL = 1e-4  # the same for a turn, of its largest distance so far from its start
_SLOW, _SLOWEST = 100, 0.01  # a curve ends where so many steps lead it no farther, in windows
_MOST = 20_000  # steps


def switches(system: PhaseSystem) -> Switching | None:
    """Return the switching of a system; None if its f does not jump."""
    return system.switching if system.switching and system.switching.guards else None


def curves(
    system: PhaseSystem,
    window: Window,
    x: npt.ArrayLike,
    v: npt.ArrayLike,
    sense: npt.ArrayLike,
    margin: float,
    length: float,
    part: float,
) -> list[Grid]:
    """Return integral curves until they leave the window or come to rest, (points, 2) each.

    Backwards in time a curve ends on a switch that motions leave to both sides: it has no past there.

    Parameters
    ----------
    sense, margin, length, part : as of `followed`
    """

    def curve(start: tuple[float, float], sense: float) -> Grid:
        points = [start]
        went, mark, still = 0.0, 0.0, 0
        for count, step in enumerate(_steps(system, start, sense, _TOLERANCE), 1):
            way, (x1, v1, _) = _way(step, window), step.last
            parts = int(way / part) + 1
            pause = (step.end - step.start) / parts
            points += [*(step.at(step.start + pause * i) for i in range(1, parts)), (x1, v1)]
            went += way
            still = still + 1 if way < _STILL else 0
            over = not window.holds(x1, v1, margin) or went > length or still >= _REST
            rests = step.first[1] == v1 == 0.0
            if over or (0 in step.mode and (rests or sense < 0.0)):
                break
            if count % _SLOW == 0:  # beside a pole of f, or to and fro between switches
                if went - mark < _SLOWEST:
                    break
                mark = went
        found = np.array(points)
        found[1:, 1] *= 1.0 if sense > 0.0 else -1.0
        return found

    starts = np.broadcast_arrays(*(np.asarray(each, float) for each in (x, v, sense)))
    return [
        curve((a, b), s)
        for a, b, s in zip(*(each.ravel().tolist() for each in starts), strict=True)
    ]


def turn(
    system: PhaseSystem,
    window: Window,
    start: float,
    *,
    backwards: bool = False,
    tolerance: float = 1e-9,
    into: list[tuple[float, float]] | None = None,
) -> tuple[float, float, float]:
    """Return where a motion from (start, 0) crosses the x axis the first two times, and when the second.

    NaN for a crossing to which it does not come.
    """
    far, still, gone = nan, 0, 0.0
    sense = -1.0 if backwards else 1.0
    half = -1.0  # the sign of the velocity on record in this half of the turn, whatever the sense
    for step in _steps(system, (start, 0.0), sense, max(tolerance, 1e-10)):
        (_, v0, _), (x1, v1, _) = step.first, step.last
        gone = max(gone, hypot((x1 - start) / window.width, v1 / window.height))
        still = still + 1 if _way(step, window) <= _CRAWL * gone else 0
        if not window.holds(x1, v1, 2.0) or still >= _REST:
            break
        if into is not None:
            into.append((x1, sense * v1))
        if v1 * half >= 0.0 or v0 * half < 0.0:
            continue
        at = root(step.velocity, step.start, step.end)
        x = step.at(at)[0]
        if not isnan(far):
            return far, x, at
        far, half = x, -half
    return far, nan, nan


def samples(
    system: PhaseSystem, window: Window, start: tuple[float, float], farthest: float
) -> Iterator[tuple[tuple[float, float], int]]:
    """Yield the states of a motion at the ends of successive periods, until it is gone, and its steps."""
    due = system.period
    # as exact as a section of an equation without switches
    made = _steps(system, start, 1.0, _OF_SECTION, longest=0.25 * system.period)
    for count, step in enumerate(made, 1):
        while step.end >= due * (1.0 - 1e-12):
            x, v = step.at(min(due, step.end))
            if not window.holds(system.wrapped(np.array(x)), v, farthest):
                return
            yield (x, v), count
            due = (round(due / system.period) + 1) * system.period


def _steps(
    system: PhaseSystem,
    start: tuple[float, float],
    sense: float,
    tolerance: float,
    longest: float = inf,
) -> Iterator[Step]:
    """Yield the steps of a motion; in reversed time its velocities have the other sign."""
    switching = switches(system)
    assert switching is not None
    x, v = start
    if sense < 0.0:
        switching, v = switching.reversed, -v
    most = _MOST if longest == inf else 100 * _MOST
    try:
        yield from islice(
            steps(switching, (x, v), 0.0, 1e6, longest=longest, tolerance=tolerance), most
        )
    except MotionError:
        return


def _way(step: Step, window: Window) -> float:
    """Return the distance between the ends of a step, in windows."""
    (x0, v0, _), (x1, v1, _) = step.first, step.last
    return hypot((x1 - x0) / window.width, (v1 - v0) / window.height)
