"""Dimension lines of lengths and angles on a page."""

from __future__ import annotations

from cmath import exp
from dataclasses import replace
from math import ceil

import numpy as np

from phaseplane.constructions.primitives import Plane
from phaseplane.constructions.storage import Frame

from .page import TYPE, Page, Text
from .paper import Box

_SIZE = 8.0 / TYPE  # of the text, em
_ROW, _ROWS = 1.2, 3  # distance between rows of dimension lines, em, and their number
_WRITTEN = 10.0  # a text on another is worse than one on a line
_PARTS = np.array([0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8])  # positions of the text along the line


def length(
    page: Page, start: complex, end: complex, text: str, *, towards: complex, short: str = "",
    size: float = _SIZE,
) -> None:  # fmt: skip
    """Draw a line with arrows at both ends, and its text along it where there is room.

    Parameters
    ----------
    towards : unit vector to the side of the line where the text is
    short : text in place of one that is longer than the line
    """
    page.arrow("axis", start, end, both=True)
    way = end - start
    words = Text("axis", text, 0j, size, "dimension")
    if short and 2.0 * words.box(page.em).half.real > abs(way):
        words = replace(words, text=short)
    half = words.box(page.em).half
    words = replace(words, upright=abs(way.imag) > max(abs(way.real), 2.0 * half.real))
    half = words.box(page.em).half
    away = (0.3 * page.em + abs((half * towards.conjugate()).real)) * towards
    centres = start + _PARTS * way + away
    boxes = Box(centres[:, None], np.array(half))
    written = boxes.overlap(Box.of(page.taken)).sum(axis=1) / page.em
    crossed = boxes.inside(page.segments[:, 0], page.segments[:, 1]).sum(axis=1)
    page.write(replace(words, centre=complex(centres[(_WRITTEN * written + crossed).argmin()])))


def witness(page: Page, start: complex, end: complex) -> None:
    """Draw a thin line from a measured point to its dimension line."""
    page.lines("foot", [[start, end]])


def below(page: Page, start: complex, end: complex, text: str, row: float) -> None:
    """Dimension a length on a horizontal axis, `row` em below it, or farther if a text is there."""
    ends, taken = np.array([[start], [end]]), Box.of(page.taken)
    shifts = [-(row + _ROW * further) * 1j * page.em for further in range(_ROWS)]
    free = [shift for shift in shifts if not taken.inside(*(ends + shift)).any()]
    shift = (free or shifts)[0]
    for point in (start, end):
        witness(page, point, point + 1.15 * shift)
    length(page, start + shift, end + shift, text, towards=-1j)


def turn_angle(page: Page, plane: Plane, frame: Frame, text: str, share: float = 0.45) -> None:
    """Draw the turn angle of a step at D, clockwise where the y axis points to the right.

    The arc has an arrow in its sense and a text beside it; its radius is a share of the normal.
    """
    turn = -plane.displacement.direction.real * plane.angular_frequency * frame.duration
    vertex = frame.points[plane.foot]
    leg = share * (frame.points[plane.state] - vertex)
    parts = 2 + ceil(abs(turn) / 0.02)
    arc = [vertex + leg * exp(1j * turn * i / parts) for i in range(parts + 1)]
    page.lines("turn", [arc])
    page.lines("foot", [[vertex, vertex + 1.25 * (arc[-1] - vertex)]])
    page.arrow("turn", arc[-2], arc[-1], shaft=False)
    if text:
        page.letter([(arc[len(arc) // 2], text, "turn")])


def right_angle(page: Page, vertex: complex, leg: complex, other: complex) -> None:
    """Draw the small square of a right angle between two legs."""
    one, two = (0.9 * page.em * z / abs(z) for z in (leg, other))
    page.lines("foot", [[vertex + one, vertex + one + two, vertex + two]])
