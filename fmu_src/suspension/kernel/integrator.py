"""The integrator as others use it: states and signals in, runs, results and the whole state out."""

from __future__ import annotations

from array import array
from struct import pack, unpack_from

import cython

from .arrays import doubles, integers
from .elements import KINDS
from .march import March

if not cython.compiled:
    from math import sqrt

__all__ = ["FAILURES", "KINDS", "Integrator", "Rows"]

# How a run of steps ended that did not reach its end.
FAILURES = {
    2: "the motion has diverged",
    3: "the step has become too small to go on",
    4: "the equilibrium at the end of a step was not found: the fixed step is too long for it",
    5: "the step is too long: its matrix is not positive definite",
    6: "the fixed step is longer than the largest stable one (stable_step)",
    7: "energy grows without work done: the fixed step is too long, or the tolerance too loose",
    8: "switches follow one another while no time passes",
    9: "it would take far too many steps: a motion is too fast for so long a time",
    10: "the mass matrix must be symmetric and positive definite",
    11: "the balance of energy lacks more than was ever stored or supplied: the tolerance is too loose",
}

_PAUSED, _EVENT_CAPACITY = 1, 512  # as in march
_TOO_MANY, _NO_MASS = 9, 10
_ENOUGH_STEPS = 200000  # from which it is judged, again and again, how many are still to come
_MOST_STEPS = 30000000  # still to come in one call
_SPRING, _CONTACT, _KINDS = 0, 3, 5  # as in elements


class Integrator(March):
    """Steps one system and holds its whole state.

    The methods, with omega_max^2 the largest eigenvalue of M^-1 K, K the present tangent:

    - `extrapolated`: the incremental step (H83 eqs. 15.9 to 15.18) in 1, 2, 3 and 5 parts,
      extrapolated; order 8 (or 2, 4, 6), omega_max h < 3.2 (2.2 at orders 4 and 6), any damping.
      The default: step and order by the tolerance.
    - `equilibrium`: one incremental step with Newton to the equilibrium at its end; order 2,
      omega_max h < 2 sqrt 3. For fixed steps: the most accurate of the plain ones.
    - `mean`: tangents averaged over the step (15.7), iterated; as `equilibrium`. To follow H83.
    - `tangent`: tangents of the start of the step, as in H83's hand calculation; order 2, the same
      limit. To follow a calculation by hand, with `landing` off.
    - `wilson`: (15.12), (15.13) up to theta h, equilibrium there, and 1/theta of the change of
      acceleration (Bathe and Wilson 1976); order 2, stable at any step for linear systems only. It
      damps what is fast and lengthens periods; where a fast mode starts out of equilibrium its
      first steps overshoot by some (omega h)^2. For stiff linear systems at large fixed steps.
    - `exact`: the matrix exponential, with every cubic and sinusoid of roads and loads; right to
      rounding at any step, and what is read between steps to the tolerance. Only where every
      element is straight in each of its branches; others are refused. For truth to compare with,
      and for extreme stiffness or damping.

    Parameters
    ----------
    system : `models.System`; read once, not kept
    method : one of these
    step : fixed macro step, s; 0 lets the tolerance choose
    tolerance : largest error wanted in displacement, relative to the largest motion so far, which
        counts from where the run starts
    start : s
    order : of `extrapolated`; 0 lets the tolerance choose
    landing : whether steps end on switches; without it, as in a calculation by hand, an element
        changes its branch at the end of the step in which it passed its corner
    theta : of `wilson`, at least 1.37
    beyond_stable : what becomes of a fixed step that is not stable: `substep` takes it in equal
        parts that are, `refuse` ends the run, `allow` takes it all the same
    energy : whether the energy ledger is kept; without it steps cost less

    Raises
    ------
    ValueError : unknown method, or a mass matrix that is not positive definite.
    """

    def set_state(self, displacements, velocities):
        """Start from given displacements (m) and velocities (m/s), at the present time.

        Raises
        ------
        ValueError : not one value per coordinate.
        """
        if len(displacements) != self.n or len(velocities) != self.n:
            raise ValueError(f"{self.n} displacements and {self.n} velocities are wanted")
        self._enter_state(array("d", [*displacements, *velocities]), 0)

    def take_over(self, earlier, pairs):
        """Go on from where the integrator of a system with the same coordinates and signals stands.

        For a parameter that changes during a run. What that does to the energy stored is nobody's
        work, so the residual goes on from where it was; the work of roads and loads begins anew.

        Parameters
        ----------
        earlier : the integrator so far
        pairs : numbers of elements, here and there, that are the same thing
        """
        s, before = self.stepper, earlier.stepper
        self.set_state(before.q, before.v)
        s.reach, self.scale = before.reach, earlier.scale
        for i in range(self.n):
            s.origin[i] = before.origin[i]
        self.step_count = earlier.step_count
        self.net.exchange = earlier.net.exchange
        for here, there in pairs:
            self.ledger.work[here] = earlier.ledger.work[there]
            self.limited_time[here] = earlier.limited_time[there]
        self.ledger.supplied = earlier.ledger.supplied + abs(earlier.ledger.initial_energy)
        self.ledger.strike_balance(self.time, s.q, s.v)
        self.ledger.carry_on(earlier.ledger.residual_end)

    def set_signal(self, signal, coefficients, jumps=True):
        """Replace a one-segment signal from now on by c0 + c1 s + c2 s^2 + c3 s^3, s = t - now.

        A jump of the value acts on the masses through the dampers as an impulse, so that a sampled
        road carries the momentum of the continuous one.

        Parameters
        ----------
        signal : its number in the order of the system's signals
        coefficients : four numbers
        jumps : whether a change of the value is such a jump
        """
        before = self._energy_now() - self.net.exchange
        self._remember_branches()
        jump = self.net.replace_signal(signal, self.time, array("d", coefficients))
        if jumps and jump != 0.0:
            # a damper at rest stands on its corner: the road's new velocity says on which side it acts
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
            self.stepper.refresh(self.time)
            self.net.impulse(signal, jump, self.stepper.v)
        self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
        self._note_changes()
        self._enter_branches()
        if jump != 0.0:
            change = self._energy_now() - self.net.exchange - before
            if jumps:
                self.ledger.bring_in(signal, change)
            else:
                self.ledger.initial_energy += change

    # -- stepping ----------------------------------------------------------------------------------

    def advance(self, until, stop=False):
        """Step until `until` is reached or passed.

        Parameters
        ----------
        until : s
        stop : end a step on `until` exactly, as signals from outside demand; otherwise the steps do
            not depend on `until` at all, and results are read off the last step's interpolant

        Returns
        -------
        0, or the key of `FAILURES` that says why the run cannot go on.
        """
        self._look_at_pace()
        while True:
            with cython.nogil:
                status = self._advance(until, stop)
            if status != _PAUSED:
                return status
            if not self._may_go_on(until):
                return _TOO_MANY

    def _look_at_pace(self):
        """From now on it is judged how fast the run goes."""
        self.begun, self.started = self.step_count, self.time

    def _may_go_on(self, until):
        """Between parts of a long run: switches make room, and an interrupt may end it.

        Whether the steps to come are not far too many, at the pace of the last ones.
        """
        self._log_events()
        self.since_pause = 0
        if cython.compiled:
            PyErr_CheckSignals()  # noqa: F821  (declared beside the types)
        taken = self.step_count - self.begun
        if taken >= _ENOUGH_STEPS:
            if taken * (until - self.time) > _MOST_STEPS * (self.time - self.started):
                return False
            self._look_at_pace()
        return True

    def run(self, times, displacements, velocities=None, accelerations=None, forces=None):
        """Step over a whole run and fill arrays, without Python between the instants.

        What is wanted says `prepare`.

        Returns
        -------
        0, or the key of `FAILURES` that says why the run could not go on; `filled` instants are right.

        Raises
        ------
        ValueError : an array that is too short.
        """
        self.prepare(1, times, displacements, velocities, accelerations, forces)
        self._look_at_pace()
        while True:
            with cython.nogil:
                status = self._run(0)
            if status != _PAUSED:
                break
            if not self._may_go_on(times[len(times) - 1]):
                status = _TOO_MANY
                break
        self.instants = self.out_q = self.out_v = self.out_a = self.out_f = None
        self.count = self.places = 0
        return status

    def prepare(self, runs, times, displacements, velocities=None, accelerations=None, forces=None):
        """Say what so many runs are to fill, one after the other.

        Parameters
        ----------
        runs : how many the arrays have room for
        times : s, ascending, none before the last step; an array of doubles, as all of them
        displacements : m, of the first coordinate at all instants, then of the second and so on; then
            likewise of the next run
        velocities, accelerations : likewise, m/s and m/s^2; None if not wanted
        forces : N, one for each element; with them the accelerations are those of the equation of
            motion, as `sample_forces` finds them

        Raises
        ------
        ValueError : an array that is too short.
        """
        self.count, self.places = len(times), runs
        for out in (displacements, velocities, accelerations):
            self._check_room(out, runs * self.count * self.n)
        self._check_room(forces, runs * self.count * len(self.sample_f))
        self.want_v, self.want_a = velocities is not None, accelerations is not None
        self.want_f = forces is not None
        self.instants, self.out_q = times, displacements
        self.out_v, self.out_a, self.out_f = velocities, accelerations, forces
        self.filled = 0

    def _check_room(self, out, numbers):
        if out is not None and len(out) < numbers:
            raise ValueError(f"{numbers} numbers do not fit into an array of {len(out)}")

    def _run(self, place):
        """Step over the instants and fill what is wanted, in the room of one of the runs."""
        before = place * self.count
        while self.filled < self.count:
            t = self.instants[self.filled]
            status = self._advance(t, False)
            if status != 0:
                return status
            at = before * self.n + self.filled
            if not (self.want_v or self.want_a or self.want_f):
                self.dense.read_values(t, self.out_q, at, self.count)
                self.filled += 1
                continue
            self.sample(t)
            if self.want_f:
                self.sample_forces(t)
                force_at = before * self.net.elements + self.filled
                for i in range(self.net.elements):
                    self.out_f[force_at + i * self.count] = self.sample_f[i]
            for i in range(self.n):
                self.out_q[at + i * self.count] = self.sample_q[i]
            if self.want_v:
                for i in range(self.n):
                    self.out_v[at + i * self.count] = self.sample_v[i]
            if self.want_a:
                for i in range(self.n):
                    self.out_a[at + i * self.count] = self.sample_a[i]
            self.filled += 1
        return 0

    def _log_events(self):
        for k in range(self.event_count):
            what = self.event_what
            i = 4 * k
            self.logged.append((self.event_time[k], what[i], what[i + 1], what[i + 2], what[i + 3]))
        self.event_count, self.event_base, self.flushed = 0, 0, len(self.logged)

    @property
    def log(self):
        """Switches so far: (time, element, kind, branch before, branch after)."""
        self._log_events()
        return self.logged

    def take_log(self):
        """The switches since it was last taken."""
        taken = self.log
        self.logged = []
        self.flushed = 0
        return taken

    # -- reading results ---------------------------------------------------------------------------

    def sample(self, t):
        """Displacements, velocities and accelerations at an instant of the last step.

        They go to `sample_q`, `sample_v`, `sample_a`: by the cubic of the method itself (15.11), for
        `extrapolated` by the septic through q and its three derivatives at both ends.
        """
        self.dense.read(t)
        for i in range(self.n):
            self.sample_q[i], self.sample_v[i] = self.dense.q[i], self.dense.v[i]
            self.sample_a[i] = self.dense.a[i]

    def sample_forces(self, t):
        """Accelerations and element forces at the instant sampled last, from the equation of motion.

        They go to `sample_a` and `sample_f`, in the branches of the last step: dry friction knows
        whether it slips or sticks, and then has the force that sticking takes; what has yielded
        knows its set, which goes to `sample_set`.
        """
        if self.in_step or self.dense.end <= self.dense.start:
            self.net.keep_branches()
        self.net.read_forces(
            t, self.sample_q, self.sample_v, self.sample_a, self.sample_f, self.sample_set
        )

    @property
    def residual_end(self):
        """What the energy balance lacks at the end of the last step, J."""
        return self.ledger.residual_end

    def residual_at(self, t):
        """What the energy balance lacks, J, carried linearly through the last step."""
        h = self.dense.end - self.dense.start
        if h <= 0.0:
            return self.ledger.residual_end
        x = (t - self.dense.start) / h
        return self.ledger.residual_start + x * (
            self.ledger.residual_end - self.ledger.residual_start
        )

    def energies(self):
        """Where the energy is at the end of the last step, and where it has gone until then, J.

        Returns
        -------
        The kinetic energy, what each element stores, what each element has dissipated, and what each
        signal, as a road or as a load, has brought in.
        """
        net, work = self.net, self.ledger.work
        net.all_signals(self.time)
        net.row_states(self.stepper.q, self.stepper.v)
        stored = [net.element_energy(e, net.row_d[net.element_row[e]]) for e in range(net.elements)]
        brought_in = [0.0] * net.signals
        for r in range(net.rows):
            if net.row_signal[r] >= 0:
                brought_in[net.row_signal[r]] += work[net.elements + r]
        for m in range(net.loads):
            brought_in[net.load_signal[m]] += work[net.elements + net.rows + m]
        kinetic = net.energy(self.stepper.v) - sum(stored)
        return kinetic, stored, list(work[: net.elements]), brought_in

    def limited_time_at(self, e, t):
        """How long element e has been at its limit (a tyre off the road) up to t, s."""
        late = self.dense.end - t if self.step_limited[e] else 0.0
        return self.limited_time[e] - late

    def at_limit(self, e):
        """Whether element e is at its limit now: a tyre off the road."""
        return self.net.branch[_KINDS * e + _CONTACT] != 0

    def yielding(self, e):
        """Whether element e, which may yield, did so in the last step."""
        branch = self.net.branch if self.in_step else self.net.kept_branch
        return branch[_KINDS * e + _SPRING] != 1

    def permanent_set(self, e):
        """Deflection at which element e, which yields, would be free of force now, m."""
        d = sum(
            self.net.row_direction[self.net.element_row[e] * self.n + i] * self.stepper.q[i]
            for i in range(self.n)
        )
        s = self.net.row_signal[self.net.element_row[e]]
        if s >= 0:
            self.net.signal(s, self.time)
            d -= self.net.road[4 * s]
        return self.net.permanent_set(e, d)

    def stable_step(self):
        """Largest stable step for the present tangent: 2 sqrt 3 / omega_max; 0 where none is needed.

        omega_max^2 is the largest eigenvalue of M^-1 K.
        """
        omega = self.watch.fastest()
        return 2.0 * sqrt(3.0) / omega if omega > 0.0 else 0.0

    def beyond_stable(self):
        """When a fixed step was first found too long, and what was stable then, s; or None."""
        if self.watch.beyond_since == -1e300:
            return None
        return self.watch.beyond_since, self.watch.beyond_step

    # -- whole state -------------------------------------------------------------------------------

    def _parts(self):
        s, d, net = self.stepper, self.dense, self.net
        return (
            d.qa, d.va, d.aa, d.ja, d.qb, d.vb, d.ab, d.jb, s.q, s.v, s.a, s.j,
            self.ledger.work, self.limited_time, self.step_limited, net.segment, net.piece,
            net.branch, net.departing, net.signal_now, s.multiplier,
            s.multiplier_rate, net.kept_branch, net.kept_set, net.kept_signal, s.softest, s.drift,
            s.origin,
        )  # fmt: skip

    def snapshot(self):
        """The whole state as bytes, from which `restore` continues to the bit."""
        s, d, net, ledger = self.stepper, self.dense, self.net, self.ledger
        head = pack(
            "<15d6q", self.time, d.start, d.end, self.grid_start, self.proposal,
            net.exchange, ledger.residual_start, ledger.residual_end, s.reach, self.scale,
            ledger.most_stored,
            ledger.initial_energy, ledger.supplied, self.watch.beyond_since, self.watch.beyond_step,
            self.grid_index, self.step_count, self.in_step, self.entered, self.stalled, self.overruns,
        )  # fmt: skip
        return head + b"".join(bytes(part) for part in self._parts())

    def restore(self, state):
        """Return to the state of a snapshot of the same system.

        Raises
        ------
        ValueError : a snapshot of another system.
        """
        s, d, net, ledger = self.stepper, self.dense, self.net, self.ledger
        parts = self._parts()
        at = 8 * 21
        if len(state) != at + sum(memoryview(part).nbytes for part in parts):
            raise ValueError("this state belongs to another system")
        (
            self.time, d.start, d.end, self.grid_start, self.proposal,
            net.exchange, ledger.residual_start, ledger.residual_end, s.reach, self.scale,
            ledger.most_stored,
            ledger.initial_energy, ledger.supplied, self.watch.beyond_since, self.watch.beyond_step,
            self.grid_index, self.step_count, self.in_step, entered, self.stalled, self.overruns,
        ) = unpack_from("<15d6q", state)  # fmt: skip
        for part in parts:
            view = memoryview(part).cast("B")
            view[:] = state[at : at + len(view)]
            at += len(view)
        self.event_count = self.event_base = self.flushed = 0
        self.logged = []
        d.known = 0
        net.find_levels()
        # tangents follow from the state; accelerations and multipliers are kept to the bit
        net.list_stuck()
        derived = [s.a, s.j, s.multiplier, s.multiplier_rate]
        kept = [bytes(part) for part in derived]
        self._enter_branches()
        self.entered = entered
        for part, content in zip(derived, kept, strict=True):
            memoryview(part).cast("B")[:] = content


class Rows:
    """Runs of systems that differ in their numbers alone, one after the other without Python between.

    Other threads of Python have their way meanwhile.

    Parameters
    ----------
    integrator : it makes as many in one go as it is prepared for
    logs : whether the switches of all runs of a go are wanted
    """

    def __init__(self, integrator, logs):
        self.integrator, self.logs = integrator, logs
        most = self.most = self.integrator.places
        self.width = 1 + 2 * self.integrator.n + self.integrator.net.size
        self.contacts = self.integrator.contacts
        self.status, self.filled, self.steps, self.log_end = (
            integers([0] * most) for _ in range(4)
        )
        self.time, self.limited = (
            doubles([0.0] * most),
            doubles([0.0] * most * max(self.contacts, 1)),
        )

    def take(self, numbers, start):
        """Take the rows of all runs that are to come.

        Parameters
        ----------
        numbers : the `row` of each, one after the other; an array of doubles
        start : of all runs, s

        Raises
        ------
        ValueError : rows of another system.
        """
        if len(numbers) % self.width:
            raise ValueError(f"{len(numbers)} numbers are no rows of {self.width}")
        self.numbers, self.start, self.rows = numbers, start, len(numbers) // self.width

    def go(self, first, last):
        """Make the runs from `first` on that come before `last`, at least one of them.

        There may be no room for all: they are no more than the integrator is prepared for, and another
        one begins only while three quarters of the log, if it is wanted, are empty.

        Returns
        -------
        For each 0, or the key of `FAILURES` that says why it could not go on; how many instants it
        reached, the time, s, and the number of steps at its end; and where its switches end in `log`.

        Raises
        ------
        ValueError : an integrator that is not prepared, or runs that there are no rows for.
        """
        one = self.integrator
        if one.count == 0 or one.places < self.most or not 0 <= first < last <= self.rows:
            raise ValueError(f"runs {first} to {last} of {self.rows}: no room, or no rows")
        one.take_log()
        self.first, self.wanted = first, min(last - first, self.most)
        self.made = 0
        self.underway = False
        while True:
            with cython.nogil:
                paused = self._go()
            if not paused:
                break
            if not one._may_go_on(one.instants[one.count - 1]):
                self._end(_TOO_MANY)
        return [
            (self.status[k], self.filled[k], self.time[k], self.steps[k], self.log_end[k])
            for k in range(self.made)
        ]

    def limited_time(self, k, e):
        """How long element e was at its limit, s, in run k of the last go up to its last instant."""
        for i in range(self.contacts):
            if self.integrator.contact_element[i] == e:
                return self.limited[k * self.contacts + i]
        return 0.0  # it has no limit

    def _go(self):
        """Whether a run has paused; else all are made, or as many as there is room for."""
        while self.made < self.wanted:
            status = 0
            if not self.underway:
                if not self.logs:
                    self.integrator.event_count = 0
                elif self.integrator.event_count > _EVENT_CAPACITY // 4:
                    return 0
                status = self._begin()
            if status == 0:
                status = self.integrator._run(self.made)
            if status == _PAUSED:
                return 1
            self._end(status)
        return 0

    def _begin(self):
        at = (self.first + self.made) * self.width
        status = self.integrator.begin_row(self.numbers, at, self.start)
        self.integrator._look_at_pace()
        self.underway = True
        return _NO_MASS if status != 0 else 0

    def _end(self, status):
        """Note how the run that is underway has ended."""
        k = self.made
        self.status[k], self.filled[k] = status, self.integrator.filled
        self.time[k], self.steps[k] = self.integrator.time, self.integrator.step_count
        self.log_end[k] = self.integrator.flushed + self.integrator.event_count
        for i in range(self.integrator.contacts):
            self.limited[k * self.contacts + i] = self.integrator.limited_time_at(
                self.integrator.contact_element[i],
                self.integrator.instants[self.integrator.count - 1],
            )
        self.made += 1
        self.underway = False
