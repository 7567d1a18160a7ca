"""Lienard's construction in one phase plane: from the state point to the auxiliary curve."""

from __future__ import annotations

from bisect import bisect_right
from cmath import isfinite
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, copysign, floor

from phaseplane.constructions.control import Motion
from phaseplane.constructions.laws import Epsilon, Strut
from phaseplane.constructions.primitives import Curve, Plane
from phaseplane.constructions.sheet import reach, round_step, state_point, trail
from phaseplane.constructions.steps import Points
from phaseplane.constructions.storage import StoredFrames
from phaseplane.equations.roots import root

_BESIDE = 1e-9  # of the range of y-bar: distance of the points on both sides of a jump
_DRAWN = 1e-3  # of the length of a curve: about the width of a line; what is closer looks the same
_ON_AXIS = 1e-9  # of the distance from the origin
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
    guards : functions of y-bar and y_i; where one changes its sign a curve jumps or has a corner
    """

    plane: Plane
    epsilon: Epsilon
    corners: tuple[float, ...] = ()
    levels: tuple[float, ...] = ()
    guards: tuple[Callable[[float, float], float], ...] = ()

    @classmethod
    def of_strut(
        cls,
        plane: Plane,
        strut: Strut,
        levels: tuple[float, ...] = (),
        friction: float = 0.0,
        guards: tuple[Epsilon, ...] = (),
    ) -> Lienard:
        """Return the plane of a strut: epsilon = (Phi(Omega y-bar, y_i) + G(y_i) +- R) / c."""
        omega, moved = plane.angular_frequency, friction / strut.rate
        corners = tuple(corner / omega for corner in strut.corners)
        epsilon = strut.epsilon(omega, 0.0)

        def with_friction(y_bar: float, y: float) -> float:
            return epsilon(y_bar, y) + (copysign(moved, y_bar) if y_bar else 0.0)

        return cls(plane, with_friction if friction else epsilon, corners, levels, guards)

    def state(self, displacement: float, velocity: float) -> complex:
        """Return P for a displacement, m, and its rate, m/s."""
        return state_point(self.plane, displacement, velocity)

    def moved(self, p: complex, displacement: float, velocity: float) -> complex:
        """Return P after jumps of the displacement, m, and its rate, m/s."""
        return p + (self.state(displacement, velocity) - self.state(0.0, 0.0))

    def values(self, p: complex) -> tuple[float, float]:
        """Return y and y', read off the sheet."""
        y_bar = self.plane.scaled_velocity.read(p)
        return self.plane.displacement.read(p), self.plane.angular_frequency * y_bar

    def raised(
        self, p: complex, epsilon: Epsilon | None = None
    ) -> tuple[complex, complex, complex]:
        """Return Q, the foot of P; A, level with P on the auxiliary curve; and A*, the foot of A.

        Parameters
        ----------
        epsilon : of the branch of the curve that P is on, if it has several
        """
        axis = self.plane.displacement
        origin, scale, sense = axis.origin, axis.scale, axis.direction.real
        y = sense * (p.real - origin.real) / scale
        y_bar = (p.imag - origin.imag) / scale
        law = epsilon or self.epsilon
        far = self.interpolated(y_bar, y, law) if self.levels else law(y_bar, y)
        foot = origin.real - sense * scale * far
        return complex(p.real, origin.imag), complex(foot, p.imag), complex(foot, origin.imag)

    def interpolated(self, y_bar: float, y: float, epsilon: Epsilon) -> float:
        """Return epsilon, interpolated between the two drawn curves nearest to y, m."""
        levels = self.levels
        if len(levels) == 1:
            return epsilon(y_bar, levels[0])
        i = min(max(bisect_right(levels, y), 1), len(levels) - 1)
        low, high = levels[i - 1], levels[i]
        share = (y - low) / (high - low)
        return (1.0 - share) * epsilon(y_bar, low) + share * epsilon(y_bar, high)

    def _broken(self, heights: Sequence[float], y: float) -> Iterator[float]:
        """Yield the values of y-bar just below and above each break of the curve for y."""
        beside = _BESIDE * (heights[-1] - heights[0])
        # off the grid, since many guards vanish at y-bar = 0, which is on it
        places = [height + 1e3 * beside for height in heights]
        for guard in self.guards:

            def course(y_bar: float, guard: Epsilon = guard) -> float:
                return guard(y_bar, y)

            values = [course(place) for place in places]
            for i, (low, high) in enumerate(pairwise(places)):
                if values[i] * values[i + 1] < 0.0:
                    at = root(course, low, high)
                    yield from (at - beside, at + beside)

    def displacement(self, q: complex) -> float:
        """Return y at the foot of a point, m."""
        return self.plane.displacement.read(q)

    def displacement_between(self, start: complex, end: complex) -> float:
        """Return the signed distance of two points along the y axis, m of displacement."""
        axis = self.plane.displacement
        return (end - start).real * axis.direction.real / axis.scale

    def motion(self, points: Points) -> Motion:
        """Return y, y' and y'' read off the sheet: OQ / a, Omega QP / a and Omega^2 QD / a.

        (AP57 eqs. 11, 21 to 23 and 39; D is the foot of the normal.)
        """
        plane, q = self.plane, points[f"Q{self.plane.number}"]
        return (
            self.displacement(q),
            plane.angular_frequency * (points[plane.state] - q).imag / plane.displacement.scale,
            plane.angular_frequency**2 * self.displacement_between(q, points[plane.foot]),
        )

    def snapped(self, p: complex) -> complex:
        """Return P, on the y axis if it is there to rounding."""
        origin = self.plane.displacement.origin
        near = abs((p - origin).imag) <= _ON_AXIS * abs(p - origin)
        return complex(p.real, origin.imag) if near else p

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves over the range of the motion.

        Returns
        -------
        a labelled curve per level; curves that cannot be distinguished in a drawing become one with all
        labels; if none can be distinguished, a single curve without a label
        """
        plane = self.plane
        points = trail(plane, frames)
        low, high = reach(plane.scaled_velocity, points)
        largest = 1.1 * max(-low, high) or 0.01
        grid = {largest * (2 * i / _POINTS - 1) for i in range(_POINTS + 1)}
        heights = sorted(grid | {c for c in self.corners if abs(c) < largest})

        def curve(y: float) -> tuple[complex, ...]:
            places = sorted({*heights, *self._broken(heights, y)}) if self.guards else heights
            points = (plane.at(-self.epsilon(v, y), v) for v in places)
            return tuple(z for z in points if isfinite(z))

        values = self.levels or _round_values(*reach(plane.displacement, points))
        # where f has a pole there is no curve
        family = {y: vertices for y in values if len(vertices := curve(y)) > 1}
        first = next(iter(family.values()), (0j,))
        size = abs(first[-1] - first[0])
        axis = plane.displacement
        factor, unit = (100.0, " cm") if axis.unit == "m" else (1.0, f" {axis.unit}".rstrip())
        found: list[tuple[tuple[complex, ...], list[str]]] = []
        for y, vertices in family.items():
            known = (labels for other, labels in found if _same(vertices, other, _DRAWN * size))
            label = f"{axis.label} = {factor * y:g}{unit}"
            here = next(known, None)
            if here is None:
                found.append((vertices, [label]))
            else:
                here.append(label)
        if len(found) == 1 and len(family) == len(values):
            return (Curve("auxiliary", first),)
        return tuple(
            Curve("auxiliary", vertices, " and ".join(labels)) for vertices, labels in found
        )


def _same(one: Sequence[complex], other: Sequence[complex], tiny: float) -> bool:
    return len(one) == len(other) and all(
        abs(p - q) <= tiny for p, q in zip(one, other, strict=True)
    )


def _round_values(least: float, most: float) -> list[float]:
    interval = round_step((most - least) or 0.01, 5)
    return [interval * i for i in range(floor(least / interval), ceil(most / interval) + 1)]
