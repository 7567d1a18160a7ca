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
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from math import copysign, exp, inf, isfinite, log, log1p, sinh, tanh
from typing import NamedTuple

from .signals import GAUSS

_PARTS = 6  # of a quadrature between two corners; with five nodes each, order 10


class Own(NamedTuple):
    """A user-defined function: its value, its derivative, and its integral from 0; see `function`."""

    force: Callable[[float], float]
    tangent: Callable[[float], float]
    integral: Callable[[float], float]

    def scaled(self, factor: float) -> Own:
        """Return the function times a factor."""
        if factor == 1.0:
            return self
        return Own(*(partial(_product, factor, part) for part in self))


def _product(factor: float, function: Callable[[float], float], x: float) -> float:
    return factor * function(x)


class Piece(NamedTuple):
    """One piece, valid from `start` upwards, of s = x - origin.

    `c0 + c1 s + c2 s^2 + c3 s^3 + saturation tanh(s / scale) + power |s|^exponent sgn s + own(s)`,
    with `scale` > 0 and `exponent` > 0
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
        """Return the smallest x at which a rising law has this force; infinite if there is none.

        It is computed directly on straight pieces, by bisection on others.
        """
        for k, piece in enumerate(self.pieces):
            end = self.pieces[k + 1].start if k + 1 < len(self.pieces) else inf
            if end < inf and piece.force(end) < force:
                continue
            c0, c1, _, _ = piece.coefficients
            if piece.is_straight:
                if c0 == force:
                    return piece.origin
                return piece.origin + (force - c0) / c1 if c1 > 0.0 else inf
            return _bisected(piece, force, piece.start, end)
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


def _bisected(piece: Piece, force: float, low: float, high: float) -> float:
    """Return where a piece that rises from low to high, which may be infinite, has this force."""
    reach = piece.scale if piece.saturation else 1.0
    while low == -inf:
        low = (piece.origin if high == inf else high) - reach
        if piece.force(low) > force:
            low, reach = -inf, 2.0 * reach
        if reach > 1e30:
            return -inf
    reach = 1.0
    while high == inf:
        high = low + reach
        if piece.force(high) < force:
            high, reach = inf, 2.0 * reach
        if reach > 1e30:
            return inf
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if piece.force(middle) < force else (low, middle)
    return high


# systems built one after the other, as in a sweep, have most of their laws in common
_known = lru_cache(maxsize=256)


@_known
def linear(rate: float) -> Characteristic:
    """Return a straight line through the origin: F = rate x."""
    return Characteristic((Piece(-inf, 0.0, (0.0, rate, 0.0, 0.0)),))


@_known
def cubic(rate: float, cubic_rate: float) -> Characteristic:
    """Return a hardening (or softening) spring F = rate x + cubic_rate x^3."""
    return Characteristic((Piece(-inf, 0.0, (0.0, rate, 0.0, cubic_rate)),))


@_known
def constant(value: float) -> Characteristic:
    """Return a constant: a factor on a damper, or a constant force."""
    return Characteristic((Piece(-inf, 0.0, (value, 0.0, 0.0, 0.0)),))


def saturating(rate: float, force: float, bump_rate: float | None = None) -> Characteristic:
    """Return a smooth law with slope `rate` at 0 that never exceeds `force`: force tanh(rate x / force).

    Parameters
    ----------
    rate : slope at zero, N per unit of x; > 0
    force : limit for large x, N; > 0
    bump_rate : slope at zero for x < 0, if it differs

    Raises
    ------
    ValueError : a rate or force that is not positive.
    """
    for value in (rate, force, rate if bump_rate is None else bump_rate):
        if not 0.0 < value < inf:
            raise ValueError(
                f"rates and force of a saturating law must be positive, {value:g} given"
            )
    straight = (0.0, 0.0, 0.0, 0.0)
    rebound = Piece(-inf, 0.0, straight, force, force / rate)
    if bump_rate is None or bump_rate == rate:
        return Characteristic((rebound,))
    bump = Piece(-inf, 0.0, straight, force, force / bump_rate)
    return Characteristic((bump, rebound._replace(start=0.0)))


def power(coefficient: float, exponent: float, linear_below: float = 0.0) -> Characteristic:
    """Return a power law `coefficient |x|^exponent sgn x`, as of flow through an orifice (exponent 2).

    Parameters
    ----------
    coefficient : N per unit of x to the power of the exponent
    exponent : > 0, at most 10; below 1 the slope at zero is infinite, and needs `linear_below`
    linear_below : within this distance of zero the law is the chord through zero instead

    Raises
    ------
    ValueError : an exponent out of its range, or below 1 without `linear_below`; a number that is
        not finite.
    """
    for name, value in (("coefficient", coefficient), ("exponent", exponent),
                        ("linear_below", linear_below)):  # fmt: skip
        if not isfinite(value):
            raise ValueError(f"power law: {name} = {value:g} must be finite")
    if not 0.0 < exponent <= 10.0 or linear_below < 0.0:
        raise ValueError(
            f"power law: exponent = {exponent:g} must be positive and at most 10, and linear_below = "
            f"{linear_below:g} at least 0"
        )
    if exponent < 1.0 and linear_below == 0.0:
        raise ValueError(
            f"power law: with exponent = {exponent:g} below 1 the slope at zero is infinite; give "
            "linear_below, the distance from zero within which the law is a line"
        )
    if exponent == 1.0:
        return linear(coefficient)
    outer = Piece(-inf, 0.0, (0.0, 0.0, 0.0, 0.0), power=coefficient, exponent=exponent)
    if linear_below == 0.0:
        smooth = exponent % 2.0 == 1.0  # a polynomial; others have a jump of a derivative at zero
        return Characteristic((outer,) if smooth else (outer, outer._replace(start=0.0)))
    chord = coefficient * linear_below ** (exponent - 1.0)
    inner = Piece(-linear_below, 0.0, (0.0, chord, 0.0, 0.0))
    return Characteristic((outer, inner, outer._replace(start=linear_below)))


def function(
    force: Callable[[float], float],
    tangent: Callable[[float], float],
    corners: Sequence[float] = (),
    potential: Callable[[float], float] | None = None,
) -> Characteristic:
    """Return a law given by user-defined functions.

    The integrator calls them in every step, which takes about ten times as long as with the other laws.
    An exception in them ends the run and is raised there.

    Parameters
    ----------
    force : N over m or m/s; continuous
    tangent : its derivative
    corners : arguments at which the derivative or a higher one jumps, ascending; steps end there
    potential : integral of the force from 0; by default found by quadrature

    Raises
    ------
    ValueError : corners that do not ascend.

    Examples
    --------
    >>> from math import sin, cos
    >>> from phaseplane.suspension import characteristics
    >>> from phaseplane.suspension.systems import Element
    >>> pendulum = Element("weight", (1.0,), characteristics.function(sin, cos))
    """
    for x, x_next in pairwise(corners):
        if not x < x_next:
            raise ValueError(f"corners must ascend, but {x_next:g} follows {x:g}")
    if not all(map(isfinite, corners)):
        raise ValueError("corners must be finite numbers")
    own = Own(force, tangent, potential or _Quadrature(force, tuple(corners)))
    flat = (0.0, 0.0, 0.0, 0.0)
    return Characteristic(tuple(Piece(start, 0.0, flat, own=own) for start in (-inf, *corners)))


@dataclass(frozen=True, slots=True)
class _Quadrature:
    """The integral of a force from 0, by the rule of Gauss between its corners."""

    force: Callable[[float], float]
    corners: tuple[float, ...]

    def __call__(self, x: float) -> float:
        low, high = min(x, 0.0), max(x, 0.0)
        joints = [low, *(c for c in self.corners if low < c < high), high]
        total = 0.0
        for a, b in pairwise(joints):
            width = (b - a) / _PARTS
            for k in range(_PARTS):
                total += width * sum(
                    weight * self.force(a + width * (k + node)) for node, weight in GAUSS
                )
        return total if x > 0.0 else -total


def hat(points: Sequence[float], k: int) -> Characteristic:
    """Return the hat function: 1 at the k-th of ascending points, 0 at the others, linear between.

    It is constant beyond the ends. The hats of all points add up to 1 and interpolate a family of
    curves given at the points.
    """
    near = points[max(k - 1, 0) : k + 2]
    if len(near) == 1:
        return constant(1.0)
    return polyline([(x, float(x == points[k])) for x in near], 0.0, 0.0)


def polyline(corners: Sequence[tuple[float, float]], first: float, last: float) -> Characteristic:
    """Return straight pieces through the given corners, with the slopes of the two outer pieces.

    Parameters
    ----------
    corners : (x, F) pairs with ascending x; at least one
    first, last : slope before the first and after the last corner
    """
    x0, f0 = corners[0]
    pieces = [Piece(-inf, x0, (f0, first, 0.0, 0.0))]
    for (x, f), (x_next, f_next) in pairwise(corners):
        # measured from the end nearer to zero: exact there, without cancellation
        origin, force = (x, f) if abs(x) <= abs(x_next) else (x_next, f_next)
        pieces.append(Piece(x, origin, (force, (f_next - f) / (x_next - x), 0.0, 0.0)))
    x_end, f_end = corners[-1]
    pieces.append(Piece(x_end, x_end, (f_end, last, 0.0, 0.0)))
    return Characteristic(_without_straight_joints(pieces))


def _without_straight_joints(pieces: Iterable[Piece]) -> tuple[Piece, ...]:
    """Merge neighbours of equal slope, so that no step ends on a corner without a bend."""
    kept: list[Piece] = []
    for piece in pieces:
        if kept and kept[-1].coefficients[1] == piece.coefficients[1]:
            near = min(kept[-1], piece, key=lambda one: abs(one.origin))
            kept[-1] = near._replace(start=kept[-1].start)
        else:
            kept.append(piece)
    return tuple(kept)


@_known
def damper(
    rebound_rate: float,
    bump_rate: float,
    rebound_limit: float = 0.0,
    bump_limit: float = 0.0,
    limit_slope: float = 0.0,
) -> Characteristic:
    """Return a damper with separate rates in rebound (v > 0) and bump, and blow-off (AP57 section 1).

    Parameters
    ----------
    rebound_rate, bump_rate : N s/m
    rebound_limit, bump_limit : force at which the valve opens, N; 0 for no valve
    limit_slope : slope with an open valve, N s/m, the same on both sides
    """
    corners = [(0.0, 0.0)]
    first, last = bump_rate, rebound_rate
    if bump_limit > 0.0 and bump_rate > 0.0:
        corners.insert(0, (-bump_limit / bump_rate, -bump_limit))
        first = limit_slope
    if rebound_limit > 0.0 and rebound_rate > 0.0:
        corners.append((rebound_limit / rebound_rate, rebound_limit))
        last = limit_slope
    return polyline(corners, first, last)


def table(points: Sequence[tuple[float, float]], level: bool = False) -> Characteristic:
    """Return straight lines through given points, extrapolated with the outer slopes.

    Parameters
    ----------
    points : at least two (x, F) pairs with ascending x
    level : whether the curve is constant beyond the ends instead

    Raises
    ------
    ValueError : fewer than two points, or x not ascending.
    """
    slopes = _slopes(points)
    return polyline(points, 0.0, 0.0) if level else polyline(points, slopes[0], slopes[-1])


def monotone_table(points: Sequence[tuple[float, float]]) -> Characteristic:
    """Return a smooth curve through given points that rises and falls only where they do.

    Cubic pieces with continuous slope. At an inner point the slope is the weighted harmonic mean of
    the adjacent slopes, or zero if these differ in sign (F. N. Fritsch, J. Butland, SIAM J. Sci.
    Stat. Comput. 5, 1984); at an end it is that of the parabola through three points, limited alike.
    The curve is extrapolated with the slopes at its ends.

    Parameters
    ----------
    points : at least two (x, F) pairs with ascending x

    Raises
    ------
    ValueError : fewer than two points, x not ascending, or a number that is not finite.
    """
    for x, f in points:
        if not (isfinite(x) and isfinite(f)):
            raise ValueError(f"table points must be finite numbers, ({x:g}, {f:g}) given")
    tangents = _monotone_tangents([b[0] - a[0] for a, b in pairwise(points)], _slopes(points))
    (x0, f0), (x_end, f_end) = points[0], points[-1]
    pieces = [Piece(-inf, x0, (f0, tangents[0], 0.0, 0.0))]
    for (a, b), (ta, tb) in zip(pairwise(points), pairwise(tangents), strict=True):
        width = b[0] - a[0]
        slope = (b[1] - a[1]) / width
        c3 = ((ta - slope) + (tb - slope)) / width / width
        # measured from the end nearer to zero, as in `polyline`
        if abs(a[0]) <= abs(b[0]):
            c2 = (2.0 * (slope - ta) + (slope - tb)) / width
            pieces.append(Piece(a[0], a[0], (a[1], ta, c2, c3)))
        else:
            c2 = (2.0 * (tb - slope) + (ta - slope)) / width
            pieces.append(Piece(a[0], b[0], (b[1], tb, c2, c3)))
    pieces.append(Piece(x_end, x_end, (f_end, tangents[-1], 0.0, 0.0)))
    return Characteristic(tuple(pieces))


def _slopes(points: Sequence[tuple[float, float]]) -> list[float]:
    """Check the points of a table and return the slopes of the lines between them."""
    if len(points) < 2:
        raise ValueError(f"a table needs at least two points, {len(points)} given")
    for (x, _), (x_next, _) in pairwise(points):
        if not x < x_next:
            raise ValueError(f"table abscissae must ascend, but {x_next:g} follows {x:g}")
    return [(f_next - f) / (x_next - x) for (x, f), (x_next, f_next) in pairwise(points)]


def _monotone_tangents(widths: Sequence[float], slopes: Sequence[float]) -> list[float]:
    """Return the slopes at the points, given the widths and slopes of the intervals between them."""
    if len(slopes) == 1:
        return [slopes[0], slopes[0]]
    inner = [0.0] * (len(slopes) - 1)
    for i, ((w, w_next), (s, s_next)) in enumerate(
        zip(pairwise(widths), pairwise(slopes), strict=True)
    ):
        if min(s, s_next) > 0.0 or max(s, s_next) < 0.0:
            near, far = w + 2.0 * w_next, 2.0 * w + w_next
            inner[i] = (near + far) / (near / s + far / s_next)
    first = _end_tangent(*widths[:2], *slopes[:2])
    last = _end_tangent(*widths[:-3:-1], *slopes[:-3:-1])
    return [first, *inner, last]


def _end_tangent(width: float, width_next: float, slope: float, slope_next: float) -> float:
    """Return the slope at an end, from the two intervals next to it, outermost first."""
    parabola = slope + (slope - slope_next) * width / (width + width_next)
    if slope == 0.0 or parabola == 0.0 or (parabola > 0.0) != (slope > 0.0):
        return 0.0
    if (slope > 0.0) != (slope_next > 0.0) and abs(parabola) > 3.0 * abs(slope):
        return 3.0 * slope
    return parabola


@_known
def bump_stop(gap: float, stiffness: float) -> Characteristic:
    """Return the end stop of the bump travel: F = stiffness (x + gap) for x < -gap, else 0."""
    return polyline([(-gap, 0.0)], stiffness, 0.0)


@_known
def rebound_stop(gap: float, stiffness: float) -> Characteristic:
    """Return the end stop of the rebound travel: F = stiffness (x - gap) for x > gap, else 0."""
    return polyline([(gap, 0.0)], 0.0, stiffness)
