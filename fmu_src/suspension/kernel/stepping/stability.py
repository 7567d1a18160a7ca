"""Check whether a fixed step is stable.

The linear-acceleration method is stable while omega_max h < 2 sqrt 3, whatever the damping (H83
chapter 15 refers to Bathe and Wilson 1976, section 9.4, for the limit). In a macro step extrapolated
from 1, 2, 3 and 5 substeps an undamped amplitude grows by less than 1/1000 while omega_max h < 3.2, with
shorter sequences while it is < 2.2. omega_max^2 is the largest eigenvalue of M^-1 K, where K is the
present tangent.
"""

from __future__ import annotations

from math import floor, sqrt

from ..language import Long
from ..layout import UNBOUNDED
from ..linear import decompose
from ..motion.modes import Modes

POLICIES = {"substep": 0, "refuse": 1, "allow": 2}
_REFUSE, _ALLOW = 1, 2
_BELOW = 0.9999  # of the limit: at the limit itself the amplitude grows in proportion to time
_HALVINGS = 64  # of an interval that is at most n times as long as the eigenvalue


class StabilityMonitor:
    """Watches the fixed steps of one integrator.

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
        self.stamp: Long = -1
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
            self.omega = sqrt(largest)
        return self.omega

    def _largest_eigenvalue(self) -> float:
        """Return the largest eigenvalue of M^-1 K, or 0: beyond it x M - K is positive definite."""
        low, high = 0.0, self.modes.omega_squared * (1.0 + 1e-9)
        for _halving in range(_HALVINGS):
            x = 0.5 * (low + high)
            for i in range(self.n * self.n):
                stiffness = self.modes.stiffness[i] + self.net.series.stiffness[i]
                self.matrix[i] = x * self.net.mass[i] - stiffness
            if decompose(self.matrix, 0, self.n) == 0:
                high = x
            else:
                low = x
        return low
