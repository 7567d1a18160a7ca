"""Step rules: ways to step along the integral curves, and their drawings (AP57 figure 4).

Every rule works on any number of coupled planes at once: where it repeats the construction within the
step, all planes are predicted before any is corrected.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import copysign, sin
from typing import TypeVar

from phaseplane.constructions.geometry import seen, turned
from phaseplane.constructions.primitives import Arc, Mark, Plane, Scheme, Stroke
from phaseplane.constructions.steps import Construct, Move, Points, States, Step, along_tangent

REPEATED = "~"
"""Suffix of the points' names in a construction that a rule repeats within the step."""

_TOO_DIFFERENT = 0.1  # relative change of a normal above which the mean of both is taken


def _end_of_tangent(p: complex, d: complex, turn: float) -> complex:
    return p + along_tangent(p, d, turn)


@dataclass(frozen=True, slots=True)
class Rule:
    """A way to step along the integral curves.

    Parameters
    ----------
    name : as in this module
    order : of the error after a given time, in powers of the step
    end : the successor P' of a step in one plane, and the points that help to find it
    helpers : their names; {n} is replaced by the plane's number
    predicted : where the construction is repeated, from P, D and the turn angle
    stages, marks, strokes, arcs : its drawing; {n} is replaced by a plane's number, {foot} by the
        letter of the foot of its normal; stages count from 0
    repeats : the stage in which the construction is repeated, or None
    """

    name: str
    order: int
    end: Callable[[Step], tuple[complex, ...]] = field(repr=False)
    stages: tuple[str, ...] = field(repr=False)
    marks: tuple[Mark, ...] = field(default=(), repr=False)
    strokes: tuple[Stroke, ...] = field(default=(), repr=False)
    arcs: tuple[Arc, ...] = field(default=(), repr=False)
    repeats: int | None = field(default=None, repr=False)
    helpers: tuple[str, ...] = field(default=(), repr=False)
    predicted: Callable[[complex, complex, float], complex] = field(
        default=_end_of_tangent, repr=False
    )

    def move(
        self, states: States, feet: States, turns: Sequence[float], construct: Construct
    ) -> Move:
        """Return a step in all planes.

        Parameters
        ----------
        states, feet : the state points P and the feet D of their normals
        turns : the signed angles through which the normals turn, rad
        construct : repeats the construction at other state points
        """
        ends, new_feet = states, feet
        repeated: Points = {}
        if self.repeats is not None:
            ends = tuple(map(self.predicted, states, feet, turns))
            new_feet, repeated = construct(ends)
        steps = map(Step, states, feet, turns, ends, new_feet)
        successors, *helpers = zip(*map(self.end, steps), strict=True)
        return Move(successors, dict(zip(self.helpers, helpers, strict=True)), repeated)

    def drawn_after(self, scheme: Scheme, planes: Sequence[Plane]) -> Scheme:
        """Return the scheme of a construction followed by the stages of this rule in these planes."""
        if any(mark.role == SUCCESSOR for mark in scheme.marks):  # rest: there is no step
            return scheme
        first = len(scheme.stages)
        again = () if self.repeats is None else tuple(
            Stroke("construction", s.start + REPEATED, s.end + REPEATED, first + self.repeats)
            for s in scheme.strokes
            if s.role in ("construction", "projection", "excitation")
        )  # fmt: skip
        return Scheme(
            scheme.stages + tuple(_named(words, planes[0]) for words in self.stages),
            scheme.marks + _placed(self.marks, first, planes),
            scheme.strokes + again + _placed(self.strokes, first, planes),
            scheme.arcs + _placed(self.arcs, first, planes),
        )


Part = TypeVar("Part", Mark, Stroke, Arc)


def _placed(parts: Sequence[Part], first: int, planes: Sequence[Plane]) -> tuple[Part, ...]:
    """Return the parts for each plane, with stages counted from `first`."""
    return tuple(
        replace(
            part,
            stage=first + part.stage,
            **{
                key: _named(getattr(part, key), plane)
                for key in ("point", "label", "centre", "start", "end")
                if hasattr(part, key)
            },
        )
        for part in parts
        for plane in planes
    )


def _named(template: str, plane: Plane) -> str:
    return template.format(n=plane.number, foot=plane.foot[0])


SUCCESSOR = "successor"
"""The role of the points at which steps end."""

_PREDICTED = (
    Mark("construction", "P{n}~", 0, "P{n}'*"),
    Mark("construction", "{foot}{n}~", 1, "{foot}{n}'*"),
)
_PREDICTION = "The lengths of the arcs on the tangents: the predicted points P'*."
_REPETITION = "The construction repeated at P'*: the feet {foot}'* of the new normals."
_ON_TANGENT = Stroke("construction", "P{n}", "P{n}~", 0)
_NEW_NORMAL = Stroke("construction", "{foot}{n}~", "P{n}~", 1)
_ON_CIRCLE = Arc("arc", "S{n}", "P{n}", "P{n}'", 3)
_CENTRE = Mark("construction", "S{n}", 2, "S{n}")


def _successor(stage: int) -> Mark:
    return Mark(SUCCESSOR, "P{n}'", stage, "P{n}'")


tangent = Rule(
    "tangent",
    1,
    lambda step: (step.p + step.along_tangent,),
    ("The lengths of the arcs on the tangents: the successors P'.",),
    (_successor(0),),
    (Stroke(SUCCESSOR, "P{n}", "P{n}'", 0),),
)
"""P' on the tangent at the distance DP dtau (AP57 eq. 8)."""


def _above_q(step: Step) -> tuple[complex, complex]:
    """P' where the tangent crosses the parallel to the y-bar axis through Q', and Q'."""
    end = step.p + step.along_tangent
    return end, complex(end.real, step.d.imag)


velocity = Rule(
    "velocity",
    1,
    _above_q,
    ("Along the y axis by y-bar dtau: Q'. Above it on the tangents: the successors P'.",),
    (Mark("foot", "Q{n}'", 0, "Q{n}'"), _successor(0)),
    (
        Stroke("construction", "Q{n}", "Q{n}'", 0),
        Stroke("construction", "Q{n}'", "P{n}'", 0),
        Stroke(SUCCESSOR, "P{n}", "P{n}'", 0),
    ),
    helpers=("Q{n}'",),
)
"""P' on the tangent where y has changed by y-bar dtau (AP57 section 3): the point of `tangent`, found
without measuring a normal."""

mean_normal = Rule(
    "mean_normal",
    1,
    lambda step: (step.p + step.mean_share * step.along_tangent,),
    (
        _PREDICTION,
        _REPETITION,
        "On the first tangents, a length given by the mean of both normals: the successors P'.",
    ),
    (*_PREDICTED, _successor(2)),
    (_ON_TANGENT, _NEW_NORMAL, Stroke(SUCCESSOR, "P{n}", "P{n}'", 2)),
    repeats=1,
)
"""P' on the tangent at the mean of the distances DP and `D'*P'*`, times dtau (AP57 figure 4a)."""


def _by_their_difference(step: Step) -> tuple[complex]:
    share = step.mean_share
    differ = abs(2.0 * (share - 1.0)) > _TOO_DIFFERENT
    return (step.p + share * step.along_tangent if differ else step.p_new,)


auto_mean_normal = replace(
    mean_normal,
    name="auto_mean_normal",
    end=_by_their_difference,
    stages=(
        _PREDICTION,
        _REPETITION,
        "Where a normal has changed by more than a tenth, on its first tangent a length given by the "
        "mean of both, elsewhere at P'*: the successors P'.",
    ),
)
"""`mean_normal` where the distance DP changes by more than a tenth within the step, `tangent` elsewhere,
as AP57 takes the mean where the difference is too large."""


def _seen_from_d(step: Step) -> tuple[complex, complex]:
    """P' and S; the tangent where there is no circle."""
    return _on_circle(step, step.d) or (step.p_new, step.far_centre)


def _seen_from_midway(step: Step) -> tuple[complex, complex, complex]:
    """P', S and E, midway between both feet."""
    eye = 0.5 * (step.d + step.d_new)
    return (*(_on_circle(step, eye) or (turned(step.p, eye, step.turn), eye)), eye)


def _on_circle(step: Step, eye: complex) -> tuple[complex, complex] | None:
    """Return P' on the circle about S seen from an eye under the turn angle, and S."""
    centre = step.centre
    end = None if centre is None else seen(eye, centre, step.p, step.turn)
    return None if centre is None or end is None else (end, centre)


def _by_mean_arc(step: Step) -> tuple[complex, complex]:
    """P' at an arc from P given by the mean of both normals, and S."""
    centre = step.centre
    if centre is None:
        centre = step.far_centre
    radius = step.p - centre
    if radius == 0.0:
        return step.p_new, centre
    normal = step.p - step.d
    inwards = (radius * normal.conjugate()).real  # negative where S lies beyond P
    angle = copysign(step.mean_share * abs(normal) / abs(radius), inwards) * step.turn
    # the chord, which is accurate for any distance of the centre
    return step.p + 2j * sin(0.5 * angle) * exp(0.5j * angle) * radius, centre


osculating_circle = Rule(
    "osculating_circle",
    1,
    _seen_from_d,
    (
        _PREDICTION,
        _REPETITION,
        "The normals cross in S: the centre of the osculating circle through P.",
        "The points of the circles that are seen from {foot} under the turn angle: the successors "
        "P'.",
    ),
    (*_PREDICTED, _CENTRE, _successor(3)),
    (_ON_TANGENT, _NEW_NORMAL, Stroke("construction", "{foot}{n}", "P{n}'", 3)),
    (_ON_CIRCLE,),
    repeats=1,
    helpers=("S{n}",),
)
"""P' on the osculating circle, seen from D under dtau (AP57 figure 4b)."""

midpoint_circle = Rule(
    "midpoint_circle",
    2,
    _seen_from_midway,
    (
        _PREDICTION,
        _REPETITION,
        "The normals cross in S: the centre of the circle through P. Midway between {foot} and "
        "{foot}'*: E.",
        "The points of the circles that are seen from E under the turn angle: the successors P'.",
    ),
    (*_PREDICTED, _CENTRE, Mark("construction", "E{n}", 2, "E{n}"), _successor(3)),
    (
        _ON_TANGENT,
        _NEW_NORMAL,
        Stroke("construction", "E{n}", "P{n}", 3),
        Stroke("construction", "E{n}", "P{n}'", 3),
    ),
    (_ON_CIRCLE,),
    repeats=1,
    helpers=("S{n}", "E{n}"),
)
"""P' on the circle about S through P, seen from the midpoint of D and D'* under dtau. Not in AP57:
a second-order variant of its osculating circle."""

mean_arc_circle = replace(
    osculating_circle,
    name="mean_arc_circle",
    order=2,
    end=_by_mean_arc,
    stages=(
        *osculating_circle.stages[:3],
        "On the circles, an arc given by the mean of both normals: the successors P'.",
    ),
    strokes=(_ON_TANGENT, _NEW_NORMAL),
)
"""P' on the circle about S through P, the arc PP' being the mean of the distances DP and `D'*P'*`, times
dtau. Not in AP57: the other second-order variant of its osculating circle."""

delta = Rule(
    "delta",
    2,
    lambda step: (turned(step.p, step.d_new, step.turn),),
    (
        "P turned about {foot} by half the turn angle: the mean state M of the step.",
        "The construction repeated at M: the mean foot {foot}m.",
        "P turned about {foot}m by the turn angle: the successor P'.",
    ),
    (
        Mark("construction", "P{n}~", 0, "M{n}"),
        Mark("construction", "{foot}{n}~", 1, "{foot}m{n}"),
        _successor(2),
    ),
    (
        Stroke("construction", "{foot}{n}~", "P{n}", 2),
        Stroke("construction", "{foot}{n}~", "P{n}'", 2),
    ),
    (
        Arc("construction", "{foot}{n}", "P{n}", "P{n}~", 0),
        Arc("arc", "{foot}{n}~", "P{n}", "P{n}'", 2),
    ),
    repeats=1,
    predicted=lambda p, d, turn: turned(p, d, 0.5 * turn),
)
"""P turned about D of the mean state of the step (Jacobsen's delta method, AP57 section 1)."""

RULES: Mapping[str, Rule] = {
    rule.name: rule
    for rule in (
        tangent, velocity, mean_normal, auto_mean_normal, osculating_circle, midpoint_circle,
        mean_arc_circle, delta,
    )
}  # fmt: skip
"""All rules by name."""


def rule_named(name: str) -> Rule:
    """Return the rule of that name.

    Raises
    ------
    ValueError : if there is no such rule; the message lists all rules.
    """
    try:
        return RULES[name]
    except KeyError:
        raise ValueError(f"rule {name!r} is unknown; rules are {', '.join(RULES)}") from None
