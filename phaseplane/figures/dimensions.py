"""Dimension lines of lengths and angles on the sheet."""

from __future__ import annotations

from cmath import exp
from math import ceil

import numpy as np

from phaseplane.figures.canvas import Sheet
from phaseplane.figures.lettering import Box, Boxes, text_box

_SIZE = 8.0  # of the text, points
_PARTS = np.array([0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8])  # positions of the text along the line


def length(sheet: Sheet, start: complex, end: complex, text: str, *, towards: complex) -> None:
    """Draw a line with arrows at both ends, and its text along it where there is room.

    Parameters
    ----------
    towards : unit vector to the side of the line where the text is
    """
    ink = sheet.palette.ink
    sheet.axes.annotate(
        "", (end.real, end.imag), (start.real, start.imag),
        arrowprops={
            "arrowstyle": "<|-|>,head_width=0.15,head_length=0.4", "color": ink, "linewidth": 0.7,
            "shrinkA": 0, "shrinkB": 0,
        },
        zorder=5.0,
    )  # fmt: skip
    way = end - start
    size = text_box(0j, text, sheet.em * _SIZE / 9.0).half
    if "frac" in text:  # two lines high
        size = complex(size.real, 2.0 * size.imag)
    upright = abs(way.imag) > max(abs(way.real), 2.0 * size.real)
    half = complex(size.imag, size.real) if upright else size
    away = (0.3 * sheet.em + abs((half * towards.conjugate()).real)) * towards
    centres = start + _PARTS * way + away
    boxes = Boxes(centres[:, None], np.array(half))
    written = boxes.overlap(Boxes.of(sheet.taken)).sum(axis=1) / sheet.em
    crossed = boxes.inside(sheet.segments[:, 0], sheet.segments[:, 1]).sum(axis=1)
    best = Box(complex(centres[(written + crossed).argmin()]), half)
    sheet.axes.text(
        best.centre.real, best.centre.imag, text, color=ink, fontsize=_SIZE, ha="center",
        va="center", rotation=90.0 if upright else 0.0, path_effects=sheet.palette.halo(),
        zorder=6.0, gid="dimension",
    )  # fmt: skip
    sheet.spare((start, end))
    sheet.taken.append(best)


def witness(sheet: Sheet, start: complex, end: complex) -> None:
    """Draw a thin line from a measured point to its dimension line."""
    sheet.lines("foot", [[start, end]])


def below(
    sheet: Sheet, start: complex, end: complex, text: str, row: float, *, sign: float = -1.0
) -> None:
    """Dimension a length on a horizontal axis, some em below it (sign -1) or above it (1)."""
    shift = sign * row * 1j * sheet.em
    for point in (start, end):
        witness(sheet, point, point + 1.15 * shift)
    length(sheet, start + shift, end + shift, text, towards=sign * 1j)


def angle(
    sheet: Sheet, vertex: complex, start: complex, turn: float, text: str, share: float = 0.45
) -> None:
    """Draw the arc of a turn about a vertex, with an arrow in its sense and a text beside it.

    Parameters
    ----------
    start : a point on the first leg
    turn : rad, positive anticlockwise
    share : radius of the arc as a fraction of the first leg
    """
    leg = share * (start - vertex)
    parts = 2 + ceil(abs(turn) / 0.02)
    arc = [vertex + leg * exp(1j * turn * i / parts) for i in range(parts + 1)]
    sheet.lines("turn", [arc])
    sheet.lines("foot", [[vertex, vertex + 1.25 * (arc[-1] - vertex)]])
    sheet.axes.annotate(
        "", (arc[-1].real, arc[-1].imag), (arc[-2].real, arc[-2].imag),
        arrowprops={
            "arrowstyle": "-|>,head_width=0.18,head_length=0.5", "color": sheet.colour("turn"),
            "linewidth": 0.0, "shrinkA": 0, "shrinkB": 0,
        },
        zorder=5.0,
    )  # fmt: skip
    sheet.letter([(arc[len(arc) // 2], text, sheet.colour("turn"))])


def right_angle(sheet: Sheet, vertex: complex, leg: complex, other: complex) -> None:
    """Draw the small square of a right angle between two legs."""
    one, two = (0.9 * sheet.em * z / abs(z) for z in (leg, other))
    sheet.lines("foot", [[vertex + one, vertex + one + two, vertex + two]])
