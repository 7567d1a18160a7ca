"""Springs in series with dampers (Maxwell elements): their internal coordinates and coupling.

See `systems.System.with_internal` for the equations. The last coordinates of a system are internal:
each is the integral of the extension of one spring. With the rate k of the spring and the direction b
of its element, the forces are -k b y' on the masses and +k b' q' on the internal coordinate y.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..arrays import Memory
from ..language import Doubles

if TYPE_CHECKING:
    from ...systems import System


class SeriesSprings:
    """The springs in series of a system; most systems have none."""

    n: int
    internal: int
    outer: int

    def __init__(self, memory: Memory, system: System) -> None:
        self.n, self.internal = len(system.mass), len(system.internal)
        self.outer = self.n - self.internal  # number of the coordinates that are not internal
        n, inner = self.n, range(self.outer, self.n)
        # of each element: its internal coordinate, or -1
        self.of_element = memory.integers(
            next((i for i in inner if element.direction[i]), -1) for element in system.elements
        )
        room = max(self.internal, 1)
        self.direction, self.rate = memory.zeros(room * n), memory.zeros(room)
        # rates along the directions, and of the internal coordinates
        self.way, self.speed = memory.zeros(n), memory.zeros(n)
        # the skew part of B, and the springs as part of K, as if their dampers were rigid
        self.skew, self.stiffness = memory.zeros(n * n), memory.zeros(n * n)

    def enter_springs(self, mass: Doubles, x: Doubles, at: int) -> int:
        """Read rates from the mass matrix and directions from x[at:]; return where they end."""
        n = self.n
        for i in range(n * n):
            self.skew[i] = self.stiffness[i] = 0.0
        for k in range(self.internal):
            place = self.outer + k
            rate = self.rate[k] = mass[n * place + place]
            for i in range(n):
                b = self.direction[n * k + i] = x[at + n * k + i]
                self.skew[n * place + i] += rate * b
                self.skew[n * i + place] -= rate * b
            for i in range(n):
                for j in range(n):
                    b = self.direction[n * k + i] * self.direction[n * k + j]
                    self.stiffness[n * i + j] += rate * b
        return at + self.internal * n

    def take_rates(self, v: Doubles) -> None:
        """Find the rates that the forces depend on, from velocities; from accelerations, their rates."""
        n = self.n
        for k in range(self.internal):
            w = 0.0
            for i in range(n):
                w += self.direction[n * k + i] * v[i]
            self.way[k], self.speed[k] = w, v[self.outer + k]

    def add_forces(self, out: Doubles) -> None:
        """Add the forces at the rates last found to those on all coordinates."""
        n = self.n
        for k in range(self.internal):
            for i in range(n):
                out[i] -= self.rate[k] * self.direction[n * k + i] * self.speed[k]
            out[self.outer + k] += self.rate[k] * self.way[k]

    def force(self, e: int, speed: float) -> float:
        """Return the force of element e, which has an internal coordinate, at the rate of that."""
        return self.rate[self.of_element[e] - self.outer] * speed
