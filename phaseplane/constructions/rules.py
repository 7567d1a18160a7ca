"""Step rules: ways to step along the integral curves, and their drawings (AP57 figure 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

from phaseplane.constructions import steps
from phaseplane.constructions.primitives import Arc, Mark, Plane, Scheme, Stroke
from phaseplane.constructions.steps import Construct, Move, States

REPEATED = "~"
"""Suffix of the points' names in a construction that a rule repeats within the step."""


@dataclass(frozen=True, slots=True)
class Rule:
    """A way to step along the integral curves.

    Parameters
    ----------
    name : as in this module
    order : of the error after a given time, in powers of the step
    move : (states, feet, turn angles in rad, construction) -> Move
    stages, marks, strokes, arcs : its drawing; {n} is replaced by a plane's number, {foot} by the
        letter of the foot of its normal; stages count from 0
    repeats : the stage in which the construction is repeated, or None
    """

    name: str
    order: int
    move: Callable[[States, States, Sequence[float], Construct], Move] = field(repr=False)
    stages: tuple[str, ...] = field(repr=False)
    marks: tuple[Mark, ...] = field(default=(), repr=False)
    strokes: tuple[Stroke, ...] = field(default=(), repr=False)
    arcs: tuple[Arc, ...] = field(default=(), repr=False)
    repeats: int | None = field(default=None, repr=False)

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
    steps.tangent,
    ("The lengths of the arcs on the tangents: the successors P'.",),
    (_successor(0),),
    (Stroke(SUCCESSOR, "P{n}", "P{n}'", 0),),
)
"""P' on the tangent at the distance DP dtau (AP57 eq. 8)."""

velocity = Rule(
    "velocity",
    1,
    steps.velocity,
    ("Along the y axis by y-bar dtau: Q'. Above it on the tangents: the successors P'.",),
    (Mark("foot", "Q{n}'", 0, "Q{n}'"), _successor(0)),
    (
        Stroke("construction", "Q{n}", "Q{n}'", 0),
        Stroke("construction", "Q{n}'", "P{n}'", 0),
        Stroke(SUCCESSOR, "P{n}", "P{n}'", 0),
    ),
)
"""P' on the tangent where y has changed by y-bar dtau (AP57 section 3): the point of `tangent`, found
without measuring a normal, unless the tangent is too steep for a clear intersection."""

mean_normal = Rule(
    "mean_normal",
    1,
    steps.mean_normal,
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

auto_mean_normal = replace(
    mean_normal,
    name="auto_mean_normal",
    move=steps.auto_mean_normal,
    stages=(
        _PREDICTION,
        _REPETITION,
        "Where a normal has changed by more than a tenth, on its first tangent a length given by the "
        "mean of both, elsewhere at P'*: the successors P'.",
    ),
)
"""`mean_normal` where the distance DP changes by more than a tenth within the step, `tangent` elsewhere,
as AP57 takes the mean where the difference is too large."""

osculating_circle = Rule(
    "osculating_circle",
    1,
    steps.osculating_circle,
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
)
"""P' on the osculating circle, seen from D under dtau (AP57 figure 4b)."""

midpoint_circle = Rule(
    "midpoint_circle",
    2,
    steps.midpoint_circle,
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
)
"""P' on the circle about S through P, seen from the midpoint of D and D'* under dtau. Not in AP57:
a second-order variant of its osculating circle."""

mean_arc_circle = replace(
    osculating_circle,
    name="mean_arc_circle",
    order=2,
    move=steps.mean_arc_circle,
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
    steps.delta,
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
)
"""P turned about D of the mean state of the step (Jacobsen's delta method, AP57 section 1)."""

RULES: Mapping[str, Rule] = {
    rule.name: rule
    for rule in (
        tangent,
        velocity,
        mean_normal,
        auto_mean_normal,
        osculating_circle,
        midpoint_circle,
        mean_arc_circle,
        delta,
    )
}
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
