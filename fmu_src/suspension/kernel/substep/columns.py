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

from collections.abc import Sequence
from functools import cache
from math import isfinite

from ..language import Doubles, inline, of_python
from ..motion.balance import Balance, multiply, resist
from ..motion.motion import Motion
from ..outcomes import NOT_POSITIVE
from .inverses import Inverses
from .iteration import Iteration

_SUBSTEPS = 5  # in the longest column

# Substeps in each column of the extrapolation, by order; stable for overdamped modes.
SEQUENCES = {2: (1,), 4: (1, 3), 6: (1, 2, 4), 8: (1, 2, 3, 5)}


@cache
@of_python
def instants_of(sequence: tuple[int, ...]) -> tuple[list[float], list[int]]:
    """Return the ends of all substeps, as fractions of a macro step, and the index of each of them."""
    fractions = sorted({(i + 1.0) / m for m in sequence for i in range(m)})
    return fractions, [
        fractions.index((i + 1.0) / m) if i < m else 0 for m in sequence for i in range(_SUBSTEPS)
    ]


@cache
@of_python
def extrapolation_weights(sequence: tuple[int, ...]) -> list[float]:
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
    motion : the motion from whose present state they are taken
    balance : equation of motion of the branches
    sequence : substeps in each column of the extrapolation, one to four columns, ascending
    fraction_index : index of the loads at the end of each substep, 5 for each column
    """

    def __init__(
        self,
        motion: Motion,
        balance: Balance,
        sequence: tuple[int, ...],
        fraction_index: Sequence[int],
    ) -> None:
        self.motion, self.balance = motion, balance
        self.n, self.columns = self.balance.n, len(sequence)
        self.elements, self.branches = self.balance.elements, self.balance.branches
        memory = self.balance.net.memory
        self.inverses = Inverses(balance, sequence)
        self.iteration = Iteration(self.inverses)
        self.instant = memory.integers(fraction_index)
        weights = extrapolation_weights(sequence)
        lower = [0.0, *extrapolation_weights(sequence[1:])]
        self.weight = memory.doubles(weights)
        self.check = memory.doubles(w - x for w, x in zip(weights, lower, strict=True))
        # literal sizes, as these are C arrays: the compiler knows that they do not overlap
        self.q, self.v, self.a = [0.0] * 128, [0.0] * 128, [0.0] * 128
        self.f = [0.0] * 32
        self.error_q, self.error_v = [0.0] * 32, [0.0] * 32

    def attempt(self, h: float, a: Doubles) -> int:
        """Take a macro step h, which begins with the accelerations a: find the end of each column.

        Returns
        -------
        0, or the key in `outcomes.FAILURES` of the reason why it failed.
        """
        if h != self.inverses.step and self.inverses.prepare(h) != 0:
            return NOT_POSITIVE
        n = self.n
        if self.balance.bends.count:
            self._begin_rows(a)
        # with constants as arguments the compiler unrolls loops and drops branches
        if self.balance.bends.count or self.branches.stuck:
            if n == 2:
                return self._advance(2, self.columns, True, a)
            if n == 4:
                return self._advance(4, self.columns, True, a)
            return self._advance(n, self.columns, True, a)
        if n == 2 and self.columns == 1:
            return self._advance(2, 1, False, a)
        if n == 2:
            return self._advance(2, self.columns, False, a)
        if n == 1:
            return self._advance(1, self.columns, False, a)
        if n == 4:
            return self._advance(4, self.columns, False, a)
        return self._advance(n, self.columns, False, a)

    @inline
    def _advance(self, n: int, columns: int, rows: bool, a: Doubles) -> int:
        """Step all columns over the whole macro step; the shorter ones finish first."""
        first = 0
        for c in range(columns):
            for i in range(n):
                self.q[n * c + i] = self.motion.q[i]
                self.v[n * c + i] = self.motion.v[i]
                self.a[n * c + i] = a[i]
        for k in range(self.inverses.substeps[columns - 1]):
            while k == self.inverses.substeps[first]:
                first += 1
            for c in range(first, columns):
                status = self._substep(n, rows, c, k)
                if status != 0:
                    return status
        return 0

    # -- one substep -------------------------------------------------------------------------------

    @inline
    def _substep(self, n: int, rows: bool, c: int, k: int) -> int:
        """Take substep k of a column by (15.12) and (15.13), with equilibrium at its end."""
        at = n * c
        instant = self.instant[_SUBSTEPS * c + k]
        s, half = self.inverses.s[c], self.inverses.half[c]
        third, sixth = self.inverses.third[c], self.inverses.sixth[c]
        for i in range(at, at + n):
            a, v = self.a[i], self.v[i]
            self.q[i] = self.q[i] + s * v + third * a
            self.v[i] = v + half * a
        resist(
            self.balance.damping, self.v, self.balance.stiffness, self.q, at, n,
            self.balance.loads, n * instant, self.f,
        )  # fmt: skip
        multiply(self.inverses.inverse, n * n * c, self.f, n, self.a, at)
        status = self._solve_rows(n, c, k, instant) if rows else 0
        for i in range(at, at + n):
            a = self.a[i]
            self.v[i] += half * a
            self.q[i] += sixth * a
        return status

    @inline
    def _solve_rows(self, n: int, c: int, k: int, instant: int) -> int:
        """Correct the accelerations for rows that stick or are curved."""
        for p in range(self.branches.stuck):
            u = self.balance.carrier[self.elements.rows * instant + p]
            for i in range(n):
                self.a[n * c + i] += self.inverses.carried[n * (self.elements.rows * c + p) + i] * u
        bends = self.balance.bends.count
        if bends == 1:
            return self._bend(n, 1, c, k, instant)
        if bends == 2:
            return self._bend(n, 2, c, k, instant)
        return self._bend(n, bends, c, k, instant) if bends else 0

    @inline
    def _bend(self, n: int, bends: int, c: int, k: int, instant: int) -> int:
        """Find the accelerations of the curved rows, and add the effect of their forces to all others."""
        at = 2 * self.elements.rows * instant
        for p in range(bends):
            r = self.balance.bends.row[p]
            d = 0.0
            w = 0.0
            x = 0.0
            for i in range(n):
                b = self.elements.row_direction[n * r + i]
                d += b * self.q[n * c + i]
                w += b * self.v[n * c + i]
                x += b * self.a[n * c + i]
            self.iteration.d[p] = d - self.balance.under[at + 2 * p]
            self.iteration.w[p] = w - self.balance.under[at + 2 * p + 1]
            self.iteration.x0[p] = x
        status = self.iteration.find(bends, c)
        if status != 0:
            return status
        for p in range(bends):
            force = self.iteration.force_of(p)
            at = n * (self.elements.rows * c + p)
            for i in range(n):
                self.a[n * c + i] -= self.inverses.yield_of[at + i] * force
        self.iteration.keep(bends, c, k)
        return 0

    def _begin_rows(self, a: Doubles) -> None:
        """Let the accelerations of curved rows begin as those of the step's start, with its jerk."""
        for p in range(self.balance.bends.count):
            r = self.balance.bends.row[p]
            x = self.elements.along(r, a)
            self.iteration.begin(p, x, self.elements.along(r, self.motion.j))

    # -- the end -----------------------------------------------------------------------------------

    def extrapolate(self) -> int:
        """Find the end of the motion's attempt: that of the last column plus small corrections.

        `error_q` and `error_v` become the differences of the last two columns of the table; a single
        column ends with its own acceleration. Return 1 if the end is not finite.
        """
        if self.columns == 1:
            return self._end_column(2) if self.n == 2 else self._end_column(self.n)
        if self.n == 2:
            return self._extrapolate(2, self.columns)
        if self.n == 4:
            return self._extrapolate(4, self.columns)
        return self._extrapolate(self.n, self.columns)

    @inline
    def _end_column(self, n: int) -> int:
        """End with the only column, in equilibrium if all forces are straight."""
        for i in range(n):
            q, v = self.q[i], self.v[i]
            if not (isfinite(q) and isfinite(v)):
                return 1
            self.motion.qb[i], self.motion.vb[i], self.motion.ab[i] = q, v, self.a[i]
        return 0

    @inline
    def _extrapolate(self, n: int, columns: int) -> int:
        last = n * (columns - 1)
        for i in range(n):
            last_q, last_v = self.q[last + i], self.v[last + i]
            end_q = end_v = error_q = error_v = 0.0
            for c in range(columns - 1):
                x = self.q[n * c + i] - last_q
                end_q += self.weight[c] * x
                error_q += self.check[c] * x
                y = self.v[n * c + i] - last_v
                end_v += self.weight[c] * y
                error_v += self.check[c] * y
            self.error_q[i], self.error_v[i] = error_q, error_v
            end_q += last_q
            end_v += last_v
            if not (isfinite(end_q) and isfinite(end_v)):
                return 1
            self.motion.qb[i], self.motion.vb[i] = end_q, end_v
        return 0
