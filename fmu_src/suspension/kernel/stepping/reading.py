"""A result within the last step: motion, forces and permanent sets at the time last requested."""

from __future__ import annotations

from ..motion.dense import Dense
from ..network.network import Network


class Reading:
    """The numbers that Python reads as `sample_q` and so on."""

    def __init__(self, network: Network) -> None:
        self.net = network
        memory, n, elements = self.net.memory, self.net.n, self.net.elements.count
        self.q, self.v, self.a = memory.zeros(n), memory.zeros(n), memory.zeros(n)
        self.low = memory.zeros(n)  # displacements, measured from the datum
        self.f, self.set = memory.zeros(elements), memory.zeros(elements)

    def take(self, dense: Dense) -> None:
        """Take the motion that the dense output has just read."""
        for i in range(self.net.n):
            self.low[i] = dense.q[i]
            self.q[i] = dense.q[i] + self.net.state.datum
            self.v[i], self.a[i] = dense.v[i], dense.a[i]

    def find_forces(self, t: float, h: float) -> None:
        """Find accelerations and forces at the same time t, in the branches of a step of length h."""
        self.net.read_forces(t, h, self.low, self.v, self.a, self.f, self.set)
