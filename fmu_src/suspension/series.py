"""Outputs over a whole run as columns, from the arrays that the integrator fills in one call.

Every output over time that is a number is linear in displacements, velocities, accelerations, forces of
the elements and the road; contact follows from the instants at which it was lost and regained.
"""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import repeat
from operator import add, attrgetter, mul
from typing import Any

from .engine import KINDS
from .outputs import SUSPENSION, Contact
from .signals import Signal
from .systems import System

_OF_CONTACT = KINDS.index("contact")
DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = range(4)
_ORDERS = ("displacement", "velocity", "acceleration")
_CONTACT = {  # attributes of `Contact` by the outputs' names
    "airborne": "airborne", "lift_off_count": "lift_offs", "last_lift_off": "last_lift_off",
    "last_touchdown": "last_touchdown",
}  # fmt: skip
Column = Sequence[float]


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
    system : what is to be stepped; further ones may differ from it in their numbers
    times : s, ascending
    names : the outputs that are wanted over time
    at_end : those that are wanted at the last instant
    """

    def __init__(
        self, system: System, times: array[float], names: Sequence[str], at_end: Sequence[str] = ()
    ) -> None:
        self._system, self._times, self._names, self._at_end = system, times, names, at_end
        self._roads: dict[tuple[str, int], tuple[Signal, Column]] = {}
        self._find_lines()
        self._tyres = _of_tyres(system, ("airborne_time", *_CONTACT))
        kinds = {line.kind for line in self._lines.values()}
        if ACCELERATION in kinds:
            kinds.add(FORCE)  # accelerations are those of the equation of motion
        n, elements, rows = len(system.mass), len(system.elements), len(times)
        self._width = {kind: elements if kind == FORCE else n for kind in range(4)}
        self._filled = {
            kind: array("d", bytes(8 * self._width[kind] * rows)) for kind in {*kinds, DISPLACEMENT}
        }

    def _find_lines(self) -> None:
        self._lines = {name: line for name, line in _lines(self._system) if name in self._names}

    def prepare(self, system: System, integrator: Any) -> None:
        """Let an integrator of this system, at the start, fill the columns when it runs."""
        moved, self._system = system.motions != self._system.motions, system
        if moved:
            self._find_lines()
        self._integrator = integrator
        integrator.prepare(self._times, *map(self._filled.get, range(4)))

    def columns(self) -> dict[str, Column]:
        """The outputs over time at all instants that were reached."""
        return {name: self._column(name) for name in self._names}

    def ends(self) -> dict[str, float]:
        """The outputs at the last instant, of those that add up over the run."""
        return {name: self._end(name) for name in self._at_end}

    def _column(self, name: str) -> Column:
        line = self._lines.get(name)
        if line is not None:
            return self._of_line(line)
        return self._of_contact(name, self._times[: self._integrator.filled])

    def _of_line(self, line: Line) -> Column:
        rows, width = self._integrator.filled, self._width[line.kind]
        found = self._filled.get(line.kind, array("d"))
        terms = [(b, found[i : width * rows : width]) for i, b in line.direction.items()]
        if not line.road and line.axle is None and [b for b, _ in terms] == [1.0]:
            return terms[0][1]
        column = [0.0] * rows
        for b, x in terms:
            column = list(map(add, column, map(mul, x, repeat(b))))
        if line.road:
            under = map(mul, repeat(line.road_factor), self._under(line.road, line.kind))
            column = list(map(add, column, under))
        if line.axle is None:
            return column
        return list(map(add, column, repeat(self._system.axles[line.axle].static_load)))

    def _under(self, road: str, order: int) -> Column:
        """A road or its rate at all instants, found once for as long as it is the same road."""
        signal = self._system.signals[road]
        known, column = self._roads.get((road, order), (None, []))
        if known is not signal:
            column = [signal.derivatives(t)[order] for t in self._times]
            self._roads[road, order] = signal, column
        return column

    def _of_contact(self, name: str, times: array[float]) -> Column:
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
