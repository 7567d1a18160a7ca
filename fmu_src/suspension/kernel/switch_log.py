"""The switches of a run: noted in C, and listed when Python looks."""

from __future__ import annotations

CAPACITY = 512  # switches that are noted between two looks


class SwitchLog:
    """Time of each switch, and what: element, kind, branch before, branch after.

    Parameters
    ----------
    memory : where the arrays lie
    """

    def __init__(self, memory):
        self.memory = memory
        self.time, self.what = self.memory.zeros(CAPACITY), self.memory.marks(4 * CAPACITY)
        self.listed = []  # without those that are only noted
        self.start()

    def start(self):
        """Forget what is only noted."""
        self.count = self.base = self.flushed = 0

    def begin_row(self):
        """Let another run of a batch begin: what it notes counts from here."""
        self.base = self.count

    def is_half_full(self):
        """Return whether the present run has noted so much that Python should look."""
        return self.count - self.base > CAPACITY // 2

    def note(self, time, e, kind, before, after):
        """Note that element e has moved from one branch to another."""
        k = self.count
        if k < CAPACITY:
            self.time[k] = time
            self.what[4 * k] = e
            self.what[4 * k + 1] = kind
            self.what[4 * k + 2] = before
            self.what[4 * k + 3] = after
            self.count += 1

    def all(self):
        """Return the switches so far: (time, element, kind, branch before, branch after)."""
        for k in range(self.count):
            what, i = self.what, 4 * k
            self.listed.append((self.time[k], what[i], what[i + 1], what[i + 2], what[i + 3]))
        self.count, self.base, self.flushed = 0, 0, len(self.listed)
        return self.listed

    def clear(self):
        """Forget the switches listed."""
        self.listed = []
        self.flushed = 0
