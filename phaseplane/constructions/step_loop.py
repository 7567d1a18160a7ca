"""Steps along the integral curves: one loop for any number of coupled planes.

A construction supplies the sheet and the points for given state points, a step rule their successors,
and the loop makes successive steps. A step ends wherever the construction changes its mode, so that
lift-off U and touchdown V are state points, and wherever the road jumps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf, isfinite, pi
from typing import NamedTuple

from phaseplane.constructions.construction import JOLT, Construction, Window
from phaseplane.constructions.control import Before
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.rules import Rule, delta
from phaseplane.constructions.sheet import longest_normal, turn_angles
from phaseplane.constructions.stepping import Stepper
from phaseplane.constructions.steps import States
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.constructions.switching import first_end
from phaseplane.equations.typeset import number

_LEAST_PART = 1e-9  # of a step: anything shorter is rounding
_LARGEST_TURN = 0.5 * pi


class StepError(ValueError):
    """A step that is too long for a construction, or not valid."""


class Start(NamedTuple):
    """The start of a construction."""

    time: float
    mode: str
    states: States
    event: str = ""


def frames(
    construction: Construction,
    rule: Rule = delta,
    *,
    step: float,
    duration: float | None = None,
    steps: int | None = None,
    start: Start | None = None,
    ending: list[Frame] | None = None,
) -> Iterator[Frame]:
    """Yield the steps of a construction one after another, each complete.

    Parameters
    ----------
    construction : any construction of this package
    rule : the step rule
    step : s; steps end at its multiples, at the end of the motion, where the mode changes and where
        the road jumps
    duration, steps : length of the motion in s or in whole steps; give one of them
    start : by default time 0 in the construction's initial state
    ending : list that receives the end of the motion, as a step of no duration

    Raises
    ------
    StepError : if the step is not positive, or turns a normal by more than a right angle.
    ValueError : if the duration is not positive, or both or neither of duration and steps are given.
    ArithmeticError : if the construction diverges, e.g. with too long a step for a stiff stop, or if
        the step is too long for the damping.
    """
    _check_step(construction, step)
    length = _length(step, duration, steps)
    if start is None:
        states = construction.remembered(construction.initial, None)
        start = Start(0.0, construction.mode_at(states, 0.0), states)
    stepper = Stepper(construction, rule, start=start.states, begin=start.time, length=step)
    return _frames(stepper, step, start, start.time + length, ending)


def _frames(
    stepper: Stepper, step: float, start: Start, end: float, ending: list[Frame] | None
) -> Iterator[Frame]:
    construction = stepper.construction
    time, mode, states, event = start
    jolts = iter([*(t for t in construction.jolts if time < t < end), inf])
    jolt = next(jolts)
    before: Before | None = None
    made, tick = 0, 1
    fresh = bool(event) and event != JOLT
    while time < end and not (made and construction.ends(mode)):  # there is a step, if only of rest
        goal = min(start.time + tick * step, end)
        if end - goal < _LEAST_PART * step:
            goal = end
        target = jolt if jolt < goal + _LEAST_PART * step else goal
        window = Window.between(time, target)
        try:
            points, successors = stepper.step(mode, states, window)
            found = first_end(stepper, mode, states, window, points, successors, fresh=fresh)
            if found and found.part < window.duration * (1.0 - _LEAST_PART):
                window = Window(time, found.part)
                target = window.end
                points, successors = stepper.step(mode, states, window)
            readings = construction.readings(mode, states, time, before)
        except OverflowError:
            raise ArithmeticError(
                f"the construction diverges after {time:.6g} s; try a step shorter than {step:g} s, or "
                "less time if the motion itself grows without bound"
            ) from None
        scheme = construction.scheme_of(mode)
        yield Frame(made, time, window.duration, scheme, points, readings, event, mode)
        made += 1
        before = Before(readings, window.duration)
        time, states, event = target, successors, ""
        old_mode = mode
        if found:
            if found.limits:
                mode = construction.mode_after(mode, found.limits, states, time)
            else:
                mode = construction.mode_at(states, time)
            states = construction.remembered(states, states)
        if time == jolt:
            jolt, before, event = next(jolts), None, JOLT
            states = construction.jolted(mode, states, time)
            mode = construction.mode_at(states, time)
        fresh = mode != old_mode
        if fresh:
            event = construction.event(old_mode, mode)
        if goal - time < _LEAST_PART * step:
            tick += 1
    if ending is not None:
        points = construction.points(mode, states, Window(time))
        readings = construction.readings(mode, states, time, before)
        scheme = construction.scheme_of(mode)
        ending.append(Frame(made, time, 0.0, scheme, points, readings, event, mode))


def construct_motion(
    construction: Construction,
    rule: Rule = delta,
    *,
    step: float,
    duration: float | None = None,
    steps: int | None = None,
    start: Start | None = None,
) -> Drawing:
    """Make a whole construction from its initial state, or from another start.

    See `frames` for the parameters and the errors raised.
    """
    ending: list[Frame] = []
    made = frames(
        construction, rule, step=step, duration=duration, steps=steps, start=start, ending=ending
    )
    drawn = drawing(
        construction, rule, StoredFrames(made), step, f"step {number(1e3 * step, 4)} ms"
    )
    return replace(drawn, end=ending[0])


def drawing(
    construction: Construction, rule: Rule, made: StoredFrames, step: float, words: str
) -> Drawing:
    """Return the drawing of these frames and the fixed curves, with the turn angles of the step."""
    planes = construction.planes
    angles = turn_angles(planes, construction.protractor, longest_normal(planes, made), step)
    return Drawing(
        f"{construction.title}: rule {rule.name.replace('_', ' ')}, {words}",
        planes,
        construction.curves(made) + angles,
        {mode: rule.drawn_after(scheme, planes) for mode, scheme in construction.schemes.items()},
        made,
        rule=rule.name,
    )


def _check_step(construction: Construction, step: float) -> None:
    if not (isfinite(step) and step > 0.0):
        raise StepError(f"step = {step!r} s: must be positive and finite")
    fastest = max(construction.planes, key=lambda plane: plane.angular_frequency)
    if step * fastest.angular_frequency > _LARGEST_TURN:
        raise StepError(
            f"step = {step:g} s would turn the normal of the plane {fastest.name} by "
            f"{step * fastest.angular_frequency:.3g} rad; at most a right angle is allowed, "
            f"that is, a step of {_LARGEST_TURN / fastest.angular_frequency:.4g} s; "
            f"try {0.2 / fastest.angular_frequency:.2g} s"
        )


def _length(step: float, duration: float | None, steps: int | None) -> float:
    if (duration is None) == (steps is None):
        raise ValueError("give either the duration or the number of steps")
    if duration is not None:
        if not (isfinite(duration) and duration > 0.0):
            raise ValueError(f"duration = {duration!r} s: must be positive and finite")
        return duration
    assert steps is not None
    if steps < 1:
        raise ValueError(f"steps = {steps!r}: must be at least 1")
    return steps * step
