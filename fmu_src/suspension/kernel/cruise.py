"""Equal steps in one linear branch, as long as no watched quantity comes near a bound.

The step is that of `stepper` with the matrices of the branch, which are stored,

    a1 = (M + h/2 B + h^2/6 K)^-1 (p1 - B v* - K q*),    v* = v0 + h/2 a0,    q* = q0 + h v0 + h^2/3 a0.

A watched quantity, w = g q + c v minus the same for its road, is a cubic within such a step. It stays
within its bounds if its four Bernstein coefficients do:

    w0,    w0 + h/3 w0',    w1 - h/3 w1',    w1;

Any other step is left to the search for switches.
"""

from __future__ import annotations

import cython

if not cython.compiled:
    from math import fabs

_ROOM = 256  # numbers for the watched quantities, one per coordinate each
_WATCHED = 64
_DAMPER, _CONTACT, _FRICTION = 1, 3, 4  # as in elements


class Cruise:
    """Equal steps in the present linear branch, and the state after the last one.

    Parameters
    ----------
    stepper : the stepper of the branch
    switches : the quantities watched in it
    """

    def __init__(self, stepper, switches):
        self.stepper, self.switches = stepper, switches
        self.net, self.lanes, self.n = self.stepper.net, self.stepper.lanes, self.stepper.n
        self.last = (self.stepper.fractions - 1) * self.n  # index of the loads at the end of a step
        self.stamp = -1
        # literal sizes, as these are C arrays
        self.stiffness, self.damping, self.inverse = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.q, self.v, self.a, self.load = [0.0] * 8, [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.q0, self.v0, self.a0 = [0.0] * 8, [0.0] * 8, [0.0] * 8  # before the last step
        self.q1, self.v1, self.a1 = [0.0] * 8, [0.0] * 8, [0.0] * 8  # after the current step
        self.pq, self.pv, self.f = [0.0] * 8, [0.0] * 8, [0.0] * 8
        self.origin = [0.0] * 8  # from which the motion is measured
        self.g, self.c = [0.0] * 256, [0.0] * 256
        self.signal = [0] * 64
        self.of_road, self.of_rate, self.at_rest = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.low, self.high = [0.0] * 64, [0.0] * 64
        self.offset, self.drift = [0.0] * 64, [0.0] * 64
        self.value, self.rate = [0.0] * 64, [0.0] * 64
        self.value1, self.rate1 = [0.0] * 64, [0.0] * 64
        self.watched = self.taken = 0
        self.h = 0.0
        self.start = self.time = self.reach = 0.0  # of the last step, and the largest motion

    def enter(self, h):
        """Copy the present branch for steps h; return whether it is suitable."""
        if self.stamp == self.stepper.stamp:
            return self.fits
        self.stamp = self.stepper.stamp
        self.fits = 0
        self.h = h
        n = self.n
        count = self.switches.watched
        if count > _WATCHED or count * n > _ROOM or not self.stepper.in_lanes():
            return 0
        if self.lanes.invert(h) != 0:
            return 0
        for i in range(n * n):
            self.stiffness[i] = self.lanes.stiffness[i]
            self.damping[i] = self.lanes.damping[i]
            self.inverse[i] = self.lanes.inverse[i]
        self.watched = count
        for k in range(count):
            self._watch(k)
        self.still = self.net.still()
        self.fits = 1
        return 1

    def _watch(self, k):
        """Store a watched quantity as a combination of displacements, velocities and its road."""
        e, kind = self.switches.watched_element[k], self.switches.watched_kind[k]
        row = self.net.element_row[e]
        value, rate, rest = 1.0, 0.0, 0.0  # a deflection
        if kind == _CONTACT:
            value, rate = self.switches.contact_k[e], self.switches.contact_c[e]
            rest = self.switches.contact_f[e]
        elif kind in (_DAMPER, _FRICTION):
            value, rate = 0.0, 1.0
        for i in range(self.n):
            b = self.net.row_direction[row * self.n + i]
            self.g[k * self.n + i] = value * b
            self.c[k * self.n + i] = rate * b
        self.at_rest[k], self.of_road[k], self.of_rate[k] = rest, value, rate
        self.signal[k] = self.net.row_signal[row]
        self.low[k], self.high[k] = self.switches.low[k], self.switches.high[k]

    def begin(self, t):
        """Start from the stepper's state at time t."""
        n = self.n
        self.time, self.taken, self.reach = t, 0, self.stepper.reach
        for i in range(n):
            self.origin[i] = self.stepper.origin[i]
        self._read_roads(t)
        for i in range(n):
            self.q[i], self.v[i], self.a[i] = (
                self.stepper.q[i],
                self.stepper.v[i],
                self.stepper.a[i],
            )
        for k in range(self.watched):
            w = self.offset[k]
            r = self.drift[k]
            for i in range(n):
                g, c = self.g[k * n + i], self.c[k * n + i]
                w += g * self.q[i] + c * self.v[i]
                r += g * self.v[i] + c * self.a[i]
            self.value[k], self.rate[k] = w, r

    def _read_roads(self, t):
        """Evaluate roads and loads at time t, for the masses and the watched quantities."""
        self.net.all_signals(t)
        self.stepper.loads_at_end(t)
        for i in range(self.n):
            self.load[i] = self.stepper.load_table[self.last + i]
        for k in range(self.watched):
            s = self.signal[k]
            self.offset[k] = self.at_rest[k]
            self.drift[k] = 0.0
            if s >= 0:
                g, c = self.of_road[k], self.of_rate[k]
                self.offset[k] -= g * self.net.road[4 * s] + c * self.net.road[4 * s + 1]
                self.drift[k] -= g * self.net.road[4 * s + 1] + c * self.net.road[4 * s + 2]

    def go(self, grid, index, until, end, most):
        """Take steps on the grid + h index, none after `until`, none that reaches `end`."""
        # with a constant in place of n the compiler unrolls the loops
        if self.n == 2:
            self._go(grid, index, until, end, most, 2)
        elif self.n == 1:
            self._go(grid, index, until, end, most, 1)
        elif self.n == 4:
            self._go(grid, index, until, end, most, 4)
        else:
            self._go(grid, index, until, end, most, self.n)

    def _go(self, grid, index, until, end, most, n):
        q, v, a, load, f, pq, pv = self.q, self.v, self.a, self.load, self.f, self.pq, self.pv
        origin = self.origin
        q0, v0, a0, q1, v1, a1 = self.q0, self.v0, self.a0, self.q1, self.v1, self.a1
        stiffness, damping, inverse, g, c = (
            self.stiffness,
            self.damping,
            self.inverse,
            self.g,
            self.c,
        )
        value, rate, value1, rate1 = self.value, self.rate, self.value1, self.rate1
        offset, drift, low, high = self.offset, self.drift, self.low, self.high
        h = self.h
        half, third = h / 2.0, h / 3.0
        sixth = h * h / 6.0
        while self.time < until and self.taken < most and self.time + h * (1.0 + 1e-9) < end:
            t = grid + (index + self.taken + 1) * h
            if not self.still:
                self._read_roads(t)
            for i in range(n):
                pv[i] = v[i] + half * a[i]
                pq[i] = q[i] + h * (v[i] + third * a[i])
            for i in range(n):
                x = load[i]
                for j in range(n):
                    x -= damping[n * i + j] * pv[j] + stiffness[n * i + j] * pq[j]
                f[i] = x
            for i in range(n):
                x = 0.0
                for j in range(n):
                    x += inverse[n * i + j] * f[j]
                a1[i] = x
                v1[i] = pv[i] + half * x
                q1[i] = pq[i] + sixth * x
            for k in range(self.watched):
                w = offset[k]
                r = drift[k]
                for i in range(n):
                    w += g[n * k + i] * q1[i] + c[n * k + i] * v1[i]
                    r += g[n * k + i] * v1[i] + c[n * k + i] * a1[i]
                inside = low[k] < w < high[k] and low[k] < value[k] < high[k]
                x = value[k] + third * rate[k]
                y = w - third * r
                if not (inside and low[k] < x < high[k] and low[k] < y < high[k]):
                    return
                value1[k] = w
                rate1[k] = r
            for k in range(self.watched):
                value[k] = value1[k]
                rate[k] = rate1[k]
            for i in range(n):
                q0[i], v0[i], a0[i] = q[i], v[i], a[i]
                q[i], v[i], a[i] = q1[i], v1[i], a1[i]
                x = fabs(q1[i] - origin[i])
                self.reach = max(self.reach, x)
            self.start, self.time = self.time, t
            self.taken += 1
