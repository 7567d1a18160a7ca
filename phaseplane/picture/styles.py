"""One table of styles: the hue, width and words of every role, and the hue of every part of a car.

Every hue comes in three shades: one for light paper, one for dark, and one between them for a canvas
whose ground is not known, such as the viewer's. Its relative luminance is 0.198, so that its contrast to
white and to the dark paper is the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Shade = Literal["light", "dark", "either"]


@dataclass(frozen=True, slots=True)
class Hue:
    """A colour in its shades for light and for dark paper, and that legible on either, as #rrggbb."""

    light: str
    dark: str
    either: str

    def on(self, shade: Shade) -> str:
        """Return the shade for light paper, for dark paper, or the one that is legible on either."""
        return str(getattr(self, shade))


BLUE = Hue("#1f6fb2", "#5fa8e8", "#317fc1")
ORANGE = Hue("#b8500f", "#f08a3c", "#c55d19")
GREEN = Hue("#14774f", "#3cc48d", "#1f8c60")
RED = Hue("#c22f2f", "#f27070", "#d64b4b")
TEAL = Hue("#0f7480", "#35bccb", "#198794")
PINK = Hue("#ad3f7d", "#e583b8", "#c05691")
OCHRE = Hue("#7d6210", "#cfae3f", "#94781d")
VIOLET = Hue("#7450b8", "#ab8fe6", "#8a69ca")
GREY = Hue("#666b73", "#a0a6af", "#767b84")
INK = Hue("#222222", "#e8e8e8", "#7b7b7b")
PAPER = Hue("#ffffff", "#15181c", "#7a7b7e")
GRID = Hue("#e4e4e4", "#2c3138", "#787b7f")
SHADE = Hue("#e9eef5", "#243040", "#737c88")


@dataclass(frozen=True, slots=True)
class Style:
    """The style of a role."""

    hue: Hue = GREY
    width: float = 0.8  # of lines, in points
    dash: Literal["-", "--", ":"] = "-"
    size: float = 3.0  # diameter of points, in points
    words: str = ""  # in a legend; roles without words have no entry
    mono: tuple[float, ...] = ()  # dashes and gaps of black lines; only the integral curve is solid


_STEP = (4, 2.5, 0.1, 2.5, 0.1, 2.5)

ROLES = {
    "trail": Style(BLUE, 1.8, words="integral curve"),
    "run": Style(VIOLET, 1.5, words="motion of the run", mono=(1, 2)),
    "state": Style(BLUE, 1.5, size=5.0),
    "halo": Style(Hue("#ffffff", "#ffffff", "#ffffff"), size=13.0),
    "here": Style(Hue("#15181c", "#15181c", "#15181c"), size=10.0),
    "axis": Style(INK, 0.9),
    "value": Style(),
    "auxiliary": Style(OCHRE, 1.0, words="auxiliary curve", mono=(12, 3)),
    "line": Style(TEAL, 1.0, "--", words="lines I, II", mono=(5, 3)),
    "shortcut": Style(RED, 1.0, "--", words="flight to x2 = x2st", mono=(8, 3, 0.1, 3)),
    "foot": Style(width=0.7, dash=":"),
    "construction": Style(width=0.7),
    "excitation": Style(PINK, 2.0, words="road and weight", mono=(0.1, 2)),
    "projection": Style(VIOLET, 0.8, words="projection", mono=(2, 3)),
    "normal": Style(ORANGE, 1.4, size=4.0, words="normal", mono=(5, 2.5, 0.1, 2.5)),
    "arc": Style(GREEN, 1.6, words="step P to P'", mono=_STEP),
    "turn": Style(RED, 1.0, words="turn angle", mono=(0.1, 4)),
    "successor": Style(GREEN, 1.6, size=4.5, words="step P to P'", mono=_STEP),
    "event": Style(RED, 1.6, size=7.0),
}
MOVING_POINT = ("halo", "here", "state")
"""The roles of the discs that make up the moving point, one on another: it stands out on any ground."""

PARTS = {
    "body": BLUE,
    "wheel": ORANGE,
    "suspension": GREEN,
    "tyre": VIOLET,
    "contact": PINK,
    "road": OCHRE,
    "kinetic": BLUE,
    "stored": GREEN,
    "dissipated": ORANGE,
    "supplied": PINK,
}
"""The hue of each part of a car and of each energy, by the words in the names of their variables."""
SERIES = (BLUE, ORANGE, GREEN, VIOLET, RED, TEAL, PINK, OCHRE)
"""Hues of curves beside one another, as many as can be distinguished."""


def style_of(role: str) -> Style:
    """Return the style of a role or of a part; unknown ones are drawn like construction lines."""
    if role in PARTS:
        return Style(PARTS[role], 1.4)
    return ROLES.get(role, Style())


def hue_of(variable: str, number: int = 0) -> Hue:
    """Return the hue of a variable by the part it belongs to, else the hue with this number."""
    part = part_of(variable)
    return PARTS[part] if part else SERIES[number % len(SERIES)]


def part_of(variable: str) -> str:
    """Return the part of the car or the energy that a variable belongs to; empty if none."""
    return next((word for word in variable.split("_") if word in PARTS), "")


def strength_of(variable: str) -> float:
    """Return the opacity of a variable: a rear axle is fainter than a front one, right than left."""
    words = variable.split("_")
    return (0.5 if "rear" in words else 1.0) * (0.7 if "right" in words else 1.0)


def weight_of(variable: str) -> float:
    """Return the relative width of a curve: those of a rear axle are thin, for hues differ little."""
    return 0.5 if "rear" in variable.split("_") else 1.0
