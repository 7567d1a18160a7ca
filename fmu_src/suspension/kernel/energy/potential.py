"""The energy stored in the present branches: a parabola for each row, if its forces are straight."""

from __future__ import annotations

from ..language import Doubles, inline
from ..layout import BRANCHES, CONTACT
from ..motion.straight import Straight


class Potential:
    """The energy of each row, e0 + e1 d + e2 d^2, and the rows whose elements are added one by one."""

    def __init__(self, straight: Straight) -> None:
        self.straight, self.net = straight, straight.net
        self.elements = self.net.elements
        memory, rows = self.net.memory, max(self.elements.rows, 1)
        self.e0, self.e1, self.e2 = memory.zeros(rows), memory.zeros(rows), memory.zeros(rows)
        self.by_element = memory.marks(rows)

    def enter(self) -> None:
        """Read the present branches."""
        for r in range(self.elements.rows):
            self.by_element[r] = 0
            self.e0[r] = self.e1[r] = self.e2[r] = 0.0
        for e in range(self.elements.count):
            self._add(e)

    def _add(self, e: int) -> None:
        """Add the potential of element e to that of its row, if it is a parabola."""
        r = self.elements.row_of[e]
        if self._is_curved(e):
            self.by_element[r] = 1
            return
        self.e0[r] += self.elements.element_energy(e, 0.0)
        if self.elements.branch[BRANCHES * e + CONTACT]:
            self.e1[r] += self.elements.limit[e]
        else:
            self.e1[r] += self.straight.spring_f[e]
            self.e2[r] += 0.5 * self.straight.spring_k[e]

    def _is_curved(self, e: int) -> bool:
        """Return whether the potential of element e is no parabola, or depends on its permanent set."""
        if self.elements.branch[BRANCHES * e + CONTACT]:
            return False
        return self.elements.yields[e] != 0 or self.straight.bent_spring[e] != 0

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
        for r in range(self.elements.rows):
            s = self.elements.row_signal[r]
            d = -self.net.signals.road[4 * s] if s >= 0 else 0.0
            for i in range(n):
                d += self.elements.row_direction[r * n + i] * q[i]
            energy += self.e0[r] + d * (self.e1[r] + d * self.e2[r])
            if self.by_element[r]:
                for e in range(self.elements.count):
                    if self.elements.row_of[e] == r and self._is_curved(e):
                        energy += self.elements.element_energy(e, d)
        return energy
