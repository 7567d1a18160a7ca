"""An FMU stepped from start to end, its outputs read into one table.

Slaves of FMI 2.0 step from one communication point to the next. Slaves of FMI 3.0 may return early, at
events, which are handled before they go on. Models for model exchange are integrated by FMPy.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from ctypes import byref, c_size_t, c_uint32, c_void_p
from dataclasses import dataclass
from functools import partial
from math import ceil, isclose
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    fmi2Boolean,
    fmi2Discard,
    fmi2Integer,
    fmi2LastSuccessfulTime,
    fmi2Real,
    fmi2Terminated,
    fmi2True,
    fmi2Warning,
)
from fmpy.simulation import (
    apply_start_values,
    settable_in_initialization_mode,
    settable_in_instantiated,
)
from numpy.ctypeslib import as_ctypes_type

from ..errors import RunError

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription

Instance = Any  # of FMPy: FMU2Slave, FMU3Slave, FMU2Model or FMU3Model
GoingOn = Callable[[float], bool]
_Call = tuple[Callable[..., int], tuple[Any, ...]]  # FMI's function and its arguments

# FMI's type -> the getter, the C type and the type of a column
_TYPES: Mapping[str, tuple[str, Any, Any]] = {
    "Real": ("fmi2GetReal", fmi2Real, np.float64),
    "Integer": ("fmi2GetInteger", fmi2Integer, np.int32),
    "Boolean": ("fmi2GetBoolean", fmi2Boolean, np.bool_),
}
_TYPES_3: Mapping[str, tuple[str, Any, Any]] = {
    name: (f"fmi3Get{name}", as_ctypes_type(column), column)
    for name, column in (
        ("Float64", np.float64), ("Float32", np.float32), ("Int64", np.int64), ("UInt64", np.uint64),
        ("Int32", np.int32), ("UInt32", np.uint32), ("Int16", np.int16), ("UInt16", np.uint16),
        ("Int8", np.int8), ("UInt8", np.uint8), ("Boolean", np.bool_),
    )
}  # fmt: skip
_MOST_RETURNS = 1000  # early returns at one instant
_TOLERANCE = 1e-6  # of the solver for model exchange, if the FMU names none


@dataclass(frozen=True, slots=True)
class _Outputs:
    """The outputs of one type, read together: FMI's function, its arguments, and types of values.

    Parameters
    ----------
    names : of the outputs
    get : FMI's function
    before, after : its arguments before and after the values, apart from the component
    values : the C type of the values
    column_type : of a column
    """

    names: list[str]
    get: Callable[..., int]
    before: tuple[Any, ...]
    after: tuple[Any, ...]
    values: Any
    column_type: type

    def into(self, values: Any, component: Any) -> _Call:
        """Return the function with all its arguments, for values to be written there."""
        return self.get, (component, *self.before, byref(values), *self.after)


class Rows:
    """The rows read from an instance so far: `time` and outputs. Another thread may read them.

    Parameters
    ----------
    instance : the slave or model
    description : its model description
    outputs : names of the outputs to read
    most : most rows that there can be
    at_end : names of the outputs to read at the end only
    """

    def __init__(
        self,
        instance: Instance,
        description: ModelDescription,
        outputs: Collection[str],
        most: int,
        at_end: Collection[str] = (),
    ) -> None:
        self._outputs = list(_outputs(instance, description, outputs))
        self.names = ["time", *(name for one in self._outputs for name in one.names)]
        self._groups = {"time": np.dtype(np.float64)} | {
            str(k): np.dtype(one.values) for k, one in enumerate(self._outputs)
        }
        layout = np.dtype(list(self._groups.items()), align=True)
        # the FMU writes into this row, which is copied as bytes: several times faster than by types
        row = np.zeros(1, layout)
        self._row, self._time = row.view(np.uint8).data, row["time"]
        component = c_void_p.from_param(instance.component)
        self._calls = [
            one.into(one.values.from_buffer(row[str(k)]), component)
            for k, one in enumerate(self._outputs)
        ]
        self._table = np.empty(most, layout)
        self._bytes = self._table.view(np.uint8).data
        self._count = 0
        self._at_end = [(one, one.values()) for one in _outputs(instance, description, at_end)]
        self._calls_at_end = [one.into(values, component) for one, values in self._at_end]

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, rows: slice) -> Any:
        """Return rows as an array of shape (rows, columns)."""
        return np.column_stack(list(self._fields(rows)))

    def _fields(self, rows: slice) -> Iterator[npt.NDArray[Any]]:
        """Yield the columns of these rows, as the FMU wrote them."""
        there = self._table[: self._count][rows]
        for field in self._groups:
            yield from np.atleast_2d(there[field].T)

    def read(self, time: float) -> None:
        """Read the outputs into the next row."""
        self._time[0] = time
        _make(self._calls)
        at = self._count * len(self._row)
        self._bytes[at : at + len(self._row)] = self._row
        self._count += 1

    def read_at_end(self) -> None:
        """Read the outputs of the end."""
        _make(self._calls_at_end)

    def take(self, row: Mapping[str, Any]) -> None:
        """Let values by name be the next row."""
        there = self._table[self._count]
        there["time"] = row["time"]
        for k, one in enumerate(self._outputs):
            there[str(k)] = [row[name] for name in one.names]
        self._count += 1

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """Return the columns, each of its own type; of outputs of the end the last value."""
        kinds = [np.float64, *(one.column_type for one in self._outputs for _ in one.names)]
        columns = zip(self.names, self._fields(slice(None)), kinds, strict=True)
        last: dict[str, npt.NDArray[Any]] = {
            name: np.array([value], one.column_type)
            for one, values in self._at_end
            for name, value in zip(one.names, values, strict=True)
        }
        return {name: column.astype(kind) for name, column, kind in columns} | last


def _make(calls: Sequence[_Call]) -> None:
    for function, arguments in calls:
        if (status := function(*arguments)) > fmi2Warning:
            raise FMICallException(function=function.__name__, status=status)


def is_fmi3(description: ModelDescription) -> bool:
    """Return whether an FMU is one of FMI 3.0."""
    return description.fmiVersion.startswith("3.")


def _outputs(
    instance: Instance, description: ModelDescription, outputs: Collection[str]
) -> Iterator[_Outputs]:
    """Yield the outputs of each type."""
    newer = is_fmi3(description)
    types, enumeration = (_TYPES_3, "Int64") if newer else (_TYPES, "Integer")
    for kind, (getter, c_type, column_type) in types.items():
        read = [
            v
            for v in description.modelVariables
            if v.name in outputs and kind == (enumeration if v.type == "Enumeration" else v.type)
        ]
        if read:
            count = len(read)
            references = (c_uint32 * count)(*(v.valueReference for v in read))
            names = [v.name for v in read]
            # FMPy's own method asks each time whether calls are logged, at several times the cost, and
            # its function converts every argument; a new one takes them as they are
            get, number = instance.dll[getter], c_size_t(count)
            before, after = (byref(references), number), (number,) if newer else ()
            yield _Outputs(names, get, before, after, c_type * count, column_type)


def initialise(
    slave: Instance,
    description: ModelDescription,
    start_values: Mapping[str, Any],
    stop_time: float,
) -> None:
    """Set up a run from 0 to `stop_time`, s, with these start values, and initialise the slave.

    Raises
    ------
    Exception : if the slave refuses a call.
    """
    newer = is_fmi3(description)
    if not newer:
        slave.setupExperiment(startTime=0.0, stopTime=stop_time)
    left = apply_start_values(slave, description, dict(start_values), settable_in_instantiated)
    if newer:
        slave.enterInitializationMode(startTime=0.0, stopTime=stop_time)
    else:
        slave.enterInitializationMode()
    apply_start_values(slave, description, left, settable_in_initialization_mode)
    slave.exitInitializationMode()
    if newer and description.coSimulation.hasEventMode:
        _handle_events(slave)


def step_through(
    slave: Instance,
    rows: Rows,
    description: ModelDescription,
    duration: float,
    interval: float,
    going_on: GoingOn,
) -> None:
    """Step an initialised slave from 0 to the end, and read a row at the start and after each step.

    Parameters
    ----------
    rows : where the outputs go; those of the end are read unless the slave ends the run itself
    description : of the slave
    duration, interval : of the run, and of a step, s
    going_on : called after each step with the time reached; whether to go on

    Raises
    ------
    FMICallException : if a call fails, in FMI 2.0 with a status other than fmi2Discard.
    RunError : a slave that keeps returning early without progress.
    """
    step = partial(_step_with_events, slave, rows) if is_fmi3(description) else _steps(slave, rows)
    time, count = 0.0, 0
    rows.read(time)
    while not (time > duration or isclose(time, duration)):
        end = (count + 1) * interval
        if end > duration and not isclose(end, duration):
            if not description.coSimulation.canHandleVariableCommunicationStepSize:
                break
            end = duration
        if not step(time, end):
            return
        time, count = end, count + 1
        rows.read(time)
        if not going_on(time):
            break
    rows.read_at_end()


def _steps(slave: Instance, rows: Rows) -> Callable[[float, float], bool]:
    """Return the function that makes one step in FMI 2.0 and returns whether the run continues.

    A slave that ends the run within a step has its last row read.
    """
    # as in `_outputs`, not by FMPy's method
    do_step, start, size = slave.dll["fmi2DoStep"], fmi2Real(), fmi2Real()
    arguments = c_void_p.from_param(slave.component), start, size, fmi2Boolean(fmi2True)

    def step(time: float, end: float) -> bool:
        start.value, size.value = time, end - time
        if (status := do_step(*arguments)) <= fmi2Warning:
            return True
        if status != fmi2Discard:
            raise FMICallException(function="fmi2DoStep", status=status)
        if slave.getBooleanStatus(fmi2Terminated):
            reached = slave.getRealStatus(fmi2LastSuccessfulTime)
            if reached > time:
                rows.read(reached)
        return False

    return step


def _step_with_events(slave: Instance, rows: Rows, time: float, end: float) -> bool:
    """Make one step in FMI 3.0, from event to event; return whether the run continues."""
    before, returns = time, 0
    while True:
        event, over, early, reached = slave.doStep(time, end - time)
        if event and not over:
            slave.enterEventMode()
            over = _handle_events(slave)
        if over:
            if reached > before:
                rows.read(reached)
            return False
        if not early or reached >= end or isclose(reached, end, rel_tol=1e-14):
            return True
        returns = 0 if reached > time else returns + 1
        if returns > _MOST_RETURNS:
            raise RunError(f"the FMU keeps returning early without progress at {time:.9g} s")
        time = reached


def _handle_events(slave: Instance) -> bool:
    """Bring event mode to its end; return whether the slave ends the run."""
    again = True
    while again:
        again, over, *_ = slave.updateDiscreteStates()
        if over:
            return True
    slave.enterStepMode()
    return False


def integrate(
    model: Instance,
    rows: Rows,
    description: ModelDescription,
    duration: float,
    interval: float,
    going_on: GoingOn,
    *,
    unpacked: str,
    start_values: Mapping[str, Any],
) -> None:
    """Integrate a model for model exchange from 0 to the end by FMPy's CVode, and read the rows.

    Parameters
    ----------
    rows, description, duration, interval, going_on : as of `step_through`
    unpacked : the folder of the FMU
    start_values : by name

    Raises
    ------
    Exception : if a call or the solver fails.
    """
    experiment = description.defaultExperiment
    named = experiment.tolerance if experiment is not None else None

    def stepped(time: float, recorder: Any) -> bool:
        if not len(rows):
            names = (name for name, *_ in recorder.cols)
            rows.take(dict(zip(names, recorder.rows[0], strict=True)))
        due = len(rows) * interval
        if not (isclose(time, due) or isclose(time, duration)):
            return True  # an event between two rows
        rows.read(time)
        return going_on(time)

    simulate_fmu(
        unpacked, validate=False, start_time=0.0, stop_time=duration, solver="CVode",
        relative_tolerance=float(named or _TOLERANCE), output_interval=interval,
        record_events=False, fmi_type="ModelExchange", start_values=dict(start_values),
        output=rows.names[1:], step_finished=stepped, model_description=description,
        fmu_instance=model,
    )  # fmt: skip


def most_rows(duration: float, interval: float) -> int:
    """Return the most rows that a run can have."""
    return ceil(duration / interval * (1.0 + 1e-9)) + 2
