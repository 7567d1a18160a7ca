"""Expectations of a run: bounds on measures, bounds on outputs, agreement with a reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import Variable

from .. import results
from ..errors import shown
from ..measures import COUNT, Measure, Reading, has_sign
from ..toml_files import in_si
from .fields import (
    FACTOR,
    FLAG,
    INSTANT,
    NUMBER_OR_TEXT,
    TEXT,
    entry,
    format_unit,
    names_of,
    one_of,
)

if TYPE_CHECKING:
    from ..columns import Column, Columns

_TOLERANCE = 1e-6
_COMMON = "set common = true to compare only the rows, times and columns that both have"


@dataclass(frozen=True, slots=True)
class Bounds:
    """Bounds on a measure, in SI; at least one of the two."""

    min: float | None = None
    max: float | None = None

    def hold(self, value: object) -> bool:
        """Whether a value, or each of several, is within the bounds; a missing value is not."""
        if isinstance(value, list | tuple):
            return bool(value) and all(self.hold(one) for one in value)
        if not isinstance(value, int | float):
            return False
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


@dataclass(frozen=True, slots=True, kw_only=True)
class During:
    """Bounds on an output within an interval of time, always or sometime.

    Models of this package are checked between the rows too, as for measures.
    """

    output: str = entry(TEXT, "name of the output")
    start: float = entry(
        INSTANT, "start of the interval; the start of the run if left out", 0.0, name="from"
    )
    end: float | None = entry(
        INSTANT, "end of the interval; the end of the run if left out", None, name="to"
    )
    min: float | str | None = entry(
        NUMBER_OR_TEXT, "lower bound, a number in SI or a string with a unit", None
    )
    max: float | str | None = entry(NUMBER_OR_TEXT, "upper bound, as min", None)
    equals: bool | None = entry(FLAG, "true or false, for boolean outputs", None, name="is")
    when: str = entry(
        one_of(("always", "sometime")),
        "whether it must hold at every instant of the interval or at some instant",
        "always",
    )

    def __post_init__(self) -> None:
        if (self.min is None and self.max is None) == (self.equals is None):
            raise ValueError("needs min and/or max, or is = true or false")
        if self.end is not None and self.end < self.start:
            raise ValueError("to is before from")

    def bounds(self, outputs: Mapping[str, Variable]) -> Bounds:
        """Return the bounds in SI.

        Raises
        ------
        ValueError : if there is no such output, or the bounds do not fit it.
        """
        if self.output not in outputs:
            raise ValueError(f"no output {shown(self.output)}{nearest(self.output, outputs)}")
        if self.equals is not None:
            return Bounds(min=float(self.equals), max=float(self.equals))
        raw = {"min": self.min, "max": self.max}
        given = {key: value for key, value in raw.items() if value is not None}
        return bounds_from(given, outputs[self.output].unit or "1")

    def judged(
        self, outputs: Mapping[str, Variable], time: Column, column: Column
    ) -> dict[str, Any]:
        """Return whether it holds, with the deciding value and its time: the first of them."""
        bounds, column = self.bounds(outputs), column.astype(float)
        low = -inf if bounds.min is None else bounds.min
        high = inf if bounds.max is None else bounds.max
        within = (low <= column) & (column <= high)
        end = inf if self.end is None else self.end
        during = (self.start - 1e-9 <= time) & (time <= end + 1e-9)
        sometime = self.when == "sometime"
        deciding = during & (within if sometime else ~within)
        holds = bool(during.any() and deciding.any() == sometime)
        rows = np.flatnonzero(deciding if deciding.any() else during)[:1]
        until = "the end" if self.end is None else f"{self.end:g} s"
        return {
            "measure": f"{self.output} {self.when} from {self.start:g} s to {until}",
            **asdict(bounds),
            "value": float(column[rows[0]]) if len(rows) else None,
            "time": float(time[rows[0]]) if len(rows) else None,
            "holds": holds,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """A table of results that the run must agree with."""

    file: str = entry(
        TEXT,
        "CSV, Parquet, HDF5 or MAT file with a column time (s) and outputs by name, in SI",
    )
    tolerance: float = entry(
        FACTOR, "largest difference, relative to the column's peak", _TOLERANCE
    )
    columns: tuple[str, ...] | None = entry(
        names_of("columns"), "names of the columns to compare; all if left out", None
    )
    common: bool = entry(
        FLAG,
        "whether to compare only the rows, times and columns that file and run share; otherwise "
        "those that only one of them has count as differences",
        False,
    )


@dataclass(frozen=True, slots=True)
class ReferenceTable:
    """The settings of a reference, the path of its file, and the columns read from it."""

    settings: Reference
    path: Path
    columns: Columns = field(repr=False)

    def judged(self, columns: Columns) -> dict[str, Any]:
        """Return whether the worst column is within tolerance, and rows and columns are the same.

        Parameters
        ----------
        columns : the columns the run shows, and its other columns that the file has too
        """
        file, most = self.path.name, self.settings.tolerance
        entry = {"min": None, "max": most, "value": None, "time": None, "holds": False}
        try:
            found = results.comparison.compared(columns, self.columns, self.settings.columns)
        except ValueError as error:
            return {"measure": f"difference from {file}", **entry, "reason": str(error)}
        worst = found.differences[0]
        unshared = [] if self.settings.common else found.unshared("the run", file)
        return {
            "measure": f"difference of {worst.name} from {file}",
            **entry,
            "value": worst.relative,
            "time": worst.time,
            "holds": worst.relative <= most and not unshared,
            "reason": "; ".join([*unshared, _COMMON] if unshared else []),
            "compared": found.as_data(),
        }


def unknown_measure(name: str, known: Mapping[str, Measure]) -> str:
    """Return what is wrong with the name of a measure, or with the key of its bounds at its end."""
    measure, _, bound = name.rpartition(".")
    if measure in known:
        return f"{measure}: {shown(bound)} is unknown; must be min and/or max"
    return f"no measure {shown(name)}{nearest(name, known)}"


def bounds_from(raw: object, unit: str) -> Bounds:
    """Return the bounds `{min, max}` in SI; for a count also one integer.

    Raises
    ------
    ValueError : if they are not finite numbers, or strings with a unit, or min is above max.
    """
    if unit == COUNT and isinstance(raw, int) and not isinstance(raw, bool):
        raw = {"min": raw, "max": raw}
    if not isinstance(raw, dict) or not raw:
        raise ValueError(
            "must be an integer, or min and/or max"
            if unit == COUNT
            else f"must be min and/or max{format_unit(unit)}"
        )
    bounds = {}
    for name, value in raw.items():
        if name not in ("min", "max"):
            raise ValueError(f"{shown(name)} is unknown; must be min and/or max")
        si = unit if unit != COUNT else "1"
        bounds[name] = in_si(value, si)
        if not isfinite(bounds[name]):
            raise ValueError(f"{name} must be a finite number{format_unit(si)}")
    if bounds.get("min", -inf) > bounds.get("max", inf):
        raise ValueError("min is above max")
    return Bounds(**bounds)


def judged_measures(
    expected: Mapping[str, Bounds | tuple[Bounds, ...]], readings: Mapping[str, Reading]
) -> Iterator[dict[str, Any]]:
    """Yield whether each measure is within its bounds, value by value if each has its own."""
    for name, bounds in expected.items():
        value, time = readings[name]
        if isinstance(bounds, Bounds):
            yield _judged(name, bounds, value, time)
            continue
        values = value if isinstance(value, list | tuple) else (value,)
        for number in range(max(len(values), len(bounds))):
            entry = f"{name} {number + 1}"
            if number < min(len(values), len(bounds)):
                yield _judged(entry, bounds[number], values[number], time)
            else:
                why = f"{len(values)} values, but bounds for {len(bounds)}"
                yield {**_judged(entry, Bounds(), None, time), "reason": why}


def remarks(
    expected: Mapping[str, Bounds | tuple[Bounds, ...]], readings: Mapping[str, Reading]
) -> Iterator[str]:
    """Yield a remark on each peak that is within its only bound, but beyond it on the other side."""
    for name, bounds in expected.items():
        if not has_sign(name) or not isinstance(bounds, Bounds):
            continue
        value = readings[name].value
        limit, *other = (x for x in (bounds.min, bounds.max) if x is not None)
        if other or not bounds.hold(value) or not isinstance(value, float):
            continue
        if value * limit < 0.0 and abs(value) > abs(limit):
            yield (
                f"{name} = {value:.4g} is within its bound, but a peak has a sign; to bound its "
                f"magnitude, write {{ min = {-abs(limit):g}, max = {abs(limit):g} }}"
            )


def _judged(name: str, bounds: Bounds, value: object, time: float | None) -> dict[str, Any]:
    held = {"value": value, "time": time, "holds": bounds.hold(value)}
    return {"measure": name, **asdict(bounds), **held}
