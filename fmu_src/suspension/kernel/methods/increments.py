"""Incremental steps with curved forces, as in H83 chapter 15.

The increments of (15.16) to (15.18), with the tangents at the start of the step, or with the mean of
those at both ends (15.7), which is iterated.
"""

from __future__ import annotations

from math import fabs, isfinite
from typing import TYPE_CHECKING, Any

from ..language import Doubles
from ..layout import UNBOUNDED
from ..linear import decompose, solve
from ..network.network import Network
from ..outcomes import DIVERGED, NOT_CONVERGED, NOT_POSITIVE
from ..substep.iteration import LEAST_SHARE
from .extrapolated import Extrapolated

if TYPE_CHECKING:
    from ...systems import System

_MOST_MEANS = 200


class Increments:
    """Steps that overwrite displacements, velocities and accelerations."""

    def __init__(self, network: Network) -> None:
        self.net, self.n = network, network.n
        self.elements, self.signals = self.net.elements, self.net.signals
        self.once = False  # whether to use the tangents at the start only
        memory, n, size = self.net.memory, self.n, self.n * self.n
        self.stiffness, self.damping = memory.zeros(size), memory.zeros(size)
        self.factor = memory.zeros(size)
        self.pq, self.pv, self.sa = memory.zeros(n), memory.zeros(n), memory.zeros(n)
        self.rhs, self.correction = memory.zeros(n), memory.zeros(n)
        self.change = memory.zeros(n)  # of `rhs` in the last iteration
        # tangents of the rows at the start of a step, and those used for it
        rows = self.elements.rows
        self.start_k, self.start_c = memory.zeros(rows), memory.zeros(rows)
        self.mean_k, self.mean_c = memory.zeros(rows), memory.zeros(rows)

    def _solve_step_matrix(self, h: float) -> int:
        """Solve (M + h/2 B + h^2/6 K) x = rhs with the matrices `stiffness`, `damping`."""
        size = self.n * self.n
        for i in range(size):
            resistance = h / 2.0 * self.damping[i]
            self.factor[i] = self.net.mass[i] + resistance + h * h / 6.0 * self.stiffness[i]
        if decompose(self.factor, 0, self.n) != 0:
            return 1
        solve(self.factor, 0, self.n, self.rhs)
        return 0

    def add(self, t: float, h: float, q: Doubles, v: Doubles, a: Doubles) -> int:
        """Step from t to t + h; return 0 or a key of `outcomes.FAILURES`."""
        self._begin(t, q, v, a)
        before = UNBOUNDED
        share = 1.0
        for iteration in range(_MOST_MEANS):
            self._excitation_increment(t, h)
            self._add_resistance(h)
            if self._solve_step_matrix(h) != 0:
                return NOT_POSITIVE
            if iteration > 0:
                self._find_change(iteration)
            self._move(h, q, v, a)
            if not isfinite(self.largest):
                return DIVERGED
            if self.once:
                return 0
            if iteration > 0:
                if self._is_settled(before):
                    return 0
                # the mean may oscillate between both sides of a damper's saturation; while changes
                # keep one direction, a smaller share would only end short of the equilibrium
                if self.most_change > 0.9 * before and self.turn < 0.0:
                    share = max(0.5 * share, LEAST_SHARE)
                before = self.most_change
            for i in range(self.n):
                self.correction[i] = a[i] - self.sa[i]
            self._average(t + h, share, q, v)
        return NOT_CONVERGED

    def _begin(self, t: float, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Store the state at the start, and use the tangents there."""
        n = self.n
        for i in range(n):
            self.pq[i], self.pv[i], self.sa[i] = q[i], v[i], a[i]
        self.signals.all_signals(t)
        self.elements.row_states(self.pq, self.pv)
        self.elements.row_forces()
        for r in range(self.elements.rows):
            self.start_k[r] = self.mean_k[r] = self.elements.row_k[r]
            self.start_c[r] = self.mean_c[r] = self.elements.row_c[r]
        self.net.assemble(self.mean_k, self.mean_c, self.stiffness, self.damping)

    def _add_resistance(self, h: float) -> None:
        """Subtract from `rhs` the change of the forces due to the motion at the start (15.14)."""
        n = self.n
        for i in range(n):
            for k in range(n):
                way = h * self.pv[k] + h * h / 2.0 * self.sa[k]
                self.rhs[i] -= h * self.damping[k * n + i] * self.sa[k]
                self.rhs[i] -= self.stiffness[k * n + i] * way

    def _find_change(self, iteration: int) -> None:
        """Find the change of `rhs` by the last iteration, and whether it reverses the one before."""
        self.most_change = self.turn = 0.0
        for i in range(self.n):
            difference = self.rhs[i] - self.correction[i]
            self.turn += self.change[i] * difference if iteration > 1 else 0.0
            self.change[i] = difference
            self.most_change = max(self.most_change, fabs(difference))

    def _move(self, h: float, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Find the end from the change of acceleration in `rhs` (15.16 to 15.18)."""
        self.largest = 1e-30
        for i in range(self.n):
            self.largest = max(self.largest, fabs(self.rhs[i]) + fabs(self.sa[i]))
            v[i] = self.pv[i] + h * self.sa[i] + h / 2.0 * self.rhs[i]
            q[i] = (
                self.pq[i] + h * self.pv[i] + h * h / 2.0 * self.sa[i] + h * h / 6.0 * self.rhs[i]
            )
            a[i] = self.sa[i] + self.rhs[i]

    def _is_settled(self, before: float) -> bool:
        """Return whether changes have decreased to rounding, or are small and no longer decrease."""
        if self.most_change <= 1e-15 * self.largest:
            return True
        return self.most_change <= 1e-10 * self.largest and self.most_change >= 0.5 * before

    def _average(self, t: float, share: float, q: Doubles, v: Doubles) -> None:
        """Move the tangents by a share towards the mean of those at both ends (15.7)."""
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        self.elements.row_forces()
        for r in range(self.elements.rows):
            mean = 0.5 * (self.start_k[r] + self.elements.row_k[r])
            self.mean_k[r] += share * (mean - self.mean_k[r])
            mean = 0.5 * (self.start_c[r] + self.elements.row_c[r])
            self.mean_c[r] += share * (mean - self.mean_c[r])
        self.net.assemble(self.mean_k, self.mean_c, self.stiffness, self.damping)

    def _excitation_increment(self, t: float, h: float) -> None:
        """Set `rhs` to Delta f of (15.6): loads, and roads through the same tangents as the motion."""
        for i in range(self.n):
            self.rhs[i] = 0.0
        self.signals.all_signals(t)
        self.net.add_loads(self.mean_k, self.mean_c, self.rhs, 0, 0)
        for i in range(self.n):
            self.rhs[i] = -self.rhs[i]
        self.signals.all_signals(t + h)
        self.net.add_loads(self.mean_k, self.mean_c, self.rhs, 0, 0)


class Mean(Extrapolated):
    """The incremental step with the mean of the tangents at both of its ends (15.7), iterated.

    In straight branches and where friction sticks it is the single step that ends in equilibrium.
    """

    def __init__(self, *given: Any) -> None:
        Extrapolated.__init__(self, *given)
        self.controls = False
        self.most_error = 1.0
        # the interpolant is a cubic; its acceleration at the end is not that of the equation of motion
        self.cubic = self.to_end = True
        self.increments = Increments(self.net)

    @staticmethod
    def order_of(system: System, step: float, tolerance: float, order: int) -> int:
        return 2

    def attempt(self, t: float, h: float) -> int:
        """Step from t to t + h; return 0 or a key of `outcomes.FAILURES`."""
        if not self.balance.bends.count or self.net.branches.stuck:
            return self.extrapolate(t, h)
        for i in range(self.n):
            self.motion.qb[i], self.motion.vb[i] = self.motion.q[i], self.motion.v[i]
            self.motion.ab[i] = self.motion.a[i]
        status = self.increments.add(t, h, self.motion.qb, self.motion.vb, self.motion.ab)
        if status == 0:
            self.end(t + h)
        return status


class Tangent(Mean):
    """The incremental step with the tangents at its start, as in a calculation by hand."""

    def __init__(self, *given: Any) -> None:
        Mean.__init__(self, *given)
        self.increments.once = True
