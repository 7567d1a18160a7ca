"""From scenes and results to graphical constructions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.variables import Value

from phaseplane import constructions

from ..errors import DrawingError, InputError, one_line
from .planes import planes_of

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from phaseplane.constructions.primitives import Drawing

    Columns = Mapping[str, npt.NDArray[np.float64]]
    ReadAt = Callable[[Sequence[float], Sequence[str]], Columns]


def constructed(
    model: str, parameters: Mapping[str, Value], settings: Mapping[str, Any], duration: float
) -> Drawing:
    """The graphical construction marching by itself.

    Parameters
    ----------
    parameters : of the model, all of them, SI
    settings : rule, step (s), plane_distance (m), plane_scales, shortcut
    duration : s

    Raises
    ------
    DrawingError : settings with which it cannot be drawn, such as a step too long.
    InputError : a model without a construction.
    ArithmeticError : the construction leaves every sheet.
    """
    planes = planes_of(model, parameters, settings)
    rule, step = constructions.rule_named(settings["rule"]), settings["step"]
    try:
        drawing = constructions.march(planes, rule, step=step, duration=duration)
        return (
            constructions.with_shortcuts(drawing, planes, rule, step)
            if settings.get("shortcut")
            else drawing
        )
    except ValueError as error:
        raise DrawingError(f"construction: {one_line(error)}") from None


def laid_over(
    columns: Columns,
    model: str,
    parameters: Mapping[str, Value],
    settings: Mapping[str, Any],
) -> Drawing:
    """The graphical construction with the state points of a motion that is known.

    Parameters
    ----------
    columns : `time` (s) and what the planes show with its rates, SI; `airborne` if there is lift-off
    model, parameters : what moved
    settings : as for `constructed`, and duration (s); where `step` is longer than the rows are apart,
        rows are skipped, but never those where a wheel leaves the road or returns

    Raises
    ------
    InputError : a model without a construction, columns that are missing, or settings with which it
        cannot be drawn.
    """
    planes = planes_of(model, parameters, settings)
    shown = [name for plane in planes.planes for name in (plane.name, rate_of(plane.name))]
    missing = [name for name in ("time", *shown) if name not in columns]
    if missing:
        raise InputError(
            f"no column {missing[0]}; put it into show.outputs and run, or into the table; "
            f"the construction needs time, {', '.join(shown)}"
        )
    flying = [name for name in columns if name.endswith("airborne")]
    rows = list(_rows(columns, flying, settings["step"], settings.get("duration")))
    wheels = [columns[name][rows].astype(bool).tolist() for name in flying]
    try:
        return constructions.overlay(
            planes,
            columns["time"][rows].tolist(),
            *(columns[name][rows].tolist() for name in shown),
            rule=constructions.rule_named(settings["rule"]),
            airborne=list(zip(*wheels, strict=True)) if wheels else None,
        )
    except ValueError as error:
        raise InputError(f"construction: {one_line(error)}") from None


def drifting(drawing: Drawing, columns: Columns, read_at: ReadAt) -> Drawing:
    """A construction by itself with how far it has drifted from a run, where the run tells enough.

    Parameters
    ----------
    drawing : the construction
    columns : of the run
    read_at : gives outputs of the run at the instants of the construction
    """
    shown = [name for plane in drawing.planes for name in (plane.name, rate_of(plane.name))]
    if not set(shown) <= columns.keys() or columns["time"][-1] < drawing.frames[-1].time:
        return drawing
    columns = read_at([frame.time for frame in drawing.frames], shown) or columns
    motion = (columns[name].tolist() for name in shown)
    return constructions.held_against(drawing, columns["time"].tolist(), *motion)


def rate_of(displacement: str) -> str:
    """The name of the rate of a displacement, as FMUs and constructions have it."""
    stem = displacement.removesuffix("displacement")
    return f"{stem}velocity" if stem != displacement else f"{displacement}_rate"


def told_of(drawing: Drawing, seconds: float | None = None) -> dict[str, Any]:
    """What there is to be said of a construction, as plain data.

    Returns
    -------
    steps and events; `control`: how far the motions of bodies by AP57 eqs. 24 and 25 are apart at
    most; `drift`: how far from a given motion a construction by itself gets, or a step that is laid
    over it ends, at most; both in m
    """
    readings = drawing.frames[-1].readings
    controls = [name.removeprefix("control_") for name in readings if name.startswith("control_")]
    return {
        "title": drawing.title,
        "steps": len(drawing.frames),
        "seconds": seconds,
        "unit": drawing.planes[0].displacement.unit,
        "events": [
            {"event": event.name, "time": frame.time}
            for frame in drawing.frames
            for event in constructions.events_of(frame, drawing.planes)
        ],
        "control": {
            name: max(abs(f.readings[name] - f.readings[f"control_{name}"]) for f in drawing.frames)
            for name in controls
            if name.endswith("displacement")
        },
        "drift": {
            name.removesuffix("_drift"): max(f.readings[name] for f in drawing.frames)
            for name in readings
            if name.endswith("_drift")
        },
    }


def _rows(
    columns: Columns, flying: list[str], step: float, duration: float | None
) -> Iterator[int]:
    """The rows that lie a step apart, and those where the mode changes."""
    time = columns["time"]
    end = inf if duration is None else float(time[0]) + duration * (1.0 + 1e-9)
    last = int((time <= end).sum()) - 1
    due = time[0]
    for row, instant in enumerate(time[: last + 1]):
        changed = row > 0 and any(columns[n][row] != columns[n][row - 1] for n in flying)
        if changed or instant >= due - 1e-6 * step or row == last:
            yield row
        if instant >= due - 1e-6 * step:
            due += step * max(1, round((instant - due) / step + 1e-6) + 1)
