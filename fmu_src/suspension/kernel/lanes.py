"""The macro step in a linear branch: all sequences of substeps side by side, in pairs.

Within a branch whose elements are all straight, the step of the incremental method (see `stepper`)
is a product with a matrix that is kept while branch and step stay,

    a1 = (M + s/2 B + s^2/6 K)^-1 (p1 - B v* - K q*),

and the columns of the extrapolation do not depend on each other. Two at a time are carried on in
lockstep, so that one need not wait for the other's multiplications.
"""

from __future__ import annotations

import cython

from .arrays import integers

if not cython.compiled:
    from math import isfinite

_MOST = 8  # coordinates; larger systems go one column after the other
_LANES = 4
_SUBSTEPS = 5  # of the longest sequence
_DIVERGED, _NOT_POSITIVE = 2, 5  # keys of integrator.FAILURES


def extrapolation_weights(sequence):
    """w with sum w = 1 and sum w / n^(2k) = 0: of the macro steps made with n substeps each."""
    weights = []
    for n in sequence:
        w = 1.0
        for m in sequence:
            if m != n:
                w *= n * n / (n * n - m * m)
        weights.append(w)
    return weights


class Lanes:
    """The numbers of one linear branch, and macro steps in it.

    Parameters
    ----------
    mass : matrix by rows, kg
    sequence : substeps in each column of the extrapolation, one to four of them, ascending
    fraction_index : place of each substep's instant in `loads`, 5 for each column
    loads : forces of roads and loads at those instants, one for each coordinate, N; the last are
        those at the end of the step
    load_rate : their rates at the end, N/s
    tangents : K and B by rows, of which `enter` takes what stands there
    start : displacements, velocities, accelerations and jerks that steps begin with
    end : where displacements, velocities, accelerations and jerks at their end go
    """

    def __init__(self, mass, sequence, fraction_index, loads, load_rate, tangents, start, end):
        self.n = n = len(load_rate)
        self.columns = len(sequence)
        # a lane without a column of its own repeats the last
        substeps = [*sequence, *[max(sequence)] * (_LANES - len(sequence))]
        self.substeps = integers(substeps)
        self.load_at = integers(
            n
            * fraction_index[_SUBSTEPS * min(lane, len(sequence) - 1) + min(k, substeps[lane] - 1)]
            for lane in range(_LANES)
            for k in range(_SUBSTEPS)
        )
        self.loads, self.load_rate, self.last = loads, load_rate, len(loads) - n
        self.given_stiffness, self.given_damping = tangents
        self.q0, self.v0, self.a0, self.j0 = start
        self.q1, self.v1, self.a1, self.j1 = end
        # sizes are literals, for they are those of C arrays
        self.weight, self.check = [0.0] * 4, [0.0] * 4
        weights = extrapolation_weights(sequence)
        lower = [0.0, *extrapolation_weights(sequence[1:])]
        for i in range(len(sequence)):
            self.weight[i] = weights[i]
            self.check[i] = weights[i] - lower[i]
        self.stiffness, self.damping = [0.0] * 64, [0.0] * 64
        self.mass, self.flexibility = [0.0] * 64, [0.0] * 64
        self.inverse = [0.0] * 256
        self.q, self.v, self.a = [0.0] * 16, [0.0] * 16, [0.0] * 16
        self.pq, self.pv, self.f = [0.0] * 16, [0.0] * 16, [0.0] * 16
        self.at_q, self.at_v, self.at_a, self.at_j = [0.0] * 8, [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.end_q, self.end_v = [0.0] * 32, [0.0] * 32
        self.error_q, self.error_v = [0.0] * 8, [0.0] * 8
        self.step = -1.0
        self.enter_mass(mass)

    def enter_mass(self, mass):
        """Take over a mass matrix, by rows, and find its inverse."""
        for i in range(self.n * self.n):
            self.mass[i] = mass[i]
            self.stiffness[i] = self.damping[i] = 0.0
        self._invert_pair(0, 0.0, 0.0, self.n)
        for i in range(self.n * self.n):
            self.flexibility[i] = self.inverse[2 * i]  # M^-1
        self.step = -1.0

    def enter(self):
        """Take over the tangents of a branch, and find acceleration and jerk where it begins.

        Nothing moves in `loads` but what stands at the end of a step: there its start is, too.
        """
        n = self.n
        for i in range(n * n):
            self.stiffness[i] = self.given_stiffness[i]
            self.damping[i] = self.given_damping[i]
        self.step = -1.0
        for i in range(n):
            self.at_q[i], self.at_v[i] = self.q0[i], self.v0[i]
        self._solve_motion(n)
        for i in range(n):
            self.a0[i], self.j0[i] = self.at_a[i], self.at_j[i]

    def attempt(self, h):
        """One macro step h: the state at its end, and by how much the last two columns differ.

        Returns
        -------
        0, or the key of `integrator.FAILURES` that says why it could not be made.
        """
        # with a number in place of n the compiler writes the loops out
        if self.n == 2:
            return self._attempt(h, 2)
        if self.n == 1:
            return self._attempt(h, 1)
        if self.n == 4:
            return self._attempt(h, 4)
        return self._attempt(h, self.n)

    def _attempt(self, h, n):
        if self._invert(h, n) != 0:
            return _NOT_POSITIVE
        for pair in range(2):
            if 2 * pair < self.columns:
                self._advance_pair(
                    pair, h / self.substeps[2 * pair], h / self.substeps[2 * pair + 1], n
                )
        if self._extrapolate(n) != 0:
            return _DIVERGED
        self._finish(n)
        return 0

    def finish(self):
        """Acceleration and jerk at the end, by the equation of motion and its derivative."""
        if self.n == 2:
            self._finish(2)
        elif self.n == 4:
            self._finish(4)
        else:
            self._finish(self.n)

    def invert(self, h):
        """Find the matrices of all columns for macro steps h; 1 if one is not positive definite."""
        return self._invert(h, self.n)

    def _invert(self, h, n):
        if h == self.step:
            return 0
        self.step = -1.0
        for pair in range(2):
            if 2 * pair < self.columns:
                s0 = h / self.substeps[2 * pair]
                s1 = h / self.substeps[2 * pair + 1]
                if self._invert_pair(pair, s0, s1, n) != 0:
                    return 1
        self.step = h
        return 0

    def _invert_pair(self, pair, s0, s1, n):
        """(M + s/2 B + s^2/6 K)^-1 of two lanes, by Gauss and Jordan; 1 if not positive definite."""
        at = 2 * pair * _MOST * _MOST
        for i in range(n * n):
            self.inverse[at + 2 * i] = (
                self.mass[i] + s0 / 2.0 * self.damping[i] + s0 * s0 / 6.0 * self.stiffness[i]
            )
            self.inverse[at + 2 * i + 1] = (
                self.mass[i] + s1 / 2.0 * self.damping[i] + s1 * s1 / 6.0 * self.stiffness[i]
            )
        for k in range(n):
            kk = at + 2 * (n * k + k)
            if not (self.inverse[kk] > 0.0 and self.inverse[kk + 1] > 0.0):
                return 1
            x0 = 1.0 / self.inverse[kk]
            x1 = 1.0 / self.inverse[kk + 1]
            self.inverse[kk] = 1.0
            self.inverse[kk + 1] = 1.0
            for j in range(n):
                kj = at + 2 * (n * k + j)
                self.inverse[kj] *= x0
                self.inverse[kj + 1] *= x1
            for i in range(n):
                if i != k:
                    ik = at + 2 * (n * i + k)
                    x0 = self.inverse[ik]
                    x1 = self.inverse[ik + 1]
                    self.inverse[ik] = 0.0
                    self.inverse[ik + 1] = 0.0
                    for j in range(n):
                        ij = at + 2 * (n * i + j)
                        kj = at + 2 * (n * k + j)
                        self.inverse[ij] -= x0 * self.inverse[kj]
                        self.inverse[ij + 1] -= x1 * self.inverse[kj + 1]
        return 0

    def _advance_pair(self, pair, s0, s1, n):
        """Both columns of a pair over the whole macro step; the shorter one stops on its way.

        (15.12), (15.13) with the end-of-step equilibrium, which is linear.
        """
        at = 2 * pair * _MOST * _MOST
        lane = 2 * pair
        third0 = s0 * s0 / 3.0
        third1 = s1 * s1 / 3.0
        for i in range(n):
            self.q[2 * i] = self.q[2 * i + 1] = self.q0[i]
            self.v[2 * i] = self.v[2 * i + 1] = self.v0[i]
            self.a[2 * i] = self.a[2 * i + 1] = self.a0[i]
        for k in range(self.substeps[lane + 1]):
            load0 = self.load_at[_SUBSTEPS * lane + k]
            load1 = self.load_at[_SUBSTEPS * lane + _SUBSTEPS + k]
            for i in range(0, 2 * n, 2):
                self.pv[i] = self.v[i] + 0.5 * s0 * self.a[i]
                self.pv[i + 1] = self.v[i + 1] + 0.5 * s1 * self.a[i + 1]
                self.pq[i] = self.q[i] + s0 * self.v[i] + third0 * self.a[i]
                self.pq[i + 1] = self.q[i + 1] + s1 * self.v[i + 1] + third1 * self.a[i + 1]
            for i in range(n):
                x0 = self.loads[load0 + i]
                x1 = self.loads[load1 + i]
                for j in range(n):
                    x0 -= self.damping[n * i + j] * self.pv[2 * j]
                    x1 -= self.damping[n * i + j] * self.pv[2 * j + 1]
                for j in range(n):
                    x0 -= self.stiffness[n * i + j] * self.pq[2 * j]
                    x1 -= self.stiffness[n * i + j] * self.pq[2 * j + 1]
                self.f[2 * i] = x0
                self.f[2 * i + 1] = x1
            for i in range(n):
                x0 = 0.0
                x1 = 0.0
                for j in range(n):
                    x0 += self.inverse[at + 2 * (n * i + j)] * self.f[2 * j]
                    x1 += self.inverse[at + 2 * (n * i + j) + 1] * self.f[2 * j + 1]
                self.a[2 * i] = x0
                self.a[2 * i + 1] = x1
            for i in range(0, 2 * n, 2):
                self.v[i] = self.pv[i] + 0.5 * s0 * self.a[i]
                self.v[i + 1] = self.pv[i + 1] + 0.5 * s1 * self.a[i + 1]
                self.q[i] = self.pq[i] + 0.5 * third0 * self.a[i]
                self.q[i + 1] = self.pq[i + 1] + 0.5 * third1 * self.a[i + 1]
            if k + 1 == self.substeps[lane]:
                for i in range(n):
                    self.end_q[_LANES * i + lane] = self.q[2 * i]
                    self.end_v[_LANES * i + lane] = self.v[2 * i]
        for i in range(n):
            self.end_q[_LANES * i + lane + 1] = self.q[2 * i + 1]
            self.end_v[_LANES * i + lane + 1] = self.v[2 * i + 1]

    def _extrapolate(self, n):
        """Ends of the macro step, each as that of the last column and small corrections to it."""
        for i in range(n):
            at = _LANES * i
            q = self.end_q[at + self.columns - 1]
            v = self.end_v[at + self.columns - 1]
            dq = 0.0
            dv = 0.0
            eq = 0.0
            ev = 0.0
            for lane in range(self.columns - 1):
                x = self.end_q[at + lane] - q
                dq += self.weight[lane] * x
                eq += self.check[lane] * x
                x = self.end_v[at + lane] - v
                dv += self.weight[lane] * x
                ev += self.check[lane] * x
            self.q1[i] = q + dq
            self.v1[i] = v + dv
            if not (isfinite(self.q1[i]) and isfinite(self.v1[i])):
                return 1
            self.error_q[i] = eq
            self.error_v[i] = ev
        return 0

    def _finish(self, n):
        for i in range(n):
            self.at_q[i], self.at_v[i] = self.q1[i], self.v1[i]
        self._solve_motion(n)
        for i in range(n):
            self.a1[i], self.j1[i] = self.at_a[i], self.at_j[i]

    def _solve_motion(self, n):
        """Acceleration and jerk at the state `at_q`, `at_v`, with the last of the loads."""
        for i in range(n):
            x = self.loads[self.last + i]
            for j in range(n):
                x -= self.damping[n * i + j] * self.at_v[j] + self.stiffness[n * i + j] * self.at_q[j]
            self.f[i] = x
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += self.flexibility[n * i + j] * self.f[j]
            self.at_a[i] = x
        for i in range(n):
            x = self.load_rate[i]
            for j in range(n):
                x -= self.damping[n * i + j] * self.at_a[j] + self.stiffness[n * i + j] * self.at_v[j]
            self.f[i] = x
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += self.flexibility[n * i + j] * self.f[j]
            self.at_j[i] = x
