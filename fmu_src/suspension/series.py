"""Outputs over whole runs as columns, from the arrays that the integrator fills in one batch.

Every numeric output over time is linear in displacements, velocities, accelerations, forces of the
elements and the road; contact follows from the times at which it was lost and regained.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .engine import KINDS, Rows
from .many import Many, of_run
from .outputs import SUSPENSION, Contact
from .signals import Segment, Signal
from .systems import System

_OF_CONTACT = KINDS.index("contact")
_MOST_RUNS = 64  # in one batch
_MOST_FILLED = 50_000  # numbers that the integrator fills in one batch
DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = range(4)
_ORDERS = ("displacement", "velocity", "acceleration")
_CONTACT = {  # attributes of `Contact` by the outputs' names
    "airborne": "airborne", "lift_off_count": "lift_offs", "last_lift_off": "last_lift_off",
    "last_touchdown": "last_touchdown",
}  # fmt: skip
Column = npt.NDArray[np.float64]
_Log = Sequence[tuple[float, int, int, int, int]]


@dataclass(frozen=True, slots=True)
class Line:
    """An output `sum b x + road_factor u + offset`.

    Parameters
    ----------
    kind : the kind of x: DISPLACEMENT, VELOCITY, ACCELERATION or FORCE
    direction : b by the index of the coordinate or element
    road : name of the signal u, or empty; for velocities its rate is used
    axle : index of the axle whose static load is the offset; None for no offset
    """

    kind: int
    direction: Mapping[int, float]
    road: str = ""
    road_factor: float = -1.0
    axle: int | None = None

    def is_alone(self) -> bool:
        """Return whether it is a single entry of x."""
        return not self.road and self.axle is None and list(self.direction.values()) == [1.0]


def lines(system: System) -> dict[str, Line]:
    """Return the linear outputs of a system."""
    return dict(_lines(system))


def _lines(system: System) -> Iterator[tuple[str, Line]]:
    for i, name in enumerate(system.coordinates):
        for kind, what in enumerate(_ORDERS):
            yield f"{name}_{what}".lstrip("_"), Line(kind, {i: 1.0})
    for motion in system.motions:
        for kind, name in enumerate(motion.names):
            yield name, Line(kind, _terms(motion.direction))
    for e, element in enumerate(system.elements):
        yield f"{element.name}_force", Line(FORCE, {e: 1.0})
    for k, axle in enumerate(system.axles):
        yield from ((f"{axle.prefix}{name}", line) for name, line in _of_axle(k, system))


def _of_axle(k: int, system: System) -> Iterator[tuple[str, Line]]:
    axle = system.axles[k]
    road = "" if axle.tyre else axle.road
    for kind, ending in ((DISPLACEMENT, ""), (VELOCITY, "_rate")):
        yield f"suspension_deflection{ending}", Line(kind, _terms(axle.suspension), road)
        what = "velocity" if kind else "elevation"
        yield f"ground_{what}", Line(kind, {}, axle.road, 1.0)
    for name in SUSPENSION:
        if system.element(f"{axle.prefix}{name}") is None:
            yield f"{name}_force", Line(FORCE, {})
    e = system.element(axle.tyre)
    if e is not None:
        tyre = system.elements[e]
        for kind, ending in ((DISPLACEMENT, ""), (VELOCITY, "_rate")):
            yield f"tyre_deflection{ending}", Line(kind, _terms(tyre.direction), tyre.road)
        yield "tyre_force", Line(FORCE, {e: 1.0})
        yield "contact_force", Line(FORCE, {e: -1.0}, axle=k)


def _terms(direction: Sequence[float]) -> dict[int, float]:
    return {i: b for i, b in enumerate(direction) if b != 0.0}


def over_time(system: System) -> list[str]:
    """Return the names of the outputs of `Series.go`."""
    return [*lines(system), *_of_tyres(system, _CONTACT)]


def at_the_end(system: System) -> list[str]:
    """Return the names of the outputs of `Series.ends`."""
    return ["step_count", *_of_tyres(system, ("airborne_time", *_CONTACT))]


def _of_tyres(system: System, names: Iterable[str]) -> dict[str, tuple[int | None, str]]:
    """Return the element and the quantity of each contact output of every tyre."""
    return {
        f"{a.prefix}{name}": (system.element(a.tyre), name)
        for a in system.axles if a.tyre for name in names
    }  # fmt: skip


class Ended(NamedTuple):
    """The end of a run.

    Parameters
    ----------
    status : 0, or the key of its failure in `engine.FAILURES`
    filled : number of times that it reached
    time : at which it ended, s
    steps : number of steps taken
    log_end : index at which its switches end in the log of the batch
    """

    status: int
    filled: int
    time: float
    steps: int
    log_end: int


class Series:
    """The columns of runs over the same times, made one after the other by one integrator.

    Parameters
    ----------
    integrator : the integrator
    system : the system of one or many runs (see `many`); other systems may differ in their numbers
    times : s, ascending
    names : outputs over time
    at_end : outputs at the last time
    corners : whether `switches` and `joints` are needed
    """

    def __init__(
        self,
        integrator: Any,
        system: System,
        times: array[float],
        names: Sequence[str],
        at_end: Sequence[str] = (),
        corners: bool = False,
    ) -> None:
        self._times, self._names, self._at_end = times, names, at_end
        self._roads: dict[tuple[str, int], tuple[tuple[Segment, ...], Column]] = {}
        self._tyres = _of_tyres(system, ("airborne_time", *_CONTACT))
        wanted = {what for name, (_, what) in self._tyres.items() if name in {*names, *at_end}}
        self._logged = corners or not wanted <= {"airborne_time"}
        self._integrator = integrator
        self.enter(system)
        kinds = {line.kind for line in self._lines if line is not None}
        if ACCELERATION in kinds:
            kinds.add(FORCE)  # accelerations are those of the equation of motion
        n, elements = len(system.mass), len(system.elements)
        wide = {kind: elements if kind == FORCE else n for kind in {*kinds, DISPLACEMENT}}
        room = _MOST_FILLED // (len(times) * sum(wide.values()))
        most = min(max(room, 1), _MOST_RUNS)
        self._filled = {kind: np.empty((most, wide[kind], len(times))) for kind in wide}
        filled = (self._filled.get(kind) for kind in range(4))
        integrator.prepare(most, times, *(x if x is None else x.reshape(-1) for x in filled))
        self._rows = Rows(integrator, self._logged)

    def enter(self, system: System) -> None:
        """Prepare for runs of another system."""
        self._system = system
        found = dict(_lines(system))
        self._lines = [found.get(name) for name in self._names]
        self._alone = [line is not None and line.is_alone() for line in self._lines]

    def take(self, numbers: npt.NDArray[np.float64]) -> None:
        """Store the `row` of each run, (runs, numbers)."""
        self._rows.take(numbers.reshape(-1).data, self._times[0])

    def go(self, first: int, into: npt.NDArray[np.float64]) -> list[Ended]:
        """Make at least one run, from `first` on, and return the ends of the runs made.

        Parameters
        ----------
        into : the columns of all runs, (outputs, runs, times); those of a failed run are valid up to
            its end
        """
        ended = [*map(Ended._make, self._rows.go(first, into.shape[1]))]
        self._logs = self._taken_apart(ended) if self._logged else []
        last = first + len(ended)
        with np.errstate(all="ignore"):  # a motion may have diverged
            for k, line in enumerate(self._lines):
                if line is None:
                    for run, log in enumerate(self._logs, first):
                        into[k, run] = self._of_contact(
                            self._names[k], self._times, log, run - first
                        )
                elif self._alone[k]:
                    filled = self._filled[line.kind][: last - first]
                    into[k, first:last] = filled[:, next(iter(line.direction))]
                else:
                    self._fill(into[k, first:last], line, first)
        return ended

    def _taken_apart(self, ended: Sequence[Ended]) -> list[_Log]:
        """Return the switches of each run of the last batch."""
        log, ends = self._integrator.log, [0, *(one.log_end for one in ended)]
        return [log[a:b] for a, b in pairwise(ends)]

    def ends(self, k: int, ended: Ended) -> dict[str, float]:
        """Return the outputs at the last time of run k of the last batch."""
        return {name: self._end(name, k, ended) for name in self._at_end}

    def switches(self, k: int) -> list[float]:
        """Return the times at which an element changed its branch in run k of the last batch, s."""
        return [instant for instant, *_ in self._logs[k]]

    def joints(self, runs: int) -> Column:
        """Return the times at which roads and loads have joints, s, ascending, (runs, joints)."""
        starts = [
            np.broadcast_to(np.asarray(segment.start), runs)
            for signal in self._system.signals.values()
            for segment in signal.segments[1:]
        ]
        return np.sort(np.array(starts, float).reshape(-1, runs).T, axis=1)

    def _fill(self, column: Column, line: Line, first: int) -> None:
        """Fill the column of successive runs, (runs, times), from run `first` on."""
        runs, filled = len(column), self._filled[line.kind]
        column[:] = 0.0
        for i, b in line.direction.items():
            column += filled[:runs, i] * _of_runs(b, first, runs)
        if line.road:
            for k in range(runs):
                column[k] += line.road_factor * self._under(line.road, line.kind, first + k)
        if line.axle is not None:
            column += _of_runs(self._system.axles[line.axle].static_load, first, runs)

    def _under(self, road: str, order: int, run: int) -> Column:
        """Return a road or its rate at all times; cached while the road is the same."""
        segments = of_run(self._system.signals[road].segments, run)
        known = self._roads.get((road, order))
        if known is None or known[0] is not segments:
            signal = Signal(segments)
            column = np.array([signal.derivatives(t)[order] for t in self._times])
            known = self._roads[road, order] = segments, column
        return known[1]

    def _of_contact(self, name: str, times: array[float], log: _Log, run: int) -> array[float]:
        """Return a contact output at given times, from the switches in a run of the last batch."""
        tyre, what = self._tyres[name]
        read = attrgetter(_CONTACT[what])
        switches = [
            (instant, bool(before), bool(after))
            for instant, element, kind, before, after in log
            if element == tyre and kind == _OF_CONTACT
        ]
        # a wheel that starts in flight has not lifted off: only its touchdown is a switch
        flies = switches[0][1] if switches else self._rows.limited_time(run, tyre) > 0.0
        contact, column = Contact(airborne=flies), array("d")
        for instant, _, after in switches:
            before = array("d", [read(contact)])
            column += before * (bisect_left(times, instant) - len(column))
            contact.switch(instant, after)
        return column + array("d", [read(contact)]) * (len(times) - len(column))

    def _end(self, name: str, k: int, ended: Ended) -> float:
        if name == "step_count":
            return ended.steps
        tyre, what = self._tyres[name]
        if what in _CONTACT:
            return self._of_contact(name, self._times[-1:], self._logs[k], k)[0]
        return float(self._rows.limited_time(k, tyre))


def _of_runs(number: float, first: int, runs: int) -> float | npt.NDArray[np.float64]:
    """Return the numbers of successive runs, shaped for their columns."""
    if isinstance(number, Many):
        return np.asarray(number)[first : first + runs, None]
    return number
