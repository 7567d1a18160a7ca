"""The rows at both ends of an attempt: their deflections and three derivatives, and those of roads.

The search for switches reads them, and the works of a step follow from them.
"""

from __future__ import annotations

from ..language import Doubles, inline
from .balance import Balance
from .errors import Errors
from .motion import Motion


class Rows:
    """Four numbers at the start of an attempt and four at its end, for each row and each signal."""

    def __init__(self, motion: Motion, balance: Balance, errors: Errors) -> None:
        self.motion, self.balance, self.errors = motion, balance, errors
        self.elements, self.signals = self.motion.net.elements, self.motion.net.signals
        memory = self.motion.net.memory
        self.row = memory.zeros(8 * max(self.elements.rows, 1))
        self.road = memory.zeros(8 * max(self.signals.count, 1))
        self.roads_known = False
        self.start_known = self.end_known = False  # whether all rows have been read there
        self.continues = False  # whether the start is the end of the last step
        self.own_jerks = False  # whether the attempt last read had jerks of its own

    def forget(self) -> None:
        """Read everything anew, after a change of branch."""
        self.roads_known = self.start_known = self.end_known = self.continues = False

    def read(self, t: float, h: float) -> None:
        """Read signals and rows at both ends of the attempt just made."""
        if not (self.roads_known and self.balance.loads_hold):
            self._read_roads(t, h)
        # an attempt with jerks of its own does not start with those at the end of the last one
        known = self.start_known and not (self.own_jerks or self.errors.own_jerks)
        self.own_jerks = self.errors.own_jerks
        self.continues = self.continues and known
        # with a constant in place of n the compiler unrolls the loops
        if self.elements.n == 2:
            self._sum_all(2, known)
        else:
            self._sum_all(self.elements.n, known)
        self.start_known = self.end_known = True

    def read_end(self, r: int, t: float) -> None:
        """Read signals and row r at the end of the attempt, t, after it has been shortened."""
        self.end_known = False
        if not self.balance.loads_hold:
            self._read_road_end(t)
        self._sum_rows(self.elements.n, r, r + 1, 4)

    def carry_on(self) -> None:
        """After the attempt was accepted, take its end as the start of the next one."""
        self.continues = self.start_known = self.end_known
        self.end_known = False
        if self.start_known:
            _carry(self.row, self.elements.rows)
            if not self.balance.loads_hold:
                _carry(self.road, self.signals.count)

    def _read_roads(self, t: float, h: float) -> None:
        """Read signals at both ends of the attempt just made, and leave them as they are at its end."""
        self._read_road_end(t + h)
        if not self.start_known:
            self.signals.all_signals(t)
            self._note_road(0)
            self.signals.all_signals(t + h)
        self.roads_known = True

    def _read_road_end(self, t: float) -> None:
        """Read signals at the end of the attempt just made or shortened."""
        if self.balance.loads_hold:
            self.signals.all_signals(t)
        self._note_road(1)  # otherwise the attempt has left the signals evaluated there

    def _note_road(self, end: int) -> None:
        for s in range(self.signals.count):
            for k in range(4):
                self.road[8 * s + 4 * end + k] = self.signals.road[4 * s + k]

    @inline
    def _sum_all(self, n: int, known: bool) -> None:
        """Read all rows at the end of the attempt, and at its start unless they are known there."""
        if not known:
            self._sum_rows(n, 0, self.elements.rows, 0)
        self._sum_rows(n, 0, self.elements.rows, 4)

    @inline
    def _sum_rows(self, n: int, first: int, last: int, end: int) -> None:
        """Read rows from `first` to before `last` at the start (`end` 0) or end (4) of the attempt."""
        if end:
            q, v, a, j = self.motion.qb, self.motion.vb, self.motion.ab, self.motion.end_jerk
        else:
            q, v, a, j = self.motion.q, self.motion.v, self.motion.a, self.motion.jerk
        row, road, direction = self.row, self.road, self.elements.row_direction
        for r in range(first, last):
            d0 = 0.0
            d1 = 0.0
            d2 = 0.0
            d3 = 0.0
            for i in range(n):
                b = direction[r * n + i]
                d0 += b * q[i]
                d1 += b * v[i]
                d2 += b * a[i]
                d3 += b * j[i]
            s = self.elements.row_signal[r]
            if s >= 0:
                at = 8 * s + end
                d0 -= road[at]
                d1 -= road[at + 1]
                d2 -= road[at + 2]
                d3 -= road[at + 3]
            at = 8 * r + end
            row[at] = d0
            row[at + 1] = d1
            row[at + 2] = d2
            row[at + 3] = d3


@inline
def _carry(x: Doubles, count: int) -> None:
    """Copy the four numbers at the end of each row or signal to those at its start."""
    for at in range(0, 8 * count, 8):
        x[at] = x[at + 4]
        x[at + 1] = x[at + 5]
        x[at + 2] = x[at + 6]
        x[at + 3] = x[at + 7]
