"""A step by the method of Dormand and Prince, of order 5 with an error of order 4.

J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980)
19-26.
"""

from __future__ import annotations

from phaseplane.equations.method import Function, Made


def dormand_prince(f: Function, t: float, x: float, v: float, a: float, h: float) -> Made:
    """Return the end of a step h from x, x' and x''."""
    v2 = v + h * 0.2 * a
    a2 = f(v2, x + h * 0.2 * v, t + 0.2 * h)
    v3 = v + h * (3 / 40 * a + 9 / 40 * a2)
    a3 = f(v3, x + h * (3 / 40 * v + 9 / 40 * v2), t + 0.3 * h)
    v4 = v + h * (44 / 45 * a - 56 / 15 * a2 + 32 / 9 * a3)
    a4 = f(v4, x + h * (44 / 45 * v - 56 / 15 * v2 + 32 / 9 * v3), t + 0.8 * h)
    v5 = v + h * (19372 / 6561 * a - 25360 / 2187 * a2 + 64448 / 6561 * a3 - 212 / 729 * a4)
    x5 = x + h * (19372 / 6561 * v - 25360 / 2187 * v2 + 64448 / 6561 * v3 - 212 / 729 * v4)
    a5 = f(v5, x5, t + 8 / 9 * h)
    v6 = v + h * (9017 / 3168 * a - 355 / 33 * a2 + 46732 / 5247 * a3 + 49 / 176 * a4
                  - 5103 / 18656 * a5)  # fmt: skip
    x6 = x + h * (9017 / 3168 * v - 355 / 33 * v2 + 46732 / 5247 * v3 + 49 / 176 * v4
                  - 5103 / 18656 * v5)  # fmt: skip
    a6 = f(v6, x6, t + h)
    v7 = v + h * (35 / 384 * a + 500 / 1113 * a3 + 125 / 192 * a4 - 2187 / 6784 * a5
                  + 11 / 84 * a6)  # fmt: skip
    x7 = x + h * (35 / 384 * v + 500 / 1113 * v3 + 125 / 192 * v4 - 2187 / 6784 * v5
                  + 11 / 84 * v6)  # fmt: skip
    a7 = f(v7, x7, t + h)
    apart = v7 - v6  # both at the end of the step
    decay = h * (a6 - a7) / apart if apart else 0.0
    return x7, v7, a7, _lack(h, v, v3, v4, v5, v6, v7), _lack(h, a, a3, a4, a5, a6, a7), decay


def _lack(h: float, k1: float, k3: float, k4: float, k5: float, k6: float, k7: float) -> float:
    """Return the difference between the results of order 5 and 4."""
    return h * (
        71 / 57600 * k1 - 71 / 16695 * k3 + 71 / 1920 * k4 - 17253 / 339200 * k5
        + 22 / 525 * k6 - k7 / 40
    )  # fmt: skip
