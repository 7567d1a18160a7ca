"""The end of an attempt on a switch, or on a point of a smooth table.

An attempt that goes on beyond it is stored. The state there is read from its septic if that is accurate
enough; otherwise the step is repeated with the length found.
"""

from __future__ import annotations

from math import fabs

from ..arrays import Memory
from ..layout import UNBOUNDED
from ..motion.dense import Dense
from .switches import Switches

_SIMULTANEOUS = 1e-6  # of a step: switches that are closer may be exchanged
_SHORT_PHASE = 1e-4  # phase of the fastest motion up to which its Taylor series replaces a step
# of an attempt: this close to its end, its septic is far more accurate than halfway
_NEAR_END = 0.005
_NEAR_PHASE = 0.05  # of the fastest motion: the same, in long steps
_MOST_ITERATIONS = 8


class Landing:
    """Shortens or extends an attempt, so that it ends where it should."""

    def __init__(self, switches: Switches, memory: Memory) -> None:
        self.switches = switches
        self.stepper, self.motion = self.switches.stepper, self.switches.stepper.motion
        self.errors, self.modes = self.stepper.errors, self.stepper.modes
        self.whole = Dense(memory, memory, self.motion, False, False)
        self.length = 0.0  # of the attempt as it ends now, s

    def extend_to(self, step: float, h: float) -> bool:
        """Let an attempt of length h go on to a longer one, with its septic; return whether it can.

        It cannot if the septic no longer obeys the equation of motion there, as curved forces may change
        beyond the attempt as they do not within it.
        """
        self._keep_attempt(h)
        time = self.motion.state.time
        self.stepper.stop_within(time + step, self.whole)
        if self.errors.obeys(self.whole.a, step - h):
            return True
        self.stepper.stop_within(time + h, self.whole)
        return False

    def end_on_switch(self, h: float) -> int:
        """End an attempt of length h on the switch found, by Newton's method, finally by Taylor's series.

        Under error control the state is read from the septic through the ends of the attempt, if that is
        accurate enough. Otherwise the step is repeated; as short steps are more accurate, it may then not
        reach the bound, or only after another switch, and is accepted without a switch at its end. A step
        that is shortened because a gap opens in it has no switch at its end, either.

        Return 0, or the reason why a repeated step failed.
        """
        time = self.motion.state.time
        step = self.switches.at * h
        near = h  # how far from the switch expected the stored attempt may be read
        status = 0
        if self._reads() and self.errors.can_read(self.switches.at, h):
            self._keep_attempt(h)
            self.stepper.stop_within(time + step, self.whole)
        else:
            status = self.stepper.attempt(time, step)
            near = self._keep_near(step)
        self.switches.recedes = False
        latest = h * min(1.0, self.switches.next + _SIMULTANEOUS)
        best = UNBOUNDED
        for _iteration in range(0 if self.switches.only_opens else _MOST_ITERATIONS):
            if status != 0:
                return status
            late = self.switches.lateness(time + step)
            if self.switches.recedes:
                break
            new = step - late
            if late == 0.0 or self.switches.miss >= best or new <= 0.0:
                break
            if new > latest:
                self.switches.recedes = True
                break
            if time + new == time + step:
                break
            best = self.switches.miss
            if fabs(late) * self.modes.quickest < _SHORT_PHASE:
                self.stepper.shift_end(time + new, -late)
            elif fabs(late) < near:
                self.stepper.stop_within(time + new, self.whole)
            else:
                status = self.stepper.attempt(time, new)
                near = self._keep_near(new)
            step = new
        if status == 0:
            self.length = step
        return status

    def _reads(self) -> bool:
        """Return whether the state at a switch may be read from an attempt."""
        return self.errors.controlled and not self.stepper.method.exact

    def _keep_near(self, h: float) -> float:
        """Store the attempt just made; return how far from its end it may be read."""
        if self.stepper.net.branches.stuck or not self._reads():
            return 0.0
        self._keep_attempt(h)
        return min(_NEAR_END * h, _NEAR_PHASE / (self.modes.quickest + 1.0))

    def _keep_attempt(self, h: float) -> None:
        time = self.motion.state.time
        self.whole.take_attempt(time, time + h)
