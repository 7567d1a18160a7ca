"""The contact of every tyre at the present time, and the upcoming switches of contact."""

from __future__ import annotations

from collections.abc import Sequence

from ..arrays import Memory
from ..integrator import Integrator
from ..language import of_python, open_to_python
from ..layout import UNBOUNDED

_WAITING = 256  # switches later than the present time, up to the end of the last step
_NONE = -1


class Contacts:
    """Which tyres are off the road, how often they have left it, and when.

    Parameters
    ----------
    memory : the memory that contains the arrays
    tyres : numbers of the elements whose contact is monitored
    """

    waiting: int

    def __init__(self, memory: Memory, tyres: Sequence[int]) -> None:
        self.memory, self.tyres = memory, len(tyres)
        self.tyre = self.memory.integers(tyres)
        self.airborne, self.lift_offs = self.memory.marks(self.tyres), self.memory.marks(self.tyres)
        self.last_lift_off = self.memory.zeros(self.tyres)
        self.last_touchdown = self.memory.zeros(self.tyres)
        self.waiting = 0
        self.waiting_time = self.memory.zeros(_WAITING)
        self.waiting_tyre = self.memory.marks(_WAITING)
        self.waiting_airborne = self.memory.marks(_WAITING)

    @open_to_python
    def begin(self, integrator: Integrator) -> None:
        """Reset all contacts; a wheel that starts in the air does not count as a lift-off."""
        self.waiting = 0
        for c in range(self.tyres):
            self.airborne[c] = integrator.at_limit(self.tyre[c])
            self.lift_offs[c] = 0
            self.last_lift_off[c] = self.last_touchdown[c] = -1.0

    @of_python
    def renumber(self, counterpart: Sequence[int]) -> None:
        """Take the numbers of the tyres in a new system.

        Parameters
        ----------
        counterpart : for each of its elements the number of the same element so far, or -1
        """
        for c in range(self.tyres):
            self.tyre[c] = counterpart.index(self.tyre[c])

    @open_to_python
    def note(self, time: float, e: int, airborne: bool) -> None:
        """Add a lift-off or touchdown of element e to the switches that wait for their time.

        If too many wait, the first of them is counted before its time.
        """
        if self.waiting == _WAITING:
            self.next(UNBOUNDED)
        for c in range(self.tyres):
            if self.tyre[c] == e:
                self.waiting_time[self.waiting] = time
                self.waiting_tyre[self.waiting] = c
                self.waiting_airborne[self.waiting] = airborne
                self.waiting += 1

    @open_to_python
    def compare(self, integrator: Integrator, time: float) -> None:
        """Add the contacts that end or begin because a parameter has changed."""
        for c in range(self.tyres):
            now = integrator.at_limit(self.tyre[c])
            if now != self.airborne[c]:
                self.note(time, self.tyre[c], now)

    @open_to_python
    def next(self, until: float) -> int:
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

    @open_to_python
    def forget_waiting(self) -> None:
        """Discard the waiting switches, after a return to the present time."""
        self.waiting = 0

    @of_python
    def seen(self) -> tuple[memoryview[int], memoryview[int], memoryview[float], memoryview[float]]:
        """Return the contacts of all tyres at the present time, as views that change in place.

        Returns
        -------
        Whether each is off the road, its lift-offs so far, and its last lift-off and touchdown, s.
        """
        return (
            self.memory.seen_marks(self.airborne, self.tyres),
            self.memory.seen_marks(self.lift_offs, self.tyres),
            self.memory.seen(self.last_lift_off, self.tyres),
            self.memory.seen(self.last_touchdown, self.tyres),
        )
