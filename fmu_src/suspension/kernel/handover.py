"""The data that a run keeps when the numbers of its system change: motion, works and counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cython

if TYPE_CHECKING:
    from .language import Doubles, Long
    from .motion import Motion
    from .network import Network

if not cython.compiled:
    from math import fabs


class Handover:
    """The part of a run's state that outlives a change of its parameters.

    Parameters
    ----------
    network : network of the system
    """

    def __init__(self, network: Network) -> None:
        self.net, self.n, self.elements = network, network.n, network.elements
        memory = self.net.memory
        self.q, self.v = memory.zeros(self.n), memory.zeros(self.n)
        self.origin = memory.zeros(self.n)  # displacements from which the motion is measured
        self.work, self.limited_time = memory.zeros(self.elements), memory.zeros(self.elements)
        self.reach = self.speed = self.scale = self.datum = 0.0
        self.exchange = self.supplied = self.residual = 0.0
        self.steps: Long = 0

    def take_run(self, motion: Motion, net: Network) -> None:
        """Store motion, energies and counts at the end of the last step."""
        # springs in series are relaxed if there were others before
        same = self.n if net.n == self.n else self.net.series.outer
        for i in range(self.n):
            self.q[i] = motion.q[i] if i < same else 0.0
            self.v[i] = motion.v[i] if i < same else 0.0
            self.origin[i] = motion.origin[i] if i < same else 0.0
        self.reach, self.speed = net.state.reach, net.state.speed
        self.scale = net.state.scale
        self.steps = net.state.step_count
        self.datum, self.exchange = net.state.datum, net.state.exchange
        self.supplied = net.state.supplied + fabs(net.state.initial_energy)
        self.residual = net.state.residual_end

    def take_element(self, here: int, there: int, work: Doubles, limited_time: Doubles) -> None:
        """Store the work and time of element `there` as those of element `here`; zero if it is -1."""
        self.work[here] = work[there] if there >= 0 else 0.0
        self.limited_time[here] = limited_time[there] if there >= 0 else 0.0
