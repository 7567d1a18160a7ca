"""The phase planes on the sheet: one step with all letters, or many with all auxiliary lines."""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.storage import Frame
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import draw_curves, draw_missed, draw_own_curves, draw_trails
from phaseplane.picture.frames import motions_of
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Box, Points
from phaseplane.picture.step import draw_step, mark_events, write_letters, write_numbers
from phaseplane.picture.text import format_time
from phaseplane.picture.views import frame_at, gathered, view_of

from .canvas import as_figure, new_page
from .style import Look

_MANY = 20  # steps with all auxiliary lines
_MOVED, _SEEN = 0.02, 0.4  # of the largest distance from the start: the motion begins, it is seen
_ROOMY = 65.0  # em: larger side of a sheet on which every point may be numbered
_NUMBERED = 80  # points beyond those with auxiliary lines, at the most


@as_figure
def phase_planes(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw the phase planes to scale with the whole motion, and one step with all letters.

    The style is that of AP57's figure 7. Lift-off U and touchdown V are marked.

    Parameters
    ----------
    frame : index of the lettered step; default: one whose letters have room

    Raises
    ------
    ValueError : if there is no such frame.
    """
    chosen = frame_at(drawing, frame)
    page = step_page(drawing, chosen, look)
    mark_events(page)
    write_letters(page, chosen)
    return page, f"{typeset(drawing.title)}\n{format_step(chosen)}"


def step_page(drawing: Drawing, frame: Frame, look: Look, beside: float = 0.0) -> Page:
    """Return axes, curves, the whole motion and the lines of one step, without letters.

    On the right there may be room for the distances of lines I and II, a fraction of the width.
    """
    view = view_of(drawing, [frame], turn=False)
    room = beside * view.half.real
    page = new_page(drawing, Box(view.centre + room, view.half + room), look)
    lines = step_lines(page, frame)
    if beside:
        ends = [plane.displacement.origin.imag for plane in drawing.planes]
        rows = np.array([[x - aside * page.em for aside in (0.0, 1.2)] for x in distances(page)])
        lines = np.append(lines, rows.reshape(-1, 1) + 1j * np.array(ends), axis=0)
    draw_axes(page, lines)
    draw_curves(page, clear=lines)
    draw_own_curves(page, frame)
    draw_trails(page, recent=0)  # the lettered step is rarely one of the last
    draw_missed(page)
    draw_step(page, frame)
    return page


def distances(page: Page) -> list[float]:
    """Return where the distances of the other plane and of lines I and II are dimensioned."""
    edge = page.view.corners[1].real
    return [edge - (1.0 + 3.2 * column) * page.em for column in range(3)]


def step_lines(page: Page, frame: Frame) -> Points:
    """Return the segments of the lines of a step."""
    beside = Page(page.subject, page.view, page.em)
    draw_step(beside, frame)
    return beside.segments


def format_step(frame: Frame) -> str:
    """Return the number and time of the lettered step as text."""
    return f"Step {frame.step} lettered, {format_time(frame.time)}"


@as_figure
def construction_sheet(
    drawing: Drawing, frames: Iterable[int] | None = None, *, through: bool = False, look: Look
) -> tuple[Page, str]:
    """Draw the sheet after many steps, with all their auxiliary lines.

    The style is that of AP57's figure 13: state points are numbered, turn angles share a common arm,
    and the curves continue to the end of the motion.

    Parameters
    ----------
    frames : indices of the steps drawn with all lines; indices beyond the end are ignored. Default: the
        first 20, or if nothing moves in them, 20 from the start of a motion, or in which it is seen
    through : whether later points are also marked and numbered, or some of them if they are many

    Raises
    ------
    ValueError : if none of the frames exists.
    """
    frames = _first(drawing) if frames is None else frames
    wanted = [i for i in frames if 0 <= i < len(drawing.frames)]
    if not wanted:
        raise ValueError(f"none of the frames exists; the drawing has {len(drawing.frames)}")
    drawing, chosen = gathered(drawing, drawing.frames.at(wanted))
    page = new_page(drawing, view_of(drawing, chosen, turn=True), look)
    draw_axes(page)
    draw_curves(page, None)
    for one in chosen:
        draw_step(page, one, ("step", "turn"), thin=0.6)
    draw_trails(page, recent=0)  # these steps are rarely the last
    draw_missed(page)
    mark_events(page)
    later = drawing.frames[wanted[-1] + 1 :] if through else []
    near = max(1, ceil(_ROOMY * page.em / page.view.size))
    apart = max(near, ceil(len(later) / _NUMBERED))
    every = (apart if later else near) == 1
    write_numbers(page, [*chosen[::near], *later[::apart]], end=every)
    last, end = chosen[-1].step + 1, drawing.frames[-1].step + 1
    words = f"Points {chosen[0].step} to {last} with all auxiliary lines"
    if later:
        words += f", {last + 1} to {end} along the curves"
    if not every:
        words += f", one in {apart} numbered"
    return page, f"{typeset(drawing.title)}\n{words}"


def _first(drawing: Drawing) -> range:
    """Return the first steps; if nothing moves in them, those after or until it is well seen to move."""
    motions = np.array(motions_of(drawing))
    away = abs(motions - motions[:, :1])
    most = np.nanmax(away, initial=0.0, axis=1)[:, None]
    begin, seen = (int((away > part * most).any(axis=0).argmax()) for part in (_MOVED, _SEEN))
    first = max(begin - 1, seen - _MANY) if begin > _MANY else 0
    return range(first, first + _MANY)
