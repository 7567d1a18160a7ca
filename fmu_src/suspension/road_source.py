"""A road as a source of signals for external vehicles: the content of the FMU `Road`."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import nan

from .models.road import signals
from .reading import ReadMany
from .session import Session, refuse_step
from .variables import SOURCES, ParameterError, Value, checked_parameters, refuse_unknown


class RoadSource:
    """Elevation and velocity of a road under two axles; its only state is the present time.

    An FMU steps and reads it like a `Session`.

    Parameters
    ----------
    model : `Road`
    parameters : public parameters by name, in SI or as strings with units; the others at their defaults
    start_time : s
    tolerance : ignored

    Raises
    ------
    ParameterError : unknown parameter, wrong type, unit or range, unreadable table.
    """

    def __init__(
        self,
        model: str,
        parameters: Mapping[str, object],
        start_time: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self.model, self.time, self.ok = model, start_time, True
        self.messages: list[tuple[str, str]] = []
        self.parameters = checked_parameters(model, parameters)
        front, rear = signals(self.parameters).values()
        self.readers: dict[str, Callable[[], Value]] = {
            "front_elevation": lambda: front.value(self.time),
            "front_velocity": lambda: front.rate(self.time),
            "rear_elevation": lambda: rear.value(self.time),
            "rear_velocity": lambda: rear.rate(self.time),
            "ok": lambda: self.ok,
        }

    def set_input(self, name: str, value: float) -> None:
        """Refuse any input: there are none.

        Raises
        ------
        ParameterError : always.
        """
        raise ParameterError(f"{name} = {value}: {self.model} has no inputs")

    def set_parameter(self, name: str, value: object) -> None:
        """Refuse any change: no parameter is tunable.

        Raises
        ------
        ParameterError : always.
        """
        raise ParameterError(f"{name} = {value!r}: this parameter cannot change during a run")

    def advance(self, until: float) -> None:
        """Step to the time `until`, s.

        Raises
        ------
        SimulationError : `until` is not finite or before the present, or a step has failed.
        """
        refuse_step(self.ok, self.time, until)
        self.time = until

    def value(self, name: str) -> Value:
        """Return an output or parameter at the present time; at a joint of the road, the value after it.

        Raises
        ------
        ParameterError : no such variable.
        """
        if name in self.readers:
            return self.readers[name]() if self.ok or name == "ok" else nan
        refuse_unknown([name], (*self.readers, *self.parameters), "no variable")
        return self.parameters[name]

    def many(self, names: Sequence[str]) -> ReadMany:
        """Return the function that reads variables by their indices in `names`, many in one call."""
        of = [self.readers.get(name) or partial(self.value, name) for name in names]
        return lambda which: [of[k]() for k in which]

    def snapshot(self) -> bytes:
        """Return the whole state as bytes (JSON)."""
        return json.dumps({"time": self.time, "ok": self.ok}).encode()

    def restore(self, state: bytes) -> None:
        """Return to a snapshot of the same road."""
        kept = json.loads(state)
        self.time, self.ok = kept["time"], kept["ok"]


def session_of(
    model: str,
    parameters: Mapping[str, object],
    start_time: float = 0.0,
    tolerance: float | None = None,
) -> Session | RoadSource:
    """Return what the FMU of a model steps and reads; see both for parameters and errors."""
    kind: type[Session | RoadSource] = RoadSource if model in SOURCES else Session
    return kind(model, parameters, start_time, tolerance)
