"""One macro step with all branches fixed, by any of the methods, and its error.

In a linear branch the last column of the extrapolation (see `columns`) is better than the one before by
the square of the phase of the fast modes, once that is small, so that errors are proportional to the
tolerance. An infinitely damped mode is multiplied by -1 in each substep and by the sum of w (-1)^n in a
macro step, where w are the weights of the extrapolation: -0.59 for 1, 2, 3 and 5 substeps, but 6.2 if
the last column had 4.
"""

from __future__ import annotations

from functools import cache

import cython

from .balance import MOST_COORDINATES, MOST_ROWS, Balance
from .columns import Columns
from .exact import Propagator
from .increments import Increments

if not cython.compiled:
    from math import fabs, isfinite, sqrt


_DIVERGED = 2  # key of integrator.FAILURES

_SHARE = 0.1  # share of the tolerance for one step, as the errors of many steps add up
# Phase per macro step, of the fastest mode, its decay and the road together, below which the last column
# is better than the one before by the square of the phase; a gain of at most `_MOST_BETTER` is assumed.
_SLOW_PHASE = 2.0
_MOST_BETTER = 10.0
_ROUNDING = 1e-13  # of displacements, below which errors cannot be resolved
_LEAST_LENGTH = 1e-290  # m, instead of none
# the least share of that difference that is taken for the error with curved forces
_BENT_BETTER = 0.3
_READ_SHARE = 0.05  # share of the error allowed, for reading where a switch is
_READ_PHASE = (
    3.0  # phase of the fastest motion up to which the septic can be as accurate as the step
)
_FINER = 128.0  # times as accurate in q must a septic be whose rates and accelerations are read
_STIFF_PHASE = 100.0  # phase of the fastest motion beyond which jerks do not describe a step
_MOST = 5  # substeps in one macro step
_NEGLIGIBLE = 0.02  # share of the error allowed, for what is left when curved forces are iterated
# Phase of a mode per macro step up to which an undamped mode grows by less than 1/500 at any order, and
# phase up to which it does not grow with at least this damping, by number of columns: see `bound`.
# A single column takes no longer steps.
_SAFE_PHASE = 2.4
_DAMPED_PHASE = 6.0
_LEAST_DAMPING = {1: 1e3, 2: 0.04, 3: 0.017, 4: 0.008}

METHODS = {"extrapolated": 0, "equilibrium": 1, "mean": 2, "tangent": 3, "wilson": 4, "exact": 5}
_MEAN, _TANGENT, _WILSON, _EXACT = 2, 3, 4, 5
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
        if n > MOST_COORDINATES:
            raise ValueError(
                f"a system of {n} coordinates: at most {MOST_COORDINATES} are possible"
            )
        if network.rows > MOST_ROWS:
            raise ValueError(
                f"elements along {network.rows} directions: at most {MOST_ROWS} are possible"
            )
        self.net, self.n = network, n
        self.method, self.columns, self.tolerance = METHODS[method], columns, tolerance
        memory = self.net.memory
        # now, and at the end of the attempt
        self.q, self.v, self.a, self.j = (
            memory.zeros(n), memory.zeros(n), memory.zeros(n), memory.zeros(n),
        )  # fmt: skip
        self.qb, self.vb, self.ab, self.jb = (
            memory.zeros(n), memory.zeros(n), memory.zeros(n), memory.zeros(n),
        )  # fmt: skip
        self.error_order = 0  # exponent of the step in the error of the attempt
        self.road_rate = 0.0  # of the fastest sinusoid at the start of a step, rad/s
        self.controlled = False  # whether the error controls the step
        self.least_damping = _LEAST_DAMPING[columns]
        self.reach = 0.0  # the largest motion so far, m, to which errors are relative
        self.scale = 0.0
        self.origin = memory.zeros(n)  # start of the run, from which the motion is measured
        self.stamp = 0  # changes with every branch, to mark stored matrices as outdated
        held = self.net.elements
        self.multiplier, self.multiplier_rate = memory.zeros(held), memory.zeros(held)
        # Wilson's acceleration minus that of the equation of motion, which is in `a`
        self.theta = theta
        self.drift, self.drift_end = memory.zeros(n), memory.zeros(n)
        self._allocate()

    def _allocate(self):
        n, memory = self.n, self.net.memory
        self.stiffness_known = memory.zeros(n * n)  # the stiffness of the known fastest mode
        self.softest, self.velocity_scale = memory.doubles([1e300] * n), memory.zeros(n)
        sequence = SEQUENCES[self.columns]
        fractions, index = _instants(sequence)
        if self.method == _WILSON:
            fractions = [self.theta]
        self.balance = Balance(self.net, fractions)
        self.stiffness, self.damping = self.balance.tangent_k, self.balance.tangent_c
        self.columns_now = Columns(self.balance, sequence, index)
        self.start_a = memory.zeros(n)
        self.middle_q, self.middle_v, self.middle_a = (
            memory.zeros(n),
            memory.zeros(n),
            memory.zeros(n),
        )
        self.septic_q, self.septic_v, self.septic_a = (
            memory.zeros(n),
            memory.zeros(n),
            memory.zeros(n),
        )
        self.lack = memory.zeros(n)
        self.adds = self.method in (_MEAN, _TANGENT)
        self.increments = Increments(self.net, self.method == _TANGENT) if self.adds else None
        self.propagator = Propagator(self.net) if self.method == _EXACT else None
        if self.method == _EXACT:
            self.propagator.stiffness, self.propagator.damping = self.stiffness, self.damping
            self.propagator.q0, self.propagator.v0, self.propagator.a0 = self.q, self.v, self.a
            self.propagator.q1, self.propagator.v1 = self.middle_q, self.middle_v
            self.propagator.q2, self.propagator.v2 = self.qb, self.vb

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

    def refresh(self, t):
        """Update tangents, acceleration, jerk, fastest mode after a change of branch or state."""
        self.balance.enter()
        self.columns_now.forget()
        self.balance.begin(t, self.q, self.v, self.a, self.j)
        if self.net.stuck:
            self.keep_multipliers()
        self.follow_tangents()

    def follow_tangents(self):
        """Update what depends on the tangents, after a change of them."""
        self.stamp += 1
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
            if self.method < _WILSON and self.net.is_damped(
                self.stiffness, self.damping, self.least_damping * longer, _SAFE_PHASE / longer
            ):
                self.longest = longer
        return self.longest if h > self.longest else h

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

    # -- the macro step ------------------------------------------------------------------------------

    def attempt(self, t, h):
        """Step from t to t + h with all branches fixed; write the end to qb, vb, ab, jb."""
        self.time = t
        self.error_order = 2 * self.columns - 1
        if self.method == _EXACT:
            return self._propagate(t, h)
        if self.method == _WILSON:
            return self._reach_beyond(t, h)
        if self.adds and self.balance.bends and not self.net.stuck:
            return self._add_increments(t, h)
        self.balance.prepare(t, h)
        if self.balance.bends:
            self.columns_now.enough = self._enough(h)
        status = self.columns_now.attempt(h, self.q, self.v, self.a, self.j)
        if status != 0:
            return status
        if self.columns_now.extrapolate(self.qb, self.vb) != 0:
            return _DIVERGED
        self.balance.end_step(t + h, self.qb, self.vb, self.ab, self.jb)
        if self.controlled:
            self._find_error(h)
        return 0

    def _find_error(self, h):
        """Find the error of the attempt, in units of the one allowed."""
        self._begin_errors()
        for i in range(self.n):
            self._note_error(fabs(self.columns_now.error_q[i]))
            self._note_error(fabs(self.columns_now.error_v[i]) * self.velocity_scale[i])
        self._expect_better(h)
        if self.balance.bends:
            self._check_middle(h)
        if h * self.quickest > _STIFF_PHASE:
            self._check_reading(h)
        self.error /= self.allowed

    def _enough(self, h):
        """Return the error of accelerations that does not matter in a step, m/s^2; 0 for a fixed one."""
        if not self.controlled:
            return 0.0
        slowest = h
        for i in range(self.n):
            slowest = max(slowest, self.velocity_scale[i])
        return _NEGLIGIBLE * _SHARE * self.tolerance * self.reach / (h * slowest)

    def _expect_better(self, h):
        """Take the last column for better than the one before by the square of the phase, if small.

        With curved forces only by the phase, as their own changes count, too.
        """
        phase = h * (self.quickest + self.road_rate) / _SLOW_PHASE
        if phase < 1.0 and self.balance.bends:
            self.error *= max(phase, _BENT_BETTER)
        elif phase < 1.0:
            better = phase * phase
            if better > 1.0 / _MOST_BETTER:
                self.error_order += 2
            else:
                better = 1.0 / _MOST_BETTER
            self.error *= better

    def _add_increments(self, t, h):
        """Add the increments with tangents at the start of the step or their mean over it."""
        for i in range(self.n):
            self.qb[i], self.vb[i], self.ab[i] = self.q[i], self.v[i], self.a[i]
        status = self.increments.add(t, h, self.qb, self.vb, self.ab)
        if status == 0:
            self.balance.end(t + h, self.qb, self.vb, self.ab, self.jb)
        return status

    def _check_reading(self, h):
        """Count the effect of the end jerks on the septic halfway as an error, for stiff motions.

        If a motion decays within a small part of the step, the jerks contain its remainder times the
        square of its decay rate, and do not describe the step.
        """
        for i in range(self.n):
            self._note_error(_SHARE * h * h * h / 768.0 * fabs(self.jb[i] - self.j[i]))

    def is_plain(self):
        """Return whether all forces of the present branches are straight, and nothing sticks."""
        return self.balance.bends == 0 and not self.net.stuck

    def shift_end(self, t, late):
        """Move the end of the attempt slightly, to t, along its Taylor series."""
        for i in range(self.n):
            a, j = self.ab[i], self.jb[i]
            self.qb[i] += late * (self.vb[i] + late * (a / 2.0 + late * j / 6.0))
            self.vb[i] += late * (a + late * j / 2.0)
        self.balance.end(t, self.qb, self.vb, self.ab, self.jb)

    def stop_within(self, t, dense):
        """End the attempt at t, on the septic `dense` through its ends."""
        dense.read(t)
        for i in range(self.n):
            self.qb[i], self.vb[i] = dense.q[i], dense.v[i]
        self.balance.end(t, self.qb, self.vb, self.ab, self.jb)

    def _reach_beyond(self, t, h):
        """Take Wilson's step: equilibrium at theta h, and 1/theta of the change of acceleration."""
        n = self.n
        self.balance.prepare(t, h)
        for i in range(n):
            self.start_a[i] = self.a[i] + self.drift[i]
        self.columns_now.enough = 0.0
        status = self.columns_now.attempt(self.theta * h, self.q, self.v, self.start_a, self.j)
        if status != 0:
            return status
        for i in range(n):
            a0 = self.start_a[i]
            a1 = a0 + (self.columns_now.a[i] - a0) / self.theta
            self.drift_end[i] = a1
            self.vb[i] = self.v[i] + h / 2.0 * (a0 + a1)
            self.qb[i] = self.q[i] + h * self.v[i] + h * h / 6.0 * (2.0 * a0 + a1)
            if not (isfinite(self.qb[i]) and isfinite(self.vb[i])):
                return _DIVERGED
        self.balance.end(t + h, self.qb, self.vb, self.ab, self.jb)
        for i in range(n):
            self.drift_end[i] -= self.ab[i]
        return 0

    def _propagate(self, t, h):
        """Take the exact step; its error is that of the septic through its ends, halfway.

        Each derivative of the septic is less accurate than the one before: with e the error of q, up to
        3.8 e / h in v and 32 e / h^2 in a. So it must be a good deal more accurate than q need be.
        """
        status = self.propagator.attempt(t, h)
        if status != 0:
            return status
        self.balance.end(t + h, self.qb, self.vb, self.ab, self.jb)
        self._begin_errors()
        self._read_middle(h)
        for i in range(self.n):
            # errors do not accumulate here, so one step may use the whole tolerance; in v the
            # difference of q over a short step is rounded
            rounding = 1e-15 * (fabs(self.q[i]) + fabs(self.qb[i])) / h
            self._note_error(_SHARE * _FINER * fabs(self.septic_q[i] - self.middle_q[i]))
            self._note_error(
                _SHARE
                * self.velocity_scale[i]
                * (fabs(self.septic_v[i] - self.middle_v[i]) - rounding)
            )
        self.error /= self.allowed
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
        self._find_lack(h)
        for i in range(self.n):
            lack = _SHARE * h * self.lack[i]
            self._note_error(h / 32.0 * lack)
            self._note_error(0.12 * self.velocity_scale[i] * lack)

    def _find_lack(self, h):
        """Find the residual of the septic in the equation of motion halfway, m/s^2."""
        self._read_middle(h)
        self.balance.accelerations(self.time + 0.5 * h, self.septic_q, self.septic_v, self.middle_a)
        for i in range(self.n):
            self.lack[i] = fabs(self.septic_a[i] - self.middle_a[i])

    def can_read(self, x, h):
        """Return whether the septic through the ends of an attempt is accurate enough at a fraction x.

        An error e of it goes with (x (1 - x))^4; halfway its second derivative is -32 e / h^2.
        """
        if self.net.stuck or h * self.quickest > _READ_PHASE:
            return 0
        if self.balance.bends == 0:
            self._find_lack(h)
        u = x * (1.0 - x)
        of_q = 8.0 * h * h * u * u * u * u
        of_v = 32.0 * h * u * u * u * max(fabs(1.0 - 2.0 * x), 0.25)
        for i in range(self.n):
            error = max(of_q, of_v * self.velocity_scale[i]) * self.lack[i]
            if not error <= _READ_SHARE * self.allowed:
                return 0
        return 1

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
        """Update the largest error, m."""
        if not size <= self.error:
            self.error = size


@cache
def _instants(sequence):
    """Return the instants of all substeps of a macro step, as fractions of it, and which is whose."""
    fractions = sorted({(i + 1.0) / m for m in sequence for i in range(m)})
    return fractions, [
        fractions.index((i + 1.0) / m) if i < m else 0 for m in sequence for i in range(_MOST)
    ]
