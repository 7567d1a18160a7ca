"""The switches of a run: written to arrays in C, and moved to a list when Python reads them."""

from __future__ import annotations

from ..arrays import Memory
from ..language import of_python

CAPACITY = 512  # switches that the arrays hold, and those of one step besides


class SwitchLog:
    """The time of each switch, its element, its kind, the branch before and the branch after.

    Parameters
    ----------
    memory : the memory that contains the arrays
    in_step : the largest number of switches in one step
    """

    def __init__(self, memory: Memory, in_step: int) -> None:
        self.capacity = CAPACITY + in_step
        self.time, self.what = memory.zeros(self.capacity), memory.marks(4 * self.capacity)
        # without those that are still in the arrays
        self.listed: list[tuple[float, int, int, int, int]] = []
        self.start()

    def start(self) -> None:
        """Discard the switches in the arrays."""
        self.logged = self.base = self.flushed = 0

    def begin_row(self) -> None:
        """Begin another run of a batch: its switches are counted from here."""
        self.base = self.logged

    def is_half_full(self) -> bool:
        """Return whether the present run has filled half of the arrays, which Python should then read."""
        return self.logged - self.base > CAPACITY // 2

    def note(self, time: float, e: int, kind: int, before: int, after: int) -> None:
        """Log that element e has moved from one branch to another."""
        k = self.logged
        if k < self.capacity:
            self.time[k] = time
            self.what[4 * k] = e
            self.what[4 * k + 1] = kind
            self.what[4 * k + 2] = before
            self.what[4 * k + 3] = after
            self.logged += 1

    def all(self) -> list[tuple[float, int, int, int, int]]:
        """Return the switches so far: (time, element, kind, branch before, branch after)."""
        for k in range(self.logged):
            what, i = self.what, 4 * k
            self.listed.append((self.time[k], what[i], what[i + 1], what[i + 2], what[i + 3]))
        self.logged, self.base, self.flushed = 0, 0, len(self.listed)
        return self.listed

    @of_python
    def clear(self) -> None:
        """Clear the list."""
        self.listed = []
        self.flushed = 0
