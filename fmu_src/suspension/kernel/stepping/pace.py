"""The pace of a run: when it pauses, and whether it will come to its end."""

from __future__ import annotations

from ..layout import UNBOUNDED
from ..state import KernelState

PAUSE = 5000  # steps after which Python can handle signals, such as an interrupt
_ENOUGH_STEPS = 200000  # steps between two estimates of the number of steps still to come
_MOST_STEPS = 30000000  # still to come, in one call or to the end of the run, as far as it is known

# s, so far ahead steps are counted: a host may step for days, to a stop time that it never reaches
_COUNTED_AHEAD = 60.0


class Pace:
    """The steps of one call, or of calls whose end is known, and since the last pause."""

    def __init__(self, state: KernelState) -> None:
        self.state = state
        self.since_pause = 0
        self.stop_time = -UNBOUNDED  # of the run, if the host knows it
        self.look_at_pace()

    def look_at_pace(self) -> None:
        """Start measuring the pace of the run."""
        self.begun, self.started = self.state.step_count, self.state.time

    def keeps_pace(self, until: float) -> bool:
        """Return whether the number of steps still to come, at the present pace, is acceptable."""
        taken = self.state.step_count - self.begun
        if taken >= _ENOUGH_STEPS:
            end = max(until, min(self.stop_time, self.state.time + _COUNTED_AHEAD))
            if taken * (end - self.state.time) > _MOST_STEPS * (self.state.time - self.started):
                return False
            self.look_at_pace()
        return True
