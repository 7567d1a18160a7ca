"""A page as a figure: the canvas of matplotlib."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from textwrap import fill
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
_BESIDE = 0.1  # inches
_LINE = 0.155  # inches of a line of a caption
_ABOVE = {"trail": 3.0, "normal": 3.0, "arc": 3.5, "successor": 3.5}  # order of drawing; others 2
_DASH_DOT_DOT = (0, (4, 2.5, 0.1, 2.5, 0.1, 2.5))
_MONO: dict[str, Any] = {  # of lines with round ends; only the integral curve is solid
    "run": (0, (1, 2)),
    "auxiliary": (0, (12, 3)),
    "line": (0, (5, 3)),
    "shortcut": (0, (8, 3, 0.1, 3)),
    "excitation": (0, (0.1, 2)),
    "projection": (0, (2, 3)),
    "normal": (0, (5, 2.5, 0.1, 2.5)),
    "arc": _DASH_DOT_DOT,
    "successor": _DASH_DOT_DOT,
    "turn": (0, (0.1, 4)),
}


def new_page(drawing: Drawing, view: Box, look: Look, scale: float = 0.0) -> Page:
    """Return an empty page with type of the right size for a scale, in of the figure for a m of paper."""
    return Page(Subject(drawing), view, TYPE / 72.0 / (scale or _scale(view, look)))


def _scale(view: Box, look: Look) -> float:
    """Return the inches of a figure for a metre of paper."""
    size = 2.0 * view.half
    if look.inches is not None:
        return max(0.5, look.inches - 2 * _BESIDE) / size.real
    return min(_LARGEST[0] / size.real, _LARGEST[1] / size.imag)


class Sheet:
    """A figure of a page, and of the pages that follow it in an animation.

    The pages of an animation have captions, of which one at a time takes the place of the legend; there
    may be room below them, inches.
    """

    def __init__(self, look: Look, captions: Sequence[str] = (), below: float = 0.0) -> None:
        self.look = look
        self.palette = look.palette
        self.figure: Printed
        self.axes: Axes
        self.moving: list[Artist] = []
        self.captions, self.below = captions, below

    def begin(self, page: Page, *heading: str) -> Printed:
        """Return the figure of a page, with a heading above it and a legend below."""
        size = 2.0 * page.view.half * _scale(page.view, self.look)
        width, height = size.real + 2 * _BESIDE, size.imag + 2 * _BESIDE
        self.figure = Printed(self.look, width, height, layout="none")
        if self.captions:
            self.captions = [fill(text, int(11 * width)) for text in self.captions]
            rows = 1 + max(text.count("\n") + 1 for text in self.captions)
            self.figure.grow(self.below + _LINE * rows)
        else:
            self.figure.key([self._handle(*entry) for entry in page.legend()])
        below = self.figure.get_figheight() - height
        self.figure.finished(*heading)
        self.place(page.view, complex(_BESIDE, _BESIDE + below), size)
        for item in page.items:
            self.draw(item)
        return self.figure

    def place(self, view: Box, corner: complex, size: complex) -> None:
        """Draw in a part of the figure from now on, with this lower left corner and size, inches."""
        width, height = self.figure.get_size_inches()
        self.axes = self.figure.add_axes(
            (corner.real / width, corner.imag / height, size.real / width, size.imag / height)
        )
        self.axes.set_aspect("equal")
        self.axes.set_axis_off()
        low, high = view.corners
        self.axes.set_xlim(low.real, high.real)
        self.axes.set_ylim(low.imag, high.imag)

    def frame(self, page: Page) -> None:
        """Draw a page in place of the one before."""
        for artist in self.moving:
            artist.remove()
        self.moving = [self.draw(item) for item in page.items]

    def colour(self, role: str) -> str:
        """Return the colour of a role."""
        return self.palette.of(style_of(role).hue)

    def draw(self, item: Item) -> Artist:
        """Draw one item."""
        if isinstance(item, Lines):
            return self._lines(item)
        if isinstance(item, Dots):
            return self._dots(item)
        if isinstance(item, Arrow):
            return self._arrow(item)
        return self._text(item)

    def _lines(self, item: Lines) -> Artist:
        style = style_of(item.role)
        lines = LineCollection(
            [vertices(strip) for strip in item.strips], colors=self.colour(item.role),
            linewidths=style.width * item.weight, linestyles=self.dashes(item.role),
            alpha=item.strength, capstyle="round",
            zorder=_ABOVE.get(item.role, 2.0), gid=item.role,
        )  # fmt: skip
        return self.axes.add_collection(lines, autolim=False)

    def dashes(self, role: str) -> Any:
        """Return the dashes of a role, which distinguish lines of one colour."""
        dash = style_of(role).dash
        return _MONO.get(role, dash) if self.palette.mono else dash

    def _dots(self, item: Dots) -> Artist:
        return self.axes.plot(
            [z.real for z in item.points], [z.imag for z in item.points], "o",
            color=self.colour(item.role), markersize=style_of(item.role).size * item.weight,
            markeredgecolor=self.palette.paper, markeredgewidth=0.5, alpha=item.strength, zorder=4.0,
            gid=item.role,
        )[0]  # fmt: skip

    def _arrow(self, item: Arrow) -> Artist:
        heads = "<|-|>" if item.both else "-|>"
        head = "0.15,head_length=0.4" if item.both else "0.2,head_length=0.5"
        width = 0.7 if item.both else style_of(item.role).width
        tip, start = ((z.real, z.imag) for z in (item.tip, item.start))
        return self.axes.annotate(
            "", tip, start, zorder=5.0 if item.both or not item.shaft else 1.5,
            arrowprops={
                "arrowstyle": f"{heads},head_width={head}", "color": self.colour(item.role),
                "linewidth": width if item.shaft else 0.0, "shrinkA": 0, "shrinkB": 0,
            },
        )  # fmt: skip

    def _text(self, item: Text) -> Artist:
        return self.axes.text(
            item.centre.real, item.centre.imag, item.text, color=self.colour(item.role),
            fontsize=TYPE * item.size, fontstyle="italic" if is_letter(item.text) else "normal",
            ha="center", va="center", rotation=90.0 if item.upright else 0.0,
            bbox=self.palette.plate(), alpha=item.strength, zorder=6.0,
            gid="axis_name" if item.kind == "name" else item.kind,
        )  # fmt: skip

    def _handle(self, role: str, words: str) -> Line2D:
        """Return the line of an entry in the legend."""
        return Line2D(
            [], [], color=self.colour(role), linestyle=self.dashes(role), label=words,
            linewidth=style_of(role).width if self.palette.mono else 1.6, dash_capstyle="round",
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
        return Sheet(look).begin(page, title, *words.split("\n"))

    return figure
