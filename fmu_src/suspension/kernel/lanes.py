"""The macro step in a linear branch: all columns of the extrapolation side by side.

Within a linear branch, the step of the incremental method (see `stepper`) is a product with a matrix
that is stored as long as branch and step stay the same,

    a1 = (M + s/2 B + s^2/6 K)^-1 (p1 - B v* - K q*),

and the columns of the extrapolation are independent: one substep of each column is taken in turn, so
that the processor can overlap them. All matrices are symmetric and are read by columns, which suits
vector instructions.
"""

from __future__ import annotations

import cython

from .arrays import integers

if not cython.compiled:
    from math import isfinite

_SUBSTEPS = 5  # in the longest sequence
_LANE = 8  # coordinates that each column has room for
_DIVERGED, _NOT_POSITIVE = 2, 5  # keys of integrator.FAILURES


def extrapolation_weights(sequence):
    """Return the weights w of macro steps with n substeps: sum w = 1, sum w / n^(2k) = 0."""
    weights = []
    for n in sequence:
        w = 1.0
        for m in sequence:
            if m != n:
                w *= n * n / (n * n - m * m)
        weights.append(w)
    return weights


def multiply(m, at, x, first, n, out, to):
    """Set out[to:] = m x[first:]; the symmetric matrix starts at `at`."""
    for i in range(n):
        out[to + i] = m[at + i] * x[first]
    for j in range(1, n):
        for i in range(n):
            out[to + i] += m[at + n * j + i] * x[first + j]


class Lanes:
    """Macro steps in one linear branch.

    Parameters
    ----------
    masses : mass matrix and its inverse by rows, kg, copied by `enter_mass`
    sequence : substeps in each column of the extrapolation, one to four columns, ascending
    fraction_index : index in `loads` of the time of each substep, 5 for each column
    loads : forces of roads and loads at those times, one for each coordinate, N; the last are those
        at the end of the step
    load_rate : their rates at the end, N/s
    tangents : K and B by rows, copied by `enter`
    start : displacements, velocities, accelerations and jerks at the start of a step
    end : arrays for displacements, velocities, accelerations and jerks at its end
    """

    def __init__(self, masses, sequence, fraction_index, loads, load_rate, tangents, start, end):
        self.n = n = len(load_rate)
        self.columns = len(sequence)
        self.substeps = integers(sequence)
        self.load_at = integers(n * k for k in fraction_index)
        self.loads, self.load_rate, self.last = loads, load_rate, len(loads) - n
        self.given_mass, self.given_flexibility = masses
        self.given_stiffness, self.given_damping = tangents
        self.q0, self.v0, self.a0, self.j0 = start
        self.q1, self.v1, self.a1, self.j1 = end
        # literal sizes, as these are C arrays
        self.weight, self.check = [0.0] * 4, [0.0] * 4
        weights = extrapolation_weights(sequence)
        lower = [0.0, *extrapolation_weights(sequence[1:])]
        for i in range(len(sequence)):
            self.weight[i] = weights[i]
            self.check[i] = weights[i] - lower[i]
        self.stiffness, self.damping = [0.0] * 64, [0.0] * 64
        self.mass, self.flexibility = [0.0] * 64, [0.0] * 64
        self.s, self.half, self.third, self.sixth = [0.0] * 4, [0.0] * 4, [0.0] * 4, [0.0] * 4
        self.inverse = [0.0] * 256
        self.q, self.v, self.a = [0.0] * 32, [0.0] * 32, [0.0] * 32
        self.fk, self.fb, self.f = [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.at_q, self.at_v, self.at_a, self.at_j = [0.0] * 8, [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.error_q, self.error_v = [0.0] * 8, [0.0] * 8
        self.step = -1.0
        self.enter_mass()

    def enter_mass(self):
        """Copy the mass matrix and its inverse."""
        for i in range(self.n * self.n):
            self.mass[i], self.flexibility[i] = self.given_mass[i], self.given_flexibility[i]
        self.step = -1.0

    def enter(self):
        """Copy the tangents of a branch, and find acceleration and jerk at its start.

        The loads at its start are taken from the last entry of `loads`, that of the end of a step.
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
        """Take a macro step h: find the state at its end and the difference of the last two columns.

        Returns
        -------
        0, or the key in `integrator.FAILURES` of the reason why it failed.
        """
        # with a constant in place of n the compiler unrolls the loops
        if self.n == 2:
            return self._attempt(h, 2)
        if self.n == 1:
            return self._attempt(h, 1)
        if self.n == 4:
            return self._attempt(h, 4)
        return self._attempt(h, self.n)

    def _attempt(self, h, n):
        if h != self.step and self._invert(h, n) != 0:
            return _NOT_POSITIVE
        self._advance(n)
        if self._extrapolate(n) != 0:
            return _DIVERGED
        self._finish(n)
        return 0

    def finish(self):
        """Find acceleration and jerk at the end, by the equation of motion and its derivative."""
        if self.n == 2:
            self._finish(2)
        elif self.n == 4:
            self._finish(4)
        else:
            self._finish(self.n)

    def invert(self, h):
        """Find the matrices of all columns for macro steps h; 1 if one is not positive definite."""
        return h != self.step and self._invert(h, self.n) != 0

    def _invert(self, h, n):
        """Find (M + s/2 B + s^2/6 K)^-1 for the substeps s of all columns, by Gauss and Jordan."""
        self.step = -1.0
        for c in range(self.columns):
            s = h / self.substeps[c]
            self.s[c] = s
            self.half[c] = half = 0.5 * s
            self.third[c] = s * s / 3.0
            self.sixth[c] = sixth = s * s / 6.0
            for i in range(n * n):
                self.inverse[64 * c + i] = (
                    self.mass[i] + half * self.damping[i] + sixth * self.stiffness[i]
                )
        for k in range(n):
            for c in range(self.columns):
                row = 64 * c + n * k
                if not self.inverse[row + k] > 0.0:
                    return 1
                pivot = 1.0 / self.inverse[row + k]
                self.inverse[row + k] = 1.0
                for j in range(n):
                    self.inverse[row + j] *= pivot
                for i in range(n):
                    if i != k:
                        at = 64 * c + n * i
                        pivot = self.inverse[at + k]
                        self.inverse[at + k] = 0.0
                        for j in range(n):
                            self.inverse[at + j] -= pivot * self.inverse[row + j]
        self.step = h
        return 0

    def _advance(self, n):
        """Step all columns over the whole macro step; the shorter ones finish first."""
        for c in range(self.columns):
            for i in range(n):
                self.q[_LANE * c + i] = self.q0[i]
                self.v[_LANE * c + i] = self.v0[i]
                self.a[_LANE * c + i] = self.a0[i]
        first = 0
        for k in range(self.substeps[self.columns - 1]):
            while k == self.substeps[first]:
                first += 1
            for c in range(first, self.columns):
                self._substep(n, c, self.load_at[_SUBSTEPS * c + k])

    def _substep(self, n, c, load):
        """Step by (15.12), (15.13) to the equilibrium at the end; the loads start at `load`."""
        at = _LANE * c
        for i in range(at, at + n):
            self.q[i] = self.q[i] + self.s[c] * self.v[i] + self.third[c] * self.a[i]
            self.v[i] += self.half[c] * self.a[i]
        multiply(self.damping, 0, self.v, at, n, self.fb, 0)
        multiply(self.stiffness, 0, self.q, at, n, self.fk, 0)
        for i in range(n):
            self.f[i] = self.loads[load + i] - (self.fb[i] + self.fk[i])
        multiply(self.inverse, 64 * c, self.f, 0, n, self.a, at)
        for i in range(at, at + n):
            self.v[i] += self.half[c] * self.a[i]
            self.q[i] += self.sixth[c] * self.a[i]

    def _extrapolate(self, n):
        """Find the end of the macro step: that of the last column plus small corrections."""
        last = _LANE * (self.columns - 1)
        for i in range(n):
            q = self.q[last + i]
            v = self.v[last + i]
            dq = 0.0
            dv = 0.0
            eq = 0.0
            ev = 0.0
            for c in range(self.columns - 1):
                x = self.q[_LANE * c + i] - q
                dq += self.weight[c] * x
                eq += self.check[c] * x
                x = self.v[_LANE * c + i] - v
                dv += self.weight[c] * x
                ev += self.check[c] * x
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
        """Find acceleration and jerk at the state `at_q`, `at_v`, with the last of the loads."""
        multiply(self.damping, 0, self.at_v, 0, n, self.fb, 0)
        multiply(self.stiffness, 0, self.at_q, 0, n, self.fk, 0)
        for i in range(n):
            self.f[i] = self.loads[self.last + i] - (self.fb[i] + self.fk[i])
        multiply(self.flexibility, 0, self.f, 0, n, self.at_a, 0)
        multiply(self.damping, 0, self.at_a, 0, n, self.fb, 0)
        multiply(self.stiffness, 0, self.at_v, 0, n, self.fk, 0)
        for i in range(n):
            self.f[i] = self.load_rate[i] - (self.fb[i] + self.fk[i])
        multiply(self.flexibility, 0, self.f, 0, n, self.at_j, 0)
