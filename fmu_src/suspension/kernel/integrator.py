"""The integrator: macro steps chosen, cut at joints and switches, accepted, and read off.

Branches stay fixed within a step, in which the motion is therefore smooth; a step that would leave
a branch is cut short so that it ends on the switch, located to rounding.
"""

from __future__ import annotations

from struct import pack, unpack_from

import cython

from .arrays import doubles, integers, vectors
from .dense import Dense
from .exact import not_straight
from .ledger import Ledger
from .network import Network
from .stepper import METHODS, Stepper
from .switches import Switches
from .watch import LIMITS, POLICIES, UNLIMITED, Watch

if not cython.compiled:
    from math import fabs, pow, sqrt

# How a step, or a run of them, ended. C constants when compiled; FAILURES is what others read.
_REACHED, _PAUSED, _DIVERGED, _STEP_TOO_SMALL = 0, 1, 2, 3
_UNSTABLE, _ENERGY_GROWS, _NO_TIME_PASSES = 6, 7, 8
FAILURES = {
    2: "the motion has diverged",
    3: "the step has become too small to go on",
    4: "the equilibrium at the end of a step was not found",
    5: "the step is too long: its matrix is not positive definite",
    6: "the fixed step is longer than the largest stable one (stable_step)",
    7: "energy grows without work done: the fixed step is too long, or the tolerance too loose",
    8: "switches follow one another while no time passes",
}

_SPRING, _CONTACT, _FRICTION, _KINDS = 0, 3, 4, 5  # as in elements
_EVENT_CAPACITY = 256
_PAUSE = 5000  # steps after which Python may look for signals, such as an interrupt
_STALLED = 100  # steps in which no time passes
_LEAST_THETA = 1.37
_GROWTH = 1e7  # a displacement this many times the scale of the run has diverged
_SAFE_PHASE = 2.5  # of the fastest mode per macro step; local extrapolation is stable up to 3.1
_NO_ERROR = 2e-5  # (0.9 / 4)^7: below it steps grow as much as they may
_SHORT_PHASE = 1e-4  # of the quickest motion, over which its Taylor series is as good as a step


class Integrator:
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

    def __init__(
        self,
        system,
        method="extrapolated",
        step=0.0,
        tolerance=1e-6,
        start=0.0,
        order=0,
        landing=True,
        energy=True,
        theta=1.4,
        beyond_stable="substep",
    ):
        if method not in METHODS:
            raise ValueError(f"method {method!r} is not one of {', '.join(METHODS)}")
        if method == "exact" and (why := not_straight(system)):
            raise ValueError(f"method 'exact' cannot take this system: {why}")
        if not theta >= _LEAST_THETA:
            raise ValueError(f"theta = {theta:g} must be at least {_LEAST_THETA:g}")
        if method == "exact":
            columns = 4
        elif method != "extrapolated":
            columns = 1
        elif order:
            columns = order // 2
        else:
            columns = 4 if tolerance < 1e-4 or step > 0.0 else 3
        self.net = Network(system)
        self.stepper = Stepper(self.net, method, columns, tolerance, theta)
        self.switches = Switches(self.stepper)
        if beyond_stable not in POLICIES:
            raise ValueError(f"beyond_stable {beyond_stable!r} is not one of {', '.join(POLICIES)}")
        limit = 0.0 if method in UNLIMITED else LIMITS[columns]
        self.watch = Watch(self.stepper, self.net, beyond_stable, limit)
        self.n = n = self.net.n
        self.dense = Dense(n, method in ("equilibrium", "mean", "tangent"))
        self.ledger = Ledger(self.net, self.dense)
        self.fixed_step = step
        self.landing, self.energy = landing, energy
        self.controlled = method in ("extrapolated", "exact") and step == 0.0
        self.sample_q, self.sample_v, self.sample_a = vectors(3, n)
        elements = self.net.elements
        self.sample_f, self.sample_set = vectors(2, elements)
        self.in_step = True  # whether the branches are still those of the last step
        self.step_limited, self.limited_time = integers([0] * elements), doubles([0.0] * elements)
        self.event_time = doubles([0.0] * _EVENT_CAPACITY)
        self.event_what = integers([0] * 4 * _EVENT_CAPACITY)
        self.event_count = self.stalled = self.filled = self.since_pause = 0
        self.log = []  # switches so far: (time, element, kind, from, to)
        self.time = self.grid_start = start
        self.grid_index = self.step_count = 0
        self.proposal = 0.0
        self.stepper.reach = self.first_reach = max(system.scales)
        self.net.enter_segments(start, vectors(1, n)[0])  # what lies before the start gives no jump
        self._begin()

    def _begin(self):
        """Branches, accelerations and energy of the present state, which both ends of the step show."""
        s, d, net = self.stepper, self.dense, self.net
        net.settle(self.time, s.q, s.v)
        net.locate_branches(self.time, s.q, s.v)
        self._enter_branches()
        for i in range(self.n):
            d.qa[i] = d.qb[i] = s.q[i]
            d.va[i] = d.vb[i] = s.v[i]
            d.aa[i] = d.ab[i] = s.a[i]
            d.ja[i] = d.jb[i] = s.j[i]
            s.drift[i] = 0.0
        d.start = d.end = self.time
        net.row_states(s.q, s.v)
        self.ledger.initial_energy = net.energy(s.v)

    def _enter_branches(self):
        """Everything that follows from the branches, after any of them has changed."""
        self.stepper.refresh(self.time)
        self.switches.enter_branches()

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
        before = self._energy()
        jump = self.net.replace_signal(signal, self.time, doubles(coefficients))
        if jumps and jump != 0.0:
            # a damper at rest stands on its corner: the road's new velocity says on which side it acts
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
            self.stepper.refresh(self.time)
            self.net.impulse(signal, jump, self.stepper.v)
        self._leave_step()
        self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
        self._enter_branches()
        if jump != 0.0:
            if jumps:
                self.ledger.bring_in(self._energy() - before)
            else:
                self.ledger.initial_energy += self._energy() - before

    def _energy(self):
        """Kinetic and stored energy now, J, less what contact switches have exchanged."""
        self.net.all_signals(self.time)
        self.net.row_states(self.stepper.q, self.stepper.v)
        return self.net.energy(self.stepper.v) - self.net.exchange

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
        while status == _PAUSED:
            with cython.nogil:
                status = self._advance(until, stop)
            self._log_events()
        return status

    def run(self, times, displacements, velocities=None, accelerations=None):
        """Step over a whole run and fill arrays, without Python between the instants.

        Parameters
        ----------
        times : s, ascending, none before the last step; an array of doubles, as all of them
        displacements : m, one for each coordinate at the first instant, then at the second and so on
        velocities, accelerations : likewise, m/s and m/s^2; None if not wanted

        Returns
        -------
        0, or the key of `FAILURES` that says why the run could not go on; `filled` instants are right.

        Raises
        ------
        ValueError : an array that is too short.
        """
        count = len(times)
        for out in (displacements, velocities, accelerations):
            if out is not None and len(out) < count * self.n:
                raise ValueError(f"{count * self.n} numbers do not fit into an array of {len(out)}")
        self.want_v, self.want_a = velocities is not None, accelerations is not None
        self.instants, self.out_q = times, displacements
        self.out_v, self.out_a = velocities, accelerations
        self.filled = 0
        status = self._run_all(count)
        self.instants = self.out_q = self.out_v = self.out_a = None
        return status

    def _run_all(self, count):
        status = _PAUSED
        while status == _PAUSED:
            with cython.nogil:
                status = self._run(count)
            self._log_events()
        return status

    def _run(self, count):
        while self.filled < count:
            t = self.instants[self.filled]
            status = self._advance(t, False)
            if status != 0:
                return status
            at = self.filled * self.n
            if not (self.want_v or self.want_a):
                self.dense.read_values(t, self.out_q, at)
                self.filled += 1
                continue
            self.dense.read(t)
            for i in range(self.n):
                self.out_q[at + i] = self.dense.q[i]
            if self.want_v:
                for i in range(self.n):
                    self.out_v[at + i] = self.dense.v[i]
            if self.want_a:
                for i in range(self.n):
                    self.out_a[at + i] = self.dense.a[i]
            self.filled += 1
        return 0

    def _log_events(self):
        for k in range(self.event_count):
            what = self.event_what[4 * k : 4 * k + 4]
            self.log.append((self.event_time[k], *what))
        self.event_count = self.since_pause = 0
        if cython.compiled:
            PyErr_CheckSignals()  # noqa: F821  (declared beside the types)

    def _advance(self, until, stop):
        while self.time < until:
            if self.event_count > _EVENT_CAPACITY - 16 or self.since_pause >= _PAUSE:
                return _PAUSED
            self.since_pause += 1
            before = self.time
            status = self._step(until if stop else 1e300)
            if status != 0:
                return status
            # switches that follow each other while no time passes would have no end
            if self.time - before > 1e-13 * (fabs(self.time) + 1e-3):
                self.stalled = 0
            else:
                self.stalled += 1
                if self.stalled > _STALLED:
                    return _NO_TIME_PASSES
        return _REACHED

    def _proposed_step(self):
        """The step the method wants, before joints and switches cut it."""
        if self.fixed_step > 0.0:
            # the grid is counted, not summed, so that it does not drift
            target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            while target <= self.time + 1e-9 * self.fixed_step:
                self.grid_index += 1
                target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            return self.watch.fit(self.time, target - self.time)
        omega = sqrt(self.stepper.omega_squared)
        road = self.net.road_limit(self.time)
        if not self.controlled:
            # the period error of the linear-acceleration method is (omega h)^2 / 24
            h = sqrt(self.stepper.tolerance) / omega if omega > 0.0 else road
        else:
            h = self.proposal if self.proposal > 0.0 else 0.1 * _SAFE_PHASE / (omega + 1.0)
            if h * omega > _SAFE_PHASE:
                h = _SAFE_PHASE / omega
        return road if h > road else h

    def _step(self, latest):
        """One accepted macro step, cut at joints and switches."""
        h = self._proposed_step()
        if h == 0.0:
            return _UNSTABLE
        flips = 0
        while True:
            joint = self.net.next_joint()
            end = joint if joint < latest else latest
            to_end = 0
            if self.time + h * (1.0 + 1e-9) >= end:
                h = end - self.time
                to_end = 1
            if not (to_end or h > 4e-16 * (fabs(self.time) + 1e-3)):
                return _STEP_TOO_SMALL
            status = self.stepper.attempt(self.time, h)
            if status != 0:
                h *= 0.25
                if not self.controlled or h < 1e-14:
                    return status
                continue
            if self.controlled and self.stepper.error > 1.0:
                h *= self._factor_for_error()
                continue
            at = self.switches.first(self.time, h) if self.landing else 2.0
            if at == 0.0 and flips < 8:
                # the branch is left at once: it was the wrong side of its bound
                flips += 1
                self._switch(self.switches.element, self.switches.kind, self.switches.side)
                self._enter_branches()
                continue
            break
        # a step that a joint cut short says nothing against longer ones
        if self.controlled and (not to_end or h > self.proposal > 0.0):
            self.proposal = h * self._factor_for_error()
        landed = 0
        if 0.0 < at <= 1.0:
            status = self._land(h)
            if status != 0:
                return status
            h = self.landed
            landed = 1
            to_end = to_end and self.time + h >= end
        self._accept(h, end if to_end else self.time + h)
        if landed:
            self._switch(self.switches.element, self.switches.kind, self.switches.side)
        if to_end and end == joint:
            self._pass_joint()
        if not self.landing:
            self._leave_step()
            self.net.follow(self.time, self.stepper.q, self.stepper.v)
        if landed or to_end or not (self.landing and self.stepper.affine):
            self._enter_branches()
        for i in range(self.n):
            if not fabs(self.stepper.q[i]) < _GROWTH * self.first_reach:
                return _DIVERGED
        if self.energy and self.ledger.grows():
            return _ENERGY_GROWS
        return _REACHED

    def _pass_joint(self):
        """Signals enter their next segments; what a jump of a road does is work of that road."""
        self._leave_step()
        self.net.all_signals(self.time)
        self.net.row_states(self.stepper.q, self.stepper.v)
        self.net.row_forces()
        before = self.net.energy(self.stepper.v)
        if self.net.enter_segments(self.time, self.stepper.v):
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
            self.ledger.bring_in(self.net.energy(self.stepper.v) - before)

    def _factor_for_error(self):
        """Change of step that brings the error to the tolerance: err grows as h^(2 columns - 1)."""
        if self.stepper.error <= _NO_ERROR:
            return 4.0
        factor = 0.9 * pow(self.stepper.error, -1.0 / (2.0 * self.stepper.columns - 1.0))
        return 4.0 if factor > 4.0 else (0.2 if factor < 0.2 else factor)

    def _accept(self, h, t):
        """Make the attempt the last step."""
        for i in range(self.n):
            self.dense.qa[i] = self.stepper.q[i]
            self.dense.va[i] = self.stepper.v[i]
            self.dense.aa[i] = self.stepper.a[i]
            self.dense.ja[i] = self.stepper.j[i]
            self.dense.qb[i] = self.stepper.q[i] = self.stepper.qb[i]
            self.dense.vb[i] = self.stepper.v[i] = self.stepper.vb[i]
            self.dense.ab[i] = self.stepper.a[i] = self.stepper.ab[i]
            self.dense.jb[i] = self.stepper.j[i] = self.stepper.jb[i]
            self.stepper.drift[i] = self.stepper.drift_end[i]
            self.stepper.reach = max(self.stepper.reach, fabs(self.stepper.q[i]))
        for i in range(self.net.elements):
            self.step_limited[i] = self.net.branch[_KINDS * i + _CONTACT]
            if self.step_limited[i]:
                self.limited_time[i] += h
        for i in range(_KINDS * self.net.elements):
            self.net.departing[i] = 0
        if self.net.stuck:
            self.stepper.keep_multipliers()
        self.in_step = True
        self.dense.start = self.time
        self.dense.end = self.time = t
        self.dense.known = 0
        self.step_count += 1
        if self.energy:
            self.ledger.book()
            self.ledger.strike_balance(t, self.stepper.q, self.stepper.v)

    def _land(self, h):
        """Shorten the attempt so that it ends on the switch found: Newton, at last along Taylor."""
        step = self.switches.at * h
        status = self.stepper.attempt(self.time, step)
        best = 1e300
        for _iteration in range(8):
            if status != 0:
                return status
            late = self.switches.lateness(self.time + step)
            new = step - late
            if late == 0.0 or self.switches.miss >= best or not (0.0 < new <= h):
                break
            if self.time + new == self.time + step:
                break
            best = self.switches.miss
            if fabs(late) * self.stepper.quickest < _SHORT_PHASE:
                self.stepper.shift_end(self.time + new, -late)
            else:
                status = self.stepper.attempt(self.time, new)
            step = new
        self.landed = step
        return status

    def _switch(self, e, kind, side):
        """Element e enters the neighbouring branch, now; the event is noted."""
        self._leave_step()
        new = self.net.enter(e, kind, side, self.time, self.stepper.q, self.stepper.v)
        k = self.event_count
        if k < _EVENT_CAPACITY:
            self.event_time[k] = self.time
            self.event_what[4 * k] = e
            self.event_what[4 * k + 1] = kind
            if kind == _CONTACT:
                self.event_what[4 * k + 2] = 1 - new
            elif kind == _FRICTION and new != 0:
                self.event_what[4 * k + 2] = 0
            else:
                self.event_what[4 * k + 2] = new - side
            self.event_what[4 * k + 3] = new
            self.event_count += 1

    def _leave_step(self):
        """Branches are about to change: remember those of the step that ends here, to read it off."""
        if self.in_step:
            self.net.keep_branches()
            self.in_step = False

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
        self.log = []
        d.known = 0
        # tangents follow from the state; accelerations and multipliers are kept to the bit
        net.list_stuck()
        derived = [s.a, s.j, s.multiplier, s.multiplier_rate]
        kept = [bytes(part) for part in derived]
        self._enter_branches()
        for part, content in zip(derived, kept, strict=True):
            memoryview(part).cast("B")[:] = content
