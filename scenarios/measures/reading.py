"""What a measure is: a name, a unit, the outputs it needs and how it is taken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Value

if TYPE_CHECKING:
    import numpy as np
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
    """

    columns: Columns
    parameters: Mapping[str, Value] = field(default_factory=dict)
    model: str = ""

    @property
    def time(self) -> Column:
        """The instants of the rows, s."""
        return self.columns["time"]

    def mean(self, values: Column) -> float:
        """Mean over time of values given at the rows, joined by straight lines."""
        span = float(self.time[-1] - self.time[0])
        return float(np.trapezoid(values, self.time)) / span if span > 0.0 else float(values[0])


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
    """

    name: str
    unit: str
    needs: tuple[str, ...]
    take: Callable[[Run], Reading]
    about: str
    source: str = ""
    at_end: bool = False
