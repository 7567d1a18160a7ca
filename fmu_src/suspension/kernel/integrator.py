"""The integrator: macro steps chosen, cut at joints and switches, accepted, and read off.

Branches stay fixed within a step, in which the motion is therefore smooth; a step that would leave
a branch is cut short so that it ends on the switch, located to rounding.
"""

from __future__ import annotations

from struct import pack, unpack_from

import cython

from .arrays import doubles, integers, vectors
from .bernstein import Crossing
from .network import Network
from .stepper import METHODS, Stepper

if not cython.compiled:
    from math import fabs, pow, sqrt

# How a step, or a run of them, ended. C constants when compiled; FAILURES is what others read.
_REACHED, _EVENTS_FULL, _DIVERGED, _STEP_TOO_SMALL = 0, 1, 2, 3
FAILURES = {
    2: "the motion has diverged",
    3: "the step has become too small to go on",
    4: "the equilibrium at the end of a step was not found",
    5: "the step is too long: its matrix is not positive definite",
}

_SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION, _KINDS = 0, 1, 2, 3, 4, 5  # as in elements
_LAWS = 3
_EVENT_CAPACITY = 256
_STALLED = 100  # steps in which no time passes
_GROWTH = 1e7  # a displacement this many times the scale of the run has diverged
_SAFE_PHASE = 2.5  # of the fastest mode per macro step; local extrapolation is stable up to 3.1


class Integrator:
    """Steps one system and holds its whole state.

    Parameters
    ----------
    system : `models.System`; read once, not kept
    method : `extrapolated` (order 2, 4, 6 or 8), or at order 2 `equilibrium` (Newton to the
        end-of-step equilibrium), `mean` (tangents averaged over the step, 15.7) or `tangent`
        (those of its start)
    step : fixed macro step, s; 0 lets the tolerance choose
    tolerance : largest error wanted in displacement, relative to the largest displacement
    start : s
    order : of `extrapolated`; 0 lets the tolerance choose
    landing : whether steps end on switches; without it, as in a calculation by hand, an element
        changes its branch at the end of the step in which it passed its corner

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
    ):
        if method not in METHODS:
            raise ValueError(f"method {method!r} is not one of {', '.join(METHODS)}")
        if method != "extrapolated":
            columns = 1
        elif order:
            columns = order // 2
        else:
            columns = 4 if tolerance < 1e-4 or step > 0.0 else 3
        self.net = Network(system)
        self.stepper = Stepper(self.net, method, columns, tolerance)
        self.crossing = Crossing()
        self.n = n = self.net.n
        self.fixed_step = step
        self.landing = landing
        self.controlled = method == "extrapolated" and step == 0.0
        self.qa, self.va, self.aa, self.ja = vectors(4, n)  # at the start of the last step
        self.qb, self.vb, self.ab, self.jb = vectors(4, n)  # at its end, before any switch there
        self.sample_q, self.sample_v, self.sample_a = vectors(3, n)
        rows, elements = self.net.rows, self.net.elements
        self.sample_f, self.sample_set = vectors(2, elements)
        self.in_step = True  # whether the branches are still those of the last step
        self.row_start, self.row_end = vectors(2, 4 * max(rows, 1))
        self.step_limited, self.limited_time = integers([0] * elements), doubles([0.0] * elements)
        self.event_time = doubles([0.0] * _EVENT_CAPACITY)
        self.event_what = integers([0] * 4 * _EVENT_CAPACITY)
        self.event_count = self.stalled = 0
        self.log = []  # switches so far: (time, element, kind, from, to)
        self.time = self.step_start = self.step_end = self.grid_start = start
        self.grid_index = self.step_count = 0
        self.proposal = 0.0
        self.residual_start = self.residual_end = 0.0
        self.stepper.reach = self.first_reach = max(system.scales)
        self.net.enter_segments(start, vectors(1, n)[0])  # what lies before the start gives no jump
        self._begin()

    def _begin(self):
        """Branches, accelerations and energy of the present state, which both ends of the step show."""
        s, net = self.stepper, self.net
        net.settle(self.time, s.q, s.v)
        net.locate_branches(self.time, s.q, s.v)
        s.refresh(self.time)
        for i in range(self.n):
            self.qa[i] = self.qb[i] = s.q[i]
            self.va[i] = self.vb[i] = s.v[i]
            self.aa[i] = self.ab[i] = s.a[i]
            self.ja[i] = self.jb[i] = s.j[i]
        self.step_start = self.step_end = self.time
        self.initial_energy = net.energy(s.v)

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
            s.work[here] = before.work[there]
            self.limited_time[here] = earlier.limited_time[there]
        self.residual_start = self.residual_end = earlier.residual_end
        self.initial_energy += self._energy_residual() - earlier.residual_end

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
        jump = self.net.replace_signal(signal, self.time, doubles(coefficients))
        if jumps and jump != 0.0:
            # a damper at rest stands on its corner: the road's new velocity says on which side it acts
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
            self.stepper.refresh(self.time)
            self.net.impulse(signal, jump, self.stepper.v)
        self._leave_step()
        self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
        self.stepper.refresh(self.time)

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
        status = _EVENTS_FULL
        while status == _EVENTS_FULL:
            with cython.nogil:
                status = self._advance(until, stop)
            self._log_events()
        return status

    def _log_events(self):
        for k in range(self.event_count):
            what = self.event_what[4 * k : 4 * k + 4]
            self.log.append((self.event_time[k], *what))
        self.event_count = 0

    def _advance(self, until, stop):
        while self.time < until:
            if self.event_count > _EVENT_CAPACITY - 16:
                return _EVENTS_FULL
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
                    return _STEP_TOO_SMALL
        return _REACHED

    def _proposed_step(self):
        """The step the method wants, before joints and switches cut it."""
        if self.fixed_step > 0.0:
            # the grid is counted, not summed, so that it does not drift
            target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            while target <= self.time + 1e-9 * self.fixed_step:
                self.grid_index += 1
                target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            return target - self.time
        omega = sqrt(self.stepper.omega_squared)
        road = self.net.road_limit(self.time)
        if self.stepper.method != 0:
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
            at = self._first_switch(h) if self.landing else 2.0
            if at == 0.0 and flips < 8:
                # the branch is left at once: it was the wrong side of its bound
                flips += 1
                self._switch(self.switch_element, self.switch_kind, self.switch_side)
                self.stepper.refresh(self.time)
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
            self._switch(self.switch_element, self.switch_kind, self.switch_side)
        if to_end and end == joint:
            self._pass_joint()
        if not self.landing:
            self._leave_step()
            self.net.follow(self.time, self.stepper.q, self.stepper.v)
        if landed or to_end or not (self.landing and self.stepper.affine):
            self.stepper.refresh(self.time)
        for i in range(self.n):
            if not fabs(self.stepper.q[i]) < _GROWTH * self.first_reach:
                return _DIVERGED
        return _REACHED

    def _pass_joint(self):
        """Signals enter their next segments; what a jump of a road does is work of that road."""
        self._leave_step()
        before = self.net.energy(self.stepper.v)
        if self.net.enter_segments(self.time, self.stepper.v):
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
            self.stepper.work[self.net.elements] += self.net.energy(self.stepper.v) - before

    def _factor_for_error(self):
        """Change of step that brings the error to the tolerance: err grows as h^(2 columns - 1)."""
        if self.stepper.error <= 0.0:
            return 4.0
        factor = 0.9 * pow(self.stepper.error, -1.0 / (2.0 * self.stepper.columns - 1.0))
        return 4.0 if factor > 4.0 else (0.2 if factor < 0.2 else factor)

    def _accept(self, h, t):
        """Make the attempt the last step."""
        for i in range(self.n):
            self.qa[i] = self.stepper.q[i]
            self.va[i] = self.stepper.v[i]
            self.aa[i] = self.stepper.a[i]
            self.ja[i] = self.stepper.j[i]
            self.qb[i] = self.stepper.q[i] = self.stepper.qb[i]
            self.vb[i] = self.stepper.v[i] = self.stepper.vb[i]
            self.ab[i] = self.stepper.a[i] = self.stepper.ab[i]
            self.jb[i] = self.stepper.j[i] = self.stepper.jb[i]
            self.stepper.reach = max(self.stepper.reach, fabs(self.stepper.q[i]))
        for i in range(self.net.elements):
            self.step_limited[i] = self.net.branch[_KINDS * i + _CONTACT]
            if self.step_limited[i]:
                self.limited_time[i] += h
        for i in range(self.net.works):
            self.stepper.work[i] = self.stepper.trial_work[i]
        self.stepper.keep_multipliers()
        self.in_step = True
        self.step_start = self.time
        self.time = t
        self.step_end = t
        self.step_count += 1
        self.net.all_signals(t)
        self.net.row_states(self.stepper.q, self.stepper.v)
        self.net.mark_bounds()
        self.residual_start = self.residual_end
        self.residual_end = self._energy_residual()

    def _energy_residual(self):
        """T + U + dissipated - brought in - exchanged at contact switches - its start: 0 if exact."""
        balance = self.net.energy(self.stepper.v) - self.initial_energy - self.net.exchange
        for i in range(self.net.elements):
            balance += self.stepper.work[i]
        for i in range(self.net.elements, self.net.works):
            balance -= self.stepper.work[i]
        return balance

    # -- switches ----------------------------------------------------------------------------------

    def _first_switch(self, h):
        """The earliest switch within the attempted step: its fraction of h, or 2 for none."""
        self.net.all_signals(self.time)
        self.net.row_derivatives(
            self.stepper.q, self.stepper.v, self.stepper.a, self.stepper.j, self.row_start
        )
        self.net.all_signals(self.time + h)
        self.net.row_derivatives(
            self.stepper.qb, self.stepper.vb, self.stepper.ab, self.stepper.jb, self.row_end
        )
        self.switch_at = 2.0
        for e in range(self.net.elements):
            at = 4 * self.net.element_row[e]
            # what sticks passes no corner, whatever rounding says
            if not self.net.row_stuck[self.net.element_row[e]]:
                self._search_laws(e, at, h)
            if self.net.friction[e] > 0.0:
                self._friction_polynomial(e, at, h)
            if self.net.limit[e] < 1e300:
                self.net.unlimited_force(e, self.row_start, at)
                f0, f1, f2 = self.net.force0, self.net.force1, self.net.force2
                self.net.unlimited_force(e, self.row_end, at)
                self.crossing.hermite5(
                    f0, f1, f2, self.net.force0, self.net.force1, self.net.force2, h
                )
                self._search(e, _CONTACT, 5)
        return self.switch_at

    def _search_laws(self, e, at, h):
        """Deflection against the corners of spring and modulation, rate against those of the damper."""
        for kind in range(_SPRING, _MODULATION + 1, 2):
            if self.net.count[_LAWS * e + kind] > 1:
                self.crossing.hermite7(self.row_start, self.row_end, at, h)
                self._search(e, kind, 7)
        if self.net.count[_LAWS * e + _DAMPER] > 1 or self.net.yields[e]:
            self.crossing.hermite5(
                self.row_start[at + 1], self.row_start[at + 2], self.row_start[at + 3],
                self.row_end[at + 1], self.row_end[at + 2], self.row_end[at + 3], h,
            )  # fmt: skip
            self._search(e, _DAMPER, 5)

    def _friction_polynomial(self, e, at, h):
        """Slipping: the rate, until it is zero. Sticking: the force it takes, until it is too large."""
        if self.net.branch[_KINDS * e + _FRICTION] != 0:
            self.crossing.hermite5(
                self.row_start[at + 1], self.row_start[at + 2], self.row_start[at + 3],
                self.row_end[at + 1], self.row_end[at + 2], self.row_end[at + 3], h,
            )  # fmt: skip
            self._search(e, _FRICTION, 5)
        else:
            self.crossing.hermite3(
                self.stepper.multiplier[e], self.stepper.multiplier_rate[e],
                self.net.multiplier[e], self.net.multiplier_rate[e], h,
            )  # fmt: skip
            self._search(e, _FRICTION, 3)

    def _search(self, e, kind, degree):
        """Compare the polynomial at hand with both bounds of the branch; keep the first exit."""
        self.crossing.extent(degree)
        for side in range(-1, 2, 2):
            bound = self.net.bound(e, kind, side)
            if (side < 0 and self.crossing.low < bound) or (
                side > 0 and self.crossing.high > bound
            ):
                at = self.crossing.exit(
                    bound, side, degree, self.net.departing[_KINDS * e + kind] == side
                )
                if at < self.switch_at:
                    self.switch_at = at
                    self.switch_element = e
                    self.switch_kind = kind
                    self.switch_side = side

    def _land(self, h):
        """Shorten the attempt so that it ends on the switch found; Newton on the step itself."""
        e, kind = self.switch_element, self.switch_kind
        at = 4 * self.net.element_row[e]
        bound = self.net.bound(e, kind, self.switch_side)
        step = self.switch_at * h
        best = 1e300
        for _iteration in range(8):
            status = self.stepper.attempt(self.time, step)
            if status != 0:
                return status
            self.net.all_signals(self.time + step)
            self.net.row_derivatives(
                self.stepper.qb, self.stepper.vb, self.stepper.ab, self.stepper.jb, self.row_end
            )
            if kind == _CONTACT:
                self.net.unlimited_force(e, self.row_end, at)
                value, rate = self.net.force0, self.net.force1
            elif kind == _FRICTION and self.net.branch[_KINDS * e + _FRICTION] == 0:
                value, rate = self.net.multiplier[e], self.net.multiplier_rate[e]
            else:
                order = 1 if kind in (_DAMPER, _FRICTION) else 0
                value, rate = self.row_end[at + order], self.row_end[at + order + 1]
            miss = value - bound
            if miss == 0.0 or rate == 0.0 or fabs(miss) >= best:
                break
            best = fabs(miss)
            change = miss / rate
            new = step - change
            if not (0.0 < new <= h) or self.time + new == self.time + step:
                break
            step = new
        self.landed = step
        return 0

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
        h = self.step_end - self.step_start
        if h <= 0.0:
            for i in range(self.n):
                self.sample_q[i], self.sample_v[i] = self.qb[i], self.vb[i]
                self.sample_a[i] = self.ab[i]
            return
        x = (t - self.step_start) / h
        if self.stepper.method != 0:
            tau = x * h
            for i in range(self.n):
                slope = (self.ab[i] - self.aa[i]) / h
                self.sample_a[i] = self.aa[i] + tau * slope
                self.sample_v[i] = self.va[i] + tau * (self.aa[i] + tau * slope / 2.0)
                self.sample_q[i] = self.qa[i] + tau * (
                    self.va[i] + tau * (self.aa[i] / 2.0 + tau * slope / 6.0)
                )
            return
        for i in range(self.n):
            self.row_start[0], self.row_start[1] = self.qa[i], self.va[i]
            self.row_start[2], self.row_start[3] = self.aa[i], self.ja[i]
            self.row_end[0], self.row_end[1] = self.qb[i], self.vb[i]
            self.row_end[2], self.row_end[3] = self.ab[i], self.jb[i]
            self.crossing.hermite7(self.row_start, self.row_end, 0, h)
            self.crossing.read(x, h)
            self.sample_q[i] = self.crossing.value
            self.sample_v[i] = self.crossing.first
            self.sample_a[i] = self.crossing.second

    def sample_forces(self, t):
        """Accelerations and element forces at the instant sampled last, from the equation of motion.

        They go to `sample_a` and `sample_f`, in the branches of the last step: dry friction knows
        whether it slips or sticks, and then has the force that sticking takes; what has yielded
        knows its set, which goes to `sample_set`.
        """
        if self.in_step or self.step_end <= self.step_start:
            self.net.keep_branches()
        self.net.read_forces(
            t, self.sample_q, self.sample_v, self.sample_a, self.sample_f, self.sample_set
        )

    def residual_at(self, t):
        """What the energy balance lacks, J, carried linearly through the last step."""
        h = self.step_end - self.step_start
        if h <= 0.0:
            return self.residual_end
        x = (t - self.step_start) / h
        return self.residual_start + x * (self.residual_end - self.residual_start)

    def energies(self):
        """Where the energy is at the end of the last step, and where it has gone until then, J.

        Returns
        -------
        The kinetic energy, what each element stores, what each element has dissipated, and what each
        signal, as a road or as a load, has brought in.
        """
        net, work = self.net, self.stepper.work
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
        late = self.step_end - t if self.step_limited[e] else 0.0
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

        omega_max^2 is the largest eigenvalue of M^-1 K, found by Jacobi rotations of L^-1 K L^-T.
        """
        largest = max(_eigenvalues(self._symmetric_stiffness()))
        return 2.0 * sqrt(3.0 / largest) if largest > 0.0 else 0.0

    def _symmetric_stiffness(self):
        n = self.n
        k = [[self.stepper.stiffness[i * n + j] for j in range(n)] for i in range(n)]
        low = [[self.net.mass_factor[i * n + j] for j in range(n)] for i in range(n)]
        for i in range(n):  # L^-1 K, then (L^-1 (L^-1 K)')'
            for p in range(i):
                for j in range(n):
                    k[i][j] -= low[i][p] * k[p][j]
        for j in range(n):
            for p in range(j):
                for i in range(n):
                    k[i][j] -= low[j][p] * k[i][p]
        root = [sqrt(low[i][i]) for i in range(n)]
        return [[k[i][j] / (root[i] * root[j]) for j in range(n)] for i in range(n)]

    # -- whole state -------------------------------------------------------------------------------

    def _parts(self):
        s, net = self.stepper, self.net
        return (
            self.qa, self.va, self.aa, self.ja, self.qb, self.vb, self.ab, self.jb,
            s.q, s.v, s.a, s.j, s.work, self.limited_time, self.step_limited, net.segment, net.piece,
            net.branch, net.departing, net.signal_now, net.limited_count, s.multiplier,
            s.multiplier_rate, net.kept_branch, net.kept_set, net.kept_signal,
        )  # fmt: skip

    def snapshot(self):
        """The whole state as bytes, from which `restore` continues to the bit."""
        s, net = self.stepper, self.net
        head = pack(
            "<11d3q", self.time, self.step_start, self.step_end, self.grid_start, self.proposal,
            net.exchange, self.residual_start, self.residual_end, s.reach, self.first_reach,
            self.initial_energy, self.grid_index, self.step_count, self.in_step,
        )  # fmt: skip
        return head + b"".join(bytes(part) for part in self._parts())

    def restore(self, state):
        """Return to the state of a snapshot of the same system.

        Raises
        ------
        ValueError : a snapshot of another system.
        """
        s, net, parts = self.stepper, self.net, self._parts()
        at = 8 * 14
        if len(state) != at + sum(memoryview(part).nbytes for part in parts):
            raise ValueError("this state belongs to another system")
        (
            self.time, self.step_start, self.step_end, self.grid_start, self.proposal,
            net.exchange, self.residual_start, self.residual_end, s.reach, self.first_reach,
            self.initial_energy, self.grid_index, self.step_count, self.in_step,
        ) = unpack_from("<11d3q", state)  # fmt: skip
        for part in parts:
            view = memoryview(part).cast("B")
            view[:] = state[at : at + len(view)]
            at += len(view)
        self.event_count = 0
        self.log = []
        # tangents follow from the state; accelerations and multipliers are kept to the bit
        net.list_stuck()
        derived = [s.a, s.j, s.multiplier, s.multiplier_rate]
        kept = [bytes(part) for part in derived]
        s.refresh(self.time)
        for part, content in zip(derived, kept, strict=True):
            memoryview(part).cast("B")[:] = content


def _eigenvalues(matrix):
    """Eigenvalues of a small symmetric matrix, by cyclic Jacobi rotations."""
    n = len(matrix)
    m = [row[:] for row in matrix]
    for _sweep in range(30):
        off = max((abs(m[i][j]) for i in range(n) for j in range(i)), default=0.0)
        if off <= 1e-15 * max(abs(m[i][i]) for i in range(n)):
            break
        for i in range(n):
            for j in range(i):
                if m[i][j] != 0.0:
                    theta = (m[i][i] - m[j][j]) / (2.0 * m[i][j])
                    t = 1.0 / (abs(theta) + sqrt(theta * theta + 1.0))
                    t = t if theta >= 0.0 else -t
                    c = 1.0 / sqrt(t * t + 1.0)
                    s = t * c
                    for k in range(n):
                        m[k][i], m[k][j] = c * m[k][i] + s * m[k][j], c * m[k][j] - s * m[k][i]
                    for k in range(n):
                        m[i][k], m[j][k] = c * m[i][k] + s * m[j][k], c * m[j][k] - s * m[i][k]
    return [m[i][i] for i in range(n)]
