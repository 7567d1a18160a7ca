"""The straight forces of the present branches, f + k d + c w: of each element, and summed by row."""

from __future__ import annotations

from ..layout import BRANCHES, C1, CONTACT, DAMPER, FRICTION, MODULATION, PIECE, SPRING
from ..network.network import Network


class Straight:
    """What the straight pieces of springs and dampers add to the equation of motion."""

    def __init__(self, network: Network) -> None:
        self.net = network
        self.elements, self.laws = self.net.elements, self.net.laws
        memory, elements, rows = self.net.memory, self.elements.count, self.elements.rows
        # of each element, without its limit: force at rest and rate of its spring, then of its damper
        self.spring_f, self.spring_k = memory.zeros(elements), memory.zeros(elements)
        self.damper_f, self.damper_c = memory.zeros(elements), memory.zeros(elements)
        # whether they are curved instead, and whether either is; damper_c is then the rate at rest
        self.bent_spring, self.bent_damper = memory.marks(elements), memory.marks(elements)
        self.curved = memory.marks(elements)
        # of each row: the sums of what acts on it in the present branches, friction included
        self.f, self.k, self.c = memory.zeros(rows), memory.zeros(rows), memory.zeros(rows)

    def enter(self) -> None:
        """Read the present branches."""
        for r in range(self.elements.rows):
            self.f[r] = self.k[r] = self.c[r] = 0.0
        for e in range(self.elements.count):
            self._read(e)
            r = self.elements.row_of[e]
            if self.elements.branch[BRANCHES * e + CONTACT]:
                self.f[r] += self.elements.limit[e]
            else:
                if not self.bent_spring[e]:
                    self.f[r] += self.spring_f[e]
                    self.k[r] += self.spring_k[e]
                if not self.bent_damper[e]:
                    self.f[r] += self.damper_f[e]
                    self.c[r] += self.damper_c[e]
            self.f[r] += self.elements.branch[BRANCHES * e + FRICTION] * self.elements.friction[e]

    def force(self, r: int, d: float, w: float) -> float:
        """Return the straight force of row r at deflection d and rate w."""
        return self.f[r] + self.k[r] * d + self.c[r] * w

    def _read(self, e: int) -> None:
        """Read the pieces of element e."""
        spring, damper = self.elements.piece_now(e, SPRING), self.elements.piece_now(e, DAMPER)
        self.bent_spring[e] = not self.laws.straight[spring]
        self.bent_damper[e] = not self.laws.straight[damper]
        factor = 1.0
        if self.elements.modulated[e]:
            p = self.elements.piece_now(e, MODULATION)
            factor = self.laws.law(p, 0.0)
            if not self.laws.straight[p] or self.laws.piece[PIECE * p + C1] != 0.0:
                self.bent_damper[e] = 1
        self.curved[e] = self.bent_spring[e] != 0 or self.bent_damper[e] != 0
        self.spring_f[e] = self.laws.intercept(spring)
        self.spring_k[e] = self.laws.piece[PIECE * spring + C1]
        self.damper_f[e] = factor * self.laws.intercept(damper)
        self.damper_c[e] = factor * self.laws.law_slope(damper, 0.0)
