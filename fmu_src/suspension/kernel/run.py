"""One run between communication points: what a host sets, and how the integrator follows it.

Inputs are samples set by the host. Held over a step, a sample makes the motion accurate to first order
only; extrapolated by its slope, to second order. A road has its velocity as an input for that. All other
inputs, and a road without a velocity, are extrapolated by the smaller of the slopes of their last two
intervals, and held if the signs of these differ. This is the slope to first order where the course is
smooth, and keeps jumps.

With an internal road the integrator goes ahead of the communication points, so contact switches wait
here until their time has come.
"""

from __future__ import annotations

import cython

from .arrays import Memory
from .rest import Rest

if not cython.compiled:
    from math import fabs

_SAMPLES = 3  # for two slopes
_LONGEST = 2.0  # duration of the extrapolation, in intervals of the last slope
_WAITING = 1024  # switches that can wait; between two looks at them there are at most half as many
_NONE = -1
_FIRST_LOOK = 1000  # steps before the energies are looked at; later after twice as many each time
_DRIFT = 30.0  # tolerances by which the energy may be off, of all energy held, taken and brought in
_LEAST_DRIFT = 1e-9


class Run:
    """The inputs, the contacts and the present time of one run.

    Parameters
    ----------
    integrator : steps the system
    start : s
    inputs : number of inputs
    lines : of every signal that inputs drive, ascending: its number, the input that gives its value, and
        the input that gives its rate, or -1
    tyres : elements whose contact is followed
    sampled : whether inputs drive a road, so that steps end on communication points from the start
    """

    def __init__(self, integrator, start, inputs, lines, tyres, sampled):
        self.integrator = integrator
        self.rest = Rest(self.integrator.net)
        self.inputs, self.lines, self.tyres = inputs, len(lines), len(tyres)
        self.sampled = sampled
        self.memory = memory = Memory()
        self.value = memory.zeros(inputs)
        self.samples = memory.marks(inputs)
        samples = _SAMPLES * inputs
        self.sample_time, self.sample_value = memory.zeros(samples), memory.zeros(samples)
        self.line_signal = memory.integers([line[0] for line in lines])
        self.line_input = memory.integers([line[1] for line in lines])
        self.line_rate = memory.integers([line[2] for line in lines])
        # the present course of every line: a value at a time, and its slope
        self.line_time, self.line_value = memory.zeros(self.lines), memory.zeros(self.lines)
        self.line_slope = memory.zeros(self.lines)
        self.course_time = self.course_value = self.course_slope = 0.0
        self.coefficients = memory.zeros(4)
        self.tyre = memory.integers(tyres)
        self.airborne, self.lift_offs = memory.marks(self.tyres), memory.marks(self.tyres)
        self.last_lift_off = memory.zeros(self.tyres)
        self.last_touchdown = memory.zeros(self.tyres)
        # the energies of the run at the time looked at last, J; and of the account what it opened with
        self.signals = self.integrator.net.signals
        self.kinetic = self.stored = self.dissipated = self.opening = 0.0
        self.supplied, self.carried = memory.zeros(self.signals), memory.zeros(self.signals)
        self.waiting = 0
        self.waiting_time = memory.zeros(_WAITING)
        self.waiting_tyre = memory.marks(_WAITING)
        self.waiting_airborne = memory.marks(_WAITING)
        self.begin(start)

    def begin(self, start):
        """Start anew: no input has been set."""
        self.time = self.start = start
        self.handed = start  # when inputs were last handed over, s, and the time since those before
        self.interval = 0.0
        for i in range(self.inputs):
            self.value[i] = 0.0
            self.samples[i] = 0
        for k in range(self.lines):
            self.line_time[k] = start
            self.line_value[k] = self.line_slope[k] = 0.0
        self.look_at, self.drifts = _FIRST_LOOK, 0
        self.begin_contacts()

    # -- inputs --------------------------------------------------------------------------------------

    def set_input(self, i, value):
        """Set input i from the present time on; a call at the same time replaces an earlier one."""
        at = _SAMPLES * i
        count = self.samples[i]
        while count > 0 and self.sample_time[at + count - 1] >= self.time:
            count -= 1
        if count == _SAMPLES:
            for k in range(1, _SAMPLES):
                self.sample_time[at + k - 1] = self.sample_time[at + k]
                self.sample_value[at + k - 1] = self.sample_value[at + k]
            count -= 1
        self.sample_time[at + count] = self.time
        self.sample_value[at + count] = value
        self.samples[i] = count + 1
        self.value[i] = value

    def input_now(self, i):
        """Return the present value of input i."""
        return self.value[i]

    def _since(self, i):
        """Return when input i was last set, s; 0 if it never was."""
        count = self.samples[i]
        return self.sample_time[_SAMPLES * i + count - 1] if count > 0 else 0.0

    def slope(self, i, until):
        """Return the rate of change of input i for a step that ends at `until`, s.

        0 if the step ends more than two intervals after the last sample: a host that sets nothing
        for so long means that nothing changes.
        """
        if self.samples[i] < _SAMPLES:
            return 0.0
        at = _SAMPLES * i
        t0, t1, t2 = self.sample_time[at], self.sample_time[at + 1], self.sample_time[at + 2]
        f0, f1, f2 = self.sample_value[at], self.sample_value[at + 1], self.sample_value[at + 2]
        if until - t2 > _LONGEST * (t2 - t1) * (1.0 + 1e-9):
            return 0.0
        before = (f1 - f0) / (t1 - t0)
        last = (f2 - f1) / (t2 - t1)
        if before * last <= 0.0:
            return 0.0
        return before if fabs(before) <= fabs(last) else last

    def _find_course(self, k, until):
        """Find the course of line k for a step from now to `until`.

        Once its velocity has been set, a road follows it from each elevation. If velocities are set
        without elevations, the road follows their mean over each interval.
        """
        value, rate = self.line_input[k], self.line_rate[k]
        if rate == _NONE or self.samples[rate] == 0:
            self.course_time = self._since(value)
            self.course_value = self.value[value]
            self.course_slope = self.slope(value, until)
            return
        before = self.line_time[k]
        self.course_slope = self.value[rate]
        if self.samples[value] > 0 and self._since(value) == self.time:
            self.course_time = self.time
            self.course_value = self.value[value]
        elif self._since(rate) == self.time and self.time > before:
            self.course_time = self.time
            mean = 0.5 * (self.line_slope[k] + self.value[rate])
            self.course_value = self.line_value[k] + mean * (self.time - before)
        else:
            self.course_time = before
            self.course_value = self.line_value[k]

    def _continues(self, k):
        """Return whether the course found is the present one of line k."""
        if self.course_value != self.line_value[k] or self.course_slope != self.line_slope[k]:
            return 0
        return self.course_time == self.line_time[k] or self.course_slope == 0.0

    def sets_in(self):
        """Return whether an input has begun to act on a system that needed none so far.

        Roads as inputs act from the start; forces may set in at any time.
        """
        if self.sampled:
            return 0
        for k in range(self.lines):
            if self.value[self.line_input[k]] != self.line_value[k]:
                return 1
        return 0

    def hand_over(self, until):
        """Set the signals that inputs drive, for a step that ends at `until`; return whether any changes.

        A road that is not at 0 at the start has always been there: no jump.
        """
        if not self.sampled:
            return 0
        moved = 0
        if self.time > self.handed:
            self.interval = self.time - self.handed
            self.handed = self.time
        for k in range(self.lines):
            self._find_course(k, until)
            if self._continues(k):
                continue
            moved = 1
            late = self.time - self.course_time
            self.line_value[k] = self.course_value + self.course_slope * late
            self.line_slope[k] = self.course_slope
            self.line_time[k] = self.time
            self._enter_course(k)
            self.integrator.replace_signal(
                self.line_signal[k], self.coefficients, self.interval, self.time > self.start
            )
        return moved

    def _enter_course(self, k):
        self.coefficients[0] = self.line_value[k]
        self.coefficients[1] = self.line_slope[k]

    # -- contacts ------------------------------------------------------------------------------------

    def begin_contacts(self):
        """Start anew: a wheel may be in the air at the start, which does not count as a lift-off."""
        self.waiting = 0
        for c in range(self.tyres):
            self.airborne[c] = self.integrator.at_limit(self.tyre[c])
            self.lift_offs[c] = 0
            self.last_lift_off[c] = self.last_touchdown[c] = -1.0

    def note_contact(self, time, e, airborne):
        """Let a lift-off or touchdown of element e wait for its time."""
        for c in range(self.tyres):
            if self.tyre[c] == e and self.waiting < _WAITING:
                self.waiting_time[self.waiting] = time
                self.waiting_tyre[self.waiting] = c
                self.waiting_airborne[self.waiting] = airborne
                self.waiting += 1

    def compare_contacts(self):
        """Note contacts that end or begin because a parameter has changed."""
        for c in range(self.tyres):
            now = self.integrator.at_limit(self.tyre[c])
            if now != self.airborne[c]:
                self.note_contact(self.time, self.tyre[c], now)

    def next_contact(self, until):
        """Count the first waiting switch, if its time is not after `until`.

        Returns
        -------
        The number of its tyre, or -1 if none is due.
        """
        if self.waiting == 0 or self.waiting_time[0] > until:
            return _NONE
        c = self.waiting_tyre[0]
        self.airborne[c] = self.waiting_airborne[0]
        if self.airborne[c]:
            self.lift_offs[c] += 1
            self.last_lift_off[c] = self.waiting_time[0]
        else:
            self.last_touchdown[c] = self.waiting_time[0]
        self.waiting -= 1
        for k in range(self.waiting):
            self.waiting_time[k] = self.waiting_time[k + 1]
            self.waiting_tyre[k] = self.waiting_tyre[k + 1]
            self.waiting_airborne[k] = self.waiting_airborne[k + 1]
        return c

    def forget_waiting(self):
        """Forget the switches that wait, after a return to the present."""
        self.waiting = 0

    # -- roads and loads -----------------------------------------------------------------------------

    def find_rest(self):
        """Find where the system rests on its roads just before now, in `rest.q`; 1 if nowhere.

        External forces act from the start on and are not part of the equilibrium.
        """
        found = 0
        for s in range(self.integrator.net.signals):
            self.rest.level[s] = 0.0
        for r in range(self.integrator.net.rows):
            s = self.integrator.net.row_signal[r]
            if s >= 0:
                self.rest.level[s] = self.integrator.net.value_before(s, self.time)
                if self.rest.level[s] != 0.0:
                    found = 1
        for i in range(self.integrator.n):
            self.rest.q[i] = 0.0
        return self.rest.find() if found else 0

    # -- energies --------------------------------------------------------------------------------------

    def begin_account(self):
        """Let the energies start, where the integrator's ledger begins."""
        self.dissipated = 0.0
        for s in range(self.signals):
            self.supplied[s] = 0.0
        self.carry_account()

    def carry_account(self):
        """Let the energies found last go on, where the integrator's ledger begins anew.

        What the elements store otherwise is no work.
        """
        dissipated = self.dissipated
        for s in range(self.signals):
            self.carried[s] = self.supplied[s]
        self._look(self.integrator.state.time)
        # constant but for the residual
        self.opening = dissipated + self.kinetic + self.stored - self.integrator.state.residual_end

    def find_energies(self):
        """Find the energies at the present time.

        Where the last step goes beyond the present, they are those of its interpolant. What is dissipated
        follows from the balance: all work on the elements that no other entry has.
        """
        self._look(self.time)
        self.dissipated = self.opening - (self.kinetic + self.stored)
        for s in range(self.signals):
            since = self.integrator.ledger.until[self.integrator.net.elements + s]
            self.dissipated += since
            self.supplied[s] = self.carried[s] + since
        self.dissipated += self.integrator.residual_at(self.time)

    def _look(self, time):
        """Let the ledger find its entries at a time, and add up what the elements store."""
        self.integrator.find_energies(time)
        self.kinetic = self.integrator.ledger.kinetic
        self.stored = 0.0
        for e in range(self.integrator.net.elements):
            self.stored += self.integrator.ledger.kept[e]

    def energies(self):
        """Return the kinetic, stored, dissipated and supplied energies found last, J."""
        supplied = [self.supplied[s] for s in range(self.signals)]
        return self.kinetic, self.stored, self.dissipated, tuple(supplied)

    def find_drift(self):
        """Return the part of all energy by which the balance is off, if errors have added up; else 0.

        They do in a long run without damping, where nothing forgets them. It is told once.
        """
        if self.drifts or self.integrator.state.step_count < self.look_at:
            return 0.0
        self.look_at = 2 * self.integrator.state.step_count
        self.integrator.find_energies(self.integrator.dense.end)
        # all that has been there, and what has gone through it: a residual of that is no drift
        turned_over = self.integrator.ledger.kinetic
        for e in range(self.integrator.net.elements):
            turned_over += fabs(self.integrator.ledger.kept[e])
        for k in range(self.integrator.ledger.works):
            turned_over += fabs(self.integrator.ledger.until[k])
        off = fabs(self.integrator.state.residual_end)
        tolerated = max(_DRIFT * self.integrator.stepper.errors.tolerance, _LEAST_DRIFT)
        if off <= tolerated * turned_over:
            return 0.0
        self.drifts = 1
        return off / turned_over

    # -- another integrator --------------------------------------------------------------------------

    def hand_on(self, integrator, counterpart):
        """Let another integrator go on from the present one; the host then puts it in its place."""
        for k in range(self.lines):
            self._enter_course(k)
            integrator.net.replace_signal(self.line_signal[k], self.line_time[k], self.coefficients)
        integrator.take_over(self.integrator, counterpart)

    def replace(self, integrator, counterpart):
        """Let another integrator go on from the present one, in its place.

        Parameters
        ----------
        integrator : new, at the present time, of a system with other numbers
        counterpart : for each of its elements the number of the same one until now, or -1
        """
        memory = Memory()
        self.hand_on(integrator, memory.integers(counterpart))
        self.integrator = integrator

    # -- whole state ---------------------------------------------------------------------------------

    def _parts(self):
        """Return all arrays of the state, as Python sees them."""
        memory, samples = self.memory, _SAMPLES * self.inputs
        return [
            memory.seen(self.value, self.inputs),
            memory.seen_marks(self.samples, self.inputs),
            memory.seen(self.sample_time, samples),
            memory.seen(self.sample_value, samples),
            memory.seen(self.line_time, self.lines),
            memory.seen(self.line_value, self.lines),
            memory.seen(self.line_slope, self.lines),
            memory.seen(self.carried, self.signals),
            *self.contacts(),
            memory.seen(self.waiting_time, self.waiting),
            memory.seen_marks(self.waiting_tyre, self.waiting),
            memory.seen_marks(self.waiting_airborne, self.waiting),
        ]

    def contacts(self):
        """Return the contacts of all tyres at the present time, which change in place.

        Returns
        -------
        Whether each is off the road, its lift-offs so far, and its last lift-off and touchdown, s.
        """
        memory = self.memory
        return (
            memory.seen_marks(self.airborne, self.tyres),
            memory.seen_marks(self.lift_offs, self.tyres),
            memory.seen(self.last_lift_off, self.tyres),
            memory.seen(self.last_touchdown, self.tyres),
        )

    def courses(self):
        """Return the present course of every signal that inputs drive.

        Returns
        -------
        Number of the signal, a time (s), the value then, and the slope.
        """
        return [
            (self.line_signal[k], self.line_time[k], self.line_value[k], self.line_slope[k])
            for k in range(self.lines)
        ]

    def snapshot(self):
        """Return the state, apart from the integrator's, as numbers."""
        numbers = [
            self.time, self.start, self.handed, self.interval, self.opening, self.look_at,
            self.sampled, self.drifts, self.waiting,
        ]  # fmt: skip
        for part in self._parts():
            numbers += part.tolist()
        return numbers

    def restore(self, state):
        """Return to the state of a snapshot of the same run."""
        self.time, self.start, self.handed, self.interval, self.opening = state[:5]
        self.look_at, self.sampled, self.drifts, self.waiting = map(int, state[5:9])
        at = 9
        for part in self._parts():
            kind = int if part.format == "i" else float
            for k in range(len(part)):
                part[k] = kind(state[at + k])
            at += len(part)
