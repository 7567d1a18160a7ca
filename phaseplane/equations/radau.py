"""A step by Radau's method IIA, as long as the motion itself allows, however strong its damping is.

The accelerations a_i of its three stages, at c = (4 -+ sqrt(6)) / 10 and 1, fulfil the equation there,

    v_i = v + h sum A_ij a_j,   x_i = x + h sum A_ij v_j,   a_i = F(v_i, x_i, t + c_i h),

with an error of order 5.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 1996, section IV.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nan, sqrt

from phaseplane.equations.method import Function, Made
from phaseplane.equations.switching import slope

Matrix = Sequence[Sequence[float]]
"""3 by 3. In lists so small, numbers are multiplied sooner than in arrays."""

_R = sqrt(6.0)
_A = [
    [(88.0 - 7.0 * _R) / 360.0, (296.0 - 169.0 * _R) / 1800.0, (3.0 * _R - 2.0) / 225.0],
    [(296.0 + 169.0 * _R) / 1800.0, (88.0 + 7.0 * _R) / 360.0, (-3.0 * _R - 2.0) / 225.0],
    [(16.0 - _R) / 36.0, (16.0 + _R) / 36.0, 1.0 / 9.0],
]
_A2 = [[sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*_A, strict=True)]
       for row in _A]  # fmt: skip
_C = [sum(row) for row in _A]
_ITERATIONS = 12
_CONVERGED = 1e-13  # of the velocity: the last correction
_ULPS = 2.0**-50  # of x: what rounding may move it
# the error of x in the middle of such a polynomial is e, elsewhere 64 e s^3 (1 - s)^3: its slope at most
_OFF = 192.0 / 25.0 / sqrt(5.0)

_FAILED = nan, nan, nan, inf, inf, nan


def radau(f: Function, t: float, x: float, v: float, a: float, h: float) -> Made:
    """Return the end of a step h from x, x' and x'', made in two halves.

    The errors are those of one made as a whole, and the last corrections of Newton's method; that of x'
    is no less than the one in the polynomial between the ends, which its x in the middle shows.
    """
    by_v = slope(lambda v: f(v, x, t), v)
    by_x = slope(lambda x: f(v, x, t), x)
    try:
        whole, half = (_inverse(s * by_v, s * s * by_x) for s in (h, 0.5 * h))
    except ZeroDivisionError:
        return _FAILED
    x_once, v_once, _, of_whole = _end(f, t, x, v, a, h, whole)
    x_half, v_half, a_half, of_first = _end(f, t, x, v, a, 0.5 * h, half)
    x_end, v_end, a_end, of_second = _end(f, t + 0.5 * h, x_half, v_half, a_half, 0.5 * h, half)
    between = 0.5 * (x + x_end) + h * (5.0 / 32.0 * (v - v_end) + h / 64.0 * (a + a_end))
    off = max(abs(v_end - v_once), _OFF * (abs(between - x_half) - _ULPS * abs(x)) / h)
    left = of_whole + of_first + of_second
    return x_end, v_end, a_end, abs(x_end - x_once) + h * left, off + left, -h * by_v


def _end(
    f: Function,
    t: float,
    x: float,
    v: float,
    a: float,
    h: float,
    inverse: Matrix,
) -> tuple[float, float, float, float]:
    """Return x, x' and x'' at the end, which is the last stage, and the last correction of x'.

    Corrections end where they no longer decrease: at the rounding of f, or where Newton's method fails.

    Parameters
    ----------
    inverse : of the derivatives of a_i - F, 3 by 3, at the start
    """
    times = [t + h * c for c in _C]
    found = [a, a, a]
    size = inf
    for _ in range(_ITERATIONS):
        speeds = [v + h * rise for rise in _times(_A, found)]
        places = [
            x + h * (v * c + h * rise) for c, rise in zip(_C, _times(_A2, found), strict=True)
        ]
        lacks = [f(*at) - a for *at, a in zip(speeds, places, times, found, strict=True)]
        changes = _times(inverse, lacks)
        found = [a + change for a, change in zip(found, changes, strict=True)]
        before, size = size, h * max(map(abs, changes))
        if not _CONVERGED * max(map(abs, (v, *speeds))) < size < 0.5 * before:
            break
    return (
        x + h * (v + h * _times(_A2, found)[2]),
        v + h * _times(_A, found)[2],
        found[2],
        size,
    )


def _inverse(damping: float, stiffness: float) -> Matrix:
    """Return the inverse of 1 - damping A - stiffness A^2, by cofactors.

    Raises
    ------
    ZeroDivisionError : there is none.
    """
    (a, b, c), (d, e, f), (g, h, i) = (
        [(j == k) - damping * _A[j][k] - stiffness * _A2[j][k] for k in range(3)] for j in range(3)
    )
    rows = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    whole = a * rows[0][0] + b * rows[1][0] + c * rows[2][0]
    return [[x / whole for x in row] for row in rows]


def _times(matrix: Matrix, vector: Sequence[float]) -> list[float]:
    """Return the product of a matrix and a vector."""
    p, q, r = vector
    return [one * p + two * q + three * r for one, two, three in matrix]
