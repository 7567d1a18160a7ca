"""Motions over time: displacements with the road, velocities, accelerations, energies; or any columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from math import ceil
from textwrap import fill
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from phaseplane.picture.quantities import QUANTITIES, Quantity, in_range, unit_of_columns
from phaseplane.picture.styles import hue_of
from phaseplane.picture.text import bracketed, in_words

from .style import DASHES, PLAIN, Look, Palette, Printed, name_up, styled

# the columns of each quantity, and their labels
_COLUMNS = {
    "displacement": {
        "road_elevation": "road ξ",
        "suspension_deflection": "deflection y",
        "wheel_displacement": "wheel x₂",
        "body_centre_displacement": "body's centre",
        "body_displacement": "body x₁",
    },
    "velocity": {
        "suspension_deflection_rate": "deflection ẏ",
        "wheel_velocity": "wheel ẋ₂",
        "body_centre_velocity": "body's centre",
        "body_velocity": "body ẋ₁",
    },
    "acceleration": {
        "suspension_deflection_acceleration": "deflection ÿ",
        "wheel_acceleration": "wheel ẍ₂",
        "body_centre_acceleration": "body's centre",
        "body_acceleration": "body ẍ₁",
    },
    "energy": {f"{name}_energy": name for name in ("kinetic", "stored", "dissipated", "supplied")},
}
_KNOWN = {name for columns in _COLUMNS.values() for name in columns}
_BODY = "body_acceleration"
_OF_BODY = (_BODY, "body_centre_acceleration")
_FLAT = 0.1  # of the largest acceleration: below it, that of the body has a panel of its own
_DASHES = {"road": "--", "centre": ":"}
# of black lines, besides: their dashes, and their markers, and whether these are filled
_MONO = {
    "wheel": "-.", "suspension": (0, (6, 1.5)), "stored": "--", "dissipated": "-.", "supplied": ":",
}  # fmt: skip
_MARKERS = {"body": ("o", True), "wheel": ("s", False), "suspension": ("^", False)}
_MONO_MARKED = 20  # times that are marked on black lines, whose dashes are seen between them
_MOST_MARKED = 300  # times that are marked; more would be a blot
_NARROW = 5.0  # inches of a picture with one column of panels, or one legend for all panels
_IN_COLUMN = 7  # panels one below the other, more if they would be too many side by side
_ACROSS = 3  # panels side by side
_LINE = 18  # letters of a label

Table = dict[str, npt.NDArray[np.float64]]
Row = tuple[Quantity, dict[str, str]]
"""What a panel shows, and its columns with labels."""
Curve = tuple[npt.ArrayLike, npt.ArrayLike]


def time_histories(
    columns: Mapping[str, npt.ArrayLike],
    *, title: str = "", look: Look = PLAIN, points: bool = False,
) -> Figure:  # fmt: skip
    """Draw displacements, velocities, accelerations (AP57 figures 14 to 16) and energies over time.

    Parameters
    ----------
    columns : `time` (s) and any of road_elevation, body_displacement, body_centre_displacement (of a
        body over several axles), wheel_displacement, suspension_deflection (m), `*_velocity` and
        suspension_deflection_rate (m/s), `*_acceleration` (m/s^2), `*_energy` (J), airborne (true or
        false), shape (n,) each; others are ignored, a panel without columns is omitted
    points : mark every time

    Raises
    ------
    ValueError : if `time` is missing or has fewer than two values, lengths of columns differ, or
        there is nothing to draw.
    """
    return axle_histories({"": columns}, title=title, look=look, points=points)


@styled
def axle_histories(
    axles: Mapping[str, Mapping[str, npt.ArrayLike]],
    *, title: str = "", look: Look = PLAIN, points: bool = False,
) -> Figure:  # fmt: skip
    """Draw the motions over several axles beside each other, with equal scales across.

    Parameters
    ----------
    axles : the columns of each axle by its name, as for `time_histories`, with its errors
    """
    tables = {name: _checked(columns) for name, columns in axles.items()}
    # points of a construction stay in one panel, where a reader adds them up
    rows = _rows(list(tables.values()), split=not points)
    palette, across = look.palette, len(tables)
    long = max(float(table["time"][-1]) for table in tables.values()) > 1.0
    unit, factor = ("s", 1.0) if long else ("ms", 1e3)
    width = look.inches or (9.0 if across == 1 else 1.5 + 5.2 * across)
    narrow = width < _NARROW
    between = "\n" if narrow else " "  # the name of an axis and its unit
    height = 2.2 * min(1.0, 0.5 + width / across / 15.0)
    figure = Printed(look, width, 0.5 + len(rows) * height)
    grid = figure.subplots(len(rows), across, sharex=True, sharey="row", squeeze=False)
    for k, (axle, table) in enumerate(tables.items()):
        panels, times = grid[:, k], factor * table["time"]
        spans = airborne_spans(times, table["airborne"]) if "airborne" in table else []
        for axes, row in zip(panels, rows, strict=True):
            _panel(axes, row, table, times, palette, points=points)
            for start, end in spans:
                axes.axvspan(start, end, color=palette.tint, zorder=0.0, gid="airborne")
            if not k:
                name_up(axes, f"{row[0].name}{between}[{row[0].unit}]")
        for start, end in spans[:1]:
            panels[0].annotate(
                "airborne", (0.5 * (start + end), 1.0), (0.0, -2.0 if narrow else 2.0),
                xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                va="top" if narrow else "bottom", fontsize=8.0, color=palette.faint,
                bbox=palette.plate(),
            )  # fmt: skip
        panels[-1].set_xlabel(f"time [{unit}]")
        if axle:
            panels[0].set_title(axle, loc="right")
    keys = []  # of each row, with the curves of all axles in one order
    for (_, columns), panels in zip(rows, grid, strict=True):
        drawn = {line.get_gid(): line for axes in panels for line in axes.lines}
        keys.append([drawn[name] for name in reversed(columns) if name in drawn])
    if narrow:
        # by a label that goes with a part in all panels: body for body x₁
        named = {
            " ".join(word for word in str(line.get_label()).split() if len(word) > 2): line
            for line in chain.from_iterable(reversed(keys))
        }
        figure.key(list(named.values()), labels=list(named))
    else:
        for axes, key in zip(grid[:, -1], keys, strict=True):
            axes.legend(handles=key, loc="center left", bbox_to_anchor=(1.01, 0.5))
    return figure.finished(*title.split("\n"))


def has_histories(columns: Mapping[str, object]) -> bool:
    """Whether some of the columns are drawn by `time_histories`."""
    return not _KNOWN.isdisjoint(columns)


def airborne_spans(times: npt.ArrayLike, airborne: npt.ArrayLike) -> list[tuple[float, float]]:
    """Return the intervals in which the wheel is off the road.

    An interval begins at the first airborne time and ends at the next that is not airborne.
    """
    instants = np.asarray(times, float)
    flies = np.concatenate([[False], np.asarray(airborne, float) > 0.5, [False]])
    changes = np.flatnonzero(flies[1:] != flies[:-1]).clip(max=len(instants) - 1)
    return [(float(start), float(end)) for start, end in instants[changes].reshape(-1, 2)]


def _checked(columns: Mapping[str, npt.ArrayLike]) -> Table:
    if "time" not in columns:
        raise ValueError(f"no column 'time'; columns given: {', '.join(columns) or 'none'}")
    if not has_histories(columns):
        raise ValueError(
            f"none of the columns can be drawn: {', '.join(columns)}; known columns are "
            + ", ".join(sorted(_KNOWN))
        )
    own = _KNOWN | {"time", "airborne"}
    table = {name: np.asarray(column, float) for name, column in columns.items() if name in own}
    shape = table["time"].shape
    if len(shape) != 1 or shape[0] < 2:
        raise ValueError(
            f"'time' has shape {shape}: must be one-dimensional with at least two values"
        )
    for name, column in table.items():
        if column.shape != shape:
            raise ValueError(
                f"column {name!r} has shape {column.shape}: must be {shape}, as 'time'"
            )
    return table


def _rows(tables: list[Table], *, split: bool) -> list[Row]:
    """Return the panels, with one for the body's acceleration if it is flat next to the wheel's."""
    rows: list[Row] = []
    for quantity in QUANTITIES:
        columns = _COLUMNS.get(quantity.name, {})
        known = [table[name] for table in tables for name in columns if name in table]
        if not known:
            continue
        shown = in_range(quantity, known)
        if split and _BODY in columns and any(_is_flat(table, columns) for table in tables):
            own = {name: columns[name] for name in columns if name in _OF_BODY}
            rest = {name: columns[name] for name in columns if name not in own}
            rows += [(shown, rest), (replace(shown, name="body acceleration"), own)]
        else:
            rows.append((shown, columns))
    return rows


def _is_flat(table: Table, columns: Mapping[str, str]) -> bool:
    peaks = {name: float(np.max(np.abs(table[name]))) for name in columns if name in table}
    return 0.0 < peaks.get(_BODY, 0.0) < _FLAT * max(peaks.values())


def _panel(
    axes: Axes, row: Row, table: Table, times: npt.NDArray[np.float64], palette: Palette, *,
    points: bool,
) -> None:  # fmt: skip
    quantity, columns = row
    dashes: dict[str, Any] = {**_DASHES, **(_MONO if palette.mono else {})}
    every = max(1, len(times) // _MONO_MARKED) if palette.mono else 1
    marked = points and len(times) <= _MOST_MARKED
    for name in (name for name in columns if name in table):
        words = name.split("_")
        marker, filled = _MARKERS.get(words[0], (".", True)) if palette.mono else (".", True)
        axes.plot(
            times, quantity.factor * table[name], color=palette.of(hue_of(name)),
            linewidth=1.6 if words[0] in ("body", "wheel") else 1.1,
            linestyle=next((dashes[word] for word in words if word in dashes), "-"),
            marker=marker if marked and words[0] != "road" else "", markersize=4.0, markevery=every,
            markerfacecolor=None if filled else palette.paper, label=columns[name], gid=name,
        )  # fmt: skip
    axes.axhline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)
    axes.set_xlim(times[0], times[-1])


@styled
def runs(
    values: Mapping[str, Mapping[str, Curve]],
    units: Mapping[str, str],
    *, title: str = "", look: Look = PLAIN,
) -> Figure:  # fmt: skip
    """Draw columns of several runs over one another, each column in a panel of its own.

    Parameters
    ----------
    values : for each column its time (s) and values by the name of the run
    units : of the columns, where known

    Raises
    ------
    ValueError : if there are no columns.
    """
    count = len(values)
    if not count:
        raise ValueError("no columns to draw")
    narrow = look.inches is not None and look.inches < _NARROW
    across = 1 if narrow else min(ceil(count / _IN_COLUMN), _ACROSS)
    down = ceil(count / across)
    figure = Printed(look, look.inches or 2.5 + 6.0 * across, 0.5 + 1.5 * down)
    panels = figure.subplots(down, across, sharex=True, squeeze=False).T.ravel()
    for axes in panels[count:]:
        axes.set_axis_off()
    for k in range(0, count, down):
        lowest = panels[min(k + down, count) - 1]
        lowest.set_xlabel("time [s]")
        lowest.tick_params(labelbottom=True)
    labels = list(dict.fromkeys(label for curves in values.values() for label in curves))
    drawn = {}
    for axes, (name, curves) in zip(panels, values.items(), strict=False):
        unit, factor = unit_of_columns(
            units.get(name, ""), [column for _, column in curves.values()]
        )
        name_up(axes, fill(in_words(name), _LINE) + bracketed(unit).replace(" ", "\n", 1))
        for label, (time, column) in curves.items():
            number = labels.index(label)
            style = {**look.palette.curve(number), "linestyle": DASHES[number % len(DASHES)]}
            scaled = factor * np.asarray(column, float)
            (drawn[label],) = axes.plot(time, scaled, linewidth=1.3, label=label, **style)
        if not unit and all(np.isin(column, (0.0, 1.0)).all() for _, column in curves.values()):
            axes.set(ylim=(-0.1, 1.1), yticks=(0, 1))  # true or false, such as airborne
    if len(labels) > 1:  # all of them, though a panel may have but one
        figure.key([drawn[label] for label in labels])
    return figure.finished(title)


@styled
def plane_of_columns(
    curves: Mapping[str, Curve],
    names: tuple[str, str],
    units: Mapping[str, str],
    *, title: str = "", look: Look = PLAIN,
) -> Figure:  # fmt: skip
    """Draw one column over another, such as a rate over its displacement, for one or more runs.

    Parameters
    ----------
    curves : abscissa and ordinate by the name of the run, shape (n,) each
    names : names of the two columns
    units : of the columns, where known

    Raises
    ------
    ValueError : if there are no curves.
    """
    if not curves:
        raise ValueError("no columns to draw")
    figure = look.blank(6.5, 5.6)
    axes = figure.subplots()
    shown = [
        unit_of_columns(units.get(name, ""), columns)
        for name, columns in zip(names, zip(*curves.values(), strict=True), strict=True)
    ]
    for number, (label, both) in enumerate(curves.items()):
        x, y = (factor * np.asarray(v, float) for v, (_, factor) in zip(both, shown, strict=True))
        style = look.palette.curve(number)
        axes.plot(x, y, linewidth=1.3, label=label, **style)
        axes.plot(x[:1], y[:1], "o", color=style["color"], markersize=4.0)
    words = [in_words(n) + bracketed(unit) for n, (unit, _) in zip(names, shown, strict=True)]
    axes.set(xlabel=words[0], ylabel=words[1])
    if len(curves) > 1:
        axes.legend()
    return figure.finished(title)
