"""The phase planes on the sheet: one step with all letters, or many with all auxiliary lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure

from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.figures.canvas import (
    Sheet,
    graduation_of,
    is_main,
    motions_of,
    reach_of,
    time_words,
)
from phaseplane.figures.lettering import Box, Points
from phaseplane.figures.style import palette_for

_NAME = 0.16  # room for the name of an axis, as a fraction of the sheet's height
BODY_CURVES = ("auxiliary", "line", "shortcut")


def phase_planes(
    drawing: Drawing, frame: int | None = None, *, title: str = "", dark: bool = False
) -> Figure:
    """Draw the phase planes to scale with the whole motion, and one step with all letters.

    The style is that of AP57's figure 7. Lift-off U and touchdown V are marked.

    Parameters
    ----------
    frame : index of the lettered step; default: one whose letters have room
    title : written above, before the title of the drawing
    dark : use a dark background

    Raises
    ------
    ValueError : if there is no such frame.
    """
    chosen = frame_at(drawing, frame)
    sheet = step_sheet(drawing, chosen, dark=dark)
    sheet.events()
    sheet.letters(chosen)
    sheet.finish(title, f"{drawing.title}\n{step_words(chosen)}")
    return sheet.figure


def step_sheet(drawing: Drawing, frame: Frame, *, dark: bool, beside: float = 0.0) -> Sheet:
    """Draw axes, curves, the whole motion and the lines of one step, without letters.

    Parameters
    ----------
    beside : room on the right for dimensions, as a fraction of the width
    """
    view = view_of(drawing, [frame], turn=False)
    room = beside * view.half.real
    sheet = Sheet(drawing, Box(view.centre + room, view.half + room), palette_for(dark))
    sheet.axes_of_planes()
    sheet.stay(BODY_CURVES)
    sheet.trails()
    sheet.step(frame, repeated=False, turn=False)
    return sheet


def step_words(frame: Frame) -> str:
    """Return the number and time of the lettered step as text."""
    return f"Step {frame.step} lettered, {time_words(frame.time)}"


def construction_sheet(
    drawing: Drawing,
    frames: Iterable[int] = range(20),
    *,
    through: bool = False,
    title: str = "",
    dark: bool = False,
) -> Figure:
    """Draw the sheet after many steps, with all their auxiliary lines.

    The style is that of AP57's figure 13: state points are numbered, turn angles share a common arm,
    and the curves continue to the end of the motion.

    Parameters
    ----------
    frames : indices of the steps drawn with all lines; indices beyond the end are ignored
    through : whether later points are also marked and numbered
    title : written above, before the title of the drawing
    dark : use a dark background

    Raises
    ------
    ValueError : if none of the frames exists.
    """
    wanted = [i for i in frames if 0 <= i < len(drawing.frames)]
    if not wanted:
        raise ValueError(f"none of the frames exists; the drawing has {len(drawing.frames)}")
    chosen = [drawing.frames[i] for i in wanted]
    sheet = Sheet(drawing, view_of(drawing, chosen, turn=True), palette_for(dark))
    sheet.axes_of_planes()
    sheet.stay(None)
    for one in chosen:
        sheet.step(one, repeated=False, turn=True, thin=0.6)
    sheet.trails()
    sheet.events()
    sheet.numbers(drawing.frames[wanted[0] :] if through else chosen)
    last, end = chosen[-1].step + 1, drawing.frames[-1].step + 1
    words = f"Points {chosen[0].step} to {last} with all auxiliary lines"
    if through and end > last:
        words += f", {last + 1} to {end} along the curves"
    sheet.finish(title, f"{drawing.title}\n{words}")
    return sheet.figure


def frame_at(drawing: Drawing, index: int | None) -> Frame:
    """Return the frame with this index, or one whose letters have room."""
    if index is None:
        return telling_frame(drawing)
    if not 0 <= index < len(drawing.frames):
        raise ValueError(f"no frame {index}; the drawing has frames 0 to {len(drawing.frames) - 1}")
    return drawing.frames[index]


def telling_frame(drawing: Drawing, mode: str = "") -> Frame:
    """Return the step whose letters are farthest apart relative to the size of its sheet.

    Parameters
    ----------
    mode : mode of the step; default: that of the first
    """
    mode = mode or drawing.frames[0].scheme
    frames = [frame for frame in drawing.frames if frame.scheme == mode]
    names = [m.point for m in drawing.schemes[mode].marks if is_main(m.point) and m.label]
    names = [name for name in names if not name.endswith("'")]
    points = np.array([[frame.points[name] for name in names] for frame in frames])
    one, other = np.triu_indices(len(names), 1)
    gaps = np.sort(abs(points[:, one] - points[:, other]), axis=1)
    seen = np.array([[frame.points[name] for name in _seen(drawing, mode)] for frame in frames])
    _, halves = bounds(_shown(drawing, seen))
    return frames[int((gaps[:, :5].sum(axis=1) / abs(halves) ** 2).argmax())]


def view_of(drawing: Drawing, frames: Sequence[Frame], *, turn: bool) -> Box:
    """Return the visible part of the sheet, with a margin."""
    points = [frame.points[name] for frame in frames for name in _seen(drawing, frame.scheme)]
    if turn:
        points += [
            vertex
            for curve in drawing.curves
            if curve.role not in BODY_CURVES
            for vertex in curve.vertices
        ]
    return around(_shown(drawing, np.array(points)))


def _seen(drawing: Drawing, scheme: str) -> list[str]:
    """Return the names of the points of a step that must be visible."""
    marks = drawing.schemes[scheme].marks
    return [m.point for m in marks if is_main(m.point) and not m.point.startswith("S")]


def _shown(drawing: Drawing, points: Points) -> Points:
    """Return the corners of views that show these points, shape (..., points), and the motion."""
    motion = corners(motion_points(drawing))
    known = np.concatenate((points, np.broadcast_to(motion, (*points.shape[:-1], 2))), axis=-1)
    return np.concatenate((corners(known), name_room(drawing, known)), axis=-1)


def name_room(drawing: Drawing, points: Points) -> Points:
    """Return how far the y axes extend beyond the motion for their names, m of paper.

    Parameters
    ----------
    points : shape (..., points)

    Returns
    -------
    shape (..., planes)
    """
    room = _NAME * np.ptp(points.imag, axis=-1)[..., None]
    axes = [plane.displacement for plane in drawing.planes]
    ends = [
        axis.at(reach_of(axis, m)[1]) for axis, m in zip(axes, motions_of(drawing), strict=True)
    ]
    return np.array(ends) + room * np.array([axis.direction for axis in axes])


def motion_points(drawing: Drawing) -> Points:
    """Return the motion in all planes, with the origins and the values on the y-bar axes."""
    points = []
    for plane, motion in zip(drawing.planes, motions_of(drawing), strict=True):
        axis = plane.scaled_velocity
        values = [axis.at(value) for value in graduation_of(axis, motion).values]
        points += [motion, np.array([plane.displacement.origin, *values])]
    return np.concatenate(points)


def around(points: Points, margin: float = 0.05) -> Box:
    """Return the smallest box around the points, with a margin as a fraction of its larger side."""
    centre, half = bounds(points, margin)
    return Box(complex(centre), complex(half))


def bounds(points: Points, margin: float = 0.05) -> tuple[Points, Points]:
    """Return centres and half-sizes of the smallest boxes around each row, shape (..., points)."""
    low, high = np.moveaxis(corners(points), -1, 0)
    size = high - low
    border = margin * np.maximum(size.real, size.imag)
    return (low + high) / 2, size / 2 + np.where(border > 0.0, border, 0.01) * (1 + 1j)


def corners(points: Points) -> Points:
    """Return the lower left and the upper right corner of the range of each row of points."""
    x, y = points.real, points.imag
    ends = x.min(axis=-1) + 1j * y.min(axis=-1), x.max(axis=-1) + 1j * y.max(axis=-1)
    return np.stack(ends, axis=-1)
