"""Static equilibrium of a system: sum b f(b' q - u, 0) = p.

The forces at rest are the gradient of a potential U(q). It is minimised by Newton steps with the
tangent of the present branches. A step that does not reduce U is shortened and turned towards steepest
descent, so that the iteration cannot cycle between the branches of stops, tables and tyres.
"""

from __future__ import annotations

from math import fabs, isfinite

from ..language import Doubles, Numbers, of_python, open_to_python
from ..layout import LAWS, PIECE, SPRING, START, UNBOUNDED
from ..linear import decompose, solve
from .network import Network

_MOST_TRIALS = 400


class Rest:
    """The search for the rest position of a network, with dry friction left out.

    Parameters
    ----------
    network : network of the system; its branches are not changed
    """

    def __init__(self, network: Network) -> None:
        # its parts are reached through it, because a native FMU links the network alone to its run
        self.net, self.n = network, network.n
        memory, n = self.net.memory, self.n
        self.level = memory.zeros(max(self.net.signals.count, 1))  # of roads and loads, m and N
        self.q, self.trial, self.change = memory.zeros(n), memory.zeros(n), memory.zeros(n)
        self.now, self.slope, self.size = memory.zeros(n), memory.zeros(n), memory.zeros(n)
        self.tangent, self.factor = memory.zeros(n * n), memory.zeros(n * n)

    @of_python
    def displacements(self, levels: Numbers) -> tuple[float, ...] | None:
        """Return the displacements at rest for a level of each signal, or None if there is no rest."""
        for s in range(self.net.signals.count):
            self.level[s] = levels[s]
        return None if self.find() else tuple([self.q[i] for i in range(self.net.series.outer)])

    @open_to_python
    def find(self) -> int:
        """Find the displacements `q` for the present levels; return 1 if there is no equilibrium."""
        n = self.n
        for i in range(n):
            self.q[i] = 0.0
        least = self._least_shift()
        shift = 0.0  # of the tangent, in units of the mass matrix
        for _step in range(_MOST_TRIALS):
            self._find_slope(self.q)
            if self._is_at_rest():
                return 0
            for i in range(n):
                self.now[i] = self.slope[i]
            definite = self._solve(shift)
            finite = 1
            moves = 0
            for i in range(n):
                self.trial[i] = self.q[i] - self.change[i]
                if not isfinite(self.trial[i]):
                    finite = 0
                if self.trial[i] != self.q[i]:
                    moves = 1
            if definite and not moves:
                return 0  # to rounding
            if definite and finite and self._falls():
                for i in range(n):
                    self.q[i] = self.trial[i]
                shift = 0.1 * shift if shift > least else 0.0
            else:
                shift = max(4.0 * shift, least)
            if not shift < UNBOUNDED:
                break
        return 1

    def _least_shift(self) -> float:
        """Return a small shift of the tangent, relative to the stiffness at the origin."""
        stiffness = 0.0
        largest = 0.0
        for e in range(self.net.elements.count):
            self._find_force(e, 0.0)
            for i in range(self.n):
                b = self.net.elements.row_direction[self.net.elements.row_of[e] * self.n + i]
                stiffness += fabs(self.stiffness) * b * b
        for i in range(self.n):
            largest = max(largest, self.net.mass[i * self.n + i])
        return 1e-6 * (stiffness if stiffness > 0.0 else 1.0) / largest

    def _is_at_rest(self) -> bool:
        for i in range(self.n):
            if not fabs(self.slope[i]) <= 1e-13 * self.size[i]:
                return False
        return True

    def _deflection(self, e: int, q: Doubles) -> float:
        r = self.net.elements.row_of[e]
        s = self.net.elements.row_signal[r]
        d = self.net.elements.along(r, q)
        return d - self.level[s] if s >= 0 else d

    def _find_force(self, e: int, d: float) -> None:
        """Set `force` and `stiffness` of element e at rest: up to its limit, along its yield lines."""
        if self.net.elements.limit[e] < UNBOUNDED and d >= self.net.elements.free_length[e]:
            self.force, self.stiffness = self.net.elements.limit[e], 0.0
            return
        law = LAWS * e + SPRING
        p = self.net.laws.first[law] + self.net.laws.piece_at(law, d)
        self.force = self.net.laws.law(p, d)
        self.stiffness = self.net.laws.law_slope(p, d)

    def _energy(self, e: int, d: float) -> float:
        """Return the potential of element e at rest, J."""
        if self.net.elements.limit[e] < UNBOUNDED and d >= self.net.elements.free_length[e]:
            return self.net.elements.free_potential(e, d)
        law = LAWS * e + SPRING
        k = self.net.laws.piece_at(law, d)
        p = self.net.laws.first[law] + k
        if not self.net.elements.yields[e]:
            return self.net.laws.potential(p, d)
        # the elastic line up to where it yields, then a line of flow
        elastic = self.net.laws.first[law] + 1
        end = d
        if k == 0:
            end = self.net.laws.piece[elastic * PIECE + START]
        elif k == 2:
            end = self.net.laws.piece[(elastic + 1) * PIECE + START]
        rate = self.net.laws.law_slope(elastic, end)
        force = self.net.laws.law(elastic, end)
        beyond = d - end
        return force * force / (2.0 * rate) + beyond * (
            force + 0.5 * beyond * self.net.laws.law_slope(p, d)
        )

    def _potential(self, q: Doubles) -> float:
        """Return U(q), J."""
        total = 0.0
        for m in range(self.net.loads):
            p = self.level[self.net.load_signal[m]]
            for i in range(self.n):
                total -= self.net.load_direction[m * self.n + i] * p * q[i]
        for e in range(self.net.elements.count):
            total += self._energy(e, self._deflection(e, q))
        return total

    def _find_slope(self, q: Doubles) -> None:
        """Set the gradient of U, its tangent, and the magnitude of the terms in the gradient."""
        n = self.n
        for i in range(n):
            self.slope[i] = 0.0
            self.size[i] = 0.0
        for i in range(n * n):
            self.tangent[i] = 0.0
        for i in range(self.net.series.outer, n):  # no force at rest
            self.tangent[i * n + i] = self.net.mass[i * n + i]
        for m in range(self.net.loads):
            p = self.level[self.net.load_signal[m]]
            for i in range(n):
                self.slope[i] -= self.net.load_direction[m * n + i] * p
                self.size[i] += fabs(self.net.load_direction[m * n + i] * p)
        for e in range(self.net.elements.count):
            r = self.net.elements.row_of[e]
            s = self.net.elements.row_signal[r]
            self._find_force(e, self._deflection(e, q))
            # the magnitude includes the effect of rounding in the deflection on the force
            reach = fabs(self.level[s]) if s >= 0 else 0.0
            for i in range(n):
                reach += fabs(self.net.elements.row_direction[r * n + i] * q[i])
            rounding = fabs(self.force) + fabs(self.stiffness) * reach
            for i in range(n):
                b = self.net.elements.row_direction[r * n + i]
                self.slope[i] += b * self.force
                self.size[i] += fabs(b) * rounding
                for j in range(n):
                    c = self.net.elements.row_direction[r * n + j]
                    self.tangent[i * n + j] += b * c * self.stiffness

    def _falls(self) -> bool:
        """Return whether U decreases from `q` to the trial or, within rounding, its gradient does."""
        before = self._potential(self.q)
        after = self._potential(self.trial)
        if fabs(after - before) > 1e-9 * (fabs(before) + fabs(after)):
            return after < before
        self._find_slope(self.trial)
        largest = 0.0
        largest_now = 0.0
        for i in range(self.n):
            largest = max(largest, fabs(self.slope[i]))
            largest_now = max(largest_now, fabs(self.now[i]))
        return largest < largest_now

    def _solve(self, shift: float) -> bool:
        """Solve (tangent + shift mass) change = slope; return whether that is positive definite."""
        n = self.n
        for i in range(n * n):
            self.factor[i] = self.tangent[i] + shift * self.net.mass[i]
        if decompose(self.factor, 0, n) != 0:
            return False
        for i in range(n):
            k = i * n + i
            if not self.factor[k] > 1e-14 * fabs(self.tangent[k] + shift * self.net.mass[k]):
                return False
            self.change[i] = self.slope[i]
        solve(self.factor, 0, n, self.change)
        return True
