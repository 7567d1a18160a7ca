"""Motions over time: displacements with the road, velocities, accelerations, energies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from phaseplane.picture.quantities import QUANTITIES, Quantity
from phaseplane.picture.styles import hue_of

from .style import PLAIN, Look, Palette, Printed, name_up, styled

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
"""The columns of each quantity, and their labels."""
_KNOWN = {name for columns in _COLUMNS.values() for name in columns}
_BODY = "body_acceleration"
_OF_BODY = (_BODY, "body_centre_acceleration")
_FLAT = 0.1  # of the largest acceleration: below it, that of the body has a panel of its own
_DASHES = {"road": "--", "centre": ":"}
_MONO = {  # the dashes of black lines, besides
    "wheel": "-.", "suspension": (0, (6, 1.5)), "stored": "--", "dissipated": "-.", "supplied": ":",
}  # fmt: skip
# the markers of black lines, and whether they are filled
_MARKERS = {"body": ("o", True), "wheel": ("s", False), "suspension": ("^", False)}
_MONO_MARKED = 20  # times that are marked on black lines, whose dashes are seen between them
_MOST_MARKED = 300  # times that are marked; more would be a blot
_NARROW = 5.0  # in: a picture with one legend for all panels

Table = dict[str, npt.NDArray[np.float64]]
Row = tuple[str, Quantity, dict[str, str]]
"""The name of a panel, its quantity, and its columns with their labels."""


@styled
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
    return _histories({"": columns}, title, look, points)


@styled
def axle_histories(
    axles: Mapping[str, Mapping[str, npt.ArrayLike]], *, title: str = "", look: Look = PLAIN
) -> Figure:
    """Draw the motions over several axles beside each other, each with its road and flights.

    Parameters
    ----------
    axles : the columns of each axle by its name, as for `time_histories`, with its errors
    """
    return _histories(axles, title, look, points=False)


def _histories(
    axles: Mapping[str, Mapping[str, npt.ArrayLike]], title: str, look: Look, points: bool
) -> Figure:
    """Draw a column of panels for each axle, with equal scales across."""
    checked = {name: _checked(columns) for name, columns in axles.items()}
    shown = max((shown for _, shown in checked.values()), key=len)
    # points of a construction stay in one panel, where a reader adds them up
    rows = _rows(shown, [] if points else [table for table, _ in checked.values()])
    palette, across = look.palette, len(checked)
    long = max(float(table["time"][-1]) for table, _ in checked.values()) > 1.0
    unit, factor = ("s", 1.0) if long else ("ms", 1e3)
    width = look.inches or (9.0 if across == 1 else 1.5 + 5.2 * across)
    narrow = width < _NARROW
    between = "\n" if narrow else " "  # the name of an axis and its unit
    height = 2.2 * min(1.0, 0.5 + width / across / 15.0)
    figure = Printed(look, width, 0.5 + len(rows) * height)
    grid = figure.subplots(len(rows), across, sharex=True, sharey="row", squeeze=False)
    for k, (axle, (table, _)) in enumerate(checked.items()):
        panels = grid[:, k]
        spans = airborne_spans(table["time"], table["airborne"]) if "airborne" in table else []
        for axes, row in zip(panels, rows, strict=True):
            _panel(axes, row, table, factor * table["time"], palette, points=points)
            for start, end in spans:
                axes.axvspan(
                    factor * start, factor * end, color=palette.tint, zorder=0.0, gid="airborne"
                )
            if k + 1 == across and not narrow:
                axes.legend(reverse=True, loc="center left", bbox_to_anchor=(1.01, 0.5))
            if not k:
                name_up(axes, f"{row[0]}{between}[{row[1].unit}]")
        for start, end in spans[:1]:
            panels[0].annotate(
                "airborne", (0.5 * factor * (start + end), 1.0), (0.0, -2.0 if narrow else 2.0),
                xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                va="top" if narrow else "bottom", fontsize=8.0, color=palette.faint,
                bbox=palette.plate(),
            )  # fmt: skip
        panels[-1].set_xlabel(f"time [{unit}]")
        if axle:
            panels[0].set_title(axle, loc="right")
    if narrow:
        lines = [line for axes in grid[:, 0] for line in axes.lines if line.get_gid()]
        named = {_without_symbol(str(line.get_label())): line for line in reversed(lines)}
        figure.key(list(named.values()), labels=list(named))
    return figure.finished(*title.split("\n"))


def _without_symbol(label: str) -> str:
    """Return a label that goes with a part in all panels: body for body x₁."""
    return " ".join(word for word in label.split() if len(word) > 2)


def has_histories(columns: Mapping[str, object]) -> bool:
    """Whether some of the columns are drawn by `time_histories`."""
    return not _KNOWN.isdisjoint(columns)


def airborne_spans(times: npt.ArrayLike, airborne: npt.ArrayLike) -> list[tuple[float, float]]:
    """Return the intervals in which the wheel is off the road, s.

    An interval begins at the first airborne time and ends at the next that is not airborne.
    """
    instants = np.asarray(times, float)
    flies = np.concatenate([[False], np.asarray(airborne, float) > 0.5, [False]])
    changes = np.flatnonzero(flies[1:] != flies[:-1])
    last = len(instants) - 1
    return [
        (float(instants[start]), float(instants[min(end, last)]))
        for start, end in zip(changes[::2], changes[1::2], strict=True)
    ]


def _checked(columns: Mapping[str, npt.ArrayLike]) -> tuple[Table, list[Quantity]]:
    if "time" not in columns:
        raise ValueError(f"no column 'time'; columns given: {', '.join(columns) or 'none'}")
    table = {
        name: np.asarray(column, float)
        for name, column in columns.items()
        if name in _KNOWN | {"time", "airborne"}
    }
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
    shown = [q for q in QUANTITIES if not table.keys().isdisjoint(_COLUMNS.get(q.name, ()))]
    if not shown:
        raise ValueError(
            f"none of the columns can be drawn: {', '.join(columns)}; known columns are "
            + ", ".join(sorted(_KNOWN))
        )
    return table, shown


def _rows(shown: list[Quantity], tables: list[Table]) -> list[Row]:
    """Return the panels, with one for the body's acceleration if it is flat next to the wheel's."""
    rows: list[Row] = []
    for quantity in shown:
        columns = _COLUMNS[quantity.name]
        if _BODY in columns and any(_flat(table, columns) for table in tables):
            own = {name: columns[name] for name in columns if name in _OF_BODY}
            rest = {name: columns[name] for name in columns if name not in own}
            rows += [(quantity.name, quantity, rest), ("body acceleration", quantity, own)]
        else:
            rows.append((quantity.name, quantity, columns))
    return rows


def _flat(table: Table, columns: Iterable[str]) -> bool:
    peaks = {name: float(np.max(np.abs(table[name]))) for name in columns if name in table}
    return 0.0 < peaks.get(_BODY, 0.0) < _FLAT * max(peaks.values())


def _panel(
    axes: Axes, row: Row, table: Table, times: npt.NDArray[np.float64], palette: Palette, *,
    points: bool,
) -> None:  # fmt: skip
    _, quantity, columns = row
    dashes: dict[str, Any] = {**_DASHES, **(_MONO if palette.mono else {})}
    every = max(1, len(times) // _MONO_MARKED) if palette.mono else 1
    for name in (name for name in columns if name in table):
        element, *words = name.split("_")
        marker, filled = _MARKERS.get(element, (".", True)) if palette.mono else (".", True)
        face = None if filled else palette.paper
        axes.plot(
            times, quantity.factor * table[name], color=palette.of(hue_of(name)),
            linewidth=1.6 if element in ("body", "wheel") else 1.1,
            linestyle=next((dashes[word] for word in (element, *words) if word in dashes), "-"),
            marker=marker if points and element != "road" and len(times) <= _MOST_MARKED else "",
            markersize=4.0, markevery=every, markerfacecolor=face, label=columns[name], gid=name,
        )  # fmt: skip
    axes.axhline(0.0, color=palette.faint, linewidth=0.6, zorder=1.0)
    axes.set_xlim(times[0], times[-1])
