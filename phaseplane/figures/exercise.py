"""Sheets of exercises at true scale: a centimetre of the construction is one on paper.

A sheet has the axes, the auxiliary curves, lines I and II, the turn angle, the start point and a table to
fill in; its solution has the construction and the filled table as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from phaseplane.figures.style import BLUE, GREEN, OCHRE, ORANGE, RED, TEAL, new_figure, palette_for
from phaseplane.picture.letters import text_box
from phaseplane.picture.paper import Box, Boxes
from phaseplane.picture.text import MINUS

PAPERS = {"A4": (21.0, 29.7), "A3": (29.7, 42.0)}
"""Width and height of a sheet, cm."""

_EDGE, _HEAD, _ROW, _FOOT = 1.0, 1.9, 0.62, 0.9  # cm
_MOST_ROWS = 13  # of one table; longer ones are put in two columns
_GRID = 0.5  # cm
_ROLES = {"auxiliary": OCHRE, "line": TEAL, "trail": BLUE}
_TURN = ("axis", "construction")  # the curves of the turn angle, which may lie anywhere
_INK, _GREY = "#1b1f24", "#57606a"
_POINT = 2.54 / 72.0  # cm
_GAP = 0.03  # cm around a text
_PLACES = 200  # that are tried for a text
_AROUND = ((1, 1), (1, -1), (-1, 1), (-1, -1))  # where a text may be beside a point


@dataclass
class _Texts:
    """Texts of a sheet, none of which covers another.

    Parameters
    ----------
    axes : what they are written on, in cm of paper
    room : what they stay within
    lines : the polylines that they keep off, if there is room
    taken : the boxes of those that are there
    """

    axes: Axes
    room: Box
    lines: Sequence[np.ndarray] = ()
    taken: list[Box] = field(default_factory=list)

    def write(self, text: str, places: Iterable[complex], size: float, colour: str) -> None:
        """Write a text at the first free one of these centres, if there is one.

        A place that no line crosses is preferred; elsewhere the background of the text is white.
        """
        boxes = [text_box(centre, text, size * _POINT).grown(_GAP) for centre in places]
        free = [
            box for box in boxes
            if self.room.contains(box) and not any(box.overlap(other) for other in self.taken)
        ]  # fmt: skip
        if not free:
            return
        tried = free[:: max(1, len(free) // _PLACES)]
        crossed = self._crossed(tried)
        box = tried[int(np.argmax(crossed <= crossed.min()))]
        self.taken.append(box)
        self.axes.text(
            box.centre.real, box.centre.imag, text, fontsize=size, color=colour, ha="center",
            va="center", zorder=5.0,
            bbox={"facecolor": "white", "linewidth": 0.0, "pad": 0.4},
        )  # fmt: skip

    def _crossed(self, boxes: Sequence[Box]) -> np.ndarray:
        """Return the length of all lines inside each box, cm."""
        total = np.zeros(len(boxes))
        several = Boxes.of(boxes)
        columns = Boxes(several.centres[:, None], several.halves[:, None])
        for line in self.lines:
            z = line[:, 0] + 1j * line[:, 1]
            total += np.asarray(columns.inside(z[:-1], z[1:])).sum(axis=1)
        return total

    def beside(self, text: str, points: Iterable[np.ndarray], size: float, colour: str) -> None:
        """Write a text beside the first of these points that has room."""
        half = text_box(0j, text, size * _POINT).half + 0.05 * (1 + 1j)
        ways = [complex(x * half.real, y * half.imag) for x, y in _AROUND]
        self.write(text, (complex(*at) + way for at in points for way in ways), size, colour)


class Filled(NamedTuple):
    """The content of a filled table, and additional points.

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
    x = _EDGE + 0.5 * (free_width - (right - left)) - left
    y = height - _EDGE - _HEAD - 0.5 * (free_height - (top - bottom)) - top
    moved = np.array([x, y])
    _grid(axes, np.array([left, bottom]) + moved, np.array([right, top]) + moved)
    clip = (left + moved[0], right + moved[0], bottom + moved[1], top + moved[1])
    middle = 0.5 * np.array([left + right, bottom + top]) + moved
    extent = complex(right - left, top - bottom)
    drawn = [
        np.array(c["points"]) + moved for c in sheet["curves"]
        if c["role"] not in _TURN and len(c["points"]) > 1
    ]  # fmt: skip
    drawn += [np.array(axis["ends"]) + moved for plane in sheet["axes"] for axis in plane.values()]
    texts = _Texts(axes, Box(complex(*middle), 0.5 * extent).grown(0.3), drawn)
    _axes(texts, sheet, moved)
    _curves(axes, sheet, moved, clip)
    _turn(axes, sheet, np.array([left + 0.6, bottom + 0.6]) + moved)
    _solution(texts, sheet, filled, moved)
    _labels(texts, sheet, moved, clip)
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


def _curves(
    axes: Axes, sheet: Mapping[str, Any], moved: np.ndarray, clip: tuple[float, ...]
) -> None:
    """Draw the curves that stay."""
    left, right, bottom, top = clip
    frame = Rectangle((left, bottom), right - left, top - bottom, transform=axes.transData)
    for curve in sheet["curves"]:
        if curve["role"] in _TURN:
            continue
        at = np.array(curve["points"]) + moved
        (drawn,) = axes.plot(
            *at.T, color=_ROLES.get(curve["role"], _GREY), linewidth=0.9, gid=curve["role"],
            linestyle="--" if curve["role"] == "line" else "-", zorder=2.0,
        )  # fmt: skip
        drawn.set_clip_path(frame)


def _labels(
    texts: _Texts, sheet: Mapping[str, Any], moved: np.ndarray, clip: tuple[float, ...]
) -> None:
    """Write the labels of the curves, each near one of its ends."""
    left, right, bottom, top = clip
    for number, curve in enumerate(sheet["curves"]):
        if not curve["label"] or curve["role"] in _TURN:
            continue
        at = np.array(curve["points"]) + moved
        x, y = at.T
        seen = at[(x > left) & (x < right) & (y > bottom) & (y < top)]
        ordered = seen if number % 2 else seen[::-1]  # neighbours at different ends
        words = curve["label"].replace("-", MINUS)
        texts.beside(words, ordered, 6.5, _ROLES.get(curve["role"], _GREY))


def _axes(texts: _Texts, sheet: Mapping[str, Any], moved: np.ndarray) -> None:
    """Draw the axes with their names and values."""
    axes, values = texts.axes, []
    for plane in sheet["axes"]:
        for key, axis in plane.items():
            start, end = np.array(axis["ends"]) + moved
            axes.annotate(
                "", end, start, zorder=1.8,
                arrowprops={"arrowstyle": "-|>", "linewidth": 0.8, "color": _INK,
                            "shrinkA": 0.0, "shrinkB": 0.0},
            )  # fmt: skip
            half = text_box(0j, axis["label"], 8.0 * _POINT).half
            inwards = -half.real if end[0] > start[0] else half.real
            beside = complex(inwards if key == "x" else 0.15 + half.real, half.imag + 0.1)
            # by the arrow's head, on either side of the axis
            places = [beside, beside.conjugate()]
            if key != "x":
                places = [beside, complex(-beside.real, beside.imag)]
            texts.write(axis["label"], [complex(*end) + place for place in places], 8.0, _INK)
            for x, y, value in axis["ticks"]:
                at = np.array([x, y]) + moved
                across = np.array([0.0, 0.1] if key == "x" else [0.1, 0.0])
                axes.plot(*np.array([at - across, at + across]).T, color=_INK, linewidth=0.6)
                if float(value) != 0.0:
                    half = text_box(0j, value, 6.0 * _POINT).half
                    below = -1j * (half.imag + 0.12) if key == "x" else -half.real - 0.12 + 0j
                    values.append((value.replace("-", MINUS), complex(*at) + below))
    for value, place in values:
        texts.write(value, [place], 6.0, _GREY)


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
            axes.plot(*at.T, color=_GREY, linewidth=0.7, zorder=2.0)
            if curve["label"]:
                below = (0.0, -0.32) if curve["role"] == "axis" else (0.1, -0.1)
                axes.text(
                    *_xy(at[-1] + below), curve["label"], fontsize=6.5, color=_GREY, ha="center"
                )


def _solution(texts: _Texts, sheet: Mapping[str, Any], filled: Filled, moved: np.ndarray) -> None:
    axes = texts.axes
    for i, points in enumerate(filled.right):
        at = np.array(points) + moved
        # from point to point as the rule steps
        way = [p for step in sheet["steps"][: len(points) - 1] for p in step["ways"][i]]
        if way:
            axes.plot(*(np.array(way) + moved).T, color=BLUE, linewidth=0.9, zorder=4.0)
        axes.plot(*at.T, "o", color=BLUE, markersize=2.6, zorder=4.0)
        names = range(len(at)) if len(at) > 1 else ["P₀"]
        for name, place in zip(names, at, strict=True):
            texts.beside(str(name), [place], 6.5, BLUE)
    for points, feet in zip(filled.right, filled.feet, strict=False):
        for p, d in zip(points, feet, strict=False):
            at = np.array([p, d]) + moved
            axes.plot(*at.T, color=ORANGE, linewidth=0.4, zorder=3.0)
    for points, right in filled.read:
        at = np.array(points) + moved
        axes.plot(*at.T, "x", color=GREEN if right else RED, markersize=5.0, zorder=6.0)


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
            axes.plot([edges[0], edges[-1]], [y, y], color=_GREY, linewidth=0.5)
        for x in edges:
            axes.plot([x, x], [top, top - _ROW * (len(mine) + 1)], color=_GREY, linewidth=0.5)
        for i, row in enumerate([head, *mine]):
            for j, text in enumerate(row):
                axes.text(
                    0.5 * (edges[j] + edges[j + 1]), top - _ROW * (i + 0.5),
                    text.replace("-", MINUS), ha="center", va="center",
                    fontsize=7.5 if i else 7.0, weight="normal" if i else "bold",
                )  # fmt: skip


def _ruler(axes: Axes, width: float) -> None:
    """Draw a ruler of 10 cm by which the scale of a print can be checked."""
    y = 0.85
    axes.plot([_EDGE, _EDGE + 10.0], [y, y], color=_INK, linewidth=0.7, gid="ruler")
    for i in range(11):
        axes.plot([_EDGE + i] * 2, [y, y + 0.15], color=_INK, linewidth=0.7)
    axes.text(_EDGE + 10.2, y, "10 cm if printed at 100 %", fontsize=7.0, va="center")
