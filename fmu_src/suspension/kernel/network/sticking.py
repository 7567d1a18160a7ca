"""Rows on which dry friction sticks: their constraint, whose multipliers are the forces of friction."""

from __future__ import annotations

from ..arrays import Memory
from ..language import Doubles
from ..linear import decompose, solve
from .branches import Branches


class Sticking:
    """The constraint of all rows that stick in the present branches."""

    def __init__(self, memory: Memory, branches: Branches) -> None:
        self.branches, self.elements = branches, branches.elements
        self.signals = self.elements.signals
        n, count = self.elements.n, self.elements.count
        self.n = n
        # of each element, the force that lets it stick, and its rate
        self.multiplier, self.multiplier_rate = memory.zeros(count), memory.zeros(count)
        self.kick = memory.zeros(count)  # likewise the impulse
        self.spread, self.reaction = memory.zeros(count * n), memory.zeros(count)
        self.coupling = memory.zeros(count * count)
        self.zero, self.scratch = memory.zeros(n), memory.zeros(n)

    def forget(self) -> None:
        """Reset to no force."""
        for e in range(self.elements.count):
            self.multiplier[e] = self.multiplier_rate[e] = 0.0

    def stick(
        self, factor: Doubles, at: int, x: Doubles, base: Doubles, order: int, multiplier: Doubles
    ) -> int:
        """Correct the solution x of `factor` so that stuck rows follow their roads.

        The condition is b' (base + x) = the derivative of the road of the given order. x changes along
        the solutions for b; their multipliers are the forces required for sticking. Return 1 if the
        conditions of the rows that stick contradict each other.
        """
        n, m = self.n, self.branches.stuck
        for p in range(m):
            r = self.elements.row_of[self.branches.stuck_element[p]]
            for i in range(n):
                self.scratch[i] = self.elements.row_direction[r * n + i]
            solve(factor, at, n, self.scratch)
            s = self.elements.row_signal[r]
            self.reaction[p] = self.signals.road[4 * s + order] if s >= 0 else 0.0
            for i in range(n):
                self.spread[p * n + i] = self.scratch[i]
                self.reaction[p] -= self.elements.row_direction[r * n + i] * (base[i] + x[i])
        for p in range(m):
            r = self.elements.row_of[self.branches.stuck_element[p]]
            for k in range(m):
                g = 0.0
                for i in range(n):
                    g += self.elements.row_direction[r * n + i] * self.spread[k * n + i]
                self.coupling[p * m + k] = g
        if decompose(self.coupling, 0, m) != 0:
            return 1
        solve(self.coupling, 0, m, self.reaction)
        for p in range(m):
            multiplier[self.branches.stuck_element[p]] = -self.reaction[p]
            for i in range(n):
                x[i] += self.spread[p * n + i] * self.reaction[p]
        return 0

    def rest(self, mass_factor: Doubles, v: Doubles) -> None:
        """Remove the remaining rates of rows that stick from v, with the signals in `road`.

        Steps constrain accelerations only; on a curved road, rates then deviate by more than rounding.
        """
        if self.branches.stuck:
            self.stick(mass_factor, 0, v, self.zero, 1, self.kick)

    def hold(self) -> None:
        """Add the forces of sticking to the rows, for the works."""
        for p in range(self.branches.stuck):
            e = self.branches.stuck_element[p]
            r = self.elements.row_of[e]
            self.elements.row_f[r] = self.elements.row_f[r] + self.multiplier[e]
