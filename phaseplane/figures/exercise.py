"""Sheets of exercises at true scale: a centimetre of the construction is one on paper.

A sheet has the axes, the auxiliary curves, lines I and II, the turn angle, the start point and a table to
fill in; its solution has the construction and the filled table as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from phaseplane.constructions.letters import MINUS, typeset
from phaseplane.constructions.primitives import Axis, Drawing
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import CURVES, draw_curves, draw_trails
from phaseplane.picture.frames import columns, motions_of
from phaseplane.picture.page import TYPE, Page
from phaseplane.picture.paper import Box, around
from phaseplane.picture.step import write_numbers
from phaseplane.picture.styles import GREEN, RED
from phaseplane.picture.subject import Subject

from .canvas import Sheet
from .style import PLAIN, Printed

PAPERS = {"A4": (21.0, 29.7), "A3": (29.7, 42.0)}  # width and height of a sheet, cm

_CM, _INCH = 0.01, 2.54  # m, and cm in an inch
_EM = TYPE / 72.0 * _INCH * _CM  # m of paper at true scale
_EDGE, _HEAD, _ROW, _FOOT = 1.0, 1.9, 0.62, 0.9  # cm
_MOST_ROWS = 13  # of one table; longer ones are put in two columns
_GRID = 0.005  # m of paper
_SEEN = "PQDACH"  # the points of the planes that must have room, by their first letters
_BOLD, _LIGHT = 0.6, 0.56  # average width of letters, em
_ROOM = 0.008  # m of paper around them, for the names of the axes


def sheet_room(paper: str, count: int) -> complex:
    """Return the width and height that a sheet with so many rows leaves for the construction, m."""
    width, height = PAPERS[paper]
    rows = ceil(count / _tables(count))
    high = height - _HEAD - _FOOT - _ROW * (rows + 1.5) - 2.0 * _EDGE
    return complex(width - 2.0 * _EDGE, high) * _CM


def sheet_view(drawing: Drawing) -> Box:
    """Return the part of a drawing that its sheet must show: state points, feet and turn angles."""
    shown = [
        z for frame in drawing.frames for name, z in frame.points.items()
        if name[0] in _SEEN and "~" not in name
    ]  # fmt: skip
    shown += [plane.displacement.origin for plane in drawing.planes]
    shown += [z for c in drawing.curves if c.role not in CURVES for z in c.vertices]
    return around(shown, 0.0).grown(_ROOM)


def exercise_sheet(
    drawing: Drawing, head: Sequence[str], rows: Sequence[Sequence[str]],
    *, solved: bool, read: Sequence[tuple[Sequence[complex], bool]] = (),
    paper: str = "A4", title: str = "", lines: Sequence[str] = (),
) -> Figure:  # fmt: skip
    """Draw the sheet of an exercise or its solution: heading, correct construction and filled table.

    Parameters
    ----------
    head, rows : of the table
    solved : whether the whole construction is drawn, or only its start
    read : the points that a student read, m of paper, one in each plane, with whether they are right
    lines : below the title
    """
    width, height = PAPERS[paper]
    canvas = Sheet(Printed(PLAIN, width / _INCH, height / _INCH, layout="none"))
    canvas.figure.set_label(title)
    view, room = sheet_view(drawing), sheet_room(paper, len(rows))
    size = 2.0 * view.half / _CM
    bottom = height - _EDGE - _HEAD - 0.5 * (room.imag / _CM + size.imag)
    canvas.place(view, complex(0.5 * (width - size.real), bottom) / _INCH, size / _INCH)
    low, high = view.corners
    look: dict[str, Any] = {"color": "#dfe5ea", "linewidth": 0.35, "zorder": 0.5}
    canvas.axes.vlines(np.arange(low.real, high.real, _GRID), low.imag, high.imag, **look)
    canvas.axes.hlines(np.arange(low.imag, high.imag, _GRID), low.real, high.real, **look)
    for item in _page(drawing, view, solved).items:
        canvas.draw(item)
    for points, right in read:
        colour = PLAIN.palette.chart(GREEN if right else RED)
        canvas.axes.plot(
            np.real(points), np.imag(points), "x", color=colour, markersize=5.0, zorder=6.0
        )
    axes = canvas.figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(0.0, height))
    axes.set_axis_off()
    top = height - _EDGE
    bold: dict[str, Any] = {"fontsize": _size(title, 12.0, _BOLD, width), "weight": "bold"}
    axes.text(_EDGE, top - 0.1, title, va="top", gid="heading", **bold)
    for i, line in enumerate(lines):
        letters = _size(line, 8.5, _LIGHT, width)
        axes.text(_EDGE, top - 0.75 - 0.48 * i, line, fontsize=letters, va="top", gid="about")
    _table(axes, head, rows)
    # a ruler of 10 cm by which the scale of a print can be checked
    ink: dict[str, Any] = {"color": PLAIN.palette.ink, "linewidth": 0.7}
    y = 0.85
    axes.plot([_EDGE, _EDGE + 10.0], [y, y], gid="ruler", **ink)
    for i in range(11):
        axes.plot([_EDGE + i] * 2, [y, y + 0.15], **ink)
    axes.text(_EDGE + 10.2, y, "10 cm if printed at 100 %", fontsize=7.0, va="center")
    return canvas.figure


def _size(text: str, largest: float, broad: float, width: float) -> float:
    """Return the size of letters with which a line fits on a sheet of this width, cm, in pt.

    Parameters
    ----------
    broad : average width of the letters, em
    """
    room = (width - 2.0 * _EDGE) / _INCH * 72.0
    return min(largest, room / (broad * (1 + len(text))))


def _page(drawing: Drawing, view: Box, solved: bool) -> Page:
    """Return the construction, or what is given of it."""
    drawing = _in_centimetres(drawing)
    feet = [columns(drawing.frames, [plane.foot])[:, 0] for plane in drawing.planes]
    motions = map(np.append, motions_of(drawing), feet)
    page = Page(Subject(drawing, list(motions)), view, _EM)
    draw_axes(page)  # with values as far as the feet, which are read off, too
    page.subject = Subject(drawing)
    draw_curves(page, None)
    if solved:
        for plane in drawing.planes:
            normals = columns(drawing.frames, [plane.state, plane.foot])
            page.lines("normal", list(normals[np.isfinite(normals).all(axis=1)]), 0.4)
        draw_trails(page)
        write_numbers(page, drawing.frames)
    else:
        start = [drawing.frames[0].points[plane.state] for plane in drawing.planes]
        page.dots("state", start, 0.6)
        page.letter([(z, typeset("P0"), "state") for z in start])
    return page


def _in_centimetres(drawing: Drawing) -> Drawing:
    """Return a drawing with lengths in cm, the unit of the table, on axes of any length."""

    def shown(axis: Axis) -> Axis:
        return replace(axis, unit="cm", scale=axis.scale * _CM) if axis.unit == "m" else axis

    planes = tuple(
        replace(p, displacement=shown(p.displacement), scaled_velocity=shown(p.scaled_velocity))
        for p in drawing.planes
    )
    curves = tuple(
        replace(curve, label=curve.label.replace(" cm", "")) if " = " in curve.label else curve
        for curve in drawing.curves
    )
    return replace(drawing, planes=planes, curves=curves)


def _tables(rows: int) -> int:
    return 1 if rows <= _MOST_ROWS else 2


def _table(axes: Axes, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Draw the table at the foot of the sheet, in two columns if it is long."""
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    parts = _tables(len(rows))
    count = ceil(len(rows) / parts)
    broad = (width - 2.0 * _EDGE - 0.6 * (parts - 1)) / parts
    narrow = 1.0  # of the number of the point
    widths = [narrow] + [(broad - narrow) / max(1, len(head) - 1)] * (len(head) - 1)
    for part in range(parts):
        mine = [
            [name.replace(" [", "\n[") for name in head],
            *rows[part * count : (part + 1) * count],
        ]
        left, bottom = _EDGE + part * (broad + 0.6), _FOOT + _EDGE + _ROW * (count + 1 - len(mine))
        drawn = axes.table(
            [[text.replace("-", MINUS) for text in row] for row in mine], colWidths=widths,
            cellLoc="center",
            bbox=Bbox.from_bounds(
                left / width, bottom / height, broad / width, _ROW * len(mine) / height
            ),
        )  # fmt: skip
        drawn.auto_set_font_size(False)
        for (row, _), cell in drawn.get_celld().items():
            cell.set(edgecolor=PLAIN.palette.faint, linewidth=0.5)
            cell.set_text_props(
                fontsize=7.5 if row else 7.0, weight="normal" if row else "bold", linespacing=1.0
            )
