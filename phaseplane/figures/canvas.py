"""A page as a figure: the canvas of matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from phaseplane.constructions.letters import is_letter
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.page import TYPE, Arrow, Dots, Item, Lines, Page, Text
from phaseplane.picture.paper import Box, vertices
from phaseplane.picture.styles import style_of
from phaseplane.picture.subject import Subject

from .style import PLAIN, Look, Printed, styled

_LARGEST = (11.0, 10.0)  # inches that the sheet may take up
BESIDE = 0.1  # inches
_ABOVE = {"trail": 3.0, "normal": 3.0, "arc": 3.5, "successor": 3.5}  # order of drawing; others 2


def new_page(drawing: Drawing, view: Box, look: Look, scale: float = 0.0) -> Page:
    """Return an empty page with type of the right size for a scale, in of the figure for a m of paper."""
    size = 2.0 * view.half
    if not scale and look.inches is not None:
        scale = max(0.5, look.inches - 2 * BESIDE) / size.real
    scale = scale or min(_LARGEST[0] / size.real, _LARGEST[1] / size.imag)
    return Page(Subject(drawing), view, TYPE / 72.0 / scale)


def size_of(page: Page) -> complex:
    """Return the width and height of a page with type of its size, inches."""
    return complex(2.0 * page.view.half * (TYPE / 72.0 / page.em))


class Sheet:
    """A figure on which pages are drawn, one beside another or one after another."""

    def __init__(self, figure: Printed) -> None:
        self.figure, self.palette = figure, figure.look.palette
        self.axes: Axes

    @classmethod
    def of(cls, page: Page, look: Look, *heading: str, below: float = 0.0) -> Sheet:
        """Return the figure of a page with a heading above it, and a legend or so much room below, in."""
        size = size_of(page)
        width, height = size.real + 2 * BESIDE, size.imag + 2 * BESIDE
        sheet = cls(Printed(look, width, height, layout="none"))
        if below:
            sheet.figure.grow(below)
        else:
            sheet.figure.key([sheet.handle(*entry) for entry in page.legend()])
        foot = sheet.figure.get_figheight() - height
        sheet.figure.finished(*heading)
        sheet.place(page.view, complex(BESIDE, BESIDE + foot), size)
        for item in page.items:
            sheet.draw(item)
        return sheet

    def place(self, view: Box, corner: complex, size: complex) -> Axes:
        """Draw in a part of the figure from now on, with this lower left corner and size, inches."""
        width, height = self.figure.get_size_inches()
        self.axes = self.figure.add_axes(
            (corner.real / width, corner.imag / height, size.real / width, size.imag / height)
        )
        self.axes.set_aspect("equal")
        self.axes.set_axis_off()
        low, high = view.corners
        self.axes.set(xlim=(low.real, high.real), ylim=(low.imag, high.imag))
        return self.axes

    def dashes(self, role: str) -> Any:
        """Return the dashes of a role, which distinguish lines of one colour."""
        style = style_of(role)
        return (0, style.mono) if self.palette.mono and style.mono else style.dash

    def draw(self, item: Item) -> Artist:
        """Draw one item."""
        role, style = item.role, style_of(item.role)
        colour = self.palette.of(style.hue)
        match item:
            case Lines():
                lines = LineCollection(
                    [vertices(strip) for strip in item.strips], colors=colour,
                    linewidths=style.width * item.weight, linestyles=self.dashes(role),
                    alpha=item.strength, capstyle="round", zorder=_ABOVE.get(role, 2.0), gid=role,
                )  # fmt: skip
                return self.axes.add_collection(lines, autolim=False)
            case Dots():
                return self.axes.plot(
                    *vertices(item.points).reshape(-1, 2).T, "o", color=colour,
                    markersize=style.size * item.weight, markeredgecolor=self.palette.paper,
                    markeredgewidth=0.5, alpha=item.strength, zorder=4.0, gid=role,
                )[0]  # fmt: skip
            case Arrow():
                heads = "<|-|>" if item.both else "-|>"
                head = "0.15,head_length=0.4" if item.both else "0.2,head_length=0.5"
                width = 0.7 if item.both else style.width
                tip, start = ((z.real, z.imag) for z in (item.tip, item.start))
                return self.axes.annotate(
                    "", tip, start, zorder=5.0 if item.both or not item.shaft else 1.5,
                    arrowprops={
                        "arrowstyle": f"{heads},head_width={head}", "color": colour,
                        "linewidth": width if item.shaft else 0.0, "shrinkA": 0, "shrinkB": 0,
                    },
                )  # fmt: skip
            case Text():
                return self.axes.text(
                    item.centre.real, item.centre.imag, item.text, color=colour,
                    fontsize=TYPE * item.size,
                    fontstyle="italic" if is_letter(item.text) else "normal", ha="center",
                    va="center", rotation=90.0 if item.upright else 0.0, bbox=self.palette.plate(),
                    alpha=item.strength, zorder=3.5 if item.kind == "name" else 6.0,
                    gid="axis_name" if item.kind == "name" else item.kind,
                )  # fmt: skip

    def handle(self, role: str, words: str) -> Line2D:
        """Return the line of an entry in the legend, or the mark of events."""
        style, mark = style_of(role), role == "event"
        return Line2D(
            [], [], color=self.palette.of(style.hue), label=words, marker="o" if mark else "",
            markersize=4.0, linestyle="" if mark else self.dashes(role),
            linewidth=style.width if self.palette.mono else 1.6, dash_capstyle="round",
        )  # fmt: skip


def as_figure(draw: Callable[..., tuple[Page, str]]) -> Callable[..., Figure]:
    """Return a function that makes a figure of a page, with a title and the words that `draw` returns.

    The title and the look of the figure are named arguments; by default there is no title.
    """

    @styled
    @wraps(draw)
    def figure(
        drawing: Drawing, *args: Any, title: str = "", look: Look = PLAIN, **more: Any
    ) -> Figure:
        page, words = draw(drawing, *args, look=look, **more)
        return Sheet.of(page, look, title, *words.split("\n")).figure

    return figure
