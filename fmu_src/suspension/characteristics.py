"""The characteristics of springs, dampers, stops and tyres: lines, cubics, power laws, tables, stops.

Each is a `Characteristic`, a chain of pieces (see `pieces`), and so is one of your own (`function`).
The argument is a deflection in m (springs) or a rate in m/s (dampers); positive is extension.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import inf, isfinite

from .pieces import LEAST_SCALE, Characteristic, Own, Piece
from .signals import GAUSS

__all__ = [
    "Characteristic",
    "Piece",
    "bump_stop",
    "constant",
    "cubic",
    "damper",
    "function",
    "hat",
    "linear",
    "monotone_table",
    "polyline",
    "power",
    "rebound_stop",
    "saturating",
    "table",
]

_PARTS = 6  # of a quadrature between two corners; with five nodes each, order 10
_RATES = (-100.0, -3.0, -0.3, -1e-3, 1e-3, 0.3, 3.0, 100.0)  # m/s, at which dampers are checked

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
    ValueError : a rate or force that is not positive, or a force that is far too small for the rates.
    """
    rates = (rate, rate if bump_rate is None else bump_rate)
    for value in (*rates, force):
        if not 0.0 < value < inf:
            raise ValueError(
                f"rates and force of a saturating law must be positive, {value:g} given"
            )
    for slope in rates:
        if not force / slope >= LEAST_SCALE:
            raise ValueError(
                f"a saturating law with a rate of {slope:g} cannot have a force of {force:g}: it must be "
                f"at least {LEAST_SCALE:g} times the rate"
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
    try:
        chord = coefficient * linear_below ** (exponent - 1.0)
    except OverflowError:
        chord = inf
    if not isfinite(chord):
        raise ValueError(
            f"power law: its force at linear_below = {linear_below:g} is too large with coefficient = "
            f"{coefficient:g} and exponent = {exponent:g}; give another linear_below"
        )
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
    Where they raise an exception the integrator tries a shorter step; if that fails, too, or steps are
    fixed, the run ends with the exception.

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


def driving_rate(damper: Characteristic) -> float | None:
    """Return a rate up to 100 m/s at which a damper adds energy; None if there is none.

    Where a user-defined function raises an exception nothing is known.
    """
    for rate in (*damper.corners, *_RATES):
        with suppress(Exception):
            if damper.force(rate) * rate < 0.0:
                return rate
    return None


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
