"""Lienard's construction in one phase plane: from the state point to the auxiliary curve."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, floor

from phaseplane.constructions.laws import Strut
from phaseplane.constructions.primitives import Curve, Frame, Plane
from phaseplane.constructions.sheet import reach, round_step, state_point, trail

_POINTS = 64  # of an auxiliary curve, an even number so that y-bar = 0 is one of them


@dataclass(frozen=True, slots=True)
class Lienard:
    """A phase plane with its family of auxiliary curves y = -epsilon(y-bar; y_i) (AP57 section 3).

    Parameters
    ----------
    plane : where it is on the sheet
    epsilon : of y-bar and y_i, m
    corners : values of y-bar at which the curves bend, m
    levels : the y_i for which curves are drawn, m, ascending; between two of them, and beyond the
        outer ones, A is interpolated; empty: A lies on the curve of P's own y, and the curves drawn
        are those of round values
    """

    plane: Plane
    epsilon: Callable[[float, float], float]
    corners: tuple[float, ...] = ()
    levels: tuple[float, ...] = ()

    @classmethod
    def of_strut(cls, plane: Plane, strut: Strut, levels: tuple[float, ...] = ()) -> Lienard:
        """The plane of a strut: epsilon = (Phi(Omega y-bar, y_i) + G(y_i)) / c."""
        omega, rate, force = plane.angular_frequency, strut.rate, strut.force
        corners = tuple(corner / omega for corner in strut.corners)
        return cls(plane, lambda y_bar, y: force(omega * y_bar, y) / rate - y, corners, levels)

    def state(self, displacement: float, velocity: float) -> complex:
        """P of a displacement, m, and its rate, m/s."""
        return state_point(self.plane, displacement, velocity)

    def values(self, p: complex) -> tuple[float, float]:
        """Return y and y', read off the sheet."""
        y_bar = self.plane.scaled_velocity.read(p)
        return self.plane.displacement.read(p), self.plane.angular_frequency * y_bar

    def raised(self, p: complex) -> tuple[complex, complex, complex]:
        """Q, the foot of P; A, where the parallel to the y axis meets the curve; A*, its foot."""
        axis = self.plane.displacement
        origin, scale, sense = axis.origin, axis.scale, axis.direction.real
        y = sense * (p.real - origin.real) / scale
        y_bar = (p.imag - origin.imag) / scale
        epsilon = self.interpolated(y_bar, y) if self.levels else self.epsilon(y_bar, y)
        foot = origin.real - sense * scale * epsilon
        return complex(p.real, origin.imag), complex(foot, p.imag), complex(foot, origin.imag)

    def interpolated(self, y_bar: float, y: float) -> float:
        """Return epsilon, interpolated between the two drawn curves nearest to y, m."""
        levels = self.levels
        if len(levels) == 1:
            return self.epsilon(y_bar, levels[0])
        i = min(max(bisect_right(levels, y), 1), len(levels) - 1)
        low, high = levels[i - 1], levels[i]
        share = (y - low) / (high - low)
        return (1.0 - share) * self.epsilon(y_bar, low) + share * self.epsilon(y_bar, high)

    def displacement(self, q: complex) -> float:
        """y off the sheet: OQ / a (AP57 eqs. 11, 21, 39)."""
        return self.plane.displacement.read(q)

    def displacement_between(self, start: complex, end: complex) -> float:
        """The length between two points along the y axis, in its sense, m of displacement."""
        axis = self.plane.displacement
        return (end - start).real * axis.direction.real / axis.scale

    def velocity(self, p: complex, q: complex) -> float:
        """y' off the sheet: Omega QP / a (AP57 eqs. 11, 22, 39)."""
        return self.plane.angular_frequency * (p - q).imag / self.plane.displacement.scale

    def acceleration(self, q: complex, foot: complex) -> float:
        """y'' off the sheet: Omega^2 QD / a (AP57 eqs. 11, 23, 39)."""
        return self.plane.angular_frequency**2 * self.displacement_between(q, foot)

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """Return the auxiliary curves over the range of the motion.

        Returns
        -------
        one curve without a label where epsilon does not depend on y
        """
        plane = self.plane
        points = trail(plane, frames)
        low, high = reach(plane.scaled_velocity, points)
        largest = 1.1 * max(-low, high) or 0.01
        grid = {largest * (2 * i / _POINTS - 1) for i in range(_POINTS + 1)}
        heights = sorted(grid | {c for c in self.corners if abs(c) < largest})
        up = plane.scaled_velocity.direction * plane.scaled_velocity.scale

        def curve(y: float) -> tuple[complex, ...]:
            return tuple(plane.displacement.at(-self.epsilon(v, y)) + up * v for v in heights)

        values = self.levels or _round_values(*reach(plane.displacement, points))
        family = [curve(y) for y in values]
        apart = max(abs(p - q) for other in family for p, q in zip(family[0], other, strict=True))
        if apart <= 1e-9 * abs(family[0][-1] - family[0][0]):
            return (Curve("auxiliary", family[0]),)
        axis = plane.displacement
        factor, unit = (100.0, " cm") if axis.unit == "m" else (1.0, axis.unit)
        return tuple(
            Curve("auxiliary", vertices, f"{axis.label} = {factor * y:g}{unit}")
            for vertices, y in zip(family, values, strict=True)
        )


def _round_values(least: float, most: float) -> list[float]:
    interval = round_step((most - least) or 0.01, 5)
    return [interval * i for i in range(floor(least / interval), ceil(most / interval) + 1)]
