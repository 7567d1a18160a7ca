"""The comparison of two runs, column by column."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.units import counted

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..columns import Column, Columns


_ROUNDING = 1e-6  # of the longer run's duration: instants this close are the same
_MOST_NAMED = 3


@dataclass(frozen=True, slots=True)
class Difference:
    """The largest difference between a column and the same column of another run.

    Parameters
    ----------
    name : name of the column
    largest : magnitude of the largest difference, in the column's unit
    peak : largest finite magnitude of either column over their common time
    time : time of the largest difference, s
    """

    name: str
    largest: float
    peak: float
    time: float

    @property
    def relative(self) -> float:
        """The largest difference over the peak; 0 if both columns are zero."""
        if not isfinite(self.largest):
            return inf
        return self.largest / self.peak if self.peak > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Extent:
    """The number of rows of a run, and its first and last time, s."""

    rows: int
    start: float
    end: float

    def __str__(self) -> str:
        return f"{counted(self.rows, 'row')} from {self.start:g} to {self.end:g} s"


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison of two runs over their common time.

    Parameters
    ----------
    differences : one for each column compared, the largest relative difference first
    ours, other : rows of the two runs
    common : rows of the first run within the time of the other, which are compared
    only_ours, only_other : names of columns that the other run lacks
    """

    differences: tuple[Difference, ...]
    ours: Extent
    other: Extent
    common: Extent
    only_ours: tuple[str, ...]
    only_other: tuple[str, ...]

    def unshared(self, ours: str, other: str) -> list[str]:
        """Return what only one of the two runs has, in words; `ours` and `other` name the runs."""
        lines = []
        near = _ROUNDING * max(e.end - e.start for e in (self.ours, self.other))
        if (
            self.ours.rows != self.other.rows
            or abs(self.ours.start - self.other.start) > near
            or abs(self.ours.end - self.other.end) > near
        ):
            lines.append(f"{ours} has {self.ours}, {other} has {self.other}")
        lines += [
            f"only {name} has {'column' if len(columns) == 1 else 'columns'} {_listed(columns)}"
            for name, columns in ((ours, self.only_ours), (other, self.only_other))
            if columns
        ]
        return lines

    def as_data(self) -> dict[str, Any]:
        """Return the columns, rows and time compared, as plain data."""
        return {
            "columns": [difference.name for difference in self.differences],
            "rows": self.common.rows,
            "from": self.common.start,
            "to": self.common.end,
        }


def format_extent(compared: Mapping[str, Any]) -> str:
    """Return the columns, rows and time of `Comparison.as_data` in words."""
    extent = Extent(compared["rows"], compared["from"], compared["to"])
    return f"{counted(len(compared['columns']), 'column')}, {extent}"


def _listed(names: tuple[str, ...]) -> str:
    left = len(names) - _MOST_NAMED
    more = f" and {left} more" if left > 0 else ""
    return f"{', '.join(names[:_MOST_NAMED])}{more}"


def compared(ours: Columns, other: Columns, names: Iterable[str] | None = None) -> Comparison:
    """Compare two runs.

    The other run is interpolated linearly at the times of the first, over their common time.

    Parameters
    ----------
    ours, other : `time` (s) and columns of the same length, in the same units
    names : columns to compare, which both must have; all if None

    Raises
    ------
    ValueError : if no column or no time is common, `names` contains the time, or a time is not finite
        or goes back.
    """
    wanted = None if names is None else tuple(names)
    if wanted is not None and "time" in wanted:
        raise ValueError("time cannot be compared: columns are compared at equal times")
    shared = [name for name in ours if name in other and name != "time"]
    if wanted is not None:
        shared = [name for name in wanted if name in shared]
    if not shared:
        raise ValueError(
            "no column in common; a TOML file with a table [measured] assigns the columns of a "
            "measurement to outputs"
        )
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
    b = _at(time, then, other.astype(float))[both]
    with np.errstate(invalid="ignore"):  # infinity minus infinity
        gap = abs(a - b)
    gap[(np.isnan(a) & np.isnan(b)) | (a == b)] = 0.0
    gap[np.isnan(gap)] = np.inf
    row = int(gap.argmax())
    peak = max(float(abs(x[np.isfinite(x)]).max(initial=0.0)) for x in (a, b))
    return Difference(name, float(gap[row]), peak, float(time[both][row]))


def _at(time: Column, then: Column, values: Column) -> Column:
    """Return values at other times, between them by straight lines.

    Where a time is repeated, as on both sides of a jump, its rows have the values in turn, and the last
    of them the last value.
    """
    found = np.interp(time, then, values)
    turn = np.arange(len(time)) - np.searchsorted(time, time)
    goes_on = np.append(time[1:] == time[:-1], False)
    first, last = np.searchsorted(then, time), np.searchsorted(then, time, "right") - 1
    known = then[last] == time
    found[known] = values[np.where(goes_on, np.minimum(first + turn, last), last)[known]]
    return found


def check_ascending(time: Column) -> None:
    """Reject times that are not finite or go back.

    Raises
    ------
    ValueError : if there is one; the message names the row.
    """
    for row in np.flatnonzero(~np.isfinite(time)):
        raise ValueError(f"time is {time[row]:g} in row {row + 1}; it must be a finite number")
    for row in np.flatnonzero(np.diff(time) < 0.0):
        raise ValueError(
            f"time must not go back, but {time[row + 1]:g} follows {time[row]:g} s in row {row + 2}"
        )


def check_comparable(columns: Columns, names: Iterable[str]) -> None:
    """Reject columns that cannot be a reference: times that go back, or values that are not finite.

    Raises
    ------
    ValueError : if there is one; the message names column and row.
    """
    check_ascending(columns["time"].astype(float))
    for name in names:
        for row in np.flatnonzero(~np.isfinite(columns[name].astype(float))):
            raise ValueError(f"{name} is {columns[name][row]:g} in row {row + 1}")


def _extent(time: Column) -> Extent:
    return Extent(len(time), float(time[0]), float(time[-1]))
