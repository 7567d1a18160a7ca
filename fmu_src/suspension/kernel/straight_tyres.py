"""The forces of tyres whose laws are straight in the present branches, without their limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .layout import DAMPER, MODULATION, SPRING

if TYPE_CHECKING:
    from .network import Network


class StraightTyres:
    """Force at rest, stiffness and damping of each element with a contact.

    Parameters
    ----------
    network : network of the system
    """

    def __init__(self, network: Network) -> None:
        self.net = network
        memory, elements = self.net.memory, self.net.elements
        self.f, self.k = memory.zeros(elements), memory.zeros(elements)
        self.c = memory.zeros(elements)
        self.straight = memory.marks(elements)

    def enter(self, e: int) -> None:
        """Store force at rest, stiffness and damping of a tyre, if its pieces are straight."""
        ps, pd = self.net.piece_now(e, SPRING), self.net.piece_now(e, DAMPER)
        self.straight[e] = self.net.straight[ps] and self.net.straight[pd]
        factor = 1.0
        if self.net.modulated[e]:
            pm = self.net.piece_now(e, MODULATION)
            factor = self.net.law(pm, 0.0)
            if not self.net.straight[pm] or self.net.law_slope(pm, 0.0) != 0.0:
                self.straight[e] = 0
        self.k[e] = self.net.law_slope(ps, 0.0)
        self.c[e] = self.net.law_slope(pd, 0.0) * factor
        self.f[e] = self.net.intercept(ps) + self.net.intercept(pd) * factor
