"""Outputs over a whole run as columns, from the arrays that the integrator fills in one call.

Every output over time that is a number is linear in displacements, velocities, accelerations, forces of
the elements and the road; contact follows from the instants at which it was lost and regained.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import add, attrgetter, mul
from typing import Any

from .engine import KINDS
from .outputs import SUSPENSION, Contact
from .systems import Axle, System

DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = range(4)
_ORDERS = ("displacement", "velocity", "acceleration")
_CONTACT = {  # attributes of `Contact` by the outputs' names
    "airborne": "airborne", "lift_off_count": "lift_offs", "last_lift_off": "last_lift_off",
    "last_touchdown": "last_touchdown",
}  # fmt: skip
Column = Sequence[float]


@dataclass(frozen=True, slots=True)
class Line:
    """An output `offset + sum b x + road_factor u`.

    Parameters
    ----------
    kind : what x is: DISPLACEMENT, VELOCITY, ACCELERATION or FORCE
    direction : b by the index of the coordinate or element
    road : name of the signal u, or empty; of velocities its rate
    """

    kind: int
    direction: Mapping[int, float]
    road: str = ""
    road_factor: float = -1.0
    offset: float = 0.0


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
    for axle in system.axles:
        yield from ((f"{axle.prefix}{name}", line) for name, line in _of_axle(axle, system))


def _of_axle(axle: Axle, system: System) -> Iterator[tuple[str, Line]]:
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
        yield "contact_force", Line(FORCE, {e: -1.0}, offset=axle.static_load)


def _terms(direction: Sequence[float]) -> dict[int, float]:
    return {i: b for i, b in enumerate(direction) if b != 0.0}


def over_time(system: System) -> list[str]:
    """Names of the outputs that `Series.column` gives."""
    return [*lines(system), *_of_tyres(system, _CONTACT)]


def at_the_end(system: System) -> list[str]:
    """Names of the outputs that `Series.at_end` gives."""
    return ["step_count", *_of_tyres(system, ("airborne_time", *_CONTACT))]


def _of_tyres(system: System, names: Iterable[str]) -> dict[str, tuple[Axle, str]]:
    """What there is to be told of every tyre: its axle, and what."""
    return {f"{a.prefix}{name}": (a, name) for a in system.axles if a.tyre for name in names}


class Series:
    """The columns of a run.

    Parameters
    ----------
    system : what is to be stepped
    integrator : its integrator, at the start
    times : s, ascending
    names : the outputs that are wanted
    """

    def __init__(
        self, system: System, integrator: Any, times: array[float], names: Sequence[str]
    ) -> None:
        self._system, self._integrator, self._times = system, integrator, times
        self._lines = {name: line for name, line in _lines(system) if name in names}
        kinds = {line.kind for line in self._lines.values()}
        if ACCELERATION in kinds:
            kinds.add(FORCE)  # accelerations are those of the equation of motion
        n, elements, rows = len(system.mass), len(system.elements), len(times)
        self._width = {kind: elements if kind == FORCE else n for kind in range(4)}
        self._filled = {
            kind: array("d", bytes(8 * self._width[kind] * rows)) for kind in {*kinds, DISPLACEMENT}
        }

    def run(self) -> int:
        """Step over all instants; 0, or the key of `FAILURES` that says why it ended before."""
        return int(self._integrator.run(self._times, *map(self._filled.get, range(4))))

    def column(self, name: str) -> Column:
        """An output at all instants that were reached."""
        line = self._lines.get(name)
        if line is not None:
            return self._of_line(line)
        return self._of_contact(name, self._times[: self._integrator.filled])

    def _of_line(self, line: Line) -> Column:
        rows, width = self._integrator.filled, self._width[line.kind]
        found = self._filled.get(line.kind, array("d"))
        terms = [(b, found[i : width * rows : width]) for i, b in line.direction.items()]
        if not line.road and not line.offset and [b for b, _ in terms] == [1.0]:
            return terms[0][1]
        column = [0.0] * rows
        for b, x in terms:
            column = list(map(add, column, map(mul, x, [b] * rows)))
        if line.road:
            signal, factor = self._system.signals[line.road], line.road_factor
            column = [
                c + factor * signal.derivatives(t)[line.kind]
                for c, t in zip(column, self._times, strict=False)
            ]
        return [line.offset + c for c in column] if line.offset else column

    def _of_contact(self, name: str, times: array[float]) -> Column:
        """Contact as it stands at these instants, from the switches located."""
        axle, what = _of_tyres(self._system, _CONTACT)[name]
        tyre, read = self._system.element(axle.tyre), attrgetter(_CONTACT[what])
        switches = [
            (time, bool(after))
            for time, element, kind, _, after in self._integrator.log
            if element == tyre and KINDS[kind] == "contact"
        ]
        contact, column, k = Contact(), array("d"), 0
        for t in times:
            while k < len(switches) and switches[k][0] <= t:
                contact.switch(*switches[k])
                k += 1
            column.append(read(contact))
        return column

    def at_end(self, name: str) -> float:
        """An output at the last instant, of those that add up over the run."""
        if name == "step_count":
            return int(self._integrator.step_count)
        axle, what = _of_tyres(self._system, ("airborne_time", *_CONTACT))[name]
        if what in _CONTACT:
            return self._of_contact(name, self._times[-1:])[0]
        tyre = self._system.element(axle.tyre)
        return float(self._integrator.limited_time_at(tyre, self._times[-1]))
