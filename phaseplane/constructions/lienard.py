"""Lienard's construction in one phase plane: from the state point to the auxiliary curve."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, floor

from phaseplane.constructions.laws import Strut
from phaseplane.constructions.primitives import Curve, Frame, Plane
from phaseplane.constructions.sheet import reach, round_step, state_point, trail

_POINTS = 64  # intervals of an auxiliary curve, even so that y-bar = 0 is included


@dataclass(frozen=True, slots=True)
class Lienard:
    """A phase plane with its family of auxiliary curves y = -epsilon(y-bar; y_i) (AP57 section 3).

    Parameters
    ----------
    plane : the plane on the sheet
    epsilon : function of y-bar and y_i, m
    corners : values of y-bar at which the curves have corners, m
    levels : y_i of the drawn curves, m, ascending; A is interpolated between them and extrapolated
        beyond; empty: A is on the curve through P's y, and curves are drawn for round values
    """

    plane: Plane
    epsilon: Callable[[float, float], float]
    corners: tuple[float, ...] = ()
    levels: tuple[float, ...] = ()

    @classmethod
    def of_strut(cls, plane: Plane, strut: Strut, levels: tuple[float, ...] = ()) -> Lienard:
        """Return the plane of a strut: epsilon = (Phi(Omega y-bar, y_i) + G(y_i)) / c."""
        omega, rate, force = plane.angular_frequency, strut.rate, strut.force
        corners = tuple(corner / omega for corner in strut.corners)
        return cls(plane, lambda y_bar, y: force(omega * y_bar, y) / rate - y, corners, levels)

    def state(self, displacement: float, velocity: float) -> complex:
        """Return P for a displacement, m, and its rate, m/s."""
        return state_point(self.plane, displacement, velocity)

    def values(self, p: complex) -> tuple[float, float]:
        """Return y and y', read off the sheet."""
        y_bar = self.plane.scaled_velocity.read(p)
        return self.plane.displacement.read(p), self.plane.angular_frequency * y_bar

    def raised(self, p: complex) -> tuple[complex, complex, complex]:
        """Return Q, the foot of P; A, level with P on the auxiliary curve; and A*, the foot of A."""
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
        """Return y read off the sheet: OQ / a (AP57 eqs. 11, 21, 39)."""
        return self.plane.displacement.read(q)

    def displacement_between(self, start: complex, end: complex) -> float:
        """Return the signed distance of two points along the y axis, m of displacement."""
        axis = self.plane.displacement
        return (end - start).real * axis.direction.real / axis.scale

    def velocity(self, p: complex, q: complex) -> float:
        """Return y' read off the sheet: Omega QP / a (AP57 eqs. 11, 22, 39)."""
        return self.plane.angular_frequency * (p - q).imag / self.plane.displacement.scale

    def acceleration(self, q: complex, foot: complex) -> float:
        """Return y'' read off the sheet: Omega^2 QD / a (AP57 eqs. 11, 23, 39)."""
        return self.plane.angular_frequency**2 * self.displacement_between(q, foot)

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """Return the auxiliary curves over the range of the motion.

        Returns
        -------
        a labelled curve per level, or one without a label if epsilon does not depend on y
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
