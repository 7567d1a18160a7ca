"""Outputs over whole runs as columns, from the arrays that the integrator fills in one batch.

Every numeric output over time is linear in displacements, velocities, accelerations, forces of the
elements and the road, or the residual of the energy balance; contact follows from the times at which it
was lost and regained.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import ceil, cos, sin
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..engine import KINDS, Filling, Integrator, RunQueue
from ..outputs import (
    ACCELERATION,
    DISPLACEMENT,
    FORCE,
    VELOCITY,
    Contact,
    Line,
    OfContact,
    OfRun,
    Reading,
    is_of_switches,
    reading_of,
)
from ..signals import Signal
from ..systems import System
from ..variable import Variable

_OF_CONTACT = KINDS.index("contact")
_MOST_RUNS = 64  # in one batch
_MOST_FILLED = 50_000  # numbers that the integrator fills in one batch
_MOST_MARKS = 1_000  # of a run, apart by at least
_LEAST_APART = 8  # instants
RESIDUAL = OfRun("energy_residual")
_RESIDUAL = -1  # its place among the quantities
Column = npt.NDArray[np.float64]
_Filled = Mapping[int, npt.NDArray[np.float64]]
_Log = Sequence[tuple[float, int, int, int, int]]


def is_over_time(reading: Reading) -> bool:
    """Return whether `Series.go` can fill an output."""
    return isinstance(reading, Line) or reading == RESIDUAL or is_of_switches(reading)


def is_at_end(reading: Reading) -> bool:
    """Return whether `Series.ends` can return an output."""
    return isinstance(reading, OfContact) or reading == OfRun("step_count")


class Ended(NamedTuple):
    """The end of a run.

    Parameters
    ----------
    status : 0, or the key of its failure in `engine.FAILURES`
    filled : number of times that it reached
    time : at which it ended, s
    steps : number of steps taken
    log_end : index at which its switches end in the log of the batch
    beyond_since, beyond_step : since when its fixed step was too long, and the stable step then, s
    overruns : number of switches without time between them
    """

    status: int
    filled: int
    time: float
    steps: int
    log_end: int
    beyond_since: float
    beyond_step: float
    overruns: float


class Series:
    """The columns of runs over the same times, made one after the other by one integrator.

    Parameters
    ----------
    integrator : the integrator
    system : the system of one run; those of others may differ in their numbers
    times : s, ascending
    over_time : outputs over time by name
    at_end : outputs at the last time by name
    corners : whether `switches` are needed
    twice : whether `again` is

    Attributes
    ----------
    needs_systems : whether the systems of all runs are needed, or their numbers are enough
    """

    def __init__(
        self,
        integrator: Integrator,
        system: System,
        times: array[float],
        over_time: Mapping[str, Variable],
        at_end: Mapping[str, Variable],
        corners: bool = False,
        twice: bool = False,
    ) -> None:
        self._integrator, self._times, self._declared = integrator, times, [*over_time.values()]
        self._roads: dict[str, _Course] = {}
        self._readings = [reading_of(output, system) for output in self._declared]
        self._at_end = {name: reading_of(v, system) for name, v in at_end.items()}
        self.needs_systems = corners or any(
            isinstance(one, Line) and one.index is None for one in self._readings
        )
        self._logged = corners or any(
            map(is_of_switches, (*self._readings, *self._at_end.values()))
        )
        kinds = {one.quantity for one in self._readings if isinstance(one, Line)}
        if ACCELERATION in kinds:
            kinds.add(FORCE)  # accelerations are those of the equation of motion
        n, elements = len(system.mass), len(system.elements)
        self._wide = {kind: elements if kind == FORCE else n for kind in {*kinds, DISPLACEMENT}}
        if RESIDUAL in self._readings:
            self._wide[_RESIDUAL] = 1
        room = _MOST_FILLED // (len(times) * sum(self._wide.values()))
        self._filled, filling = self._room(min(max(room, 1), _MOST_RUNS), times)
        every = max(ceil(len(times) / _MOST_MARKS), _LEAST_APART) if twice else 0
        self._rows = RunQueue(filling, self._logged, every)

    def _room(self, runs: int, times: array[float]) -> tuple[_Filled, Filling]:
        """Return arrays for the results of runs, by quantity, and what fills them."""
        filled = {kind: np.empty((runs, wide, len(times))) for kind, wide in self._wide.items()}
        flat = {kind: x.reshape(-1) for kind, x in filled.items()}
        others = map(flat.get, (VELOCITY, ACCELERATION, FORCE, _RESIDUAL))
        return filled, Filling(self._integrator, times, flat[DISPLACEMENT], *others, runs=runs)

    def take(self, systems: Sequence[System], numbers: array[float]) -> None:
        """Store the systems of all runs, if needed, and the `row` of each, one after the other."""
        self._systems = systems
        self._rows.take(numbers, self._times[0])

    def go(self, first: int, into: npt.NDArray[np.float64]) -> list[Ended]:
        """Make at least one run, from `first` on, and return the ends of the runs made.

        Parameters
        ----------
        into : the columns of all runs, (outputs, runs, times); those of a failed run are valid up to
            its end
        """
        ended = [*map(Ended._make, self._rows.go(first, into.shape[1]))]
        self._logs = self._taken_apart(ended) if self._logged else []
        runs = range(len(ended))
        self._fill_in(into[:, first : first + len(ended)], self._times, self._filled, first, runs)
        return ended

    def again(self, run: int, k: int, times: array[float]) -> npt.NDArray[np.float64]:
        """Return the columns of a run at other times after its start, s, ascending: (outputs, times).

        Only steps near these times are made again, each from the mark before it.

        Parameters
        ----------
        run : its number
        k : its number in the last batch
        times : s, ascending, within the run
        """
        filled, filling = self._room(1, times)
        marks = self._rows.marks[k]
        self._rows.return_to(k)
        last_before = np.searchsorted([time for time, _ in marks], times) - 1
        for end in [*np.flatnonzero(np.diff(last_before)) + 1, len(times)]:
            self._integrator.restore(marks[last_before[end - 1]][1])
            filling.fill(int(end))
        columns = np.empty((len(self._readings), 1, len(times)))
        self._fill_in(columns, times, filled, run, range(k, k + 1))
        return columns[:, 0]

    def _fill_in(
        self, into: Column, times: array[float], filled: _Filled, first: int, batch: range
    ) -> None:
        """Find the columns, (outputs, runs, times), of runs of the last batch, from `first` on."""
        last = first + len(batch)
        with np.errstate(all="ignore"):  # a motion may have diverged
            for column, reading, output in zip(into, self._readings, self._declared, strict=True):
                if isinstance(reading, OfContact):
                    for row, k in zip(column, batch, strict=True):
                        row[:] = self._of_contact(reading, times, self._logs[k], k)
                elif reading == RESIDUAL:
                    column[:] = filled[_RESIDUAL][: len(batch), 0]
                elif isinstance(reading, Line) and reading.index is not None:
                    column[:] = filled[reading.quantity][: len(batch), reading.index]
                else:
                    self._fill(column, output, self._systems[first:last], times, filled)

    def _taken_apart(self, ended: Sequence[Ended]) -> list[_Log]:
        """Return the switches of each run of the last batch."""
        log, ends = self._integrator.log, [0, *(one.log_end for one in ended)]
        return [log[a:b] for a, b in pairwise(ends)]

    def ends(self, k: int, ended: Ended) -> dict[str, float]:
        """Return the outputs at the last time of run k of the last batch."""
        return {name: self._end(reading, k, ended) for name, reading in self._at_end.items()}

    def switches(self, k: int) -> list[float]:
        """Return the times at which an element changed its branch in run k of the last batch, s."""
        return [instant for instant, *_ in self._logs[k]]

    def failure(self, k: int) -> BaseException | None:
        """Return what a function has raised to end run k of the last batch, or None."""
        return self._rows.failures[k]

    def _fill(
        self, column: Column, output: Variable, systems: Sequence[System], times: array[float],
        filled: _Filled,
    ) -> None:  # fmt: skip
        """Fill the column of successive runs, (runs, times), with sum b x + sum c u + offset."""
        lines: list[Line] = [reading_of(output, system) for system in systems]  # type: ignore[misc]
        first = lines[0]
        x = filled[first.quantity]
        column[:] = 0.0
        for k, (i, _) in enumerate(first.terms):
            column += x[: len(lines), i] * _upright(line.terms[k][1] for line in lines)
        for k, (name, _) in enumerate(first.signals):
            for run, (line, system) in enumerate(zip(lines, systems, strict=True)):
                course = self._course(name, system).at(times, first.quantity)
                column[run] += line.signals[k][1] * course
        column += _upright(line.offset for line in lines)

    def _course(self, name: str, system: System) -> _Course:
        """Return a signal as arrays; cached while it is the same."""
        signal = system.signals[name]
        if name not in self._roads or self._roads[name].signal.segments is not signal.segments:
            self._roads[name] = _Course(signal)
        return self._roads[name]

    def _of_contact(
        self, reading: OfContact, times: array[float], log: _Log, run: int
    ) -> array[float]:
        """Return a contact output at given times, from the switches in a run of the last batch."""
        read = attrgetter(reading.what)
        switches = [
            (instant, bool(before), bool(after))
            for instant, element, kind, before, after in log
            if element == reading.tyre and kind == _OF_CONTACT
        ]
        # a wheel that starts in flight has not lifted off: only its touchdown is a switch
        flies = switches[0][1] if switches else self._rows.limited_time(run, reading.tyre) > 0.0
        contact, column = Contact(airborne=flies), array("d")
        for instant, _, after in switches:
            before = array("d", [read(contact)])
            column += before * (bisect_left(times, instant) - len(column))
            contact.switch(instant, after)
        return column + array("d", [read(contact)]) * (len(times) - len(column))

    def _end(self, reading: Reading, k: int, ended: Ended) -> float:
        if not isinstance(reading, OfContact):
            return ended.steps
        if is_of_switches(reading):
            return self._of_contact(reading, self._times[-1:], self._logs[k], k)[0]
        return float(self._rows.limited_time(k, reading.tyre))


def _upright(numbers: Any) -> Column:
    """Return one number per run as a factor for the columns, (runs, 1)."""
    return np.array([*numbers])[:, None]


class _Course:
    """A signal at many times at once, to the bit as `Signal.derivatives` has it."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self._numbers = np.frombuffer(signal.doubles).reshape(len(signal.segments), -1).T
        self._found: dict[int, Column] = {}  # by order, at the times last asked for
        self._times: array[float] | None = None

    def at(self, times: array[float], order: int) -> Column:
        """Return the values (order 0) or the rates (1) at times, s."""
        if times is not self._times:
            self._times, self._found = times, {}
        if order not in self._found:
            self._found[order] = self._sampled(np.asarray(times), order)
        return self._found[order]

    def _sampled(self, times: Column, order: int) -> Column:
        at = np.searchsorted(self._numbers[0, 1:], times, side="right")
        _, origin, c0, c1, c2, c3, amplitude, *phase = self._numbers[:, at]
        s = times - origin
        if order == VELOCITY:
            column = c1 + s * (2.0 * c2 + s * 3.0 * c3)
        else:
            column = c0 + s * (c1 + s * (c2 + s * c3))
        waves = np.flatnonzero(amplitude)
        if len(waves):
            s, (p0, p1, p2) = s[waves], (p[waves] for p in phase)
            angle = (p0 + s * (p1 + s * p2)).tolist()
            if order == VELOCITY:  # numpy's sine may differ from that of `math`
                column[waves] -= amplitude[waves] * [*map(sin, angle)] * (p1 + 2.0 * p2 * s)
            else:
                column[waves] += amplitude[waves] * [*map(cos, angle)]
        return column
