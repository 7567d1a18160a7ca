"""Outputs of a system: motions, deflections, forces, contact, and the state of the run.

They are named after the system's coordinates, motions and axles, so that no model needs code here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from operator import mul
from typing import Any, NamedTuple, Protocol

from .signals import Signal
from .systems import Axle, Element, Motion, System
from .variables import Value

Read = Callable[[], Value]

SUSPENSION = ("spring", "damper", "bump_stop", "rebound_stop", "friction")


@dataclass(slots=True)
class Contact:
    """The contact of one tyre with the road, and its history up to the present time."""

    airborne: bool = False
    lift_offs: int = 0
    last_lift_off: float = -1.0
    last_touchdown: float = -1.0

    def switch(self, instant: float, airborne: bool) -> None:
        """Record a lift-off or a touchdown."""
        self.airborne = airborne
        if airborne:
            self.lift_offs += 1
            self.last_lift_off = instant
        else:
            self.last_touchdown = instant


class Contacts(NamedTuple):
    """The contacts of all tyres at the present time, in the order of their axles."""

    airborne: Sequence[int]
    lift_offs: Sequence[int]
    last_lift_off: Sequence[float]
    last_touchdown: Sequence[float]


class State:
    """Motion, deflections and forces at the time that the integrator sampled last.

    Everything is computed on request. `q`, `v` and the like are views of the integrator's arrays.

    Parameters
    ----------
    system : the system being stepped
    integrator : its integrator
    """

    def __init__(self, system: System, integrator: Any) -> None:
        self._system, self._integrator = system, integrator
        # builtin views are read several times faster than those of a compiled attribute
        self.q, self.v = memoryview(integrator.sample_q), memoryview(integrator.sample_v)
        self._a, self._f = memoryview(integrator.sample_a), memoryview(integrator.sample_f)
        self._set = memoryview(integrator.sample_set)
        self.at(0.0, system.signals)

    def at(self, time: float, signals: Mapping[str, Signal]) -> None:
        """Move to another time, s, which the integrator has just sampled."""
        self._time, self._sources = time, signals
        self._signals: dict[str, tuple[float, float, float, float]] | None = None
        self._deflections: list[tuple[float, float]] | None = None
        self._known = False  # whether forces, accelerations and sets are those of this time

    @property
    def signals(self) -> dict[str, tuple[float, float, float, float]]:
        """Every signal with its derivatives."""
        if self._signals is None:
            t = self._time
            self._signals = {name: source.derivatives(t) for name, source in self._sources.items()}
        return self._signals

    @property
    def deflections(self) -> list[tuple[float, float]]:
        """Deflection and rate of every element."""
        if self._deflections is None:
            self._deflections = [
                (
                    _along(e.direction, self.q) - (self.signals[e.road][0] if e.road else 0.0),
                    _along(e.direction, self.v) - (self.signals[e.road][1] if e.road else 0.0),
                )
                for e in self._system.elements
            ]
        return self._deflections

    def _find_forces(self) -> None:
        """Compute forces, accelerations and permanent sets from the equation of motion."""
        if not self._known:
            self._integrator.sample_forces(self._time)
            self._known = True

    @property
    def forces(self) -> Sequence[float]:
        """Force of every element."""
        self._find_forces()
        return self._f

    @property
    def a(self) -> Sequence[float]:
        """Accelerations."""
        self._find_forces()
        return self._a

    @property
    def permanent_sets(self) -> Sequence[float]:
        """Deflection at which the force of each yielding element would be zero."""
        self._find_forces()
        return self._set


def _along(direction: Sequence[float], vector: Sequence[float]) -> float:
    """b' x."""
    return sum(map(mul, direction, vector))


def _combination(direction: Sequence[float], vector: Sequence[float]) -> Callable[[], float]:
    """Return a reader of b' x for a vector that changes in place (most have two terms)."""
    terms = [(b, i) for i, b in enumerate(direction) if b != 0.0]
    if len(terms) == 2:
        (b, i), (c, j) = terms
        return lambda: b * vector[i] + c * vector[j]
    return lambda: sum(b * vector[i] for b, i in terms)


class Run(Protocol):
    """The part of a session from which its outputs are read."""

    ok: bool
    state: State
    contacts: Contacts

    @property
    def time(self) -> float:
        """The present time, s."""


def readers(system: System, integrator: Any, run: Run) -> dict[str, Read]:
    """Return the function that reads each output at the present time."""
    read: dict[str, Read] = {
        "energy_residual": lambda: integrator.residual_at(run.time),
        "stable_step": integrator.stable_step,
        "step_count": lambda: integrator.step_count,
        "ok": lambda: run.ok,
    }
    for i, name in enumerate(system.coordinates):
        read |= _of_coordinate(i, f"{name}_" if name else "", run)
    for e, element in enumerate(system.elements):
        read |= _of_element(e, element, integrator, run)
    if not system.axles:
        read["applied_force"] = lambda: sum(run.state.signals[m.signal][0] for m in system.loads)
    for motion in system.motions:
        read |= _of_motion(motion, run)
    tyres = 0
    for axle in system.axles:
        read |= _of_axle(axle, system, run)
        tyre = system.element(axle.tyre)
        if tyre is not None:
            read |= _of_tyre(axle, tyre, tyres, integrator, run)
            tyres += 1
    return read


def _of_coordinate(i: int, name: str, run: Run) -> dict[str, Read]:
    q, v = run.state.q, run.state.v
    return {
        f"{name}displacement": lambda: q[i],
        f"{name}velocity": lambda: v[i],
        f"{name}acceleration": lambda: run.state.a[i],
    }


def _of_element(e: int, element: Element, integrator: Any, run: Run) -> dict[str, Read]:
    """Force of an element; permanent set and yielding of one that can yield."""
    read: dict[str, Read] = {f"{element.name}_force": lambda: run.state.forces[e]}
    if element.yield_force < inf:
        read["permanent_set"] = lambda: run.state.permanent_sets[e]
        read["yielding"] = lambda: integrator.yielding(e)
    return read


def _of_motion(motion: Motion, run: Run) -> dict[str, Read]:
    b = motion.direction
    displacement, velocity, acceleration = motion.names
    return {
        displacement: _combination(b, run.state.q),
        velocity: _combination(b, run.state.v),
        acceleration: lambda: _along(b, run.state.a),
    }


def _of_axle(axle: Axle, system: System, run: Run) -> dict[str, Read]:
    """Deflection and forces of the suspension, and the road."""

    def deflection(order: int) -> Read:
        moved = _combination(axle.suspension, run.state.v if order else run.state.q)
        if axle.tyre:
            return moved
        return lambda: moved() - run.state.signals[axle.road][order]

    def force(name: str) -> Read:
        e = system.element(f"{axle.prefix}{name}")
        return (lambda: 0.0) if e is None else (lambda: run.state.forces[e])

    read: dict[str, Read] = {
        "suspension_deflection": deflection(0),
        "suspension_deflection_rate": deflection(1),
        "ground_elevation": lambda: run.state.signals[axle.road][0],
        "ground_velocity": lambda: run.state.signals[axle.road][1],
        **{f"{name}_force": force(name) for name in SUSPENSION},
    }
    return {f"{axle.prefix}{name}": reader for name, reader in read.items()}


def _of_tyre(axle: Axle, e: int, c: int, integrator: Any, run: Run) -> dict[str, Read]:
    """Deflection and force of tyre c, which is element e, and its contact with the road."""
    of = run.contacts
    read: dict[str, Read] = {
        "tyre_deflection": lambda: run.state.deflections[e][0],
        "tyre_deflection_rate": lambda: run.state.deflections[e][1],
        "tyre_force": lambda: run.state.forces[e],
        "contact_force": lambda: axle.static_load - run.state.forces[e],
        "airborne": lambda: of.airborne[c] != 0,
        "lift_off_count": lambda: of.lift_offs[c],
        "airborne_time": lambda: integrator.limited_time_at(e, run.time),
        "last_lift_off": lambda: of.last_lift_off[c],
        "last_touchdown": lambda: of.last_touchdown[c],
    }
    return {f"{axle.prefix}{name}": reader for name, reader in read.items()}
