"""Placement of letters without overlap, and their typesetting."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from unicodedata import normalize

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.complex128]
Lengths = npt.NDArray[np.floating]

_WIDTH, _HEIGHT = 0.58, 1.15  # of one character, in em
_RADII = np.repeat([1.0, 1.5, 2.2, 3.2], 16)  # distances of a letter from its point, in em
_DIRECTIONS = np.tile(np.exp(1j * (np.arange(16) + 0.5) * pi / 8.0), 4)
_FARTHEST = _RADII[-1]
_BAR, _DOT = "\N{COMBINING MACRON}", "\N{COMBINING DOT ABOVE}"
_INDICES = {ord(plain): index for plain, index in zip("0123456789m", "₀₁₂₃₄₅₆₇₈₉ₘ", strict=True)}
_LETTER = re.compile("(?!I$)([A-Za-z]|Δτ)[₀-₉ₘ]*\N{PRIME}?\\*?")


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle: its centre and half its width and height."""

    centre: complex
    half: complex

    def overlap(self, other: Box) -> float:
        """Return the area common to both."""
        apart = self.centre - other.centre
        reach = self.half + other.half
        across, up = reach.real - abs(apart.real), reach.imag - abs(apart.imag)
        return across * up if across > 0.0 and up > 0.0 else 0.0

    def holds(self, point: complex) -> bool:
        """Return whether a point is inside."""
        apart = point - self.centre
        return abs(apart.real) <= self.half.real and abs(apart.imag) <= self.half.imag

    def contains(self, other: Box) -> bool:
        """Return whether another box is wholly inside."""
        return Box(self.centre, self.half - other.half).holds(other.centre)


@dataclass(frozen=True, slots=True)
class Boxes:
    """Rectangles by their centres and half-sizes, arrays of any shapes that numpy broadcasts."""

    centres: Points
    halves: Points

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> Boxes:
        """Return boxes as one-dimensional arrays."""
        row = np.array([(box.centre, box.half) for box in boxes], complex).reshape(-1, 2)
        return cls(row[:, 0], row[:, 1])

    def overlap(self, other: Boxes) -> Lengths:
        """Return the areas common to each box and another."""
        apart, reach = self.centres - other.centres, self.halves + other.halves
        across = np.maximum(0.0, reach.real - abs(apart.real))
        return across * np.maximum(0.0, reach.imag - abs(apart.imag))

    def within(self, view: Box) -> npt.NDArray[np.bool_]:
        """Return whether each box is wholly in a view."""
        apart, room = self.centres - view.centre, view.half - self.halves
        return (abs(apart.real) <= room.real) & (abs(apart.imag) <= room.imag)

    def inside(self, starts: Points, ends: Points) -> Lengths:
        """Return the length of each segment inside each box."""
        ways, begins = ends - starts, starts - self.centres
        low: Lengths = np.zeros(())
        high: Lengths = np.ones(())
        for step, position, half in (
            (ways.real, begins.real, self.halves.real),
            (ways.imag, begins.imag, self.halves.imag),
        ):
            # a segment parallel to a side gives infinities: unbounded inside, empty outside
            with np.errstate(divide="ignore", invalid="ignore"):
                one, other = (-half - position) / step, (half - position) / step
            low = np.maximum(low, np.fmin(one, other))
            high = np.minimum(high, np.fmax(one, other))
        return abs(ways) * np.maximum(0.0, high - low)


def text_box(centre: complex, text: str, em: float) -> Box:
    """Return the box of a text with its centre and size of type."""
    letters = len(re.sub(r"[${}^_\\]|\\[a-z]+", "", text))
    return Box(centre, complex(0.5 * _WIDTH * max(letters, 1) + 0.15, 0.5 * _HEIGHT) * em)


def place(
    letters: Sequence[tuple[complex, str]],
    em: float,
    view: Box,
    segments: Points,
    taken: Sequence[Box] = (),
) -> list[complex]:
    """Return the centres of letters beside their points.

    Letters with the closest neighbours are placed first. Each takes the best of 64 positions about
    its point: close to it, not over other letters, points or lines, and nearer to it than to others.

    Parameters
    ----------
    letters : point and text of each letter
    em : size of the type in units of the sheet
    view : the visible part of the sheet; letters stay inside
    segments : ends of the lines that letters must avoid, shape (segments, 2)
    taken : boxes of texts that are already there
    """
    points = np.array([point for point, _ in letters], complex)
    sizes = np.array([text_box(0j, text, em).half for _, text in letters], complex)
    written = Boxes.of(taken)
    known = len(taken)
    room = np.zeros(len(letters), complex)
    boxes = np.concatenate((written.centres, room))
    halves = np.concatenate((written.halves, room))
    crowd = (abs(points[:, None] - points) < 2.5 * em).sum(axis=1)
    dots = Boxes(points, np.array(0.15 * em * (1 + 1j)))
    centres = points.copy()
    for count, i in enumerate(np.argsort(-crowd, kind="stable"), known):
        point, size = points[i], sizes[i]
        at = point + _RADII * em * _DIRECTIONS + (size.real - 0.3 * em) * _DIRECTIONS.real
        box = Boxes(at[:, None], size)
        near = segments[_about(point, _FARTHEST * em * (1 + 1j) + 2.0 * size, segments)]
        cost = (
            0.7 * _RADII
            + 40.0 * box.overlap(Boxes(boxes[:count], halves[:count])).sum(axis=1) / em**2
            + 4.0 * (box.overlap(dots) > 0.0).sum(axis=1)
            + 1.5 * box.inside(near[:, 0], near[:, 1]).sum(axis=1) / em
            + 2.0 * (abs(points - at[:, None]) < abs(point - at)[:, None]).sum(axis=1)
            + 100.0 * ~Boxes(at, size).within(view)
        )
        centres[i] = boxes[count] = at[cost.argmin()]
        halves[count] = size
    return [complex(centre) for centre in centres]


def _about(point: complex, half: complex, segments: Points) -> npt.NDArray[np.bool_]:
    """Return the segments that may come within a distance of a point."""
    near = np.ones(len(segments), bool)
    apart = segments - point
    for part, reach in ((apart.real, half.real), (apart.imag, half.imag)):
        near &= (part.min(axis=1) <= reach) & (part.max(axis=1) >= -reach)
    return near


def typeset(label: str) -> str:
    """Return a label of the construction as typeset text: A1* becomes A₁*, y1'/Ω1 its definition.

    It is plain text, which is drawn several times faster than parsed mathematics.
    """
    speed = re.fullmatch(r"([a-z])(\d*)'/Ω(\d*)", label)
    if speed:
        bar, dot = (normalize("NFC", speed[1] + accent) + speed[2] for accent in (_BAR, _DOT))
        return f"{bar} = {dot}/Ω{speed[3]}".translate(_INDICES)
    turn = re.fullmatch(r"dtau(\d*)", label)
    if turn:
        return f"Δτ{turn[1]}".translate(_INDICES)
    level = re.fullmatch(r"[a-z]\d* = (-?[\d.]+(?: cm)?)", label)
    if level:
        return level[1].replace("-", "\N{MINUS SIGN}")
    lettered = re.fullmatch(r"([A-Za-z])(m?\d*)('?\*?)", label)
    if not lettered:
        return label
    name, index, upper = lettered.groups()
    return name + index.translate(_INDICES) + upper.replace("'", "\N{PRIME}")


def is_letter(text: str) -> bool:
    """Return whether a text is the letter of a point or an angle, which is set in italics."""
    return _LETTER.fullmatch(text) is not None
