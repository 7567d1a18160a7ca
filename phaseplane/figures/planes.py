"""The phase planes on their sheet: one step lettered in full, or many with all auxiliary lines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from matplotlib.figure import Figure

from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.constructions.sheet import trail
from phaseplane.figures.canvas import Sheet, graduation_of, is_main
from phaseplane.figures.lettering import Box
from phaseplane.figures.style import DARK, LIGHT

_BODY_CURVES = ("auxiliary", "line", "shortcut")


def phase_planes(drawing: Drawing, frame: int | None = None, *, dark: bool = False) -> Figure:
    """Both phase planes to scale with the whole motion, and one step lettered in full.

    In the manner of AP57's figure 7. Lift-off U and touchdown V are marked.

    Parameters
    ----------
    frame : index of the lettered step; left out, one whose letters have room
    dark : on a dark ground

    Raises
    ------
    ValueError : no such frame.
    """
    chosen = _frame(drawing, frame)
    sheet = Sheet(drawing, _view(drawing, [chosen], turn=False), DARK if dark else LIGHT)
    sheet.axes_of_planes()
    sheet.stay(_BODY_CURVES)
    sheet.trails()
    sheet.step(chosen, repeated=False, turn=False)
    sheet.events()
    sheet.letters(chosen)
    sheet.finish(f"{drawing.title}\nStep {chosen.step} lettered, t = {1e3 * chosen.time:.4g} ms")
    return sheet.figure


def construction_sheet(
    drawing: Drawing, frames: Iterable[int] = range(20), *, dark: bool = False
) -> Figure:
    """The sheet as it looks after many steps, with all their auxiliary lines.

    In the manner of AP57's figure 13: the state points are numbered, the turn angles stand on their
    common arm, and the curves go on to the end of the motion.

    Parameters
    ----------
    frames : indices of the steps that are drawn with all lines; those beyond the end are left out
    dark : on a dark ground

    Raises
    ------
    ValueError : none of the frames is there.
    """
    wanted = [i for i in frames if 0 <= i < len(drawing.frames)]
    if not wanted:
        raise ValueError(f"none of the frames is there; the drawing has {len(drawing.frames)}")
    chosen = [drawing.frames[i] for i in wanted]
    sheet = Sheet(drawing, _view(drawing, chosen, turn=True), DARK if dark else LIGHT)
    sheet.axes_of_planes()
    sheet.stay(None)
    for one in chosen:
        sheet.step(one, repeated=False, turn=True, thin=0.6)
    sheet.trails()
    sheet.events()
    sheet.numbers(chosen)
    last = chosen[-1].step + 1
    sheet.finish(f"{drawing.title}\nPoints {chosen[0].step} to {last} with all auxiliary lines")
    return sheet.figure


def _frame(drawing: Drawing, index: int | None) -> Frame:
    if index is None:
        return telling_frame(drawing)
    if not 0 <= index < len(drawing.frames):
        raise ValueError(f"frame {index}: the drawing has frames 0 to {len(drawing.frames) - 1}")
    return drawing.frames[index]


def telling_frame(drawing: Drawing) -> Frame:
    """The step in contact whose lettered points lie farthest apart on the sheet it needs."""
    normal = drawing.frames[0].scheme
    names = [m.point for m in drawing.schemes[normal].marks if is_main(m.point) and m.label]

    def room(frame: Frame) -> float:
        points = [frame.points[name] for name in names if not name.endswith("'")]
        gaps = sorted(abs(p - q) for i, p in enumerate(points) for q in points[:i])
        box = _view(drawing, [frame], turn=False)
        return sum(gaps[:5]) / abs(box.half) ** 2

    return max((f for f in drawing.frames if f.scheme == normal), key=room)


def _view(drawing: Drawing, frames: Sequence[Frame], *, turn: bool) -> Box:
    """What has to be seen of the sheet, with a margin."""
    names = {
        mark.point
        for frame in frames
        for mark in drawing.schemes[frame.scheme].marks
        if is_main(mark.point) and not mark.point.startswith("S")
    }
    points = [frame.points[name] for frame in frames for name in names if name in frame.points]
    for plane in drawing.planes:
        points += trail(plane, drawing.frames)
        points.append(plane.displacement.origin)
        axis = plane.scaled_velocity
        values = graduation_of(axis, trail(plane, drawing.frames)).values
        points += [axis.at(value) for value in values]
    if turn:
        points += [
            vertex
            for curve in drawing.curves
            if curve.role not in _BODY_CURVES
            for vertex in curve.vertices
        ]
    left, right = min(z.real for z in points), max(z.real for z in points)
    bottom, top = min(z.imag for z in points), max(z.imag for z in points)
    margin = 0.05 * max(right - left, top - bottom) or 0.01
    return Box(
        complex(left + right, bottom + top) / 2,
        complex(right - left, top - bottom) / 2 + margin * (1 + 1j),
    )
