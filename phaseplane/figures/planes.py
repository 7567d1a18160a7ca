"""The phase planes on their sheet: one step lettered in full, or many with all auxiliary lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from matplotlib.figure import Figure

from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.constructions.sheet import reach, trail
from phaseplane.figures.canvas import Sheet, graduation_of, is_main, time_words
from phaseplane.figures.lettering import Box
from phaseplane.figures.style import palette_for

_NAME = 0.16  # of a sheet's height: what the name of an axis takes up
BODY_CURVES = ("auxiliary", "line", "shortcut")


def phase_planes(
    drawing: Drawing, frame: int | None = None, *, title: str = "", dark: bool = False
) -> Figure:
    """Both phase planes to scale with the whole motion, and one step lettered in full.

    In the manner of AP57's figure 7. Lift-off U and touchdown V are marked.

    Parameters
    ----------
    frame : index of the lettered step; left out, one whose letters have room
    title : written above, before what the drawing says of itself
    dark : on a dark ground

    Raises
    ------
    ValueError : no such frame.
    """
    chosen = frame_at(drawing, frame)
    sheet = step_sheet(drawing, chosen, dark=dark)
    sheet.events()
    sheet.letters(chosen)
    sheet.finish(title, f"{drawing.title}\n{step_words(chosen)}")
    return sheet.figure


def step_sheet(drawing: Drawing, frame: Frame, *, dark: bool, beside: float = 0.0) -> Sheet:
    """Axes, curves, the whole motion and the lines of one step, still without letters.

    Parameters
    ----------
    beside : of the width, room on the right for dimensions
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
    """Which step is lettered."""
    return f"Step {frame.step} lettered, {time_words(frame.time)}"


def construction_sheet(
    drawing: Drawing,
    frames: Iterable[int] = range(20),
    *,
    title: str = "",
    dark: bool = False,
) -> Figure:
    """The sheet as it looks after many steps, with all their auxiliary lines.

    In the manner of AP57's figure 13: the state points are numbered, the turn angles stand on their
    common arm, and the curves go on to the end of the motion.

    Parameters
    ----------
    frames : indices of the steps that are drawn with all lines; those beyond the end are left out
    title : written above, before what the drawing says of itself
    dark : on a dark ground

    Raises
    ------
    ValueError : none of the frames is there.
    """
    wanted = [i for i in frames if 0 <= i < len(drawing.frames)]
    if not wanted:
        raise ValueError(f"none of the frames is there; the drawing has {len(drawing.frames)}")
    chosen = [drawing.frames[i] for i in wanted]
    sheet = Sheet(drawing, view_of(drawing, chosen, turn=True), palette_for(dark))
    sheet.axes_of_planes()
    sheet.stay(None)
    for one in chosen:
        sheet.step(one, repeated=False, turn=True, thin=0.6)
    sheet.trails()
    sheet.events()
    sheet.numbers(chosen)
    last = chosen[-1].step + 1
    words = f"Points {chosen[0].step} to {last} with all auxiliary lines"
    sheet.finish(title, f"{drawing.title}\n{words}")
    return sheet.figure


def frame_at(drawing: Drawing, index: int | None) -> Frame:
    """The frame of this index, or one whose letters have room."""
    if index is None:
        return telling_frame(drawing)
    if not 0 <= index < len(drawing.frames):
        raise ValueError(f"frame {index}: the drawing has frames 0 to {len(drawing.frames) - 1}")
    return drawing.frames[index]


def telling_frame(drawing: Drawing, mode: str = "") -> Frame:
    """The step whose lettered points lie farthest apart on the sheet it needs.

    Parameters
    ----------
    mode : of the step; left out, that of the first
    """
    mode = mode or drawing.frames[0].scheme
    names = [m.point for m in drawing.schemes[mode].marks if is_main(m.point) and m.label]

    def room(frame: Frame) -> float:
        points = [frame.points[name] for name in names if not name.endswith("'")]
        gaps = sorted(abs(p - q) for i, p in enumerate(points) for q in points[:i])
        box = view_of(drawing, [frame], turn=False)
        return sum(gaps[:5]) / abs(box.half) ** 2

    return max((f for f in drawing.frames if f.scheme == mode), key=room)


def view_of(drawing: Drawing, frames: Sequence[Frame], *, turn: bool) -> Box:
    """What has to be seen of the sheet, with a margin."""
    names = {
        mark.point
        for frame in frames
        for mark in drawing.schemes[frame.scheme].marks
        if is_main(mark.point) and not mark.point.startswith("S")
    }
    points = [frame.points[name] for frame in frames for name in names if name in frame.points]
    points += motion_points(drawing)
    if turn:
        points += [
            vertex
            for curve in drawing.curves
            if curve.role not in BODY_CURVES
            for vertex in curve.vertices
        ]
    return around(points + name_room(drawing, points))


def name_room(drawing: Drawing, points: Sequence[complex]) -> list[complex]:
    """How far the y axes go beyond the motion for their names, on a sheet with these points."""
    heights = [point.imag for point in points]
    room = _NAME * (max(heights) - min(heights))
    ends = []
    for plane in drawing.planes:
        axis, motion = plane.displacement, trail(plane, drawing.frames)
        ends.append(axis.at(reach(axis, motion)[1]) + room * axis.direction)
    return ends


def motion_points(drawing: Drawing) -> list[complex]:
    """The motion in all planes, with their origins and the values on their y-bar axes."""
    points: list[complex] = []
    for plane in drawing.planes:
        motion = trail(plane, drawing.frames)
        axis = plane.scaled_velocity
        points += [*motion, plane.displacement.origin]
        points += [axis.at(value) for value in graduation_of(axis, motion).values]
    return points


def around(points: Sequence[complex], margin: float = 0.05) -> Box:
    """The smallest box that holds the points with a margin, a part of the larger side."""
    left, right = min(z.real for z in points), max(z.real for z in points)
    bottom, top = min(z.imag for z in points), max(z.imag for z in points)
    border = margin * max(right - left, top - bottom) or 0.01
    return Box(
        complex(left + right, bottom + top) / 2,
        complex(right - left, top - bottom) / 2 + border * (1 + 1j),
    )
