"""Sheets of exercises in true scale: a centimetre of the construction is one on paper.

A sheet has the axes, the auxiliary curves, lines I and II, the turn angle, the start point and a table to
fill in; its solution has the construction and the filled table as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from phaseplane.figures.style import BLUE, GREEN, OCHRE, ORANGE, RED, TEAL, new_figure, palette_for

PAPERS = {"A4": (21.0, 29.7), "A3": (29.7, 42.0)}
"""Width and height of a sheet, cm."""

_EDGE, _HEAD, _ROW, _FOOT = 1.0, 1.9, 0.62, 0.9  # cm
_MOST_ROWS = 13  # of one table; longer ones are put in two columns
_GRID = 0.5  # cm
_ROLES = {"auxiliary": OCHRE, "line": TEAL, "trail": BLUE}
_TURN = ("axis", "construction")  # the curves of the turn angle, which may lie anywhere


class Filled(NamedTuple):
    """What a table is filled with, and what is drawn besides.

    Parameters
    ----------
    rows : the cells of each row
    right : state points of the solution, cm of paper, one list for each plane
    feet : the feet D of their normals
    read : those that a student read, with whether each is right
    """

    rows: Sequence[Sequence[str]]
    right: Sequence[Sequence[Sequence[float]]]
    feet: Sequence[Sequence[Sequence[float]]] = ()
    read: Sequence[tuple[Sequence[Sequence[float]], bool]] = ()


def sheet_room(paper: str, count: int) -> tuple[float, float]:
    """Return the width and height that a sheet leaves for the construction, cm.

    Parameters
    ----------
    count : rows of the table
    """
    width, height = PAPERS[paper]
    rows = min(count, _MOST_ROWS) if count <= _MOST_ROWS else (count + 1) // 2
    return width - 2.0 * _EDGE, height - _HEAD - _FOOT - _ROW * (rows + 1.5) - 2.0 * _EDGE


def sheet_extent(sheet: Mapping[str, Any], points: Sequence[Sequence[float]]) -> np.ndarray:
    """Return the corners of what a sheet must show, cm: shape (2, 2), lower left and upper right.

    Parameters
    ----------
    sheet : the drawing, see `phaseplane.exercises.sheet_data`
    points : state points and feet of the solution
    """
    seen = [p for axes in sheet["axes"] for axis in axes.values() for p in axis["ends"]]
    seen += [p for c in sheet["curves"] if c["role"] == "trail" for p in c["points"]]
    seen += [[0.0, p[1]] for c in sheet["curves"] if c["role"] == "line" for p in c["points"]]
    corners = np.array([*seen, *points])
    turn = _turn_size(sheet)
    low, high = corners.min(axis=0) - 0.6, corners.max(axis=0) + 0.8
    low[1] -= turn[1] + 1.2  # the turn angle lies below
    high[0] = max(high[0], low[0] + turn[0] + 1.0)
    return np.array([low, high])


def exercise_sheet(
    sheet: Mapping[str, Any],
    points: Sequence[Sequence[float]],
    *,
    paper: str = "A4",
    title: str = "",
    lines: Sequence[str] = (),
    head: Sequence[str] = (),
    filled: Filled,
) -> Figure:
    """Draw the sheet of an exercise, or its solution.

    Parameters
    ----------
    sheet : the drawing as plain data
    points : what must have room: state points and feet of the solution, cm
    paper : A4 or A3
    title, lines : the heading: what is to be constructed
    head : the names of the table's columns
    filled : the table, and what is drawn of the solution
    """
    width, height = PAPERS[paper]
    figure = new_figure(width / 2.54, height / 2.54, palette_for(False))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    size = min(12.0, 900.0 / (1 + len(title)) * width / PAPERS["A4"][0])
    axes.text(_EDGE, height - _EDGE - 0.1, title, fontsize=size, va="top", weight="bold")
    for i, line in enumerate(lines):
        axes.text(_EDGE, height - _EDGE - 0.75 - 0.48 * i, line, fontsize=8.5, va="top")
    (left, bottom), (right, top) = sheet_extent(sheet, points)
    free_width, free_height = sheet_room(paper, len(filled.rows))
    moved = np.array(
        [
            _EDGE + 0.5 * (free_width - (right - left)) - left,
            height - _EDGE - _HEAD - 0.5 * (free_height - (top - bottom)) - top,
        ]
    )
    _grid(axes, np.array([left, bottom]) + moved, np.array([right, top]) + moved)
    clip = (left + moved[0], right + moved[0], bottom + moved[1], top + moved[1])
    _fixed(axes, sheet, moved, clip)
    _turn(axes, sheet, np.array([left + 0.6, bottom + 0.6]) + moved)
    _solution(axes, filled, moved)
    _table(axes, head, filled.rows, width)
    _ruler(axes, width)
    return figure


def _xy(place: np.ndarray) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _grid(axes: Axes, low: np.ndarray, high: np.ndarray) -> None:
    for i in (0, 1):
        for at in np.arange(np.ceil(low[i] / _GRID), high[i] / _GRID) * _GRID:
            ends = [[at, at], [low[1 - i], high[1 - i]]]
            x, y = ends if i == 0 else ends[::-1]
            axes.plot(x, y, color="#dfe5ea", linewidth=0.35, zorder=0.5)


def _fixed(
    axes: Axes, sheet: Mapping[str, Any], moved: np.ndarray, clip: tuple[float, ...]
) -> None:
    """Draw the curves and axes that stay."""
    left, right, bottom, top = clip
    frame = Rectangle((left, bottom), right - left, top - bottom, transform=axes.transData)
    for number, curve in enumerate(sheet["curves"]):
        if curve["role"] in _TURN:
            continue
        at = np.array(curve["points"]) + moved
        colour = _ROLES.get(curve["role"], "#6b7280")
        (drawn,) = axes.plot(
            *at.T, color=colour, linewidth=0.9, gid=curve["role"],
            linestyle="--" if curve["role"] == "line" else "-", zorder=2.0,
        )  # fmt: skip
        drawn.set_clip_path(frame)
        inside = at[
            (at[:, 0] > left) & (at[:, 0] < right - 0.8) & (at[:, 1] > bottom) & (at[:, 1] < top)
        ]
        if curve["label"] and len(inside):
            place = inside[-1 if number % 2 else 0]  # neighbours at different ends
            axes.text(*_xy(place + 0.08), curve["label"], color=colour, fontsize=6.5)
    for plane in sheet["axes"]:
        for key, axis in plane.items():
            start, end = np.array(axis["ends"]) + moved
            axes.annotate(
                "", end, start, zorder=1.8,
                arrowprops={"arrowstyle": "-|>", "linewidth": 0.8, "color": "#1b1f24",
                            "shrinkA": 0.0, "shrinkB": 0.0},
            )  # fmt: skip
            beside = (-0.1, 0.15) if key == "x" else (0.15, 0.0)
            axes.text(
                *_xy(end + beside), axis["label"], fontsize=8.0,
                ha="right" if key == "x" and end[0] > start[0] else "left", va="bottom",
            )  # fmt: skip
            for x, y, value in axis["ticks"]:
                at = np.array([x, y]) + moved
                across = np.array([0.0, 0.1] if key == "x" else [0.1, 0.0])
                axes.plot(*np.array([at - across, at + across]).T, color="#1b1f24", linewidth=0.6)
                if float(value) != 0.0:
                    place = at - (0.0, 0.16) if key == "x" else at - (0.16, 0.0)
                    axes.text(
                        *_xy(place), value, fontsize=6.0, color="#57606a",
                        ha="center" if key == "x" else "right", va="top" if key == "x" else "center",
                    )  # fmt: skip


def _turn_points(sheet: Mapping[str, Any]) -> np.ndarray:
    points = [p for c in sheet["curves"] if c["role"] in _TURN for p in c["points"]]
    return np.array(points or [[0.0, 0.0]])


def _turn_size(sheet: Mapping[str, Any]) -> np.ndarray:
    points = _turn_points(sheet)
    return np.asarray(points.max(axis=0) - points.min(axis=0))


def _turn(axes: Axes, sheet: Mapping[str, Any], corner: np.ndarray) -> None:
    """Draw the turn angle with its lower left corner at a place."""
    low = _turn_points(sheet).min(axis=0)
    for curve in sheet["curves"]:
        if curve["role"] in _TURN:
            at = np.array(curve["points"]) - low + corner
            axes.plot(*at.T, color="#6b7280", linewidth=0.7, zorder=2.0)
            if curve["label"]:
                below = (0.0, -0.32) if curve["role"] == "axis" else (0.1, -0.1)
                axes.text(
                    *_xy(at[-1] + below), curve["label"], fontsize=6.5, color="#57606a", ha="center"
                )


def _solution(axes: Axes, filled: Filled, moved: np.ndarray) -> None:
    for points in filled.right:
        at = np.array(points) + moved
        axes.plot(*at.T, color=BLUE, linewidth=0.9, marker="o", markersize=2.6, zorder=4.0)
        names = range(len(at)) if len(at) > 1 else ["P₀"]
        for name, place in zip(names, at, strict=True):
            axes.text(*_xy(place + 0.1), str(name), fontsize=6.5, color=BLUE, zorder=5.0)
    for points, feet in zip(filled.right, filled.feet, strict=False):
        for p, d in zip(points, feet, strict=False):
            at = np.array([p, d]) + moved
            axes.plot(*at.T, color=ORANGE, linewidth=0.4, zorder=3.0)
    for points, right in filled.read:
        at = np.array(points) + moved
        axes.plot(
            *at.T,
            color=GREEN if right else RED,
            marker="x",
            markersize=5.0,
            linestyle="",
            zorder=6.0,
        )


def _table(axes: Axes, head: Sequence[str], rows: Sequence[Sequence[str]], width: float) -> None:
    """Draw the table at the foot of the sheet, in two columns if it is long."""
    halves = 1 if len(rows) <= _MOST_ROWS else 2
    per = -(-len(rows) // halves)
    broad = (width - 2.0 * _EDGE - 0.6 * (halves - 1)) / halves
    narrow = 1.0  # of the number of the point
    cell = (broad - narrow) / max(1, len(head) - 1)
    top = _FOOT + _EDGE + _ROW * (per + 1)
    for half in range(halves):
        left = _EDGE + half * (broad + 0.6)
        edges = [left, *(left + narrow + cell * i for i in range(len(head)))]
        mine = rows[half * per : (half + 1) * per]
        for i in range(len(mine) + 2):
            y = top - _ROW * i
            axes.plot([edges[0], edges[-1]], [y, y], color="#6b7280", linewidth=0.5)
        for x in edges:
            axes.plot([x, x], [top, top - _ROW * (len(mine) + 1)], color="#6b7280", linewidth=0.5)
        for i, row in enumerate([head, *mine]):
            for j, text in enumerate(row):
                axes.text(
                    0.5 * (edges[j] + edges[j + 1]), top - _ROW * (i + 0.5), text, ha="center",
                    va="center", fontsize=7.5 if i else 7.0, weight="normal" if i else "bold",
                )  # fmt: skip


def _ruler(axes: Axes, width: float) -> None:
    """Draw a ruler of 10 cm by which the scale of a print can be checked."""
    y = 0.85
    axes.plot([_EDGE, _EDGE + 10.0], [y, y], color="#1b1f24", linewidth=0.7, gid="ruler")
    for i in range(11):
        axes.plot([_EDGE + i] * 2, [y, y + 0.15], color="#1b1f24", linewidth=0.7)
    axes.text(_EDGE + 10.2, y, "10 cm if printed at 100 %", fontsize=7.0, va="center")
