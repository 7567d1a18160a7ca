"""One step of the incremental method with curved forces, by iteration.

Either to the equilibrium at the end of the step (Newton), or by the increments of H83 (15.16) to (15.18)
with tangents at the start, or with their mean over the step (15.7), which is iterated.
"""

from __future__ import annotations

import cython

from .arrays import doubles, vectors

if not cython.compiled:
    from math import fabs, isfinite

    from .linear import decompose, solve

_DIVERGED, _NOT_CONVERGED, _NOT_POSITIVE = 2, 4, 5  # keys of integrator.FAILURES

_LEAST_SHARE = 1e-3  # of a correction


class Iteration:
    """Steps that overwrite displacements, velocities and accelerations.

    Parameters
    ----------
    network : of the system
    state : displacements, velocities, accelerations
    signal_table : value and two derivatives of every signal at the ends of steps
    once : whether to use the tangents at the start only
    """

    def __init__(self, network, state, signal_table, once):
        self.net, self.n = network, network.n
        self.cq, self.cv, self.ca = state
        self.signal_table, self.once = signal_table, once
        self.stiffness, self.damping, self.stiffness2, self.damping2 = vectors(4, self.n * self.n)
        self.stiffness_end, self.damping_end = vectors(2, self.n * self.n)
        self.factor = doubles([0.0] * self.n * self.n)
        self.pq, self.pv, self.sa, self.rhs, self.correction = vectors(5, self.n)
        # tangents of the rows at the start of a step, and those used for it
        self.start_k, self.start_c, self.mean_k, self.mean_c = vectors(4, network.rows)

    def take_signals(self, fraction):
        """Set `road` to the signals at an instant of the table."""
        at = 3 * self.net.signals * fraction
        for s in range(self.net.signals):
            for order in range(3):
                self.net.road[4 * s + order] = self.signal_table[at + 3 * s + order]

    def reach_equilibrium(self, h, fraction, reach):
        """Step by (15.12), (15.13), with Newton's iteration to the end-of-step equilibrium.

        It ends when corrections are at rounding level, or close to it and no longer decreasing. They
        are compared with the forces, which may cancel, and with those at a displacement of `reach`.
        """
        n = self.n
        self.take_signals(fraction)
        for i in range(n):
            self.pv[i] = self.cv[i] + h / 2.0 * self.ca[i]
            self.pq[i] = self.cq[i] + h * self.cv[i] + h * h / 3.0 * self.ca[i]
        before = lack_before = 1e300
        share = 1.0
        for _iteration in range(100):
            for i in range(n):
                self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
                self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
            self.net.row_states(self.cq, self.cv)
            self.net.row_forces()
            self.net.assemble(self.stiffness2, self.damping2)
            self.net.net_force(self.rhs)
            for i in range(n):
                for k in range(n):
                    self.rhs[i] -= self.net.mass[i * n + k] * self.ca[k]
            if self._solve_step_matrix(h) != 0:
                return _NOT_POSITIVE
            if self.net.stuck and self.net.stick(
                self.factor, 0, self.rhs, self.ca, 2, self.net.multiplier
            ):
                return _NOT_POSITIVE
            size = 0.0
            for i in range(n):
                size = max(size, fabs(self.rhs[i]))
            if not isfinite(size):
                return _DIVERGED
            lack = self._lack(h)
            largest = self._largest_acceleration(reach)
            if lack > lack_before and size > 1e-10 * largest and share > _LEAST_SHARE:
                # past the saturation of a damper, for example: go only half as far
                share *= 0.5
                for i in range(n):
                    self.ca[i] -= share * self.correction[i]
                continue
            share = 1.0
            for i in range(n):
                self.ca[i] += self.rhs[i]
                self.correction[i] = self.rhs[i]
            if size <= 4e-16 * largest or (size <= 1e-10 * largest and size >= 0.5 * before):
                for i in range(n):
                    self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
                    self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
                return 0
            before = size
            lack_before = lack
        return _NOT_CONVERGED

    def _lack(self, h):
        """Return the residual of the equation of motion, per mass, before the correction in `rhs`."""
        n = self.n
        largest = 0.0
        for i in range(n):
            lack = 0.0
            for k in range(n):
                at = i * n + k
                lack += self.rhs[k] * (
                    self.net.mass[at]
                    + h / 2.0 * self.damping2[at]
                    + h * h / 6.0 * self.stiffness2[at]
                )
            largest = max(largest, fabs(lack) / self.net.mass[i * n + i])
        return largest

    def _largest_acceleration(self, reach):
        """Return the largest acceleration by all forces in magnitude, with springs at `reach`."""
        n = self.n
        largest = 1e-30
        for i in range(n):
            force = 0.0
            for m in range(self.net.loads):
                p = self.net.road[4 * self.net.load_signal[m]]
                force += fabs(self.net.load_direction[m * n + i] * p)
            for r in range(self.net.rows):
                force += fabs(self.net.row_direction[r * n + i] * self.net.row_f[r])
            for k in range(n):
                force += fabs(self.stiffness2[i * n + k] * (fabs(self.cq[k]) + reach))
            largest = max(largest, fabs(self.ca[i]), force / self.net.mass[i * n + i])
        return largest

    def _solve_step_matrix(self, h):
        """Solve (M + h/2 B + h^2/6 K) x = rhs with the matrices `stiffness2`, `damping2`."""
        size = self.n * self.n
        for i in range(size):
            self.factor[i] = (
                self.net.mass[i] + h / 2.0 * self.damping2[i] + h * h / 6.0 * self.stiffness2[i]
            )
        if decompose(self.factor, 0, self.n) != 0:
            return 1
        solve(self.factor, 0, self.n, self.rhs)
        return 0

    def add_increments(self, t, h, fraction):
        """Add the increments of (15.16) to (15.18), with tangents at the start or their mean (15.7)."""
        n = self.n
        for i in range(n):
            self.pq[i] = self.cq[i]
            self.pv[i] = self.cv[i]
            self.sa[i] = self.ca[i]
        self.net.all_signals(t)
        self.net.row_states(self.pq, self.pv)
        self.net.row_forces()
        self.net.assemble(self.stiffness, self.damping)
        for i in range(n * n):
            self.stiffness2[i] = self.stiffness[i]
            self.damping2[i] = self.damping[i]
        for r in range(self.net.rows):
            self.start_k[r] = self.mean_k[r] = self.net.row_k[r]
            self.start_c[r] = self.mean_c[r] = self.net.row_c[r]
        before = 1e300
        share = 1.0
        for iteration in range(200):
            self._excitation_increment(t, fraction)
            for i in range(n):
                for k in range(n):
                    self.rhs[i] -= h * self.damping2[i * n + k] * self.sa[k]
                    self.rhs[i] -= self.stiffness2[i * n + k] * (
                        h * self.pv[k] + h * h / 2.0 * self.sa[k]
                    )
            if self._solve_step_matrix(h) != 0:
                return _NOT_POSITIVE
            change = 0.0
            largest = 1e-30
            for i in range(n):
                if iteration > 0:
                    change = max(change, fabs(self.correction[i] - self.rhs[i]))
                largest = max(largest, fabs(self.rhs[i]) + fabs(self.sa[i]))
                self.cv[i] = self.pv[i] + h * self.sa[i] + h / 2.0 * self.rhs[i]
                self.cq[i] = (
                    self.pq[i] + h * self.pv[i] + h * h / 2.0 * self.sa[i]
                    + h * h / 6.0 * self.rhs[i]
                )  # fmt: skip
                self.ca[i] = self.sa[i] + self.rhs[i]
            if not isfinite(largest):
                return _DIVERGED
            if self.once:
                return 0
            if iteration > 0 and (
                change <= 1e-15 * largest or (change <= 1e-10 * largest and change >= 0.5 * before)
            ):
                return 0
            if iteration > 0:
                # the mean may oscillate between both sides of a damper's saturation
                share = max(0.5 * share, _LEAST_SHARE) if change > 0.9 * before else share
                before = change
            self.take_signals(fraction)
            self.net.row_states(self.cq, self.cv)
            self.net.row_forces()
            self.net.assemble(self.stiffness_end, self.damping_end)
            for i in range(n):
                self.correction[i] = self.ca[i] - self.sa[i]
            for i in range(n * n):
                mean = 0.5 * (self.stiffness[i] + self.stiffness_end[i])
                self.stiffness2[i] += share * (mean - self.stiffness2[i])
                mean = 0.5 * (self.damping[i] + self.damping_end[i])
                self.damping2[i] += share * (mean - self.damping2[i])
            for r in range(self.net.rows):
                mean = 0.5 * (self.start_k[r] + self.net.row_k[r])
                self.mean_k[r] += share * (mean - self.mean_k[r])
                mean = 0.5 * (self.start_c[r] + self.net.row_c[r])
                self.mean_c[r] += share * (mean - self.mean_c[r])
        return _NOT_CONVERGED

    def _excitation_increment(self, t, fraction):
        """Set `rhs` to Delta f of (15.6): loads, and roads through the same tangents as the motion."""
        n = self.n
        for i in range(n):
            self.rhs[i] = 0.0
        self.take_signals(fraction)
        for sign in range(2):
            factor = 1.0 if sign == 0 else -1.0
            if sign == 1:
                self.net.all_signals(t)
            for m in range(self.net.loads):
                p = factor * self.net.road[4 * self.net.load_signal[m]]
                for i in range(n):
                    self.rhs[i] += self.net.load_direction[m * n + i] * p
            for r in range(self.net.rows):
                s = self.net.row_signal[r]
                if s >= 0:
                    f = factor * (
                        self.mean_k[r] * self.net.road[4 * s]
                        + self.mean_c[r] * self.net.road[4 * s + 1]
                    )
                    for i in range(n):
                        self.rhs[i] += self.net.row_direction[r * n + i] * f
