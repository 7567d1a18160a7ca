"""W = (M + s/2 B + s^2/6 K)^-1 for the substeps s of all columns (see `columns`).

M + s/2 B + s^2/6 K is the effective mass of a substep: what its equilibrium demands of the acceleration
at its end. While rows stick, W is projected on their condition, so that no force moves them. Curved rows
need W only along their own directions.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..language import inline
from ..motion.balance import Balance

# share of a condition that is independent of those before it, below which it follows from them
_DEPENDENT = 1e-12


class Inverses:
    """The matrices W of a macro step, and their products with the rows that stick or are curved.

    Parameters
    ----------
    balance : equation of motion of the branches
    sequence : substeps in each column of the extrapolation, one to four columns, ascending
    """

    def __init__(self, balance: Balance, sequence: Sequence[int]) -> None:
        self.balance = balance
        self.net, self.n, self.columns = self.balance.net, self.balance.n, len(sequence)
        self.elements, self.branches = self.net.elements, self.net.branches
        n, rows, columns = self.n, max(self.elements.rows, 1), self.columns
        memory = self.net.memory
        self.substeps = memory.integers(sequence)
        self.step = -1.0  # macro step of the matrices, s; -1 if there are none
        self.s, self.half, self.third, self.sixth = [0.0] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4
        self.inverse = [0.0] * 4096  # a literal size, as for all C arrays here
        # for each column and curved row: W b, and b' W b with each curved row
        self.yield_of = memory.zeros(columns * rows * n)
        self.coupling = memory.zeros(columns * rows * rows)
        # for each column and sticking row: the accelerations per unit acceleration of its road
        self.carried = memory.zeros(columns * rows * n)
        # W b or W' b of a row, W b / b' W b of a sticking row, and b' W b of each before any is held
        self.f, self.held, self.alone = [0.0] * 32, [0.0] * 32, [0.0] * 64

    def forget(self) -> None:
        """Discard the matrices, after a change of branch."""
        self.step = -1.0

    def prepare(self, h: float) -> int:
        """Find W of all columns for a macro step h; return 1 if one is not positive definite."""
        if self.n == 2:  # with a constant as argument the compiler unrolls loops
            return self._find(2, h)
        if self.n == 4:
            return self._find(4, h)
        return self._find(self.n, h)

    @inline
    def _find(self, n: int, h: float) -> int:
        if self._invert(n, h) != 0:
            return 1
        for c in range(self.columns):
            if self.branches.stuck and self._hold(n, c) != 0:
                return 1
            if self.balance.bends.count:
                self._couple(n, c)
        self.step = h
        return 0

    @inline
    def _invert(self, n: int, h: float) -> int:
        """Find (M + s/2 B + s^2/6 K)^-1 for the substeps s of all columns by Gauss-Jordan elimination."""
        self.step = -1.0
        for c in range(self.columns):
            s = h / self.substeps[c]
            self.s[c] = s
            self.half[c] = half = 0.5 * s
            self.third[c] = s * s / 3.0
            self.sixth[c] = sixth = s * s / 6.0
            for i in range(n * n):
                mass = self.net.mass[i] + half * self.balance.damping[i]
                self.inverse[n * n * c + i] = mass + sixth * self.balance.stiffness[i]
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

    @inline
    def _spread(self, n: int, c: int, r: int, over: int, down: int) -> None:
        """Set `f` to W b of row r with strides 1 and n, to W' b with n and 1."""
        for i in range(n):
            x = 0.0
            for m in range(n):
                b = self.elements.row_direction[n * r + m]
                x += self.inverse[n * n * c + over * i + down * m] * b
            self.f[i] = x

    @inline
    def _along(self, n: int, r: int) -> float:
        """Return b' f of row r."""
        x = 0.0
        for i in range(n):
            x += self.elements.row_direction[n * r + i] * self.f[i]
        return x

    def _hold(self, n: int, c: int) -> int:
        """Project W on b' a = 0 for the rows that stick; return 1 if these conditions are contradictory.

        For each row in turn, W <- W - W b b' W / b' W b; the accelerations caused by the roads of the
        rows before it are projected likewise.
        """
        for p in range(self.branches.stuck):
            r = self.elements.row_of[self.branches.stuck_element[p]]
            self._spread(n, c, r, 1, n)
            self.alone[p] = self._along(n, r)
        for p in range(self.branches.stuck):
            r = self.elements.row_of[self.branches.stuck_element[p]]
            self._spread(n, c, r, 1, n)
            size = self._along(n, r)
            if not size > _DEPENDENT * self.alone[p]:
                return 1
            for i in range(n):
                self.held[i] = self.f[i] / size
            self._spread(n, c, r, n, 1)
            for i in range(n):
                for m in range(n):
                    self.inverse[n * n * c + n * m + i] -= self.held[i] * self.f[m]
            for o in range(p):
                at = n * (self.elements.rows * c + o)
                x = 0.0
                for i in range(n):
                    x += self.elements.row_direction[n * r + i] * self.carried[at + i]
                for i in range(n):
                    self.carried[at + i] -= x * self.held[i]
            for i in range(n):
                self.carried[n * (self.elements.rows * c + p) + i] = self.held[i]
        return 0

    @inline
    def _couple(self, n: int, c: int) -> None:
        """Find W b and b' W b of the curved rows."""
        bends, rows = self.balance.bends.count, self.elements.rows
        for p in range(bends):
            self._spread(n, c, self.balance.bends.row[p], 1, n)
            for i in range(n):
                self.yield_of[n * (rows * c + p) + i] = self.f[i]
            for o in range(bends):
                self.coupling[rows * (rows * c + p) + o] = self._along(n, self.balance.bends.row[o])
