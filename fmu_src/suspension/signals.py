"""Functions of time made of segments, with their derivatives and the times at which these jump.

A signal is a chain of segments, each a cubic polynomial plus one cosine whose phase may be
quadratic in time. Bumps, obstacles, sines, sweeps, tables and forces all have this form, so the
integrator evaluates them by one formula and ends a step on every joint.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import cos, inf, sin
from typing import NamedTuple

GAUSS = (  # five nodes on (0, 1) and their weights
    (0.04691007703066802, 0.11846344252809454),
    (0.23076534494715845, 0.23931433524968324),
    (0.5, 0.28444444444444444),
    (0.76923465505284155, 0.23931433524968324),
    (0.95308992296933199, 0.11846344252809454),
)
_ROUNDING = 64.0 * 2.0**-52  # of a difference of two rounded sums, relative to the terms


class Segment(NamedTuple):
    """From `start`: c0 + c1 s + c2 s^2 + c3 s^3 + amplitude cos(p0 + p1 s + p2 s^2); s = t - origin."""

    start: float
    origin: float = 0.0
    coefficients: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    amplitude: float = 0.0
    phase: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def derivatives(self, t: float) -> tuple[float, float, float, float]:
        """Return the value and the first three time derivatives at t."""
        s = t - self.origin
        c0, c1, c2, c3 = self.coefficients
        value = c0 + s * (c1 + s * (c2 + s * c3))
        rate = c1 + s * (2.0 * c2 + s * 3.0 * c3)
        acceleration = 2.0 * c2 + 6.0 * c3 * s
        jerk = 6.0 * c3
        if self.amplitude != 0.0:
            p0, p1, p2 = self.phase
            angle = p0 + s * (p1 + s * p2)
            speed = p1 + 2.0 * p2 * s
            c, d = self.amplitude * cos(angle), self.amplitude * sin(angle)
            value += c
            rate -= d * speed
            acceleration -= c * speed * speed + d * 2.0 * p2
            jerk += d * speed * speed * speed - 6.0 * p2 * speed * c
        return value, rate, acceleration, jerk

    @property
    def level(self) -> bool:
        """Whether the value is constant."""
        return self.amplitude == 0.0 and not any(self.coefficients[1:])

    def rounding(self, t: float) -> float:
        """Return the possible rounding error of the value at t, including that of the times."""
        s = abs(t - self.origin)
        terms = _magnitude(self.coefficients, s)
        if self.amplitude != 0.0:
            terms += abs(self.amplitude) * (1.0 + _magnitude(self.phase, s))
        return _ROUNDING * (terms + abs(self.derivatives(t)[1] * t))

    def integral(self, t0: float, t1: float) -> float:
        """Return the integral of the value from t0 to t1."""
        s0, s1 = t0 - self.origin, t1 - self.origin
        width = s1 - s0
        middle = 0.5 * (s0 + s1)
        c0, c1, c2, c3 = self.coefficients
        square = width * width / 12.0
        total = width * (
            c0 + middle * (c1 + middle * (c2 + middle * c3)) + square * (c2 + 3.0 * middle * c3)
        )
        if self.amplitude == 0.0:
            return total
        p0, p1, p2 = self.phase
        if p2 == 0.0:
            half = 0.5 * p1 * width
            sinc = sin(half) / half if half != 0.0 else 1.0
            return total + self.amplitude * width * cos(p0 + p1 * middle) * sinc
        # A quadratic phase gives Fresnel integrals: Gauss quadrature in panels of half a radian.
        turn = max(abs(p1 + 2.0 * p2 * s0), abs(p1 + 2.0 * p2 * s1)) * abs(width)
        panels = int(2.0 * turn) + 1
        part = width / panels
        sums = sum(
            weight * cos(p0 + s * (p1 + s * p2))
            for i in range(panels)
            for node, weight in GAUSS
            for s in (s0 + part * (i + node),)
        )
        return total + self.amplitude * part * sums


def _start(segment: Segment) -> float:
    return segment.start


@dataclass(frozen=True)
class Signal:
    """A function of time made of segments in ascending order; its value may jump at a joint.

    Parameters
    ----------
    segments : at least one; the first starts at minus infinity
    scale : a typical magnitude, in the signal's unit, for error control (0 if nothing is known)
    """

    segments: tuple[Segment, ...]
    scale: float = 0.0

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """The numbers of all segments, one segment after the other; see `Segment`."""
        return tuple(
            number
            for start, origin, coefficients, amplitude, phase in self.segments
            for number in (start, origin, *coefficients, amplitude, *phase)
        )

    @cached_property
    def doubles(self) -> array[float]:
        """The same numbers as an array, made once: a road may have a hundred thousand."""
        return array("d", self.numbers)

    @property
    def joints(self) -> tuple[float, ...]:
        """The times at which two segments meet, s, ascending."""
        return tuple(segment.start for segment in self.segments[1:])

    @cached_property
    def jumps(self) -> tuple[tuple[float, float], ...]:
        """The joints at which the value jumps: time in s and height, new minus old value.

        Differences within rounding are ignored.
        """
        found = []
        for left, right in pairwise(self.segments):
            t = right.start
            height = right.derivatives(t)[0] - left.derivatives(t)[0]
            if abs(height) > left.rounding(t) + right.rounding(t):
                found.append((t, height))
        return tuple(found)

    def derivatives(self, t: float) -> tuple[float, float, float, float]:
        """Return the value and the first three derivatives at t (to the right of a joint)."""
        here = bisect_right(self.segments, t, lo=1, key=_start) - 1
        return self.segments[here].derivatives(t)

    def value(self, t: float) -> float:
        """Return the elevation in m (or force in N) at t."""
        return self.derivatives(t)[0]

    def before(self, t: float) -> float:
        """Return the value at t to the left of a joint."""
        here = bisect_left(self.segments, t, lo=1, key=_start) - 1
        return self.segments[here].derivatives(t)[0]

    def rate(self, t: float) -> float:
        """Return the first derivative at t."""
        return self.derivatives(t)[1]

    def acceleration(self, t: float) -> float:
        """Return the second derivative at t."""
        return self.derivatives(t)[2]

    def integral(self, t0: float, t1: float) -> float:
        """Return the integral of the value from t0 to t1, joint by joint."""
        if t1 < t0:
            return -self.integral(t1, t0)
        here = bisect_right(self.segments, t0, lo=1, key=_start)
        total = 0.0
        while here < len(self.segments) and (joint := self.segments[here].start) <= t1:
            total += self.segments[here - 1].integral(t0, joint)
            t0 = joint
            here += 1
        return total + self.segments[here - 1].integral(t0, t1)

    def delayed(self, delay: float) -> Signal:
        """Return the signal delayed by `delay` seconds, as the rear axle meets the front axle's road."""
        return replace(
            self,
            segments=tuple(
                segment._replace(start=segment.start + delay, origin=segment.origin + delay)
                for segment in self.segments
            ),
        )


def constant(value: float = 0.0) -> Signal:
    """Return a constant signal, such as a flat road or a zero force."""
    return Signal((Segment(-inf, 0.0, (value, 0.0, 0.0, 0.0)),), abs(value))


LEVEL = constant()
"""A flat road, or a zero force."""


def straight_lines(points: Sequence[tuple[float, float]], scale: float) -> Signal:
    """Return straight lines through (time, value) points, constant before and after.

    Two points at the same time make a jump.
    """
    segments = [Segment(-inf, 0.0, (points[0][1], 0.0, 0.0, 0.0))]
    for (t, value), (t_next, value_next) in pairwise(points):
        if t < t_next:
            segments.append(Segment(t, t, (value, (value_next - value) / (t_next - t), 0.0, 0.0)))
    t_end, last = points[-1]
    segments.append(Segment(t_end, t_end, (last, 0.0, 0.0, 0.0)))
    return Signal(tuple(segments), scale)


def passing_time(length: float, speed: float, *, or_zero: bool = False) -> float:
    """Return the time in s that a wheel at `speed` takes for `length`.

    Raises
    ------
    ValueError : a speed that is not positive, or a length that is not (zero is allowed by `or_zero`).
    """
    if not 0.0 < speed < inf:
        raise ValueError(f"speed must be positive, {speed:g} m/s given")
    if not (0.0 < length < inf or (or_zero and length == 0.0)):
        allowed = "must not be negative" if or_zero else "must be positive"
        raise ValueError(f"a length of road {allowed}, {length:g} m given")
    return length / speed


def _magnitude(coefficients: Sequence[float], s: float) -> float:
    """Return the polynomial with the magnitudes of the coefficients at s >= 0; infinity if too large."""
    found = 0.0
    for c in reversed(coefficients):
        found = found * s + abs(c)
    return found
