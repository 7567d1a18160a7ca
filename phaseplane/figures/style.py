"""The common style of the pictures: colours, line styles, and output to files."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, withStroke


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours of the paper and of everything without a role."""

    paper: str
    ink: str
    faint: str
    grid: str
    shade: str

    def halo(self, width: float = 2.5) -> list[AbstractPathEffect]:
        """Return an outline in the colour of the paper that keeps text legible on lines."""
        return [withStroke(linewidth=width, foreground=self.paper)]


LIGHT = Palette(paper="#ffffff", ink="#222222", faint="#777777", grid="#e4e4e4", shade="#e9eef5")
DARK = Palette(paper="#15181c", ink="#e8e8e8", faint="#9a9a9a", grid="#2c3138", shade="#243040")


@dataclass(frozen=True, slots=True)
class RoleStyle:
    """The style of a role; by default its colour is the palette's faint ink."""

    colour: str = ""
    width: float = 0.8
    dash: Literal["-", "--", ":"] = "-"
    size: float = 3.0
    words: str = ""


BLUE, ORANGE, GREEN, RED = "#2f7fc1", "#d5651a", "#1f9e6e", "#d03c3c"
TEAL, PINK, OCHRE, GREY, VIOLET = "#1a9aa8", "#c65594", "#a8861b", "#8a8f98", "#8868c0"
COLOURS = (BLUE, ORANGE, GREEN, VIOLET, RED, TEAL, PINK, OCHRE)
"""Of curves beside one another, as many as can be distinguished."""

ROLES = {
    "trail": RoleStyle(BLUE, 1.8, words="integral curve"),
    "state": RoleStyle(BLUE, size=5.0),
    "auxiliary": RoleStyle(OCHRE, 1.0, words="auxiliary curve (of y)"),
    "line": RoleStyle(TEAL, 1.0, "--", words="lines I, II"),
    "shortcut": RoleStyle(RED, 1.0, "--", words="flight to x2 = x2st"),
    "foot": RoleStyle(width=0.7, dash=":"),
    "construction": RoleStyle(width=0.7),
    "excitation": RoleStyle(PINK, 2.0, words="road and weight"),
    "projection": RoleStyle(VIOLET, 0.8, words="projection"),
    "normal": RoleStyle(ORANGE, 1.4, size=4.0, words="normal"),
    "arc": RoleStyle(GREEN, 1.6, words="step P to P'"),
    "turn": RoleStyle(RED, 1.0, words="turn angle"),
    "successor": RoleStyle(GREEN, 1.6, size=4.5),
    "event": RoleStyle(RED, 1.6, size=7.0),
}
_UNKNOWN = RoleStyle()

SERIES = {
    "body": BLUE,
    "wheel": ORANGE,
    "suspension": GREEN,
    "road": GREY,
}


def palette_for(dark: bool) -> Palette:
    """Return the dark or the light palette."""
    return DARK if dark else LIGHT


def role_style(role: str) -> RoleStyle:
    """Return the style of a role; unknown roles are drawn like construction lines."""
    return ROLES.get(role, _UNKNOWN)


def dress(axes: Axes, palette: Palette, label_size: float, *, grid: bool = True) -> None:
    """Set background, ticks, frame and grid of axes to the colours of the palette."""
    axes.set_facecolor(palette.paper)
    axes.tick_params(colors=palette.ink, labelsize=label_size, which="both")
    for spine in axes.spines.values():
        spine.set_color(palette.faint)
    if grid:
        axes.grid(color=palette.grid, linewidth=0.6)


def new_figure(width: float, height: float, palette: Palette) -> Figure:
    """Return an empty figure; width and height in inches."""
    figure = Figure(figsize=(width, height), dpi=150, facecolor=palette.paper)
    FigureCanvasAgg(figure)
    return figure


# Without dates and random names, equal figures give equal files.
_OPTIONS: dict[str, dict[str, Any]] = {
    # a sixth larger than at zlib's default level, in half the time
    ".png": {"pil_kwargs": {"compress_level": 1}},
    ".svg": {"metadata": {"Date": None}},
    ".pdf": {"metadata": {"CreationDate": None}},
}


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure whole or not at all, in the format of the suffix.

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
    with written_whole(target) as temporary, rc_context({"svg.hashsalt": "phaseplane"}):
        figure.savefig(
            temporary,
            format=suffix[1:],
            facecolor=figure.get_facecolor(),
            **_OPTIONS[suffix],
        )
    return target


@contextmanager
def written_whole(target: Path) -> Iterator[Path]:
    """Yield a temporary file that replaces the target if writing succeeds.

    Raises
    ------
    OSError : if the folder does not exist or cannot be written to.
    """
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{target}: the folder {target.parent} does not exist")
    handle, name = tempfile.mkstemp(
        suffix=target.suffix, prefix=f".{target.stem}-", dir=target.parent
    )
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
