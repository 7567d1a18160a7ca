"""The energy stored in the present branches: a parabola for each row, if its forces are straight."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .language import inline
from .layout import BRANCHES, CONTACT, SPRING

if TYPE_CHECKING:
    from .language import Doubles
    from .network import Network


class Potential:
    """The energy of each row, e0 + e1 d + e2 d^2, and which rows have elements that are added one by one.

    Parameters
    ----------
    network : network of the system
    """

    def __init__(self, network: Network) -> None:
        self.net = network
        memory, rows = self.net.memory, max(self.net.rows, 1)
        self.e0, self.e1, self.e2 = memory.zeros(rows), memory.zeros(rows), memory.zeros(rows)
        self.by_element = memory.marks(rows)

    def enter(self) -> None:
        """Read the present branches."""
        for r in range(self.net.rows):
            self.by_element[r] = 0
            self.e0[r] = self.e1[r] = self.e2[r] = 0.0
        for e in range(self.net.elements):
            self._add(e)

    def _add(self, e: int) -> None:
        """Add the potential of element e to that of its row, if it is a parabola."""
        r = self.net.element_row[e]
        if self.net.branch[BRANCHES * e + CONTACT]:
            self.e0[r] += self.net.free_potential(e, 0.0)
            self.e1[r] += self.net.limit[e]
        elif self.net.yields[e] or not self.net.spring_is_straight(e):
            self.by_element[r] = 1
        else:
            p = self.net.piece_now(e, SPRING)
            k = self.net.law_slope(p, 0.0)
            self.e0[r] += self.net.potential(p, 0.0)
            self.e1[r] += self.net.intercept(p)
            self.e2[r] += 0.5 * k

    def energy(self, q: Doubles, v: Doubles) -> float:
        """Return kinetic energy plus the potential of all rows."""
        # with a constant in place of n the compiler unrolls the loops
        return self._sum(2, q, v) if self.net.n == 2 else self._sum(self.net.n, q, v)

    @inline
    def _sum(self, n: int, q: Doubles, v: Doubles) -> float:
        twice = 0.0
        for i in range(n):
            for k in range(n):
                twice += v[i] * self.net.mass[i * n + k] * v[k]
        energy = 0.5 * twice
        for r in range(self.net.rows):
            s = self.net.row_signal[r]
            d = -self.net.road[4 * s] if s >= 0 else 0.0
            for i in range(n):
                d += self.net.row_direction[r * n + i] * q[i]
            energy += self.e0[r] + d * (self.e1[r] + d * self.e2[r])
            if self.by_element[r]:
                for e in range(self.net.elements):
                    if self.net.element_row[e] == r:
                        energy += self._of_curved(e, d)
        return energy

    def _of_curved(self, e: int, d: float) -> float:
        """Return the potential of element e at d, or 0 if the parabola of its row includes it."""
        if self.net.branch[BRANCHES * e + CONTACT]:
            return 0.0
        if self.net.yields[e] or not self.net.spring_is_straight(e):
            return self.net.element_energy(e, d)
        return 0.0
