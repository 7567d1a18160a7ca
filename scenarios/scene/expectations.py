"""What must hold of a run: bounds on measures, bounds within a time, closeness to a reference."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, isfinite
from typing import TYPE_CHECKING, Annotated, Any, Literal

from phaseplane.suspension.units import nearest, to_si
from phaseplane.suspension.variables import Variable
from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from ..errors import shown
from ..measures import COUNT, Reading
from ..results.comparison import compared
from .fields import Factor, Instant, Strict, choices, one_of, tuple_from, unit_words

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Columns = Mapping[str, npt.NDArray[np.float64]]

_TOLERANCE = 1e-6
_COMMON = "common = true compares only what both have"


class Bounds(Strict):
    """What a measure must keep to, in SI; at least one of the two."""

    min: float | None = None
    max: float | None = None

    def hold(self, value: object) -> bool:
        """Whether a measured value keeps to them; one that could not be measured does not."""
        if not isinstance(value, int | float):
            return False
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


class During(Strict):
    """What an output must keep to from one instant to another, always or sometime.

    It is looked at as closely as measures are: a model of this project also between the rows.
    """

    model_config = ConfigDict(**{**Strict.model_config, "populate_by_name": True})

    output: str
    """name of the output"""
    start: Annotated[Instant, Field(alias="from")] = 0.0
    """from this instant on; from the beginning if left out"""
    end: Annotated[Instant | None, Field(alias="to")] = None
    """to this instant; to the end if left out"""
    min: float | str | None = None
    """lower bound, a number in SI or a text with a unit"""
    max: float | str | None = None
    """upper bound, as min"""
    equals: Annotated[bool | None, Field(alias="is")] = None
    """true or false, for outputs that are"""
    when: Annotated[
        Literal["always", "sometime"],
        BeforeValidator(one_of(("always", "sometime"))),
        choices(("always", "sometime")),
    ] = "always"
    """whether it must hold at every instant of that time or at some"""

    @model_validator(mode="after")
    def _whole(self) -> During:
        if (self.min is None and self.max is None) == (self.equals is None):
            raise ValueError("needs min and/or max, or is = true or false")
        if self.end is not None and self.end < self.start:
            raise ValueError("to lies before from")
        return self

    def bounds(self, outputs: Mapping[str, Variable]) -> Bounds:
        """The bounds in SI.

        Raises
        ------
        ValueError : no such output, or bounds that do not fit it.
        """
        if self.output not in outputs:
            raise ValueError(f"no output {shown(self.output)}{nearest(self.output, outputs)}")
        if self.equals is not None:
            return Bounds(min=float(self.equals), max=float(self.equals))
        raw = {"min": self.min, "max": self.max}
        given = {key: value for key, value in raw.items() if value is not None}
        return bounds_from(given, outputs[self.output].unit or "1")

    def judged(self, outputs: Mapping[str, Variable], columns: Columns) -> dict[str, Any]:
        """Whether it holds, with the value that decides and its instant."""
        bounds = self.bounds(outputs)
        time, column = columns["time"], columns[self.output].astype(float)
        end = inf if self.end is None else self.end
        rows = [row for row, t in enumerate(time) if self.start - 1e-9 <= t <= end + 1e-9]
        good = [row for row in rows if bounds.hold(float(column[row]))]
        if self.when == "sometime":
            holds, deciding = bool(good), (good or rows)[:1]
        else:
            kept = set(good)
            holds = bool(rows) and len(good) == len(rows)
            deciding = [row for row in rows if row not in kept][:1] or rows[:1]
        until = "the end" if self.end is None else f"{self.end:g} s"
        return {
            "measure": f"{self.output} {self.when} from {self.start:g} s to {until}",
            **bounds.model_dump(),
            "value": float(column[deciding[0]]) if deciding else None,
            "time": float(time[deciding[0]]) if deciding else None,
            "holds": holds,
        }


class Reference(Strict):
    """Columns of a file to which the run must come close."""

    file: str
    """CSV, Parquet, HDF5 or MAT with a column time (s) and outputs by name, in SI"""
    tolerance: Factor = _TOLERANCE
    """largest difference over the column's peak"""
    columns: Annotated[tuple[str, ...], BeforeValidator(tuple_from)] | None = None
    """names of the columns compared; all if left out"""
    common: bool = False
    """whether only the rows, time and columns that file and run have in common are compared; if not, \
those that only one of them has count as a difference"""

    def judged(self, file: str, reference: Columns, columns: Columns) -> dict[str, Any]:
        """Whether the worst column is close enough, and file and run have the same rows and columns.

        Parameters
        ----------
        file : name of the file
        reference : its columns
        columns : those of the run that are shown, and those that the file has as well
        """
        told = {"min": None, "max": self.tolerance, "value": None, "time": None, "holds": False}
        try:
            found = compared(columns, reference, self.columns)
        except ValueError as error:
            return {"measure": f"difference from {file}", **told, "reason": str(error)}
        worst = found.differences[0]
        unshared = [] if self.common else found.unshared("the run", file)
        return {
            "measure": f"difference of {worst.name} from {file}",
            **told,
            "value": worst.relative,
            "time": worst.time,
            "holds": worst.relative <= self.tolerance and not unshared,
            "reason": "; ".join([*unshared, _COMMON] if unshared else []),
            "compared": found.as_data(),
        }


def bounds_from(raw: object, unit: str) -> Bounds:
    """`{min, max}` in numbers or texts with units; for what is counted also a whole number."""
    if unit == COUNT and isinstance(raw, int) and not isinstance(raw, bool):
        raw = {"min": raw, "max": raw}
    if not isinstance(raw, dict) or not raw:
        raise ValueError(
            "must be a whole number, or min and/or max"
            if unit == COUNT
            else f"must be min and/or max{unit_words(unit)}"
        )
    bounds = {}
    for key, value in raw.items():
        number = to_si(value, unit if unit != COUNT else "1") if isinstance(value, str) else value
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError(f"{key} must be a number{unit_words(unit)}")
        try:
            bounds[key] = float(number)
        except OverflowError:
            bounds[key] = inf
        if not isfinite(bounds[key]):
            raise ValueError(f"{key} must be finite")
    if bounds.get("min", -inf) > bounds.get("max", inf):
        raise ValueError("min is above max")
    return Bounds.model_validate(bounds)


def judged_measures(
    expected: Mapping[str, Bounds], readings: Mapping[str, Reading]
) -> Iterator[dict[str, Any]]:
    """Whether the measures keep to their bounds."""
    for name, bounds in expected.items():
        yield {
            "measure": name,
            **bounds.model_dump(),
            "value": readings[name].value,
            "time": readings[name].time,
            "holds": bounds.hold(readings[name].value),
        }
