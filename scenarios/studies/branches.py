"""The branches of the elements of `equations`, which change where a guard crosses zero."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from copy import copy
from math import inf
from typing import Any

import numpy as np
from phaseplane.suspension.characteristics import Piece

from .equations import LATE, LAWS, Equations, Guard, Vector

_ELASTIC = 1  # the middle piece of the three of a yielding element
# Of an element with a limit: in contact; out of contact up to its free length; across a gap.
_TOUCHES, _HANGS, _GAP = 0, 1, 2
_TURNS = 100  # largest number of switches at one instant


class ChatterError(ArithmeticError):
    """Endless switches at one instant."""


class Branches:
    """The branch of every element, as the numbers p of the equations.

    Parameters
    ----------
    equations : equations of the system
    t, y : time (s) and state at the start, shape (2n,)
    guards : compiled guards of the equations; None to run them in Python
    """

    def __init__(
        self,
        equations: Equations,
        t: float,
        y: Vector,
        guards: Callable[[float, Vector, Vector, Vector], Any] | None = None,
    ) -> None:
        self.equations = equations
        self.system = equations.system
        self.p: Vector = np.zeros(equations.size)
        self._g: Vector = np.zeros(len(equations.guards))
        self._guards = guards or equations.functions()["guards"]
        self._of_element: list[list[int]] = [[] for _ in self.system.elements]
        for k, guard in enumerate(equations.guards):
            self._of_element[guard.element].append(k)
        elements = self.system.elements
        self._known: dict[tuple[int, ...], tuple[Any, Any]] = {}  # shared by all copies
        self.segment = [0] * len(equations.courses)
        self.piece = {law: [0] * len(elements) for law in LAWS}
        self.limited = [_TOUCHES] * len(elements)
        self.slip = [0] * len(elements)  # -1, 1, or 0 where friction sticks
        self.permanent_set = [element.permanent_set for element in elements]
        self.events: list[tuple[float, str, str]] = []
        self._enter_segments(t)
        self._locate(t, y)
        for i, element in enumerate(elements):
            if element.yield_force < inf:
                self._start_yielding(i, t, y)
        self._write()
        self.settle(t, y)

    def copy(self) -> Branches:
        """Return an independent copy in the same branches."""
        other = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, list):
                setattr(other, name, value.copy())
        other.piece = {law: places.copy() for law, places in self.piece.items()}
        other.p, other._g = self.p.copy(), self._g.copy()
        return other

    # -- deflections and joints ----------------------------------------------------------------------

    def deflection(self, i: int, t: float, y: Vector) -> tuple[float, float]:
        """Return the deflection of element i and its rate, m and m/s."""
        element, n = self.system.elements[i], self.equations.n
        u, du = self._road(element.road, t)
        d = sum(b * y[k] for k, b in enumerate(element.direction)) - u
        return d, sum(b * y[n + k] for k, b in enumerate(element.direction)) - du

    def _road(self, name: str, t: float) -> tuple[float, float]:
        if not name:
            return 0.0, 0.0
        k = self.equations.names.index(name)
        value, rate, *_ = self.equations.courses[k].segments[self.segment[k]].derivatives(t)
        return value, rate

    def next_joint(self, t: float) -> float:
        """Return the next time at which a signal changes segment, s."""
        starts = (
            course.segments[now + 1].start
            for course, now in zip(self.equations.courses, self.segment, strict=True)
            if now + 1 < len(course.segments)
        )
        return min((s for s in starts if s > t), default=inf)

    # -- signals -----------------------------------------------------------------------------------

    def _enter_segments(self, t: float) -> None:
        for k, course in enumerate(self.equations.courses):
            starts = [segment.start for segment in course.segments[1:]]
            self.segment[k] = bisect_right(starts, t)

    def pass_joint(self, t: float, y: Vector) -> None:
        """Enter the next segments of the signals; a jump of a road acts through its dampers."""
        before = {name: self._road(name, t)[0] for name in self.equations.names}
        self._enter_segments(t)
        for i, element in enumerate(self.system.elements):
            jump = self._road(element.road, t)[0] - before.get(element.road, 0.0)
            if element.road and abs(jump) > 1e-12 * abs(before[element.road]) + 1e-15:
                self._impulse(i, jump, t, y)
        self._locate(t, y)
        self._write()
        self.settle(t, y)

    def _impulse(self, i: int, jump: float, t: float, y: Vector) -> None:
        element, n = self.system.elements[i], self.equations.n
        d, _ = self.deflection(i, t, y)
        if jump > 0.0 and d + jump > element.opening:  # a gap: only the rest of the jump acts
            jump = element.opening - d
        # a road that rises at an infinite rate presses on the tyre, whether it had contact or not
        if jump > 0.0 or not element.limit < inf:
            # a ramp of zero length has an infinite rate
            slope = element.damper.pieces[0 if jump > 0.0 else -1].coefficients[1]
            way = element.modulation.potential(d + jump) - element.modulation.potential(d)
            for k, push in enumerate(self.equations.spread(element.direction)):
                y[n + k] += push * slope * way

    # -- branches ----------------------------------------------------------------------------------

    def _locate(self, t: float, y: Vector) -> None:
        """Set all branches that follow from the state alone."""
        for i, element in enumerate(self.system.elements):
            d, w = self.deflection(i, t, y)
            for law, x in zip(LAWS, (d, w, d), strict=True):
                if law != "spring" or element.yield_force == inf:
                    self.piece[law][i] = bisect_right(getattr(element, law).corners, x)
            force = element.spring.force(d) + element.modulation.force(d) * element.damper.force(w)
            self.limited[i] = _HANGS if force > element.limit else _TOUCHES
            if d > element.opening:
                self.limited[i] = _GAP
            if element.friction > 0.0 and (self.slip[i] != 0 or abs(w) > 1e-12):
                self.slip[i] = int(w > 0.0) - int(w < 0.0)

    def _start_yielding(self, i: int, t: float, y: Vector) -> None:
        """Set the permanent set of an element that starts beyond its elastic range."""
        self.piece["spring"][i] = _ELASTIC
        d, _ = self.deflection(i, t, y)
        for side in (-1, 1):
            if (d - self._flow_corner(i, side)) * side > 0.0:
                self.piece["spring"][i] = _ELASTIC + side
                self._unload(i, d)

    def _flow_corner(self, i: int, side: int) -> float:
        """Return the deflection at which the elastic line meets the line of plastic flow."""
        element = self.system.elements[i]
        rate, flow = element.spring.tangent(0.0), element.hardening
        line = element.yield_force * (1.0 - flow / rate)
        return (rate * self.permanent_set[i] + side * line) / (rate - flow)

    def _unload(self, i: int, d: float) -> None:
        element = self.system.elements[i]
        force = self._yielding_piece(i).force(d)
        self.permanent_set[i] = d - force / element.spring.tangent(0.0)
        self.piece["spring"][i] = _ELASTIC

    def _yielding_piece(self, i: int) -> Piece:
        element, side = self.system.elements[i], self.piece["spring"][i] - _ELASTIC
        rate, flow = element.spring.tangent(0.0), element.hardening
        if side == 0:
            return Piece(-inf, self.permanent_set[i], (0.0, rate, 0.0, 0.0))
        line = element.yield_force * (1.0 - flow / rate)
        return Piece(-inf, 0.0, (side * line, flow, 0.0, 0.0))

    def leave(self, t: float, y: Vector) -> None:
        """Leave the branch whose guard is zero, and all others whose guards are not positive."""
        self._guards(t, y, self._g, self.p)
        self.switch(self.equations.guards[int(self._g.argmin())], t, y)
        self.settle(t, y)

    def settle(self, t: float, y: Vector) -> None:
        """Leave all branches whose guards are not positive; several may end at one instant.

        Raises
        ------
        ChatterError : if the switches do not end.
        """
        if not len(self._g):
            return
        for _ in range(_TURNS):
            self._guards(t, y, self._g, self.p)
            worst = int(self._g.argmin())
            if self._g[worst] > 0.0:
                return
            self.switch(self.equations.guards[worst], t, y)
        raise ChatterError(f"more than {_TURNS} switches at {t:.9g} s")

    def switch(self, guard: Guard, t: float, y: Vector) -> None:
        """Enter the branch beyond the guard; y may change, as a sticking element stops."""
        i, kind, side = guard.element, guard.kind, guard.side
        element = self.system.elements[i]
        if element.yield_force < inf and kind == "damper":
            self._unload(i, self.deflection(i, t, y)[0])
        elif kind in self.piece:
            self.piece[kind][i] += side
        elif kind == "contact":
            self.limited[i] = _HANGS if side > 0 else _TOUCHES
        elif kind == "gap":
            self.limited[i] = _GAP if side > 0 else _TOUCHES
        elif kind == "friction":
            self.slip[i] = 0
            self._stop(i, t, y)
        else:
            self.slip[i] = side
        if kind != "gap" or side < 0:  # an opening gap changes no force
            self.events.append((t, element.name, "contact" if kind == "gap" else kind))
        self._write_element(i)
        if kind in ("friction", "multiplier"):
            self._write_sticking()

    def _stop(self, i: int, t: float, y: Vector) -> None:
        """Remove the remaining rate of an element that begins to stick."""
        n, b = self.equations.n, self.system.elements[i].direction
        spread = self.equations.spread(b)
        rate = self.deflection(i, t, y)[1]
        reach = sum(x * s for x, s in zip(b, spread, strict=True))
        for k, s in enumerate(spread):
            y[n + k] -= s * rate / reach

    # -- into p ------------------------------------------------------------------------------------

    def _write(self) -> None:
        equations, p = self.equations, self.p
        for course, now in zip(equations.courses, self.segment, strict=True):
            if course.at >= 0:
                numbers = course.numbers(course.segments[now])
                p[course.at : course.at + len(numbers)] = numbers
        for i in range(len(self.system.elements)):
            self._write_element(i)
        self._write_sticking()

    def _write_element(self, i: int) -> None:
        """Write the numbers of element i; they are cached for branches without memory."""
        pieces = (places[i] for places in self.piece.values())
        where = (i, *pieces, self.limited[i], self.slip[i])
        known = self._known.get(where)
        if known is not None:
            self.p[known[0]] = known[1]
            return
        written = list(self._numbers(i))
        for k, number in written:
            self.p[k] = number
        if self.system.elements[i].yield_force == inf:
            at, numbers = zip(*written, strict=True) if written else ((), ())
            self._known[where] = (np.array(at, int), np.array(numbers, float))

    def _numbers(self, i: int) -> Iterator[tuple[int, float]]:
        """Yield the places in p, and the numbers there, of the current branch of element i."""
        equations, element = self.equations, self.system.elements[i]
        for name, laws in equations.laws.items():
            if (law := laws[i]).at >= 0:
                yields = name == "spring" and element.yield_force < inf
                piece = self._yielding_piece(i) if yields else law.pieces[self.piece[name][i]]
                yield from enumerate(law.numbers(piece), law.at)
        if i in equations.contacts:
            yield from enumerate(
                (0.0, element.limit) if self.limited[i] else (1.0, 0.0), equations.contacts[i]
            )
        if i in equations.slips:
            yield equations.slips[i], self.slip[i] * element.friction
        for k in self._of_element[i]:
            yield from enumerate(self._guard(equations.guards[k]), equations.bounds + 2 * k)

    def _guard(self, guard: Guard) -> tuple[float, float]:
        """Return the factor and constant of side (bound - x), relative for forces; 0, 1 for no bound."""
        bound = self._bound(guard)
        if bound is None:
            return 0.0, 1.0
        element = self.system.elements[guard.element]
        unit = {"contact": element.limit, "multiplier": element.holding}.get(guard.kind, 1.0)
        return -guard.side / unit, guard.side * bound / unit

    def _write_sticking(self) -> None:
        """Write the inverse of b' M^-1 b over the sticking elements, zero elsewhere."""
        equations, rubbing = self.equations, self.equations.rubbing
        stuck = [j for j, i in enumerate(rubbing) if self.slip[i] == 0]
        whole = np.zeros((len(rubbing), len(rubbing)))
        if stuck:
            directions = np.array([self.system.elements[rubbing[j]].direction for j in stuck])
            coupling = directions @ np.array(equations.inverse) @ directions.T
            whole[np.ix_(stuck, stuck)] = np.linalg.inv(coupling)
        at = equations.sticking
        self.p[at : at + whole.size] = whole.ravel()

    def _bound(self, guard: Guard) -> float | None:
        """Return where the current branch ends on that side, slightly beyond the corner, or None."""
        i, side = guard.element, guard.side
        element = self.system.elements[i]
        yields = element.yield_force < inf
        if guard.kind == "contact":
            ends = self.limited[i] == (_TOUCHES if side > 0 else _HANGS)
            return element.limit * (1.0 + side * LATE) if ends else None
        if guard.kind == "gap":
            ends = self.limited[i] == (_HANGS if side > 0 else _GAP)
            # a closing gap is exact, as the force jumps; an opening one changes no force
            return element.opening + (LATE if side > 0 else 0.0) if ends else None
        if guard.kind == "friction":
            return side * LATE if self.slip[i] == -side else None
        if guard.kind == "multiplier":
            return side * element.holding * (1.0 + LATE) if self.slip[i] == 0 else None
        if yields and guard.kind == "damper":
            return side * LATE if self.piece["spring"][i] == _ELASTIC - side else None
        if yields:
            flows = self.piece["spring"][i] != _ELASTIC
            return None if flows else self._flow_corner(i, side) + side * LATE
        corners = getattr(element, guard.kind).corners
        corner = self.piece[guard.kind][i] + min(side, 0)
        return corners[corner] + side * LATE if 0 <= corner < len(corners) else None
