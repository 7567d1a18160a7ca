"""The construction laid over a known motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import isfinite

import numpy as np

from phaseplane.constructions.construction import Construction, Window
from phaseplane.constructions.control import Before
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.rules import Rule, delta
from phaseplane.constructions.sheet import state_point
from phaseplane.constructions.step_loop import drawing
from phaseplane.constructions.stepping import Stepper
from phaseplane.constructions.steps import States
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.equations.typeset import number


def overlay(
    construction: Construction,
    times: Sequence[float],
    *columns: Sequence[float],
    rule: Rule = delta,
    airborne: Sequence[bool | Sequence[bool]] | None = None,
) -> Drawing:
    """Lay the construction over a known trajectory, such as that of a simulation.

    The state points are those of the trajectory. Each step's successor is constructed, and its
    distance from the next given point is read off as `<displacement>_drift`, m. Of repeated times
    the last one counts.

    Parameters
    ----------
    times : ascending, s, shape (n,)
    columns : displacement and velocity of each plane in turn, m and m/s, shape (n,) each; for two
        planes suspension_deflection, suspension_deflection_rate, wheel_displacement, wheel_velocity
    airborne : whether the wheel is off the road, shape (n,), or (n, 2) for two wheels; default:
        found from the states

    Raises
    ------
    ValueError : if the number or length of columns is wrong, a value is not finite, times descend,
        or there are fewer than two different times.
    """
    rows = _rows(construction, times, columns, airborne)
    stepper = Stepper(construction, rule)
    made: list[Frame] = []
    before: Before | None = None
    old_mode = rows[0][2]
    for (time, states, mode), (next_time, next_states, _) in pairwise(rows):
        window = Window.between(time, next_time)
        points, successors = stepper.step(mode, states, window)
        own = construction.readings(mode, states, time, before)
        jolt = next((t for t in construction.jolts if time < t <= next_time), None)
        if jolt is not None:
            successors = construction.jolted(mode, successors, jolt)
        readings = own | {
            f"{plane.name}_drift": abs(end - wanted) / plane.displacement.scale
            for plane, end, wanted in zip(
                construction.planes, successors, next_states, strict=False
            )
        }
        event = construction.event(old_mode, mode) if old_mode != mode else ""
        scheme = construction.scheme_of(mode)
        made.append(Frame(len(made), time, window.duration, scheme, points, readings, event))
        old_mode = mode
        before = Before(readings, window.duration) if jolt is None else None
    longest = max(frame.duration for frame in made)
    words = f"laid over {len(made)} steps of up to {number(1e3 * longest, 4)} ms"
    return drawing(construction, rule, StoredFrames(made), longest, words)


def compare_with_motion(
    drawing: Drawing, times: Sequence[float], *columns: Sequence[float]
) -> Drawing:
    """Compare an independent construction with a known motion.

    The distance of its state points from those of the motion is read off at every step as
    `<displacement>_drift`, m. The motion is interpolated linearly between its times.

    Parameters
    ----------
    times, columns : as for `overlay`

    Raises
    ------
    ValueError : if there are fewer than two times, or the motion does not span the construction.
    """
    first, last = float(times[0]), float(times[-1])
    if len(times) < 2 or drawing.frames[0].time < first or drawing.frames[-1].time > last:
        raise ValueError(
            f"the motion from {first:g} s to {last:g} s does not span the construction"
        )
    drifts: dict[str, list[float]] = {}
    for plane, *motion in zip(drawing.planes, columns[::2], columns[1::2], strict=True):
        known = zip(
            *(np.interp(drawing.frames.times, times, column) for column in motion), strict=True
        )
        drifts[f"{plane.name}_drift"] = [
            abs(p - state_point(plane, y, rate)) / plane.displacement.scale
            for p, (y, rate) in zip(drawing.frames.points(plane.state), known, strict=True)
        ]
    apart = (dict(zip(drifts, row, strict=True)) for row in zip(*drifts.values(), strict=True))
    frames = (
        replace(frame, readings={**frame.readings, **row})
        for frame, row in zip(drawing.frames, apart, strict=True)
    )
    return replace(drawing, frames=StoredFrames(frames))


def _rows(
    construction: Construction,
    times: Sequence[float],
    columns: Sequence[Sequence[float]],
    airborne: Sequence[bool | Sequence[bool]] | None,
) -> list[tuple[float, States, str]]:
    """Return times with the state points and their mode."""
    planes = construction.planes
    if len(columns) != 2 * len(planes):
        raise ValueError(
            f"{len(columns)} columns given: must be {2 * len(planes)}, displacement and velocity of "
            + ", ".join(plane.name for plane in planes)
        )
    optional = () if airborne is None else (airborne,)
    lengths = [len(column) for column in (times, *columns, *optional)]
    if len(set(lengths)) != 1 or min(lengths) < 2:
        raise ValueError(
            "times and columns must have the same length, at least 2; lengths given: "
            + ", ".join(map(str, lengths))
        )
    rows: list[tuple[float, States, str]] = []
    before: States | None = None
    for i, (instant, *values) in enumerate(zip(times, *columns, strict=True)):
        time = float(instant)
        if not all(map(isfinite, (time, *values))):
            raise ValueError(f"row {i} of the trajectory (time {time:g} s) is not finite")
        if rows and time < rows[-1][0]:
            raise ValueError(f"times must ascend, but {time:g} s follows {rows[-1][0]:g} s")
        given = tuple(
            state_point(plane, float(y), float(rate))
            for plane, y, rate in zip(planes, values[::2], values[1::2], strict=True)
        )
        before = states = construction.remembered(given, before)
        flies = None if airborne is None else airborne[i]
        known = None if flies is None else (flies,) if isinstance(flies, bool) else tuple(flies)
        if rows and time == rows[-1][0]:
            rows.pop()
        rows.append((time, states, construction.mode_at(states, time, known)))
    if len(rows) < 2:
        raise ValueError("a trajectory needs at least two different times")
    return rows
