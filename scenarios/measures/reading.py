"""The definition of a measure: a name, a unit, the outputs it needs and how it is taken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from phaseplane.suspension.variables import Value

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..columns import Column, Columns


COUNT = "count"  # the unit of counts


class Reading(NamedTuple):
    """A measured value.

    Parameters
    ----------
    value : in the measure's unit; several for a measure that lists times; None if unknown
    time : the time at which it was read, s, if there is one
    """

    value: float | int | tuple[float, ...] | None
    time: float | None = None


@dataclass(frozen=True)
class Run:
    """The data that measures are taken from.

    Parameters
    ----------
    columns : `time` (s) and outputs, each of shape (rows,), in SI; at least one row
    parameters : parameters of the model, in SI
    model : its name, if it is a model of this package
    details : `time` and the same outputs at further ascending times, where extremes may be
    """

    columns: Columns
    parameters: Mapping[str, Value] = field(default_factory=dict)
    model: str = ""
    details: Columns | None = None

    @property
    def time(self) -> Column:
        """The times of the rows, s."""
        return self.columns["time"]

    def closely(self, name: str, since: float = -inf) -> tuple[Column, Column]:
        """Return times and values of an output, including `details`, from the time `since` on."""
        time, values = self.time, self.columns[name]
        if self.details is not None and len(self.details["time"]):
            time, order = self._merged
            values = np.concatenate((self.details[name], values))[order]
        first = int(np.searchsorted(time, since))
        return time[first:], values[first:]

    @cached_property
    def _merged(self) -> tuple[Column, npt.NDArray[np.intp]]:
        """All times, ascending, and their places among those of `details` and of the rows."""
        assert self.details is not None
        time = np.concatenate((self.details["time"], self.time))
        order = np.argsort(time, kind="stable")
        return time[order], order

    def mean(self, what: Callable[..., Column], *names: str, since: float = -inf) -> float:
        """Return the time mean of a function of outputs, by the trapezoidal rule."""
        found = [self.closely(name, since) for name in names]
        time, values = found[0][0], what(*(column for _, column in found))
        span = float(time[-1] - time[0])
        return float(np.trapezoid(values, time)) / span if span > 0.0 else float(values[0])


@dataclass(frozen=True, slots=True)
class Measure:
    """A measure of a run.

    Parameters
    ----------
    name : its name in scenes
    unit : SI, or `COUNT`
    needs : names of the outputs it is taken from
    take : function that takes it
    about : its definition in one sentence
    source : source of the definition, if it is published
    at_end : whether the last row is enough
    at_rows : whether it is taken from the rows of the run as driven
    longest_interval : largest allowed time between points, s
    counted : whether it lists times, of which sweeps and studies take the number
    single : if it has several values for other things than times, measures with one of them
    details : where to refine the first output it needs: at its `peak` (largest magnitude), where it is
        `least`, at both ends of its `range`, where its `mean` is least accurate, or only at `switches`
        and corners (as all of these are); of a `late range` or a `late mean` the second half of the run
        counts; nowhere if empty
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
    counted: bool = False
    single: tuple[str, ...] = ()
    details: str = ""

    @property
    def unit_of_one(self) -> str:
        """The unit of the one number that sweeps and studies take."""
        return COUNT if self.counted else self.unit

    @property
    def over_time(self) -> bool:
        """Whether it is taken from the outputs over time, at all points where they are known."""
        return bool(self.needs) and not (self.at_end or self.at_rows)


def late(time: Column) -> float:
    """Return the start of the second half of the run, s."""
    return 0.5 * float(time[0] + time[-1])
