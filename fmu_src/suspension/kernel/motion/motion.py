"""The motion now, and at the end of an attempt: what every method is given, and what it must return."""

from __future__ import annotations

from math import fabs

from ..language import Doubles
from ..layout import UNBOUNDED
from ..network.network import Network


class Motion:
    """Displacements, velocities, accelerations and their rates, now and at the end of an attempt."""

    def __init__(self, network: Network) -> None:
        n, elements = network.n, network.elements.count
        self.net, self.n, self.elements = network, n, elements
        self.outer = self.net.series.outer
        memory = self.net.memory
        # now
        self.state = self.net.state
        kept = self.state.memory
        self.q, self.v, self.a, self.j = kept.zeros(n), kept.zeros(n), kept.zeros(n), kept.zeros(n)
        # at the end of the attempt
        self.qb, self.vb = memory.zeros(n), memory.zeros(n)
        self.ab, self.jb = memory.zeros(n), memory.zeros(n)
        # jerks with which the attempt is read between its ends, at its start and its end: these or others
        self.jerk, self.end_jerk = self.j, self.jb
        # the acceleration of the method minus that of the equation of motion, which is in `a`
        self.drift, self.drift_end = kept.zeros(n), memory.zeros(n)
        self.origin = kept.zeros(n)  # start of the run, from which the motion is measured
        # forces of sticking
        self.multiplier, self.multiplier_rate = kept.zeros(elements), kept.zeros(elements)

    def start(self) -> None:
        """Reset to rest in the equilibrium of the system that the network has read."""
        for i in range(self.n):
            self.q[i] = self.v[i] = 0.0
        self.count_from_here()

    def forget(self) -> None:
        """Discard what the last step has left besides the motion."""
        for i in range(self.n):
            self.drift[i] = self.drift_end[i] = 0.0
        for e in range(self.elements):
            self.multiplier[e] = self.multiplier_rate[e] = 0.0

    def count_from_here(self) -> None:
        """Measure the motion from the present displacements, the start of a run."""
        self.state.reach = self.state.speed = 0.0
        for i in range(self.n):
            self.origin[i] = self.q[i]

    def reach_at(self, q: Doubles) -> float:
        """Return the largest motion so far, including that at displacements q, m."""
        reach, origin = self.state.reach, self.origin
        total = 0.0  # not a number if one of them is none
        for i in range(self.outer):
            x = fabs(q[i] - origin[i])
            total += x
            reach = max(reach, x)
        return reach if total < UNBOUNDED else total

    def speed_in(self, h: float) -> float:
        """Return the largest velocity so far, including those of the attempt of length h, m/s.

        These are the one at its end and the mean velocity, as a step may go from rest to rest. One that
        ends on a switch where it starts has no length, and no mean.
        """
        speed = self.state.speed
        for i in range(self.outer):
            rounding = 1e-15 * (fabs(self.q[i]) + fabs(self.qb[i]))
            mean = (fabs(self.qb[i] - self.q[i]) - rounding) / h if h > 0.0 else 0.0
            speed = max(speed, fabs(self.vb[i]), mean)
        return speed

    def foresee(self, h: float) -> None:
        """Set the end of an attempt to that of the Taylor series, with constant jerks."""
        self.jerk = self.j
        self.end_jerk = self.j
        for i in range(self.n):
            v, a, j = self.v[i], self.a[i], self.j[i]
            self.qb[i] = self.q[i] + h * (v + h * (a / 2.0 + h * j / 6.0))
            self.vb[i] = v + h * (a + h * j / 2.0)
            self.ab[i] = a + h * j

    def keep_multipliers(self) -> None:
        """Store the present forces of sticking, as attempts overwrite those of the network."""
        for e in range(self.elements):
            self.multiplier[e] = self.net.sticking.multiplier[e]
            self.multiplier_rate[e] = self.net.sticking.multiplier_rate[e]
