"""The end of a mode within a step: the first time at which one of its margins becomes negative."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from phaseplane.constructions.construction import Window
from phaseplane.constructions.stepping import Stepper
from phaseplane.constructions.steps import Points, States
from phaseplane.equations.roots import root

_SAMPLES = (0.25, 0.5, 0.75)  # parts of a step at which margins are sampled
_AT_ONCE = 1e-9  # part of a window within which limits are reached at the same time
_DOUBTFUL = 0.05  # of the largest margin: dips that stay above it are ignored


class End(NamedTuple):
    """The end of a mode.

    Parameters
    ----------
    part : time from the start of the window, s
    limits : the limit that is reached, and others that are reached at the same time; none if the window
        ends with the states beyond a limit: they then decide on the next mode
    """

    part: float
    limits: tuple[int, ...]


def first_end(
    stepper: Stepper,
    mode: str,
    states: States,
    window: Window,
    points: Points,
    successors: States,
    *,
    fresh: bool,
) -> End | None:
    """Return the first end of the mode within a window, or None.

    Parameters
    ----------
    points, successors : of the step over the whole window
    fresh : whether the mode has just begun, so that its margin is zero to rounding
    """
    margins = stepper.construction.margins
    last = margins(mode, successors, window.end)
    if not last:
        return None
    way = stepper.way(states, points, window.duration)

    def between(part: float) -> tuple[float, ...]:
        parabolas = zip(states, way, successors, strict=True)
        at = tuple([p + part * (t + part * (q - p - t)) for p, t, q in parabolas])
        return margins(mode, at, window.start + part * window.duration)

    rows = (margins(mode, states, window.start), *map(between, _SAMPLES), last)
    found: list[tuple[float, int]] = []
    for limit, course in enumerate(zip(*rows, strict=True)):

        def left(part: float, limit: int = limit) -> float:
            within = Window(window.start, part)
            _, at = stepper.step(mode, states, within)
            return margins(mode, at, within.end)[limit]

        part = _end_of(course, left, window.duration, fresh=fresh)
        if part is not None:
            found.append((part, limit))
    if not found:
        return None
    first, _ = min(found)
    if first == window.duration and min(last) < 0.0:
        return End(first, ())
    at_once = first + _AT_ONCE * window.duration
    return End(first, tuple(limit for part, limit in sorted(found) if part <= at_once))


def _end_of(
    course: Sequence[float], left: Callable[[float], float], duration: float, *, fresh: bool
) -> float | None:
    """Return the time at which a margin becomes negative, s, from its samples over the window.

    Right after a change of mode the margin is zero. If it does not grow from there, the curve only
    touches the limit, and the present mode lasts for the whole window.
    """
    for start, end in _descents(course):
        low, high = start * duration, end * duration
        f_high = course[-1] if end == 1.0 else left(high)
        if f_high >= 0.0:
            continue  # only the approximating parabola crosses zero
        f_low = course[0] if start == 0.0 else left(low)
        if f_low <= 0.0 or (fresh and start == 0.0):
            low = next((part for i in range(1, 11) if left(part := high / 2**i) > 0.0), 0.0)
            if low == 0.0:
                return duration if course[-1] < 0.0 else None
        return root(left, low, high)
    # what is reached with the end of the window would otherwise be missed by the next one
    ends = course[-1] < course[-2] and 0.0 <= course[-1] <= _AT_ONCE * max(course)
    return duration if ends else None


def _descents(course: Sequence[float]) -> Iterator[tuple[float, float]]:
    """Yield the parts of the window in which a margin may fall through zero, including dips."""
    parts = (0.0, *_SAMPLES, 1.0)
    doubtful = _DOUBTFUL * max(course)
    positive = 0  # where the margin was positive last
    for i in range(1, len(course)):
        before, here = course[i - 1], course[i]
        if before > 0.0:
            positive = i - 1
        if here < 0.0:
            yield parts[positive], parts[i]
        elif i + 1 < len(course) and before > here < course[i + 1]:
            bend = before - 2.0 * here + course[i + 1]
            fall = before - course[i + 1]
            if here - 0.125 * fall * fall / bend < doubtful:
                yield parts[i - 1], parts[i] + 0.5 * fall / bend * parts[1]
