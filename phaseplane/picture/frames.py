"""Many steps of a construction as arrays: their points and readings, and the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Axis, Drawing
from phaseplane.constructions.storage import StoredFrames
from phaseplane.constructions.two_planes import STUCK
from phaseplane.constructions.yielding import FLOWS

from .paper import Points, Reals
from .quantities import display_unit


def table(frames: StoredFrames, names: Sequence[str]) -> Points:
    """Return the named points of the frames, shape (frames, names).

    Raises
    ------
    ValueError : if a frame lacks a point.
    """
    points = columns(frames, names)
    for row, column in np.argwhere(np.isnan(points)):
        frame = frames[int(row)]
        if names[column] not in frame.points:
            raise ValueError(
                f"step {frame.step} of the construction has no point {names[column]!r}"
            )
    return points


def columns(
    frames: StoredFrames, names: Sequence[str], part: Literal["points", "readings"] = "points"
) -> npt.NDArray[Any]:
    """Return named points or readings of the frames, shape (frames, names); nan where there is none."""
    store, chosen = frames.store, np.asarray(frames.chosen, np.int64)
    numbers, rows = (np.frombuffer(of, np.int64)[chosen] for of in (store.numbers, store.rows))
    kind = complex if part == "points" else float
    found: npt.NDArray[Any] = np.full((len(chosen), len(names)), np.nan, kind)
    for number in np.unique(numbers):
        known = {name: i for i, name in enumerate(getattr(store.layouts[number], part))}
        present = [i for i, name in enumerate(names) if name in known]
        values: npt.NDArray[Any] = np.frombuffer(getattr(store.tables[number], part), kind)
        mine = np.flatnonzero(numbers == number)
        own = np.array([known[names[i]] for i in present], np.int64)
        found[mine[:, None], present] = values[rows[mine, None] * len(known) + own]
    return found


def by_readings(frames: StoredFrames) -> dict[tuple[str, ...], list[int]]:
    """Return the places of frames by the names of their readings."""
    names = [layout.readings for layout in frames.store.layouts]
    found: dict[tuple[str, ...], list[int]] = {}
    for place, i in enumerate(frames.chosen):
        found.setdefault(names[frames.store.numbers[i]], []).append(place)
    return found


def read_over(
    drawing: Drawing, names: Sequence[str], first: int = 0, last: int | None = None
) -> tuple[Reals, Reals]:
    """Return the times of a range of steps and their readings, shape (times, names).

    After the last step of a construction, its end follows if it is known.
    """
    several = [drawing.frames[first:last]]
    if drawing.end is not None and first + len(several[0]) == len(drawing.frames):
        several.append(StoredFrames([drawing.end]))
    times, read = zip(*((of.times, columns(of, names, "readings")) for of in several), strict=True)
    return np.concatenate(times), np.concatenate(read)


def switches_of(drawing: Drawing) -> dict[str, npt.NDArray[np.bool_]]:
    """Return which wheels are off the road, and whether the spring yields or dry friction sticks.

    Each at all points of a construction, by the names of the columns of a run. Those that never occur
    are left out.
    """
    schemes = drawing.frames.schemes + ([drawing.end.scheme] if drawing.end is not None else [])
    forces = [n for n in drawing.frames[0].readings if n.endswith("contact_force")]
    _, read = read_over(drawing, forces)
    found = {
        **{n.replace("contact_force", "airborne"): read[:, k] == 0.0 for k, n in enumerate(forces)},
        "yielding": np.array([scheme in FLOWS for scheme in schemes]),
        "sticking": np.array([scheme.endswith(STUCK) for scheme in schemes]),
    }
    return {name: states for name, states in found.items() if states.any()}


def motions_of(drawing: Drawing) -> list[Points]:
    """Return the state points of each plane, including the end of the motion if the last step has it."""
    names = [plane.state for plane in drawing.planes]
    states = table(drawing.frames, names)
    ends = [f"{name}'" for name in names]
    if all(name in drawing.frames[-1].points for name in ends):
        states = np.concatenate([states, table(drawing.frames[-1:], ends)])
    return list(states.T)


def unit_of(axis: Axis, motion: Points) -> tuple[str, float]:
    """Return the unit in which a motion on an axis is shown, and its number in that of the axis."""
    return display_unit(axis.unit, float(np.ptp(reach_of(axis, motion))))


def reach_of(axis: Axis, motion: Points) -> tuple[float, float]:
    """Return the smallest and largest value of a motion on an axis, always including zero."""
    values = np.asarray(axis.read(motion))  # type: ignore[arg-type]
    values = values[np.isfinite(values)]
    return float(values.min(initial=0.0)), float(values.max(initial=0.0))
