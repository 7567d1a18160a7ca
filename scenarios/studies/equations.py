"""A system as switched first-order equations, for general solvers.

    y = (q, q'),   y' = f(t, y, p),   M q'' = sum l F - sum b f(b' q - u, b' q' - u')

The numbers p encode the branch of each element and the segment of each signal; between two switches
they are constant and f is smooth. Guards g(t, y, p) are positive within the branches and cross zero at a
switch. Both are generated as source text from the system, so that the same equations run in plain
Python, compiled by numba, or on the symbols of a Taylor integrator. The kernel of this package is not
used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.systems import Element, System

from .expressions import Course, Law, degrees_of, sum_of

Vector = npt.NDArray[np.float64]

# How far a branch reaches beyond its corner, relative for forces, else in m and m/s: more than the
# error of locating it, so that no switch repeats. As forces are continuous, this causes only an error
# proportional to its square.
LATE = 1e-11
LAWS = ("spring", "damper", "modulation")  # of an element


@dataclass(frozen=True, slots=True)
class Guard:
    """One end of a branch: `kind` of variable, `element`, and lower (-1) or upper (+1) bound."""

    element: int
    kind: str  # spring, damper, modulation, contact, gap, friction, multiplier
    side: int


class Equations:
    """The source text of f and of the guards of one system, and the layout of p.

    Attributes
    ----------
    memory : why elements cannot choose their branches from the state, or ""

    Raises
    ------
    ValueError : if an element has a power law, a user-defined function, or a spring in series with its
        damper.
    """

    def __init__(self, system: System) -> None:
        if any(element.series < inf for element in system.elements):
            raise ValueError("there is no independent solution for springs in series with dampers")
        self.system = system
        self.n = len(system.mass)
        self.size = 0  # of p
        self.inverse = np.linalg.inv(np.array(system.mass)).tolist()
        self.names = list(system.signals)
        self.courses = [self._course(signal) for signal in system.signals.values()]
        self.laws = {
            name: [
                self._law(getattr(e, name), yields=name == "spring" and e.yield_force < inf)
                for e in system.elements
            ]
            for name in LAWS
        }
        limited = [i for i, e in enumerate(system.elements) if e.limit < inf]
        self.contacts = {i: self._take(2) for i in limited}  # factor and constant of the force
        self.rubbing = [i for i, e in enumerate(system.elements) if e.friction > 0.0]
        self.slips = {i: self._take(1) for i in self.rubbing}  # friction force while slipping
        self.sticking = self._take(len(self.rubbing) ** 2)
        self.guards = tuple(self._guards())
        self.bounds = self._take(2 * len(self.guards))  # factor and constant of each guard
        memory = [e.name for e in system.elements if e.yield_force < inf or e.friction > 0.0]
        self.memory = f"{', '.join(memory)}: the force depends on the past" if memory else ""

    # -- layout of p ---------------------------------------------------------------------------------

    def _take(self, numbers: int) -> int:
        at = self.size
        self.size += numbers
        return at

    def _course(self, signal: Signal) -> Course:
        segments = signal.segments
        degrees = degrees_of(s.coefficients for s in segments)
        waves = any(s.amplitude != 0.0 for s in segments)
        course = Course(segments, degrees, waves)
        if len(segments) == 1:
            return course
        return replace(course, at=self._take(len(course.numbers(segments[0]))))

    def _law(self, law: Characteristic, *, yields: bool = False) -> Law:
        if any(piece.power or piece.own for piece in law.pieces):
            raise ValueError(
                "there is no independent solution for power laws and user-defined functions"
            )
        degrees = (0, 1) if yields else degrees_of(piece.coefficients for piece in law.pieces)
        made = Law(law.pieces, degrees, any(piece.saturation for piece in law.pieces))
        if len(law.pieces) == 1 and not yields:
            return made
        return replace(made, at=self._take(len(made.numbers(law.pieces[0]))))

    def _guards(self) -> Iterable[Guard]:
        for i, element in enumerate(self.system.elements):
            yields = element.yield_force < inf
            wanted = {
                "spring": len(element.spring.pieces) > 1 or yields,
                "damper": len(element.damper.pieces) > 1 or yields,
                "modulation": len(element.modulation.pieces) > 1,
                "contact": element.limit < inf,
                "gap": element.opening < inf,
                "friction": element.friction > 0.0,
                "multiplier": element.friction > 0.0,
            }
            for kind, needed in wanted.items():
                if needed:
                    yield from (Guard(i, kind, side) for side in (-1, 1))

    # -- source text -------------------------------------------------------------------------------

    def _written(self, *, choosing: bool) -> str:
        """Return the source of the functions; with `choosing`, that of `rhs` only."""
        shared = [*self._signal_lines(), *self._force_lines(choosing=choosing)]
        rates = [f"dy[{i}] = y[{self.n + i}]" for i in range(self.n)]
        rates += [f"dy[{self.n + i}] = a{i}" for i in range(self.n)]
        rhs = _function("rhs(t, y, dy, p)", [*shared, *rates])
        if choosing:
            return rhs
        values = {"spring": "d{}", "modulation": "d{}", "damper": "w{}", "friction": "w{}",
                  "contact": "free{}", "gap": "d{}", "multiplier": "stick{}"}  # fmt: skip
        tests = []
        for k, guard in enumerate(self.guards):
            row = self._row(self.system.elements[guard.element])
            number = guard.element if guard.kind in ("contact", "multiplier") else row
            at = self.bounds + 2 * k
            tests.append(f"g[{k}] = p[{at}] * {values[guard.kind].format(number)} + p[{at + 1}]")
        reads = [
            f"f[{i}] = f{i}" + (f" + stick{i}" if i in self.rubbing else "")
            for i in range(len(self.system.elements))
        ]
        forces = _function("forces(t, y, f, p)", [*shared, *reads])
        if not tests:
            tests, shared = ["pass"], []
        guards = _function("guards(t, y, g, p)", [*shared, *tests])
        return "\n\n".join([rhs, guards, forces])

    def _signal_lines(self) -> Iterable[str]:
        for k, course in enumerate(self.courses):
            if not course.is_zero:
                yield from (line for line in course.lines(k) if self.rubbing or "ddu" not in line)

    def _rows(self) -> list[tuple[tuple[float, ...], str]]:
        return list(dict.fromkeys((tuple(e.direction), e.road) for e in self.system.elements))

    def _row(self, element: Element) -> int:
        return self._rows().index((tuple(element.direction), element.road))

    def _under(self, road: str, prefix: str) -> str:
        """Return the text that subtracts the road under a row."""
        if not road or self.courses[self.names.index(road)].is_zero:
            return ""
        return f" - {prefix}{self.names.index(road)}"

    def _force_lines(self, *, choosing: bool) -> Iterable[str]:
        n, rows = self.n, self._rows()
        for r, (b, road) in enumerate(rows):
            for name, first, prefix in ((f"d{r}", 0, "u"), (f"w{r}", n, "du")):
                moved = sum_of((x, f"y[{first + i}]") for i, x in enumerate(b))
                yield f"{name} = {moved}{self._under(road, prefix)}"
        for i, element in enumerate(self.system.elements):
            r = self._row(element)
            of = ((laws[i], f"{x}{r}") for laws, x in zip(self.laws.values(), "dwd", strict=True))
            spring, damper, factor = (
                law.choosing_text(x) if choosing else law.text(x) for law, x in of
            )
            if factor != "1.0" and damper != "0.0":
                damper = f"({factor}) * ({damper})"
            force = " + ".join(text for text in (spring, damper) if text != "0.0") or "0.0"
            if i in self.contacts and choosing:
                limited = f"min({force}, {element.limit!r})"
                if element.opening < inf:
                    limited = f"{element.limit!r} if d{r} > {element.opening!r} else {limited}"
                yield f"f{i} = {limited}"
            elif i in self.contacts:
                at = self.contacts[i]
                yield f"free{i} = {force}"
                yield f"f{i} = p[{at}] * free{i} + p[{at + 1}]"
            else:
                rub = f" + p[{self.slips[i]}]" if i in self.slips else ""
                yield f"f{i} = {force}{rub}"
        for r, (b, road) in enumerate(rows):
            acting = [i for i, e in enumerate(self.system.elements)
                      if (tuple(e.direction), e.road) == (b, road)]  # fmt: skip
            yield f"r{r} = {' + '.join(f'f{i}' for i in acting)}"
        pushes = [self.spread(b) for b, _ in rows]
        loads = [(self.spread(load.direction), load.signal) for load in self.system.loads]
        for k in range(n):
            terms = [(-push[k], f"r{r}") for r, push in enumerate(pushes)]
            terms += [
                (push[k], f"u{self.names.index(signal)}")
                for push, signal in loads
                if not self.courses[self.names.index(signal)].is_zero
            ]
            yield f"a{k} = {sum_of(terms)}"
        yield from self._sticking_lines()

    def _sticking_lines(self) -> Iterable[str]:
        """Yield the forces that hold sticking elements, found from the accelerations without them."""
        elements, m = self.system.elements, len(self.rubbing)
        for j, i in enumerate(self.rubbing):
            b = elements[i].direction
            free = sum_of((x, f"a{k}") for k, x in enumerate(b))
            yield f"free_acceleration{j} = {free}{self._under(elements[i].road, 'ddu')}"
        for row, i in enumerate(self.rubbing):
            terms = (f"p[{self.sticking + row * m + j}] * free_acceleration{j}" for j in range(m))
            yield f"stick{i} = {' + '.join(terms)}"
        for i in self.rubbing:
            for k, push in enumerate(self.spread(elements[i].direction)):
                if push:
                    yield f"a{k} = a{k} - {push!r} * stick{i}"

    def spread(self, direction: Sequence[float]) -> list[float]:
        """Return M^-1 b."""
        return [sum(a * b for a, b in zip(row, direction, strict=True)) for row in self.inverse]

    # -- as functions ------------------------------------------------------------------------------

    def functions(
        self, *, choosing: bool = False, **names: Any
    ) -> dict[str, Callable[[Any, Any, Any, Any], None]]:
        """Return the functions in Python.

        `rhs(t, y, dy, p)` fills dy; `guards(t, y, g, p)` fills g, one entry per guard;
        `forces(t, y, f, p)` fills f, one entry per element.

        Parameters
        ----------
        choosing : whether to return `rhs` only, in which the elements choose their branches from the
            state; not if `memory` forbids it
        names : replacements of `cos`, `sin`, `tanh`
        """
        space: dict[str, Any] = {"cos": math.cos, "sin": math.sin, "tanh": math.tanh, **names}
        source = self._written(choosing=choosing)
        exec(compile(source, "<equations>", "exec"), space)
        return {name: space[name] for name in ("rhs", "guards", "forces") if name in space}


def _function(head: str, lines: Sequence[str]) -> str:
    return "\n".join([f"def {head}:", *(f"    {line}" for line in lines)])
