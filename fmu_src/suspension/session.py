"""One model being stepped: parameters in, communication steps, named outputs out.

This is what an FMU does, without FMI. With a road of its own the integrator steps as it likes, ahead
of the communication points, and outputs are read off its interpolant; with signals from outside it
stops on every communication point, because nothing is known beyond it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import astuple
from functools import cached_property
from math import inf, isfinite, nan
from operator import mul

from .engine import FAILURES, KINDS, Integrator
from .models import System, build
from .roads import Segment, Signal
from .variables import ParameterError, Value, checked_parameters, refuse_unknown, variables

_AT_REST = 1e-12  # s by which a communication point may lie before the present, from rounding


class SimulationError(RuntimeError):
    """A step that could not be made; the message says when and why."""


class Session:
    """A model between its start and the present time.

    Parameters
    ----------
    model : `QuarterCar`
    parameters : public parameters by name, in SI or as texts with units; the others at their defaults
    start_time : s
    tolerance : the host's tolerance; counts where `solver.tolerance` is left at its default

    Raises
    ------
    ParameterError : unknown model or parameter, wrong type, unit or range, unreadable table.
    """

    def __init__(
        self,
        model: str,
        parameters: Mapping[str, object],
        start_time: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self.model = model
        self.time = self._start = start_time
        self.ok = True
        self.messages: list[tuple[str, str]] = []
        declared = variables(model)
        self.parameters = checked_parameters(model, parameters)
        self._inputs = {v.name: 0.0 for v in declared if v.causality == "input"}
        self._outputs = {v.name: v.start for v in declared if v.causality == "output"}
        self._system = build(model, self.parameters)
        default = next(v.start for v in declared if v.name == "solver.tolerance")
        wanted = self.parameters["solver.tolerance"]
        if tolerance is not None and tolerance > 0.0 and wanted == default:
            wanted = tolerance
        self._integrator = Integrator(
            self._system,
            str(self.parameters["solver.method"]),
            float(self.parameters["solver.step"]),
            float(wanted),
            start_time,
        )
        self._sampled = self.parameters["road.shape"] == "input"
        self._changed: set[str] = set()
        self._velocity_given = False
        self._sample_before = (start_time, 0.0)  # instant and road_elevation
        self._behind = self._integrator.snapshot()
        self._contacts: list[tuple[float, bool]] = []
        self._airborne = False
        self._last = {"last_lift_off": -1.0, "last_touchdown": -1.0}
        self._lift_offs = 0
        self._read = _reader(self._system, self)
        self._signals = dict(self._system.signals)
        self._sample()

    # -- inputs and stepping -------------------------------------------------------------------------

    def set_input(self, name: str, value: float) -> None:
        """Give an input its value from the present time on.

        Raises
        ------
        ParameterError : no such input, or a value that is not finite.
        """
        refuse_unknown([name], self._inputs, f"{self.model} has no input")
        if not isfinite(value):
            raise ParameterError(f"input {name} = {value}: must be finite")
        if value != self._inputs[name]:
            self._inputs[name] = value
            self._changed.add(name)

    def advance(self, until: float) -> None:
        """Go on to `until`, s.

        Raises
        ------
        SimulationError : the motion diverged, or a step could not be made; `ok` is false from then on.
        """
        if not self.ok:
            raise SimulationError(f"the run failed before, at {self.time:.9g} s")
        if not isfinite(until) or until < self.time - _AT_REST:
            raise SimulationError(f"cannot step from {self.time:.9g} s back to {until:.9g} s")
        self._take_inputs()
        if self._integrator.time < until:
            if not self._sampled:
                self._behind = self._integrator.snapshot()
            self._step(until)
        self.time = until
        self._sample()

    def _step(self, until: float) -> None:
        status = self._integrator.advance(until, self._sampled)
        self._note_switches()
        if status != 0:
            self.ok = False
            self.time = self._integrator.time
            reason = (
                f"{FAILURES[status]} at {self.time:.6g} s, in step {self._integrator.step_count}"
            )
            self.messages.append(("error", reason))
            raise SimulationError(reason)

    def _take_inputs(self) -> None:
        """Hand the inputs to the integrator, at the present time."""
        changed, self._changed = self._changed, set()
        if not self._sampled:
            if "body_force" not in changed:
                return  # the road is internal: its inputs are not looked at
            self._sampled = True
            if self._integrator.time > self.time:
                self._repeat()
        self._hand_over()

    def _repeat(self) -> None:
        """The integrator had gone ahead as if no input would change: repeat that stretch up to now."""
        said = len(self.messages)
        self._integrator.restore(self._behind)
        self._step(self.time)
        # what happened up to now was reported when it was first passed
        self._contacts = []
        del self.messages[said:]

    def _hand_over(self) -> None:
        """What the inputs say from now on: the road goes on at its velocity, forces stay."""
        held = {"body_force": (self._inputs.get("body_force", 0.0), 0.0, 0.0, 0.0)}
        if self.parameters["road.shape"] == "input":
            held["road"] = (self._inputs["road_elevation"], self._road_velocity(), 0.0, 0.0)
        for number, name in enumerate(self._system.signals):
            if name in held:
                segment = Segment(-inf, self.time, held[name])
                if self._signals[name].segments[0] != segment:
                    self._signals[name] = Signal((segment,))
                    # a road that is elsewhere at the start has always been there: no jump
                    self._integrator.set_signal(number, held[name], self.time > self._start)

    def _road_velocity(self) -> float:
        """The input road_velocity; where it is never given, the slope since the sample before."""
        now, before = (self.time, self._inputs["road_elevation"]), self._sample_before
        self._velocity_given = self._velocity_given or self._inputs["road_velocity"] != 0.0
        self._sample_before = now
        if self._velocity_given or now[0] <= before[0]:
            return self._inputs["road_velocity"]
        return (now[1] - before[1]) / (now[0] - before[0])

    def _note_switches(self) -> None:
        tyre = self._system.element("tyre")
        log, self._integrator.log = self._integrator.log, []
        for time, element, kind, before, after in log:
            name = self._system.elements[element].name
            if element == tyre and KINDS[kind] == "contact":
                self._contacts.append((time, bool(after)))
            elif name.endswith("stop"):
                met = (after < before) == name.endswith("bump_stop")
                self.messages.append(
                    ("event", f"{name} {'met' if met else 'left'} at {time:.9g} s")
                )

    # -- outputs -------------------------------------------------------------------------------------

    def _sample(self) -> None:
        """Read the state at the present time off the integrator's interpolant."""
        while self._contacts and self._contacts[0][0] <= self.time:
            instant, self._airborne = self._contacts.pop(0)
            self._lift_offs += self._airborne
            self._last["last_lift_off" if self._airborne else "last_touchdown"] = instant
            self.messages.append(
                ("event", f"{'lift-off' if self._airborne else 'touchdown'} at {instant:.9g} s")
            )
        self._integrator.sample(self.time)
        self._state = _State(
            self._system,
            self._integrator.sample_q,
            self._integrator.sample_v,
            self._signals,
            self.time,
        )

    def value(self, name: str) -> Value:
        """An output, input or parameter at the present time; not a number once the run has failed.

        Raises
        ------
        ParameterError : no such variable.
        """
        if name in self._read:
            if not self.ok and name != "ok":
                start = self._outputs[name]
                return nan if isinstance(start, float) else type(start)(0)
            return self._read[name]()
        if name in self._inputs:
            return self._inputs[name]
        refuse_unknown([name], (*self._read, *self._inputs, *self.parameters), "no variable")
        return self.parameters[name]

    # -- whole state ---------------------------------------------------------------------------------

    def snapshot(self) -> bytes:
        """The whole state as bytes (JSON); `restore` continues from it to the bit."""
        return json.dumps(
            {
                "model": self.model,
                "parameters": self.parameters,
                "time": self.time,
                "start": self._start,
                "ok": self.ok,
                "inputs": self._inputs,
                "changed": sorted(self._changed),
                "sampled": self._sampled,
                "velocity_given": self._velocity_given,
                "sample_before": self._sample_before,
                "contacts": self._contacts,
                "airborne": self._airborne,
                "last": self._last,
                "lift_offs": self._lift_offs,
                "signals": {
                    name: [astuple(segment) for segment in signal.segments]
                    for name, signal in self._signals.items()
                },
                "integrator": self._integrator.snapshot().hex(),
                "behind": self._behind.hex(),
            }
        ).encode()

    def restore(self, state: bytes) -> None:
        """Return to a snapshot of a session of the same model and parameters.

        Raises
        ------
        ValueError : a snapshot of another model, or made with other parameters.
        """
        kept = json.loads(state)
        if (kept["model"], kept["parameters"]) != (self.model, self.parameters):
            raise ValueError("this state belongs to another model or to other parameters")
        self._integrator.restore(bytes.fromhex(kept["integrator"]))
        self._behind = bytes.fromhex(kept["behind"])
        self.time, self._start, self.ok = kept["time"], kept["start"], kept["ok"]
        self._inputs, self._changed = kept["inputs"], set(kept["changed"])
        self._sampled, self._velocity_given = kept["sampled"], kept["velocity_given"]
        self._sample_before = tuple(kept["sample_before"])
        self._contacts = [(instant, airborne) for instant, airborne in kept["contacts"]]
        self._airborne, self._last = kept["airborne"], kept["last"]
        self._lift_offs = kept["lift_offs"]
        self._signals = {
            name: Signal(tuple(Segment(a, b, tuple(c), d, tuple(e)) for a, b, c, d, e in segments))
            for name, segments in kept["signals"].items()
        }
        self._sample()


class _State:
    """Motion, deflections and forces of a system at one instant; what is not asked for is not made."""

    def __init__(
        self, system: System, q: Sequence[float], v: Sequence[float], signals: Mapping[str, Signal],
        time: float,
    ) -> None:  # fmt: skip
        self._system, self.q, self.v, self._sources, self._time = system, q, v, signals, time

    @cached_property
    def signals(self) -> dict[str, tuple[float, float, float, float]]:
        """Every signal with its derivatives."""
        return {name: signal.derivatives(self._time) for name, signal in self._sources.items()}

    @cached_property
    def deflections(self) -> list[tuple[float, float]]:
        """Deflection and rate of every element."""
        return [
            (
                sum(map(mul, e.direction, self.q)) - (self.signals[e.road][0] if e.road else 0.0),
                sum(map(mul, e.direction, self.v)) - (self.signals[e.road][1] if e.road else 0.0),
            )
            for e in self._system.elements
        ]

    @cached_property
    def forces(self) -> list[float]:
        """Force of every element."""
        return [
            min(e.spring.force(d) + e.damper.force(w), e.limit)
            for e, (d, w) in zip(self._system.elements, self.deflections, strict=True)
        ]

    @cached_property
    def a(self) -> list[float]:
        """Accelerations, from the equation of motion."""
        net = [0.0] * len(self.q)
        for element, force in zip(self._system.elements, self.forces, strict=True):
            for i, b in enumerate(element.direction):
                net[i] -= b * force
        for load in self._system.loads:
            for i, b in enumerate(load.direction):
                net[i] += b * self.signals[load.signal][0]
        return _solved(self._system.mass, net)


def _solved(matrix: tuple[tuple[float, ...], ...], right: list[float]) -> list[float]:
    """Solve a small symmetric positive definite system by elimination."""
    n = len(right)
    rows = [[*row, x] for row, x in zip(matrix, right, strict=True)]
    for k in range(n):
        for i in range(k + 1, n):
            if rows[i][k] != 0.0:
                ratio = rows[i][k] / rows[k][k]
                rows[i] = [x - ratio * y for x, y in zip(rows[i], rows[k], strict=True)]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x


def _reader(system: System, session: Session) -> dict[str, Callable[[], Value]]:
    """For every output of the model how to read it at the present time."""
    integrator = session._integrator
    read: dict[str, Callable[[], Value]] = {}
    for i, name in enumerate(system.coordinates):
        read[f"{name}_displacement"] = lambda i=i: session._state.q[i]  # type: ignore[misc]
        read[f"{name}_velocity"] = lambda i=i: session._state.v[i]  # type: ignore[misc]
        read[f"{name}_acceleration"] = lambda i=i: session._state.a[i]  # type: ignore[misc]
    for name in ("spring", "damper", "bump_stop", "rebound_stop", "tyre"):
        e = system.element(name)
        read[f"{name}_force"] = (
            (lambda: 0.0) if e is None else lambda e=e: session._state.forces[e]  # type: ignore[misc]
        )
    tyre = system.element("tyre")
    if tyre is not None:
        load = float(session.parameters["gravity"]) * sum(map(sum, system.mass))
        read["tyre_deflection"] = lambda: session._state.deflections[tyre][0]
        read["tyre_deflection_rate"] = lambda: session._state.deflections[tyre][1]
        read["contact_force"] = lambda: load - session._state.forces[tyre]
        read["airborne_time"] = lambda: integrator.limited_time_at(tyre, session.time)
    return read | {
        "suspension_deflection": lambda: session._state.q[0] - session._state.q[1],
        "suspension_deflection_rate": lambda: session._state.v[0] - session._state.v[1],
        "ground_elevation": lambda: session._state.signals["road"][0],
        "ground_velocity": lambda: session._state.signals["road"][1],
        "airborne": lambda: session._airborne,
        "lift_off_count": lambda: session._lift_offs,
        "last_lift_off": lambda: session._last["last_lift_off"],
        "last_touchdown": lambda: session._last["last_touchdown"],
        "energy_residual": lambda: integrator.residual_at(session.time),
        "stable_step": integrator.stable_step,
        "step_count": lambda: integrator.step_count,
        "ok": lambda: session.ok,
    }


def simulate(
    model: str,
    parameters: Mapping[str, object],
    times: Iterable[float],
    outputs: Iterable[str],
) -> dict[str, list[Value]]:
    """Run a model over ascending instants, in this process, and collect outputs.

    Parameters
    ----------
    times : s; the first is the start
    outputs : names of variables

    Returns
    -------
    One list per output, and `time`.

    Raises
    ------
    ParameterError, SimulationError : as `Session`.
    """
    times = list(times)
    session = Session(model, parameters, times[0])
    columns: dict[str, list[Value]] = {"time": list(times), **{name: [] for name in outputs}}
    for time in times:
        session.advance(time)
        for name, column in columns.items():
            if name != "time":
                column.append(session.value(name))
    return columns
