"""Roots of functions of one variable."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

_ROUNDING = 4e-16


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the place from which on a function has the sign that it has at `high`, to rounding.

    By the Illinois variant of regula falsi; where two steps do not halve the interval, by bisection.

    Parameters
    ----------
    function : continuous; at `low` zero, or of the other sign
    low, high : the interval
    """
    at_high = function(high)
    sign = -1.0 if at_high > 0.0 else 1.0
    f_low, f_high = max(sign * function(low), 0.0), sign * at_high
    least = _ROUNDING * (high - low + max(abs(low), abs(high)))
    moves = 0  # of the same end in succession: of `low` if positive, of `high` if negative
    width = before = inf  # of the last interval, and of the one before
    while high - low > least and f_high < 0.0:
        if high - low > 0.5 * before:
            middle = 0.5 * (low + high)
        else:
            middle = (f_low * high - f_high * low) / (f_low - f_high)
            middle = min(max(middle, low + 0.5 * least), high - 0.5 * least)
        before, width = width, high - low
        if not low < middle < high:
            break
        f = sign * function(middle)
        if f >= 0.0:
            low, f_low = middle, f
            moves = max(moves, 0) + 1
            f_high *= 0.5 if moves > 1 else 1.0
        else:
            high, f_high = middle, f
            moves = min(moves, 0) - 1
            f_low *= 0.5 if moves < -1 else 1.0
    return high
