"""FMI 2.0 mapped onto `suspension.session.Session`: the calls of a host, without mechanics.

In an FMU the names of this module and of `suspension` contain a hash of their content, because all
FMUs of a process share one `sys.modules`. Everything that any FMU needs is imported here: modules are
shared, and the folder of the FMU that brought them may be gone when the next one is instantiated.
"""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from math import nan
from pathlib import Path
from typing import Any, ClassVar

from phaseplane.suspension import trace as _trace  # noqa: F401  (needed when parameters are tuned)
from phaseplane.suspension.engine import why_uncompiled
from phaseplane.suspension.models import inputs
from phaseplane.suspension.roads.extent import remarks
from phaseplane.suspension.session import Session, SimulationError, rounding_at, sealed, unsealed
from phaseplane.suspension.variables import (
    ParameterError,
    Value,
    checked_parameters,
    variables,
)
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

START_VALUES = "start_values.json"  # in the FMU's resources: start values other than the defaults

# From Python 3.12 on the wrapper loses an exception's message and may end the host's process. There
# a bad value is logged at the end of initialisation, and the first step is discarded.
_RAISES = sys.version_info < (3, 12)

_ROUNDING = 1e-6  # of its time, 1 s at least, by which a host may be off: it may count in singles

_SURELY_ROUNDING = 1e-12  # s, at any time

_NOTHING: Mapping[type[Value], Value] = {float: nan, bool: False, int: 0, str: ""}
# status and category of messages; errors are logged where they are caught
_LOGGED = {"event": (Fmi2Status.ok, "logEvents"), "info": (Fmi2Status.warning, "logStatusWarning")}


def _of_type(method: Callable[..., Any], kind: type[Value]) -> Callable[..., Any]:
    """Return a method for variables of one type; one of `functools.partialmethod` takes 1 us more."""

    def of_type(self: VehicleSlave, *given: Any) -> Any:
        return method(self, kind, *given)

    return of_type


class VehicleSlave(Fmi2Slave):
    """A model as a co-simulation slave; a subclass names the model.

    pythonfmu's wrapper turns any exception into fmi2Fatal, after which some hosts crash. Therefore a
    failed step or a forbidden call is logged; the step, or the next one, returns fmi2Discard, `ok`
    turns false and outputs turn NaN. Two things do raise: bad start values in the constructor
    (instantiation fails), and bad parameters or inputs at the end of initialisation, because a host
    would otherwise continue without a model.
    """

    model: ClassVar[str]

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        # For every instance the wrapper executes the script again and then releases a reference to
        # the script's globals that it never took. Without this they are freed while in use.
        _hold(vars(sys.modules[cls.__module__]))

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        declared = variables(self.model)
        self._names = [variable.name for variable in declared]
        self._references = {  # by the type of their variables
            kind: frozenset(k for k, v in enumerate(declared) if type(v.start) is kind)
            for kind in _NOTHING
        }
        self._starts = {variable.name: variable.start for variable in declared}
        # parameters and inputs as set by the host, checked when a session is made from them
        starts = _start_values(self.resources)
        self._parameters = dict(checked_parameters(self.model, starts))
        self._input_names = frozenset(inputs(self.model))
        self._inputs: dict[str, float] = {}  # only those that the host has set
        self._bound: Mapping[str, Callable[[], Any]] = {}
        self._read: Callable[[list[int]], list[Any]]  # by value reference, of what is bound
        self._start_time = 0.0
        self._tolerance: float | None = None
        self._stop_time: float | None = None
        self._refusal = ""  # why the next step cannot be made
        self._initialised = False
        self._session: Session | None = None
        if starts:  # refused here if they are not those of a model
            self._session = self._new_session()

    # -- initialisation ----------------------------------------------------------------------------

    def _new_session(self) -> Session:
        session = Session(
            self.model, self._parameters, self._start_time, self._tolerance, self._stop_time
        )
        for name, value in self._inputs.items():
            session.set_input(name, value)
        session.advance(self._start_time)  # outputs follow the inputs already at the start
        return session

    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        """Store the start time, the stop time and the host's tolerance."""
        if self._is_late("fmi2SetupExperiment"):
            return
        if self.resources in sys.path:
            sys.path.remove(self.resources)  # the wrapper put it there; all is imported by now
        self._start_time, self._tolerance = start_time, tolerance
        self._stop_time = stop_time
        self._session = None

    def exit_initialization_mode(self) -> None:
        """Check parameters and inputs, and make the model.

        Raises
        ------
        ParameterError : a parameter or input that is out of range or unreadable, or an output that
            was set; see `_RAISES`.
        """
        if self._is_late("fmi2ExitInitializationMode"):
            return
        try:
            if self._refusal:
                raise ParameterError(self._refusal)
            self._session = self._new_session()
        except Exception as error:
            self._write(str(error))
            if not _RAISES:
                self._refuse(str(error))
                return
            self.log(str(error), Fmi2Status.error)
            # on an exception the wrapper releases what it holds, and again with the instance
            _hold(self, type(self), self.log_queue)
            raise
        self._initialised = True
        if why_uncompiled:
            slower = f"the integrator runs uncompiled, which is slower: {why_uncompiled}"
            self.log(slower, Fmi2Status.warning)
        if self._stop_time is not None:
            for remark in remarks(self._session.parameters, self._stop_time):
                self.log(remark, Fmi2Status.warning)
        self._report()

    def _is_late(self, call: str) -> bool:
        """Return whether initialisation has ended, and refuse the next step if so."""
        if self._initialised:
            self._refuse(f"{call} cannot be called during a run: reset the FMU first")
        return self._initialised

    # -- stepping ----------------------------------------------------------------------------------

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make one communication step; return False (fmi2Discard) if it fails."""
        session = self._session
        try:
            if self._refusal:
                raise SimulationError(self._refusal)
            if session is None or not self._initialised:
                raise SimulationError("a step needs an initialised model")
            if session.ok:
                _check_start(session.time, current_time, step_size)
            session.advance(current_time + step_size)
        except Exception as error:
            self._report()
            expected = isinstance(error, SimulationError | ParameterError)
            why = str(error) if expected else repr(error)
            self.log(f"the step from {current_time:.9g} s failed: {why}", Fmi2Status.discard)
            if session is not None:
                session.ok = False
            return False
        if session.messages:
            self._report()
        return True

    def terminate(self) -> None:
        """End the run; values can still be read."""
        ended = "the run has been terminated: reset the FMU, or restore a state"
        self._refusal = self._refusal or ended

    def log(self, msg: str, *how: Any) -> None:
        """Hand a text to the host, whose logger takes it as a format."""
        super().log(msg.replace("%", "%%"), *how)

    def _report(self) -> None:
        """Log the session's messages."""
        if self._session is not None:
            for category, text in self._session.messages:
                if category in _LOGGED:
                    status, of_host = _LOGGED[category]
                    self.log(text, status, of_host)
            self._session.messages.clear()

    def _write(self, reason: str) -> None:
        """Write why there is no model to stderr: hosts without logging get no messages, only a status."""
        with suppress(AttributeError, OSError, ValueError):  # there is none, or it is closed
            sys.stderr.write(f"{self.instance_name}: {reason}\n")
            sys.stderr.flush()

    def _refuse(self, reason: str) -> None:
        self.log(reason, Fmi2Status.error)
        self._refusal = self._refusal or reason

    # -- variables ---------------------------------------------------------------------------------

    def _have_type(self, kind: type[Value], vrs: list[int]) -> bool:
        """Return whether these are variables of a type, and refuse the next step if not."""
        if self._references[kind].issuperset(vrs):
            return True
        wrong = next(vr for vr in vrs if vr not in self._references[kind])
        self._refuse(f"value reference {wrong} is not a variable of this type")
        return False

    def _get(self, kind: type[Value], vrs: list[int]) -> list[Any]:
        """Return values by value reference; hosts call this most."""
        if not self._have_type(kind, vrs):
            return [_NOTHING[kind]] * len(vrs)
        session = self._session
        if session is None or not (self._initialised and session.ok):
            return [self._value(self._names[vr]) for vr in vrs]
        if session.readers is not self._bound:  # another session, or one rebuilt for a parameter
            self._bound = session.readers
            self._read = session.many(self._names)
        return self._read(vrs)

    def _set(self, kind: type[Value], vrs: list[int], values: list[Any]) -> None:
        """Set values by value reference."""
        if self._have_type(kind, vrs):
            for vr, value in zip(vrs, values, strict=True):
                self._set_one(self._names[vr], value)

    get_real, set_real = _of_type(_get, float), _of_type(_set, float)
    get_integer, set_integer = _of_type(_get, int), _of_type(_set, int)
    get_boolean, set_boolean = _of_type(_get, bool), _of_type(_set, bool)
    get_string, set_string = _of_type(_get, str), _of_type(_set, str)

    def _value(self, name: str) -> Value:
        if self._initialised and self._session is not None:
            return self._session.value(name)
        if name in self._parameters:
            return self._parameters[name]
        if name in self._input_names:
            return self._inputs.get(name, self._starts[name])
        if self._session is None and not self._refusal:
            with suppress(Exception):  # reported at the end of initialisation
                self._session = self._new_session()
        return self._session.value(name) if self._session else _NOTHING[type(self._starts[name])]

    def _set_one(self, name: str, value: Value) -> None:
        if name not in self._input_names and name not in self._parameters:
            self._refuse(f"{name} = {value!r}: an output cannot be set")
        elif self._initialised and self._session is not None:
            try:
                if name in self._input_names:
                    self._inputs[name] = float(value)
                    self._session.set_input(name, float(value))
                else:
                    self._session.set_parameter(name, value)
            except ValueError as error:
                self._refuse(str(error))
        else:
            self._session = None
            if name in self._input_names:
                self._inputs[name] = float(value)
            else:
                self._parameters[name] = value

    # -- whole state -------------------------------------------------------------------------------

    def _get_fmu_state(self) -> dict[str, Any]:
        session = self._session if self._initialised else None
        return {
            "model": self.__module__,
            "parameters": dict(session.parameters if session else self._parameters),
            "inputs": dict(self._inputs),
            "start": (self._start_time, self._tolerance),
            "refusal": self._refusal,
            "session": session and session.snapshot().decode(),
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if state.get("model") != self.__module__:
            self._refuse("the state to be restored is damaged, or belongs to another FMU")
            return
        before = self._session, self._initialised
        try:
            self._parameters, self._inputs = dict(state["parameters"]), dict(state["inputs"])
            self._start_time, self._tolerance = state["start"]
            self._refusal = state["refusal"]
            self._session = None
            self._initialised = state["session"] is not None
            if self._initialised:
                self._session = self._new_session()
                self._session.restore(state["session"].encode())
                self._session.messages.clear()
        except Exception as error:
            self._session, self._initialised = before
            self._refuse(f"the state cannot be restored: {error!r}")

    _fmu_state_to_bytes = staticmethod(sealed)

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        try:
            return unsealed(state)
        except ValueError:
            return {}  # refused when it is restored


def _check_start(present: float, start: float, size: float) -> None:
    """Refuse a step that does not start at the present: of a host that repeats or leaves out steps."""
    late = abs(start - present)
    if late <= _SURELY_ROUNDING:
        return
    off = min(_ROUNDING * max(1.0, abs(present)), 0.5 * size)
    if not (late <= off or late <= rounding_at(present)):
        raise SimulationError(
            f"the host steps from {start:.12g} s, but the FMU is at {present:.12g} s: step from "
            f"there, or first restore its state at {start:.12g} s"
        )


def _start_values(resources: str | None) -> dict[str, Value]:
    """Return the start values packed into the FMU."""
    path = Path(resources or "", START_VALUES)
    return dict(json.loads(path.read_text("utf-8"))) if resources and path.exists() else {}


def _hold(*objects: object) -> None:
    """Take a permanent reference to objects that the wrapper releases once too often."""
    try:
        from ctypes import py_object, pythonapi  # noqa: PLC0415  (some Pythons come without it)
    except ImportError:
        return
    for held in objects:
        pythonapi.Py_IncRef(py_object(held))


def _give_back_interrupts() -> None:
    """Let Ctrl-C end a host that is not a Python program and does not handle it.

    In such a host the wrapper starts Python, which catches unhandled interrupts to raise them in its main
    thread. That thread belongs to the wrapper and only waits for the end.
    """
    started_by_the_wrapper = not sys.orig_argv
    if started_by_the_wrapper and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        try:
            from ctypes import pythonapi  # noqa: PLC0415  (some Pythons come without it)
        except ImportError:
            return
        pythonapi.PyOS_setsig(signal.SIGINT, None)  # `signal.signal` is for the main thread alone


_give_back_interrupts()
