"""Two runs compared column by column, and what only one of them has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    Column = npt.NDArray[np.float64]
    Columns = Mapping[str, Column]

_ROUNDING = 1e-6  # of the longer run, within which two instants are the same
_MOST_NAMED = 3


@dataclass(frozen=True, slots=True)
class Difference:
    """How far one column lies from the same one of another run.

    Parameters
    ----------
    name : of the column
    largest : magnitude of the largest difference, in the column's unit
    peak : largest magnitude of either column where both are known
    time : the instant of the largest difference, s
    """

    name: str
    largest: float
    peak: float
    time: float

    @property
    def relative(self) -> float:
        """The largest difference over the peak; 0 where both columns vanish."""
        if not isfinite(self.largest):
            return inf
        return self.largest / self.peak if self.peak > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Extent:
    """The rows of a run: how many, and from when to when, s."""

    rows: int
    start: float
    end: float

    def __str__(self) -> str:
        rows = "row" if self.rows == 1 else "rows"
        return f"{self.rows} {rows} from {self.start:g} to {self.end:g} s"


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two runs compared where both have values.

    Parameters
    ----------
    differences : of the columns compared, largest relative one first
    ours, other : rows of the two
    common : our rows that lie within the other's time, which are compared
    only_ours, only_other : names of columns that the other one lacks
    """

    differences: tuple[Difference, ...]
    ours: Extent
    other: Extent
    common: Extent
    only_ours: tuple[str, ...]
    only_other: tuple[str, ...]

    def unshared(self, ours: str, other: str) -> list[str]:
        """What only one of the two has, a phrase each, with the names they go by."""
        told = []
        near = _ROUNDING * max(e.end - e.start for e in (self.ours, self.other))
        if (
            self.ours.rows != self.other.rows
            or abs(self.ours.start - self.other.start) > near
            or abs(self.ours.end - self.other.end) > near
        ):
            told.append(f"{ours} has {self.ours}, {other} has {self.other}")
        told += [
            f"only {name} has {'column' if len(columns) == 1 else 'columns'} {_listed(columns)}"
            for name, columns in ((ours, self.only_ours), (other, self.only_other))
            if columns
        ]
        return told

    def as_data(self) -> dict[str, Any]:
        """What was compared, as plain data."""
        return {
            "columns": [difference.name for difference in self.differences],
            "rows": self.common.rows,
            "from": self.common.start,
            "to": self.common.end,
        }


def extent_words(compared: Mapping[str, Any]) -> str:
    """What was compared, as `Comparison.as_data` gives it, in words."""
    columns = len(compared["columns"])
    extent = Extent(compared["rows"], compared["from"], compared["to"])
    return f"{columns} {'column' if columns == 1 else 'columns'}, {extent}"


def _listed(names: tuple[str, ...]) -> str:
    left = len(names) - _MOST_NAMED
    more = f" and {left} more" if left > 0 else ""
    return f"{', '.join(names[:_MOST_NAMED])}{more}"


def compared(ours: Columns, other: Columns, names: Iterable[str] | None = None) -> Comparison:
    """Compare two runs.

    The other run is read at our instants, between its own by straight lines, over the time that both
    have in common.

    Parameters
    ----------
    ours, other : `time` (s) and columns of the same length, in the same units
    names : only these columns, which both must have; all if left out

    Raises
    ------
    ValueError : no column or no time in common, or times that cannot be compared.
    """
    wanted = None if names is None else tuple(names)
    shared = [name for name in ours if name in other and name != "time"]
    if wanted is not None:
        shared = [name for name in wanted if name in shared]
    if not shared:
        raise ValueError("no column in common")
    time, then = ours["time"].astype(float), other["time"].astype(float)
    for instants in (time, then):
        check_ascending(instants)
    near = _ROUNDING * max(time[-1] - time[0], then[-1] - then[0])
    both = (time >= then[0] - near) & (time <= then[-1] + near)
    if not both.any():
        raise ValueError(
            f"no time in common: {time[0]:g} to {time[-1]:g} s and {then[0]:g} to {then[-1]:g} s"
        )
    found = [_difference(name, time, ours[name], then, other[name], both) for name in shared]
    alone = wanted is None
    return Comparison(
        tuple(sorted(found, key=lambda difference: -difference.relative)),
        _extent(time),
        _extent(then),
        _extent(time[both]),
        tuple(name for name in ours if alone and name not in other),
        tuple(name for name in other if alone and name not in ours),
    )


def _difference(
    name: str, time: Column, ours: Column, then: Column, other: Column,
    both: npt.NDArray[np.bool_],
) -> Difference:  # fmt: skip
    a = ours[both].astype(float)
    b = np.interp(time[both], then, other.astype(float))
    with np.errstate(invalid="ignore"):  # infinity less infinity
        gap = abs(a - b)
    gap[(np.isnan(a) & np.isnan(b)) | (a == b)] = 0.0
    gap[np.isnan(gap)] = np.inf
    row = int(gap.argmax())
    peak = float(max(np.nanmax(abs(a), initial=0.0), np.nanmax(abs(b), initial=0.0)))
    return Difference(name, float(gap[row]), peak, float(time[both][row]))


def check_ascending(time: Column) -> None:
    """Refuse instants that are not finite or go back.

    Raises
    ------
    ValueError : names the row.
    """
    for row in np.flatnonzero(~np.isfinite(time)):
        raise ValueError(f"time is {time[row]:g} in row {row + 1}; it must be a finite number")
    for row in np.flatnonzero(np.diff(time) < 0.0):
        raise ValueError(
            f"time must not go back, but {time[row + 1]:g} follows {time[row]:g} s in row {row + 2}"
        )


def check_comparable(columns: Columns, names: Iterable[str]) -> None:
    """Refuse what nothing can be compared with: times that go back, and what is not a number.

    Raises
    ------
    ValueError : names column and row.
    """
    check_ascending(columns["time"].astype(float))
    for name in names:
        for row in np.flatnonzero(~np.isfinite(columns[name].astype(float))):
            raise ValueError(f"{name} is {columns[name][row]:g} in row {row + 1}")


def _extent(time: Column) -> Extent:
    return Extent(len(time), float(time[0]), float(time[-1]))
