"""Steps by increments with curved forces, as in H83 chapter 15.

The increments of (15.16) to (15.18), with tangents at the start of the step, or with their mean over it
(15.7), which is iterated.
"""

from __future__ import annotations

import cython

if not cython.compiled:
    from math import fabs, isfinite

    from .linear import decompose, solve

_DIVERGED, _NOT_CONVERGED, _NOT_POSITIVE = 2, 4, 5  # keys of integrator.FAILURES

_LEAST_SHARE = 1e-3  # of a correction


class Increments:
    """Steps that overwrite displacements, velocities and accelerations.

    Parameters
    ----------
    network : of the system
    once : whether to use the tangents at the start only
    """

    def __init__(self, network, once):
        self.net, self.n, self.once = network, network.n, once
        memory, n, size = self.net.memory, self.n, self.n * self.n
        self.stiffness, self.damping = memory.zeros(size), memory.zeros(size)
        self.stiffness2, self.damping2 = memory.zeros(size), memory.zeros(size)
        self.stiffness_end, self.damping_end = memory.zeros(size), memory.zeros(size)
        self.factor = memory.zeros(size)
        self.pq, self.pv, self.sa = memory.zeros(n), memory.zeros(n), memory.zeros(n)
        self.rhs, self.correction = memory.zeros(n), memory.zeros(n)
        self.change = memory.zeros(n)  # of `rhs` in the last iteration
        # tangents of the rows at the start of a step, and those used for it
        rows = self.net.rows
        self.start_k, self.start_c = memory.zeros(rows), memory.zeros(rows)
        self.mean_k, self.mean_c = memory.zeros(rows), memory.zeros(rows)

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

    def add(self, t, h, q, v, a):
        """Step from t to t + h; return 0 or a key of `FAILURES`."""
        n = self.n
        for i in range(n):
            self.pq[i], self.pv[i], self.sa[i] = q[i], v[i], a[i]
        self.net.all_signals(t)
        self.net.row_states(self.pq, self.pv)
        self.net.row_forces()
        self.net.assemble(self.net.row_k, self.net.row_c, self.stiffness, self.damping)
        for i in range(n * n):
            self.stiffness2[i] = self.stiffness[i]
            self.damping2[i] = self.damping[i]
        for r in range(self.net.rows):
            self.start_k[r] = self.mean_k[r] = self.net.row_k[r]
            self.start_c[r] = self.mean_c[r] = self.net.row_c[r]
        before = 1e300
        share = 1.0
        for iteration in range(200):
            self._excitation_increment(t, h)
            for i in range(n):
                for k in range(n):
                    self.rhs[i] -= h * self.damping2[i * n + k] * self.sa[k]
                    self.rhs[i] -= self.stiffness2[i * n + k] * (
                        h * self.pv[k] + h * h / 2.0 * self.sa[k]
                    )
            if self._solve_step_matrix(h) != 0:
                return _NOT_POSITIVE
            change = turn = 0.0
            largest = 1e-30
            for i in range(n):
                if iteration > 0:
                    difference = self.rhs[i] - self.correction[i]
                    turn += self.change[i] * difference if iteration > 1 else 0.0
                    self.change[i] = difference
                    change = max(change, fabs(difference))
                largest = max(largest, fabs(self.rhs[i]) + fabs(self.sa[i]))
                v[i] = self.pv[i] + h * self.sa[i] + h / 2.0 * self.rhs[i]
                q[i] = (
                    self.pq[i] + h * self.pv[i] + h * h / 2.0 * self.sa[i]
                    + h * h / 6.0 * self.rhs[i]
                )  # fmt: skip
                a[i] = self.sa[i] + self.rhs[i]
            if not isfinite(largest):
                return _DIVERGED
            if self.once:
                return 0
            if iteration > 0 and (
                change <= 1e-15 * largest or (change <= 1e-10 * largest and change >= 0.5 * before)
            ):
                return 0
            if iteration > 0:
                # the mean may oscillate between both sides of a damper's saturation; where changes
                # go on in one direction, a smaller share would only stop short of the equilibrium
                if change > 0.9 * before and turn < 0.0:
                    share = max(0.5 * share, _LEAST_SHARE)
                before = change
            self.net.all_signals(t + h)
            self.net.row_states(q, v)
            self.net.row_forces()
            self.net.assemble(self.net.row_k, self.net.row_c, self.stiffness_end, self.damping_end)
            for i in range(n):
                self.correction[i] = a[i] - self.sa[i]
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

    def _excitation_increment(self, t, h):
        """Set `rhs` to Delta f of (15.6): loads, and roads through the same tangents as the motion."""
        n = self.n
        for i in range(n):
            self.rhs[i] = 0.0
        for sign in range(2):
            factor = 1.0 if sign == 0 else -1.0
            self.net.all_signals(t + h if sign == 0 else t)
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
