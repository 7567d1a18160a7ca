"""Check whether a fixed step is stable.

The linear-acceleration method is stable while omega_max h < 2 sqrt 3, whatever the damping (H83
chapter 15 refers to Bathe and Wilson 1976, section 9.4, for the limit). In a macro step extrapolated
from 1, 2, 3 and 5 substeps an undamped amplitude grows by less than 1/1000 while omega_max h < 3.2, with
shorter sequences while it is < 2.2. omega_max^2 is the largest eigenvalue of M^-1 K, where K is the
present tangent.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import cython

from .layout import UNBOUNDED

if TYPE_CHECKING:
    from .modes import Modes

if not cython.compiled:
    from math import fabs, floor, sqrt

POLICIES = {"substep": 0, "refuse": 1, "allow": 2}
_REFUSE, _ALLOW = 1, 2
_BELOW = 0.9999  # of the limit: at the limit itself the amplitude grows in proportion to time
_SWEEPS = 30


class StabilityMonitor:
    """StabilityMonitor the fixed steps of one integrator.

    Parameters
    ----------
    modes : modes of the present tangents
    policy : key of `POLICIES`
    limit : largest stable omega_max h; 0 if there is no limit
    """

    def __init__(self, modes: Modes, policy: str, limit: float) -> None:
        self.modes = modes
        self.net, self.n = self.modes.net, self.modes.n
        self.policy: int = POLICIES[policy]
        self.limit = _BELOW * limit
        self.stamp = -1
        self.omega = 0.0
        self.matrix = self.net.memory.zeros(self.n * self.n)
        self.start()

    def start(self) -> None:
        """Reset: no step has been too long yet."""
        self.net.state.beyond_since = -UNBOUNDED  # time at which a step was first too long, s
        self.net.state.beyond_step = 0.0  # the stable step then, s

    def fit(self, time: float, h: float) -> float:
        """Return the step to take instead of h: h itself, an equal part of it, or 0 if it is refused."""
        if self.limit == 0.0 or self.policy == _ALLOW:
            return h
        # a known upper bound
        if h * h * self.modes.omega_squared <= self.limit * self.limit:
            return h
        omega = self.fastest()
        if h * omega <= self.limit:
            return h
        if self.net.state.beyond_since == -UNBOUNDED:
            self.net.state.beyond_since = time
            self.net.state.beyond_step = self.limit / omega
        if self.policy == _REFUSE:
            return 0.0
        return h / (1.0 + floor(h * omega / self.limit))

    def fastest(self) -> float:
        """Return omega_max of the present tangent, rad/s; 0 without a restoring force."""
        if self.stamp != self.modes.stamp:
            self.stamp = self.modes.stamp
            largest = self._largest_eigenvalue()
            self.omega = sqrt(largest) if largest > 0.0 else 0.0
        return self.omega

    def _largest_eigenvalue(self) -> float:
        """Return the largest eigenvalue of M^-1 K, by cyclic Jacobi rotations."""
        self._reduce()
        n = self.n
        m = self.matrix
        for _sweep in range(_SWEEPS):
            off = 0.0
            largest = 0.0
            for i in range(n):
                largest = max(largest, fabs(m[i * n + i]))
                for j in range(i):
                    off = max(off, fabs(m[i * n + j]))
            if off <= 1e-15 * largest:
                break
            for i in range(n):
                for j in range(i):
                    if m[i * n + j] != 0.0:
                        self._rotate(i, j)
        largest = m[0]
        for i in range(n):
            largest = max(largest, m[i * n + i])
        return largest

    def _reduce(self) -> None:
        """Set `matrix` to the symmetric L^-1 K L^-T with the same eigenvalues, M = L L^T."""
        n = self.n
        m, low = self.matrix, self.net.mass_factor
        for i in range(n * n):
            m[i] = self.modes.stiffness[i] + self.net.series.stiffness[i]
        for i in range(n):
            for p in range(i):
                for j in range(n):
                    m[i * n + j] -= low[i * n + p] * m[p * n + j]
        for j in range(n):
            for p in range(j):
                for i in range(n):
                    m[i * n + j] -= low[j * n + p] * m[i * n + p]
        for i in range(n):
            for j in range(n):
                m[i * n + j] /= sqrt(low[i * n + i] * low[j * n + j])

    def _rotate(self, i: int, j: int) -> None:
        n = self.n
        m = self.matrix
        theta = (m[j * n + j] - m[i * n + i]) / (2.0 * m[i * n + j])
        t = 1.0 / (fabs(theta) + sqrt(theta * theta + 1.0))
        t = t if theta >= 0.0 else -t
        c = 1.0 / sqrt(t * t + 1.0)
        s = t * c
        for k in range(n):
            x, y = m[k * n + i], m[k * n + j]
            m[k * n + i] = c * x - s * y
            m[k * n + j] = s * x + c * y
        for k in range(n):
            x, y = m[i * n + k], m[j * n + k]
            m[i * n + k] = c * x - s * y
            m[j * n + k] = s * x + c * y
