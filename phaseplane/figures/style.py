"""The look of printed pictures: ground, type, width, and output to files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Figure  # noqa: PLC0414  (used in annotations elsewhere)
from matplotlib.font_manager import findfont
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from phaseplane.picture import styles as hues
from phaseplane.picture.files import replace_file
from phaseplane.picture.styles import Hue, Shade

COLOURS = (
    hues.BLUE, hues.ORANGE, hues.GREEN, hues.VIOLET, hues.RED, hues.TEAL, hues.PINK, hues.OCHRE
)  # fmt: skip
"""Hues of curves beside one another, as many as can be distinguished."""
DASHES = ("-", "--", "-.", ":")
"""Of curves over one another, and of black ones."""

_MATHS = {"serif": "dejavuserif", "STIXGeneral": "stix", "cmr10": "cm"}
"""The type of formulas that goes with a font."""
_FALLBACK = "DejaVu Sans"  # has the subscripts, primes and bars that other fonts may lack

_BEFORE_UNIT = re.compile(r"(?<=\d) (?=(?:ms|s|mm|cm|m|m/s|km/h|Hz)\b)")
HEADING = "heading"
"""The `gid` of the texts above a picture, which a publisher sets as its caption."""


def heading_lines(texts: Iterable[str], width: float) -> list[str]:
    """Return texts in lines that fit into the width of a figure, inches; numbers keep their units."""
    most = max(20, int(13 * width))
    joined = (_BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", text) for text in texts)
    return [line.replace("\N{NO-BREAK SPACE}", " ") for text in joined for line in wrap(text, most)]


class Palette:
    """Colours of the ground and of everything without a role; mono in the colour of the ink alone."""

    def __init__(self, shade: Shade, mono: bool = False) -> None:
        self.shade, self.mono = shade, mono
        self.paper, self.ink = hues.PAPER.on(shade), hues.INK.on(shade)
        self.faint, self.grid = hues.GREY.on(shade), hues.GRID.on(shade)
        self.tint = hues.SHADE.on(shade)  # the ground of intervals

    def of(self, hue: Hue) -> str:
        """Return a hue on this ground."""
        if not self.mono:
            return hue.on(self.shade)
        return self.faint if hue is hues.GREY else self.ink

    def chart(self, hue: Hue) -> str:
        """Return a hue in a chart, the same on light and on dark ground."""
        return self.of(hue) if self.mono else hue.on("either")

    def curve(self, number: int) -> dict[str, Any]:
        """Return colour and dashes of one of several curves; only black lines are dashed."""
        dashes = DASHES[number % len(DASHES)] if self.mono else "-"
        return {"color": self.chart(COLOURS[number % len(COLOURS)]), "linestyle": dashes}

    def halo(self) -> list[AbstractPathEffect]:
        """Return an outline in the colour of the paper that keeps text legible on lines."""
        return [withStroke(linewidth=2.5, foreground=self.paper)]


@dataclass(frozen=True, slots=True)
class Look:
    """How a picture is to be printed.

    Parameters
    ----------
    dark : on a dark ground
    width : of the picture, m; None for the size that suits its contents
    font : family of the type, such as `serif` or `STIXGeneral`; empty for matplotlib's own
    mono : black lines, distinguished by dashes
    headed : with a heading; without it the words are for the caption

    Raises
    ------
    ValueError : if the font is not installed.
    """

    dark: bool = False
    width: float | None = None
    font: str = ""
    mono: bool = False
    headed: bool = True

    def __post_init__(self) -> None:
        if self.font:
            try:
                findfont(self.font, fallback_to_default=False)
            except ValueError:
                raise ValueError(
                    f"font {self.font!r} is not installed; try serif, sans-serif or STIXGeneral"
                ) from None

    @property
    def palette(self) -> Palette:
        """Its colours."""
        return Palette("dark" if self.dark else "light", self.mono)

    @property
    def inches(self) -> float | None:
        """Its width in inches."""
        return None if self.width is None else self.width / 0.0254

    def blank(self, width: float, height: float) -> Figure:
        """Return an empty figure of this size, inches, or of this shape in the width asked for."""
        inches = self.inches or width
        return new_figure(inches, height * inches / width, self.palette)

    def entitled(self, figure: Figure, title: str) -> Figure:
        """Return a figure with a title above it, in lines that fit."""
        if title:
            self.head(figure, "\n".join(heading_lines([title], figure.get_figwidth())))
        return printed(figure, self)

    def head(self, figure: Figure, words: str, **where: Any) -> None:
        """Write words above a figure."""
        figure.suptitle(words, color=self.palette.ink, fontsize=11.0, gid=HEADING, **where)


PLAIN = Look()
"""The look of a picture on a screen: in colour on white, as large as it needs to be."""


def dress(axes: Axes, palette: Palette, label_size: float, *, grid: bool = True) -> None:
    """Set background, title, labels, ticks, frame and grid of axes to the colours of the palette."""
    axes.set_facecolor(palette.paper)
    axes.set_axisbelow(True)
    for text in (axes.title, axes.xaxis.label, axes.yaxis.label):
        text.set_color(palette.ink)
    axes.tick_params(colors=palette.ink, labelsize=label_size, which="both")
    for spine in axes.spines.values():
        spine.set_color(palette.faint)
    if grid:
        axes.grid(color=palette.grid, linewidth=0.6)


def draw_zero(axes: Axes, palette: Palette) -> None:
    """Draw faint lines through the origin."""
    axes.axhline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)
    axes.axvline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)


def new_figure(width: float, height: float, palette: Palette) -> Figure:
    """Return an empty figure; width and height in inches."""
    figure = Figure(figsize=(width, height), dpi=150, facecolor=palette.paper)
    FigureCanvasAgg(figure)
    return figure


def printed(figure: Figure, look: Look) -> Figure:
    """Return a figure with the type and without the heading, if the look asks for it."""
    for text in figure.findobj(Text) if look.font else ():
        text.set_fontfamily([look.font, _FALLBACK])
        text.set_math_fontfamily(_MATHS.get(look.font, "dejavusans"))
    for text in headings(figure) if not look.headed else ():
        text.set_visible(False)
    return figure


def headings(figure: Figure) -> list[Text]:
    """Return the texts above a figure. Accessing its axes would create all ticks."""
    return [text for text in figure.texts if text.get_gid() == HEADING]


# Without dates and random names, equal figures give equal files.
_OPTIONS: dict[str, dict[str, Any]] = {
    # a sixth larger than at zlib's default level, in half the time
    ".png": {"pil_kwargs": {"compress_level": 1}},
    ".svg": {"metadata": {"Date": None}},
    ".pdf": {"metadata": {"CreationDate": None}},
}
# Type that publishers accept, and texts that can be searched for.
_TYPE: Any = {"svg.hashsalt": "phaseplane", "svg.fonttype": "none", "pdf.fonttype": 42}


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure, completely or not at all, in the format of the suffix.

    Its heading is the title of the file. Fonts in PDF are TrueType, texts in SVG are texts.

    Parameters
    ----------
    path : ends with .png, .svg or .pdf; an existing file is replaced

    Raises
    ------
    ValueError : if the suffix is another.
    OSError : if the folder does not exist or cannot be written to.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in _OPTIONS:
        raise ValueError(f"{target.name}: figures are written as {', '.join(_OPTIONS)}")
    above = [text for text in headings(figure) if text.get_text()]
    words = "; ".join(" ".join(text.get_text().split()) for text in above)
    metadata = {**_OPTIONS[suffix].get("metadata", {}), **({"Title": words} if words else {})}
    hidden = bool(above) and not any(text.get_visible() for text in above)
    plated = _with_plates(figure) if suffix != ".png" else nullcontext()
    with replace_file(target) as temporary, rc_context(_TYPE), plated:
        figure.savefig(
            temporary,
            format=suffix[1:],
            facecolor=figure.get_facecolor(),
            bbox_inches=_without_room_above(figure) if hidden else None,
            **{**_OPTIONS[suffix], "metadata": metadata},
        )
    return target


def _without_room_above(figure: Figure) -> Bbox:
    """Return the part of a figure that its contents take up in height, and its whole width, inches."""
    contents, margin = figure.get_tightbbox(), 0.02
    return Bbox.from_extents(0.0, contents.y0 - margin, figure.get_figwidth(), contents.y1 + margin)


@contextmanager
def _with_plates(figure: Figure) -> Iterator[None]:
    """Replace the outlines of texts by plates, because outlined texts would be written as paths."""
    outlined = [text for text in figure.findobj(Text) if text.get_path_effects()]
    effects = [text.get_path_effects() for text in outlined]
    plate = {"facecolor": figure.get_facecolor(), "edgecolor": "none", "pad": 0.4, "alpha": 0.75}
    for text in outlined:
        text.set_path_effects([])
        text.set_bbox(plate)
    try:
        yield
    finally:
        for text, before in zip(outlined, effects, strict=True):
            text.set_bbox(None)
            text.set_path_effects(before)
