"""Motions of x'' + f(x', x, t) = 0 at given times, to ten digits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import isnan, log2, nan
from typing import NamedTuple

from phaseplane.equations.stepping import (
    MOST_STEPS,
    MotionError,
    State,
    Step,
    TooManyStepsError,
    steps,
)
from phaseplane.equations.switching import Mode, Switching

# steps after which, and after each doubling, it is judged how many would follow; what has grown by then
_FIRST_MARK, _GROWN = 8192, 1.05
_SHORTEST = 1e-14  # of the time that remains: so short are steps only where rounding ends them


class Motion(NamedTuple):
    """A motion at given times.

    Parameters
    ----------
    times : those reached, s
    displacements, velocities, accelerations : at these times
    switches : the times at which the mode changed, s
    complaint : why the motion ended early, or empty
    """

    times: list[float]
    displacements: list[float]
    velocities: list[float]
    accelerations: list[float]
    switches: list[float]
    complaint: str = ""

    def add(self, *row: float) -> None:
        """Append a time, displacement, velocity and acceleration."""
        for column, value in zip(self[:4], row, strict=True):
            column.append(value)


def motion(
    system: Switching,
    start: State,
    times: Sequence[float],
    going_on: Callable[[float], bool] = lambda _time: True,
) -> Motion:
    """Return the motion from a state at the first of ascending times, as `motions` does."""
    return motions(system, [start], times, going_on)[0]


def motions(
    system: Switching,
    starts: Sequence[State],
    times: Sequence[float],
    going_on: Callable[[float], bool] = lambda _time: True,
) -> list[Motion]:
    """Return the motions from some states at the first of ascending times, each to ten digits.

    They go on side by side: when they are ended, or one cannot go on, the others have come as far.

    Parameters
    ----------
    system : the equation
    starts : x and x' of each at the first time
    times : s, ascending
    going_on : called after every step with the time that all have reached, s; whether to go on
    """
    found = [Motion([], [], [], [], []) for _ in starts]
    under_way = [_followed(system, *each, times) for each in zip(starts, found, strict=True)]
    reached, end = dict.fromkeys(range(len(starts)), times[0]), times[-1]
    while reached:
        k = min(reached, key=reached.__getitem__)
        try:
            reached[k] = next(under_way[k], end)
        except MotionError as error:
            found[k] = found[k]._replace(complaint=str(error))
            ended = found[k].times[-1] if found[k].times else times[0]
            end = reached[k] = min(end, ended)
        if not going_on(min(reached.values())):
            break
        reached = {other: time for other, time in reached.items() if time < end}
    for (x, v), one in zip(starts, found, strict=True):
        if not one.times:  # it did not leave its start, or was not to
            a = system.acceleration(system.settled(v, x, times[0]), v, x, times[0])
            one.add(times[0], x, v, -system.value(v, x, times[0]) if isnan(a) else a)
    return found


def _followed(
    system: Switching, start: State, found: Motion, times: Sequence[float]
) -> Iterator[float]:
    """Yield the times to which a motion has come, s, with its rows so far in `found`."""
    due, end = 0, times[-1]
    mode: Mode | None = None
    longest = (end - times[0]) / 50.0
    for step in _within_reach(steps(system, start, times[0], end, longest=longest), end):
        if mode is not None and step.mode != mode:
            found.switches.append(step.start)
        mode = step.mode
        while due < len(times) and times[due] <= step.end:
            x, v = step.at(times[due])
            a = nan if step.stiff else system.acceleration(mode, v, x, times[due])
            if isnan(a):  # or f ends so close to the motion that the error of x is beyond it
                a = step.acceleration(times[due])
            found.add(times[due], x, v, a)
            due += 1
        yield step.end


def _within_reach(steps: Iterable[Step], end: float) -> Iterator[Step]:
    """Yield steps to an end, s; raise an error as soon as it is out of reach.

    What grows and becomes ever faster is followed with ever shorter steps, which would only end after
    minutes; and where f ends, the motion creeps up to it with steps that do not move x.
    """
    marks: list[float] = []  # when the number of steps had doubled
    largest = grown = (0.0, 0.0)
    for count, step in enumerate(steps, 1):
        yield step
        x, v, _ = step.last
        largest = max(largest[0], abs(x)), max(largest[1], abs(v))
        if count != _FIRST_MARK << len(marks):
            continue
        marks.append(step.end)
        if len(marks) > 2 and 2.0 * _ahead(count, *marks[-3:]) < end - step.end:
            if any(new > _GROWN * old for new, old in zip(largest, grown, strict=True)):
                raise TooManyStepsError(step.end)
            if marks[-1] - marks[-2] < 0.5 * count * _SHORTEST * (end - step.end):
                raise MotionError(step.end)
        grown = largest


def _ahead(count: int, first: float, second: float, third: float) -> float:
    """Return how long a motion goes on until its steps are too many, s.

    Parameters
    ----------
    count : of steps so far
    first, second, third : when a quarter, half and all of them were made, s; from one doubling to the
        next, the intervals change by the same ratio, with steps of one length, ever shorter ones or
        such as a power of time
    """
    interval = third - second
    ratio = interval / (second - first)
    return sum(interval * ratio**k for k in range(1, int(log2(MOST_STEPS / count)) + 1))
