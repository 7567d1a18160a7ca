"""The macro step: several columns of equal steps of the incremental method, extrapolated.

Within a step s the acceleration is linear in time (H83 eq. 15.9), so

    v1 = v* + s/2 a1,  v* = v0 + s/2 a0;    q1 = q* + s^2/6 a1,  q* = q0 + s v0 + s^2/3 a0
                                                                               (15.12, 15.13)
and the equation of motion at its end gives

    a1 = W (p1 - B v* - K q* - sum b f(d1, w1)),    W = (M + s/2 B + s^2/6 K)^-1,

where f are the forces of rows with curved springs or dampers, and K and B those of all straight ones;
W is reused while branch and step stay the same. Only the accelerations of the curved rows, x = b' a1,
are iterated. Their equation

    x = b' W (p1 - B v* - K q*) - sum (b' W b) f(d* + s^2/6 x, w* + s/2 x),

is solved by iteration, with one unknown for each curved row, none if all forces are straight.
Rows on which dry friction sticks have b' a1 = u'': W is replaced by its projection on that condition.

As the method is symmetric, its error is a series in s^2. Columns of 1, 2, 3 and 5 such steps,
extrapolated (Aitken, Neville), give a macro step of order 8. The columns are independent: one step of
each is taken in turn, so that the processor can overlap them. All matrices are stored and read by
columns, which suits vector instructions; with springs in series, B and W are not symmetric.
"""

from __future__ import annotations

from functools import cache

import cython

from .balance import MOST_ROWS
from .outcomes import DIVERGED, NOT_CONVERGED, NOT_POSITIVE

if not cython.compiled:
    from math import fabs, isfinite

    from .balance import multiply, resist

_SUBSTEPS = 5  # in the longest column

_ITERATIONS = 60
_ENDLESS = 1e290  # m/s^2; a larger residual means that the iteration has diverged
_EPSILON = 4e-16  # relative error of a sum of forces
_SMALL = 2.5e5  # in units of rounding, size of corrections that may stop decreasing
LEAST_SHARE = 1e-3  # smallest share of a correction that is taken
# share of a condition that is independent of those before it, below which it follows from them
_DEPENDENT = 1e-12
_AHEAD = 10.0  # factor of safety on the correction expected next
_MOST_SECOND = 0.5  # largest part of second order of a correction, over that of first order


# Substeps in each column of the extrapolation, by order; stable for overdamped modes.
SEQUENCES = {2: (1,), 4: (1, 3), 6: (1, 2, 4), 8: (1, 2, 3, 5)}


@cache
def instants_of(sequence):
    """Return the ends of all substeps, as fractions of a macro step, and the index of each of them."""
    fractions = sorted({(i + 1.0) / m for m in sequence for i in range(m)})
    return fractions, [
        fractions.index((i + 1.0) / m) if i < m else 0 for m in sequence for i in range(_SUBSTEPS)
    ]


@cache
def extrapolation_weights(sequence):
    """Return the weights w of macro steps with n substeps: sum w = 1, sum w / n^(2k) = 0."""
    weights = []
    for n in sequence:
        w = 1.0
        for m in sequence:
            if m != n:
                w *= n * n / (n * n - m * m)
        weights.append(w)
    return weights


class Columns:
    """Macro steps in the present branches.

    Parameters
    ----------
    balance : equation of motion of the branches
    sequence : substeps in each column of the extrapolation, one to four columns, ascending
    fraction_index : index of the loads at the end of each substep, 5 for each column
    """

    def __init__(self, balance, sequence, fraction_index):
        self.balance = balance
        self.net, self.n, self.columns = self.balance.net, self.balance.n, len(sequence)
        n, rows, columns = self.n, max(self.net.rows, 1), self.columns
        memory = self.net.memory
        self.substeps, self.instant = memory.integers(sequence), memory.integers(fraction_index)
        weights = extrapolation_weights(sequence)
        lower = [0.0, *extrapolation_weights(sequence[1:])]
        self.weight = memory.doubles(weights)
        self.check = memory.doubles(w - x for w, x in zip(weights, lower, strict=True))
        self.step = -1.0  # macro step of the matrices, s; -1 if there are none
        self.s, self.half, self.third, self.sixth = [0.0] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4
        # literal sizes, as these are C arrays: the compiler knows that they do not overlap
        self.inverse = [0.0] * 4096
        self.q, self.v, self.a = [0.0] * 128, [0.0] * 128, [0.0] * 128
        self.f, self.fk = [0.0] * 32, [0.0] * 32
        self.end_q, self.end_v = [0.0] * 32, [0.0] * 32
        self.error_q, self.error_v = [0.0] * 32, [0.0] * 32
        # for each column and curved row: W b, and b' W b with each curved row
        self.yield_of = memory.zeros(columns * rows * n)
        self.coupling = memory.zeros(columns * rows * rows)
        # for each column and sticking row: the accelerations per unit acceleration of its road
        self.carried = memory.zeros(columns * rows * n)
        # of curved rows: d*, w*, x without curved forces, x and its last correction, of which the second
        # part is due to the curvature; slope of the force along x, and its rise by the curvature
        self.d, self.w, self.x0 = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.x, self.dx, self.second = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.slope, self.rise = [0.0] * 64, [0.0] * 64
        self.matrix = [0.0] * 4096  # for the correction
        # x at the ends of the last three substeps of each column
        bent = columns * rows
        self.x1, self.x2, self.x3 = memory.zeros(bent), memory.zeros(bent), memory.zeros(bent)
        self.enough = 0.0  # negligible error of x, m/s^2
        self.bend = -1.0  # ratio of a correction to a power of the one before; -1 if unknown

    def forget(self):
        """Discard the matrices, after a change of branch."""
        self.step = -1.0

    def attempt(self, h, q, v, a, j):
        """Take a macro step h from a state: find the end of each column.

        Returns
        -------
        0, or the key in `integrator.FAILURES` of the reason why it failed.
        """
        if h != self.step and self._prepare(h) != 0:
            return NOT_POSITIVE
        n = self.n
        for c in range(self.columns):
            for i in range(n):
                self.q[n * c + i] = q[i]
                self.v[n * c + i] = v[i]
                self.a[n * c + i] = a[i]
        if self.balance.bends.count:
            self._begin_rows(n, a, j)
        # with constants as arguments the compiler unrolls loops and drops branches
        if self.balance.bends.count or self.net.stuck:
            if n == 2:
                return self._advance(2, True)
            return self._advance(4, True) if n == 4 else self._advance(n, True)
        if n == 2:
            return self._advance(2, False)
        if n == 1:
            return self._advance(1, False)
        if n == 4:
            return self._advance(4, False)
        return self._advance(n, False)

    def _advance(self, n, rows):
        """Step all columns over the whole macro step; the shorter ones finish first."""
        first = 0
        columns = self.columns
        for k in range(self.substeps[columns - 1]):
            while k == self.substeps[first]:
                first += 1
            for c in range(first, columns):
                status = self._substep(n, rows, c, k)
                if status != 0:
                    return status
        return 0

    # -- matrices ----------------------------------------------------------------------------------

    def _prepare(self, h):
        """Find W of all columns, and its products with the curved and sticking rows."""
        if self.n == 2:
            return self._find_matrices(2, h)
        if self.n == 4:
            return self._find_matrices(4, h)
        return self._find_matrices(self.n, h)

    def _find_matrices(self, n, h):
        if self._invert(n, h) != 0:
            return 1
        for c in range(self.columns):
            if self.net.stuck and self._hold(n, c) != 0:
                return 1
            if self.balance.bends.count:
                self._couple(n, c)
        self.step = h
        return 0

    def _invert(self, n, h):
        """Find (M + s/2 B + s^2/6 K)^-1 for the substeps s of all columns by Gauss-Jordan elimination."""
        self.step = -1.0
        for c in range(self.columns):
            s = h / self.substeps[c]
            self.s[c] = s
            self.half[c] = half = 0.5 * s
            self.third[c] = s * s / 3.0
            self.sixth[c] = sixth = s * s / 6.0
            for i in range(n * n):
                self.inverse[n * n * c + i] = (
                    self.net.mass[i]
                    + half * self.balance.damping[i]
                    + sixth * self.balance.stiffness[i]
                )
        for k in range(n):
            for c in range(self.columns):
                row = n * n * c + n * k
                if not self.inverse[row + k] > 0.0:
                    return 1
                pivot = 1.0 / self.inverse[row + k]
                self.inverse[row + k] = 1.0
                for i in range(n):
                    self.inverse[row + i] *= pivot
                for i in range(n):
                    if i != k:
                        at = n * n * c + n * i
                        pivot = self.inverse[at + k]
                        self.inverse[at + k] = 0.0
                        for m in range(n):
                            self.inverse[at + m] -= pivot * self.inverse[row + m]
        return 0

    def _spread(self, n, c, r):
        """Set `f` to W b of row r."""
        for i in range(n):
            x = 0.0
            for m in range(n):
                x += self.inverse[n * n * c + n * m + i] * self.net.row_direction[n * r + m]
            self.f[i] = x

    def _gather(self, n, c, r):
        """Set `f` to W' b of row r."""
        for i in range(n):
            x = 0.0
            for m in range(n):
                x += self.inverse[n * n * c + n * i + m] * self.net.row_direction[n * r + m]
            self.f[i] = x

    def _along(self, n, r):
        """Return b' f of row r."""
        x = 0.0
        for i in range(n):
            x += self.net.row_direction[n * r + i] * self.f[i]
        return x

    def _hold(self, n, c):
        """Project W on b' a = 0 for the rows that stick; return 1 if these conditions are contradictory.

        For each row in turn, W <- W - W b b' W / b' W b; the accelerations caused by the roads of the
        rows before it are projected likewise.
        """
        for p in range(self.net.stuck):
            r = self.net.element_row[self.net.stuck_element[p]]
            self._spread(n, c, r)
            self.x0[p] = self._along(n, r)
        for p in range(self.net.stuck):
            r = self.net.element_row[self.net.stuck_element[p]]
            self._spread(n, c, r)
            size = self._along(n, r)
            if not size > _DEPENDENT * self.x0[p]:
                return 1
            for i in range(n):
                self.fk[i] = self.f[i] / size
            self._gather(n, c, r)
            for i in range(n):
                for m in range(n):
                    self.inverse[n * n * c + n * m + i] -= self.fk[i] * self.f[m]
            for o in range(p):
                at = n * (self.net.rows * c + o)
                x = 0.0
                for i in range(n):
                    x += self.net.row_direction[n * r + i] * self.carried[at + i]
                for i in range(n):
                    self.carried[at + i] -= x * self.fk[i]
            for i in range(n):
                self.carried[n * (self.net.rows * c + p) + i] = self.fk[i]
        return 0

    def _couple(self, n, c):
        """Find W b and b' W b of the curved rows."""
        bends, rows = self.balance.bends.count, self.net.rows
        for p in range(bends):
            self._spread(n, c, self.balance.bends.row[p])
            for i in range(n):
                self.yield_of[n * (rows * c + p) + i] = self.f[i]
            for o in range(bends):
                self.coupling[rows * (rows * c + p) + o] = self._along(n, self.balance.bends.row[o])

    # -- one substep -------------------------------------------------------------------------------

    def _substep(self, n, rows, c, k):
        """Take substep k of a column by (15.12) and (15.13), with equilibrium at its end."""
        at = n * c
        instant = self.instant[_SUBSTEPS * c + k]
        s, half, third, sixth = self.s[c], self.half[c], self.third[c], self.sixth[c]
        for i in range(at, at + n):
            a, v = self.a[i], self.v[i]
            self.q[i] = self.q[i] + s * v + third * a
            self.v[i] = v + half * a
        resist(
            self.balance.damping, self.v, self.balance.stiffness, self.q, at, n,
            self.balance.loads, n * instant, self.f,
        )  # fmt: skip
        multiply(self.inverse, n * n * c, self.f, 0, n, self.a, at)
        status = self._solve_rows(n, c, k, instant) if rows else 0
        for i in range(at, at + n):
            a = self.a[i]
            self.v[i] += half * a
            self.q[i] += sixth * a
        return status

    def _solve_rows(self, n, c, k, instant):
        """Correct the accelerations for rows that stick or are curved."""
        for p in range(self.net.stuck):
            u = self.balance.carrier[self.net.rows * instant + p]
            for i in range(n):
                self.a[n * c + i] += self.carried[n * (self.net.rows * c + p) + i] * u
        if self.balance.bends.count == 1:
            return self._bend(n, 1, c, k, instant)
        if self.balance.bends.count == 2:
            return self._bend(n, 2, c, k, instant)
        return (
            self._bend(n, self.balance.bends.count, c, k, instant)
            if self.balance.bends.count
            else 0
        )

    def _begin_rows(self, n, a, j):
        """Set the earlier values of every column so that the first substep is predicted as a0 + s j0."""
        self.bend = -1.0
        for p in range(self.balance.bends.count):
            r = self.balance.bends.row[p]
            x = 0.0
            rate = 0.0
            for i in range(n):
                x += self.net.row_direction[n * r + i] * a[i]
                rate += self.net.row_direction[n * r + i] * j[i]
            for c in range(self.columns):
                at = self.net.rows * c + p
                self.x1[at] = x
                self.x2[at] = x - self.s[c] * rate
                self.x3[at] = x - 2.0 * self.s[c] * rate

    def _bend(self, n, bends, c, k, instant):
        """Find the accelerations of the curved rows by iteration, and with them all others.

        Newton's correction and its term of second order (Chebyshev's method) leave an error of third
        order. The iteration ends when the next correction is expected to be below `enough`, or below
        rounding. If the residual grows, as beyond the saturation of a damper, the correction is halved.
        """
        rows = self.net.rows
        sixth, half = self.sixth[c], self.half[c]
        self._expect(n, bends, c, k, instant)
        before = lack_before = 1e300
        share = 1.0
        for _iteration in range(_ITERATIONS):
            lack = 0.0
            rounding = 0.0
            for p in range(bends):
                x = self.x[p]
                self.balance.bends.find(p, self.d[p] + sixth * x, self.w[p] + half * x, sixth, half)
            for p in range(bends):
                rest = self.x0[p] - self.x[p]
                size = fabs(self.x0[p])
                for o in range(bends):
                    x = self.coupling[rows * (rows * c + p) + o] * self.balance.bends.force[o]
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
            if before < 1e300 and self._power(before) > 0.0:
                self.bend = max(self.bend, size / self._power(before))
            if (
                size <= limit
                or (
                    self.bend >= 0.0
                    and _AHEAD * self.bend * self._power(size) <= limit
                    and (not self.balance.bends.joined or self._stays(bends, c))
                )
                or (size <= _SMALL * rounding and size >= 0.5 * before)
            ):
                self._take_rows(n, bends, c, k)
                return 0
            before = size
            lack_before = lack
        return NOT_CONVERGED

    def _power(self, size):
        """Return the power of a correction to which the next one is proportional."""
        return size * size * size if self.balance.bends.order == 3 else size * size

    def _stays(self, bends, c):
        """Return whether no law of a curved row leaves the piece of a smooth table that was evaluated."""
        for p in range(bends):
            x = self.x[p]
            if not self.balance.bends.stays(
                p, self.d[p] + self.sixth[c] * x, self.w[p] + self.half[c] * x
            ):
                return 0
        return 1

    def _expect(self, n, bends, c, k, instant):
        """Find d*, w*, x without curved forces; predict x by the parabola through its last 3 values."""
        at = 2 * self.net.rows * instant
        for p in range(bends):
            r = self.balance.bends.row[p]
            d = 0.0
            w = 0.0
            x = 0.0
            for i in range(n):
                b = self.net.row_direction[n * r + i]
                d += b * self.q[n * c + i]
                w += b * self.v[n * c + i]
                x += b * self.a[n * c + i]
            self.d[p] = d - self.balance.under[at + 2 * p]
            self.w[p] = w - self.balance.under[at + 2 * p + 1]
            self.x0[p] = x
            past = self.net.rows * c + p
            self.x[p] = 3.0 * (self.x1[past] - self.x2[past]) + self.x3[past]

    def _factorise(self, bends, c):
        """Eliminate in 1 + b' W b f', with the reciprocals of the pivots; return 1 if not possible."""
        rows = self.net.rows
        for o in range(bends):
            slope = (
                self.sixth[c] * self.balance.bends.force_k[o]
                + self.half[c] * self.balance.bends.force_c[o]
            )
            self.slope[o] = slope
            for p in range(bends):
                self.matrix[MOST_ROWS * p + o] = self.coupling[rows * (rows * c + p) + o] * slope
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

    def _eliminate(self, bends, x):
        """Solve with the factors for x, in place."""
        for k in range(bends):
            for p in range(k + 1, bends):
                x[p] -= self.matrix[MOST_ROWS * p + k] * x[k]
        for k in range(bends - 1, -1, -1):
            for o in range(k + 1, bends):
                x[k] -= self.matrix[MOST_ROWS * k + o] * x[o]
            x[k] *= self.matrix[MOST_ROWS * k + k]

    def _correct(self, bends, c):
        """Correct x for the residual in `second`; return the size of the correction, m/s^2.

        With the correction dx of Newton's method, forces change by f' dx + f'' dx^2 / 2; the last term
        is left out unless it is small.
        """
        rows = self.net.rows
        for p in range(bends):
            self.dx[p] = self.second[p]
            self.second[p] = 0.0
        self._eliminate(bends, self.dx)
        for o in range(bends):
            self.rise[o] = x = 0.5 * self.balance.bends.bow[o] * self.dx[o] * self.dx[o]
            for p in range(bends):
                self.second[p] -= self.coupling[rows * (rows * c + p) + o] * x
        self._eliminate(bends, self.second)
        first = 0.0
        second = 0.0
        for p in range(bends):
            first = max(first, fabs(self.dx[p]))
            second = max(second, fabs(self.second[p]))
        if not second <= _MOST_SECOND * first:
            self.bend = 1e300
            for p in range(bends):
                self.second[p] = self.rise[p] = 0.0
        size = 0.0
        for p in range(bends):
            self.dx[p] += self.second[p]
            self.x[p] += self.dx[p]
            size = max(size, fabs(self.dx[p]))
        return size

    def _take_rows(self, n, bends, c, k):
        """Add the effect of the curved forces, and store the accelerations of their rows."""
        for p in range(bends):
            force = self.balance.bends.force[p] + self.slope[p] * self.dx[p] + self.rise[p]
            at = self.net.rows * c + p
            for i in range(n):
                self.a[n * c + i] -= self.yield_of[n * at + i] * force
            if c == 0 and k == 0:
                self._curve(p)
            # in the prediction for the second substep, the parabola has the rate at the start
            earlier = self.x2[at]
            if k == 0:
                earlier = self.x[p] - 4.0 * (self.x1[at] - self.x2[at]) + self.x1[at] - self.x3[at]
            self.x3[at], self.x2[at], self.x1[at] = earlier, self.x1[at], self.x[p]

    def _curve(self, p):
        """Let the other columns begin on the parabola that ends where the single step has ended."""
        way = self.x[p] - 2.0 * self.x1[p] + self.x2[p]
        for c in range(1, self.columns):
            part = self.s[c] / self.s[0]
            at = self.net.rows * c + p
            self.x2[at] += way * part * part
            self.x3[at] += 4.0 * way * part * part

    # -- the end -----------------------------------------------------------------------------------

    def extrapolate(self, q, v):
        """Find the end of the macro step: that of the last column plus small corrections.

        `error_q` and `error_v` become the differences of the last two columns of the table. Return 1 if
        the end is not finite.
        """
        n = self.n
        if n == 2:
            self._extrapolate(2)
        elif n == 4:
            self._extrapolate(4)
        else:
            self._extrapolate(n)
        for i in range(n):
            if not (isfinite(self.end_q[i]) and isfinite(self.end_v[i])):
                return 1
            q[i], v[i] = self.end_q[i], self.end_v[i]
        return 0

    def _extrapolate(self, n):
        last = n * (self.columns - 1)
        for i in range(n):
            self.end_q[i] = self.end_v[i] = self.error_q[i] = self.error_v[i] = 0.0
        for c in range(self.columns - 1):
            weight, check = self.weight[c], self.check[c]
            for i in range(n):
                x = self.q[n * c + i] - self.q[last + i]
                self.end_q[i] += weight * x
                self.error_q[i] += check * x
                y = self.v[n * c + i] - self.v[last + i]
                self.end_v[i] += weight * y
                self.error_v[i] += check * y
        for i in range(n):
            self.end_q[i] += self.q[last + i]
            self.end_v[i] += self.v[last + i]
