"""The integrator's interface: set states and signals, run, read results, save and restore."""

from __future__ import annotations

from collections.abc import Callable
from math import fabs, sqrt

import cython

from .arrays import Memory
from .energy.ledger import unknown_energy
from .language import (
    Doubles,
    Integers,
    Numbers,
    PyErr_CheckSignals,
    Size,
    Switch,
    of_python,
    open_to_python,
    uses_python,
)
from .layout import BRANCHES, CONTACT, SPRING, UNBOUNDED
from .network.elements import ELASTIC
from .outcomes import DIVERGED, INTERRUPTED, PAUSED, TOO_MANY
from .stepping.time_loop import TimeLoop


class Integrator(TimeLoop):
    """Steps one system and owns its whole state; for one thread at a time.

    The methods, where omega_max^2 is the largest eigenvalue of M^-1 K and K the present tangent:

    - `extrapolated`: the incremental step (H83 eqs. 15.9 to 15.18) in 1, 2, 3 and 5 parts,
      extrapolated; order 8 (or 2, 4, 6), omega_max h < 3.2 (2.2 at orders 4 and 6), any damping.
      The default; the tolerance sets step and order.
    - `equilibrium`: one incremental step with Newton to the equilibrium at its end; order 2,
      omega_max h < 2 sqrt 3. The most accurate method of order 2 for fixed steps.
    - `mean`: tangents averaged over the step (15.7), iterated; limits as `equilibrium`. To follow H83.
    - `tangent`: tangents at the start of the step, as in H83's hand calculation; order 2, the same
      limit. To follow a hand calculation, with `landing` off.
    - `wilson`: (15.12), (15.13) up to theta h, equilibrium there, and 1/theta of the change of
      acceleration (Bathe and Wilson 1976); order 2, stable at any step for linear systems only. It
      damps fast modes and lengthens periods; a fast mode that starts out of equilibrium overshoots
      by about (omega h)^2 in its first steps. For stiff linear systems with large fixed steps.
    - `exact`: the matrix exponential, with all cubics and sinusoids of roads and loads; accurate to
      rounding at any step, and to the tolerance between steps. Only for systems whose elements are
      linear in each branch; others are refused. For reference solutions, and for extreme stiffness
      or damping.

    Parameters
    ----------
    system : `models.System`; read once, not stored
    method : one of these
    step : fixed macro step, s; 0 lets the tolerance choose
    tolerance : largest error of displacements, relative to the largest motion so far from the start
        of the run; of velocities twice that, relative to the largest velocity so far
    start : start time, s
    order : of `extrapolated`; 0 lets the tolerance choose
    landing : whether steps end on switches; otherwise, as in a hand calculation, an element changes
        branch at the end of the step in which it passed its corner
    theta : of `wilson`, at least 1.37
    beyond_stable : what to do with an unstable fixed step: `substep` divides it into stable equal
        parts, `refuse` ends the run, `allow` takes it as it is
    energy : whether to keep the energy ledger; steps cost less without it

    Raises
    ------
    ValueError : if the method is unknown or the mass matrix is not positive definite.
    """

    going_on: Callable[[float], bool] | None

    @of_python
    def _make_room(self) -> None:
        """Allocate the arrays for changes of signals and parameters, and find the size of the state."""
        # called with the present time at each pause of a long run; returns whether to continue
        self.going_on = None
        self.state_size: Size = len(self.state.content())

    @of_python
    def expect_end(self, stop_time: float) -> None:
        """Measure the pace across calls, up to the end of the run, s."""
        self.pace.stop_time = stop_time

    @of_python
    def set_state(self, displacements: Numbers, velocities: Numbers) -> None:
        """Start from given displacements (m) and velocities (m/s), at the present time.

        Raises
        ------
        ValueError : if there is not one value per coordinate.
        """
        n = self.net.series.outer
        if len(displacements) != n or len(velocities) != n:
            raise ValueError(f"{n} displacements and {n} velocities are required")
        memory = Memory()
        self._enter_state(memory.doubles([*displacements, *velocities]), 0)
        self.raise_failure(DIVERGED)

    def take_over(self, earlier: Integrator, counterpart: Integers) -> None:
        """Continue from the state of the integrator of a system with the same coordinates and signals.

        For a parameter that changes during a run. The resulting change of stored energy is not work,
        so the residual continues from its value; the work of roads and loads starts from zero.

        Parameters
        ----------
        earlier : the previous integrator
        counterpart : for each element of this integrator the number of the same element in the earlier
            one, or -1
        """
        residual = earlier.energy_residual(UNBOUNDED)
        # springs in series are relaxed if there were others before
        same = self.net.n if earlier.net.n == self.net.n else self.net.series.outer
        self.net.signals.set_datum(earlier.state.datum)
        for i in range(same):
            self.motion.q[i], self.motion.v[i] = earlier.motion.q[i], earlier.motion.v[i]
            self.motion.origin[i] = earlier.motion.origin[i]
        for e in range(self.net.elements.count):
            if counterpart[e] >= 0:
                self.ledger.work[e] = earlier.ledger.work[counterpart[e]]
                self.limited.time[e] = earlier.limited.time[counterpart[e]]
        self.state.take_over(earlier.state)
        self._go_on(residual)

    def take_laws(self, x: Doubles, at: int) -> None:
        """Continue with other laws of the elements, from x[at:].

        The state is then that after `take_over` by a new integrator, but only the laws are read again.
        """
        residual = self.energy_residual(UNBOUNDED)
        self.net.branches.enter_elements(x, at)
        self._go_on(residual)

    def _go_on(self, residual: float) -> None:
        """Begin at the present time with the present motion, works and counts, and the residual given."""
        supplied = self.state.supplied + fabs(self.state.initial_energy)
        steps, exchange = self.state.step_count, self.state.exchange
        self._restart(self.state.time, self.state.scale)
        self.net.laws.forget_failures()
        self._begin()
        self.state.step_count, self.state.exchange = steps, exchange
        self.state.supplied = supplied
        self.find_energies(UNBOUNDED)
        if self.energy:
            self.ledger.carry_on(residual)

    @of_python
    def set_signal(self, signal: int, coefficients: Numbers, jumps: bool = True) -> None:
        """Replace a one-segment signal from now on by c0 + c1 s + c2 s^2 + c3 s^3, s = t - now.

        A jump of the value acts on the masses through the dampers as an impulse, so that a sampled
        road transfers the momentum of the continuous one.

        Parameters
        ----------
        signal : number of the signal in the order of the system
        coefficients : four numbers
        jumps : whether to treat a change of the value as such a jump

        Raises
        ------
        ValueError : a signal of several segments.
        """
        if self.net.signals.signal_count[signal] != 1:
            raise ValueError(
                f"signal {signal} has {self.net.signals.signal_count[signal]} segments; one of a single "
                "segment can be replaced"
            )
        interval = self.state.time - self.net.signals.set_at(signal)
        memory = Memory()
        self.replace_signal(signal, memory.doubles(coefficients), interval, jumps)

    def replace_signal(
        self, signal: int, coefficients: Doubles, interval: float, jumps: bool
    ) -> None:
        """Replace a signal as `set_signal` does; the coefficients are an array.

        `interval` is the time since the last sample, s, in which the signal has moved to its new value.
        """
        before = self.transitions.energy()
        before -= self.state.exchange
        self.transitions.jumps.remember_rates()
        self.transitions.remember()
        jump = self.net.signals.replace_signal(signal, self.state.time, coefficients)
        if self.net.signals.is_road[signal]:  # a load moves no element, not even one on a corner
            if jumps and jump != 0.0:
                # a damper at rest is at its corner: the road's new velocity decides on which side it acts
                self.net.branches.locate_branches(self.state.time, self.motion.q, self.motion.v)
                self.stepper.refresh(self.state.time)
                self.transitions.jumps.impulse(signal, jump, interval, self.motion.v)
            self.net.branches.locate_branches(self.state.time, self.motion.q, self.motion.v)
        if jumps:  # at the start the road has always been there: no contact has begun or ended
            self.transitions.book_contacts()
        self.transitions.note()
        if not jumps:  # an element at rest can slip only the way that all loads together push it
            self.net.branches.follow_slips(self.state.time, self.motion.q, self.motion.v)
        self._enter_branches()
        if not jumps:
            self._break_loose()
        if jump != 0.0:
            change = self.transitions.energy()
            change = change - self.state.exchange - before
            if jumps:
                self.ledger.bring_in(signal, change + self._lost(signal, jump, interval))
            else:
                self.state.initial_energy += change

    def _lost(self, signal: int, jump: float, interval: float) -> float:
        """Book the energy that dampers dissipate as a road jumps between samples, and return it, J."""
        total = 0.0
        for e in range(self.net.elements.count):
            r = self.net.elements.row_of[e]
            if self.net.elements.row_signal[r] == signal:
                w = 0.5 * (self.transitions.jumps.rate_before[r] + self.net.elements.row_v[r])
                lost = self.transitions.jumps.lost(e, jump, interval, w)
                self.ledger.lose(e, lost)
                total += lost
        return total

    # -- stepping ----------------------------------------------------------------------------------

    @open_to_python
    @uses_python
    def advance(self, until: float, stop: bool = False) -> int:
        """Step until `until` is reached or passed.

        Parameters
        ----------
        until : time, s
        stop : whether to end a step exactly on `until`, as sampled signals require; otherwise the steps
            do not depend on `until`, and results are read from the interpolant of the last step

        Returns
        -------
        0, or the key in `outcomes.FAILURES` of the reason why the run ended early.

        Raises
        ------
        ValueError : if `until` is not a number.
        """
        if not fabs(until) <= UNBOUNDED:
            raise ValueError(f"cannot step to {until} s: the time must be finite")
        until = float(until)  # uncompiled it may be an int, as would then be the times of switches
        if self.pace.stop_time < until:
            self.pace.look_at_pace()
        while True:
            with cython.nogil:
                status = self.step_until(until, stop)
            if status != PAUSED:
                self.raise_failure(status)
                return status
            status = self.reason_to_end(until)
            if status != 0:
                return status

    @of_python
    def raise_failure(self, status: int) -> None:
        """Raise the exception that a function of an element has raised, if it has ended the run."""
        failure = self.take_failure()
        if failure is not None and status != 0:
            raise failure

    @of_python
    def take_failure(self) -> BaseException | None:
        """Return the exception that a function has raised in the present run, if any, and forget it.

        An interrupt is always raised: no shorter step makes it undone.
        """
        laws = self.net.laws
        failure, laws.failure = laws.failure, None
        raised, laws.raised = laws.raised, False
        if failure is None or isinstance(failure, Exception):
            return failure if raised else None
        raise failure

    @uses_python
    def reason_to_end(self, until: float) -> int:
        """Between parts of a long run, move switches to the log and let an interrupt end the run.

        Return 0, or the key in `outcomes.FAILURES` of a reason to end it: `going_on` returns false, or
        too many steps are still to come at the present pace.
        """
        self.noted.all()
        self.pace.since_pause = 0
        if cython.compiled:
            PyErr_CheckSignals()
        if self.net.laws.failure is not None and not isinstance(self.net.laws.failure, Exception):
            return INTERRUPTED
        if self.going_on is not None and not self.going_on(self.state.time):
            return INTERRUPTED
        return 0 if self.pace.keeps_pace(until) else TOO_MANY

    @property
    def log(self) -> list[Switch]:
        """The switches so far: (time, element, kind, branch before, branch after)."""
        return self.noted.all()

    @of_python
    def take_log(self) -> list[Switch]:
        """Return the switches since the last call, and clear them."""
        taken = self.noted.all()
        self.noted.clear()
        return taken

    # -- reading results ---------------------------------------------------------------------------

    @open_to_python
    def sample(self, t: float) -> None:
        """Find displacements, velocities and accelerations at time t within the last step.

        They are written to `sample_q`, `sample_v`, `sample_a`, from the cubic of the method (15.11), or
        for `extrapolated` the septic through q and its three derivatives at both ends.
        """
        self.dense.read(t)
        self.reading.take(self.dense)

    @open_to_python
    def sample_forces(self, t: float) -> None:
        """Find accelerations and element forces at the last sampled time, by the equation of motion.

        They are written to `sample_a` and `sample_f`, for the branches of the last step; the force of
        dry friction that sticks is the one needed to hold it. `sample_set` gets the permanent sets.
        Each call needs a `sample` before it, as it uses up the accelerations of that.
        """
        self.show_last_branches()
        self.reading.find_forces(t, self.dense.end - self.dense.start)
        self.show_present_branches()

    @property
    def sample_q(self) -> memoryview[float]:
        """Displacements at the last sampled time, m."""
        return self.net.memory.seen(self.reading.q, self.net.series.outer)

    @property
    def sample_v(self) -> memoryview[float]:
        """Velocities at the last sampled time, m/s."""
        return self.net.memory.seen(self.reading.v, self.net.series.outer)

    @property
    def sample_a(self) -> memoryview[float]:
        """Accelerations at the last sampled time, m/s^2."""
        return self.net.memory.seen(self.reading.a, self.net.series.outer)

    @property
    def sample_f(self) -> memoryview[float]:
        """The force of each element at the last sampled time, N; see `sample_forces`."""
        return self.net.memory.seen(self.reading.f, self.net.elements.count)

    @property
    def sample_set(self) -> memoryview[float]:
        """The permanent set of each element that yields at the last sampled time, m."""
        return self.net.memory.seen(self.reading.set, self.net.elements.count)

    @open_to_python
    def energy_residual(self, t: float = UNBOUNDED) -> float:
        """Return the residual of the energy balance at t in the last step, or at its end, J.

        It is NaN without the ledger.
        """
        if not self.energy:
            return unknown_energy()
        self.find_energies(t)
        return self.ledger.residual()

    @of_python
    def energies(self, t: float = UNBOUNDED) -> tuple[float, list[float], list[float], list[float]]:
        """Return the energies stored at t in the last step, or at its end, and the works until then, J.

        Returns
        -------
        The kinetic energy, the energy stored in each element, the energy dissipated by each element, and
        the work done by each signal as a road or a load.
        """
        self.find_energies(t)
        ledger, elements = self.ledger, self.net.elements.count
        works = [ledger.until[k] for k in range(ledger.works)]
        kept = [ledger.kept[e] for e in range(elements)]
        return ledger.kinetic, kept, works[:elements], works[elements:]

    def find_energies(self, t: float) -> None:
        """Find the entries of the ledger at a time t within the last step, or at its end, in `ledger`."""
        if t >= self.dense.end:
            self.ledger.find_all()
            self.net.signals.all_signals(self.state.time)
            self.ledger.take_stock(self.motion.q, self.motion.v)
            return
        self.show_last_branches()
        self.ledger.find_until(t)
        self.dense.read(t)
        self.net.signals.all_signals(t)
        self.ledger.take_stock(self.dense.q, self.dense.v)
        self.show_present_branches()

    def show_last_branches(self) -> None:
        """Exchange the present branches for those of the last step."""
        if self.state.in_step or self.dense.end <= self.dense.start:
            self.net.branches.keep_branches()
        self.net.branches.exchange_branches()

    def show_present_branches(self) -> None:
        """Exchange those of the last step for the present branches again."""
        self.net.branches.exchange_branches()

    @open_to_python
    def limited_time_at(self, e: int, t: float) -> float:
        """Return how long element e has been at its limit (a tyre off the road) up to t, s."""
        late = self.dense.end - t if self._branch_of_step(e, CONTACT) else 0.0
        return self.limited.time[e] - late

    @open_to_python
    def at_limit(self, e: int) -> bool:
        """Return whether element e is now at its limit (a tyre off the road)."""
        return self.net.elements.branch[BRANCHES * e + CONTACT] != 0

    @open_to_python
    def yielding(self, e: int) -> bool:
        """Return whether element e, which can yield, did so in the last step."""
        return self._branch_of_step(e, SPRING) != ELASTIC

    def _branch_of_step(self, e: int, kind: int) -> int:
        """Return a branch of element e in the last step."""
        at = BRANCHES * e + kind
        return (
            self.net.elements.branch[at]
            if self.state.in_step
            else self.net.branches.kept_branch[at]
        )

    @open_to_python
    def stable_step(self) -> float:
        """Return the largest stable step for the present tangent, 2 sqrt 3 / omega_max; 0 if unlimited.

        omega_max^2 is the largest eigenvalue of M^-1 K.
        """
        omega = self.monitor.fastest()
        return 2.0 * sqrt(3.0) / omega if omega > 0.0 else 0.0

    @of_python
    def beyond_stable(self) -> tuple[float, float] | None:
        """Return when a fixed step was first too long and the stable step then, s; or None."""
        if self.state.beyond_since == -UNBOUNDED:
            return None
        return self.state.beyond_since, self.state.beyond_step

    # -- why a run ended ---------------------------------------------------------------------------

    @property
    def last_attempt(self) -> float:
        """The length of the step attempted last, s."""
        return self.stepper.errors.step

    @of_python
    def tangents(self) -> tuple[list[list[float]], list[list[float]]]:
        """Return the present stiffness and damping matrices, row by row (N/m and N s/m).

        Springs in series are included as if their dampers were rigid.
        """
        n, modes, places = self.net.n, self.stepper.modes, range(self.net.series.outer)
        k = [
            [modes.stiffness[j * n + i] + self.net.series.stiffness[j * n + i] for j in places]
            for i in places
        ]
        return k, [[modes.damping[j * n + i] for j in places] for i in places]

    # -- whole state -------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The end of the last step, s."""
        return self.state.time

    @property
    def step_count(self) -> int:
        """The number of steps so far."""
        return self.state.step_count

    @property
    def overruns(self) -> int:
        """How often switches that followed one another without time between them were passed over."""
        return self.state.overruns

    @of_python
    def snapshot(self) -> bytes:
        """Return the whole state as bytes, from which `restore` continues bit-identically.

        They are the state as it lies in memory, without a checksum, as runs take and restore many within
        a process; what leaves it, as the state of a `Session` or an FMU, is sealed there.
        """
        self.net.take_moving()
        return self.state.content()

    @of_python
    def restore(self, state: bytes) -> None:
        """Return to the state of a snapshot of the same system; only its size is checked.

        Raises
        ------
        ValueError : if a snapshot of this system has another size.
        """
        if len(state) != self.state_size:
            raise ValueError("this snapshot belongs to another system; use one of this integrator")
        self.noted.clear()
        self._resume(bytes(state))
        self.pace.look_at_pace()
