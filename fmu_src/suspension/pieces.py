"""Force characteristics of springs, dampers, stops and tyres, as chains of pieces.

Every law of an element (a line, a cubic spring, a damper with blow-off, a table, an end stop) is a
chain of cubic pieces, each with an optional saturating term, power law, or user-defined function. One
representation therefore gives force, tangent, potential and corners, and the integrator evaluates the
same numbers.

The argument is a deflection in m (springs) or a rate in m/s (dampers). Extension is positive, and
so is a force that pulls the two ends together (AP57 section 2).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from math import copysign, exp, inf, isfinite, log, log1p, sinh, tanh
from typing import NamedTuple

_FAST = 1e6  # m/s, where the slope of a user-defined function is that of ever larger rates
_SLOW = 0.2  # m/s, where every function is to have a slope
# the search for an argument, in m or m/s: its first step, how much farther each goes, and where it ends
_REACH, _FARTHER, _MOST_REACH = 1e-3, 1.05, 1e30
LEAST_SCALE = 1e-100  # m or m/s, of a saturating term; third derivatives are divided by its cube


class Own(NamedTuple):
    """A user-defined function: its value, its derivative, and its integral from 0."""

    force: Callable[[float], float]
    tangent: Callable[[float], float]
    integral: Callable[[float], float]

    def scaled(self, factor: float) -> Own:
        """Return the function times a factor."""
        if factor == 1.0:
            return self
        return Own(*(partial(_product, factor, part) for part in self))

    def fastest(self, side: float) -> float:
        """Return the largest rate on a side of zero, -1 or 1, at which the slope is looked at, m/s.

        It is lower where the function raises or is no number, as cosh at 1000 m/s.
        """
        rate = _FAST
        while rate > _SLOW:
            try:
                if isfinite(self.tangent(side * rate)):
                    break
            except Exception:  # functions of users may raise anything
                pass
            rate *= 0.5
        return side * rate

    def far_slope(self, side: float) -> float:
        """Return the slope for ever larger rates on a side of zero, -1 or 1."""
        return self.tangent(self.fastest(side))


def _product(factor: float, function: Callable[[float], float], x: float) -> float:
    return factor * function(x)


class Piece(NamedTuple):
    """One piece, valid from `start` upwards, of s = x - origin.

    `c0 + c1 s + c2 s^2 + c3 s^3 + saturation tanh(s / scale) + power |s|^exponent sgn s + own(s)`,
    with `scale` >= `LEAST_SCALE` and `exponent` > 0; the exponent is at least 1 in a piece that contains
    its origin, where the slope would be infinite
    """

    start: float
    origin: float
    coefficients: tuple[float, float, float, float]
    saturation: float = 0.0
    scale: float = 1.0
    power: float = 0.0
    exponent: float = 1.0
    own: Own | None = None

    @property
    def is_straight(self) -> bool:
        """Whether it is a line."""
        curved = any(self.coefficients[2:]) or self.saturation or self.power
        return not curved and self.own is None

    def force(self, x: float) -> float:
        s = x - self.origin
        c0, c1, c2, c3 = self.coefficients
        force = c0 + s * (c1 + s * (c2 + s * c3))
        if self.saturation:
            force += self.saturation * tanh(s / self.scale)
        if self.power:
            force += copysign(self.power * abs(s) ** self.exponent, s * self.power)
        return force + self.own.force(s) if self.own else force

    def tangent(self, x: float) -> float:
        s = x - self.origin
        _, c1, c2, c3 = self.coefficients
        tangent = c1 + s * (2.0 * c2 + s * 3.0 * c3)
        if self.saturation:
            w = exp(-2.0 * abs(s / self.scale))
            tangent += self.saturation / self.scale * 4.0 * w / (1.0 + w) ** 2
        if self.power:
            tangent += self.power * self.exponent * abs(s) ** (self.exponent - 1.0)
        return tangent + self.own.tangent(s) if self.own else tangent

    def antiderivative(self, x: float) -> float:
        s = x - self.origin
        c0, c1, c2, c3 = self.coefficients
        integral = s * (c0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))
        if self.saturation:
            integral += self.saturation * self.scale * log_cosh(s / self.scale)
        if self.power:
            integral += self.power / (self.exponent + 1.0) * abs(s) ** (self.exponent + 1.0)
        return integral + self.own.integral(s) if self.own else integral


def log_cosh(u: float) -> float:
    """Return log cosh u, the integral of tanh, without overflow or cancellation."""
    x = abs(u)
    return 0.5 * log1p(sinh(x) ** 2) if x < 1.0 else x + log1p(exp(-2.0 * x)) - log(2.0)


@dataclass(frozen=True)
class Characteristic:
    """A continuous force law made of pieces in ascending order.

    Properties of the pieces are computed once, because successive systems share their laws.

    Parameters
    ----------
    pieces : at least one; the first starts at minus infinity.
    """

    pieces: tuple[Piece, ...]

    def _piece(self, x: float) -> Piece:
        return self.pieces[bisect_right(self.corners, x)]

    @cached_property
    def corners(self) -> tuple[float, ...]:
        """The arguments at which two pieces meet, ascending."""
        return tuple(piece.start for piece in self.pieces[1:])

    def force(self, x: float) -> float:
        """Return the force at x, in N."""
        return self._piece(x).force(x)

    def tangent(self, x: float) -> float:
        """Return the slope at x (to the right of a corner), in N per unit of x."""
        return self._piece(x).tangent(x)

    def potential(self, x: float) -> float:
        """Return the integral of the force from 0 to x: for a spring its stored energy, in J."""
        return self.potentials[bisect_right(self.corners, x)] + self._piece(x).antiderivative(x)

    @cached_property
    def potentials(self) -> tuple[float, ...]:
        """The constant of each piece that makes `potential` continuous and zero at 0."""
        if len(self.pieces) == 1:
            return (-self.pieces[0].antiderivative(0.0),)
        zero = bisect_right(self.corners, 0.0)  # outwards from here, to avoid cancellation
        constants = [0.0] * len(self.pieces)
        constants[zero] = -self.pieces[zero].antiderivative(0.0)
        for k in range(zero, len(self.pieces) - 1):
            left, right = self.pieces[k], self.pieces[k + 1]
            joint = right.start
            constants[k + 1] = (
                constants[k] + left.antiderivative(joint) - right.antiderivative(joint)
            )
        for k in range(zero, 0, -1):
            left, right = self.pieces[k - 1], self.pieces[k]
            joint = right.start
            constants[k - 1] = (
                constants[k] + right.antiderivative(joint) - left.antiderivative(joint)
            )
        return tuple(constants)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """All pieces as the integrator reads them, one after the other.

        Start, origin, four coefficients, saturation, scale, the energy stored up to the piece, power,
        exponent, and whether there is a user-defined function.
        """
        return tuple(
            number
            for piece, potential in zip(self.pieces, self.potentials, strict=True)
            for number in (
                piece.start, piece.origin, *piece.coefficients, piece.saturation, piece.scale,
                potential, piece.power, piece.exponent, float(piece.own is not None),
            )
        )  # fmt: skip

    @cached_property
    def functions(self) -> tuple[Own | None, ...]:
        """The user-defined function of each piece, or None."""
        return tuple(piece.own for piece in self.pieces)

    @cached_property
    def is_zero(self) -> bool:
        """Whether the force is zero everywhere, so that the element may be left out."""
        return not any(
            any(piece.coefficients) or piece.saturation or piece.power or piece.own
            for piece in self.pieces
        )

    def argument(self, force: float) -> float:
        """Return the x nearest to 0 at which a law that rises there has this force; infinite if none.

        It is computed directly on straight pieces, by bisection on others. The law may fall farther out,
        as that of a softening spring does.
        """
        here = bisect_right(self.corners, 0.0)
        ends = (-inf, *self.corners, inf)
        rest = self.pieces[here].force(0.0)
        if force == rest:
            return 0.0
        below = force < rest
        for k in range(here, -1, -1) if below else range(here, len(self.pieces)):
            near, far = (
                (min(ends[k + 1], 0.0), ends[k]) if below else (max(ends[k], 0.0), ends[k + 1])
            )
            if (x := _argument(self.pieces[k], force, near, far)) < inf:
                return x
        return inf

    def moved(self, x: float, force: float) -> Characteristic:
        """Return the same law measured from a new origin, at x and `force` of the old one."""
        return Characteristic(
            tuple(
                piece._replace(
                    start=piece.start - x,
                    origin=piece.origin - x,
                    coefficients=(piece.coefficients[0] - force, *piece.coefficients[1:]),
                )
                for piece in self.pieces
            )
        )

    def scaled(self, factor: float) -> Characteristic:
        """Return the law with all forces multiplied by a factor."""
        pieces = []
        for piece in self.pieces:
            c0, c1, c2, c3 = (factor * c for c in piece.coefficients)
            pieces.append(
                piece._replace(
                    coefficients=(c0, c1, c2, c3),
                    saturation=factor * piece.saturation,
                    power=factor * piece.power,
                    own=piece.own and piece.own.scaled(factor),
                )
            )
        return Characteristic(tuple(pieces))

    def resting(self) -> Characteristic:
        """The same law through the origin, if it misses it only by rounding.

        A system at rest then stays exactly where it is.
        """
        here = bisect_right(self.corners, 0.0)
        piece = self.pieces[here]
        if piece.saturation or piece.power or piece.own:
            return self
        _, c1, c2, c3 = _about(piece, 0.0)
        level = piece._replace(origin=0.0, coefficients=(0.0, c1, c2, c3))
        return Characteristic((*self.pieces[:here], level, *self.pieces[here + 1 :]))

    def __add__(self, other: Characteristic) -> Characteristic:
        """Return the law of two elements in parallel.

        Raises
        ------
        ValueError : both saturate, about different points or over different scales, or both have powers
            or user-defined functions; use two elements.
        """
        starts = (-inf, *sorted({*self.corners, *other.corners}))
        return Characteristic(
            tuple(_side_by_side(start, self._piece(start), other._piece(start)) for start in starts)
        )


def _side_by_side(start: float, one: Piece, other: Piece) -> Piece:
    """Return the sum of two pieces, from `start` on."""
    bound = [piece for piece in (one, other) if piece.saturation or piece.power or piece.own]
    if len(bound) == 2 and not _saturate_alike(*bound):
        raise ValueError(
            "two laws that saturate about different points or over different scales, or contain power "
            "laws or user-defined functions, cannot be added; use two elements"
        )
    curved = bound[0] if bound else min((one, other), key=lambda piece: abs(piece.origin))
    a0, a1, a2, a3 = _about(one, curved.origin)
    b0, b1, b2, b3 = _about(other, curved.origin)
    return curved._replace(
        start=start,
        coefficients=(a0 + b0, a1 + b1, a2 + b2, a3 + b3),
        saturation=sum(piece.saturation for piece in bound),
    )


def _saturate_alike(one: Piece, other: Piece) -> bool:
    """Return whether the sum of two curved pieces is a piece."""
    more = one.power or other.power or one.own or other.own
    return (one.origin, one.scale) == (other.origin, other.scale) and not more


def _about(piece: Piece, origin: float) -> tuple[float, float, float, float]:
    """Return the coefficients of the same cubic about another origin."""
    cubic = piece._replace(saturation=0.0, power=0.0, own=None)
    _, _, c2, c3 = piece.coefficients
    s = origin - piece.origin
    return (cubic.force(origin), cubic.tangent(origin), c2 + 3.0 * c3 * s, c3)


def _argument(piece: Piece, force: float, near: float, far: float) -> float:
    """Return where a piece has this force between two ends; infinite if it is not reached.

    On a curved piece it goes outwards from the near end in short steps, so that it finds what a softening
    spring carries before its force falls again. The far end may be infinite.
    """

    def is_reached(x: float) -> bool:
        return piece.force(x) >= force if near < far else piece.force(x) <= force

    if piece.is_straight:
        c0, c1, _, _ = piece.coefficients
        if abs(far) < inf and not is_reached(far):
            return inf
        if c0 == force:
            return piece.origin
        return piece.origin + (force - c0) / c1 if c1 > 0.0 else inf
    reach = _REACH * (piece.scale if piece.saturation else 1.0)
    before, x = near, near
    while not is_reached(x):
        if x == far or reach > _MOST_REACH:
            return inf
        before, x = x, min(near + reach, far) if near < far else max(near - reach, far)
        reach *= _FARTHER
    low, high = min(before, x), max(before, x)
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if piece.force(middle) < force else (low, middle)
    return high
