"""The integrator as others use it: states and signals in, runs, results and the whole state out."""

from __future__ import annotations

from struct import pack, unpack_from

import cython

from .arrays import doubles
from .elements import KINDS
from .march import March

if not cython.compiled:
    from math import sqrt

__all__ = ["FAILURES", "KINDS", "Integrator", "run_all"]

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
}

_PAUSED = 1  # as in march
_TOO_MANY = 9
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
    tolerance : largest error wanted in displacement, relative to the largest displacement
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
        s = self.stepper
        for i in range(self.n):
            s.q[i], s.v[i] = displacements[i], velocities[i]
            s.reach = max(s.reach, abs(displacements[i]))
        self.first_reach = s.reach
        self.in_step = True
        self._begin()

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
        s.reach, self.first_reach = before.reach, earlier.first_reach
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
        jump = self.net.replace_signal(signal, self.time, doubles(coefficients))
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
                self.ledger.bring_in(change)
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
        status = _PAUSED
        self.begun, self.started = self.step_count, self.time
        while status == _PAUSED:
            with cython.nogil:
                status = self._advance(until, stop)
            if status == _PAUSED:
                self._pause()
                if self._is_hopeless(until):
                    return _TOO_MANY
        return status

    def _is_hopeless(self, until):
        """Whether the steps to come would be far too many, at the pace of the last ones."""
        taken = self.step_count - self.begun
        if taken < _ENOUGH_STEPS:
            return False
        if taken * (until - self.time) > _MOST_STEPS * (self.time - self.started):
            return True
        self.begun, self.started = self.step_count, self.time
        return False

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
        self.prepare(times, displacements, velocities, accelerations, forces)
        (status,) = run_all([self])
        self.instants = self.out_q = self.out_v = self.out_a = self.out_f = None
        self.count = 0
        return status

    def prepare(self, times, displacements, velocities=None, accelerations=None, forces=None):
        """Say what `run_all` is to fill, now and again after each restart.

        Parameters
        ----------
        times : s, ascending, none before the last step; an array of doubles, as all of them
        displacements : m, of the first coordinate at all instants, then of the second and so on
        velocities, accelerations : likewise, m/s and m/s^2; None if not wanted
        forces : N, one for each element; with them the accelerations are those of the equation of
            motion, as `sample_forces` finds them

        Raises
        ------
        ValueError : an array that is too short.
        """
        self.count = len(times)
        for out in (displacements, velocities, accelerations):
            self._check_room(out, self.count * self.n)
        self._check_room(forces, self.count * len(self.sample_f))
        self.want_v, self.want_a = velocities is not None, accelerations is not None
        self.want_f = forces is not None
        self.instants, self.out_q = times, displacements
        self.out_v, self.out_a, self.out_f = velocities, accelerations, forces
        self.filled = 0

    def _check_room(self, out, numbers):
        if out is not None and len(out) < numbers:
            raise ValueError(f"{numbers} numbers do not fit into an array of {len(out)}")

    def _run_in_turn(self):
        """The first part of the run, and that of all those that follow."""
        self.begun, self.started = self.step_count, self.time
        self.status = self._run()
        if self.following is not None:
            self.following._run_in_turn()

    def _finish(self):
        """The rest of the run, where it paused."""
        while self.status == _PAUSED:
            self._pause()
            if self._is_hopeless(self.instants[self.count - 1]):
                self.status = _TOO_MANY
                break
            with cython.nogil:
                self.status = self._run()
        return self.status

    def _run(self):
        while self.filled < self.count:
            t = self.instants[self.filled]
            status = self._advance(t, False)
            if status != 0:
                return status
            at = self.filled
            if not (self.want_v or self.want_a or self.want_f):
                self.dense.read_values(t, self.out_q, at, self.count)
                self.filled += 1
                continue
            self.sample(t)
            if self.want_f:
                self.sample_forces(t)
                for i in range(self.net.elements):
                    self.out_f[at + i * self.count] = self.sample_f[i]
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

    def _pause(self):
        """Between parts of a long run: switches make room, and an interrupt may end it."""
        self._log_events()
        self.since_pause = 0
        if cython.compiled:
            PyErr_CheckSignals()  # noqa: F821  (declared beside the types)

    def _log_events(self):
        for k in range(self.event_count):
            what = self.event_what
            i = 4 * k
            self.logged.append((self.event_time[k], what[i], what[i + 1], what[i + 2], what[i + 3]))
        self.event_count = 0

    @property
    def log(self):
        """Switches so far: (time, element, kind, branch before, branch after)."""
        self._log_events()
        return self.logged

    def take_log(self):
        """The switches since it was last taken."""
        taken = self.log
        self.logged = []
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
            net.branch, net.departing, net.signal_now, net.limited_count, s.multiplier,
            s.multiplier_rate, net.kept_branch, net.kept_set, net.kept_signal, s.softest, s.drift,
        )  # fmt: skip

    def snapshot(self):
        """The whole state as bytes, from which `restore` continues to the bit."""
        s, d, net, ledger = self.stepper, self.dense, self.net, self.ledger
        head = pack(
            "<12d3q", self.time, d.start, d.end, self.grid_start, self.proposal,
            net.exchange, ledger.residual_start, ledger.residual_end, s.reach, self.first_reach,
            ledger.initial_energy, ledger.supplied, self.grid_index, self.step_count, self.in_step,
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
        at = 8 * 15
        if len(state) != at + sum(memoryview(part).nbytes for part in parts):
            raise ValueError("this state belongs to another system")
        (
            self.time, d.start, d.end, self.grid_start, self.proposal,
            net.exchange, ledger.residual_start, ledger.residual_end, s.reach, self.first_reach,
            ledger.initial_energy, ledger.supplied, self.grid_index, self.step_count, self.in_step,
        ) = unpack_from("<12d3q", state)  # fmt: skip
        for part in parts:
            view = memoryview(part).cast("B")
            view[:] = state[at : at + len(view)]
            at += len(view)
        self.event_count = 0
        self.logged = []
        d.known = 0
        net.find_levels()
        # tangents follow from the state; accelerations and multipliers are kept to the bit
        net.list_stuck()
        derived = [s.a, s.j, s.multiplier, s.multiplier_rate]
        kept = [bytes(part) for part in derived]
        self._enter_branches()
        for part, content in zip(derived, kept, strict=True):
            memoryview(part).cast("B")[:] = content


def run_all(integrators):
    """Make the runs that integrators are prepared for, one after the other.

    Meanwhile other threads of Python have their way: the lock is given back once for all runs.

    Returns
    -------
    For each 0, or the key of `FAILURES` that says why its run could not go on.
    """
    following = None
    for one in reversed(integrators):
        one.following = following
        following = one
    first = following
    if first is not None:
        with cython.nogil:
            first._run_in_turn()
    statuses = []
    for one in integrators:
        one.following = None
        statuses.append(one._finish())
    return statuses
