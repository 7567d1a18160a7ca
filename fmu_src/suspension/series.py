"""Outputs over a whole run as columns, from the arrays that the integrator fills in one call.

Every output over time that is a number is linear in displacements, velocities, accelerations, forces of
the elements and the road; contact follows from the instants at which it was lost and regained.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
import numpy.typing as npt

from .engine import KINDS
from .many import of_run
from .outputs import SUSPENSION, Contact
from .signals import Segment, Signal
from .systems import System

_OF_CONTACT = KINDS.index("contact")
DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = range(4)
_ORDERS = ("displacement", "velocity", "acceleration")
_CONTACT = {  # attributes of `Contact` by the outputs' names
    "airborne": "airborne", "lift_off_count": "lift_offs", "last_lift_off": "last_lift_off",
    "last_touchdown": "last_touchdown",
}  # fmt: skip
Column = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Line:
    """An output `sum b x + road_factor u + offset`.

    Parameters
    ----------
    kind : what x is: DISPLACEMENT, VELOCITY, ACCELERATION or FORCE
    direction : b by the index of the coordinate or element
    road : name of the signal u, or empty; of velocities its rate
    axle : number of the axle whose static load is the offset; None for no offset
    """

    kind: int
    direction: Mapping[int, float]
    road: str = ""
    road_factor: float = -1.0
    axle: int | None = None


def lines(system: System) -> dict[str, Line]:
    """The outputs of a system that are linear."""
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
    """Names of the outputs that `Series.column` gives."""
    return [*lines(system), *_of_tyres(system, _CONTACT)]


def at_the_end(system: System) -> list[str]:
    """Names of the outputs that `Series.at_end` gives."""
    return ["step_count", *_of_tyres(system, ("airborne_time", *_CONTACT))]


def _of_tyres(system: System, names: Iterable[str]) -> dict[str, tuple[int | None, str]]:
    """What there is to be told of every tyre: the number of its element, and what."""
    return {
        f"{a.prefix}{name}": (system.element(a.tyre), name)
        for a in system.axles if a.tyre for name in names
    }  # fmt: skip


class Series:
    """The columns of runs over the same instants.

    Parameters
    ----------
    system : what is to be stepped, one or many (see `many`); others may differ in their numbers
    times : s, ascending
    names : the outputs that are wanted over time
    at_end : those that are wanted at the last instant
    """

    def __init__(
        self, system: System, times: array[float], names: Sequence[str], at_end: Sequence[str] = ()
    ) -> None:
        self._times, self._names, self._at_end = times, names, at_end
        self._roads: dict[tuple[str, int], tuple[tuple[Segment, ...], Column]] = {}
        self._tyres = _of_tyres(system, ("airborne_time", *_CONTACT))
        kinds = {line.kind for name, line in _lines(system) if name in names}
        if ACCELERATION in kinds:
            kinds.add(FORCE)  # accelerations are those of the equation of motion
        n, elements, rows = len(system.mass), len(system.elements), len(times)
        self._filled = {
            kind: np.empty((elements if kind == FORCE else n, rows))
            for kind in {*kinds, DISPLACEMENT}
        }
        self.enter(system)

    def enter(self, system: System) -> None:
        """Get ready for runs of another system."""
        self._system = system
        found = dict(_lines(system))
        lines = [found.get(name) for name in self._names]
        alone = [None if line is None else self._filled_alone(line) for line in lines]
        self._alone = [(k, filled) for k, filled in enumerate(alone) if filled is not None]
        self._made = [(k, lines[k]) for k, filled in enumerate(alone) if filled is None]

    def _filled_alone(self, line: Line) -> Column | None:
        """The one column that a line is, if it is no more."""
        if line.road or line.axle is not None or list(line.direction.values()) != [1.0]:
            return None
        alone: Column = self._filled[line.kind][next(iter(line.direction))]
        return alone

    def prepare(self, integrator: Any) -> None:
        """Let an integrator fill the columns whenever it runs."""
        self._integrator = integrator
        filled = (self._filled.get(kind) for kind in range(4))
        integrator.prepare(self._times, *(x if x is None else x.reshape(-1) for x in filled))

    def columns(self, into: Sequence[Column], run: int = 0) -> dict[str, Column]:
        """The outputs over time at all instants that were reached, of one of the runs of a system.

        Parameters
        ----------
        into : an array for each of the outputs, which becomes its column
        """
        rows = self._integrator.filled
        if rows < len(self._times):
            into = [column[:rows] for column in into]
        for k, filled in self._alone:
            into[k][:] = filled if rows == len(filled) else filled[:rows]
        for k, line in self._made:
            if line is not None:
                self._fill(into[k], line, run)
            else:
                into[k][:] = self._of_contact(self._names[k], self._times[:rows])
        return dict(zip(self._names, into, strict=True))

    def ends(self) -> dict[str, float]:
        """The outputs at the last instant, of those that add up over the run."""
        return {name: self._end(name) for name in self._at_end}

    def _fill(self, column: Column, line: Line, run: int) -> None:
        rows = len(column)
        column[:] = 0.0
        with np.errstate(all="ignore"):  # a motion may have diverged
            for i, b in line.direction.items():
                column += self._filled[line.kind][i][:rows] * of_run(b, run)
            if line.road:
                column += line.road_factor * self._under(line.road, line.kind, run)[:rows]
            if line.axle is not None:
                column += of_run(self._system.axles[line.axle].static_load, run)

    def _under(self, road: str, order: int, run: int) -> Column:
        """A road or its rate at all instants, found once for as long as it is the same road."""
        segments = of_run(self._system.signals[road].segments, run)
        known = self._roads.get((road, order))
        if known is None or known[0] is not segments:
            signal = Signal(segments)
            column = np.array([signal.derivatives(t)[order] for t in self._times])
            known = self._roads[road, order] = segments, column
        return known[1]

    def _of_contact(self, name: str, times: array[float]) -> array[float]:
        """Contact as it stands at these instants, from the switches located."""
        tyre, what = self._tyres[name]
        read = attrgetter(_CONTACT[what])
        contact, column = Contact(), array("d")
        for instant, element, kind, _, after in self._integrator.log:
            if element == tyre and kind == _OF_CONTACT:
                before = array("d", [read(contact)])
                column += before * (bisect_left(times, instant) - len(column))
                contact.switch(instant, bool(after))
        return column + array("d", [read(contact)]) * (len(times) - len(column))

    def _end(self, name: str) -> float:
        if name == "step_count":
            return int(self._integrator.step_count)
        tyre, what = self._tyres[name]
        if what in _CONTACT:
            return self._of_contact(name, self._times[-1:])[0]
        return float(self._integrator.limited_time_at(tyre, self._times[-1]))
