"""How long elements have been at their limit, such as tyres off the road."""

from __future__ import annotations

from collections.abc import Sequence

from ..layout import BRANCHES, CONTACT
from ..network.network import Network


class Limited:
    """The elements with a limit, and the time that each has spent there."""

    def __init__(self, network: Network, elements: Sequence[int]) -> None:
        self.elements = network.elements
        self.element, self.count = network.memory.integers(elements), len(elements)
        kept = network.state.memory
        # of every element: whether it was at its limit in the last step, and the time spent there, s
        self.now, self.time = kept.marks(self.elements.count), kept.zeros(self.elements.count)

    def start(self) -> None:
        """No element is at its limit before the first step."""
        for e in range(self.elements.count):
            self.now[e] = 0

    def add_step(self, h: float) -> None:
        """Add a step, in the present branches."""
        for k in range(self.count):
            e = self.element[k]
            self.now[e] = self.elements.branch[BRANCHES * e + CONTACT]
            if self.now[e]:
                self.time[e] += h
