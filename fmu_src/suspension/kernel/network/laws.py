"""The laws of all elements: chains of pieces.

A piece is c0 + c1 s + c2 s^2 + c3 s^3 + saturation tanh(s / scale) + power |s|^exponent sgn s + own(s),
s = x - origin. The last term is a function in Python, which is called with the interpreter lock held.
"""

from __future__ import annotations

from itertools import accumulate
from math import exp, fabs, log1p, pow, sinh
from typing import TYPE_CHECKING, Any

from ..arrays import Memory
from ..language import Doubles, inline, of_python, takes_gil
from ..layout import (
    C0,
    C1,
    C2,
    C3,
    EXPONENT,
    LAWS,
    ORIGIN,
    OWN,
    PIECE,
    POWER,
    SATURATION,
    SCALE,
    START,
    STORED,
    UNBOUNDED,
)

if TYPE_CHECKING:
    from ...systems import Element, System

_FORCE, _SLOPE, _INTEGRAL, _FAR_SLOPE = 0, 1, 2, 3  # the functions in Python of a piece
_SMOOTH = 1e-9  # relative difference of slopes that are the same to rounding
# largest ratio of what the columns miss of jumps of the third and second derivative
_OF_THIRD = 0.09
_NEAR = 1e-5  # relative distance for the difference quotient of a slope in Python
_FARTHEST = 1e27  # m or m/s, up to which powers grow: the 11th is still finite
_SMALL_ARGUMENT = 0.549  # of tanh, half the logarithm of 3
_LOG_2 = 0.6931471805599453


class Laws:
    """The pieces of every law.

    Parameters
    ----------
    memory : the memory that contains the arrays
    system : `systems.System`
    joins : whether curved pieces that meet with the same slope, as in a smooth table, are one branch
    """

    failure: BaseException | None

    def __init__(self, memory: Memory, system: System, joins: bool) -> None:
        self.joins = joins
        count = [pieces for element in system.elements for pieces in pieces_of(element)]
        self.pieces = memory.integers(count)
        self.first = memory.integers(accumulate(count, initial=0))
        self.piece = memory.zeros(PIECE * sum(count))
        self.straight = memory.integers([1] * sum(count))
        self.cubic = memory.integers([1] * sum(count))
        self.functions = [
            own and (*own, own.far_slope)
            for element in system.elements
            for own in functions_of(element)
        ]
        self.failure = None  # an exception raised by a function
        self.raised = False  # whether one was raised since the state was entered
        self.failed = False  # whether one was raised since the last attempt began
        # beyond its ends a cubic is continued by its tangent
        self.low, self.high = memory.zeros(sum(count)), memory.zeros(sum(count))
        # where each piece begins: the jump of the second derivative; and the one, times a power of the
        # way passed, of which the columns would miss as much as of another singularity there
        self.jump, self.rough = memory.zeros(sum(count) + 1), memory.zeros(sum(count) + 1)
        self.growth = memory.zeros(sum(count) + 1)  # the exponent of that power
        # the first and the last of the pieces that each is joined with
        self.run_first, self.run_last = memory.marks(sum(count)), memory.marks(sum(count))

    def enter_laws(self, e: int, x: Doubles, at: int) -> int:
        """Read the pieces of the laws of element e from x[at:]; return where they end."""
        first = self.first[LAWS * e]
        last = self.first[LAWS * (e + 1)]
        for i in range(PIECE * (last - first)):
            self.piece[PIECE * first + i] = x[at + i]
        for law in range(LAWS * e, LAWS * (e + 1)):
            end = self.first[law] + self.pieces[law]
            for p in range(self.first[law], end):
                k = p * PIECE
                power = self.piece[k + POWER] != 0.0
                others = self.piece[k + SATURATION] != 0.0 or self.piece[k + OWN] != 0.0
                curved = self.piece[k + C2] != 0.0 or self.piece[k + C3] != 0.0 or power
                self.cubic[p] = not (power or others)
                self.straight[p] = self.cubic[p] and not curved
                self.low[p], self.high[p] = -UNBOUNDED, UNBOUNDED
                if curved and p > self.first[law]:
                    self.low[p] = self.piece[k + START]
                if curved and p + 1 < end:
                    self.high[p] = self.piece[k + PIECE + START]
            self._join(law)
        return at + PIECE * (last - first)

    def _join(self, law: int) -> None:
        """Find which pieces of a law are joined."""
        first = self.first[law]
        last = first + self.pieces[law] - 1
        for p in range(first, last + 1):
            self.run_first[p] = self.run_last[p] = p
        for p in range(first + 1, last + 1):
            if self._meets_smoothly(p) and self.joins:
                self.run_first[p] = self.run_first[p - 1]
        for p in range(last - 1, first - 1, -1):
            if self.run_first[p + 1] != p + 1:
                self.run_last[p] = self.run_last[p + 1]

    def _meets_smoothly(self, p: int) -> bool:
        """Return whether curved piece p begins with the slope of the curved piece before it."""
        self.jump[p] = self.rough[p] = 0.0
        if self.piece[(p - 1) * PIECE + OWN] != 0.0 or self.piece[p * PIECE + OWN] != 0.0:
            return False
        x = self.piece[p * PIECE + START]
        third = self._third(p - 1, x)
        self.read_piece(p - 1, x)
        slope, curvature = self.slope, self.curvature
        self.read_piece(p, x)
        self._find_jump(p, curvature, self._third(p, x) - third)
        if self.straight[p - 1] or self.straight[p]:
            return False
        return fabs(self.slope - slope) <= _SMOOTH * (fabs(self.slope) + fabs(slope))

    def _find_jump(self, p: int, curvature: float, third: float) -> None:
        """Find `jump`, `rough` and `growth` of piece p, just read, from the curvature before it.

        Over a way s the columns miss as much of the zero of a power law |s|^n as of a jump of the second
        derivative by 4 |(n - 1) (3 - n)| exp(4 - 2 n) s^(n - 2), which is exact for n = 2; and of a jump
        of the third derivative by `third`, which counts if the second is continuous, as of one by
        `_OF_THIRD` third s. Of two power laws that meet at their zeros the smaller exponent counts.
        """
        self.jump[p] = fabs(self.curvature - curvature)
        self.rough[p], self.growth[p] = 0.0, UNBOUNDED
        for m in range(p - 1, p + 1):
            at = m * PIECE
            power, n = self.piece[at + POWER], self.piece[at + EXPONENT]
            if power != 0.0 and self.piece[at + ORIGIN] == self.piece[p * PIECE + START]:
                share = 4.0 * fabs((n - 1.0) * (3.0 - n)) * exp(4.0 - 2.0 * n)
                self.rough[p] = max(self.rough[p], share * fabs(power))
                self.growth[p] = min(self.growth[p], n - 2.0)
        steady = self.jump[p] <= _SMOOTH * (fabs(self.curvature) + fabs(curvature))
        if self.rough[p] == 0.0 and steady:
            self.rough[p], self.growth[p] = _OF_THIRD * fabs(third), 1.0

    def _third(self, p: int, x: float) -> float:
        """Return the third derivative of piece p at x, without a function in Python.

        Of power laws only that of exponent 3 counts; what others miss at their zeros is more.
        """
        at = p * PIECE
        scale = self.piece[at + SCALE]
        u = tangent_h((x - self.piece[at + ORIGIN]) / scale)
        bow = -2.0 * (1.0 - u * u) * (1.0 - 3.0 * u * u) / (scale * scale * scale)
        cubic = self.piece[at + C3]
        if self.piece[at + EXPONENT] == 3.0:
            cubic += self.piece[at + POWER]
        return 6.0 * cubic + self.piece[at + SATURATION] * bow

    def place(self, p: int, x: float) -> int:
        """Return which of the pieces joined with p contains x; it is found fastest from close to it."""
        first, last = self.run_first[p], self.run_last[p]
        k = p
        while k > first and not x >= self.piece[k * PIECE + START]:
            k -= 1
        while k < last and x >= self.piece[(k + 1) * PIECE + START]:
            k += 1
        return k

    def law(self, p: int, x: float) -> float:
        """Return the force of piece p, or of those it is joined with, at x."""
        if self.straight[p]:
            at = p * PIECE
            return self.piece[at + C0] + (x - self.piece[at + ORIGIN]) * self.piece[at + C1]
        self.law_and_slope(p, x)
        return self.value

    def law_slope(self, p: int, x: float) -> float:
        if self.straight[p]:
            return self.piece[p * PIECE + C1]
        self.law_and_slope(p, x)
        return self.slope

    @takes_gil
    def own(self, p: int, what: int, s: float) -> float:
        """Return force, slope, integral or far slope (`what`) of piece p by its function at s.

        It is NaN if the function fails; s is a side of zero, -1 or 1, for the far slope.
        """
        try:
            return float(self.functions[p][what](s))
        except BaseException as error:  # an interrupt, too, as C cannot pass it on
            self.note_failure(error)
            return float("nan")

    @of_python
    def note_failure(self, error: BaseException) -> None:
        """Keep the first exception of an attempt, or an interrupt; the attempt is spoilt."""
        kept = self.failure is None or isinstance(self.failure, Exception)
        if kept and not (self.failed and isinstance(error, Exception)):
            self.failure = error
        self.raised = self.failed = True

    def forget_failures(self) -> None:
        """Let no exception count that was raised before a state is entered.

        At rest at zero, before the first state, elements may be far from the road.
        """
        self.raised = self.failed = False

    def law_and_slope(self, p: int, x: float) -> None:
        """Set `value`, `slope`, `curvature` to those of piece p, or of those it is joined with, at x."""
        if self.straight[p]:
            at = p * PIECE
            self.slope, self.curvature = self.piece[at + C1], 0.0
            self.value = self.piece[at + C0] + (x - self.piece[at + ORIGIN]) * self.slope
            return
        self.read_piece(self.place(p, x), x)

    def law_and_curvature(self, p: int, x: float) -> None:
        """Do the same, with the curvature of a function in Python by a difference quotient."""
        p = self.place(p, x)
        self.read_piece(p, x)
        if self.piece[p * PIECE + OWN] != 0.0:
            s = x - self.piece[p * PIECE + ORIGIN]
            near = _NEAR * (1.0 + fabs(s))
            before = self.own(p, _SLOPE, s - near)
            self.curvature += (self.own(p, _SLOPE, s + near) - before) / (2.0 * near)

    @inline
    def read_piece(self, p: int, x: float) -> None:
        """Do the same for piece p alone, which contains x.

        The slope of tanh is 1 - tanh^2. The curvature of a function in Python counts as 0.
        """
        at = p * PIECE
        inner = x
        if x < self.low[p]:
            inner = self.low[p]
        elif x > self.high[p]:
            inner = self.high[p]
        s = inner - self.piece[at + ORIGIN]
        c1, c2, c3 = self.piece[at + C1], self.piece[at + C2], self.piece[at + C3]
        self.value = self.piece[at + C0] + s * (c1 + s * (c2 + s * c3))
        self.slope = c1 + s * (2.0 * c2 + 3.0 * s * c3)
        self.curvature = 2.0 * c2 + 6.0 * s * c3
        if not self.cubic[p]:
            self._add_functions(p, s)
        if x != inner:
            self.value += self.slope * (x - inner)
            self.curvature = 0.0

    def _add_functions(self, p: int, s: float) -> None:
        """Add what is not a cubic in piece p to `value`, `slope` and `curvature`."""
        at = p * PIECE
        saturation, scale = self.piece[at + SATURATION], self.piece[at + SCALE]
        if saturation != 0.0:
            u = tangent_h(s / scale)
            rest = saturation / scale * (1.0 - u * u)
            self.value += saturation * u
            self.slope += rest
            self.curvature -= 2.0 / scale * u * rest
        if self.piece[at + POWER] != 0.0:
            power, exponent = self.piece[at + POWER], self.piece[at + EXPONENT]
            steep = power_slope(power, exponent, s)
            self.value += power_of(power, exponent, s)
            self.slope += steep
            if s != 0.0:
                self.curvature += (exponent - 1.0) / s * steep
        if self.piece[at + OWN] != 0.0:
            self.value += self.own(p, _FORCE, s)
            self.slope += self.own(p, _SLOPE, s)

    def potential(self, p: int, x: float) -> float:
        if self.run_last[p] > self.run_first[p]:
            p = self.place(p, x)
        at = p * PIECE
        if x < self.low[p] or x > self.high[p]:
            end = min(max(x, self.low[p]), self.high[p])
            s = x - end
            self.read_piece(p, end)
            beyond = s * (self.value + 0.5 * s * self.slope)
            return beyond + self.potential(p, end)
        s = x - self.piece[at + ORIGIN]
        c0, c1, c2, c3 = (
            self.piece[at + C0], self.piece[at + C1], self.piece[at + C2], self.piece[at + C3],
        )  # fmt: skip
        energy = self.piece[at + STORED] + s * (c0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))
        saturation, scale = self.piece[at + SATURATION], self.piece[at + SCALE]
        if saturation != 0.0:
            energy += saturation * scale * log_cosh(s / scale)
        if self.piece[at + POWER] != 0.0:
            exponent = self.piece[at + EXPONENT] + 1.0
            energy += self.piece[at + POWER] / exponent * pow(min(fabs(s), _FARTHEST), exponent)
        if self.piece[at + OWN] != 0.0:
            energy += self.own(p, _INTEGRAL, s)
        return energy

    def piece_at(self, law: int, x: float) -> int:
        """Return the piece of a law at x; at a corner the upper one, of joined pieces the first."""
        k = 0
        first = self.first[law]
        while k + 1 < self.pieces[law] and self.piece[(first + k + 1) * PIECE + START] <= x:
            k += 1
        return self.run_first[first + k] - first

    def far_slope(self, p: int, side: float) -> float:
        """Return the slope of the outermost piece p far from zero, where saturated terms are level."""
        slope = self.piece[p * PIECE + C1]
        if self.piece[p * PIECE + OWN] != 0.0:
            slope += self.own(p, _FAR_SLOPE, side)
        return slope

    def intercept(self, p: int) -> float:
        """Return the force of the straight piece p, extended to x = 0."""
        at = p * PIECE
        return self.piece[at + C0] - self.piece[at + C1] * self.piece[at + ORIGIN]


def tangent_h(u: float) -> float:
    """Return tanh u to 1.2 units of rounding, in half the time that the C library takes.

    The rational function near 0 is that of Cody and Waite.
    """
    x = fabs(u)
    if x < _SMALL_ARGUMENT:
        z = u * u
        over = -1613.4119023996228 - z * (99.22592967223608 + z * 0.9643749277722548)
        under = 4840.235707198869 + z * (2233.772071896231 + z * (112.74474380534949 + z))
        return u + u * (z * over / under)
    w = exp(-2.0 * x)
    w = (1.0 - w) / (1.0 + w)
    return w if u > 0.0 else -w


def log_cosh(u: float) -> float:
    """Return log cosh u, the integral of tanh, without overflow or cancellation."""
    x = fabs(u)
    if x < 1.0:
        w = sinh(x)
        return 0.5 * log1p(w * w)
    return x + log1p(exp(-2.0 * x)) - _LOG_2


def power_of(power: float, exponent: float, s: float) -> float:
    """Return power |s|^exponent with the sign of s."""
    force = power * pow(min(fabs(s), _FARTHEST), exponent)
    return force if s > 0.0 else -force


def power_slope(power: float, exponent: float, s: float) -> float:
    """Return the slope of `power_of`."""
    return power * exponent * pow(min(fabs(s), _FARTHEST), exponent - 1.0)


@of_python
def functions_of(element: Element) -> tuple[Any, ...]:
    """Return the function of each piece of an element's laws, or None."""
    if element.yield_force < UNBOUNDED:
        return (None,) * sum(pieces_of(element))
    return element.spring.functions + element.damper.functions + element.modulation.functions


@of_python
def pieces_of(element: Element) -> tuple[int, int, int]:
    """Return the numbers of pieces of an element's spring, damper and modulation."""
    spring = len(element.spring.pieces) if element.yield_force > UNBOUNDED else 3
    return spring, len(element.damper.pieces), len(element.modulation.pieces)


@of_python
def law_numbers(element: Element) -> list[float]:
    """Return the pieces of the laws of an element, one after the other."""
    spring = _flow_pieces(element) if element.yield_force < UNBOUNDED else element.spring.numbers
    return [*spring, *element.damper.numbers, *element.modulation.numbers]


@of_python
def _flow_pieces(element: Element) -> list[float]:
    """Return the three pieces of an element that yields: flow down, elastic, flow up.

    The lines of flow are fixed: -+ yield force (1 - flow / rate) + flow d.
    """
    rate, flow, free = element.spring.tangent(0.0), element.hardening, element.permanent_set
    line = element.yield_force * (1.0 - flow / rate)
    low, high = ((rate * free + side * line) / (rate - flow) for side in (-1.0, 1.0))
    return [
        -float("inf"), 0.0, -line, flow, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0,
        low, free, 0.0, rate, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0,
        high, 0.0, line, flow, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0,
    ]  # fmt: skip
