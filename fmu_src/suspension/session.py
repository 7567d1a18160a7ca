"""A model that is stepped: parameters in, communication steps, named outputs out.

This is the content of an FMU, without the FMI interface. With an internal road the integrator chooses
its steps freely, ahead of the communication points, and outputs are interpolated. With inputs it stops
at every communication point, because the inputs after it are unknown, and extrapolates them within each
step (see `kernel.runs.run`).
"""

from __future__ import annotations

import json
from array import array
from binascii import crc32
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import inf, isfinite, nan
from typing import Any
from weakref import proxy

from .declared import solver_settings
from .driving import driving
from .engine import Integrator, Lines, Run, laws_of
from .equilibrium import start_state
from .events import Event, Events
from .kernel.outcomes import AT_SWITCHES, HALTED
from .models import build, declared_parameters, inputs
from .notices import Notices
from .reading import Energies, Readers, ReadMany, State
from .reasons import why_raised, why_stopped
from .retuning import Retuning
from .signals import Segment, Signal
from .systems import System
from .variable import Checked
from .variables import (
    SOLVER_PARAMETERS,
    ParameterError,
    Value,
    checked_parameters,
    outputs,
    refuse_unknown,
)

_TOLERANCE = next(v for v in SOLVER_PARAMETERS if v.name == "solver.tolerance")


class SimulationError(RuntimeError):
    """A step that failed; the message says when and why."""


class Session:
    """A model between its start and the present time.

    Parameters
    ----------
    model : a key of `models.ALL`, such as `QuarterCar`
    parameters : public parameters by name, in SI or as strings with units; the others at their defaults
    start_time : s
    tolerance : the host's tolerance, 0 or None if it has none; used if `solver.tolerance` is left at its
        default. One outside the range of `solver.tolerance` is ignored, with a message
    stop_time : s, if it is known; a run that would need too many steps up to it, or in the next minute
        before it, fails soon

    Raises
    ------
    ParameterError : unknown model or parameter, wrong type, unit or range, unreadable table; a start time
        that is not finite.
    """

    def __init__(
        self,
        model: str,
        parameters: Mapping[str, object],
        start_time: float = 0.0,
        tolerance: float | None = None,
        stop_time: float | None = None,
    ) -> None:
        if not isfinite(start_time):
            raise ParameterError(f"start time = {start_time:g}: must be finite")
        self.model = model
        self.ok = True
        self.messages: list[tuple[str, str]] = []
        given = checked_parameters(model, parameters)
        self._parameters: Checked | None = given
        self._solver = solver_settings(given)
        self._stop_time = stop_time
        if tolerance and self._solver["tolerance"] == _TOLERANCE.start:
            self._use_tolerance(tolerance)
        self._now: dict[str, Value] = {**given}  # as they are now
        self._tuned: dict[str, Value] = {}  # as they are from the next step on
        self._retuning = Retuning(model)
        self._energies: Energies | None = None  # at the present time, once asked for
        self._inputs = inputs(model)
        system = build(model, self.parameters)
        self._signals = dict(system.signals)
        integrator = self._new_integrator(system, start_time)
        self._notices = Notices(self._solver["step"])
        tyres = system.axles_on_tyres
        sampled, lines, self._idle = driving(system, self._inputs, given)
        of_tyres = [e for axle in tyres if (e := system.element(axle.tyre)) is not None]
        self._run = Run(integrator, start_time, len(self._inputs), lines, of_tyres, sampled)
        # end of the step for which the courses of the inputs were found, until one is set
        self._handed = self._held = -inf
        # the state before the integrator went ahead, to return to; whether it is of that step
        self._behind, self._kept = b"", False
        self._events = Events(tyres, self._run, self.messages)
        self.contacts = self._events.contacts
        self._attach(system, integrator)
        self._start_moving()
        self._sample()

    @property
    def time(self) -> float:
        """The present time, s."""
        return float(self._run.time)

    @property
    def events(self) -> list[Event]:
        """The switches so far; at most the last 100 000 of them."""
        return self._events.all()

    @property
    def parameters(self) -> Checked:
        """All parameters at the present time."""
        if self._parameters is None:
            self._parameters = Checked(self.model, self._now)
        return self._parameters

    @property
    def clock(self) -> Any:
        """What knows the present time as `time`, apart from this session."""
        return self._run

    def _start_moving(self) -> None:
        """Start from equilibrium on the present road, plus the initial values.

        A wheel may start in the air; this does not count as a lift-off.
        """
        integrator = self._integrator
        integrator.sample(self.time)
        try:
            q, v = start_state(self._system, self.parameters, self.time, self._signals)
            if any((*q, *v, *integrator.sample_q, *integrator.sample_v)):
                integrator.set_state(q, v)
        except Exception as error:  # functions of users may raise anything
            raise ParameterError(why_raised(error)) from None
        self._run.contacts.begin(integrator)
        self._run.account.begin(integrator)
        self._energies = None

    def _report(self, category: str, text: str) -> None:
        self.messages.append((category, text))

    def _use_tolerance(self, tolerance: float) -> None:
        """Use the host's tolerance if it is allowed."""
        try:
            self._solver["tolerance"] = _TOLERANCE.checked(tolerance)
        except ParameterError as error:
            self._report("info", f"the host's tolerance of {tolerance:g} is not used: {error}")

    def _new_integrator(self, system: System, time: float) -> Integrator:
        """Return an integrator that starts at a time, s, with the solver's parameters."""
        try:
            integrator = Integrator(system, start=time, **self._solver)
        except ValueError as error:
            raise ParameterError(str(error)) from None
        if self._stop_time is not None:
            integrator.expect_end(self._stop_time)
        return integrator

    def _attach(self, system: System, integrator: Integrator) -> None:
        """Use a system and its integrator from now on."""
        self._system, self._integrator = system, integrator
        self._is_old = False  # whether it has other laws than the integrator
        self._events.attach(system)
        self.state = State(system, integrator)
        # of use while `ok`; they do not hold the session, so that it is freed with its last owner
        self.readers = Readers(outputs(self.model), system, integrator, proxy(self))

    # -- inputs and stepping -------------------------------------------------------------------------

    def set_input(self, name: str, value: float) -> None:
        """Set an input from the present time on.

        A call counts as a sample even if the value is unchanged. See `kernel.runs.run` for the course
        between samples. An input of a road that is not `input` has no effect, which a message says once.

        Raises
        ------
        ParameterError : no such input, or a value that is not finite.
        """
        if name not in self._inputs:  # asked here, as the sentence takes longer than the rest
            refuse_unknown([name], self._inputs, f"{self.model} has no input")
        if not isfinite(value):
            raise ParameterError(f"input {name} = {value}: must be finite")
        if name in self._idle and value != 0.0:
            self._report("info", f"{name} = {value:g} has no effect, {self._idle[name]}")
            self._idle = {}  # said once
        self._run.set_input(self._inputs.index(name), value)
        self._handed = self._held = -inf

    def set_parameter(self, name: str, value: object) -> None:
        """Set a tunable parameter from the present time on.

        The next `advance` rebuilds the system and keeps motion, contacts, road and energy.

        Raises
        ------
        ParameterError : unknown or fixed parameter, or a value that it cannot have.
        """
        if name not in self._now:
            refuse_unknown([name], self._now, f"{self.model} has no parameter")
        variable = declared_parameters(self.model)[name]
        if not variable.tunable:
            raise ParameterError(f"{name} = {value!r}: this parameter cannot change during a run")
        self._tuned[name] = variable.checked(value)

    def advance(self, until: float, *, to_switch: bool = False, held_until: float = -inf) -> None:
        """Step to the time `until`, s, or to the first switch of an element before it.

        Stopping a run does not change its motion unless a value is set there.

        Parameters
        ----------
        until : s
        to_switch : whether to stop at the next switch after the present time
        held_until : when inputs will be set again, s, if later than `until`: how they are extrapolated
            does not depend on where the run stops before

        Raises
        ------
        SimulationError : the motion diverged, or a step failed; `ok` is false from then on.
        ParameterError : parameters set during the run are inconsistent.
        """
        run, now = self._run, self._run.time
        if not (self.ok and now < until < inf):
            refuse_step(self.ok, now, until)
            until = now  # it is no later, but for the rounding or the sign of zero
        held = max(until, held_until)
        goes_on = until == self._handed  # from a switch to the same end, which changes nothing
        if self._tuned:
            self._take_parameters()
        if not goes_on:
            if run.sets_in():
                self._stop_here()
                run.sampled, self._held = True, -inf
            if run.sampled and held != self._held:
                self._hand_over(held)
            self._handed, self._held, self._kept = until, held, False
        if now == run.start < until:
            self._events.report_start()
        switch = self._events.next_after(now) if to_switch else inf
        while switch > until and self._integrator.time < until:
            if not (run.sampled or self._kept):
                self._behind, self._kept = self._integrator.snapshot(), True
            self._step(until, run.sampled, AT_SWITCHES if to_switch else 0)
            if to_switch:
                switch = self._events.next_after(now)
        run.time = min(switch, until)
        self._sample()

    def _step(self, until: float, stop: bool, halts: int = 0) -> None:
        integrator = self._integrator
        integrator.halts = halts
        reason = ""
        try:
            status = integrator.advance(until, stop)
        except Exception as error:  # functions of users may raise anything
            reason = why_raised(error, self._where)
        else:
            if status not in (0, HALTED):
                fixed = self._solver["step"] > 0.0
                # it names the last switches in the log, which is then taken
                reason = why_stopped(status, self._where, integrator, self.system, fixed=fixed)
        if switches := integrator.take_log():
            self._events.note(switches, until if until > self.time else -inf)
        for text in self._notices.new(integrator, self._run):
            self._report("info", text)
        if reason:
            self.ok = False
            self._run.time = integrator.time
            self._report("error", reason)
            raise SimulationError(reason)

    @property
    def _where(self) -> str:
        """How far the integrator has come, for the reason of a failure."""
        return f"at {self._integrator.time:.6g} s, in step {self._integrator.step_count}"

    def _take_parameters(self) -> None:
        """Continue from the present state with the parameters set.

        Laws of elements are replaced in place. Any other change requires a new integrator.
        """
        tuned, self._tuned = self._tuned, {}
        if tuned.items() <= self._now.items():
            return
        laws = self._retuning.laws(self._now, tuned)
        if laws is None:
            self._take(Checked(self.model, {**self._now, **tuned}))
        else:
            self._stop_here()
            self._run.retune(laws)
            self._is_old = True
        self._now.update(tuned)
        self._parameters = None
        self._energies = None
        self._kept = False

    def _take(self, parameters: Checked) -> None:
        """Continue with the system of other parameters."""
        system = self._on_present_road(parameters)
        self._refuse(system)
        self._stop_here()
        if self._fits(system):
            self._run.retune(array("d", laws_of(system)))
            self._system, self._is_old = system, False
            self._retuning.note(_on_level_road(parameters), self._fits)
        else:
            self._replace_integrator(system)
            self._retuning.forget()

    def _refuse(self, system: System) -> None:
        """Refuse a system that the method cannot integrate."""
        try:
            self._integrator.refuse(system, self.time)
        except ValueError as error:
            raise ParameterError(str(error)) from None

    def _fits(self, system: System) -> bool:
        """Return whether a system differs from the present one only in laws that can be replaced."""
        present = replace(system, signals=self._signals)
        self._refuse(present)  # what is noted of a system includes why it is not refused
        return _has_other_laws_alone(system, self._system) and self._integrator.fits(present)

    def _on_present_road(self, parameters: Checked) -> System:
        """Return the system with other parameters and the present signals; no road is made again."""
        system = build(self.model, _on_level_road(parameters))
        if any(self._signals[axle.road].scale for axle in system.axles):
            return replace(system, signals=self._signals, scales=self._system.scales)
        return replace(system, signals=self._signals)

    def _replace_integrator(self, system: System) -> None:
        """Let a new integrator of another system go on from the present state."""
        integrator = self._new_integrator(system, self.time)
        there = [self._system.element(element.name) for element in system.elements]
        self._run.replace(integrator, [-1 if e is None else e for e in there])
        self._attach(system, integrator)

    def _stop_here(self) -> None:
        """Return to the present: repeat the steps up to now if the integrator has gone ahead."""
        if self._integrator.time <= self.time:
            return
        reported = len(self.messages)
        self._integrator.restore(self._behind)
        self._events.forget_after(self._integrator.time)
        self._step(self.time, stop=True)
        # what happened up to now was reported when it was first passed
        self._events.forget_waiting()
        del self.messages[reported:]

    def _hand_over(self, until: float) -> None:
        """Set the integrator's signals from the inputs, for a step that ends at `until`."""
        run = self._run
        if run.hand_over(until):
            self._read_lines()
            if self.time == run.start:
                self._start_moving()
                self._integrator.take_log()  # the initial level of the road switches nothing
        if self.time > run.start and (switches := self._integrator.take_log()):
            self._events.note(switches, -inf)

    def _read_lines(self) -> None:
        """Take the present course of every signal that inputs drive."""
        run, names = self._run, list(self._system.signals)
        for signal, origin, value, slope in run.courses():
            self._signals[names[signal]] = Signal(
                (Segment(-inf, origin, (value, slope, 0.0, 0.0)),)
            )

    @property
    def integrator(self) -> Integrator:
        """The integrator, for quantities that are not outputs."""
        return self._integrator

    @property
    def system(self) -> System:
        """The system of the integrator, with the present parameters."""
        if self._is_old:
            self._system, self._is_old = self._on_present_road(self.parameters), False
        return self._system

    # -- energies ------------------------------------------------------------------------------------

    def energies(self) -> Energies:
        """Return the energies at the present time; see `kernel.runs.run`."""
        if self._energies is None:
            self._run.account.find(self._integrator, self.time)
            self._energies = Energies(*self._run.account.energies())
        return self._energies

    # -- outputs -------------------------------------------------------------------------------------

    def _sample(self) -> None:
        """Interpolate the state at the present time."""
        self._energies = None
        now = self._run.time
        self._events.come_to(now)
        self._integrator.sample(now)
        self.state.at(now, self._signals)

    def value(self, name: str) -> Value:
        """Return an output, input or parameter at the present time; NaN once the run has failed.

        Raises
        ------
        ParameterError : no such variable.
        """
        declared = outputs(self.model)
        if name in declared:
            if not self.ok and name != "ok":
                start = declared[name].start
                return nan if isinstance(start, float) else type(start)(0)
            return self.readers[name]()
        if name in self._inputs:
            return float(self._run.input_now(self._inputs.index(name)))
        refuse_unknown([name], (*declared, *self._inputs, *self._now), "no variable")
        return self._tuned.get(name, self._now[name])

    def many(self, names: Sequence[str]) -> ReadMany:
        """Return the function that reads variables by their indices in `names`, many in one call.

        It is valid while `ok` is true and `readers` is not replaced.
        """
        of: list[Any] = []
        lines: list[Any] = []
        for name in names:
            if line := self.readers.line(name):
                of.append(len(lines))
                lines.append(line)
            else:
                output = name in outputs(self.model)
                of.append(self.readers[name] if output else partial(self.value, name))
        found = Lines(self._run, lines, self.state.find_forces)
        return partial(found.read, of)

    # -- whole state ---------------------------------------------------------------------------------

    def snapshot(self) -> bytes:
        """Return the whole state as bytes; `restore` continues from it to the bit."""
        kept = {
            "model": self.model,
            "parameters": self._now,
            "ok": self.ok,
            "tuned": self._tuned,
            "handed": self._handed,
            "held": self._held,
            "run": self._run.snapshot().hex(),
            "integrator": self._integrator.snapshot().hex(),
            "coming": self._events.coming(self.time),
            "kept": self._kept,
            "behind": self._behind.hex() if self._kept or self._integrator.time > self.time else "",
        }
        return sealed(kept)

    def restore(self, state: bytes) -> None:
        """Return to a snapshot of a session of the same model and parameters.

        Raises
        ------
        ValueError : a snapshot of another model or with other parameters, or one that is damaged.
        """
        kept = unsealed(state)
        if (kept["model"], kept["parameters"]) != (self.model, self._now):
            raise ValueError("this state belongs to another model or to other parameters")
        self._integrator.restore(bytes.fromhex(kept["integrator"]))
        self._behind = bytes.fromhex(kept["behind"])
        self.ok, self._tuned = kept["ok"], kept["tuned"]
        self._handed, self._held, self._kept = kept["handed"], kept["held"], kept["kept"]
        self._run.restore(bytes.fromhex(kept["run"]))
        self._events.resume(self.time, kept["coming"])
        self._read_lines()
        self._sample()


def sealed(state: Mapping[str, Any]) -> bytes:
    """Return a state as its checksum and JSON: numbers in a damaged one may point anywhere."""
    text = json.dumps(state).encode()
    return b"%08x" % crc32(text) + text


def unsealed(state: bytes) -> dict[str, Any]:
    """Return the state that has been `sealed`.

    Raises
    ------
    ValueError : it is damaged.
    """
    text = state[8:]
    if state[:8] != b"%08x" % crc32(text):
        raise ValueError("this state is damaged")
    return dict(json.loads(text))


def rounding_at(time: float) -> float:
    """Return by how much a point may precede a time, s, from rounding: some units in the last place."""
    return max(1e-12, 1e-15 * abs(time))


def refuse_step(ok: bool, now: float, until: float) -> None:
    """Refuse a step after a failure, or to a time that is not finite or before the present.

    Raises
    ------
    SimulationError : says why.
    """
    if not ok:
        raise SimulationError(f"the run has already failed, at {now:.9g} s")
    if not (now <= until < inf or now - rounding_at(now) <= until < now):
        raise SimulationError(
            f"cannot step from {now:.9g} s to {until:.9g} s: the end of a step must be finite and "
            "not before its start"
        )


def _on_level_road(parameters: Checked) -> Checked:
    """Return the parameters with no road to be made, if there is one."""
    flat = {"road.shape": "flat"} if "road.shape" in parameters else {}
    return Checked(parameters.model, {**parameters, **flat})


def _has_other_laws_alone(system: System, other: System) -> bool:
    """Return whether masses, loads and what outputs are read from are the same in two systems."""
    return (
        system.with_internal().mass == other.with_internal().mass
        and system.loads == other.loads
        and system.axles == other.axles
        and system.motions == other.motions
    )


def simulate(
    model: str,
    parameters: Mapping[str, object],
    times: Iterable[float],
    outputs: Iterable[str],
) -> dict[str, list[Value]]:
    """Run a model over ascending times, in this process, and collect outputs.

    Parameters
    ----------
    times : s; the first is the start
    outputs : names of variables

    Returns
    -------
    One list per output, and `time`.

    Raises
    ------
    ValueError : `times` is empty.
    ParameterError, SimulationError : as `Session`.
    """
    times = list(times)
    if not times:
        raise ValueError("there is nothing to simulate: give at least one time")
    session = Session(model, parameters, times[0], stop_time=times[-1])
    columns: dict[str, list[Value]] = {name: [] for name in outputs}
    for time in times:
        session.advance(time)
        for name, column in columns.items():
            column.append(session.value(name))
    return {"time": [*times], **columns}
