"""Focal values (Lyapunov quantities) of a weak focus: how its motions spiral, from its Taylor series.

With the linear part of a centre, omega^2 = df/dx, and x = X R, x' = Y omega R about it,

    X' = Y,    Y' = -X - P(X, Y)

there is V = (X^2 + Y^2) / 2 + V3 + V4 + ... whose rate is L1 (X^2 + Y^2)^2 + L2 (X^2 + Y^2)^3 + ...
(A. M. Lyapunov 1892). The first of these values that is not zero decides: with L1 the focus is of first
order, and so on.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from phaseplane.portrait.system import Grid, PhaseSystem

_DEGREE = 9  # of the polynomial that f is compared with
_NODES = 16  # along each side of a square
_FITS = 1e-11  # of the largest f: what a polynomial may miss
_BENDS = 1e-4  # of the largest nonlinear part: the same, so that corners are not taken for small
_MOST_CURVED = 1.0  # of the linear part: the others, in a square in which all of them count
_HALVINGS = range(-20, 40)  # of the scale given, in search of such a square
_ZERO = 1e-9  # of the linear part: smaller values are rounding


def first_focal_value(system: PhaseSystem, x: float, omega: float, scale: float) -> float:
    """Return the first focal value of an equilibrium that is not zero, in some unit of length.

    It is below zero if small motions approach the equilibrium. It is 0 if four of them are, as of a
    centre, or if f is not smooth there.

    Parameters
    ----------
    x : the equilibrium
    omega : angular frequency of small motions, rad/s
    scale : any length, of x
    """
    for k in _HALVINGS:
        values = focal_values(system, x, omega, scale * 0.5**k)
        if values:
            return next((value for value in values if abs(value) > _ZERO), 0.0)
    return 0.0


def focal_values(system: PhaseSystem, x: float, omega: float, size: float) -> list[float]:
    """Return L1, L2, ... with `size` as the unit of length, each valid where those before are zero.

    A motion at the distance r, in that unit, changes it by 2 pi L_k r^(2 k + 1) in a turn. There are no
    values if f has no series within this size, or its linear part is the smaller one there.
    """
    series = _series(system, x, omega, size)
    return [] if series is None else _values(series)


def _series(system: PhaseSystem, x: float, omega: float, size: float) -> Grid | None:
    """Return the coefficients of P by powers of X and Y; None if the square does not suit."""
    fit, nodes_x, nodes_y, powers = _fit()
    with np.errstate(all="ignore"):
        force = system.forces(x + size * nodes_x, omega * size * nodes_y) / (omega**2 * size)
        curved = force - nodes_x
        if not np.abs(curved).max() <= _MOST_CURVED:
            return None
    coefficients = fit @ curved
    found = np.zeros((_DEGREE + 1, _DEGREE + 1))
    found[powers] = coefficients
    misses = chebyshev.chebval2d(nodes_x, nodes_y, found) - curved
    most = min(_FITS * np.abs(force).max(), _BENDS * np.abs(curved).max())
    if not np.abs(misses).max() <= most:
        return None
    to_powers = np.zeros_like(found)
    for k in range(_DEGREE + 1):
        to_powers[k, : k + 1] = chebyshev.cheb2poly(np.eye(k + 1)[k])
    return np.asarray(to_powers.T @ found @ to_powers)


@cache
def _fit() -> tuple[Grid, Grid, Grid, tuple[Any, ...]]:
    """Return what makes Chebyshev coefficients of values at the nodes, the nodes, and the degrees."""
    nodes = np.cos((np.arange(_NODES) + 0.5) * np.pi / _NODES)
    x, y = (grid.ravel() for grid in np.meshgrid(nodes, nodes))
    whole = chebyshev.chebvander2d(x, y, [_DEGREE, _DEGREE]).reshape(len(x), _DEGREE + 1, -1)
    i, j = np.indices((_DEGREE + 1, _DEGREE + 1))
    degrees = np.nonzero(i + j <= _DEGREE)
    return np.linalg.pinv(whole[:, degrees[0], degrees[1]]), x, y, degrees


def _values(series: Grid) -> list[float]:
    """Return the focal values of P.

    A homogeneous polynomial of degree n is an array of its coefficients by the power of Y.
    """
    forms = {n: np.array([series[n - j, j] for j in range(n + 1)]) for n in range(2, _DEGREE + 1)}
    v = {2: np.array([0.5, 0.0, 0.5])}
    values = []
    for n in range(3, _DEGREE + 2):
        # (Y d/dX - X d/dY) V_n - L (X^2 + Y^2)^(n/2) = the parts with the forms of P
        known = sum(
            np.convolve(np.arange(1, m + 1) * v[m][1:], forms[n - m + 1]) for m in range(2, n)
        )
        turn = np.diag(np.arange(n, 0, -1.0), -1) - np.diag(np.arange(1.0, n + 1.0), 1)
        columns = [turn]
        if n % 2 == 0:
            circle = np.array([1.0])
            for _ in range(n // 2):
                circle = np.convolve(circle, [1.0, 0.0, 1.0])
            columns.append(-circle[:, None])
        solved = np.linalg.lstsq(np.hstack(columns), known, rcond=None)[0]
        v[n] = solved[: n + 1]
        if n % 2 == 0:
            values.append(float(solved[-1]))
    return values
