"""One step of a construction as a storyboard: a picture for each stage, in print on pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from textwrap import fill

from matplotlib.figure import Figure

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import draw_curves
from phaseplane.picture.page import Item
from phaseplane.picture.paper import Box
from phaseplane.picture.story import arms_page, stage_captions, staged
from phaseplane.picture.styles import MOVING_POINT
from phaseplane.picture.text import format_time
from phaseplane.picture.views import frame_at, view_of

from .canvas import Sheet, new_page, size_of
from .planes import step_lines
from .style import PLAIN, Look, Printed, heading_lines, styled

_WIDTH = 11.0  # inches, on a screen
_NARROWEST, _LOWEST = 1.6, 0.95  # inches of a picture; the height is that of a plane
_HIGHEST = 4.5  # inches of a picture
_GAP = 0.2  # inches between pictures
_LINE = 0.125  # inches of a line of a caption
_EDGE = 0.05  # inches below the heading
_PAGE = 10.1  # inches, the height of a page: A4 without margins of 2 cm


@dataclass(frozen=True, slots=True)
class _Picture:
    """A picture: its view, what is drawn in it, its size, inches, its caption, and its stage if any."""

    view: Box
    items: tuple[Item, ...]
    size: complex
    caption: str
    stage: int = 0


@dataclass(frozen=True, slots=True)
class _Row:
    """Pictures in columns: the height of a row with its captions and the width of a column, inches."""

    height: float
    column: float
    pictures: tuple[_Picture, ...]


@styled
def storyboard(
    drawing: Drawing, frame: int | None = None, *, title: str = "", look: Look = PLAIN
) -> Figure:
    """Draw a step as a strip of small pictures, one for each stage.

    In a width for print the strip is divided into pages that are no higher than one of A4; the first is
    returned, with those that follow it.

    Parameters
    ----------
    frame : index of the step; default: one whose letters have room

    Raises
    ------
    ValueError : if there is no such frame.
    """
    chosen = frame_at(drawing, frame)
    view = view_of(drawing, [chosen], turn=False)
    width = look.inches or _WIDTH
    slope = view.half.imag / view.half.real
    lowest = _LOWEST * len(drawing.planes)
    columns = max(1, min(3, int(width / max(_NARROWEST, lowest / slope))))
    wide = width / columns - _GAP
    captions = [fill(caption, int(13.0 * wide)) for caption in stage_captions(drawing, chosen)]
    count = len(captions)
    below = 0.2 + _LINE * max(text.count("\n") + 1 for text in captions)

    def heading(stages: Sequence[int]) -> tuple[str, str]:
        return title, f"Step {chosen.step}, {format_time(chosen.time)}, {_which(stages, count)}"

    room = inf
    if look.inches:  # in print; a screen shows a strip of any height
        room = _PAGE - _EDGE - look.heading_room(heading_lines(heading([count - 1, count]), width))
    high = min(wide * slope, _HIGHEST, max(lowest, room / 2.0 - below))  # two rows on a page
    scale = min(wide / view.half.real, high / view.half.imag) / 2.0
    stays = new_page(drawing, view, look, scale=scale)
    lines = step_lines(stays, chosen)
    draw_axes(stays, lines)
    draw_curves(stays, clear=lines)
    arms = arms_page(drawing, drawing.frames.at([chosen.step]))
    ticks = list(staged(stays, arms, chosen.step))
    pictures = [
        _Picture(view, (*stays.items, *tick.page.items), complex(wide, high), caption, k)
        for k, (tick, caption) in enumerate(zip(ticks, captions, strict=True), 1)
    ]
    last: list[_Row] = []
    if turned := next((k for k, tick in enumerate(ticks, 1) if tick.arms.items), 0):
        items = (*arms.items, *ticks[turned - 1].arms.items)
        words = f"The arm of the turn angles in stage {turned}"
        arm = _Picture(arms.view, items, size_of(arms), words)
        if count % columns and arm.size.real <= wide and arm.size.imag <= high:
            pictures.append(arm)  # beside the last stage
        else:
            last = [_Row(arm.size.imag + 0.2 + _LINE, width, (arm,))]
    rows = [
        _Row(high + below, width / columns, tuple(pictures[k : k + columns]))
        for k in range(0, len(pictures), columns)
    ]
    first, *following = [
        _page(
            page, look, width, heading([p.stage for row in page for p in row.pictures if p.stage])
        )
        for page in _pages([*rows, *last], room)
    ]
    first.following = tuple(following)
    first.set_label(" ".join(filter(None, heading(range(1, count + 1)))))  # of all in one file
    return first


def _which(stages: Sequence[int], count: int) -> str:
    """Return what the heading says of the stages on a page."""
    if len(stages) == count:
        return "stage by stage"
    if len(stages) < 2:
        return f"stage {stages[0]} of {count}" if stages else "the arm of the turn angles"
    between = "and" if len(stages) == 2 else "to"
    return f"stages {stages[0]} {between} {stages[-1]} of {count}"


def _pages(rows: Iterable[_Row], room: float) -> Iterator[list[_Row]]:
    """Yield as many rows at a time as have room, and at least one."""
    page: list[_Row] = []
    for row in rows:
        if page and sum(other.height for other in page) + row.height > room:
            yield page
            page = []
        page.append(row)
    yield page


def _page(rows: Sequence[_Row], look: Look, width: float, heading: Sequence[str]) -> Printed:
    """Return the figure of some rows, one below the other."""
    top = sum(row.height for row in rows) + _EDGE
    sheet = Sheet(Printed(look, width, top, layout="none"))
    sheet.figure.finished(*heading)
    for row in rows:
        foot = top - max(picture.size.imag for picture in row.pictures)
        for k, picture in enumerate(row.pictures):
            left = k * row.column + (row.column - picture.size.real) / 2.0
            sheet.place(picture.view, complex(left, foot), picture.size)
            for item in picture.items:
                if item.role not in MOVING_POINT[:2]:  # nothing moves here
                    sheet.draw(item)
            sheet.axes.set_title(picture.caption, y=0.0, pad=-4.0, va="top", fontsize=7.5)
        top -= row.height
    return sheet.figure
