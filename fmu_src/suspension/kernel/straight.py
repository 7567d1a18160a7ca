"""The straight forces of the present branches, f + k d + c w: of each element, and summed by row."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .layout import BRANCHES, C1, CONTACT, DAMPER, FRICTION, MODULATION, PIECE, SPRING

if TYPE_CHECKING:
    from .network import Network


class Straight:
    """What the straight pieces of springs and dampers add to the equation of motion.

    Parameters
    ----------
    network : network of the system
    """

    def __init__(self, network: Network) -> None:
        self.net = network
        memory, elements, rows = self.net.memory, self.net.elements, self.net.rows
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
        for r in range(self.net.rows):
            self.f[r] = self.k[r] = self.c[r] = 0.0
        for e in range(self.net.elements):
            self._read(e)
            r = self.net.element_row[e]
            if self.net.branch[BRANCHES * e + CONTACT]:
                self.f[r] += self.net.limit[e]
            else:
                if not self.bent_spring[e]:
                    self.f[r] += self.spring_f[e]
                    self.k[r] += self.spring_k[e]
                if not self.bent_damper[e]:
                    self.f[r] += self.damper_f[e]
                    self.c[r] += self.damper_c[e]
            self.f[r] += self.net.branch[BRANCHES * e + FRICTION] * self.net.friction[e]

    def _read(self, e: int) -> None:
        """Read the pieces of element e."""
        spring, damper = self.net.piece_now(e, SPRING), self.net.piece_now(e, DAMPER)
        self.bent_spring[e] = not self.net.straight[spring]
        self.bent_damper[e] = not self.net.straight[damper]
        factor = 1.0
        if self.net.modulated[e]:
            p = self.net.piece_now(e, MODULATION)
            factor = self.net.law(p, 0.0)
            if not self.net.straight[p] or self.net.piece[PIECE * p + C1] != 0.0:
                self.bent_damper[e] = 1
        self.curved[e] = self.bent_spring[e] != 0 or self.bent_damper[e] != 0
        self.spring_f[e] = self.net.intercept(spring)
        self.spring_k[e] = self.net.piece[PIECE * spring + C1]
        self.damper_f[e] = factor * self.net.intercept(damper)
        self.damper_c[e] = factor * self.net.law_slope(damper, 0.0)
