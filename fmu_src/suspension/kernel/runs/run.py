"""One run between communication points: what a host sets, and how the integrator follows it.

Inputs are samples set by the host. Held over a step, a sample makes the motion accurate to first order
only; extrapolated by its slope, to second order. For this, the velocity of a road is an input, too. All
other inputs, and a road without a velocity, are extrapolated by the smaller of the slopes of their last
two intervals, and held if the signs of these differ. Where the input is smooth, this slope is accurate to
first order; jumps are preserved.

With an internal road the integrator runs ahead of the communication points, so contact switches wait
here until their time has come. It stops at every communication point, as with inputs, once parameters
have changed at two successive ones: running ahead would be in vain.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence

from ..arrays import Lent, Memory
from ..integrator import Integrator
from ..language import Doubles, Integers, Lendable, of_python, open_to_python
from ..network.rest import Rest
from .account import Account
from .contacts import Contacts
from .inputs import Inputs

_NONE = -1
_CHANGED, _SUCCESSIVELY = 2, 3
_NUMBERS = 10  # of the state, besides arrays


class Run:
    """The inputs, the contacts and the present time of one run.

    Parameters
    ----------
    integrator : steps the system
    start : s
    inputs : number of inputs
    lines : of every signal that inputs drive, ascending: its number, the input that gives its value, and
        the input that gives its rate, or -1
    tyres : numbers of the elements whose contact is monitored
    sampled : whether inputs drive a road, so that steps end on communication points from the start
    """

    integrator: Integrator
    rest: Rest
    inputs: Inputs
    contacts: Contacts
    account: Account
    time: float
    start: float
    sampled: bool

    def __init__(
        self,
        integrator: Integrator,
        start: float,
        inputs: int,
        lines: Sequence[Sequence[int]],
        tyres: Sequence[int],
        sampled: bool,
    ) -> None:
        self.integrator = integrator
        self.rest = Rest(self.integrator.net)
        self.lines, self.sampled = len(lines), sampled
        self.memory = memory = Memory()
        self.inputs = Inputs(memory, inputs)
        self.contacts = Contacts(memory, tyres)
        self.account = Account(memory, self.integrator.net.signals.count)
        self.line_signal = memory.integers([line[0] for line in lines])
        self.line_input = memory.integers([line[1] for line in lines])
        self.line_rate = memory.integers([line[2] for line in lines])
        # the present course of every line: a value at a time, and its slope
        self.line_time, self.line_value = memory.zeros(self.lines), memory.zeros(self.lines)
        self.line_slope = memory.zeros(self.lines)
        self.course_time = self.course_value = self.course_slope = 0.0
        self.coefficients, self.road = memory.zeros(4), memory.zeros(4)
        self.begin(start)

    def begin(self, start: float) -> None:
        """Reset the run: no input has been set."""
        self.time = self.start = start
        self.handed = start  # when inputs were last handed over, s; and how long after those before
        self.interval = 0.0
        self.changed = 0
        self.inputs.start()
        for k in range(self.lines):
            self.line_time[k] = start
            self.line_value[k] = self.line_slope[k] = 0.0
        self.account.start()
        self.contacts.begin(self.integrator)

    # -- inputs --------------------------------------------------------------------------------------

    @open_to_python
    def set_input(self, i: int, value: float) -> None:
        """Set input i from the present time on; a call at the same time replaces an earlier one."""
        self.inputs.set(i, value, self.time)

    @open_to_python
    def input_now(self, i: int) -> float:
        """Return the present value of input i."""
        return self.inputs.value[i]

    def _find_course(self, k: int, until: float) -> None:
        """Find the course of line k for a step from now to `until`.

        Once its velocity has been set, a road follows it from each elevation. If velocities are set
        without elevations, the road follows their mean over each interval.
        """
        value, rate = self.line_input[k], self.line_rate[k]
        if rate == _NONE or self.inputs.samples[rate] == 0:
            self.course_time = self.inputs.since(value)
            self.course_value = self.inputs.value[value]
            self.course_slope = self.inputs.slope(value, until)
            return
        before = self.line_time[k]
        self.course_slope = self.inputs.value[rate]
        if self.inputs.samples[value] > 0 and self.inputs.since(value) == self.time:
            self.course_time = self.time
            self.course_value = self.inputs.value[value]
        elif self.inputs.since(rate) == self.time and self.time > before:
            self.course_time = self.time
            mean = 0.5 * (self.line_slope[k] + self.inputs.value[rate])
            self.course_value = self.line_value[k] + mean * (self.time - before)
        else:
            self.course_time = before
            self.course_value = self.line_value[k]

    def _continues(self, k: int) -> bool:
        """Return whether the course found continues the present one of line k."""
        if self.course_value != self.line_value[k] or self.course_slope != self.line_slope[k]:
            return False
        return self.course_time == self.line_time[k] or self.course_slope == 0.0

    @open_to_python
    def sets_in(self) -> bool:
        """Return whether the steps are to end on communication points from now on; once for each step.

        So they do when an input begins to act, or when parameters have changed at two successive points.
        Roads as inputs act from the start; forces may begin to act at any time.
        """
        if self.sampled:
            return False
        if self.changed >= _SUCCESSIVELY:
            return True
        if self.changed > 0:
            self.changed -= 1
        for k in range(self.lines):
            if self.inputs.value[self.line_input[k]] != self.line_value[k]:
                return True
        return False

    @open_to_python
    def hand_over(self, until: float) -> bool:
        """Set the signals that inputs drive, for a step that ends at `until`; return whether any changes.

        A road that is not at 0 at the start has always been there: no jump.
        """
        if not self.sampled:
            return False
        moved = False
        if self.time > self.handed:
            self.interval = self.time - self.handed
            self.handed = self.time
        for k in range(self.lines):
            self._find_course(k, until)
            if self._continues(k):
                continue
            moved = True
            late = self.time - self.course_time
            self.line_value[k] = self.course_value + self.course_slope * late
            self.line_slope[k] = self.course_slope
            self.line_time[k] = self.time
            self._enter_course(k)
            self.integrator.replace_signal(
                self.line_signal[k], self.coefficients, self.interval, self.time > self.start
            )
        return moved

    def _enter_course(self, k: int) -> None:
        self.coefficients[0] = self.line_value[k]
        self.coefficients[1] = self.line_slope[k]

    # -- roads and loads -----------------------------------------------------------------------------

    @open_to_python
    def find_rest(self) -> int:
        """Find the rest position `rest.q` on the roads just before now; return 1 if there is none.

        External forces act from the start on and are not part of the equilibrium.
        """
        found = 0
        for s in range(self.integrator.net.signals.count):
            self.rest.level[s] = 0.0
        for r in range(self.integrator.net.elements.rows):
            s = self.integrator.net.elements.row_signal[r]
            if s >= 0:
                self.integrator.net.signals.from_zero(s, self.time, False, self.road, 0)
                self.rest.level[s] = self.road[0]
                if self.rest.level[s] != 0.0:
                    found = 1
        for i in range(self.integrator.net.n):
            self.rest.q[i] = 0.0
        return self.rest.find() if found else 0

    # -- other parameters ----------------------------------------------------------------------------

    def take_laws(self, x: Doubles, at: int) -> None:
        """Continue with other laws of the elements, from x[at:]."""
        self.account.find(self.integrator, self.time)
        self.integrator.take_laws(x, at)
        self._begin_anew(self.integrator)

    @open_to_python
    def retune(self, laws: Lendable) -> None:
        """Continue with other laws of the elements.

        Parameters
        ----------
        laws : `laws_of` a system that fits and differs in its laws alone; an array of doubles

        Raises
        ------
        ValueError : if these are not the laws of such a system.
        """
        size = self.integrator.net.branches.laws_size
        if len(laws) != size:
            raise ValueError(f"{len(laws)} numbers given; the laws of these elements have {size}")
        lent = Lent(laws)
        self.take_laws(lent.numbers, 0)

    def hand_on(self, integrator: Integrator, counterpart: Integers) -> None:
        """Let another integrator continue from the present one; the host then replaces that."""
        self.account.find(self.integrator, self.time)
        for k in range(self.lines):
            self._enter_course(k)
            integrator.net.signals.replace_signal(
                self.line_signal[k], self.line_time[k], self.coefficients
            )
        integrator.take_over(self.integrator, counterpart)
        self._begin_anew(integrator)

    def _begin_anew(self, integrator: Integrator) -> None:
        """Compare contacts, and continue the energies, while the integrator's ledger starts from zero."""
        self.changed += _CHANGED
        self.contacts.compare(integrator, self.time)
        self.account.carry(integrator)

    @of_python
    def replace(self, integrator: Integrator, counterpart: Sequence[int]) -> None:
        """Continue with another integrator from the state of the present one, which it replaces.

        Parameters
        ----------
        integrator : new, at the present time, of a system with other numbers
        counterpart : for each of its elements the number of the same element so far, or -1
        """
        memory = Memory()
        self.contacts.renumber(counterpart)
        self.hand_on(integrator, memory.integers(counterpart))
        self.integrator, self.rest = integrator, Rest(integrator.net)

    # -- whole state ---------------------------------------------------------------------------------

    @of_python
    def courses(self) -> list[tuple[int, float, float, float]]:
        """Return the present course of every signal that inputs drive.

        Returns
        -------
        Number of the signal, a time (s), the value then, and the slope.
        """
        return [
            (self.line_signal[k], self.line_time[k], self.line_value[k], self.line_slope[k])
            for k in range(self.lines)
        ]

    @of_python
    def snapshot(self) -> bytes:
        """Return the state as bytes, apart from the integrator's."""
        account, contacts = self.account, self.contacts
        numbers = [
            self.time, self.start, self.handed, self.interval, account.opening,
            account.look_at, account.drifts, self.sampled, contacts.waiting, self.changed,
        ]  # fmt: skip
        return array("d", numbers).tobytes() + self.memory.content()

    @of_python
    def restore(self, state: bytes) -> None:
        """Return to the state of a snapshot of the same run.

        Raises
        ------
        ValueError : if a snapshot of this run has another size.
        """
        if len(state) != len(self.snapshot()):
            raise ValueError("this state belongs to another run; use one of this")
        account, contacts = self.account, self.contacts
        numbers = array("d", state[: 8 * _NUMBERS])
        self.time, self.start, self.handed, self.interval, account.opening = numbers[:5]
        whole = map(int, numbers[5:])
        account.look_at, drifts, sampled, contacts.waiting, self.changed = whole
        account.drifts, self.sampled = bool(drifts), bool(sampled)
        self.memory.put_back(state, 8 * _NUMBERS)
