"""Limit cycles, as fixed points of the return to the x axis."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from phaseplane.portrait.energy import conserves
from phaseplane.portrait.returns import turns
from phaseplane.portrait.system import Grid, PhaseSystem, Window

_STARTS = 400  # of the search, over the width of the window
_COARSE, _FINE = 1e-7, 1e-10  # tolerances of a step, in windows
_ROUNDING = 1e-6  # of the width: a turn that ends so near its start may be closed
_NARROW = 0.01  # of the width: turns within it are left to the kind of their equilibrium
_LEAST = 1e-12  # of a multiplier: what is less is rounding
_ZOOMS, _PARTS = 3, 12  # into how many parts an interval is divided, and how often
_CLOSED = 3  # neighbouring closed turns: no cycle, which is alone


@dataclass(frozen=True, slots=True)
class Cycle:
    """A closed curve of the plane, alone in its neighbourhood.

    Parameters
    ----------
    crossing : where it crosses the x axis downwards, its largest x
    period : s
    multiplier : by which the distance from it grows in one turn: it attracts where that is below 1
    curve : shape (points, 2): x and x'
    semistable : whether it attracts from one side and repels on the other; two cycles that lie too
        close to be told apart look the same
    """

    crossing: float
    period: float
    multiplier: float
    curve: Grid
    semistable: bool = False

    @property
    def attracts(self) -> bool:
        """Whether motions nearby approach it, from both sides."""
        return not self.semistable and abs(self.multiplier) < 1.0

    @property
    def kind(self) -> str:
        """In words."""
        if self.semistable:
            return "attracts from one side"
        return "attracts" if self.attracts else "repels"


def limit_cycles(system: PhaseSystem, window: Window) -> list[Cycle]:
    """The limit cycles that cross the x axis in a window, inside out.

    Where the gain of a turn over its start changes sign lies a cycle; where it comes near zero
    without a change, two may lie close together, or one that attracts from one side: there the search
    goes into parts of the interval. What repels is sought in reversed time, in which it attracts.
    """
    if conserves(system, window):
        return []
    found: list[Cycle] = []
    for backwards in (False, True):
        for crossing, semistable in _fixed(system, window, backwards):
            cycle = _precise(system, window, crossing, backwards, semistable)
            if cycle is None or any(
                abs(c.crossing - cycle.crossing) < 1e-4 * window.width
                and (c.semistable or cycle.semistable)
                for c in found
            ):
                continue
            found.append(cycle)
    return sorted(found, key=lambda cycle: cycle.crossing)


def _fixed(system: PhaseSystem, window: Window, backwards: bool) -> list[tuple[float, bool]]:
    """Where turns end where they started, about, and whether from one side only."""
    x = np.linspace(window.left, window.right, _STARTS + 1)
    gain = _gains(system, window, x, backwards, _COARSE)
    crossings = _crossings(x, gain, window)
    found: list[tuple[float, bool]] = []
    for a, b in _turnings(x, gain, window):
        closer = _closer(system, window, a, b, backwards)
        if isinstance(closer, float):
            found.append((closer, True))
        else:
            crossings += closer
    for a, b in crossings:
        at = _within(system, window, a, b, backwards)
        if at is not None:
            found.append((at, False))
    return found


def _gains(system: PhaseSystem, window: Window, x: Grid, backwards: bool, tolerance: float) -> Grid:
    """How much farther out one turn from each (x, 0) ends; not a number where none begins or ends.

    Turns that are narrower than rounding would allow to judge count as none.
    """
    gain = np.full(len(x), np.nan)
    starts = system.forces(x, 0.0 * x) > 0.0
    if starts.any():
        made = turns(system, window, x[starts], backwards=backwards, tolerance=tolerance)
        wide = x[starts] - made.far > _NARROW * window.width
        gain[starts] = np.where(wide, made.back - x[starts], np.nan)
    return gain


def _crossings(x: Grid, gain: Grid, window: Window) -> list[tuple[float, float]]:
    """Intervals in which the gain goes from above zero to below it: turns close in from both sides.

    Between them it may vanish to rounding, but not over several points: there every turn is closed.
    """
    sure = np.flatnonzero(~(np.abs(gain) <= _ROUNDING * window.width))
    return [
        (float(x[a]), float(x[b]))
        for a, b in pairwise(sure)
        if gain[a] > 0.0 > gain[b] and b - a <= _CLOSED
    ]


def _turnings(x: Grid, gain: Grid, window: Window) -> list[tuple[float, float]]:
    """Intervals in which the gain comes nearest to zero, and by its bend might reach it."""
    found = []
    for k in range(1, len(x) - 1):
        a, b, c = gain[k - 1 : k + 2]
        same = a * b > 0.0 and b * c > 0.0 and max(map(abs, (a, b, c))) > _ROUNDING * window.width
        if not (same and abs(b) <= abs(a) and abs(b) <= abs(c)):
            continue
        bend = a - 2.0 * b + c
        least = b - (c - a) ** 2 / (8.0 * bend) if bend else b
        if least * b <= 0.0 or abs(least) <= abs(bend):
            found.append((float(x[k - 1]), float(x[k + 1])))
    return found


def _closer(
    system: PhaseSystem, window: Window, a: float, b: float, backwards: bool
) -> list[tuple[float, float]] | float:
    """A closer look where the gain only comes near zero: two crossings, or one touch, or neither."""
    tiny = 1e-2 * _ROUNDING * window.width  # what errors of the turns may make of zero
    x = np.array([a, b])
    for zoom in range(_ZOOMS):
        x = np.linspace(x[0], x[-1], 2 * _PARTS + 1)
        gain = _gains(system, window, x, backwards, _FINE)
        if not np.isfinite(gain).all():
            return []
        if zoom == 0 and np.count_nonzero(np.abs(gain) <= 0.1 * tiny) >= _CLOSED:
            return []  # the edge of a region of closed curves
        if (-np.sign(gain[0]) * gain).max() > tiny:
            falls = np.flatnonzero((gain[:-1] > 0.0) & (gain[1:] <= 0.0))
            return [(float(x[k]), float(x[k + 1])) for k in falls]
        k = int(np.clip(np.argmin(np.sign(gain[0]) * gain), 1, len(x) - 2))
        x = x[k - 1 : k + 2]
    return float(x[1]) if np.abs(gain).min() <= tiny else []


def _within(
    system: PhaseSystem, window: Window, a: float, b: float, backwards: bool
) -> float | None:
    """The crossing in an interval; none where the gain jumps across zero."""
    x = np.linspace(a, b, _PARTS + 1)
    gain = _gains(system, window, x, backwards, _COARSE)
    falls = np.flatnonzero((gain[:-1] >= 0.0) & (gain[1:] <= 0.0))
    if not len(falls):
        return None
    k = int(falls[0])
    before, after = float(gain[k]), float(gain[k + 1])
    # in a cycle's neighbourhood the gain falls at most as fast as the start moves out
    if before - after > 3.0 * (b - a):
        return None
    return float(x[k] + (x[k + 1] - x[k]) * before / (before - after or 1.0))


def _precise(
    system: PhaseSystem, window: Window, at: float, backwards: bool, semistable: bool
) -> Cycle | None:
    """The cycle near a crossing: Newton on the turn, with the neighbours for its slope."""
    h = 3e-5 * window.width
    made = slope = None
    for tolerance in (_COARSE, _FINE):
        x = at + h * np.array([-1.0, 0.0, 1.0])
        points: list[list[tuple[float, float]]] = [[(float(start), 0.0)] for start in x]
        closer = turns(
            system, window, x, backwards=backwards, tolerance=tolerance, into=points
        )  # fmt: skip
        if not np.isfinite(closer.back).all():
            break  # so stiff that many more steps would have to be made: the one before will do
        made, slope = closer, float(closer.back[2] - closer.back[0]) / (2.0 * h)
        curve = points[1]
        if semistable:
            continue
        if abs(slope - 1.0) < 1e-9:
            return None
        at -= (float(made.back[1]) - at) / (slope - 1.0)
    if made is None or slope is None:
        return None
    if abs(float(made.back[1]) - at) > 1e-5 * window.width or not window.left < at <= window.right:
        return None
    slope = max(slope, _LEAST)
    multiplier = 1.0 / slope if backwards else slope
    return Cycle(at, float(made.time[1]), multiplier, np.array(curve), semistable)
