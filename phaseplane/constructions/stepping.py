"""One step of a rule on a construction."""

from __future__ import annotations

from cmath import exp, isfinite
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import product

from phaseplane.constructions.construction import Construction, Window
from phaseplane.constructions.primitives import Plane
from phaseplane.constructions.rules import REPEATED, Rule
from phaseplane.constructions.steps import Construct, Points, States, along_tangent

# of a state point from an origin along the y axis, in sizes of the motion: what goes farther diverges
_FARTHEST = 1000.0
_LEAST_SIZE = 0.1  # m of paper, that of a small sheet
# times y-bar: damping that changes it by more in a step leads beyond the mirror image of P
_FOLLOWED = 2.0
_SEEN = 1e-3  # m of paper: how far beyond


def signed_frequency(plane: Plane) -> float:
    """Return the rate at which the normal turns on the sheet, rad/s, anticlockwise positive.

    y grows with time where y-bar is positive (AP57 section 3). With y-bar upwards, the normal turns
    clockwise if y points to the right and anticlockwise if y points to the left (AP57 figure 8).
    """
    y, y_bar = plane.displacement.direction, plane.scaled_velocity.direction
    return -(y.conjugate() * y_bar).imag * plane.angular_frequency


@cache
def _named(template: str, numbers: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of points of one kind, in all planes."""
    return tuple(template.format(n=number) for number in numbers)


MakePoints = Callable[[str, States, Window], Points]
"""The points of a construction, as `Construction.points`."""


@dataclass(frozen=True)
class Stepper:
    """Makes the steps of a construction by a rule, each with all its points.

    Parameters
    ----------
    make_points : makes the points; None if the construction does
    factors : of the turn angles, by plane; empty if they are right
    start : the state points from which each step continues the last one; None if every step starts
        from known ones
    begin, length : of the steps that continue each other: the time of the start, and the duration of
        a step, s
    """

    construction: Construction
    rule: Rule
    make_points: MakePoints | None = None
    factors: tuple[float, ...] = ()
    start: States | None = None
    begin: float = 0.0
    length: float = 0.0

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """The phase planes."""
        return self.construction.planes

    @cached_property
    def points(self) -> MakePoints:
        """Makes the points."""
        return self.make_points or self.construction.points

    @cached_property
    def rates(self) -> tuple[float, ...]:
        """The rates at which the normals turn on the sheet, rad/s."""
        factors = self.factors or len(self.planes) * (1.0,)
        pairs = zip(self.planes, factors, strict=True)
        return tuple(factor * signed_frequency(plane) for plane, factor in pairs)

    @cached_property
    def numbers(self) -> tuple[str, ...]:
        """The numbers of the planes."""
        return tuple(plane.number for plane in self.planes)

    @cached_property
    def feet(self) -> tuple[str, ...]:
        """The names of the feet of the normals."""
        return tuple(plane.foot for plane in self.planes)

    def step(self, mode: str, states: States, window: Window) -> tuple[Points, States]:
        """Return all points of a step, and the states at its end: the successors P' and the memory.

        Raises
        ------
        OverflowError : if a successor is far off the sheet or not finite.
        ArithmeticError : if the step is too long for the damping.
        """
        numbers, count = self.numbers, len(self.planes)
        moving, memory = states[:count], states[count:]
        turns = [rate * window.duration for rate in self.rates]

        def made(at: States) -> tuple[States, Points]:
            points = self.points(mode, at + memory, window)
            return tuple([points[foot] for foot in self.feet]), points

        def construct(at: States) -> tuple[States, Points]:
            feet, points = made(at)
            self._check_damping(made, at, feet, turns, window)
            return feet, points

        feet, points = construct(moving)
        move = self.rule.move(moving, feet, turns, construct)
        for name, point in move.repeated.items():
            points[name + REPEATED] = point
        for template, found in (*move.helpers.items(), ("P{n}'", move.successors)):
            points.update(zip(_named(template, numbers), found, strict=True))
        vertex = self.construction.protractor
        points["W"] = vertex
        for number, p, d, turn in zip(numbers, moving, feet, turns, strict=True):
            length = abs(p - d)
            points["N" + number] = vertex + length
            points["N" + number + "'"] = vertex + length * exp(1j * abs(turn))
        for plane, successor in zip(self.planes, move.successors, strict=True):
            distance = abs((successor - plane.displacement.origin).real)
            if not isfinite(successor) or (
                distance > _FARTHEST * _LEAST_SIZE
                and distance > _FARTHEST * self._size(mode, states, window)
            ):
                raise OverflowError(
                    f"the state point leaves the paper in the step from {window.start:.4g} s; shorten it"
                )
        return points, move.successors + memory

    def _size(self, mode: str, states: States, window: Window) -> float:
        """Return the size of the motion by what causes it, m of paper: its start and its excitation."""
        if self.start is None:
            return max(self._extent(states), self._excitation(mode, states, window))
        made = max(round((window.start - self.begin) / self.length), 0)
        while len(self._excited) <= made:
            before = self.begin + (len(self._excited) - 1) * self.length
            step = Window.between(before, before + self.length)
            self._excited.append(max(self._excited[-1], self._excitation(mode, states, step)))
        now = self._excitation(mode, states, window)
        return max(self._extent(self.start), self._excited[made], now)

    @cached_property
    def _excited(self) -> list[float]:
        """The excitation up to the start, the end of the first step, ..., as far as it was needed."""
        return [0.0]

    def _excitation(self, mode: str, states: States, window: Window) -> float:
        """Return the excitation as it is seen in the feet of the normals at rest in the origins.

        It is seen with all wheels on the road, too: one that flies now does not see what threw it up.
        """
        origins = [plane.displacement.origin for plane in self.planes]
        at_rest = (*origins, *states[len(origins) :])
        on_the_road = self.construction.mode_at(at_rest, window.end, [False] * len(origins))
        instants = (window, Window(window.end))  # a short step may see a part of what begins
        seen = (self.points(*of) for of in product({mode, on_the_road}, [at_rest], instants))
        return max(self._extent(tuple([points[foot] for foot in self.feet])) for points in seen)

    def _extent(self, found: States) -> float:
        """Return the largest distance of points from the origins of their planes."""
        origins = (plane.displacement.origin for plane in self.planes)
        away = (abs(point - origin) for point, origin in zip(found, origins, strict=False))
        return max(filter(isfinite, away), default=0.0)

    def _check_damping(
        self,
        made: Construct,
        states: States,
        feet: States,
        turns: Sequence[float],
        window: Window,
    ) -> None:
        """Refuse a step in which the damping alone would lead beyond the mirror image of a state."""
        for k, (plane, p, foot) in enumerate(zip(self.planes, states, feet, strict=True)):
            height = (p - plane.displacement.origin).imag
            if not height or abs(turns[k] * (p - foot).real) <= _FOLLOWED * abs(height) + _SEEN:
                continue  # whatever the part of the damping
            level, _ = made((*states[:k], complex(p.real, p.imag - height), *states[k + 1 :]))
            times = turns[k] * (foot - level[k]).real / height
            if (times - _FOLLOWED) * abs(height) > _SEEN:
                raise ArithmeticError(
                    f"a step of {window.duration:.4g} s from {window.start:.6g} s on is too long for the "
                    f"damping in the plane {plane.name}, which would change the velocity by {times:.3g} "
                    f"times its value, where at most {_FOLLOWED:g} times can be followed; try a step of "
                    f"{window.duration / times:.2g} s"
                )

    def way(self, states: States, points: Points, duration: float) -> States:
        """Return the displacements along the tangents in a time, s, and zeros for the memory."""
        feet = [points[foot] for foot in self.feet]
        steps = zip(states, feet, self.rates, strict=False)
        moved = [along_tangent(p, d, rate * duration) for p, d, rate in steps]
        return (*moved, *[0j] * (len(states) - len(moved)))
