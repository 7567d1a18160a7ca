"""Runs of systems that differ only in their numbers, one after the other."""

from __future__ import annotations

import cython

from ..arrays import Lent, Memory
from ..language import Lendable, Size, of_python, open_to_python, uses_python
from ..outcomes import DIVERGED, NO_MASS, PAUSED
from ..switching.switch_log import CAPACITY
from .filling import Filling


class RunQueue:
    """Runs of systems that differ only in their numbers, in sequence, without Python in between.

    Other Python threads can run meanwhile.

    Parameters
    ----------
    filling : the arrays that the runs of one batch fill
    logs : whether to log the switches of all runs of a batch
    every : least instants between two marks of a run, from which it can be resumed; 0 for no marks

    Attributes
    ----------
    marks : for each run of the last batch the times (s) and snapshots of its marks
    failures : for each run of the last batch the exception of a function that has ended it, or None
    """

    marks: list[list[tuple[float, bytes]]]
    failures: list[BaseException | None]

    def __init__(self, filling: Filling, logs: bool, every: Size = 0) -> None:
        self.filling, self.logs, self.every = filling, logs, every
        self.integrator = self.filling.integrator
        most = self.most = self.filling.runs
        self.width = 1 + 2 * self.integrator.net.series.outer + self.integrator.net.size
        self.contacts = self.integrator.limited.count
        self.memory = memory = Memory()
        self.status, self.filled = memory.marks(most), memory.marks(most)
        self.steps, self.log_end = memory.marks(most), memory.marks(most)
        self.time, self.limited = memory.zeros(most), memory.zeros(most * max(self.contacts, 1))
        # since when a fixed step was too long, and the stable step then, s; overruns
        self.doubts = memory.zeros(3 * most)

    @of_python
    def take(self, numbers: Lendable, start: float) -> None:
        """Set the rows of all runs.

        Parameters
        ----------
        numbers : the `row` of each run, one after the other; an array of doubles
        start : start time of all runs, s

        Raises
        ------
        ValueError : if the rows are of another system.
        """
        if len(numbers) % self.width:
            raise ValueError(f"{len(numbers)} numbers do not form whole rows of {self.width}")
        self.lent = Lent(numbers)
        self.numbers = self.lent.numbers
        self.start = start
        self.rows: Size = len(numbers) // self.width

    @open_to_python
    def go(
        self, first: Size, last: Size
    ) -> list[tuple[int, int, float, int, int, float, float, float]]:
        """Make the runs from `first` up to `last`, or as many of them as fit; at least one.

        At most as many fit as into the arrays; with a log, the next run starts only while three quarters
        of the log are empty.

        Returns
        -------
        For each run 0 or the key in `outcomes.FAILURES` of the reason why it ended early, the number of
        instants reached, time (s) and number of steps at its end, the end of its switches in `log`, since
        when a fixed step was too long and the stable step then (s; 0 if it never was), and the number of
        overruns.

        Raises
        ------
        ValueError : if rows for these runs are missing.
        """
        one, filling = self.integrator, self.filling
        if not 0 <= first < last <= self.rows:
            raise ValueError(f"runs {first} to {last} of {self.rows}: no such rows")
        one.take_log()
        self.first = first
        self.wanted: Size = min(last - first, self.most)
        self.made: Size = 0
        self.marks = [[] for _ in range(self.wanted)]
        self.failures = [None for _ in range(self.wanted)]
        self.underway = False
        while True:
            with cython.nogil:
                paused = self._go()
            if not paused:
                break
            if not self.underway:
                failure = one.take_failure()
                if self.status[self.made - 1] != 0:
                    self.failures[self.made - 1] = failure
                continue
            if filling.is_at_mark():
                self.marks[self.made].append((one.state.time, one.snapshot()))
                filling.next_mark = filling.filled + self.every
                continue
            status = one.reason_to_end(filling.instants[filling.count - 1])
            if status != 0:
                self._end(status)
        one.raise_failure(0)  # an interrupt alone
        return [
            (
                self.status[k],
                self.filled[k],
                self.time[k],
                self.steps[k],
                self.log_end[k],
                self.doubts[3 * k],
                self.doubts[3 * k + 1],
                self.doubts[3 * k + 2],
            )
            for k in range(self.made)
        ]

    @open_to_python
    @uses_python
    def return_to(self, k: Size) -> None:
        """Return to the system of run k of the last batch, so that its marks can be restored."""
        self.integrator.begin_row(self.numbers, (self.first + k) * self.width, self.start)

    @of_python
    def limited_time(self, k: int, e: int) -> float:
        """Return how long element e was at its limit, s, in run k of the last batch."""
        for i in range(self.contacts):
            if self.integrator.limited.element[i] == e:
                return self.limited[k * self.contacts + i]
        return 0.0  # it has no limit

    def _go(self) -> bool:
        """Return whether a run has paused, or has ended after an exception of a function.

        Otherwise all runs have been made, or as many as fit.
        """
        while self.made < self.wanted:
            status = 0
            if not self.underway:
                if not self.logs:
                    self.integrator.noted.logged = 0
                elif self.integrator.noted.logged > CAPACITY // 4:
                    return False
                status = self._begin()
            if status == 0:
                status = self.filling.go_on(self.made)
            if status == PAUSED:
                return True
            self._end(status)
            if self.integrator.net.laws.raised:
                return True
        return False

    def _begin(self) -> int:
        at = (self.first + self.made) * self.width
        status = self.integrator.begin_row(self.numbers, at, self.start)
        self.integrator.pace.look_at_pace()
        self.filling.begin()
        if self.every > 0:
            self.filling.next_mark = 0
        self.underway = True
        if status != 0:
            return NO_MASS
        return DIVERGED if self.integrator.net.laws.failed else 0

    def _end(self, status: int) -> None:
        """Store how the present run has ended."""
        k = self.made
        self.status[k], self.filled[k] = status, self.filling.filled
        self.time[k], self.steps[k] = self.integrator.state.time, self.integrator.state.step_count
        self.doubts[3 * k] = self.integrator.state.beyond_since
        self.doubts[3 * k + 1] = self.integrator.state.beyond_step
        self.doubts[3 * k + 2] = self.integrator.state.overruns
        self.log_end[k] = self.integrator.noted.flushed + self.integrator.noted.logged
        for i in range(self.integrator.limited.count):
            self.limited[k * self.contacts + i] = self.integrator.limited_time_at(
                self.integrator.limited.element[i], self.filling.instants[self.filling.count - 1]
            )
        self.made += 1
        self.underway = False
