"""Roots of functions of one variable."""

from __future__ import annotations

from collections.abc import Callable

_ROUNDING = 4e-16


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the place from which on a function has the sign that it has at `high`, to rounding.

    By bisection, which jumps and stretches of zeros do not disturb. The fifty values of the function are
    a small part of the work on the steps around a root, and take less time than to load scipy.optimize.

    Parameters
    ----------
    function : at `low` zero, or of the other sign
    low, high : the interval
    """
    sign = -1.0 if function(high) > 0.0 else 1.0
    least = _ROUNDING * max(abs(low), abs(high))
    while high - low > least:
        middle = 0.5 * (low + high)
        if sign * function(middle) < 0.0:
            high = middle
        else:  # or where it has no value, as at a pole
            low = middle
    return high
