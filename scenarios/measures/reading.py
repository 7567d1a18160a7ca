"""What a measure is: a name, a unit, the outputs it needs and how it is taken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Value

if TYPE_CHECKING:
    import numpy.typing as npt

    Column = npt.NDArray[np.float64]
    Columns = Mapping[str, Column]

COUNT = "count"  # in place of a unit


@dataclass(frozen=True, slots=True)
class Reading:
    """A measured value.

    Parameters
    ----------
    value : in the measure's unit; several for a measure that lists instants; None if the run does
        not tell
    time : the instant at which it was read, s, where there is one
    """

    value: float | int | tuple[float, ...] | None
    time: float | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """What measures are taken from.

    Parameters
    ----------
    columns : `time` (s) and outputs, each of shape (rows,), in SI; at least one row
    parameters : of the model, in SI
    model : its name, if it is one of this project
    details : `time` and the same outputs at further instants, ascending, where extremes may hide
    """

    columns: Columns
    parameters: Mapping[str, Value] = field(default_factory=dict)
    model: str = ""
    details: Columns | None = None

    @property
    def time(self) -> Column:
        """The instants of the rows, s."""
        return self.columns["time"]

    def closely(self, name: str, since: float = -inf) -> tuple[Column, Column]:
        """Instants and values of an output, details included, ascending from an instant on."""
        time, values = self.time, self.columns[name]
        if self.details is not None and len(self.details["time"]):
            places = np.searchsorted(time, self.details["time"])
            time = np.insert(time, places, self.details["time"])
            values = np.insert(values, places, self.details[name])
        first = int(np.searchsorted(time, since))
        return time[first:], values[first:]

    def mean(self, what: Callable[..., Column], *names: str, since: float = -inf) -> float:
        """Mean over time of what is calculated from outputs, by the trapezoidal rule."""
        found = [self.closely(name, since) for name in names]
        time, values = found[0][0], what(*(column for _, column in found))
        span = float(time[-1] - time[0])
        return float(np.trapezoid(values, time)) / span if span > 0.0 else float(values[0])


@dataclass(frozen=True, slots=True)
class Measure:
    """One figure of a run.

    Parameters
    ----------
    name : by which a scene asks for it and bounds it
    unit : SI, or `COUNT`
    needs : names of the outputs it is taken from
    take : how
    about : its definition in one sentence
    source : where the definition stands, if it is not our own
    at_end : whether the last row alone tells it
    at_rows : whether it is taken from the rows of the run, as it tells of the run as it was driven
    longest_interval : between instants that it is to be taken from, s
    details : where the first output it needs is to be read more closely: at its `peak` (largest
        magnitude), where it is `least`, at both ends of its `range`, of its `late range` in the second
        half of the run, or at `switches` and corners alone, as for the others, too; empty: nowhere
    """

    name: str
    unit: str
    needs: tuple[str, ...]
    take: Callable[[Run], Reading]
    about: str
    source: str = ""
    at_end: bool = False
    at_rows: bool = False
    longest_interval: float = inf
    details: str = ""

    @property
    def over_time(self) -> bool:
        """Whether it is taken from the course of outputs over time, as closely as that is known."""
        return bool(self.needs) and not (self.at_end or self.at_rows)


def late(time: Column) -> float:
    """Where the second half of the instants begins, s."""
    return 0.5 * float(time[0] + time[-1])
