"""Inputs of a session: samples set by the host, and their extrapolation until the next one.

Held over a step, a sample makes the motion accurate to first order only; extrapolated by its slope, to
second order. A road has its velocity as an input for that. All other inputs, and a road without a
velocity, are extrapolated by the smaller of the slopes of their last two intervals, and held if the
signs of these differ. This is the slope to first order where the course is smooth, and keeps jumps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

_SAMPLES = 3  # for two slopes
_LONGEST = 2.0  # duration of the extrapolation, in intervals of the last slope


@dataclass(frozen=True, slots=True)
class Course:
    """One input: its present value, and when it was set.

    Parameters
    ----------
    value : the value that the host reads back
    samples : (time in s, value) of the last calls that set it, at most three times; a call counts
        even if it repeats the previous value
    """

    value: float = 0.0
    samples: tuple[tuple[float, float], ...] = ()

    def set(self, time: float, value: float) -> Course:
        """Return the course after another call at `time`, s; it replaces a call at the same time."""
        before = tuple(sample for sample in self.samples if sample[0] < time)
        return Course(value, (*before[1 - _SAMPLES :], (time, value)))

    @property
    def since(self) -> float | None:
        """The time at which it was last set, s; None if it never was."""
        return self.samples[-1][0] if self.samples else None

    def slope(self, until: float) -> float:
        """Return its rate of change for a step that ends at `until`, s.

        0 if the step ends more than two intervals after the last sample: a host that sets nothing
        for so long means that nothing changes.
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
        """Return the value at `time`, s."""
        return self.value + self.slope * (time - self.origin)

    def continues(self, before: Line) -> bool:
        """Return whether it is the same course as an earlier one."""
        level = self.slope == before.slope == 0.0
        return self == before or (level and self.value == before.value)


def carried(course: Course, until: float) -> Line:
    """Extrapolate an input without a rate, for a step that ends at `until`, s."""
    since = course.since
    return Line(0.0 if since is None else since, course.value, course.slope(until))


def carried_road(
    elevation: Course, velocity: Course, before: Line, now: float, until: float
) -> Line:
    """Extrapolate a road for a step from `now` to `until`, s.

    Once its velocity has been set, the road follows it from each elevation. If velocities are set
    without elevations, the road follows their mean over each interval.

    Parameters
    ----------
    before : its course until now
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
    """Return courses as data for JSON."""
    return {name: [course.value, course.samples] for name, course in courses.items()}


def from_plain(kept: Mapping[str, Any]) -> dict[str, Course]:
    """Return the courses from which `to_plain` made the data."""
    return {
        name: Course(value, tuple((t, x) for t, x in samples))
        for name, (value, samples) in kept.items()
    }
