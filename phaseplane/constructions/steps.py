"""Steps from the state points and the feet of their normals to the next state points.

Every step works on any number of coupled planes at once. Its arguments are the state points P, the
feet D of their normals, the signed angles through which the normals turn, and the construction, which
can be repeated at other state points. All planes are predicted before any is corrected.
The y axes of the planes are parallel to the real axis of the sheet. (AP57 section 3, figure 4.)
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Callable, Mapping, Sequence
from math import copysign, sin
from typing import NamedTuple

from phaseplane.constructions.geometry import meet, seen, turned

States = tuple[complex, ...]
"""One point of the sheet for each plane."""

Points = dict[str, complex]
"""The named points of a construction."""

Construct = Callable[[States], tuple[States, Points]]
"""The construction for the time of one step: feet of the normals, and all its points."""

_FAR = 1e6  # normals; a circle of this radius is a straight line on any sheet
_STEEP = 0.05  # sine of the angle between tangent and y-bar axis below which they are near parallel
_TOO_DIFFERENT = 0.1  # relative change of a normal above which the mean of both is taken


class Move(NamedTuple):
    """The result of a step: the successors P', auxiliary points, the repeated construction.

    `helpers` has one point for each plane by a name in which {n} is the plane's number.
    """

    successors: States
    helpers: Mapping[str, States]
    repeated: Points


class Prediction(NamedTuple):
    """P, its foot D and turn angle; the predicted P'* and its foot D'*."""

    p: complex
    d: complex
    turn: float
    p_new: complex
    d_new: complex

    @property
    def mean_share(self) -> float:
        """Mean of both normals, relative to the first."""
        length = abs(self.p - self.d)
        return 0.5 * (1.0 + abs(self.p_new - self.d_new) / length) if length > 0.0 else 1.0

    @property
    def centre(self) -> complex | None:
        """The centre S of the osculating circle: where both normals cross (AP57 figure 4b)."""
        if self.p == self.d or self.p_new == self.d_new:
            return None
        return meet(self.p, self.d, self.p_new, self.d_new)


def along_tangent(state: complex, foot: complex, turn: float) -> complex:
    """Return the step along the tangent, as long as the normal times the angle (AP57 eq. 8)."""
    return 1j * turn * (state - foot)


def tangent(states: States, feet: States, turns: Sequence[float], construct: Construct) -> Move:
    """P' on the tangent."""
    steps = zip(states, feet, turns, strict=True)
    return Move(tuple([p + along_tangent(p, d, turn) for p, d, turn in steps]), {}, {})


def _predicted(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> tuple[list[Prediction], Points]:
    """Predict the ends of the tangents in all planes, and repeat the construction there."""
    ends, _, _ = tangent(states, feet, turns, construct)
    new_feet, repeated = construct(ends)
    planes = zip(states, feet, turns, ends, new_feet, strict=True)
    return [Prediction(*plane) for plane in planes], repeated


def velocity(states: States, feet: States, turns: Sequence[float], construct: Construct) -> Move:
    """Q' at y + y-bar dtau; P' where the tangent crosses the parallel to the y-bar axis there."""
    successors, marks = [], []
    for p, d, turn in zip(states, feet, turns, strict=True):
        normal = p - d
        shift = -turn * normal.imag
        q = complex(p.real + shift, d.imag)
        crossing = None
        if abs(normal.imag) > _STEEP * abs(normal):
            crossing = meet(p, p + 1j * normal, q, q + 1j)
        successors.append(p + along_tangent(p, d, turn) if crossing is None else crossing)
        marks.append(q)
    return Move(tuple(successors), {"Q{n}'": tuple(marks)}, {})


def mean_normal(states: States, feet: States, turns: Sequence[float], construct: Construct) -> Move:
    """P' on the tangent, at a distance given by the mean of both normals."""
    predictions, repeated = _predicted(states, feet, turns, construct)
    ends = [s.p + s.mean_share * along_tangent(s.p, s.d, s.turn) for s in predictions]
    return Move(tuple(ends), {}, repeated)


def auto_mean_normal(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    """P' on the tangent; the mean of both normals where they differ too much."""
    predictions, repeated = _predicted(states, feet, turns, construct)
    shares = [s.mean_share for s in predictions]
    ends = [
        s.p + share * along_tangent(s.p, s.d, s.turn)
        if abs(2.0 * (share - 1.0)) > _TOO_DIFFERENT
        else s.p_new
        for s, share in zip(predictions, shares, strict=True)
    ]
    return Move(tuple(ends), {}, repeated)


def osculating_circle(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    """P' on the circle about S, seen from D; the tangent where there is no circle."""
    predictions, repeated = _predicted(states, feet, turns, construct)
    found = [_on_circle(step, step.d, (_far_centre(step), step.p_new)) for step in predictions]
    centres, successors = zip(*found, strict=True)
    return Move(successors, {"S{n}": centres}, repeated)


def midpoint_circle(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    """P' on the circle about S, seen from midway between both feet."""
    predictions, repeated = _predicted(states, feet, turns, construct)
    eyes = tuple([0.5 * (step.d + step.d_new) for step in predictions])
    found = [
        _on_circle(step, eye, (eye, turned(step.p, eye, step.turn)))
        for step, eye in zip(predictions, eyes, strict=True)
    ]
    centres, successors = zip(*found, strict=True)
    return Move(successors, {"S{n}": centres, "E{n}": eyes}, repeated)


def _on_circle(
    step: Prediction, eye: complex, otherwise: tuple[complex, complex]
) -> tuple[complex, complex]:
    """Return S, and P' on the circle about it seen from an eye; `otherwise` where there is none."""
    centre = step.centre
    end = None if centre is None else seen(eye, centre, step.p, step.turn)
    return otherwise if centre is None or end is None else (centre, end)


def mean_arc_circle(
    states: States, feet: States, turns: Sequence[float], construct: Construct
) -> Move:
    """P' on the circle about S, at an arc from P given by the mean of both normals."""
    predictions, repeated = _predicted(states, feet, turns, construct)
    successors, centres = [], []
    for step in predictions:
        centre = step.centre
        if centre is None:
            centre = _far_centre(step)
        radius = step.p - centre
        if radius == 0.0:
            successors.append(step.p_new)
        else:
            normal = step.p - step.d
            inwards = (radius * normal.conjugate()).real  # negative where S lies beyond P
            length = step.mean_share * abs(normal) * step.turn
            angle = copysign(1.0, inwards) * length / abs(radius)
            # the chord, which is accurate for any distance of the centre
            successors.append(step.p + 2j * sin(0.5 * angle) * exp(0.5j * angle) * radius)
        centres.append(centre)
    return Move(tuple(successors), {"S{n}": tuple(centres)}, repeated)


def _far_centre(step: Prediction) -> complex:
    return step.p + _FAR * (step.d - step.p)


def delta(states: States, feet: States, turns: Sequence[float], construct: Construct) -> Move:
    """P turned about D of the mean state, which is half the turn angle ahead on the arc about D."""
    middle = tuple([turned(p, d, 0.5 * t) for p, d, t in zip(states, feet, turns, strict=True)])
    mean_feet, repeated = construct(middle)
    steps = zip(states, mean_feet, turns, strict=True)
    return Move(tuple([turned(p, d, turn) for p, d, turn in steps]), {}, repeated)
