"""One macro step of the incremental method (H83 chapter 15) with all branches fixed.

Within a step h the acceleration is linear in time (15.9), so

    v1 = v0 + h/2 (a0 + a1),    q1 = q0 + h v0 + h^2/6 (2 a0 + a1)                  (15.12, 15.13)

and the equation of motion at the end of the step gives the end acceleration

    (M + h/2 B + h^2/6 K) a1 = p1 - B v* - K q*,

where v*, q* are (15.12), (15.13) without a1. The matrix is h^2/6 times that of (15.17); with the
increment of acceleration as the unknown, as H83 recommends, short steps lose no digits. This is
Newmark's method with gamma = 1/2, beta = 1/6: second order, symmetric, stable while
omega_max h < 2 sqrt 3.

As the method is symmetric, its error expands in h^2. A macro step of 1, 2, 3 and 5 equal substeps,
extrapolated (Aitken, Neville), therefore has order 8; the difference of the last two columns of the table
is the error of the last but one. In a linear branch the last column is better by the square of the phase
of the fast modes, once that is small, so that errors are proportional to the tolerance. An infinitely
damped mode is multiplied by -1 in each substep and by the sum of w (-1)^n in a macro step, where w are
the weights of the extrapolation: -0.59 here, but 6.2 if the last column had 4 substeps.
"""

from __future__ import annotations

import cython

from .arrays import doubles, integers, vectors
from .exact import Propagator
from .iteration import Iteration
from .lanes import Lanes

if not cython.compiled:
    from math import fabs, isfinite, sqrt

    from .linear import decompose, solve

_DIVERGED, _NOT_POSITIVE = 2, 5  # keys of integrator.FAILURES

_SHARE = 0.1  # share of the tolerance for one step, as the errors of many steps add up
# Phase per macro step, of the fastest mode, its decay and the road together, below which the last column
# is better than the one before by the square of the phase; a gain of at most `_MOST_BETTER` is assumed.
_SLOW_PHASE = 2.0
_MOST_BETTER = 10.0
_ROUNDING = 1e-13  # of displacements, below which errors cannot be resolved
_LEAST_LENGTH = 1e-290  # m, instead of none
_STIFF_PHASE = 100.0  # phase of the fastest motion beyond which jerks do not describe a step
_CAUTION = 4.0  # factor on errors with curved forces, where all columns may miss a knee
_MOST = 5  # substeps in one macro step
# Phase of a mode per macro step up to which an undamped mode grows by less than 1/500 at any order, and
# phase up to which it does not grow with at least this damping, by number of columns: see `bound`.
# A single column takes no longer steps.
_SAFE_PHASE = 2.4
_DAMPED_PHASE = 6.0
_LEAST_DAMPING = {1: 1e3, 2: 0.04, 3: 0.017, 4: 0.008}

METHODS = {"extrapolated": 0, "equilibrium": 1, "mean": 2, "tangent": 3, "wilson": 4, "exact": 5}
_TANGENT, _WILSON, _EXACT = 3, 4, 5
# Substeps in each column of the extrapolation: orders 2, 4, 6, 8, stable for overdamped modes.
SEQUENCES = {1: (1,), 2: (1, 3), 3: (1, 2, 4), 4: (1, 2, 3, 5)}


class Stepper:
    """Attempts macro steps from the present state; the integrator decides whether to accept them.

    Parameters
    ----------
    network : of the system
    method : key of `METHODS`
    columns : number of columns of the extrapolation; 1 for the methods of order 2
    tolerance : relative to the largest motion so far
    theta : of `wilson`
    """

    def __init__(self, network, method, columns, tolerance, theta):
        n = network.n
        self.net, self.n = network, n
        self.method, self.columns, self.tolerance = METHODS[method], columns, tolerance
        self.q, self.v, self.a, self.j = vectors(4, n)  # now
        self.qb, self.vb, self.ab, self.jb = vectors(4, n)  # at the end of the attempt
        self.error_order = 0  # exponent of the step in the error of the attempt
        self.road_rate = 0.0  # of the fastest sinusoid at the start of a step, rad/s
        self.controlled = False  # whether the error controls the step
        self.least_damping = _LEAST_DAMPING[columns]
        self.reach = 0.0  # the largest motion so far, m, to which errors are relative
        self.scale = 0.0
        self.origin = doubles([0.0] * n)  # start of the run, from which the motion is measured
        self.stamp = 0  # changes with every branch, to mark stored matrices as outdated
        self.multiplier, self.multiplier_rate = vectors(2, network.elements)
        # Wilson's acceleration minus that of the equation of motion, which is in `a`
        self.theta = theta
        self.drift, self.drift_end = vectors(2, n)
        self._allocate()

    def _allocate(self):
        n = self.n
        self.stiffness, self.damping = vectors(2, n * n)
        self.stiffness_known = doubles([0.0] * n * n)  # the stiffness of the known fastest mode
        self.factor = doubles([0.0] * (4 * n * n))
        self.factor_step, self.factor_stamp = doubles([0.0] * 4), integers([-1] * 4)
        self.constant, self.cq, self.cv, self.ca = vectors(4, n)
        self.softest, self.velocity_scale = doubles([1e300] * n), doubles([0.0] * n)
        self.pq, self.pv = vectors(2, n)
        self.table = doubles([0.0] * (4 * 2 * n))
        # the times of all substeps of a macro step, each evaluated once
        sequence = SEQUENCES[self.columns]
        self.sequence = integers(sequence)
        fractions = sorted({(i + 1.0) / m for m in sequence for i in range(m)})
        self.fractions = len(fractions)
        self.fraction = doubles(fractions)
        if self.method == _WILSON:
            self.fraction[0] = self.theta
        self.fraction_index = integers(
            fractions.index((i + 1.0) / m) if i < m else 0 for m in sequence for i in range(_MOST)
        )
        self.signal_table = doubles([0.0] * (3 * max(self.net.signals, 1) * self.fractions))
        self.iteration = Iteration(
            self.net, (self.cq, self.cv, self.ca), self.signal_table, self.method == _TANGENT
        )
        self.load_table = doubles([0.0] * (n * self.fractions))
        self.load_rate = doubles([0.0] * n)
        self.loads_hold = 0  # whether the loads of the present branch are constant, and known
        # linear branches of systems with up to eight coordinates use a faster method
        self.side_by_side = self.method < _WILSON and n <= 8
        self.lanes = (
            Lanes(
                (self.net.mass, self.net.flexibility),
                sequence,
                self.fraction_index,
                self.load_table,
                self.load_rate,
                (self.stiffness, self.damping),
                (self.q, self.v, self.a, self.j),
                (self.qb, self.vb, self.ab, self.jb),
            )
            if self.side_by_side
            else None
        )
        self.middle_q, self.middle_v, self.middle_a = vectors(3, n)
        self.septic_q, self.septic_v, self.septic_a = vectors(3, n)
        self.propagator = (
            Propagator(
                self.net,
                self.stiffness,
                self.damping,
                (self.q, self.v, self.a),
                (self.middle_q, self.middle_v),
                (self.qb, self.vb),
            )
            if self.method == _EXACT
            else None
        )

    def count_from_here(self):
        """Measure the motion from the present displacements, the start of a run."""
        self.reach = 0.0
        for i in range(self.n):
            self.origin[i] = self.q[i]

    def reach_at(self, q):
        """Return the largest motion so far, including that at displacements q, m."""
        reach = self.reach
        for i in range(self.n):
            x = fabs(q[i] - self.origin[i])
            if not x <= reach:
                reach = x
        return reach

    def start(self, scale):
        """Reset to rest in the equilibrium of the system that the network has read.

        `scale` is a displacement, m; errors below its rounding do not matter.
        """
        self.scale = scale
        for i in range(self.n):
            self.q[i] = self.v[i] = self.drift[i] = self.drift_end[i] = 0.0
            self.softest[i] = 1e300
        self.count_from_here()
        for e in range(self.net.elements):
            self.multiplier[e] = self.multiplier_rate[e] = 0.0
        self.stiffness_known[0] = -1e300  # none yet
        if self.side_by_side:
            self.lanes.enter_mass()

    def refresh(self, t):
        """Update tangents, acceleration, jerk, fastest mode after a change of branch or state."""
        self.stamp += 1
        self.affine = self.net.is_affine()
        self.loads_hold = 0
        self.net.all_signals(t)
        if self.affine:
            # p - sum b f = (constant + signals) - B v - K q
            self.net.linearise()
            self.net.constant_force(self.constant)
        if self.in_lanes():
            self.net.assemble(self.stiffness, self.damping)
            self._begin_in_lanes()
        else:
            self.net.row_states(self.q, self.v)
            self.net.row_forces()
            self.net.assemble(self.stiffness, self.damping)
            self.net.accelerate(self.a)
            self.net.jerk(self.v, self.a, self.j)
        if self.net.stuck:
            self.keep_multipliers()
        self._find_fastest()
        self._scale_velocities()

    def _find_fastest(self):
        """Find the fastest mode, if the stiffness has changed; most switches are of dampers."""
        same = 1
        for i in range(self.n * self.n):
            if self.stiffness[i] != self.stiffness_known[i]:
                same = 0
            self.stiffness_known[i] = self.stiffness[i]
        if not same:
            self.omega_squared = self.net.fastest_mode(self.stiffness)
        self.quickest = sqrt(self.omega_squared)
        self.longest = _SAFE_PHASE / self.quickest if self.quickest > 0.0 else 1e300
        self.damping_known = 0

    def bound(self, h):
        """Return the macro step h, or the longest one in which no mode grows numerically, if shorter.

        The limit is 2.4 rad for an undamped mode. In a linear branch it is 6 rad if every mode beyond
        2.4 is damped: c_i > x h (omega_i^2 - (2.4 / h)^2), where x is the least damping. This holds if
        B - x h (K - (2.4 / h)^2 M) is positive definite.
        """
        if h > self.longest and not self.damping_known:
            self.damping_known = 1
            omega = sqrt(self.omega_squared)
            longer = _DAMPED_PHASE / omega
            if self.in_lanes() and self.net.is_damped(
                self.stiffness, self.damping, self.least_damping * longer, _SAFE_PHASE / longer
            ):
                self.longest = longer
        return self.longest if h > self.longest else h

    def _begin_in_lanes(self):
        """Find loads, acceleration and jerk at the start of a linear branch."""
        self._find_loads(self.fractions - 1, 1)
        self.lanes.enter()
        if self.net.still():
            for k in range(self.fractions - 1):
                for i in range(self.n):
                    at = (self.fractions - 1) * self.n
                    self.load_table[k * self.n + i] = self.load_table[at + i]
            self.loads_hold = 1

    def _scale_velocities(self):
        """Find the factors that turn errors of velocity into errors of displacement.

        An error of velocity becomes a displacement by the lowest natural frequency in any branch so far,
        at least 1 rad/s, as even the stiffest stop is soon left; or an acceleration by strong damping.
        """
        for k in range(self.n):
            at = k * self.n + k
            omega = sqrt(fabs(self.stiffness[at]) / self.net.mass[at])
            self.softest[k] = omega = min(self.softest[k], omega if omega > 1.0 else 1.0)
            decay = self.damping[at] / self.net.mass[at]
            self.velocity_scale[k] = max(omega, decay) / (omega * omega)
            self.quickest += decay

    def keep_multipliers(self):
        """Store the present forces of sticking, as attempts overwrite those of the network."""
        for e in range(self.net.elements):
            self.multiplier[e] = self.net.multiplier[e]
            self.multiplier_rate[e] = self.net.multiplier_rate[e]

    # -- one step of the incremental method --------------------------------------------------------

    def _factor_step_matrix(self, column, h):
        """Factorise M + h/2 B + h^2/6 K; the factors are reused while branch and step stay."""
        if self.factor_step[column] == h and self.factor_stamp[column] == self.stamp:
            return 0
        size = self.n * self.n
        at = column * size
        for i in range(size):
            self.factor[at + i] = (
                self.net.mass[i] + h / 2.0 * self.damping[i] + h * h / 6.0 * self.stiffness[i]
            )
        self.factor_step[column] = h
        self.factor_stamp[column] = self.stamp
        return decompose(self.factor, at, self.n)

    def _substep_affine(self, column, h, fraction):
        """Step by (15.12), (15.13) to the linear equilibrium at the end, with one solve."""
        n = self.n
        at = fraction * n
        for i in range(n):
            self.pv[i] = self.cv[i] + h / 2.0 * self.ca[i]
            self.pq[i] = self.cq[i] + h * self.cv[i] + h * h / 3.0 * self.ca[i]
        for i in range(n):
            f = self.load_table[at + i]
            for k in range(n):
                f -= self.damping[i * n + k] * self.pv[k] + self.stiffness[i * n + k] * self.pq[k]
            self.ca[i] = f
        solve(self.factor, column * n * n, n, self.ca)
        if self.net.stuck:
            self.iteration.take_signals(fraction)
            if self.net.stick(
                self.factor, column * n * n, self.ca, self.net.zero, 2, self.net.multiplier
            ):
                return _NOT_POSITIVE
        for i in range(n):
            self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
            self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
        return 0

    # -- the macro step ------------------------------------------------------------------------------

    def _prepare_signals(self, h):
        """Evaluate signals at the times of all substeps, and for linear branches the loads."""
        if self.loads_hold:
            return
        for k in range(self.fractions):
            if k > 0 and self.loads_hold:
                self._repeat_signals(k)
                continue
            self.net.all_signals(self.time + self.fraction[k] * h)
            if not self.in_lanes():
                self._note_signals(k)
            if self.affine:
                self.loads_hold = self.net.still()
                self._find_loads(k, k + 1 == self.fractions or self.loads_hold)

    def _note_signals(self, k):
        at = 3 * self.net.signals * k
        for s in range(self.net.signals):
            for order in range(3):
                self.signal_table[at + 3 * s + order] = self.net.road[4 * s + order]

    def _repeat_signals(self, k):
        """Copy signals and loads at the first fraction to fraction k."""
        width = 3 * self.net.signals
        for i in range(width):
            self.signal_table[k * width + i] = self.signal_table[i]
        for i in range(self.n):
            self.load_table[k * self.n + i] = self.load_table[i]

    def _find_loads(self, k, rates):
        """Find loads at fraction k, and their rates if `rates`, as at the end of a step."""
        for i in range(self.n):
            self.load_table[k * self.n + i] = self.constant[i]
        self._add_loads(self.load_table, k * self.n, 0)
        if rates:
            for i in range(self.n):
                self.load_rate[i] = 0.0
            self._add_loads(self.load_rate, 0, 1)

    def _add_loads(self, out, at, order):
        """Add the forces of loads and roads, or their rates, with the signals in `road`."""
        n = self.n
        for m in range(self.net.loads):
            p = self.net.road[4 * self.net.load_signal[m] + order]
            if p != 0.0:
                for i in range(n):
                    out[at + i] += self.net.load_direction[m * n + i] * p
        for r in range(self.net.rows):
            s = self.net.row_signal[r]
            if s >= 0:
                f = (
                    self.net.branch_k[r] * self.net.road[4 * s + order]
                    + self.net.branch_c[r] * self.net.road[4 * s + order + 1]
                )
                if f != 0.0:
                    for i in range(n):
                        out[at + i] += self.net.row_direction[r * n + i] * f

    def _column(self, column, h):
        """Take a macro step in the equal substeps of a column, into the extrapolation table."""
        n = self.n
        m = self.sequence[column]
        step = h / m
        at = column * 2 * n
        for i in range(n):
            self.cq[i] = self.q[i]
            self.cv[i] = self.v[i]
            self.ca[i] = self.a[i]
        if self.affine and self._factor_step_matrix(column, step) != 0:
            return _NOT_POSITIVE
        for k in range(m):
            fraction = self.fraction_index[_MOST * column + k]
            if self.affine:
                status = self._substep_affine(column, step, fraction)
            elif self.method >= 2 and not self.net.stuck:
                status = self.iteration.add_increments(self.time, step, fraction)
            else:
                status = self.iteration.reach_equilibrium(step, fraction, self.reach)
            if status != 0:
                return status
        for i in range(n):
            self.table[at + i] = self.cq[i]
            self.table[at + n + i] = self.cv[i]
        return 0

    def attempt(self, t, h):
        """Step from t to t + h with all branches fixed; write the end to qb, vb, ab, jb."""
        self.time = t
        self.error_order = 2 * self.columns - 1
        if self.method == _EXACT:
            return self._propagate(t, h)
        self._prepare_signals(h)
        if self.method == _WILSON:
            return self._reach_beyond(t, h)
        if not self.in_lanes():
            return self._one_by_one(t, h)
        status = self.lanes.attempt(h)
        self._begin_errors()
        for i in range(self.n):
            self._note_error(fabs(self.lanes.error_q[i]))
            self._note_error(fabs(self.lanes.error_v[i]) * self.velocity_scale[i])
        phase = h * (self.quickest + self.road_rate) / _SLOW_PHASE
        if phase < 1.0:
            better = phase * phase
            if better > 1.0 / _MOST_BETTER:
                self.error_order += 2
            else:
                better = 1.0 / _MOST_BETTER
            self.error *= better
        if self.controlled and h * self.quickest > _STIFF_PHASE:
            self._check_reading(h)
        return status

    def _check_reading(self, h):
        """Count the effect of the end jerks on the septic halfway as an error, for stiff motions.

        If a motion decays within a small part of the step, the jerks contain its remainder times the
        square of its decay rate, and do not describe the step.
        """
        for i in range(self.n):
            self._note_error(_SHARE * h * h * h / 768.0 * fabs(self.jb[i] - self.j[i]))

    def in_lanes(self):
        """Return whether the present branch is linear and uses the faster method."""
        return self.affine and self.side_by_side and not self.net.stuck

    def shift_end(self, t, late):
        """Move the end of the attempt slightly, to t, along its Taylor series."""
        for i in range(self.n):
            a, j = self.ab[i], self.jb[i]
            self.qb[i] += late * (self.vb[i] + late * (a / 2.0 + late * j / 6.0))
            self.vb[i] += late * (a + late * j / 2.0)
        if not self.in_lanes():
            self._end_of_attempt(t)
            return
        self.loads_at_end(t)
        self.lanes.finish()

    def stop_within(self, t, dense):
        """End the attempt at t, on the septic `dense` through its ends."""
        dense.read(t)
        for i in range(self.n):
            self.qb[i], self.vb[i] = dense.q[i], dense.v[i]
        if not self.in_lanes():
            self._end_of_attempt(t)
            return
        self.loads_at_end(t)
        self.lanes.finish()

    def loads_at_end(self, t):
        """Find the loads of a linear branch at the end of a step, t."""
        if not self.loads_hold:
            self.net.all_signals(t)
            self._find_loads(self.fractions - 1, 1)

    def _one_by_one(self, t, h):
        """Make the columns one after the other and extrapolate by Aitken and Neville.

        T[j,m] = T[j,m-1] + (T[j,m-1] - T[j-1,m-1]) / ((n_j / n_(j-m))^2 - 1).
        """
        n = self.n
        width = 2 * n
        largest = 0.0
        for column in range(self.columns):
            status = self._column(column, h)
            if status != 0:
                return status
            for m in range(1, column + 1):
                ratio = self.sequence[column] / (1.0 * self.sequence[column - m])
                weight = 1.0 / (ratio * ratio - 1.0)
                # the row below is overwritten from the left: T[j-1,m-1] is at column - m
                low = (column - m) * width
                high = (column - m + 1) * width
                for i in range(width):
                    change = (self.table[high + i] - self.table[low + i]) * weight
                    self.table[low + i] = self.table[high + i] + change
                    if m == column and column + 1 == self.columns:
                        scale = self.velocity_scale[i - n] if i >= n else 1.0
                        largest = max(largest, _CAUTION * fabs(change) * scale)
        for i in range(n):
            self.qb[i] = self.table[i]
            self.vb[i] = self.table[n + i]
            if not (isfinite(self.qb[i]) and isfinite(self.vb[i])):
                return _DIVERGED
        self._begin_errors()
        self._note_error(largest)
        self._end_of_attempt(t + h)
        if self.controlled:
            self._check_middle(h)
        return 0

    def _reach_beyond(self, t, h):
        """Take Wilson's step: equilibrium at theta h, and 1/theta of the change of acceleration."""
        n = self.n
        beyond = self.theta * h
        for i in range(n):
            self.cq[i] = self.q[i]
            self.cv[i] = self.v[i]
            self.ca[i] = self.a[i] + self.drift[i]
        if not self.affine:
            status = self.iteration.reach_equilibrium(beyond, 0, self.reach)
        elif self._factor_step_matrix(0, beyond) != 0:
            status = _NOT_POSITIVE
        else:
            status = self._substep_affine(0, beyond, 0)
        if status != 0:
            return status
        for i in range(n):
            a0 = self.a[i] + self.drift[i]
            a1 = self.ca[i] = a0 + (self.ca[i] - a0) / self.theta
            self.vb[i] = self.v[i] + h / 2.0 * (a0 + a1)
            self.qb[i] = self.q[i] + h * self.v[i] + h * h / 6.0 * (2.0 * a0 + a1)
            if not (isfinite(self.qb[i]) and isfinite(self.vb[i])):
                return _DIVERGED
        self._end_of_attempt(t + h)
        for i in range(n):
            self.drift_end[i] = self.ca[i] - self.ab[i]
        return 0

    def _propagate(self, t, h):
        """Take the exact step; its error is that of the septic through its ends, halfway."""
        status = self.propagator.attempt(t, h)
        if status != 0:
            return status
        self._end_of_attempt(t + h)
        self._begin_errors()
        self._read_middle(h)
        for i in range(self.n):
            # errors do not accumulate here, so one step may use the whole tolerance; in v the
            # difference of q over a short step is rounded
            rounding = 1e-15 * (fabs(self.q[i]) + fabs(self.qb[i])) / h
            self._note_error(_SHARE * fabs(self.septic_q[i] - self.middle_q[i]))
            self._note_error(
                _SHARE
                * self.velocity_scale[i]
                * (fabs(self.septic_v[i] - self.middle_v[i]) - rounding)
            )
        return 0

    def _read_middle(self, h):
        """Evaluate the septic through the ends of the attempt and two derivatives, halfway."""
        for i in range(self.n):
            v, a, j = self.vb[i] - self.v[i], self.ab[i] - self.a[i], self.jb[i] - self.j[i]
            self.septic_q[i] = 0.5 * (self.q[i] + self.qb[i]) - h * (
                11.0 / 64.0 * v - h * (3.0 / 128.0 * (self.a[i] + self.ab[i]) - h / 768.0 * j)
            )
            self.septic_v[i] = (
                35.0 / 16.0 * (self.qb[i] - self.q[i]) / h
                - 19.0 / 32.0 * (self.v[i] + self.vb[i])
                + h * (a / 16.0 - h / 384.0 * (self.j[i] + self.jb[i]))
            )
            self.septic_a[i] = (
                15.0 / 8.0 * v / h - 7.0 / 16.0 * (self.a[i] + self.ab[i]) + h / 32.0 * j
            )

    def _check_middle(self, h):
        """Count the residual of the septic in the equation of motion halfway as an error of the step.

        It shows a knee of a curved force that all substeps miss. An error e of the septic, which
        vanishes at both ends, is 1/32 h^2 e'' halfway, and its rate is at most 0.12 h e''.
        """
        self._read_middle(h)
        self.net.all_signals(self.time + 0.5 * h)
        self.net.row_states(self.septic_q, self.septic_v)
        self.net.row_forces()
        self.net.net_force(self.middle_a)
        solve(self.net.mass_factor, 0, self.n, self.middle_a)
        if self.net.stuck:
            self.net.stick(self.net.mass_factor, 0, self.middle_a, self.net.zero, 2, self.net.kick)
        for i in range(self.n):
            lack = _SHARE * h * fabs(self.septic_a[i] - self.middle_a[i])
            self._note_error(h / 32.0 * lack)
            self._note_error(0.12 * self.velocity_scale[i] * lack)

    def _begin_errors(self):
        """Reset the error, and set the allowed one from the largest motion so far or in the attempt.

        It is at least the rounding of displacements and of the forces that balance at rest.
        """
        self.error = 0.0
        size = self.scale
        for i in range(self.n):
            size = max(size, fabs(self.q[i]), fabs(self.origin[i]))
        self.allowed = _SHARE * self.tolerance * self.reach_at(self.qb)
        self.allowed = max(self.allowed, _ROUNDING * size) + _LEAST_LENGTH

    def _note_error(self, size):
        """Update the largest error, in units of the tolerance."""
        error = size / self.allowed
        if not error <= self.error:
            self.error = error

    def _end_of_attempt(self, t):
        self.net.all_signals(t)
        self.net.rest(self.vb)
        self.net.row_states(self.qb, self.vb)
        self.net.row_forces()
        self.net.accelerate(self.ab)
        self.net.jerk(self.vb, self.ab, self.jb)
