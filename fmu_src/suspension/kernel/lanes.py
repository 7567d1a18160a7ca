"""The macro step in a linear branch: all sequences of substeps side by side.

Within a branch whose elements are all straight, the step of the incremental method (see `stepper`)
is a product with a matrix that is kept while branch and step stay,

    a1 = (M + s/2 B + s^2/6 K)^-1 (p1 - B v* - K q*),

and the columns of the extrapolation do not depend on each other. Two at a time are carried on in
lockstep, each in a lane of its own, so that the processor's vector instructions take both at once.
The shorter column of a pair goes on with the other when it has arrived, for nothing.
"""

from __future__ import annotations

import cython

from .arrays import integers

if not cython.compiled:
    from math import isfinite

_LANES = 4  # two for each pair
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
    masses : their matrix and its inverse by rows, kg, of which `enter_mass` takes what stands there
    sequence : substeps in each column of the extrapolation, one to four of them, ascending
    fraction_index : place of each substep's instant in `loads`, 5 for each column
    loads : forces of roads and loads at those instants, one for each coordinate, N; the last are
        those at the end of the step
    load_rate : their rates at the end, N/s
    tangents : K and B by rows, of which `enter` takes what stands there
    start : displacements, velocities, accelerations and jerks that steps begin with
    end : where displacements, velocities, accelerations and jerks at their end go
    """

    def __init__(self, masses, sequence, fraction_index, loads, load_rate, tangents, start, end):
        self.n = n = len(load_rate)
        self.columns = len(sequence)
        self.pairs = (self.columns + 1) // 2
        # a lane without a column of its own repeats the last
        substeps = [*sequence, *[max(sequence)] * (_LANES - len(sequence))]
        self.substeps = integers(substeps)
        self.load_at = integers(
            n
            * fraction_index[_SUBSTEPS * min(lane, len(sequence) - 1) + min(k, substeps[lane] - 1)]
            for k in range(_SUBSTEPS)
            for lane in range(_LANES)
        )
        self.loads, self.load_rate, self.last = loads, load_rate, len(loads) - n
        self.given_mass, self.given_flexibility = masses
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
        self.s, self.half, self.third, self.sixth = [0.0] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4
        self.pivot = [0.0] * 2
        self.inverse = [0.0] * 256
        self.q, self.v, self.a = [0.0] * 16, [0.0] * 16, [0.0] * 16
        self.pq, self.pv, self.f = [0.0] * 16, [0.0] * 16, [0.0] * 16
        self.at_q, self.at_v, self.at_a, self.at_j = [0.0] * 8, [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.end_q, self.end_v = [0.0] * 32, [0.0] * 32
        self.error_q, self.error_v = [0.0] * 8, [0.0] * 8
        self.step = -1.0
        self.enter_mass()

    def enter_mass(self):
        """Take over the mass matrix and its inverse."""
        for i in range(self.n * self.n):
            self.mass[i], self.flexibility[i] = self.given_mass[i], self.given_flexibility[i]
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
        for pair in range(self.pairs):
            if h != self.step and self._invert(h, n, pair) != 0:
                return _NOT_POSITIVE
            self._advance(n, pair)
        self.step = h
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
        if h == self.step:
            return 0
        for pair in range(self.pairs):
            if self._invert(h, self.n, pair) != 0:
                return 1
        self.step = h
        return 0

    def _invert(self, h, n, pair):
        """(M + s/2 B + s^2/6 K)^-1 of both lanes of a pair, by Gauss and Jordan."""
        self.step = -1.0
        at = 2 * pair
        for lane in range(2):
            s = h / self.substeps[at + lane]
            self.s[at + lane] = s
            self.half[at + lane] = 0.5 * s
            self.third[at + lane] = s * s / 3.0
            self.sixth[at + lane] = s * s / 6.0
        first = 128 * pair
        for i in range(n * n):
            for lane in range(2):
                self.inverse[first + 2 * i + lane] = (
                    self.mass[i]
                    + self.half[at + lane] * self.damping[i]
                    + self.sixth[at + lane] * self.stiffness[i]
                )
        for k in range(n):
            kk = first + 2 * (n * k + k)
            for lane in range(2):
                if not self.inverse[kk + lane] > 0.0:
                    return 1
            for lane in range(2):
                self.pivot[lane] = 1.0 / self.inverse[kk + lane]
                self.inverse[kk + lane] = 1.0
            for j in range(n):
                kj = first + 2 * (n * k + j)
                for lane in range(2):
                    self.inverse[kj + lane] *= self.pivot[lane]
            for i in range(n):
                if i != k:
                    ik = first + 2 * (n * i + k)
                    for lane in range(2):
                        self.pivot[lane] = self.inverse[ik + lane]
                        self.inverse[ik + lane] = 0.0
                    for j in range(n):
                        ij = first + 2 * (n * i + j)
                        kj = first + 2 * (n * k + j)
                        for lane in range(2):
                            self.inverse[ij + lane] -= self.pivot[lane] * self.inverse[kj + lane]
        return 0

    def _advance(self, n, pair):
        """The columns of a pair over the whole macro step.

        (15.12), (15.13) with the end-of-step equilibrium, which is linear.
        """
        first = 2 * pair
        for i in range(n):
            for lane in range(2):
                self.q[2 * i + lane] = self.q0[i]
                self.v[2 * i + lane] = self.v0[i]
                self.a[2 * i + lane] = self.a0[i]
        for k in range(self.substeps[first + 1]):
            for i in range(n):
                for lane in range(2):
                    at = 2 * i + lane
                    self.pv[at] = self.v[at] + self.half[first + lane] * self.a[at]
                    self.pq[at] = (
                        self.q[at]
                        + self.s[first + lane] * self.v[at]
                        + self.third[first + lane] * self.a[at]
                    )
            for i in range(n):
                for lane in range(2):
                    f = self.loads[self.load_at[_LANES * k + first + lane] + i]
                    for j in range(n):
                        f -= self.damping[n * i + j] * self.pv[2 * j + lane]
                        f -= self.stiffness[n * i + j] * self.pq[2 * j + lane]
                    self.f[2 * i + lane] = f
            for i in range(n):
                for lane in range(2):
                    f = 0.0
                    for j in range(n):
                        at = 128 * pair + 2 * (n * i + j) + lane
                        f += self.inverse[at] * self.f[2 * j + lane]
                    self.a[2 * i + lane] = f
            for i in range(n):
                for lane in range(2):
                    at = 2 * i + lane
                    self.v[at] = self.pv[at] + self.half[first + lane] * self.a[at]
                    self.q[at] = self.pq[at] + self.sixth[first + lane] * self.a[at]
            for lane in range(2):
                if k + 1 == self.substeps[first + lane]:
                    for i in range(n):
                        self.end_q[_LANES * i + first + lane] = self.q[2 * i + lane]
                        self.end_v[_LANES * i + first + lane] = self.v[2 * i + lane]

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
                x -= (
                    self.damping[n * i + j] * self.at_v[j]
                    + self.stiffness[n * i + j] * self.at_q[j]
                )
            self.f[i] = x
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += self.flexibility[n * i + j] * self.f[j]
            self.at_a[i] = x
        for i in range(n):
            x = self.load_rate[i]
            for j in range(n):
                x -= (
                    self.damping[n * i + j] * self.at_a[j]
                    + self.stiffness[n * i + j] * self.at_v[j]
                )
            self.f[i] = x
        for i in range(n):
            x = 0.0
            for j in range(n):
                x += self.flexibility[n * i + j] * self.f[j]
            self.at_j[i] = x
