"""Limit cycles, as fixed points of the return map on the x axis."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from phaseplane.portrait.energy import conserves
from phaseplane.portrait.returns import turns
from phaseplane.portrait.switched import switches
from phaseplane.portrait.system import Grid, PhaseSystem, Window

_STARTS = 400  # of the search, over the width of the window
_SWITCHED = 120  # the same for motions with switches, which are followed one by one
_COARSE, _FINER, _FINE = 1e-7, 1e-8, 1e-10  # tolerances of a step, in windows
_DOUBTFUL = 0.1  # of the width: a smaller gain may be an error, which motions that part magnify
_ROUNDING = 1e-6  # of the width: a turn that ends within it of its start may be closed
_NARROW = 0.01  # of the width: smaller turns are judged by the kind of their equilibrium
_LEAST = 1e-12  # of a multiplier: smaller values are rounding
_ZOOMS, _PARTS = 3, 12  # how often an interval is divided, and into how many parts
_CLOSED = 3  # neighbouring closed turns: not a limit cycle, which is isolated


@dataclass(frozen=True, slots=True)
class Cycle:
    """An isolated closed curve in the plane.

    Parameters
    ----------
    crossing : its largest x, where it crosses the x axis downwards
    period : s
    multiplier : growth of the distance from it in one turn; it attracts if this is below 1
    curve : shape (points, 2): x and x'
    semistable : whether it attracts from one side and repels on the other; two cycles too close to
        be separated look the same
    """

    crossing: float
    period: float
    multiplier: float
    curve: Grid
    semistable: bool = False

    @property
    def attracts(self) -> bool:
        """Whether nearby motions approach it from both sides."""
        return not self.semistable and abs(self.multiplier) < 1.0

    @property
    def kind(self) -> str:
        """Its stability, as a phrase."""
        if self.semistable:
            return "semi-stable"
        return "attracts" if self.attracts else "repels"


def limit_cycles(system: PhaseSystem, window: Window) -> list[Cycle]:
    """Return the limit cycles that cross the x axis in a window, from the inside outwards.

    A cycle is where the gain of a turn, its end minus its start, changes sign. Where the gain comes
    near zero without a change of sign, there may be two cycles close together or a semistable one, and
    the interval is refined. Repelling cycles are sought in reversed time, in which they attract.
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
    """Return approximate starts of closed turns, and whether they attract from one side only."""
    count = _SWITCHED if switches(system) else _STARTS
    x = np.linspace(window.left, window.right, count + 1)
    gain = _without_errors(
        system, window, x, backwards, _gains(system, window, x, backwards, _COARSE)
    )
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
    """Return how much farther out a turn from each (x, 0) ends; NaN if no turn begins or ends there.

    Turns too narrow to be judged within rounding are ignored.
    """
    gain = np.full(len(x), np.nan)
    starts = system.forces(x, 0.0 * x) > 0.0
    if starts.any():
        made = turns(system, window, x[starts], backwards=backwards, tolerance=tolerance)
        wide = x[starts] - made.far > _NARROW * window.width
        gain[starts] = np.where(wide, made.back - x[starts], np.nan)
    return gain


def _without_errors(
    system: PhaseSystem, window: Window, x: Grid, backwards: bool, gain: Grid
) -> Grid:
    """Return the gains, zero where a finer tolerance changes them by more than half: all turns close.

    So it is where motions part on one half of a turn and meet again on the other. Gains within rounding
    are kept: a semi-stable cycle is where they do not change their sign.
    """
    found = gain.copy()
    sizes = np.abs(gain) / window.width
    doubtful = np.flatnonzero((sizes > _ROUNDING) & (sizes < _DOUBTFUL))
    if len(doubtful):
        finer = _gains(system, window, x[doubtful], backwards, _FINER)
        wrong = np.abs(gain[doubtful] - finer) > 0.5 * np.abs(finer)
        found[doubtful[wrong]] = 0.0
    return found


def _crossings(x: Grid, gain: Grid, window: Window) -> list[tuple[float, float]]:
    """Return intervals in which the gain falls through zero, so that turns approach from both sides.

    It may vanish within rounding, but not over several points, where every turn is closed.
    """
    sure = np.flatnonzero(~(np.abs(gain) <= _ROUNDING * window.width))
    return [
        (float(x[a]), float(x[b]))
        for a, b in pairwise(sure)
        if gain[a] > 0.0 > gain[b] and b - a <= _CLOSED
    ]


def _turnings(x: Grid, gain: Grid, window: Window) -> list[tuple[float, float]]:
    """Return intervals in which the gain is nearest to zero and, by its curvature, might reach it."""
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
    """Refine an interval where the gain comes near zero: two crossings, one touch, or neither."""
    tiny = 1e-2 * _ROUNDING * window.width  # possible error of a zero gain
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
    """Return the crossing in an interval; None if the gain jumps across zero."""
    x = np.linspace(a, b, _PARTS + 1)
    gain = _gains(system, window, x, backwards, _COARSE)
    falls = np.flatnonzero((gain[:-1] >= 0.0) & (gain[1:] <= 0.0))
    if not len(falls):
        return None
    k = int(falls[0])
    before, after = float(gain[k]), float(gain[k + 1])
    # near a cycle the gain falls at most as fast as the start moves out
    if before - after > 3.0 * (b - a):
        return None
    return float(x[k] + (x[k + 1] - x[k]) * before / (before - after or 1.0))


def _precise(
    system: PhaseSystem, window: Window, at: float, backwards: bool, semistable: bool
) -> Cycle | None:
    """Return the cycle near a crossing, by Newton's method with the slope from neighbouring turns."""
    h = 3e-5 * window.width
    made = slope = None
    for tolerance in (_COARSE, _FINE):
        x = at + h * np.array([-1.0, 0.0, 1.0])
        points: list[list[tuple[float, float]]] = [[(float(start), 0.0)] for start in x]
        closer = turns(
            system, window, x, backwards=backwards, tolerance=tolerance, into=points
        )  # fmt: skip
        if not np.isfinite(closer.back).all():
            break  # too stiff for the fine tolerance: keep the coarse result
        made, slope = closer, float(closer.back[2] - closer.back[0]) / (2.0 * h)
        curve, period = points[1], float(made.time[1])
        if semistable:
            continue
        if abs(slope - 1.0) < 1e-9:
            return None
        way = (at - float(made.back[1])) / (slope - 1.0)
        at += way
        period += way * float(made.time[2] - made.time[0]) / (2.0 * h)
    if made is None or slope is None:
        return None
    if abs(float(made.back[1]) - at) > 1e-5 * window.width or not window.left < at <= window.right:
        return None
    slope = max(slope, _LEAST)
    multiplier = 1.0 / slope if backwards else slope
    return Cycle(at, period, multiplier, np.array(curve), semistable)
