"""Step rules: from the state points and the feet of their normals to the next state points.

Every rule works on any number of coupled planes at once. It is given the state points P, the feet D
of their normals, the signed angles through which the normals turn, and the construction itself, so
that it can be repeated at other state points; all planes are predicted before any is corrected.
The y axes of the planes are parallel to the real axis of the sheet. (AP57 section 3, figure 4.)
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import NamedTuple

from phaseplane.constructions.primitives import Arc, Mark, Scheme, Stroke

States = tuple[complex, ...]
"""One point of the sheet for each plane."""

Points = dict[str, complex]
"""The named points of a construction."""

Construct = Callable[[States], tuple[States, Points]]
"""The construction for the time of one step: feet of the normals, and all its points."""

REPEATED = "~"
"""Ends the names of the points of the construction that a rule repeats within the step."""

_FAR = 1e6  # stands for infinity: a circle of so many normals is a straight line on any sheet
_STEEP = 0.05  # sine of the angle between tangent and y-bar axis below which they cross badly


class Move(NamedTuple):
    """Where a rule goes: the successors P', the points it drew, the construction it repeated.

    `helpers` holds one point for each plane by a name in which {} stands for the plane's number.
    """

    successors: States
    helpers: Mapping[str, States]
    repeated: Points


@dataclass(frozen=True, slots=True)
class Rule:
    """A way to step along the integral curves.

    Parameters
    ----------
    name : as in this module
    order : of the error after a given time, in powers of the step
    move : (states, feet, turn angles in rad, construction) -> Move
    stages, marks, strokes, arcs : how it is drawn; {} stands for a plane's number, stages from 0
    repeats : the stage in which the construction is repeated, if it is
    """

    name: str
    order: int
    move: Callable[[States, States, Sequence[float], Construct], Move] = field(repr=False)
    stages: tuple[str, ...] = field(repr=False)
    marks: tuple[Mark, ...] = field(default=(), repr=False)
    strokes: tuple[Stroke, ...] = field(default=(), repr=False)
    arcs: tuple[Arc, ...] = field(default=(), repr=False)
    repeats: int | None = field(default=None, repr=False)

    def drawn_after(self, scheme: Scheme, numbers: Sequence[str]) -> Scheme:
        """The scheme of a construction with the stages of this rule for the planes so numbered."""
        first = len(scheme.stages)
        again = () if self.repeats is None else tuple(
            Stroke("construction", s.start + REPEATED, s.end + REPEATED, first + self.repeats)
            for s in scheme.strokes
            if s.role in ("construction", "projection", "excitation")
        )  # fmt: skip
        return Scheme(
            scheme.stages + self.stages,
            scheme.marks
            + tuple(
                replace(m, point=m.point.format(n), label=m.label.format(n), stage=first + m.stage)
                for m in self.marks
                for n in numbers
            ),
            scheme.strokes
            + again
            + tuple(
                replace(s, start=s.start.format(n), end=s.end.format(n), stage=first + s.stage)
                for s in self.strokes
                for n in numbers
            ),
            scheme.arcs
            + tuple(
                replace(
                    a,
                    centre=a.centre.format(n),
                    start=a.start.format(n),
                    end=a.end.format(n),
                    stage=first + a.stage,
                )
                for a in self.arcs
                for n in numbers
            ),
        )


def turned(point: complex, centre: complex, angle: float) -> complex:
    """The point turned about a centre, anticlockwise for a positive angle (rad)."""
    return centre + (point - centre) * exp(1j * angle)


def at_height(start: complex, end: complex, height: float) -> complex:
    """Where the line through two points crosses the parallel to the real axis at a height."""
    way = end - start
    return complex(start.real + way.real * (height - start.imag) / way.imag, height)


def meet(a: complex, b: complex, c: complex, d: complex) -> complex | None:
    """Where the lines ab and cd cross; None where they are parallel."""
    one, other = b - a, d - c
    sine = (one.conjugate() * other).imag
    if abs(sine) <= 1e-12 * abs(one) * abs(other):
        return None
    return a + one * (((c - a).conjugate() * other).imag / sine)


def _tangent(state: complex, foot: complex, turn: float) -> complex:
    """The way along the tangent that is as long as the normal times the angle (AP57 eq. 8)."""
    return 1j * turn * (state - foot)


def _seen(eye: complex, centre: complex, state: complex, turn: float) -> complex | None:
    """The point of the circle about `centre` through `state` that is seen from `eye` under `turn`.

    Of two such points the one nearer to `state`; None where the ray misses the circle.
    """
    ray = exp(1j * turn) * (state - eye)
    if ray == 0.0:
        return None
    ray /= abs(ray)
    offset = (centre - eye) / ray  # in the frame of the ray: along it, and across
    under_root = abs(state - centre) ** 2 - offset.imag**2
    if under_root < 0.0:
        return None
    half_chord = sqrt(under_root)
    ends = (eye + ray * (offset.real + side * half_chord) for side in (-1.0, 1.0))
    return min(ends, key=lambda end: abs(end - state))


def _move_tangent(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    steps = zip(states, feet, turns, strict=True)
    return Move(tuple([p + _tangent(p, d, turn) for p, d, turn in steps]), {}, {})


def _move_velocity(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    """Q' at y + y-bar dtau; P' where the tangent crosses the parallel to the y-bar axis there."""
    successors, marks = [], []
    for p, d, turn in zip(states, feet, turns, strict=True):
        normal = p - d
        shift = -turn * normal.imag
        q = complex(p.real + shift, d.imag)
        crossing = None
        if abs(normal.imag) > _STEEP * abs(normal):
            crossing = meet(p, p + 1j * normal, q, q + 1j)
        successors.append(p + _tangent(p, d, turn) if crossing is None else crossing)
        marks.append(q)
    return Move(tuple(successors), {"Q{}'": tuple(marks)}, {})


def _move_mean_normal(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    predicted, _, _ = _move_tangent(states, feet, turns, construct)
    new_feet, repeated = construct(predicted)
    successors = []
    for p, d, p_new, d_new, turn in zip(states, feet, predicted, new_feet, turns, strict=True):
        length = abs(p - d)
        share = 0.5 * (1.0 + abs(p_new - d_new) / length) if length > 0.0 else 1.0
        successors.append(p + share * _tangent(p, d, turn))
    return Move(tuple(successors), {}, repeated)


def _circle_about(p: complex, d: complex, p_new: complex, d_new: complex) -> complex | None:
    """The centre S of the osculating circle: where the normals of P and P'* cross (figure 4b)."""
    if p == d or p_new == d_new:
        return None
    return meet(p, d, p_new, d_new)


def _move_osculating_circle(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    predicted, _, _ = _move_tangent(states, feet, turns, construct)
    new_feet, repeated = construct(predicted)
    successors, centres = [], []
    for p, d, p_new, d_new, turn in zip(states, feet, predicted, new_feet, turns, strict=True):
        centre = _circle_about(p, d, p_new, d_new)
        seen = None if centre is None else _seen(d, centre, p, turn)
        if centre is None or seen is None:
            centre, seen = p + _FAR * (d - p), p_new
        successors.append(seen)
        centres.append(centre)
    return Move(tuple(successors), {"S{}": tuple(centres)}, repeated)


def _move_midpoint_circle(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    predicted, _, _ = _move_tangent(states, feet, turns, construct)
    new_feet, repeated = construct(predicted)
    successors, centres, eyes = [], [], []
    for p, d, p_new, d_new, turn in zip(states, feet, predicted, new_feet, turns, strict=True):
        eye = 0.5 * (d + d_new)
        centre = _circle_about(p, d, p_new, d_new)
        seen = None if centre is None else _seen(eye, centre, p, turn)
        if centre is None or seen is None:
            centre, seen = eye, turned(p, eye, turn)
        successors.append(seen)
        centres.append(centre)
        eyes.append(eye)
    return Move(tuple(successors), {"S{}": tuple(centres), "E{}": tuple(eyes)}, repeated)


def _move_delta(states: States, feet: States, turns: Sequence[float], construct: Construct) -> Move:
    """The mean state lies on the arc about D, half the turn angle on."""
    middle = tuple([turned(p, d, 0.5 * t) for p, d, t in zip(states, feet, turns, strict=True)])
    mean_feet, repeated = construct(middle)
    steps = zip(states, mean_feet, turns, strict=True)
    return Move(tuple([turned(p, d, turn) for p, d, turn in steps]), {}, repeated)


_SUCCESSOR = "successor"
_PREDICTED = (
    Mark("construction", "P{}~", 0, "P{}'*"),
    Mark("construction", "D{}~", 1, "D{}'*"),
)
_PREDICTION = "On the tangents, as far as the arcs are long: the predicted points P'*."
_REPETITION = "The construction repeated at P'*: the feet D'* of the new normals."
_NEW_NORMAL = Stroke("construction", "D{}~", "P{}~", 1)

tangent = Rule(
    "tangent",
    1,
    _move_tangent,
    ("On the tangents, as far as the arcs are long: the successors P'.",),
    (Mark(_SUCCESSOR, "P{}'", 0, "P{}'"),),
    (Stroke(_SUCCESSOR, "P{}", "P{}'", 0),),
)
"""P' on the tangent at the distance |DP| dtau (AP57 eq. 8)."""

velocity = Rule(
    "velocity",
    1,
    _move_velocity,
    ("Along the y axis by y-bar dtau: Q'. Above it on the tangents: the successors P'.",),
    (Mark("foot", "Q{}'", 0, "Q{}'"), Mark(_SUCCESSOR, "P{}'", 0, "P{}'")),
    (
        Stroke("construction", "Q{}", "Q{}'", 0),
        Stroke("construction", "Q{}'", "P{}'", 0),
        Stroke(_SUCCESSOR, "P{}", "P{}'", 0),
    ),
)
"""P' on the tangent where y has changed by y-bar dtau (AP57 section 3): the point of `tangent`,
found without measuring a normal, except where the tangent is too steep to be cut well."""

mean_normal = Rule(
    "mean_normal",
    1,
    _move_mean_normal,
    (
        _PREDICTION,
        _REPETITION,
        "On the first tangents, as far as the mean of both normals wants: the successors P'.",
    ),
    (*_PREDICTED, Mark(_SUCCESSOR, "P{}'", 2, "P{}'")),
    (
        Stroke("construction", "P{}", "P{}~", 0),
        _NEW_NORMAL,
        Stroke(_SUCCESSOR, "P{}", "P{}'", 2),
    ),
    repeats=1,
)
"""P' on the tangent at the mean of |DP| and |D'*P'*| times dtau (AP57 figure 4a)."""

osculating_circle = Rule(
    "osculating_circle",
    1,
    _move_osculating_circle,
    (
        _PREDICTION,
        _REPETITION,
        "The normals cross in S: the centre of the osculating circle through P.",
        "The points of the circles that are seen from D under the turn angle: the successors P'.",
    ),
    (
        *_PREDICTED,
        Mark("construction", "S{}", 2, "S{}"),
        Mark(_SUCCESSOR, "P{}'", 3, "P{}'"),
    ),
    (
        Stroke("construction", "P{}", "P{}~", 0),
        _NEW_NORMAL,
        Stroke("construction", "D{}", "P{}'", 3),
    ),
    (Arc("arc", "S{}", "P{}", "P{}'", 3),),
    repeats=1,
)
"""P' on the osculating circle, seen from D under dtau (AP57 figure 4b)."""

midpoint_circle = Rule(
    "midpoint_circle",
    2,
    _move_midpoint_circle,
    (
        _PREDICTION,
        _REPETITION,
        "The normals cross in S: the centre of the circle through P. Midway between D and D'*: E.",
        "The points of the circles that are seen from E under the turn angle: the successors P'.",
    ),
    (
        *_PREDICTED,
        Mark("construction", "S{}", 2, "S{}"),
        Mark("construction", "E{}", 2, "E{}"),
        Mark(_SUCCESSOR, "P{}'", 3, "P{}'"),
    ),
    (
        Stroke("construction", "P{}", "P{}~", 0),
        _NEW_NORMAL,
        Stroke("construction", "E{}", "P{}", 3),
        Stroke("construction", "E{}", "P{}'", 3),
    ),
    (Arc("arc", "S{}", "P{}", "P{}'", 3),),
    repeats=1,
)
"""P' on the circle about S through P, seen from the midpoint of D and D'* under dtau. Not AP57's:
a variant of its osculating circle that is of second order."""

delta = Rule(
    "delta",
    2,
    _move_delta,
    (
        "P turned about D by half the turn angle: the mean state M of the step.",
        "The construction repeated at M: the mean foot Dm.",
        "P turned about Dm by the turn angle: the successor P'.",
    ),
    (
        Mark("construction", "P{}~", 0, "M{}"),
        Mark("construction", "D{}~", 1, "Dm{}"),
        Mark(_SUCCESSOR, "P{}'", 2, "P{}'"),
    ),
    (
        Stroke("construction", "D{}~", "P{}", 2),
        Stroke("construction", "D{}~", "P{}'", 2),
    ),
    (Arc("construction", "D{}", "P{}", "P{}~", 0), Arc("arc", "D{}~", "P{}", "P{}'", 2)),
    repeats=1,
)
"""P turned about D of the mean state of the step (Jacobsen's delta method, AP57 section 1)."""

RULES: Mapping[str, Rule] = {
    rule.name: rule
    for rule in (tangent, mean_normal, osculating_circle, velocity, delta, midpoint_circle)
}
"""All rules by name."""


def rule_named(name: str) -> Rule:
    """The rule of that name.

    Raises
    ------
    ValueError : no such rule; the message lists them all.
    """
    try:
        return RULES[name]
    except KeyError:
        raise ValueError(f"rule {name!r} is not known; there are {', '.join(RULES)}") from None
