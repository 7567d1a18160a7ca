"""The construction laid over a motion that is known already."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import isfinite

from phaseplane.constructions.marching import Construction, Stepper, Window, drawing
from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.constructions.sheet import state_point
from phaseplane.constructions.steps import Rule, States, delta


def overlay(
    construction: Construction,
    times: Sequence[float],
    *columns: Sequence[float],
    rule: Rule = delta,
    airborne: Sequence[bool] | None = None,
) -> Drawing:
    """The construction laid over a trajectory that is known already, as from a simulation.

    The state points are those of the trajectory; each step's successor is constructed, and how far
    it lies from the next given point is read off as `<displacement>_drift`, m. Instants given twice
    count once.

    Parameters
    ----------
    times : shape (n,), ascending, s
    columns : displacement and velocity of each plane in turn, shape (n,) each, m and m/s; for two
        planes suspension_deflection, suspension_deflection_rate, wheel_displacement, wheel_velocity
    airborne : shape (n,), whether the wheel is off the road; found from the states when left out

    Raises
    ------
    ValueError : columns too few, too many, of another length, not finite; times that descend; fewer
        than two instants.
    """
    rows = _rows(construction, times, columns, airborne)
    stepper = Stepper(construction, rule)
    made: list[Frame] = []
    readings: Mapping[str, float] | None = None
    elapsed, old_mode = 0.0, ""
    for (time, states, flies), (next_time, next_states, _) in pairwise(rows):
        mode = construction.mode_at(states, time, flies)
        event = construction.succeeding(old_mode)[1] if old_mode not in ("", mode) else ""
        window = Window(time, next_time - time)
        points = stepper.points(mode, states, window)
        own = construction.readings(mode, states, time, readings, elapsed)
        readings = own | {
            f"{plane.name}_drift": abs(end - wanted) / plane.displacement.scale
            for plane, end, wanted in zip(
                construction.planes, stepper.successors(points), next_states, strict=True
            )
        }
        made.append(Frame(len(made), time, window.duration, mode, points, readings, event))
        old_mode, elapsed = mode, window.duration
    longest = max(frame.duration for frame in made)
    return drawing(construction, rule, tuple(made), longest)


def _rows(
    construction: Construction,
    times: Sequence[float],
    columns: Sequence[Sequence[float]],
    airborne: Sequence[bool] | None,
) -> list[tuple[float, States, bool | None]]:
    planes = construction.planes
    if len(columns) != 2 * len(planes):
        raise ValueError(
            f"{len(columns)} columns given; displacement and velocity of "
            f"{', '.join(plane.name for plane in planes)} make {2 * len(planes)}"
        )
    optional = () if airborne is None else (airborne,)
    lengths = {len(column) for column in (times, *columns, *optional)}
    if len(lengths) != 1 or min(lengths) < 2:
        raise ValueError(
            "times and columns must be of one length, at least 2; given "
            + ", ".join(str(len(column)) for column in (times, *columns, *optional))
        )
    rows: list[tuple[float, States, bool | None]] = []
    for i, (instant, *values) in enumerate(zip(times, *columns, strict=True)):
        time = float(instant)
        if not all(map(isfinite, (time, *values))):
            raise ValueError(f"row {i} of the trajectory (time {time:g} s) is not finite")
        states = tuple(
            state_point(plane, float(y), float(rate))
            for plane, y, rate in zip(planes, values[::2], values[1::2], strict=True)
        )
        row = (time, states, None if airborne is None else bool(airborne[i]))
        if rows and time < rows[-1][0]:
            raise ValueError(f"times must ascend, but {time:g} s follows {rows[-1][0]:g} s")
        if rows and time == rows[-1][0]:
            rows[-1] = row
        else:
            rows.append(row)
    if len(rows) < 2:
        raise ValueError("a trajectory needs at least two different instants")
    return rows
