"""How fast the motion in the present branches can be: fastest mode, decays, and the longest step."""

from __future__ import annotations

from math import fabs, sqrt

from ..language import Long, inline
from ..layout import UNBOUNDED
from .balance import Balance

# Phase of a mode per macro step up to which an undamped mode grows by less than 1/500 at any order, and
# phases up to which it does not grow with the least damping of the method, and with more: see `bound`.
_SAFE_PHASE = 2.4
_DAMPED_PHASE = 6.0
_LONGEST_PHASE = 8.4
_MORE_DAMPING = 1.8  # times the least damping


class Modes:
    """Frequencies and decays of the present tangents."""

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        self.net, self.n = self.balance.net, self.balance.n
        memory, n = self.net.memory, self.n
        self.stiffness, self.damping = self.balance.tangent_k, self.balance.tangent_c
        self.stiffness_known = memory.zeros(n * n)  # stiffness for which the fastest mode is known
        self.softest, self.velocity_scale = self.net.state.memory.zeros(n), memory.zeros(n)
        # of literal sizes, as these are C arrays
        self.k, self.a, self.squared = [0.0] * 1024, [0.0] * 1024, [0.0] * 1024
        self.road_rate = 0.0  # of the fastest sinusoid at the start of a step, rad/s
        # changes with every branch, to mark what belongs to an earlier one as outdated
        self.stamp: Long = 0

    def start(self) -> None:
        """Discard all earlier branches."""
        for i in range(self.n):
            self.softest[i] = UNBOUNDED
        self.stiffness_known[0] = -UNBOUNDED  # none yet

    def follow(self) -> None:
        """Update what depends on the tangents, after a change of them."""
        self.stamp += 1
        self._find_fastest()
        self._scale_velocities()

    def _find_fastest(self) -> None:
        """Find the fastest mode, if the stiffness has changed; most switches change dampers only."""
        same = 1
        for i in range(self.n * self.n):
            if self.stiffness[i] != self.stiffness_known[i]:
                same = 0
            self.stiffness_known[i] = self.stiffness[i]
        if not same:
            # with a constant in place of n the compiler unrolls the loops
            if self.n == 2:
                self.omega_squared = self._highest(2)
            elif self.n == 4:
                self.omega_squared = self._highest(4)
            else:
                self.omega_squared = self._highest(self.n)
        self.quickest = sqrt(self.omega_squared)
        self.longest = _SAFE_PHASE / self.quickest if self.quickest > 0.0 else UNBOUNDED
        self.damping_known = 0

    @inline
    def _highest(self, n: int) -> float:
        """Return a bound of the highest angular frequency squared: (tr A^4)^(1/4), A = M^-1 K.

        K includes the springs in series, as if their dampers were rigid. The bound is at most n^(1/4)
        times too large and does not depend on units.
        """
        trace = 0.0
        for i in range(n * n):
            self.k[i] = self.stiffness[i] + self.net.series.stiffness[i]
        for i in range(n):
            for k in range(n):
                x = 0.0
                for j in range(n):
                    x += self.net.flexibility[i * n + j] * self.k[j * n + k]
                self.a[i * n + k] = x
        for i in range(n):
            for k in range(n):
                x = 0.0
                for j in range(n):
                    x += self.a[i * n + j] * self.a[j * n + k]
                self.squared[i * n + k] = x
        for i in range(n):
            for k in range(n):
                trace += self.squared[i * n + k] * self.squared[k * n + i]
        return sqrt(sqrt(trace)) if trace > 0.0 else 0.0

    def bound(self, h: float, least_damping: float) -> float:
        """Return the macro step h, or the longest one in which no mode grows numerically, if shorter.

        The limit is 2.4 rad for an undamped mode. In a linear branch it is 6 rad if every mode beyond
        2.4 is damped: c_i > x h (omega_i^2 - (2.4 / h)^2), where x is the least damping, that of the
        method (0 for none). This holds if B - x h (K - (2.4 / h)^2 M) is positive definite. With 1.8
        times this damping the limit is 8.4 rad.
        """
        if h > self.longest and least_damping > 0.0 and not self.damping_known:
            self.damping_known = 1
            if not self._lengthened(_LONGEST_PHASE, _MORE_DAMPING * least_damping):
                self._lengthened(_DAMPED_PHASE, least_damping)
        return self.longest if h > self.longest else h

    def _lengthened(self, phase: float, least_damping: float) -> bool:
        """Let steps be as long as a phase of the fastest mode, if every mode is damped enough for it."""
        longer = phase / sqrt(self.omega_squared)
        if self.net.is_damped(
            self.stiffness, self.damping, least_damping * longer, _SAFE_PHASE / longer
        ):
            self.longest = longer
            return True
        return False

    def _scale_velocities(self) -> None:
        """Find the factors that convert errors of velocity into errors of displacement.

        An error of velocity becomes a displacement at the lowest natural frequency of any branch so far,
        at least 1 rad/s, as even the stiffest stop is soon left; with strong damping, an acceleration.
        """
        for k in range(self.n):
            at = k * self.n + k
            if k >= self.net.series.outer:  # the extension of a spring in series
                self.velocity_scale[k] = 1.0
                self.quickest += self.damping[at] / self.net.mass[at]
                continue
            omega = sqrt(fabs(self.stiffness[at]) / self.net.mass[at])
            self.softest[k] = omega = min(self.softest[k], omega if omega > 1.0 else 1.0)
            decay = self.damping[at] / self.net.mass[at]
            self.velocity_scale[k] = max(omega, decay) / (omega * omega)
            self.quickest += decay
