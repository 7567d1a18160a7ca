"""The macro step in a linear branch: all sequences of substeps side by side.

Within a branch whose elements are all straight, the step of the incremental method (see `stepper`)
is a product with a matrix that is kept while branch and step stay,

    a1 = (M + s/2 B + s^2/6 K)^-1 (p1 - B v* - K q*),

and the columns of the extrapolation do not depend on each other. They are carried on in lockstep,
each in a lane of its own, so that the processor's vector instructions take two of them at once. A
column that has arrived goes on with the others, for nothing.
"""

from __future__ import annotations

import cython

from .arrays import integers

if not cython.compiled:
    from math import isfinite

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
        self.width = 2 if self.columns <= 2 else 4
        # a lane without a column of its own repeats the last
        substeps = [*sequence, *[max(sequence)] * (_LANES - len(sequence))]
        self.substeps = integers(substeps)
        self.longest = max(sequence)
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
        self.pivot = [0.0] * 4
        self.inverse = [0.0] * 256
        self.q, self.v, self.a = [0.0] * 32, [0.0] * 32, [0.0] * 32
        self.pq, self.pv, self.f = [0.0] * 32, [0.0] * 32, [0.0] * 32
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
        return self._attempt_narrow(h) if self.width == 2 else self._attempt_wide(h)

    # with numbers in place of n and the width the compiler writes the loops out
    def _attempt_narrow(self, h):
        if self.n == 2:
            return self._attempt(h, 2, 2)
        if self.n == 1:
            return self._attempt(h, 1, 2)
        if self.n == 4:
            return self._attempt(h, 4, 2)
        return self._attempt(h, self.n, 2)

    def _attempt_wide(self, h):
        if self.n == 2:
            return self._attempt(h, 2, 4)
        if self.n == 1:
            return self._attempt(h, 1, 4)
        if self.n == 4:
            return self._attempt(h, 4, 4)
        return self._attempt(h, self.n, 4)

    def _attempt(self, h, n, width):
        if h != self.step and self._invert(h, n, width) != 0:
            return _NOT_POSITIVE
        self._advance(n, width)
        if self._extrapolate(n, width) != 0:
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
        return 0 if h == self.step else self._invert(h, self.n, self.width)

    def _invert(self, h, n, width):
        """(M + s/2 B + s^2/6 K)^-1 of every lane, by Gauss and Jordan."""
        self.step = -1.0
        for lane in range(width):
            s = h / self.substeps[lane]
            self.s[lane] = s
            self.half[lane] = 0.5 * s
            self.third[lane] = s * s / 3.0
            self.sixth[lane] = s * s / 6.0
        for i in range(n * n):
            for lane in range(width):
                self.inverse[width * i + lane] = (
                    self.mass[i]
                    + self.half[lane] * self.damping[i]
                    + self.sixth[lane] * self.stiffness[i]
                )
        for k in range(n):
            kk = width * (n * k + k)
            for lane in range(width):
                if not self.inverse[kk + lane] > 0.0:
                    return 1
            for lane in range(width):
                self.pivot[lane] = 1.0 / self.inverse[kk + lane]
                self.inverse[kk + lane] = 1.0
            for j in range(n):
                kj = width * (n * k + j)
                for lane in range(width):
                    self.inverse[kj + lane] *= self.pivot[lane]
            for i in range(n):
                if i != k:
                    ik = width * (n * i + k)
                    for lane in range(width):
                        self.pivot[lane] = self.inverse[ik + lane]
                        self.inverse[ik + lane] = 0.0
                    for j in range(n):
                        ij = width * (n * i + j)
                        kj = width * (n * k + j)
                        for lane in range(width):
                            self.inverse[ij + lane] -= self.pivot[lane] * self.inverse[kj + lane]
        self.step = h
        return 0

    def _advance(self, n, width):
        """All columns over the whole macro step.

        (15.12), (15.13) with the end-of-step equilibrium, which is linear.
        """
        for i in range(n):
            for lane in range(width):
                self.q[width * i + lane] = self.q0[i]
                self.v[width * i + lane] = self.v0[i]
                self.a[width * i + lane] = self.a0[i]
        for k in range(self.longest):
            for i in range(n):
                for lane in range(width):
                    at = width * i + lane
                    self.pv[at] = self.v[at] + self.half[lane] * self.a[at]
                    self.pq[at] = (
                        self.q[at] + self.s[lane] * self.v[at] + self.third[lane] * self.a[at]
                    )
            for i in range(n):
                for lane in range(width):
                    self.f[width * i + lane] = self.loads[self.load_at[_LANES * k + lane] + i]
                for j in range(n):
                    x = self.damping[n * i + j]
                    y = self.stiffness[n * i + j]
                    for lane in range(width):
                        self.f[width * i + lane] -= x * self.pv[width * j + lane]
                    for lane in range(width):
                        self.f[width * i + lane] -= y * self.pq[width * j + lane]
            for i in range(n):
                for lane in range(width):
                    self.a[width * i + lane] = 0.0
                for j in range(n):
                    at = width * (n * i + j)
                    for lane in range(width):
                        self.a[width * i + lane] += (
                            self.inverse[at + lane] * self.f[width * j + lane]
                        )
            for i in range(n):
                for lane in range(width):
                    at = width * i + lane
                    self.v[at] = self.pv[at] + self.half[lane] * self.a[at]
                    self.q[at] = self.pq[at] + self.sixth[lane] * self.a[at]
            for lane in range(self.columns):
                if k + 1 == self.substeps[lane]:
                    for i in range(n):
                        self.end_q[width * i + lane] = self.q[width * i + lane]
                        self.end_v[width * i + lane] = self.v[width * i + lane]

    def _extrapolate(self, n, width):
        """Ends of the macro step, each as that of the last column and small corrections to it."""
        for i in range(n):
            at = width * i
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
