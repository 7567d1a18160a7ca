"""Where letters go, so that none hides another or what is drawn; and how they are typeset."""

from __future__ import annotations

import re
from cmath import rect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import pi

_WIDTH, _HEIGHT = 0.58, 1.15  # of one character, in em
_RADII = (1.0, 1.5, 2.2, 3.2)  # at which a letter may stand from its point, in em
_DIRECTIONS = tuple(rect(1.0, (i + 0.5) * pi / 8.0) for i in range(16))


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle that text takes up: its centre and half its width and height."""

    centre: complex
    half: complex

    def overlap(self, other: Box) -> float:
        """Area common to both."""
        apart = self.centre - other.centre
        reach = self.half + other.half
        across, up = reach.real - abs(apart.real), reach.imag - abs(apart.imag)
        return across * up if across > 0.0 and up > 0.0 else 0.0

    def holds(self, point: complex) -> bool:
        """Whether a point lies inside."""
        apart = point - self.centre
        return abs(apart.real) <= self.half.real and abs(apart.imag) <= self.half.imag

    def contains(self, other: Box) -> bool:
        """Whether another box lies wholly inside."""
        return Box(self.centre, self.half - other.half).holds(other.centre)

    def inside(self, start: complex, end: complex) -> float:
        """Length of the part of a segment that lies in the box."""
        way = end - start
        low, high = 0.0, 1.0
        begin = start - self.centre
        for position, step, half in (
            (begin.real, way.real, self.half.real),
            (begin.imag, way.imag, self.half.imag),
        ):
            if step == 0.0:
                if abs(position) > half:
                    return 0.0
                continue
            one, other = (-half - position) / step, (half - position) / step
            low, high = max(low, min(one, other)), min(high, max(one, other))
        return abs(way) * (high - low) if high > low else 0.0


def text_box(centre: complex, text: str, em: float) -> Box:
    """The box of a text of known size about its centre."""
    letters = len(re.sub(r"[${}^_\\]|\\[a-z]+", "", text))
    return Box(centre, complex(0.5 * _WIDTH * max(letters, 1) + 0.15, 0.5 * _HEIGHT) * em)


def place(
    letters: Sequence[tuple[complex, str]],
    em: float,
    view: Box,
    segments: Sequence[tuple[complex, complex]],
    taken: Iterable[Box] = (),
) -> list[complex]:
    """Centres for letters beside their points.

    Parameters
    ----------
    letters : point and text of each
    em : size of the type in units of the sheet
    view : what is seen; letters stay inside
    segments : what is drawn, not to be written across
    taken : where something is written already
    """
    boxes = list(taken)
    points = [point for point, _ in letters]
    crowd = [sum(1 for q in points if abs(p - q) < 2.5 * em) for p in points]
    centres = list(points)
    for i in sorted(range(len(letters)), key=lambda i: -crowd[i]):
        point, text = letters[i]
        size = text_box(0j, text, em).half
        best, least = point, float("inf")
        for radius in _RADII:
            for direction in _DIRECTIONS:
                reach = radius * em * direction
                centre = point + complex(
                    reach.real + (size.real - 0.3 * em) * direction.real, reach.imag
                )
                box = Box(centre, size)
                cost = (
                    0.7 * radius
                    + 40.0 * sum(box.overlap(other) for other in boxes) / em**2
                    + 4.0 * sum(Box(q, 0.15 * em * (1 + 1j)).overlap(box) > 0.0 for q in points)
                    + 1.5 * sum(box.inside(*segment) for segment in segments) / em
                )
                cost += 2.0 * sum(abs(q - centre) < abs(point - centre) for q in points)
                if not view.contains(box):
                    cost += 100.0
                if cost < least:
                    best, least = centre, cost
        centres[i] = best
        boxes.append(Box(best, size))
    return centres


def typeset(label: str) -> str:
    """A letter of the construction as mathematics: A1* becomes A with subscript and star."""
    speed = re.fullmatch(r"([a-z])(\d*)'/Ω(\d*)", label)
    if speed:
        letter, number = speed[1], _index(speed[2])
        return rf"$\bar{{{letter}}}{number} = \dot{{{letter}}}{number}/\Omega{number}$"
    turn = re.fullmatch(r"dtau(\d*)", label)
    if turn:
        return rf"$\Delta\tau{_index(turn[1])}$"
    level = re.fullmatch(r"[a-z]\d* = (-?[\d.]+(?: cm)?)", label)
    if level:
        return level[1].replace("-", "\N{MINUS SIGN}")
    lettered = re.fullmatch(r"([A-Za-z])(m?\d*)('?)(\*?)", label)
    if not lettered:
        return label
    name, number, dash, star = lettered.groups()
    if name == "I":
        return label
    upper = (r"\prime" if dash else "") + ("*" if star else "")
    return (
        "$" + name + (f"_{{{number}}}" if number else "") + (f"^{{{upper}}}" if upper else "") + "$"
    )


def _index(number: str) -> str:
    """A number as subscript."""
    return f"_{{{number}}}" if len(number) > 1 else f"_{number}" if number else ""
