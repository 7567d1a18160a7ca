"""AP57's shortcut for the end of a flight, drawn in addition to the correct touchdown.

After the obstacle, AP57 (section 5) ends the flight at x2 = x2st. This neglects the tyre's damping and
makes its force discontinuous, so the motion is never continued from there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

from phaseplane.constructions.construction import FLIGHT, LIFT_OFF
from phaseplane.constructions.primitives import Curve, Drawing
from phaseplane.constructions.rules import Rule, delta
from phaseplane.constructions.sheet import path_of
from phaseplane.constructions.step_loop import Start, frames
from phaseplane.constructions.steps import States
from phaseplane.constructions.storage import Frame
from phaseplane.constructions.two_planes import QuarterCarPlanes
from phaseplane.equations.typeset import number

_LONGEST = 10.0  # s of flight


@dataclass(frozen=True)
class _InFlight(QuarterCarPlanes):
    """A quarter car whose flight ends at x2 = x2st."""

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return x2 - x2st, m."""
        (axle,) = self.axles
        return (axle.wheel.displacement(states[1]) - axle.static_tyre_deflection,)


def shortcut_flights(
    construction: QuarterCarPlanes, made: Sequence[Frame], rule: Rule = delta, *, step: float
) -> list[tuple[Frame, ...]]:
    """Return the flight from U to x2 = x2st for every lift-off of a construction.

    Returns
    -------
    The frames of each flight; the last one ends at the V of AP57's shortcut. A flight that begins
    below x2st, or does not come down within 10 s, is omitted.
    """
    car = _InFlight(**{f.name: getattr(construction, f.name) for f in fields(construction)})
    flights = []
    for frame in made:
        if frame.event != LIFT_OFF:
            continue
        states = tuple(frame.points[plane.state] for plane in construction.planes)
        if car.margins(FLIGHT, states, frame.time)[0] <= 0.0:
            continue
        flown: list[Frame] = []
        start = Start(frame.time, FLIGHT, states)
        for one in frames(car, rule, step=step, duration=_LONGEST, start=start):
            if one.event:
                flights.append(tuple(flown))
                break
            flown.append(one)
    return flights


def with_shortcuts(
    drawing: Drawing, construction: object, rule: Rule = delta, step: float | None = None
) -> Drawing:
    """Return the drawing with each flight continued to AP57's V, as a curve `shortcut` in both planes.

    Parameters
    ----------
    construction, rule, step : those of the drawing; `step` is by default its longest step, s

    Raises
    ------
    ValueError : if the construction is not a quarter car with a linear tyre and without dry friction.
    """
    if not (
        isinstance(construction, QuarterCarPlanes)
        and construction.axle.tyre is None
        and not construction.axle.friction
    ):
        raise ValueError(
            "AP57's shortcut for touchdown is for quarter cars with linear tyres and without dry friction"
        )
    step = step or max(frame.duration for frame in drawing.frames)
    curves = tuple(
        Curve(
            "shortcut",
            path_of(plane, drawing.schemes, flight),
            f"V by x2 = x2st, {number(1e3 * end, 4)} ms",
        )
        for flight in shortcut_flights(construction, drawing.frames, rule, step=step)
        for end in (flight[-1].time + flight[-1].duration,)
        for plane in construction.planes
    )
    return replace(drawing, curves=drawing.curves + curves)
