"""A page: the content of one picture, lines, points, arrows and texts, as plain data for any canvas.

A page is filled part by part and remembers its lines and texts, so that later letters avoid them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypeVar

import numpy as np

from phaseplane.constructions.construction import FLIGHT
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing, Plane

from .frames import unit_of
from .letters import NEAR, PLATE, place, text_box
from .paper import NOTHING, Box, Points, Strip, segments_of
from .styles import style_of
from .subject import Subject
from .text import marks_text

TYPE = 9.0  # size of the type, points: 1 em of a page
LETTER, VALUE = 10.0 / TYPE, 7.0 / TYPE
"""Sizes of letters, and of the values along axes and curves, em."""
STRAIGHT = 0.01  # em: how far a thinned curve may be from the whole one

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
Named = tuple[complex, str, str]
"""A point with its letter and its role."""
Kindred = TypeVar("Kindred", Lines, Dots, Arrow, Text)


def value_text(centre: complex, text: str) -> Text:
    """Return a value at a place."""
    return Text("value", text, centre, VALUE, "value")


@dataclass
class Page:
    """A picture under way, of the part of the sheet in view."""

    subject: Subject
    view: Box
    em: float  # size of the type, m of paper
    items: list[Item] = field(default_factory=list)
    taken: list[Box] = field(default_factory=list)
    keyed: bool = True  # with a legend
    unled: float = NEAR  # farthest distance of a letter from its point without a leader, em
    _segments: Points = field(default_factory=lambda: NOTHING)
    _strips: list[Strip] = field(default_factory=list)  # whose segments are not among them yet

    @property
    def drawing(self) -> Drawing:
        """The construction."""
        return self.subject.drawing

    def following(self) -> Page:
        """Return an empty page of the same view, whose letters keep clear of what is on this one."""
        return Page(
            self.subject, self.view, self.em, taken=list(self.taken), unled=self.unled,
            _segments=self.segments,
        )  # fmt: skip

    @cached_property
    def units(self) -> dict[str, tuple[str, float]]:
        """The display unit of each plane's displacement, as on its axis, and its number in one unit."""
        planes = self.drawing.planes
        return {plane.name: unit_of(plane.displacement, self.motion(plane)) for plane in planes}

    def motion(self, plane: Plane) -> Points:
        """Return the state points of a plane, with those in view of the motions from other starts."""
        trails = [c.vertices for c in self.drawing.curves if c.role == "trail"]
        others = [z for vertices in trails for z in vertices if self.view.holds(z)]
        own = self.subject.motions[self.drawing.planes.index(plane)]
        return np.append(own, others) if len(self.drawing.planes) == 1 else own

    # What is on the page.

    def of(self, kind: type[Kindred]) -> list[Kindred]:
        """Return all items of one kind, in the order of drawing."""
        return [item for item in self.items if isinstance(item, kind)]

    @property
    def texts(self) -> list[Text]:
        """All texts."""
        return self.of(Text)

    @property
    def segments(self) -> Points:
        """Ends of all lines drawn so far, shape (segments, 2)."""
        if self._strips:
            self._segments = np.concatenate([self._segments, segments_of(self._strips)])
            self._strips.clear()
        return self._segments

    def legend(self) -> list[tuple[str, str]]:
        """Return the roles in the legend, with their words, in the order of drawing; then marks."""
        found: dict[str, str] = {}
        for role in dict.fromkeys(lines.role for lines in self.of(Lines) if self.keyed):
            words = typeset(_legend_text(self.drawing, role))
            if words and words not in found.values():
                found[role] = words
        marked = any(dots.role == "event" for dots in self.of(Dots))
        if self.keyed and marked and not any(text.role == "event" for text in self.texts):
            found["event"] = marks_text(self.drawing)
        return list(found.items())

    # Primitive parts.

    def lines(
        self, role: str, strips: Sequence[Strip], weight: float = 1.0, strength: float = 1.0
    ) -> None:
        """Draw polylines of one role."""
        strips = [strip for strip in strips if len(strip) > 2 or strip[0] != strip[1]]
        if strips:
            self.items.append(Lines(role, tuple(strips), weight, strength))
            self._strips += strips

    def dots(
        self, role: str, points: Sequence[complex], weight: float = 1.0, strength: float = 1.0
    ) -> None:
        """Draw points of one role."""
        self.items.append(Dots(role, tuple(points), weight, strength))

    def arrow(self, role: str, start: complex, tip: complex, **more: bool) -> None:
        """Draw an arrow."""
        self.items.append(Arrow(role, start, tip, **more))
        self._strips.append((start, tip))

    def write(self, text: Text) -> None:
        """Write a text at its place."""
        self.items.append(text)
        self.taken.append(text.box(self.em))

    def write_if_free(self, text: Text) -> bool:
        """Write a text in view if its plate covers no other text; return whether it was written."""
        box = text.box(self.em)
        plate = box.grown(PLATE * self.em)
        free = bool(self.view.contains(box)) and not plate.overlap(Box.of(self.taken)).any()
        if free:
            self.write(text)
        return free

    def write_first(self, texts: Iterable[Text]) -> None:
        """Write the first of some texts that finds its place free."""
        next(filter(self.write_if_free, texts), None)

    def letter(
        self, named: Sequence[Named], size: float = LETTER, *, lines: bool = True,
        others: Sequence[complex] = (),
    ) -> None:  # fmt: skip
        """Write letters clear of lines, unless these are too many; `others` are points without one."""
        if not named:
            return
        points = np.array([z for z, *_ in named])
        placed = place(
            points, [text for _, text, _ in named], size * self.em, self.view,
            self.segments if lines else NOTHING, self.taken, others,
        )  # fmt: skip
        for (z, text, role), centre, gap, free in zip(named, *placed, strict=True):
            if free:  # better no letter than two on one another, or one that is cut off
                led = bool(gap > self.unled)
                self.put(Text(role, text, complex(centre), size, "letter", z, led))

    def put(self, letter: Text) -> None:
        """Write a letter at its place, with the leader that it may need."""
        self.write(letter)
        if letter.led and letter.point is not None:
            end = letter.box(self.em).nearest(letter.point)
            self.items.append(Lines("foot", ((letter.point, end),), 0.7))


def _legend_text(drawing: Drawing, role: str) -> str:
    words = style_of(role).words
    if role == "line":
        labels = [curve.label for curve in drawing.curves if curve.role == "line"]
        return f"lines {labels[0]} to {labels[-1]}" if len(labels) > 2 else words
    if role == "auxiliary":
        valued = any(curve.role == role and curve.label for curve in drawing.curves)
        of = drawing.planes[0].displacement.label.rstrip("0123456789")
        return f"{words} (of {of})" if valued else words
    if role != "excitation":
        return words
    read = [name for frame in drawing.frames[:1] for name in frame.readings]
    if any(name.endswith("road_elevation") for name in read):
        flies = any(FLIGHT in key for key in drawing.schemes)
        return words if flies else "road"
    return "load" if "load_force" in read else "change of f"
