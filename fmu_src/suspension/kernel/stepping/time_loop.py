"""The loop of the integrator: choose macro steps, end them at joints and switches, accept them.

Branches are fixed within a step, so the motion within it is smooth. A step that would leave a branch
is shortened to end on the switch, which is located to rounding.
"""

from __future__ import annotations

from array import array
from math import fabs, sqrt
from typing import TYPE_CHECKING

from ..energy.ledger import Ledger
from ..language import Doubles, Numbers, inline, of_python
from ..layout import BRANCHES, FRICTION, UNBOUNDED
from ..methods.registry import METHODS
from ..methods.stepper import Stepper
from ..motion.dense import Dense
from ..network.network import Network, add_numbers
from ..network.signals import ROAD_PHASE
from ..outcomes import (
    AT_STEPS,
    DIVERGED,
    HALTED,
    NO_TIME_PASSES,
    PAUSED,
    REACHED,
    STEP_TOO_SMALL,
    UNSTABLE,
)
from ..switching.knots import Knots
from ..switching.landing import Landing
from ..switching.limited import Limited
from ..switching.switch_log import SwitchLog
from ..switching.switches import Switches
from ..switching.transitions import Transitions
from .pace import PAUSE, Pace
from .reading import Reading
from .stability import POLICIES, StabilityMonitor
from .trial import Trial

if TYPE_CHECKING:
    from ...systems import System

_AGAIN, _STALLS = -2, -3  # of attempts, see `_try`
_FLIPS = 24  # changes of branch at one instant, when several elements are at their corners
_STALLED = 100  # consecutive steps in which no time passes
_OVERRUNS = 1000  # overruns (see `_overrun`) allowed in a run
_LEAST_THETA = 1.37
_ORDERS = (0, 2, 4, 6, 8)
_FAR = 1e8  # m, or times the scale of the run: a larger motion has diverged
_RUNAWAY = 1e4  # times that scale: a larger motion has diverged if steps vanish, too
_DECAY_PHASE = 1.0  # of the fastest motion in a step after a switch, where it may decay
_FIRST_PHASE = 0.25  # phase of the fastest mode in the first step
_OVERRUN_PHASE = 1e-4  # of the fastest motion: the length of a step beyond such a point
_KNOTS = 4  # attempts to end a step on its first knot
_CHECKED = 8  # steps between two checks of the balance of energy, which costs a tenth of a step
_AFTER_KNOT = 0.85  # least part of the step proposed before one that a point shortens, for the next


class TimeLoop:
    """Step one system; see `integrator.Integrator` for the parameters."""

    halts: int

    def __init__(
        self,
        system: System,
        method: str = "extrapolated",
        step: float = 0.0,
        tolerance: float = 1e-6,
        start: float = 0.0,
        order: int = 0,
        landing: bool = True,
        energy: bool = True,
        theta: float = 1.4,
        beyond_stable: str = "substep",
    ) -> None:
        if method not in METHODS:
            raise ValueError(f"method {method!r} is not one of {', '.join(METHODS)}")
        if not theta >= _LEAST_THETA:
            raise ValueError(f"theta = {theta:g} must be at least {_LEAST_THETA:g}")
        if order not in _ORDERS:
            raise ValueError(f"order = {order!r} is not one of 0 (automatic), 2, 4, 6, 8")
        if not 0.0 <= step < UNBOUNDED:
            raise ValueError(f"step = {step:g} s must be finite and positive, or 0 (automatic)")
        if not 0.0 < tolerance < 1.0:
            raise ValueError(f"tolerance = {tolerance:g} must be greater than 0 and less than 1")
        if not fabs(start) < UNBOUNDED:
            raise ValueError(f"start = {start:g} s must be finite")
        if len(system.scales) != len(system.mass):
            raise ValueError(
                f"{len(system.scales)} scales for {len(system.mass)} coordinates: each coordinate needs "
                "a typical displacement, such as 0.01 m"
            )
        if not all(0.0 <= scale < UNBOUNDED for scale in system.scales):
            raise ValueError(f"scales = {system.scales} must be finite and at least 0, in m")
        self.method_name = method
        self.refuse(system, start)
        self.wanted = step, tolerance, order
        kind = METHODS[method]
        order = kind.order_of(system, *self.wanted)
        # fixed steps of higher order keep their order only if they end where the second derivative jumps
        self.net = Network(system, joins=step == 0.0 or order == 2)
        self.stepper = Stepper(self.net, kind, order, tolerance, theta)
        self.motion, self.errors = self.stepper.motion, self.stepper.errors
        self.state = self.net.state
        self.switches = Switches(self.stepper)
        self.knots, self.trial, self.pace = Knots(self.switches), Trial(), Pace(self.state)
        if beyond_stable not in POLICIES:
            raise ValueError(f"beyond_stable {beyond_stable!r} is not one of {', '.join(POLICIES)}")
        self.monitor = StabilityMonitor(
            self.stepper.modes, beyond_stable, self.stepper.method.limit
        )
        memory = self.net.memory
        self.dense = Dense(
            memory,
            self.state.memory,
            self.motion,
            self.stepper.method.cubic,
            self.stepper.method.to_end,
        )
        self.ledger = Ledger(self.stepper.balance, self.stepper.rows, self.dense)
        self.fixed_step = step
        self.ends_on_switches, self.energy = landing, energy
        self.halts = 0  # set by a host that must see every switch, or every step
        self.errors.controlled = self.stepper.method.controls and step == 0.0
        self.errors.full_growth_error = (0.9 / 4.0) ** (order + 1)
        self.landing = Landing(self.switches, memory)
        # the result at the last sampled instant
        self.reading = Reading(self.net)
        self.limited = Limited(
            self.net, [e for e, element in enumerate(system.elements) if element.limit < UNBOUNDED]
        )
        # in a step every element may change all its branches, and again at a jump of each signal
        changes = BRANCHES * self.net.elements.count * (self.net.signals.count + 2)
        self.noted = SwitchLog(memory, changes)
        self.transitions = Transitions(
            memory, self.net, self.motion, self.ledger, self.limited, self.noted
        )
        self._stand_still(float(start), max(system.scales))
        self._begin()
        self.net.place_moving()
        self._make_room()

    @of_python
    def _make_room(self) -> None:
        """Allocate what a class derived from this one needs."""

    @of_python
    def fits(self, system: System) -> bool:
        """Return whether a system differs from the present one only in its numbers."""
        return (
            self.net.fits(system)
            and METHODS[self.method_name].order_of(system, *self.wanted)
            == self.stepper.method.order
        )

    @of_python
    def refuse(self, system: System, start: float) -> None:
        """Refuse a system that the method cannot integrate, or whose kerbs push without limit.

        `start` is when its motion starts, or goes on, s: kerbs until then have no effect.
        """
        why = METHODS[self.method_name].refusal(system)
        if why:
            raise ValueError(
                f"method {self.method_name!r} cannot integrate this system: {why}; use 'extrapolated'"
            )
        for kerb in system.kerbs_without_limit(start):
            raise ValueError(f"system: {kerb}")

    @of_python
    def row(
        self,
        system: System,
        displacements: Numbers,
        velocities: Numbers,
        start: float = -UNBOUNDED,
    ) -> list[float]:
        """Return what `begin_row` reads: the numbers of a system that fits, and its start (m, m/s).

        In this list they may be numbers that record operations (see `trace`). `start` is the start time,
        s, before which it cannot be.

        Raises
        ------
        ValueError : if the method cannot integrate the system.
        """
        numbers: list[float] = []
        self.add_row(numbers, system, displacements, velocities, start)
        return numbers

    @of_python
    def add_row(
        self,
        numbers: list[float] | array[float],
        system: System,
        displacements: Numbers,
        velocities: Numbers,
        start: float = -UNBOUNDED,
    ) -> None:
        """Add the same to an array of doubles.

        Raises
        ------
        ValueError : if the method cannot integrate the system; then nothing is added.
        """
        self.refuse(system, start)
        numbers.extend([max(system.scales), *displacements, *velocities])
        add_numbers(system, numbers)

    def begin_row(self, x: Doubles, at: int, start: float) -> int:
        """Start again with the system and state whose `row` is in x[at:].

        The state is then that of a new integrator of the system with the same method, step and
        tolerance, but the log continues. Return 1 if the mass matrix is not positive definite.
        """
        self.noted.begin_row()
        self.net.laws.forget_failures()
        self.state.step_count = 0
        self.state.time = start
        if self.net.enter_system(x, at + 1 + 2 * self.net.series.outer) != 0:
            return 1
        self._stand_still(start, x[at])
        self._begin()
        for i in range(2 * self.net.series.outer):
            if x[at + 1 + i] != 0.0:
                self._enter_state(x, at + 1)
                return 0
        return 0

    def _enter_state(self, x: Doubles, at: int) -> None:
        """Start from the displacements and velocities in x[at:], with springs in series relaxed."""
        self.net.find_datum(self.state.time, self.state.scale)
        for i in range(self.net.n):
            self.motion.q[i] = self.motion.v[i] = 0.0
        for i in range(self.net.series.outer):
            self.motion.q[i] = x[at + i] - self.state.datum
            self.motion.v[i] = x[at + self.net.series.outer + i]
        self.motion.count_from_here()
        self.state.in_step = True
        self.net.laws.forget_failures()
        self._begin()

    def _stand_still(self, time: float, reach: float) -> None:
        """Reset to rest in equilibrium."""
        self.motion.start()
        self.net.signals.set_datum(0.0)
        for e in range(self.net.elements.count):
            self.ledger.work[e] = self.limited.time[e] = 0.0
        self._restart(time, reach)

    def _restart(self, time: float, reach: float) -> None:
        """Discard all earlier branches and steps, but not the motion and the works of elements."""
        self.pace.since_pause = 0
        self.state.stand_still(time, reach)
        self.motion.forget()
        self.net.forget()
        self.net.enter_segments(time)
        self.stepper.modes.start()
        self.monitor.start()
        self.ledger.start()

    def _begin(self) -> None:
        """Find branches, accelerations and energy of the present state, and set both ends of the step."""
        self.net.branches.settle(self.state.time, self.motion.q, self.motion.v)
        self.net.branches.locate_branches(self.state.time, self.motion.q, self.motion.v)
        self._enter_branches()
        self._break_loose()
        for i in range(self.net.n):
            self.dense.qa[i] = self.dense.qb[i] = self.motion.q[i]
            self.dense.va[i] = self.dense.vb[i] = self.motion.v[i]
            self.dense.aa[i] = self.dense.ab[i] = self.motion.a[i]
            self.dense.ja[i] = self.dense.jb[i] = self.motion.j[i]
            self.motion.drift[i] = 0.0
        self.dense.start = self.dense.end = self.state.step_start = self.state.time
        self.net.elements.row_states(self.motion.q, self.motion.v)
        self.state.initial_energy = self.net.energy(self.motion.v) - self.state.exchange

    def _break_loose(self) -> None:
        """Let elements slip whose force of sticking exceeds its limit, the most overloaded first."""
        for _flip in range(_FLIPS):
            most = 0.0
            loose = -1
            for p in range(self.net.branches.stuck):
                e = self.net.branches.stuck_element[p]
                over = fabs(self.motion.multiplier[e]) - self.net.branches.breakaway[e]
                if over > most:
                    most, loose = over, e
            if loose < 0:
                return
            side = 1 if self.motion.multiplier[loose] > 0.0 else -1
            self.net.branches.enter(
                loose, FRICTION, side, self.state.time, self.motion.q, self.motion.v
            )
            self._enter_branches()

    def _enter_branches(self) -> None:
        """Update everything that depends on the branches and the segments of signals."""
        self.trial.joint = self.net.signals.next_joint()
        self.stepper.refresh(self.state.time)
        self.switches.enter_branches()
        if self.stepper.balance.bends.joined:
            self.knots.enter_branches()
        self.limited.enter()
        if self.energy:
            self.ledger.enter()
        self.state.entered = True

    def step_until(self, until: float, stop: bool) -> int:
        """Step until `until` is reached or passed, or exactly to it if `stop`.

        Return 0, `PAUSED`, `HALTED`, or the key in `outcomes.FAILURES` of the reason why the run ended.
        """
        while self.state.time < until:
            events = self.noted.logged
            if self.noted.is_half_full() or self.pace.since_pause >= PAUSE:
                return PAUSED
            self.pace.since_pause += 1
            before = self.state.time
            status = self._step(until if stop else UNBOUNDED)
            if status != 0:
                return status
            if self._passes(self.state.time - before):
                self.state.stalled = 0
            else:
                self.state.stalled += 1
                if self.state.stalled > _STALLED and self.state.time < until:
                    status = self._overrun(until if stop else UNBOUNDED)
                    if status != 0:
                        return status
            if self.halts != 0 and (self.halts == AT_STEPS or self.noted.logged > events):
                return HALTED
        return REACHED

    @inline
    def _passes(self, h: float) -> bool:
        """Return whether h is more than the rounding of time."""
        return h > 1e-13 * (fabs(self.state.time) + 1e-3)

    def _overrun(self, latest: float) -> int:
        """Step slightly beyond a point where switches follow one another without time between them.

        The present branches are kept for 1/10000 rad of the fastest motion, whichever corners are passed;
        the state at the end determines the next branches. As forces are continuous at corners, the error
        is proportional to the square of this short time. A run that needs more than a thousand such
        steps is stopped.
        """
        self.state.stalled = 0
        self.state.overruns += 1
        joint = self.trial.joint
        end = min(joint, latest)
        h = _OVERRUN_PHASE / (self.stepper.modes.quickest + 1.0)
        if self.state.overruns > _OVERRUNS:
            return NO_TIME_PASSES
        to_end = self.state.time + h >= end
        if to_end:
            h = end - self.state.time
        status = self.stepper.attempt(self.state.time, h)
        if status != 0:
            return status
        self._accept(h, end if to_end else self.state.time + h)
        if to_end and end == joint:
            self.transitions.pass_joint()
        before = self.transitions.energy()
        self.transitions.relocate(True)
        self.state.exchange += self.net.energy(self.motion.v) - before
        self._enter_branches()
        return 0

    def _resume(self, content: bytes) -> None:
        """Continue from an earlier content of the state."""
        datum = self.state.datum
        self.state.put_back(content)
        self._follow_state(datum)
        self.state.put_back(content)  # so that accelerations, too, are exactly those of the content

    def _follow_state(self, before: float) -> None:
        """Find the numbers outside the state, which was put back; their heights refer to `before`."""
        datum, self.state.datum = self.state.datum, before
        self.net.signals.set_datum(datum)
        self.net.put_moving_back()
        self.dense.start, self.dense.end = self.state.step_start, self.state.time
        self.dense.known = False
        self.noted.start()
        self.net.branches.list_stuck()
        self._enter_branches()

    # -- steps ---------------------------------------------------------------------------------------

    @inline
    def _proposed_step(self) -> float:
        """Return the step chosen by the method, before joints and switches shorten it.

        It is 0 if a fixed step is not stable, and -1 if it is below the rounding of time.
        """
        if self.fixed_step > 0.0:
            step, time = self.fixed_step, self.state.time
            # the grid is counted, not summed, so that it does not drift
            target = self.state.grid_start + (self.state.grid_index + 1) * step
            # of many short steps the rounding of time is the larger one
            rounding = 4e-16 * fabs(time)
            close = 1e-9 * step + rounding
            if close > 0.5 * step:
                return -1.0
            while target <= time + close:
                self.state.grid_index += 1
                target = self.state.grid_start + (self.state.grid_index + 1) * step
            h = target - time
            if fabs(h - step) < 1e-11 * step + rounding:
                h = step  # exactly, so that its factorisation is reused
            return self.monitor.fit(time, h)
        omega = sqrt(self.stepper.modes.omega_squared)
        road = self.net.signals.road_limit(self.state.time)
        self.stepper.modes.road_rate = ROAD_PHASE / road if road > 0.0 else 0.0
        if not self.errors.controlled:
            # the period error of the linear-acceleration method is (omega h)^2 / 24
            h = sqrt(self.errors.tolerance) / omega if omega > 0.0 else road
            if not self.stepper.method.exact:
                h = min(h, self.errors.longest_by_jerk())
            h = self._while_decaying(h)
        else:
            h = self.state.proposal if self.state.proposal > 0.0 else _FIRST_PHASE / (omega + 1.0)
            h = self.stepper.modes.bound(h, self.stepper.method.least_damping)
            if self.state.entered:
                h = min(h, self.errors.longest_after_switch())
        return road if h > road else h

    def _while_decaying(self, h: float) -> float:
        """Return the step h, or a shorter one after a switch or joint if a fast motion may then decay.

        The linear-acceleration method multiplies a decay exp(-d t) by (1 - d h / 2) / (1 + d h / 2). Long
        steps reverse its sign and hardly damp it; those of Wilson's method overshoot. So the first step
        resolves the decay, and each of the next steps is at most twice as long as the one before.
        """
        if h * self.stepper.modes.quickest <= _DECAY_PHASE:
            return h
        last = 0.0 if self.state.entered else self.dense.end - self.dense.start
        return min(h, max(2.0 * last, _DECAY_PHASE / self.stepper.modes.quickest))

    @inline
    def _step(self, latest: float) -> int:
        """Take one accepted macro step, ended at joints and switches."""
        h = self._proposed_step()
        if h <= 0.0:
            return UNSTABLE if h == 0.0 and self.fixed_step > 0.0 else STEP_TOO_SMALL
        self.trial.begin(h)
        if self.errors.controlled and self.stepper.balance.bends.joined:
            shorter = self.knots.ahead(h, min(self.trial.joint, latest))
            self.trial.length, self.trial.on_knot = shorter, shorter < h
        status = _AGAIN
        while status == _AGAIN:
            self.trial.stop_at(latest, self.state.time)
            shortest = 4e-16 * (fabs(self.state.time) + 1e-3)
            if not (self.trial.to_end or self.trial.length > shortest):
                runs_away = self.state.reach > _RUNAWAY * self.state.scale
                return DIVERGED if runs_away else STEP_TOO_SMALL
            status = self._try()
        if status == _STALLS:
            return self._overrun(latest)
        return self._finish() if status == REACHED else status

    @inline
    def _try(self) -> int:
        """Attempt the step.

        Return 0 if it is accepted, `_AGAIN` if it is to be tried with the length that it then has,
        `_STALLS` if one branch after the other is left at once, or the reason why it failed.
        """
        status = self.stepper.attempt(self.state.time, self.trial.length)
        if self.net.laws.failed:
            status = DIVERGED
        if status != 0:
            self.trial.length *= 0.25
            return status if self.fixed_step > 0.0 or self.trial.length < 1e-14 else _AGAIN
        if self.errors.controlled and self._shortens():
            return _AGAIN
        if self.trial.on_knot and not self.trial.to_end:
            self._meet_knot()
        at = 2.0
        if self.ends_on_switches:
            at = self.switches.first(self.state.time, self.trial.length)
        if at == 0.0:
            if self.trial.flips < _FLIPS:
                # the branch is left at once: it was on the wrong side of its bound
                self.trial.flips += 1
                self.transitions.switch(
                    self.switches.element, self.switches.kind, self.switches.side
                )
                self._enter_branches()
                return _AGAIN
            if self.errors.controlled:
                return _STALLS
            self.state.overruns += 1
        if self.errors.controlled:
            self._look_ahead()
        return self._end_on_switch() if 0.0 < at <= 1.0 else REACHED

    def _meet_knot(self) -> None:
        """Continue an attempt that ends just before a point of a smooth table to that, if possible."""
        h = self.trial.length
        step = self.knots.met(h)
        reaches = step != h and self.state.time + step < self.trial.end
        if reaches and self.landing.extend_to(step, h):
            self.trial.length = step

    def _shortens(self) -> bool:
        """Shorten the step to a point of a smooth table, or for its error, and return whether it is."""
        if self.trial.cuts < _KNOTS and self.stepper.balance.bends.joined:
            self.trial.cuts += 1
            cut = self.knots.within(self.trial.length)
            if cut < self.trial.length:
                self.trial.on_knot = True
                self.trial.length = cut
                return True
        if not self.errors.error <= self.stepper.method.most_error:
            self.trial.length *= self.errors.factor()
            return True
        return False

    @inline
    def _look_ahead(self) -> None:
        """Choose the length of the next step, by the error of this one.

        A step shortened by a joint or by a point of a table is no reason for a shorter next step.
        """
        if not self.trial.to_end or self.trial.length > self.state.proposal > 0.0:
            self.trial.longer = self.trial.length * self.errors.factor()
            if self.trial.on_knot:
                self.trial.longer = max(self.trial.longer, _AFTER_KNOT * self.state.proposal)

    def _end_on_switch(self) -> int:
        """End the step on the switch found; return the same as `_try`."""
        status = self.landing.end_on_switch(self.trial.length)
        if status != 0:
            self.trial.length *= 0.25
            return status if self.trial.length < 1e-14 else _AGAIN
        self.trial.length = self.landing.length
        if self.errors.controlled and self.stepper.balance.bends.count:
            excess = self.errors.of_reading(self.trial.length)
            if excess > self.stepper.method.most_error:
                # it is proportional to the square of the length
                self.trial.length -= self.trial.length / sqrt(excess)
                return _AGAIN
        self.trial.lands = not (self.switches.recedes or self.switches.only_opens)
        if self.state.time + self.trial.length < self.trial.end:
            self.trial.to_end = False
        return REACHED

    @inline
    def _finish(self) -> int:
        """Make the attempt the last step, and enter the branches and segments that follow."""
        if self.trial.longer > 0.0:
            self.state.proposal = self.trial.longer
        h = self.trial.length
        self._accept(h, self.trial.end if self.trial.to_end else self.state.time + h)
        self.switches.carry_on()
        if self.trial.lands:
            self.transitions.switch(self.switches.element, self.switches.kind, self.switches.side)
        if self.trial.to_end and self.trial.end == self.trial.joint:
            self.transitions.pass_joint()
        if not self.ends_on_switches:
            self.transitions.relocate(True)
            self.transitions.book_contacts()
        if self.trial.lands or self.trial.to_end or not self.ends_on_switches:
            self._enter_branches()
        elif self.stepper.balance.bends.count:
            self.stepper.modes.follow()
        if not self.state.reach < _FAR * max(self.state.scale, 1.0) or self.net.laws.failed:
            return DIVERGED
        steps = self.state.step_count
        if self.energy and (steps % _CHECKED == 0 or steps < _CHECKED):
            return self.ledger.check(self.motion.q, self.motion.v, self.stepper.method.exact)
        return REACHED

    @inline
    def _accept(self, h: float, t: float) -> None:
        """Make the attempt the last step."""
        if self.energy:
            self.ledger.read_rows(self.state.time, h)
        if self.errors.controlled:
            self.state.speed = self.motion.speed_in(h)
        self.dense.move_on(t)
        self.state.reach = self.motion.reach_at(self.motion.q)
        if self.limited.present:
            self.limited.add_step(h)
        # an element that has just switched stays marked while others switch at the same time
        if self.state.entered and self._passes(h):
            self.state.entered = False
            self.net.branches.clear_marks()
        if self.net.branches.stuck:
            self.motion.keep_multipliers()
        self.state.in_step = True
        self.state.step_start, self.state.time = self.state.time, t
        self.state.step_count += 1
        if self.energy:
            self.ledger.book()
