"""The accelerations of curved rows in one substep: x = b' a1, with one unknown for each row.

They solve (see `columns`)

    x = x0 - sum (b' W b) f(d* + s^2/6 x, w* + s/2 x),

by Newton's correction and its term of second order (Chebyshev's method), which leave an error of third
order. As x is predicted from those before it, most substeps need one evaluation of the forces.
"""

from __future__ import annotations

from math import fabs

from ..language import Doubles, inline
from ..layout import UNBOUNDED
from ..motion.balance import MOST_ROWS
from ..outcomes import DIVERGED, NOT_CONVERGED, NOT_POSITIVE
from .inverses import Inverses

_ITERATIONS = 60
_ENDLESS = 1e290  # m/s^2; a larger residual means that the iteration has diverged
_EPSILON = 4e-16  # relative error of a sum of forces
_SMALL = 2.5e5  # in units of rounding, size of corrections that may stop decreasing
LEAST_SHARE = 1e-3  # smallest share of a correction that is taken
_AHEAD = 10.0  # factor of safety on the correction expected next
_MOST_SECOND = 0.5  # largest part of second order of a correction, over that of first order


class Iteration:
    """The accelerations of curved rows, and those of earlier substeps, which predict them."""

    def __init__(self, inverses: Inverses) -> None:
        self.inverses = inverses
        self.bends, self.rows = self.inverses.balance.bends, self.inverses.net.elements.rows
        memory, bent = self.inverses.net.memory, self.inverses.columns * max(self.rows, 1)
        # d*, w*, and x without curved forces; x and its last correction, of which the second part is due
        # to the curvature; slope of the force along x, and its rise by the curvature
        self.d, self.w, self.x0 = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.x, self.dx, self.second = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.slope, self.rise = [0.0] * 64, [0.0] * 64
        self.matrix = [0.0] * 4096  # for the correction
        # x at the ends of the last three substeps of each column
        self.x1, self.x2, self.x3 = memory.zeros(bent), memory.zeros(bent), memory.zeros(bent)
        self.enough = 0.0  # negligible error of x, m/s^2
        self.bend = -1.0  # ratio of a correction to a power of the one before; -1 if unknown

    @inline
    def begin(self, p: int, x: float, rate: float) -> None:
        """Let the first substep of every column be predicted as x + s rate."""
        self.bend = -1.0
        for c in range(self.inverses.columns):
            at, s = self.rows * c + p, self.inverses.s[c]
            self.x1[at], self.x2[at], self.x3[at] = x, x - s * rate, x - 2.0 * s * rate

    @inline
    def find(self, bends: int, c: int) -> int:
        """Find x of all curved rows, from d*, w* and x0; return 0, or the reason of the failure.

        The iteration ends when the next correction is expected to be below `enough`, or below rounding.
        If the residual grows, as beyond the saturation of a damper, the correction is halved.
        """
        sixth, half = self.inverses.sixth[c], self.inverses.half[c]
        for p in range(bends):  # the parabola through the last three values
            at = self.rows * c + p
            self.x[p] = 3.0 * (self.x1[at] - self.x2[at]) + self.x3[at]
        before = lack_before = UNBOUNDED
        share = 1.0
        for _iteration in range(_ITERATIONS):
            lack = 0.0
            rounding = 0.0
            for p in range(bends):
                x = self.x[p]
                self.bends.find(p, self.d[p] + sixth * x, self.w[p] + half * x, sixth, half)
            for p in range(bends):
                rest = self.x0[p] - self.x[p]
                size = fabs(self.x0[p])
                for o in range(bends):
                    x = self._coupling(c, p, o) * self.bends.force[o]
                    rest -= x
                    size += fabs(x)
                self.second[p] = rest
                lack = max(lack, fabs(rest))
                rounding = max(rounding, _EPSILON * size)
            if not lack < _ENDLESS:
                return DIVERGED
            if lack > lack_before and before > _SMALL * rounding and share > LEAST_SHARE:
                share *= 0.5
                for p in range(bends):
                    self.x[p] -= share * self.dx[p]
                continue
            share = 1.0
            if self._factorise(bends, c) != 0:
                return NOT_POSITIVE
            size = self._correct(bends, c)
            limit = max(self.enough, rounding)
            if before < UNBOUNDED and self._power(before) > 0.0:
                self.bend = max(self.bend, size / self._power(before))
            if (
                size <= limit
                or (
                    self.bend >= 0.0
                    and _AHEAD * self.bend * self._power(size) <= limit
                    and (not self.bends.joined or self._stays(bends, c))
                )
                or (size <= _SMALL * rounding and size >= 0.5 * before)
            ):
                return 0
            before = size
            lack_before = lack
        return NOT_CONVERGED

    @inline
    def _power(self, size: float) -> float:
        """Return the power of a correction to which the next one is proportional."""
        return size * size * size if self.bends.order == 3 else size * size

    def _stays(self, bends: int, c: int) -> bool:
        """Return whether no law of a curved row leaves the piece of a smooth table that was evaluated."""
        for p in range(bends):
            x = self.x[p]
            d, w = self.d[p] + self.inverses.sixth[c] * x, self.w[p] + self.inverses.half[c] * x
            if not self.bends.stays(p, d, w):
                return False
        return True

    @inline
    def _factorise(self, bends: int, c: int) -> int:
        """Eliminate in 1 + b' W b f', with the reciprocals of the pivots; return 1 if not possible."""
        for o in range(bends):
            slope = self.inverses.sixth[c] * self.bends.force_k[o]
            slope += self.inverses.half[c] * self.bends.force_c[o]
            self.slope[o] = slope
            for p in range(bends):
                self.matrix[MOST_ROWS * p + o] = self._coupling(c, p, o) * slope
            self.matrix[MOST_ROWS * o + o] += 1.0
        for k in range(bends):
            if not self.matrix[MOST_ROWS * k + k] > 0.0:
                return 1
            self.matrix[MOST_ROWS * k + k] = 1.0 / self.matrix[MOST_ROWS * k + k]
            for p in range(k + 1, bends):
                self.matrix[MOST_ROWS * p + k] *= self.matrix[MOST_ROWS * k + k]
                for o in range(k + 1, bends):
                    at = MOST_ROWS * p
                    self.matrix[at + o] -= self.matrix[at + k] * self.matrix[MOST_ROWS * k + o]
        return 0

    @inline
    def _eliminate(self, bends: int, x: Doubles) -> None:
        """Solve with the factors for x, in place."""
        for k in range(bends):
            for p in range(k + 1, bends):
                x[p] -= self.matrix[MOST_ROWS * p + k] * x[k]
        for k in range(bends - 1, -1, -1):
            for o in range(k + 1, bends):
                x[k] -= self.matrix[MOST_ROWS * k + o] * x[o]
            x[k] *= self.matrix[MOST_ROWS * k + k]

    @inline
    def _correct(self, bends: int, c: int) -> float:
        """Correct x for the residual in `second`; return the size of the correction, m/s^2.

        With the correction dx of Newton's method, forces change by f' dx + f'' dx^2 / 2; the last term
        is left out unless it is small.
        """
        for p in range(bends):
            self.dx[p] = self.second[p]
            self.second[p] = 0.0
        self._eliminate(bends, self.dx)
        for o in range(bends):
            self.rise[o] = x = 0.5 * self.bends.bow[o] * self.dx[o] * self.dx[o]
            for p in range(bends):
                self.second[p] -= self._coupling(c, p, o) * x
        self._eliminate(bends, self.second)
        first = 0.0
        second = 0.0
        for p in range(bends):
            first = max(first, fabs(self.dx[p]))
            second = max(second, fabs(self.second[p]))
        if not second <= _MOST_SECOND * first:
            self.bend = UNBOUNDED
            for p in range(bends):
                self.second[p] = self.rise[p] = 0.0
        size = 0.0
        for p in range(bends):
            self.dx[p] += self.second[p]
            self.x[p] += self.dx[p]
            size = max(size, fabs(self.dx[p]))
        return size

    @inline
    def _coupling(self, c: int, p: int, o: int) -> float:
        """Return b' W b of curved rows p and o."""
        return self.inverses.coupling[self.rows * (self.rows * c + p) + o]

    @inline
    def force_of(self, p: int) -> float:
        """Return the force of curved row p at the x found."""
        return self.bends.force[p] + self.slope[p] * self.dx[p] + self.rise[p]

    @inline
    def keep(self, bends: int, c: int, k: int) -> None:
        """Store x, found in substep k of a column, for the predictions that follow."""
        for p in range(bends):
            at = self.rows * c + p
            if c == 0 and k == 0:
                self._curve(p)
            # in the prediction for the second substep, the parabola has the rate at the start
            earlier = self.x2[at]
            if k == 0:
                earlier = self.x[p] - 4.0 * (self.x1[at] - self.x2[at]) + self.x1[at] - self.x3[at]
            self.x3[at], self.x2[at], self.x1[at] = earlier, self.x1[at], self.x[p]

    def _curve(self, p: int) -> None:
        """Let the other columns begin on the parabola that ends where the single step has ended."""
        way = self.x[p] - 2.0 * self.x1[p] + self.x2[p]
        for c in range(1, self.inverses.columns):
            part = self.inverses.s[c] / self.inverses.s[0]
            at = self.rows * c + p
            self.x2[at] += way * part * part
            self.x3[at] += 4.0 * way * part * part
