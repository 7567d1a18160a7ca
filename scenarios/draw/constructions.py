"""Graphical constructions of scenes and results."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from itertools import pairwise
from math import ceil, inf
from typing import TYPE_CHECKING, Any, NamedTuple

from phaseplane.suspension.variables import Value

from phaseplane import constructions
from phaseplane.constructions.sheet import state_point
from phaseplane.picture.quantities import rate_of

from ..errors import DrawingError, InputError, blaming
from .planes import planes_of

if TYPE_CHECKING:
    from phaseplane.constructions import Construction
    from phaseplane.constructions.primitives import Drawing

    from ..columns import Columns
    from ..scene.schema import Scene

    ReadAt = Callable[[Sequence[float], Sequence[str]], Columns]
    Check = Callable[[Drawing], None]

_SPARSE = 0.5  # of the distance between planes: motions that need less are too small to be seen
_PARTS = 24  # of a step over a known motion: the most by which its way is drawn


class Begin(NamedTuple):
    """A start of a construction later than time 0."""

    time: float  # s
    states: tuple[tuple[float, float], ...]  # y and y' / Omega of each plane, m


def draw_scene(scene: Scene, check: Check | None = None) -> Drawing:
    """Return the graphical construction of a scene, without its controller; see `draw_construction`."""
    settings, duration = asdict(scene.construction), scene.construction_time
    drawing = draw_construction(scene.fmu.model, scene.all_parameters, settings, duration, check)
    return of_model_alone(drawing, scene)


def of_model_alone(drawing: Drawing, scene: Scene) -> Drawing:
    """Return a construction whose title says so if the scene has a controller, which it has not."""
    if scene.controller is None:
        return drawing
    return replace(drawing, title=f"{drawing.title}, without the controller")


def draw_construction(
    model: str,
    parameters: Mapping[str, Value],
    settings: Mapping[str, Any],
    duration: float,
    check: Check | None = None,
) -> Drawing:
    """Return the graphical construction, stepped from its initial state or from a later one.

    Parameters
    ----------
    parameters : all parameters of the model, SI
    settings : rule, step (s), plane_distance (m), plane_scales, shortcut, begin
    duration : time to construct, s
    check : is given the first step, and refuses the construction by an exception of its own

    Raises
    ------
    DrawingError : if it cannot be drawn with these settings, e.g. if the step is too long.
    InputError : if the model has no construction.
    ArithmeticError : if the construction diverges.
    """
    planes = planes_of(model, parameters, settings)
    rule, step = constructions.rule_named(settings["rule"]), settings["step"]
    if check is not None:
        with _drawn():
            first = _construct(planes, settings, min(step, duration))
        check(first)
    with _drawn():
        drawing = _construct(planes, settings, duration)
        distance = _distance_needed(drawing)
        if distance and settings.get("plane_distance") is None:
            planes = planes_of(model, parameters, {**settings, "plane_distance": distance})
            drawing = _construct(planes, settings, duration)
        if settings.get("shortcut"):
            return constructions.with_shortcuts(drawing, planes, rule, step)
        return drawing


@contextmanager
def _drawn() -> Iterator[None]:
    """Report a construction that cannot be drawn."""
    try:
        yield
    except ValueError as error:
        raise DrawingError(f"the construction cannot be drawn: {error}") from None


def _construct(planes: Construction, settings: Mapping[str, Any], duration: float) -> Drawing:
    """Return a construction stepped from its initial state, or from several of an equation."""
    rule, step = constructions.rule_named(settings["rule"]), settings["step"]
    starts = settings.get("starts") or ()
    if not starts:
        start = _start(planes, settings.get("begin"))
        return constructions.construct_motion(
            planes, rule, step=step, duration=duration, start=start
        )
    if not isinstance(planes, constructions.EquationPlane):
        raise ValueError("starts are for equations only")
    return constructions.family(planes, starts, rule, step=step, duration=duration)


def _start(planes: Construction, begin: Begin | None) -> constructions.Start | None:
    """Return a later start on a sheet, which is that of the motion if none is given."""
    if begin is None:
        return None
    pairs = zip(planes.planes, begin.states, strict=True)
    states = planes.remembered(tuple(plane.at(*state) for plane, state in pairs), None)
    return constructions.Start(begin.time, planes.mode_at(states, begin.time), states)


def overlay_run(
    columns: Columns,
    model: str,
    parameters: Mapping[str, Value],
    settings: Mapping[str, Any],
    check: Check | None = None,
) -> Drawing:
    """Return the graphical construction with the state points of a known motion.

    Parameters
    ----------
    columns : `time` (s), the displacements of the planes and their rates, SI; `airborne` if there is
        lift-off
    model, parameters : the model of the motion, and its parameters in SI
    settings : as for `draw_construction`, and duration (s); rows closer than `step` are skipped,
        except at lift-off and touchdown
    check : as for `draw_construction`

    Raises
    ------
    InputError : if the model has no construction, a column is missing, or it cannot be drawn with these
        settings.
    """
    planes = planes_of(model, parameters, settings)
    shown = [name for plane in planes.planes for name in (plane.name, rate_of(plane.name))]
    missing = [name for name in ("time", *shown) if name not in columns]
    if missing:
        raise InputError(
            f"no column {missing[0]}; add it to show.outputs and run again, or add it to the table; "
            f"the construction needs time, {', '.join(shown)}"
        )
    flying = [name for name in columns if name.endswith("airborne")]
    rows = list(_rows(columns, flying, settings["step"], settings.get("duration")))
    time = columns["time"]

    def laid(planes: Construction, rows: Sequence[int] = rows) -> Drawing:
        wheels = [columns[name][rows].astype(bool).tolist() for name in flying]
        drawing = constructions.overlay(
            planes,
            time[rows].tolist(),
            *(columns[name][rows].tolist() for name in shown),
            rule=constructions.rule_named(settings["rule"]),
            airborne=list(zip(*wheels, strict=True)) if wheels else None,
        )
        return replace(drawing, ways=tuple(_ways(drawing, columns, rows)))

    if check is not None:
        until = next((k for k, row in enumerate(rows) if time[row] > time[rows[0]]), len(rows))
        with blaming("construction", (ArithmeticError, ValueError)):
            first = laid(planes, rows[: until + 1])
        check(first)
    with blaming("construction", (ArithmeticError, ValueError)):
        drawing = laid(planes)
        distance = _distance_needed(drawing)
        if distance and settings.get("plane_distance") is None:
            drawing = laid(planes_of(model, parameters, {**settings, "plane_distance": distance}))
        return drawing


def _distance_needed(drawing: Drawing) -> float:
    """Return the distance between planes, m of paper, that their motions need; 0 for the present one.

    It is 1.3 times the part of it that the motions in neighbouring planes take up, rounded up to 5 cm, or
    below 10 cm to 1 cm.
    The present one will not do where planes overlap, or where motions are small in much empty paper.
    """
    spans = [
        (height, [z.imag - height for z in drawing.frames.points(plane.state)])
        for plane in drawing.planes
        for height in (plane.displacement.origin.imag,)
    ]
    needed = present = 0.0
    for (upper, heights), (lower, others) in pairwise(sorted(spans, reverse=True)):
        present = upper - lower
        needed = max(needed, 1.3 * (max(0.0, *others) - min(0.0, *heights)))
    parts = 20.0 if needed > 0.1 else 100.0
    return 0.0 if _SPARSE * present <= needed <= present else ceil(parts * needed) / parts


def with_drift(drawing: Drawing, columns: Columns, read_at: ReadAt) -> Drawing:
    """Return a construction with its drift from a run, if the run has the columns and the time.

    `read_at` returns outputs of the run at the times of the construction and at its end.
    """
    shown = [name for plane in drawing.planes for name in (plane.name, rate_of(plane.name))]
    if not set(shown) <= columns.keys() or columns["time"][-1] < drawing.frames[-1].time:
        return drawing
    end = drawing.frames[-1].time + drawing.frames[-1].duration
    columns = read_at([*drawing.frames.times, end], shown) or columns
    motion = (columns[name].tolist() for name in shown)
    return constructions.compare_with_motion(drawing, columns["time"].tolist(), *motion)


def drawing_summary(drawing: Drawing, seconds: float | None = None) -> dict[str, Any]:
    """Return the summary of a construction, as plain data.

    Returns
    -------
    Steps and events; `control`: largest difference of the body motions by AP57 eqs. 24 and 25;
    `drift`: largest difference from a given motion, of the construction, or of each step if it is laid
    over the motion. Both in m.
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
            for frame in map(drawing.frames.__getitem__, drawing.frames.events)
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


def _ways(drawing: Drawing, columns: Columns, rows: Sequence[int]) -> Iterator[list[list[complex]]]:
    """Yield the way of the motion over each step in each plane, through the rows that it skips."""
    time = columns["time"]
    kept = [row for row, after in pairwise(rows) if time[after] > time[row]] + [rows[-1]]
    parts = min(_PARTS, max(after - row for row, after in pairwise(kept)))
    through = [
        [row + k * (after - row) // parts for k in range(parts + 1)]
        for row, after in pairwise(kept)
    ]
    for plane in drawing.planes:
        y, rate = columns[plane.name], columns[rate_of(plane.name)]
        yield [[state_point(plane, float(y[i]), float(rate[i])) for i in row] for row in through]


def _rows(
    columns: Columns, flying: list[str], step: float, duration: float | None
) -> Iterator[int]:
    """Yield the rows that are a step apart, and those where the mode changes."""
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
