"""How a session reads its outputs at the present time, each on request."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from .outputs import (
    ACCELERATION,
    DISPLACEMENT,
    FORCE,
    VELOCITY,
    Line,
    OfContact,
    OfFlow,
    OfLedger,
    OfRun,
    Reading,
    reading_of,
)
from .signals import Signal
from .systems import System
from .variable import Value, Variable

if TYPE_CHECKING:
    from .engine import Integrator

Read = Callable[[], Value]
ReadMany = Callable[[Sequence[int]], list[Value]]
"""Returns the values of several variables, each given by its number."""


class Contacts(NamedTuple):
    """The contacts of all tyres at the present time, in the order of their axles."""

    airborne: Sequence[int]
    lift_off_count: Sequence[int]
    last_lift_off: Sequence[float]
    last_touchdown: Sequence[float]


class Energies(NamedTuple):
    """The entries of the energy ledger at one time, J: kinetic + stored + dissipated - supplied = const.

    Parameters
    ----------
    kinetic, stored : energy of all masses, and of all elements
    dissipated : so far, by dampers, friction and plastic flow, and what a damped tyre exchanges at
        lift-off and touchdown
    supplied : so far, by each signal of the system
    """

    kinetic: float
    stored: float
    dissipated: float
    supplied: tuple[float, ...]


class _Signals(dict[str, tuple[float, float, float, float]]):
    """Signals with their derivatives at one time, each found when it is first asked for."""

    def __init__(self, time: float, sources: Mapping[str, Signal]) -> None:
        super().__init__()
        self._time, self._sources = time, sources

    def __missing__(self, name: str) -> tuple[float, float, float, float]:
        found = self[name] = self._sources[name].derivatives(self._time)
        return found


class State:
    """Motion and forces at the time that the integrator sampled last.

    Everything is computed on request. `q`, `v` and the like are views of the integrator's arrays.

    Parameters
    ----------
    system : the system being stepped
    integrator : its integrator
    """

    q: Sequence[float]
    v: Sequence[float]
    _a: Sequence[float]
    _f: Sequence[float]
    _set: Sequence[float]

    def __init__(self, system: System, integrator: Integrator) -> None:
        self._integrator = integrator
        self.q, self.v = integrator.sample_q, integrator.sample_v
        self._a, self._f = integrator.sample_a, integrator.sample_f
        self._set = integrator.sample_set
        self.at(0.0, system.signals)

    def at(self, time: float, signals: Mapping[str, Signal]) -> None:
        """Move to another time, s, which the integrator has just sampled."""
        self._time, self._sources = time, signals
        self._signals: _Signals | None = None
        self._known = False  # whether forces, accelerations and sets are those of this time

    @property
    def signals(self) -> dict[str, tuple[float, float, float, float]]:
        """Every signal with its derivatives."""
        if self._signals is None:
            self._signals = _Signals(self._time, self._sources)
        return self._signals

    def find_forces(self) -> None:
        """Compute forces, accelerations and permanent sets from the equation of motion."""
        if not self._known:
            self._integrator.sample_forces(self._time)
            self._known = True

    @property
    def forces(self) -> Sequence[float]:
        """Force of every element."""
        self.find_forces()
        return self._f

    @property
    def a(self) -> Sequence[float]:
        """Accelerations."""
        self.find_forces()
        return self._a

    @property
    def permanent_sets(self) -> Sequence[float]:
        """Deflection at which the force of each yielding element would be zero."""
        self.find_forces()
        return self._set


class Clock(Protocol):
    """What knows the present time, s."""

    time: float


class Run(Protocol):
    """The part of a session from which its outputs are read."""

    ok: bool
    state: State
    contacts: Contacts

    def energies(self) -> Energies:
        """Return the energies at the present time."""

    @property
    def clock(self) -> Clock:
        """What knows the present time."""


class Readers(dict[str, Read]):
    """The function that reads each output at the present time, made when it is first asked for.

    Parameters
    ----------
    declared : the outputs of the model by name
    system, integrator, run : what they are read from
    """

    def __init__(
        self, declared: Mapping[str, Variable], system: System, integrator: Integrator, run: Run
    ) -> None:
        super().__init__()
        self._declared, self._system = declared, system
        self._integrator, self._run = integrator, run

    def __missing__(self, name: str) -> Read:
        reading = reading_of(self._declared[name], self._system)
        read = self[name] = _reader(reading, self._integrator, self._run)
        return read

    def line(self, name: str) -> tuple[int, tuple[Any, ...], list[tuple[int, float]], float] | None:
        """Return the sum that an output is, for `kernel.runs.lines`, or None for other outputs."""
        reading = reading_of(self._declared[name], self._system) if name in self._declared else None
        if not isinstance(reading, Line):
            return None
        numbers = list(self._system.signals)
        signals = [(numbers.index(signal), c) for signal, c in reading.signals]
        return reading.quantity, reading.terms, signals, reading.offset


def _reader(reading: Reading, integrator: Integrator, run: Run) -> Read:
    match reading:
        case Line():
            return _of_line(reading, run.state)
        case OfContact(_, tyre, "airborne_time"):
            clock = run.clock
            return lambda: integrator.limited_time_at(tyre, clock.time)
        case OfContact(c, _, "airborne"):
            airborne = run.contacts.airborne
            return lambda: airborne[c] != 0
        case OfContact(c, _, what):
            of_tyres = getattr(run.contacts, what)
            return lambda: of_tyres[c]
        case OfFlow(element, "yielding"):
            return lambda: integrator.yielding(element)
        case OfFlow(element):
            state = run.state
            return lambda: state.permanent_sets[element]
        case OfLedger("supplied", signals):
            return lambda: _total([run.energies().supplied[k] for k in signals])
        case OfLedger(what):
            return lambda: getattr(run.energies(), what)
        case OfRun("energy_residual"):
            clock = run.clock
            return lambda: integrator.energy_residual(clock.time)
        case OfRun("stable_step"):
            return integrator.stable_step
        case OfRun("step_count"):
            return lambda: integrator.step_count
    return lambda: run.ok


_SUMMED: Mapping[int, Callable[[State], Sequence[float]]] = {
    DISPLACEMENT: attrgetter("q"), VELOCITY: attrgetter("v"), ACCELERATION: attrgetter("a"),
    FORCE: attrgetter("forces"),
}  # fmt: skip


def _of_line(line: Line, state: State) -> Read:
    """Return the reader of sum b x + sum c u + offset."""
    x = _SUMMED[line.quantity]
    order = VELOCITY if line.quantity == VELOCITY else DISPLACEMENT

    def read() -> float:
        value = _sum(line.terms, x(state)) if line.terms else 0.0
        for name, factor in line.signals:
            value += factor * state.signals[name][order]
        return value + line.offset if line.offset else value

    return read


def _total(values: Sequence[float]) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def _sum(terms: Sequence[tuple[int, float]], x: Sequence[float]) -> float:
    (i, b), *more = terms
    total = b * x[i]  # a sum of negative zeros is one
    for i, b in more:
        total += b * x[i]
    return total
