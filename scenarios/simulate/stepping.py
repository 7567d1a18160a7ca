"""An FMI 2.0 slave stepped from start to end, its outputs read into one table."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from ctypes import Array
from dataclasses import dataclass
from math import ceil, isclose
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    fmi2Boolean,
    fmi2Discard,
    fmi2Integer,
    fmi2LastSuccessfulTime,
    fmi2Real,
    fmi2Terminated,
    fmi2ValueReference,
)
from fmpy.simulation import (
    apply_start_values,
    settable_in_initialization_mode,
    settable_in_instantiated,
)

if TYPE_CHECKING:
    from fmpy.fmi2 import FMU2Slave
    from fmpy.model_description import ModelDescription

# FMI's type -> the getter, the C type and the type of a column; an enumeration is read as an integer
_TYPES: Mapping[str, tuple[str, Any, type]] = {
    "Real": ("fmi2GetReal", fmi2Real, np.float64),
    "Integer": ("fmi2GetInteger", fmi2Integer, np.int32),
    "Boolean": ("fmi2GetBoolean", fmi2Boolean, np.bool_),
}


@dataclass(frozen=True, slots=True)
class _Outputs:
    """The outputs of one type, read together: FMI's function, value references, and values as read.

    `row` is the memory of `values` as numpy sees it, which copies it in a fraction of the time.
    """

    names: list[str]
    get: Callable[..., int]
    references: Array[Any]
    values: Array[Any]
    row: npt.NDArray[Any]
    column_type: type


class Rows:
    """The rows read from a slave so far: `time` and outputs. Another thread may read them.

    Parameters
    ----------
    slave : the slave
    description : its model description
    outputs : names of the outputs to read
    most : most rows that there can be
    """

    def __init__(
        self,
        slave: FMU2Slave,
        description: ModelDescription,
        outputs: Collection[str],
        most: int,
    ) -> None:
        self._slave = slave
        self._outputs = [
            _outputs(slave, description, outputs, kind)
            for kind in _TYPES
            if any(v.name in outputs and _type_of(v) == kind for v in description.modelVariables)
        ]
        self.names = ["time", *(name for one in self._outputs for name in one.names)]
        self._table = np.empty((most, len(self.names)))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, rows: slice) -> Any:
        """Return rows as an array of shape (rows, columns)."""
        return self._table[: self._count][rows]

    def read(self, time: float) -> None:
        """Read the outputs into the next row."""
        row = self._table[self._count]
        row[0], at = time, 1
        for one in self._outputs:
            one.get(self._slave.component, one.references, len(one.values), one.values)
            row[at : at + len(one.row)] = one.row
            at += len(one.row)
        self._count += 1

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Return the columns, each of its own type."""
        kinds = [np.float64, *(one.column_type for one in self._outputs for _ in one.names)]
        return {
            name: self[:][:, k].astype(kind)
            for k, (name, kind) in enumerate(zip(self.names, kinds, strict=True))
        }


def _type_of(variable: Any) -> str:
    return "Integer" if variable.type == "Enumeration" else str(variable.type)


def _outputs(
    slave: FMU2Slave, description: ModelDescription, outputs: Collection[str], kind: str
) -> _Outputs:
    read = [v for v in description.modelVariables if v.name in outputs and _type_of(v) == kind]
    getter, c_type, column_type = _TYPES[kind]
    values = (c_type * len(read))()
    return _Outputs(
        [v.name for v in read],
        getattr(slave, getter),
        (fmi2ValueReference * len(read))(*(v.valueReference for v in read)),
        values,
        np.frombuffer(values, c_type),
        column_type,
    )


def initialise(
    slave: FMU2Slave,
    description: ModelDescription,
    start_values: Mapping[str, Any],
    stop_time: float,
) -> None:
    """Set up a run from 0 to `stop_time`, s, with these start values, and initialise the slave.

    Raises
    ------
    Exception : if the slave refuses a call.
    """
    slave.setupExperiment(startTime=0.0, stopTime=stop_time)
    left = apply_start_values(slave, description, dict(start_values), settable_in_instantiated)
    slave.enterInitializationMode()
    apply_start_values(slave, description, left, settable_in_initialization_mode)
    slave.exitInitializationMode()


def step_through(
    slave: FMU2Slave,
    rows: Rows,
    *,
    duration: float,
    interval: float,
    last_step_shorter: bool,
    going_on: Callable[[float], bool],
) -> None:
    """Step an initialised slave from 0 to the end, and read a row at the start and after each step.

    Parameters
    ----------
    rows : where the outputs go
    duration, interval : of the run, and of a step, s
    last_step_shorter : whether the last step may be shorter than the others, to end with the run
    going_on : called after each step with the time reached; whether to go on

    Raises
    ------
    FMICallException : if a call fails with a status other than fmi2Discard.
    """
    time, count = 0.0, 0
    rows.read(time)
    while not (time > duration or isclose(time, duration)):
        end = (count + 1) * interval
        if end > duration and not isclose(end, duration):
            if not last_step_shorter:
                return
            end = duration
        try:
            slave.doStep(currentCommunicationPoint=time, communicationStepSize=end - time)
        except FMICallException as refusal:
            if refusal.status != fmi2Discard:
                raise
            _read_last(slave, rows, time)
            return
        time, count = end, count + 1
        rows.read(time)
        if not going_on(time):
            return


def _read_last(slave: FMU2Slave, rows: Rows, time: float) -> None:
    """Read the row of the time up to which a slave that ended the run within a step has got."""
    if slave.getBooleanStatus(fmi2Terminated):
        reached = slave.getRealStatus(fmi2LastSuccessfulTime)
        if reached > time:
            rows.read(reached)


def most_rows(duration: float, interval: float) -> int:
    """Return the most rows that a run can have."""
    return ceil(duration / interval * (1.0 + 1e-9)) + 2
