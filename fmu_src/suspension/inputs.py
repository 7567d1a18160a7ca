"""Inputs of a session: what the host has set, and how it goes on until the host says more.

A host gives samples. Held over a step, a sample makes the motion right to first order only; carried
on by its slope, to second order. A road has its velocity as an input for that. Everything else, and
a road without a velocity, goes on by the smaller of the slopes of its last two intervals, and not at
all where their signs differ: that is the slope to first order wherever the course is smooth, and
leaves jumps as they are given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

_SAMPLES = 3  # as many as two slopes take
_LONGEST = 2.0  # times the interval that a slope was taken over: how long it is carried on


@dataclass(frozen=True, slots=True)
class Course:
    """One input: its present value, and when it was set.

    Parameters
    ----------
    value : as the host reads it back
    samples : (instant in s, value) of the last calls that set it, at most three instants; a call
        counts even if it repeats the value before
    """

    value: float = 0.0
    samples: tuple[tuple[float, float], ...] = ()

    def set(self, time: float, value: float) -> Course:
        """The course after one more call, s; a later call at the same instant replaces an earlier one."""
        before = tuple(sample for sample in self.samples if sample[0] < time)
        return Course(value, (*before[1 - _SAMPLES :], (time, value)))

    @property
    def since(self) -> float | None:
        """The instant at which it was set last, s; None if it never was."""
        return self.samples[-1][0] if self.samples else None

    def slope(self, until: float) -> float:
        """Its rate of change for a step that ends at `until`, s.

        0 where the step ends later than twice the last interval after the sample: a host that is
        silent for so long says that nothing changes.
        """
        if len(self.samples) < _SAMPLES:
            return 0.0
        (t0, f0), (t1, f1), (t2, f2) = self.samples
        if until - t2 > _LONGEST * (t2 - t1) * (1.0 + 1e-9):
            return 0.0
        before, last = (f1 - f0) / (t1 - t0), (f2 - f1) / (t2 - t1)
        if before * last <= 0.0:
            return 0.0
        return min(before, last, key=abs)


@dataclass(frozen=True, slots=True)
class Line:
    """A straight course in time: `value` at `origin` (s), and its rate of change."""

    origin: float
    value: float
    slope: float = 0.0

    def at(self, time: float) -> float:
        """The value at an instant."""
        return self.value + self.slope * (time - self.origin)

    def continues(self, before: Line) -> bool:
        """Whether it is the same course as another one, from which nothing changes."""
        level = self.slope == before.slope == 0.0
        return self == before or (level and self.value == before.value)


def carried(course: Course, until: float) -> Line:
    """How an input goes on that has no rate of its own, for a step that ends at `until`, s."""
    since = course.since
    return Line(0.0 if since is None else since, course.value, course.slope(until))


def carried_road(
    elevation: Course, velocity: Course, before: Line, now: float, until: float
) -> Line:
    """How a road goes on for a step from `now` to `until`, s.

    Once its velocity has been set the road follows it from each elevation on. Where velocities come
    without elevations, the road goes by their mean over each interval.

    Parameters
    ----------
    before : how it went until now
    """
    if not velocity.samples:
        return carried(elevation, until)
    if elevation.since == now:
        return Line(now, elevation.value, velocity.value)
    if velocity.since == now and now > before.origin:
        height = before.value + 0.5 * (before.slope + velocity.value) * (now - before.origin)
        return Line(now, height, velocity.value)
    return replace(before, slope=velocity.value)


def to_plain(courses: Mapping[str, Course]) -> dict[str, Any]:
    """Courses as data that JSON takes."""
    return {name: [course.value, course.samples] for name, course in courses.items()}


def from_plain(kept: Mapping[str, Any]) -> dict[str, Course]:
    """The courses that `to_plain` was given."""
    return {
        name: Course(value, tuple((t, x) for t, x in samples))
        for name, (value, samples) in kept.items()
    }
