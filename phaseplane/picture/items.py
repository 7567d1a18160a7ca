"""The items of a page: lines, points, arrows and texts, as plain data that any canvas can draw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeVar

from .letters import text_box
from .paper import Box, Strip

TYPE = 9.0  # size of the type, points: 1 em of a page
LETTER, VALUE = 10.0 / TYPE, 7.0 / TYPE
"""Sizes of letters, and of the values along axes and curves, em."""

Kind = Literal["letter", "value", "name", "label", "dimension"]


@dataclass(frozen=True, slots=True)
class Lines:
    """Polylines of one role; `weight` multiplies their width, `strength` is their opacity."""

    role: str
    strips: tuple[Strip, ...]
    weight: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True, slots=True)
class Dots:
    """Points of one role; `weight` multiplies their diameter, `strength` is their opacity."""

    role: str
    points: tuple[complex, ...]
    weight: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True, slots=True)
class Arrow:
    """A straight arrow with a head at its tip, or at both ends."""

    role: str
    start: complex
    tip: complex
    both: bool = False
    shaft: bool = True


@dataclass(frozen=True, slots=True)
class Text:
    """A text about its centre; `strength` is its opacity."""

    role: str
    text: str
    centre: complex
    size: float = 1.0  # of the type, em of the page
    kind: Kind = "label"
    point: complex | None = None  # that a letter names
    led: bool = False  # by a line from the point to the letter
    upright: bool = False  # reads upwards
    strength: float = 1.0

    def box(self, em: float) -> Box:
        """Return its box, for a page with this size of type."""
        half = text_box(self.centre, self.text, self.size * em).half
        if "frac" in self.text:  # two lines high
            half = complex(half.real, 2.0 * half.imag)
        return Box(self.centre, complex(half.imag, half.real) if self.upright else half)


Item = Lines | Dots | Arrow | Text
Kindred = TypeVar("Kindred", Lines, Dots, Arrow, Text)


def value_text(centre: complex, text: str) -> Text:
    """Return a value at a place."""
    return Text("value", text, centre, VALUE, "value")
