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
        self.time = network.state.memory.zeros(self.elements.count)  # of every element, s
        self.present = 0  # how many are at their limit

    def enter(self) -> None:
        """Count the elements at their limit in the present branches."""
        self.present = 0
        for k in range(self.count):
            self.present += self.elements.branch[BRANCHES * self.element[k] + CONTACT]

    def add_step(self, h: float) -> None:
        """Add a step, in the present branches."""
        for k in range(self.count):
            e = self.element[k]
            if self.elements.branch[BRANCHES * e + CONTACT]:
                self.time[e] += h
