"""What stays on the sheet: auxiliary curves, lines and the turn angles with their scale."""

from __future__ import annotations

from cmath import exp
from collections.abc import Callable, Iterable, Sequence
from math import ceil, floor, log10

from phaseplane.constructions.primitives import Axis, Curve, Frame, Plane

_POINTS = 64  # of an auxiliary curve, an even number so that y-bar = 0 is one of them


def state_point(plane: Plane, displacement: float, velocity: float) -> complex:
    """P of a displacement, m, and its rate, m/s: y-bar = y' / Omega (AP57 eq. 4)."""
    foot = plane.displacement.at(displacement)
    axis = plane.scaled_velocity
    return foot + axis.direction * axis.scale * velocity / plane.angular_frequency


def trail(plane: Plane, frames: Sequence[Frame]) -> list[complex]:
    """The state points of a plane, with the end of the motion."""
    return [
        *(frame.points[plane.state] for frame in frames),
        frames[-1].points[plane.state + "'"],
    ]


def reach(axis: Axis, points: Iterable[complex]) -> tuple[float, float]:
    """Smallest and largest value on an axis among the points; zero is always included."""
    values = [axis.read(point) for point in points]
    return min(0.0, *values), max(0.0, *values)


def round_step(span: float, count: int) -> float:
    """1, 2 or 5 times a power of ten that divides a span into about so many parts."""
    rough = span / count
    decade = 10.0 ** floor(log10(rough))
    return next(s * decade for s in (1.0, 2.0, 5.0, 10.0) if s * decade >= rough * (1.0 - 1e-9))


def auxiliary_curves(
    plane: Plane,
    epsilon: Callable[[float, float], float],
    frames: Sequence[Frame],
    corners: Sequence[float] = (),
) -> tuple[Curve, ...]:
    """The family y = -epsilon(y-bar; y_i) for round values of y_i (AP57 section 3).

    Parameters
    ----------
    epsilon : of y-bar and y, m
    corners : values of y-bar at which the curves bend, m

    Returns
    -------
    one curve without a label where epsilon does not depend on y
    """
    points = trail(plane, frames)
    low, high = reach(plane.scaled_velocity, points)
    largest = 1.1 * max(-low, high) or 0.01
    grid = {largest * (2 * i / _POINTS - 1) for i in range(_POINTS + 1)}
    levels = sorted(grid | {c for c in corners if abs(c) < largest})

    def curve(y: float) -> tuple[complex, ...]:
        y_bar = plane.scaled_velocity
        return tuple(
            plane.displacement.at(-epsilon(v, y)) + y_bar.direction * y_bar.scale * v
            for v in levels
        )

    least, most = reach(plane.displacement, points)
    interval = round_step((most - least) or 0.01, 5)
    values = [interval * i for i in range(floor(least / interval), ceil(most / interval) + 1)]
    family = [curve(y) for y in values]
    apart = max(abs(p - q) for other in family for p, q in zip(family[0], other, strict=True))
    if apart <= 1e-9 * abs(family[0][-1] - family[0][0]):
        return (Curve("auxiliary", family[0]),)
    label = plane.displacement.label
    return tuple(
        Curve("auxiliary", vertices, f"{label} = {100.0 * y:g} cm")
        for vertices, y in zip(family, values, strict=True)
    )


def turn_angles(planes: Sequence[Plane], frames: Sequence[Frame], step: float) -> tuple[Curve, ...]:
    """The turn angles of all planes on a common arm, which is divided in centimetres of paper.

    The arc whose radius is a normal is as long as the way along the integral curve (AP57 figures 8
    and 13).
    """
    vertex = frames[0].points["W"]
    numbers = [plane.state[1:] for plane in planes]
    longest = max(frame.points["N" + n].real for frame in frames for n in numbers) - vertex.real
    division = round_step(longest or 0.01, 5)
    count = max(1, ceil(longest / division))
    length = (count + 0.4) * division
    tick = 0.02 * length
    scale = [
        Curve(
            "axis",
            (end := vertex + i * division, end - 1j * tick),
            f"{100 * i * division:g}" + (" cm" if i == count else ""),
        )
        for i in range(1, count + 1)
    ]
    arms = [
        Curve(
            "construction",
            (vertex, vertex + length * exp(1j * step * plane.angular_frequency)),
            f"dtau{number}",
        )
        for plane, number in zip(planes, numbers, strict=True)
    ]
    return (Curve("axis", (vertex, vertex + length)), *scale, *arms)
