"""The sheet: places and values on it, and the turn angles with their scale."""

from __future__ import annotations

from cmath import exp, phase
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, log10

from phaseplane.constructions.primitives import Arc, Axis, Curve, Drawing, Plane, Scheme
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.equations.typeset import number

TURN = ("axis", "construction")
"""The roles of the curves of the turn angles, which may be anywhere on the sheet."""

_ARC = 0.1  # rad between two points of an arc
_FAR = 10.0  # m of paper: radius of an arc that is drawn as its chord
_LEAST_STEP = 1e-300  # any unit: there are powers of ten with all their digits down to 1e-307
_MISSED = 0.02  # of the chord: by how much an arc to the successor may miss it


def plane_at(
    name: str,
    number: str,
    angular_frequency: float,
    origin: complex,
    sense: float,
    scale: float,
    foot: str = "D",
    *,
    label: str = "y",
    unit: str = "m",
) -> Plane:
    """Return a phase plane; its y axis points to the right (sense 1) or left (-1), y-bar upwards."""
    return Plane(
        name,
        angular_frequency,
        Axis(f"{label}{number}", unit, origin, complex(sense), scale),
        Axis(f"{label}{number}'/Ω{number}", unit, origin, 1j, scale),
        f"P{number}",
        f"{foot}{number}",
    )


def state_point(plane: Plane, displacement: float, velocity: float) -> complex:
    """Return P of a displacement, m, and its rate, m/s: y-bar = y' / Omega (AP57 eq. 4)."""
    return plane.at(displacement, velocity / plane.angular_frequency)


def plane_of(planes: Sequence[Plane], point: str) -> Plane:
    """Return the plane in which a point is drawn, by the number in its name; B0 is where B2 would be."""
    name = point.replace("0", "2")
    numbered = [plane for plane in planes if plane.number and plane.number in name]
    return max(numbered, key=lambda plane: len(plane.number), default=planes[0])


def trail(plane: Plane, frames: StoredFrames) -> list[complex]:
    """Return the state points of a plane, including the end of the motion."""
    return [
        *frames.points(plane.state),
        frames[-1].points[plane.state + "'"],
    ]


def arc_points(frame: Frame, arc: Arc) -> list[complex]:
    """Return points of an arc; only its chord if its centre is far off the sheet."""
    centre, start, end = (frame.points[name] for name in (arc.centre, arc.start, arc.end))
    radius, towards = start - centre, end - centre
    if radius == 0.0 or towards == 0.0:
        return [start]
    if abs(radius) > _FAR:
        return [start, end]
    turn = phase(towards / radius)
    count = max(1, ceil(abs(turn) / _ARC))
    return [centre + radius * exp(1j * turn * i / count) for i in range(count + 1)]


def way_of(plane: Plane, scheme: Scheme, frame: Frame) -> list[complex]:
    """Return points of the way from P to P': the arc on which the rule has stepped, or the chord."""
    ends = plane.state, f"{plane.state}'"
    start, end = (frame.points[name] for name in ends)
    for arc in scheme.arcs:
        if (arc.start, arc.end) == ends and arc.centre in frame.points:
            found = arc_points(frame, arc)
            if abs(end - found[-1]) < _MISSED * abs(end - start):  # else the step was cut short
                return [*found[:-1], end]
    return [start, end]


def path_of(
    plane: Plane, schemes: Mapping[str, Scheme], frames: Sequence[Frame]
) -> tuple[complex, ...]:
    """Return points of the integral curve as it is drawn, step after step."""
    ways = (way_of(plane, schemes[frame.scheme], frame) for frame in frames)
    return (*(z for way in ways for z in way[:-1]), frames[-1].points[f"{plane.state}'"])


@dataclass(frozen=True, slots=True)
class Event:
    """An event at the start of a step.

    Parameters
    ----------
    name : `lift_off`, `touchdown` and the like; of one of two axles, such as `front_lift_off`
    kind, axle : the two parts of the name; `axle` is `front_`, `rear_`, or empty if there is only one
    planes : the planes of its axle
    """

    name: str
    kind: str
    axle: str
    planes: tuple[Plane, ...]


def events_of(frame: Frame, planes: Sequence[Plane]) -> list[Event]:
    """Return the events at the start of a frame, one for each axle."""
    found = []
    for name in filter(None, frame.event.split(", ")):
        axle = next((a for a in ("front_", "rear_") if name.startswith(a)), "")
        own = [plane for plane in planes if plane.name.startswith(axle)] or planes
        found.append(Event(name, name.removeprefix(axle), axle, tuple(own)))
    return found


def reach(axis: Axis, points: Iterable[complex]) -> tuple[float, float]:
    """Return the smallest and the largest value of the points on an axis, including zero."""
    values = [axis.read(point) for point in points]
    return min(0.0, *values), max(0.0, *values)


def round_step(span: float, count: int) -> float:
    """Return 1, 2 or 5 times a power of ten that divides a span into about `count` parts.

    Spans below 1e-300, whose powers of ten have too few digits, are not divided.
    """
    rough = max(span / count, _LEAST_STEP)
    decade = 10.0 ** floor(log10(rough))
    return next(s * decade for s in (1.0, 2.0, 5.0, 10.0) if s * decade >= rough * (1.0 - 1e-9))


def longest_normal(planes: Sequence[Plane], frames: StoredFrames) -> float:
    """Return the longest normal of some steps as it is laid off on the arm of the turn angles, m."""
    vertex = frames[0].points["W"]
    return max((z - vertex).real for plane in planes for z in frames.points("N" + plane.number))


def turn_angles(
    planes: Sequence[Plane], vertex: complex, longest: float, step: float
) -> tuple[Curve, ...]:
    """Return the turn angles of all planes on a common arm, divided in centimetres of paper.

    The arc whose radius is a normal is as long as the step along the integral curve (AP57 figures 8
    and 13).

    Parameters
    ----------
    vertex : where the arm begins
    longest : the longest normal that is laid off on it, m
    step : s
    """
    division = round_step(longest or 0.01, 5)
    count = max(1, ceil(longest / division))
    length = (count + 0.4) * division
    tick = 0.02 * length
    scale = [
        Curve(
            "axis",
            (end := vertex + i * division, end - 1j * tick),
            number(100 * i * division) + (" cm" if i == count else ""),
        )
        for i in range(1, count + 1)
    ]
    arms = [
        Curve(
            "construction",
            (vertex, vertex + length * exp(1j * step * plane.angular_frequency)),
            f"dtau{plane.number}",
        )
        for plane in planes
    ]
    return (Curve("axis", (vertex, vertex + length)), *scale, *arms)


def _cut(curve: Curve, low: float) -> Curve:
    """Return an auxiliary curve without its part below a height; others as they are."""
    upwards = curve.vertices[:: 1 if curve.vertices[-1].imag >= curve.vertices[0].imag else -1]
    above = [z for z in upwards if z.imag > low]
    if curve.role != "auxiliary" or len(above) in (0, len(upwards)):
        return curve
    last, first = upwards[-len(above) - 1], above[0]
    end = last + (first - last) * (low - last.imag) / (first - last).imag
    return replace(curve, vertices=(end, *above))


def with_turn_angles_at(
    corner: complex, drawing: Drawing, frames: Iterable[Frame], low: float
) -> tuple[tuple[Curve, ...], Iterator[Frame]]:
    """Return the curves of a drawing and some steps, with the turn angles below and right of a corner.

    Auxiliary curves end at the height `low` above them: a crossing could be taken for a point.
    """
    turning = [z for c in drawing.curves if c.role in TURN for z in c.vertices] or [corner]
    shift = corner - complex(min(z.real for z in turning), max(z.imag for z in turning))
    curves = tuple(
        replace(c, vertices=tuple(z + shift for z in c.vertices))
        if c.role in TURN
        else _cut(c, low)
        for c in drawing.curves
    )
    return curves, (
        replace(f, points={n: z + shift if n[0] in "WN" else z for n, z in f.points.items()})
        for f in frames
    )
