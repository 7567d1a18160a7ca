"""Several integral curves on one sheet: the construction from one start, the curves from others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

from phaseplane.constructions.equation import EquationPlane
from phaseplane.constructions.primitives import Curve, Drawing
from phaseplane.constructions.rules import Rule, delta
from phaseplane.constructions.sheet import path_of, reach, trail
from phaseplane.constructions.step_loop import construct_motion
from phaseplane.constructions.storage import StoredFrames
from phaseplane.equations.typeset import number


def family(
    construction: EquationPlane,
    starts: Sequence[tuple[float, float]],
    rule: Rule = delta,
    *,
    step: float,
    duration: float,
) -> Drawing:
    """Make a construction, and on its sheet the integral curves from other starts by the same steps.

    Parameters
    ----------
    starts : x and x' of the other starts
    rule, step, duration : as of `construct_motion`

    Raises
    ------
    StepError, ValueError, ArithmeticError : as of `construct_motion`.
    """
    every: list[Drawing] = []
    own = construction.initial_displacement, construction.initial_velocity
    for x, velocity in (own, *starts):
        moved = replace(construction, initial_displacement=x, initial_velocity=velocity)
        try:
            every.append(construct_motion(moved, rule, step=step, duration=duration))
        except ArithmeticError as error:
            raise ArithmeticError(f"from the start ({x:g}, {velocity:g}) {error}") from None
    (plane,) = construction.planes
    first, *others = every
    # the auxiliary curves reach as far as any of the integral curves near the construction: the values of
    # those of a pendulum that goes round and round would be too far apart for one that swings
    low, high = reach(plane.displacement, trail(plane, first.frames))
    size = high - low or inf
    near = (
        frame for one in (first, *others) for frame in one
        if low - size <= plane.displacement.read(frame.points[plane.state]) <= high + size
    )  # fmt: skip
    fixed = construction.curves(StoredFrames(near))
    kept = tuple(curve for curve in first.curves if curve.role != "auxiliary")
    curves = tuple(
        Curve("trail", path_of(plane, other.schemes, other.frames), f"({number(x)}, {number(v)})")
        for (x, v), other in zip(starts, others, strict=True)
    )
    return replace(first, curves=(*fixed, *kept, *curves))
