"""Macro steps chosen, cut at joints and switches, and accepted: the loop of the integrator.

Branches stay fixed within a step, in which the motion is therefore smooth; a step that would leave
a branch is cut short so that it ends on the switch, located to rounding.
"""

from __future__ import annotations

import cython

from .arrays import begin_apart, doubles, integers, vectors
from .cruise import Cruise
from .dense import Dense
from .exact import not_straight
from .ledger import Ledger
from .network import Network, numbers_of
from .stepper import METHODS, Stepper
from .switches import Switches
from .watch import LIMITS, POLICIES, UNLIMITED, Watch

if not cython.compiled:
    from math import fabs, pow, sqrt

# How a run of steps ended; 2 and more are keys of integrator.FAILURES.
_REACHED, _PAUSED, _DIVERGED, _STEP_TOO_SMALL = 0, 1, 2, 3
_UNSTABLE, _ENERGY_GROWS, _NO_TIME_PASSES, _OUT_OF_BALANCE = 6, 7, 8, 11

_CONTACT, _KINDS = 3, 5  # as in elements
_EVENT_CAPACITY = 512
_FLIPS = 24  # of branches at one instant, several elements being at their corners
_LINK = 1e4  # times the fastest frequency: a decay so fast is that of a rigid link
_FINE = 1e-4  # tolerances below it are reached faster at order 8 than at order 6
_PAUSE = 5000  # steps after which Python may look for signals, such as an interrupt
_STALLED = 100  # steps in which no time passes
_OVERRUNS = 1000  # of a run, each after so many steps
_LEAST_THETA = 1.37
_FAR = 1e8  # m, or as many times the scale of the run: a motion so large has diverged
_RUNAWAY = 1e4  # times that scale, and here it has if steps vanish besides
_EXCESS = 1.5  # times its share that the error of a step may be before it is made again
_FIRST_PHASE = 0.25  # of the fastest mode in the first step
_ROAD_PHASE = 1.5  # as in signals
_SHORT_PHASE = 1e-4  # of the quickest motion, over which its Taylor series is as good as a step
_READ_PHASE = 3.0  # of the quickest motion, over which the septic through a step is as good as it


class March:
    """Steps one system. What its parameters mean says `integrator.Integrator`, which adds the rest."""

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
        if method == "exact":
            _refuse_curved(system)
        if not theta >= _LEAST_THETA:
            raise ValueError(f"theta = {theta:g} must be at least {_LEAST_THETA:g}")
        self.wanted = method, step, tolerance, order
        columns = _columns(system, *self.wanted)
        begin_apart()
        self.net = Network(system)
        self.stepper = Stepper(self.net, method, columns, tolerance, theta)
        self.switches = Switches(self.stepper)
        if beyond_stable not in POLICIES:
            raise ValueError(f"beyond_stable {beyond_stable!r} is not one of {', '.join(POLICIES)}")
        limit = 0.0 if method in UNLIMITED else LIMITS[columns]
        self.watch = Watch(self.stepper, self.net, beyond_stable, limit)
        self.n = n = self.net.n
        plain = method in ("equilibrium", "mean", "tangent")
        self.dense = Dense(n, plain, method in ("mean", "tangent"))
        self.ledger = Ledger(self.net, self.dense)
        self.fixed_step = step
        self.landing, self.energy = landing, energy
        self.exact = method == "exact"  # it is right however little the ledger reads between steps
        self.controlled = method in ("extrapolated", "exact") and step == 0.0
        self.stepper.controlled = self.controlled
        self.no_error = (0.9 / 4.0) ** (2 * columns + 1)  # below it steps grow as much as they may
        self.most_error = _EXCESS if method == "extrapolated" else 1.0
        self.whole = Dense(n, False, False)  # an attempt in which a switch is looked for
        self.reads_switches = self.controlled and method == "extrapolated" and columns < 4
        # the ledger wants to see each step
        self.cruises = plain and step > 0.0 and landing and not energy and self.stepper.side_by_side
        self.cruise = Cruise(self.stepper, self.switches) if self.cruises else None
        self.sample_q, self.sample_v, self.sample_a = vectors(3, n)
        elements = self.net.elements
        self.sample_f, self.sample_set = vectors(2, elements)
        self.step_limited, self.limited_time = integers([0] * elements), doubles([0.0] * elements)
        self.contact_element = integers(
            e for e, element in enumerate(system.elements) if element.limit < 1e300
        )
        self.contacts = len(self.contact_element)
        self.event_count = self.event_base = self.flushed = 0
        self.event_time = doubles([0.0] * _EVENT_CAPACITY)
        self.event_what = integers([0] * 4 * _EVENT_CAPACITY)
        self.branch_before = integers([0] * _KINDS * elements)
        self.logged = []  # switches so far: (time, element, kind, from, to); the last ones wait
        self._stand_still(start, max(system.scales))
        self._begin()

    def fits(self, system):
        """Whether a system differs from the one before in its numbers alone."""
        return self.net.fits(system) and _columns(system, *self.wanted) == self.stepper.columns

    def row(self, system, displacements, velocities):
        """What `begin_row` reads of a system that fits, and of where it starts (m, m/s), as a list.

        Raises
        ------
        ValueError : a system that the method cannot take.
        """
        if self.stepper.method == METHODS["exact"]:
            _refuse_curved(system)
        return [max(system.scales), *displacements, *velocities, *numbers_of(system)]

    def begin_row(self, x, at, start):
        """Begin anew with the system and state whose `row` stands in x from `at` on.

        All is then as in a new integrator of that system with the same method, step and tolerance, but
        for the log, which goes on. 1 if the mass matrix is not positive definite.
        """
        self.event_base = self.event_count
        self.filled = self.step_count = 0
        self.time = start
        if self.net.enter_system(x, at + 1 + 2 * self.n) != 0:
            return 1
        self._stand_still(start, x[at])
        self._begin()
        for i in range(2 * self.n):
            if x[at + 1 + i] != 0.0:
                self._enter_state(x, at + 1)
                return 0
        return 0

    def _enter_state(self, x, at):
        """Start from the displacements and velocities that stand in x from `at` on."""
        for i in range(self.n):
            self.stepper.q[i] = x[at + i]
            self.stepper.v[i] = x[at + self.n + i]
        self.stepper.count_from_here()
        self.in_step = True
        self._begin()

    def _stand_still(self, time, reach):
        """Stand still in equilibrium, before anything has happened."""
        self.stalled = self.overruns = self.filled = self.since_pause = 0
        self.time = self.grid_start = time
        self.grid_index = self.step_count = 0
        self.proposal = 0.0
        self.in_step = True  # whether the branches are still those of the last step
        self.scale = reach
        for e in range(self.net.elements):
            self.step_limited[e] = 0
            self.limited_time[e] = 0.0
        self.net.forget()
        self.net.enter_segments(time)
        self.stepper.start(reach)
        self.watch.start()
        self.ledger.start()

    def _begin(self):
        """Branches, accelerations and energy of the present state, which both ends of the step show."""
        self.net.settle(self.time, self.stepper.q, self.stepper.v)
        self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
        self._enter_branches()
        for i in range(self.n):
            self.dense.qa[i] = self.dense.qb[i] = self.stepper.q[i]
            self.dense.va[i] = self.dense.vb[i] = self.stepper.v[i]
            self.dense.aa[i] = self.dense.ab[i] = self.stepper.a[i]
            self.dense.ja[i] = self.dense.jb[i] = self.stepper.j[i]
            self.stepper.drift[i] = 0.0
        self.dense.start = self.dense.end = self.time
        self.net.row_states(self.stepper.q, self.stepper.v)
        self.ledger.initial_energy = self.net.energy(self.stepper.v)

    def _enter_branches(self):
        """Everything that follows from the branches, after any of them has changed."""
        self.stepper.refresh(self.time)
        self.switches.enter_branches()
        self.entered = 1

    def _advance(self, until, stop):
        while self.time < until:
            events = self.event_count - self.event_base
            if events > _EVENT_CAPACITY // 2 or self.since_pause >= _PAUSE:
                return _PAUSED
            if self.cruises and not self.entered and self._cruise(until, stop):
                if self._has_diverged():
                    return _DIVERGED
                continue
            self.since_pause += 1
            before = self.time
            status = self._step(until if stop else 1e300)
            if status != 0:
                return status
            if self._passes(self.time - before):
                self.stalled = 0
            else:
                self.stalled += 1
                if self.stalled > _STALLED:
                    status = self._overrun(until if stop else 1e300)
                    if status != 0:
                        return status
        return _REACHED

    def _passes(self, h):
        """Whether h is time that passes, and no rounding of it."""
        return h > 1e-13 * (fabs(self.time) + 1e-3)

    def _overrun(self, latest):
        """Where ever more switches follow one another while no time passes: go a little beyond.

        For a ten-thousandth of the quickest motion the present branches go on whatever corner is
        passed; the state there says which ones follow. Forces being continuous over their corners,
        what that does to the motion goes with the square of so short a time. A run that needs this
        more than a thousand times is refused.
        """
        self.stalled = 0
        self.overruns += 1
        joint = self.net.next_joint()
        end = min(joint, latest)
        h = _SHORT_PHASE / (self.stepper.quickest + 1.0)
        if self.overruns > _OVERRUNS:
            return _NO_TIME_PASSES
        to_end = self.time + h >= end
        if to_end:
            h = end - self.time
        status = self.stepper.attempt(self.time, h)
        if status != 0:
            return status
        self._accept(h, end if to_end else self.time + h)
        if to_end and end == joint:
            self._pass_joint()
        before = self._energy_now()
        self._relocate(True)
        self.net.exchange += self.net.energy(self.stepper.v) - before
        self._enter_branches()
        return 0

    def _energy_now(self):
        """Kinetic energy and what the elements store in their present branches."""
        self.net.all_signals(self.time)
        self.net.row_states(self.stepper.q, self.stepper.v)
        return self.net.energy(self.stepper.v)

    def _relocate(self, flows):
        """Choose the branches by the state, and if wanted those of flow; what changes is noted."""
        self._remember_branches()
        if flows:
            self.net.follow(self.time, self.stepper.q, self.stepper.v)
        else:
            self.net.locate_branches(self.time, self.stepper.q, self.stepper.v)
        self._note_changes()

    def _remember_branches(self):
        """What the branches are before others are chosen."""
        self._leave_step()
        for i in range(_KINDS * self.net.elements):
            self.branch_before[i] = self.net.branch[i]

    def _note_changes(self):
        for i in range(_KINDS * self.net.elements):
            if self.net.branch[i] != self.branch_before[i]:
                self._note(i // _KINDS, i % _KINDS, self.branch_before[i], self.net.branch[i])

    def _proposed_step(self):
        """The step the method wants, before joints and switches cut it."""
        if self.fixed_step > 0.0:
            # the grid is counted, not summed, so that it does not drift
            target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            while target <= self.time + 1e-9 * self.fixed_step:
                self.grid_index += 1
                target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            h = target - self.time
            rounding = 1e-11 + 4e-16 * fabs(self.time) / self.fixed_step
            if fabs(h / self.fixed_step - 1.0) < rounding:
                h = self.fixed_step  # to the bit, so that what was factorised for it is kept
            return self.watch.fit(self.time, h)
        omega = sqrt(self.stepper.omega_squared)
        road = self.net.road_limit(self.time)
        self.stepper.road_rate = _ROAD_PHASE / road if road > 0.0 else 0.0
        if not self.controlled:
            # the period error of the linear-acceleration method is (omega h)^2 / 24
            h = sqrt(self.stepper.tolerance) / omega if omega > 0.0 else road
        else:
            h = self.proposal if self.proposal > 0.0 else _FIRST_PHASE / (omega + 1.0)
            h = self.stepper.bound(h)
        return road if h > road else h

    def _step(self, latest):
        """One accepted macro step, cut at joints and switches."""
        h = self._proposed_step()
        if h == 0.0:
            return _UNSTABLE
        flips = 0
        longer = 0.0  # the step that the last attempt would have next, by its error
        while True:
            joint = self.net.next_joint()
            end = joint if joint < latest else latest
            to_end = 0
            if self.time + h * (1.0 + 1e-9) >= end:
                h = end - self.time
                to_end = 1
            if not (to_end or h > 4e-16 * (fabs(self.time) + 1e-3)):
                runs_away = self.stepper.reach > _RUNAWAY * self.scale
                return _DIVERGED if runs_away else _STEP_TOO_SMALL
            status = self.stepper.attempt(self.time, h)
            if status != 0:
                h *= 0.25
                if self.fixed_step > 0.0 or h < 1e-14:
                    return status
                continue
            if self.controlled and self.stepper.error > self.most_error:
                h *= self._factor_for_error()
                continue
            at = self.switches.first(self.time, h) if self.landing else 2.0
            if at == 0.0 and flips >= _FLIPS:
                # one branch after the other is left at once
                if self.controlled:
                    return self._overrun(latest)
                self.overruns += 1
            elif at == 0.0:
                # the branch is left at once: it was the wrong side of its bound
                flips += 1
                self._switch(self.switches.element, self.switches.kind, self.switches.side)
                self._enter_branches()
                continue
            # a step that a joint cut short says nothing against longer ones
            if self.controlled and (not to_end or h > self.proposal > 0.0):
                longer = h * self._factor_for_error()
            landed = 0
            if 0.0 < at <= 1.0:
                status = self._land(h)
                if status != 0:
                    h *= 0.25
                    if h < 1e-14:
                        return status
                    continue
                h = self.landed
                landed = not (self.switches.recedes or self.switches.only_opens)
                self.switches.start_known = 0  # of the shortened step
                to_end = to_end and self.time + h >= end
            break
        if longer > 0.0:
            self.proposal = longer
        self._accept(h, end if to_end else self.time + h)
        self.switches.carry_on()
        if landed:
            self._switch(self.switches.element, self.switches.kind, self.switches.side)
        if to_end and end == joint:
            self._pass_joint()
        if not self.landing:
            self._relocate(True)
        if landed or to_end or not (self.landing and self.stepper.affine):
            self._enter_branches()
        if self._has_diverged():
            return _DIVERGED
        if self.energy and self.ledger.grows():
            return _ENERGY_GROWS
        if self.energy and not self.exact and self.ledger.is_out_of_balance():
            return _OUT_OF_BALANCE
        return _REACHED

    def _has_diverged(self):
        return not self.stepper.reach < _FAR * max(self.scale, 1.0)

    def _cruise(self, until, stop):
        """Fixed steps in a linear branch, as many as come before a switch; whether there were any."""
        h = self._proposed_step()
        if h != self.fixed_step or not self.cruise.enter(h):
            return 0
        end = self.net.next_joint()
        if stop and until < end:
            end = until
        self.cruise.begin(self.time)
        self.cruise.go(self.grid_start, self.grid_index, until, end, _PAUSE - self.since_pause)
        if self.cruise.taken == 0:
            return 0
        for i in range(self.n):
            self.dense.qa[i] = self.cruise.q0[i]
            self.dense.va[i] = self.cruise.v0[i]
            self.dense.aa[i] = self.cruise.a0[i]
            self.stepper.qb[i] = self.cruise.q[i]
            self.stepper.vb[i] = self.cruise.v[i]
        self.stepper.shift_end(self.cruise.time, 0.0)  # finds the jerk there
        for i in range(self.n):
            self.dense.qb[i] = self.stepper.q[i] = self.cruise.q[i]
            self.dense.vb[i] = self.stepper.v[i] = self.cruise.v[i]
            self.dense.ab[i] = self.stepper.a[i] = self.cruise.a[i]
            self.dense.jb[i] = self.stepper.j[i] = self.stepper.jb[i]
        self.stepper.reach = self.cruise.reach
        self._count_limited(h, self.cruise.taken)
        self.in_step = True
        self.dense.start, self.dense.end = self.cruise.start, self.cruise.time
        self.dense.known = 0
        self.switches.start_known = 0
        self.time = self.cruise.time
        self.step_count += self.cruise.taken
        self.since_pause += self.cruise.taken
        self.stalled = 0
        return 1

    def _count_limited(self, h, steps):
        """How long elements have been at their limit, step by step."""
        for k in range(self.contacts):
            i = self.contact_element[k]
            self.step_limited[i] = self.net.branch[_KINDS * i + _CONTACT]
            if self.step_limited[i]:
                for _step in range(steps):
                    self.limited_time[i] += h

    def _pass_joint(self):
        """Signals enter their next segments; what a jump of a road does is work of that road."""
        self._leave_step()
        before = self._energy_now()
        jumped = False
        for s in range(self.net.signals):
            jump = self.net.enter_segment(s, self.time)
            if jump != 0.0:
                jumped = True
                self.net.kerb(s, jump, self.stepper.v)
                self._relocate(False)
                now = self.net.energy(self.stepper.v)
                self.ledger.bring_in(s, now - before)
                before = now
        if not jumped:
            self._remember_branches()
            self.net.follow_slips(self.time, self.stepper.q, self.stepper.v)
            self._note_changes()

    def _factor_for_error(self):
        """Change of step that brings the error to the tolerance."""
        if self.stepper.error <= self.no_error:
            return 4.0
        factor = 0.9 * pow(self.stepper.error, -1.0 / self.stepper.error_order)
        return min(max(factor, 0.2), 4.0)

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
        self.stepper.reach = self.stepper.reach_at(self.stepper.q)
        self._count_limited(h, 1)
        # an element that has just switched still departs while others switch at the same instant
        if self.entered and self._passes(h):
            self.entered = 0
            self.net.clear_marks()
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
        """Shorten the attempt so that it ends on the switch found: Newton, at last along Taylor.

        Under error control with two or three columns the state there is read, in a linear branch, off
        the septic through the ends of the attempt, which is right to their order as long as nothing in
        it is over sooner, as what is strongly damped; otherwise the step is made again, and may then
        not reach the bound: long steps are less right than short ones. Such a step counts, but ends on
        no switch; nor does one cut short because a gap opens in it.
        """
        step = self.switches.at * h
        reads = (
            self.reads_switches and self.stepper.affine and h * self.stepper.quickest < _READ_PHASE
        )
        if reads:
            self._keep_attempt(h)
        status = self._end_at(step, reads)
        self.switches.recedes = False
        best = 1e300
        for _iteration in range(0 if self.switches.only_opens else 8):
            if status != 0:
                return status
            late = self.switches.lateness(self.time + step)
            if self.switches.recedes:
                break
            new = step - late
            if late == 0.0 or self.switches.miss >= best or not (0.0 < new <= h):
                break
            if self.time + new == self.time + step:
                break
            best = self.switches.miss
            if fabs(late) * self.stepper.quickest < _SHORT_PHASE:
                self.stepper.shift_end(self.time + new, -late)
            else:
                status = self._end_at(new, reads)
            step = new
        self.landed = step
        return status

    def _end_at(self, step, reads):
        """An attempt that ends after `step`, read off the one kept or made again."""
        if not reads:
            return self.stepper.attempt(self.time, step)
        self.stepper.stop_within(self.time + step, self.whole)
        return 0

    def _keep_attempt(self, h):
        for i in range(self.n):
            self.whole.qa[i], self.whole.qb[i] = self.stepper.q[i], self.stepper.qb[i]
            self.whole.va[i], self.whole.vb[i] = self.stepper.v[i], self.stepper.vb[i]
            self.whole.aa[i], self.whole.ab[i] = self.stepper.a[i], self.stepper.ab[i]
            self.whole.ja[i], self.whole.jb[i] = self.stepper.j[i], self.stepper.jb[i]
        self.whole.start, self.whole.end = self.time, self.time + h
        self.whole.known = 0

    def _switch(self, e, kind, side):
        """Element e enters the neighbouring branch, now; the event is noted."""
        self._leave_step()
        before = self.net.branch[_KINDS * e + kind]
        new = self.net.enter(e, kind, side, self.time, self.stepper.q, self.stepper.v)
        if self.net.yields[e] and kind < _CONTACT:
            before = new - side  # a rate that turns ends the flow of the spring
        self._note(e, kind, before, new)

    def _note(self, e, kind, before, after):
        """Element e has gone from one branch to another, now."""
        k = self.event_count
        if k < _EVENT_CAPACITY:
            self.event_time[k] = self.time
            self.event_what[4 * k] = e
            self.event_what[4 * k + 1] = kind
            self.event_what[4 * k + 2] = before
            self.event_what[4 * k + 3] = after
            self.event_count += 1

    def _leave_step(self):
        """Branches are about to change: remember those of the step that ends here, to read it off."""
        if self.in_step:
            self.net.keep_branches()
            self.in_step = False


def _columns(system, method, step, tolerance, order):
    """How many columns the extrapolation has."""
    if method == "exact":
        return 4
    if method != "extrapolated":
        return 1
    if order:
        return order // 2
    return 4 if tolerance < _FINE or step > 0.0 or _is_stiffly_damped(system) else 3


def _is_stiffly_damped(system):
    """Whether a damper acts like a rigid link beside what swings: c b'M^-1 b >> omega_max.

    Order 8 damps such a motion in every step, order 6 hardly (see `stepper`). M counts by its diagonal.
    """
    fastest = 0.0
    for element in system.elements:
        fastest += abs(element.spring.tangent(0.0)) * _mobility(system, element)
    for element in system.elements:
        for piece in element.damper.pieces:
            rate = abs(piece.coefficients[1]) + abs(piece.saturation) / piece.scale
            decay = rate * _mobility(system, element)
            if decay * decay > _LINK * _LINK * fastest:
                return True
    return False


def _mobility(system, element):
    return sum(b * b / system.mass[i][i] for i, b in enumerate(element.direction))


def _refuse_curved(system):
    why = not_straight(system)
    if why:
        raise ValueError(f"method 'exact' cannot take this system: {why}")
