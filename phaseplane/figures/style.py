"""The look of printed pictures: ground, type, width, and output to files."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from textwrap import wrap
from typing import Any, ParamSpec, TypeVar

from matplotlib import rc_context, rcParamsDefault
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Figure  # noqa: PLC0414  (used in annotations elsewhere)
from matplotlib.font_manager import findfont
from matplotlib.transforms import ScaledTranslation

from phaseplane.picture import styles as hues
from phaseplane.picture.files import replace_file
from phaseplane.picture.styles import Hue, Shade

DASHES = ("-", "--", "-.", ":")
"""Of curves over one another, and of black ones."""

_MATHS = {"serif": "dejavuserif", "STIXGeneral": "stix", "cmr10": "cm"}
"""The type of formulas that goes with a font."""
_FALLBACK = "DejaVu Sans"  # has the subscripts, primes and bars that other fonts may lack

# Whatever a user sets for figures of their own, by a file or in a notebook, would change the places of
# letters, or need TeX. Only drawing is set: not which windows and programs there are.
_ELSEWHERE = (
    "animation", "backend", "docstring", "interactive", "timezone", "tk", "toolbar", "webagg",
)  # fmt: skip
_DEFAULTS: Any = {
    key: value for key, value in rcParamsDefault.items() if not key.startswith(_ELSEWHERE)
} | {
    # type that publishers accept, and texts that can be searched for
    "svg.hashsalt": "phaseplane", "svg.fonttype": "none", "pdf.fonttype": 42,
}  # fmt: skip

_AWAY = 0.5  # inches between an axis and its name, with its values
_KEPT = "\N{NO-BREAK SPACE}"
_TOGETHER = re.compile(r"(?<=\d) (?=(?:ms|s|mm|cm|m|m/s|km/h|Hz)\b)| (?==)|(?<= =) ")
_PARTS = re.compile(r"(?<=:)(?= )|(?= {3}\()")  # of a title: an equation, a list in brackets

P = ParamSpec("P")
Made = TypeVar("Made")


def heading_lines(texts: Iterable[str], width: float) -> list[str]:
    """Return texts in lines that fit into the width of a figure, inches.

    If they can, lines end between the parts of a text. No line ends before a unit or beside a sign
    of equality.
    """
    most, lines = max(20, int(13 * width)), []
    for text in texts:
        lines.append("")
        for part in _PARTS.split(_TOGETHER.sub(_KEPT, text)):
            if len(lines[-1] + part) <= most:
                lines[-1] += part
            else:
                lines += wrap(part.strip(), most)
    return [line.replace(_KEPT, " ") for line in lines if line]


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
        return {"color": self.chart(hues.hue_of("", number)), "linestyle": dashes}

    def plate(self) -> dict[str, Any]:
        """Return a ground that keeps text legible on lines; an outline would make it paths in SVG."""
        return {"facecolor": self.paper, "edgecolor": "none", "pad": 0.4, "alpha": 0.85}


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

    @property
    def settings(self) -> Any:
        """The settings of matplotlib that give it, whatever the user's are."""
        palette = self.palette
        fonts = {
            "font.family": [self.font, _FALLBACK],
            "mathtext.fontset": _MATHS.get(self.font, "dejavusans"),
        }
        return {
            **_DEFAULTS,
            "figure.dpi": 150, "figure.facecolor": palette.paper, "figure.titlesize": 10.0,
            "text.color": palette.ink, "axes.facecolor": palette.paper,
            "axes.edgecolor": palette.faint, "axes.labelcolor": palette.ink,
            "axes.labelsize": 9.0, "axes.titlesize": 9.5,
            "axes.axisbelow": True, "axes.grid": True,
            # values so short that names of axes, which stand at one distance, are clear of them
            "axes.formatter.limits": (-3, 5), "axes.formatter.use_mathtext": True,
            "grid.color": palette.grid, "grid.linewidth": 0.6,
            "xtick.color": palette.ink, "ytick.color": palette.ink,
            "xtick.labelsize": 8.0, "ytick.labelsize": 8.0,
            "figure.constrained_layout.w_pad": 0.08, "figure.constrained_layout.h_pad": 0.06,
            "legend.frameon": False, "legend.fontsize": 8.0, "legend.title_fontsize": 8.0,
            "legend.handlelength": 4.0 if self.mono else 2.0,  # dashes need more
            **(fonts if self.font else {}),
        }  # fmt: skip

    def heading_room(self, lines: Sequence[str]) -> float:
        """Return the height of a heading in these lines, inches."""
        return 0.1 + 0.17 * len(lines) if lines and self.headed else 0.0

    def blank(self, width: float, height: float) -> Printed:
        """Return an empty figure of this size, inches, or of this shape in the width asked for."""
        inches = self.inches or width
        return Printed(self, inches, height * inches / width)


PLAIN = Look()
"""The look of a picture on a screen: in colour on white, as large as it needs to be."""


def styled(draw: Callable[P, Made]) -> Callable[P, Made]:
    """Return a function that draws in the look which is its argument of that name."""

    @wraps(draw)
    def drawn(*args: P.args, **named: P.kwargs) -> Made:
        look: Any = named.get("look", PLAIN)
        with rc_context(look.settings):
            return draw(*args, **named)

    return drawn


class Printed(Figure):
    """A figure in a look, of this size in inches, or higher if there is something around its panels.

    It may be the first of several pages: `following` has the others. Its look is in force again while it
    is drawn, because ticks are not made before. Its heading is its label, whether it is written above
    the panels or left to the caption.
    """

    def __init__(
        self, look: Look, width: float, height: float, layout: Any = "constrained"
    ) -> None:
        super().__init__(figsize=(width, height), layout=layout)
        self.look = look
        self.following: tuple[Figure, ...] = ()
        FigureCanvasAgg(self)

    def draw(self, renderer: RendererBase) -> None:
        """Draw it."""
        with rc_context(self.look.settings):
            super().draw(renderer)

    def finished(self, *heading: str) -> Printed:
        """Write the heading in lines that fit, and lay the figure out, so that it is saved alike."""
        lines = heading_lines(heading, self.get_figwidth())
        self.set_label(" ".join(lines))
        if room := self.look.heading_room(lines):
            self.grow(room)
            words = self.suptitle("\n".join(lines), gid="heading")
            words.set_y(1.0 - 0.06 / self.get_figheight())
        if (engine := self.get_layout_engine()) is not None:
            engine.execute(self)
            self.set_layout_engine("none")
        return self

    def key(self, handles: Sequence[Artist], **more: Any) -> None:
        """Put a legend below the panels, in as many columns as fit."""
        for columns in range(len(handles), 0, -1):
            legend = self.legend(handles=handles, loc="outside lower center", ncols=columns, **more)
            box = legend.get_window_extent()
            if columns == 1 or box.width <= self.bbox.width:
                self.grow(box.height / self.dpi)
                return
            legend.remove()

    def grow(self, height: float) -> None:
        """Make room for something around the panels, inches."""
        self.set_figheight(self.get_figheight() + height)


def name_up(axes: Axes, words: str) -> None:
    """Name the axis that points up, as far from it in every panel."""
    place = ScaledTranslation(-_AWAY, 0.0, axes.figure.dpi_scale_trans)
    axes.yaxis.set_label_coords(0.0, 0.5, axes.transAxes + place)
    axes.set_ylabel(words)


def draw_zero(axes: Axes, palette: Palette) -> None:
    """Draw faint lines through the origin."""
    axes.axhline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)
    axes.axvline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)


# Without dates and random names, equal figures give equal files.
_OPTIONS: dict[str, dict[str, Any]] = {
    # a sixth larger than at zlib's default level, in half the time
    ".png": {"pil_kwargs": {"compress_level": 1}},
    ".svg": {"metadata": {"Date": None}},
    ".pdf": {"metadata": {"CreationDate": None}},
}


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure, completely or not at all, in the format of the suffix.

    Its heading is the title of the file. Fonts in PDF are TrueType, texts in SVG are texts.

    Parameters
    ----------
    path : ends with .png, .svg or .pdf; an existing file is replaced. If the figure has several pages,
        `files_of` it has the others

    Returns
    -------
    The path.

    Raises
    ------
    ValueError : if the suffix is another.
    OSError : if the folder does not exist or cannot be written to.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in _OPTIONS:
        raise ValueError(f"{target.name}: figures are written as {', '.join(_OPTIONS)}")
    pages = pages_of(figure)
    title = {"Title": figure.get_label()} if figure.get_label() else {}
    options = {**_OPTIONS[suffix], "metadata": {**_OPTIONS[suffix].get("metadata", {}), **title}}
    if suffix == ".pdf":
        from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415  (for PDF alone)

        with (
            replace_file(target) as temporary,
            rc_context(_DEFAULTS),
            PdfPages(temporary, **options) as file,
        ):
            for page in pages:
                page.savefig(file, format="pdf", facecolor="auto")
        return target
    for page, file in zip(pages, files_of(figure, target), strict=True):
        with replace_file(file) as temporary, rc_context(_DEFAULTS):
            page.savefig(temporary, format=suffix[1:], facecolor="auto", **options)
    return target


def files_of(figure: Figure, path: Path) -> list[Path]:
    """Return the files that `save` writes: a PDF with all pages, or one of each page.

    The names of those of the second, third, ... page end in _2, _3, ...
    """
    more = 0 if path.suffix.lower() == ".pdf" else len(pages_of(figure)) - 1
    return [path, *(path.with_stem(f"{path.stem}_{k + 2}") for k in range(more))]


def pages_of(figure: Figure) -> list[Figure]:
    """Return the pages of a figure, of which it is the first."""
    return [figure, *getattr(figure, "following", ())]
