"""Exact propagation of linear branches: the matrix exponential of state and excitation together.

While all branches are linear, the motion and its excitation obey one linear system x' = X x in

    x = (q - q0, q', 1, t, t^2/2, t^3/6, and the cosine and sine of each present sinusoid),

because a signal is a cubic plus a cosine. The column of the 1 is chosen to reproduce the acceleration
at the start exactly, so that a mass at rest stays at rest. exp(h X) is a Taylor series over h / 2^k,
short enough for 16 terms to be accurate to rounding, which is then squared k times. The exponential
minus the identity is squared, D <- 2 D + D D, so that a slow motion keeps its digits next to one that
is damped within a microsecond.
"""

from __future__ import annotations

from math import cos, fabs, isfinite, sin
from typing import TYPE_CHECKING, Any

from ..language import Doubles, of_python
from ..layout import AMPLITUDE, ANGLE, C1, C2, C3, ORIGIN, SEGMENT, SPEED
from ..linear import solve
from ..motion.balance import Balance
from ..motion.errors import _SHARE
from ..motion.motion import Motion
from ..outcomes import DIVERGED
from .method import Method

if TYPE_CHECKING:
    from ...systems import System

_TERMS = 16
_SHORT = 0.5  # largest change of any motion or road in one part, for which the terms suffice
_POWERS = 4  # of time, in the cubic of a signal
# factor by which the septic must be more accurate in q, as its rates and accelerations are read, too
_FINER = 128.0


class Propagator:
    """Exact steps of any length in the present linear branch."""

    def __init__(self, motion: Motion, balance: Balance) -> None:
        self.net, self.n = motion.net, motion.n
        self.signals = self.net.signals
        self.straight = balance.straight
        self.stiffness, self.damping = balance.tangent_k, balance.tangent_c
        self.q0, self.v0, self.a0 = motion.q, motion.v, motion.a
        self.q2, self.v2 = motion.qb, motion.vb
        self.q1, self.v1 = self.net.memory.zeros(self.n), self.net.memory.zeros(self.n)  # halfway
        most = 2 * self.n + _POWERS + 2 * self.signals.count
        memory, size = self.net.memory, most * most
        self.rates, self.term = memory.zeros(size), memory.zeros(size)
        self.product, self.change = memory.zeros(size), memory.zeros(size)
        self.state, self.step = memory.zeros(most), memory.zeros(most)
        self.column = memory.zeros(self.n)
        self.multiplier = memory.zeros(self.net.elements.count)
        self.size = most

    def attempt(self, t: float, h: float) -> int:
        """Step from now, t, over h, in two halves; return 0 or a key of `outcomes.FAILURES`."""
        n = self.n
        doublings = 0
        self.part = 0.5 * h
        while not self._is_short():
            self.part *= 0.5
            doublings += 1
        self._find_rates(t)
        self._sum_series()
        for _k in range(doublings):
            self._multiply(self.change, self.change)
            for i in range(self.size * self.size):
                self.change[i] = 2.0 * self.change[i] + self.product[i]
        for i in range(n):
            self.state[i] = 0.0
            self.state[n + i] = self.v0[i] * self.part
        self._apply()
        for i in range(n):
            self.q1[i] = self.q0[i] + self.state[i]
            self.v1[i] = self.state[n + i] / self.part
        self._apply()
        for i in range(n):
            self.q2[i] = self.q0[i] + self.state[i]
            self.v2[i] = self.state[n + i] / self.part
            if not (isfinite(self.q2[i]) and isfinite(self.v2[i])):
                return DIVERGED
        return 0

    def _is_short(self) -> bool:
        """Return whether all motions and roads change little within one part."""
        n = self.n
        for j in range(n):
            for matrix in range(2):
                for i in range(n):
                    k = j * n + i
                    self.column[i] = self.stiffness[k] if matrix == 0 else self.damping[k]
                solve(self.net.mass_factor, 0, n, self.column)
                total = 0.0
                for i in range(n):
                    total += fabs(self.column[i])
                if matrix == 0:
                    total *= self.part / _SHORT
                if self.part * total > _SHORT:
                    return False
        for s in range(self.signals.count):
            g = self._segment(s)
            speed = fabs(self.signals.segment[g + SPEED])
            if self.signals.segment[g + AMPLITUDE] != 0.0 and speed * self.part > _SHORT:
                return False
        return True

    def _find_rates(self, t: float) -> None:
        """Find X, scaled to one part with velocities as distance per part, and x at t without q, q'."""
        n = self.n
        cosines = 0
        for s in range(self.signals.count):
            if self.signals.segment[self._segment(s) + AMPLITUDE] != 0.0:
                cosines += 1
        self.size = size = 2 * n + _POWERS + 2 * cosines
        for i in range(size * size):
            self.rates[i] = 0.0
        for i in range(n):
            self.rates[i * size + n + i] = 1.0
        factor = self.part * self.part
        for j in range(2 * n):
            self._clear()
            for i in range(n):
                k = (j if j < n else j - n) * n + i
                self.column[i] = -self.stiffness[k] if j < n else -self.damping[k]
            self._enter_column(j, factor if j < n else self.part)
        self.state[2 * n] = 1.0
        for k in range(1, _POWERS):
            self._clear()
            for s in range(self.signals.count):
                for order in range(3):
                    self.signals.road[4 * s + order] = self._derivative(s, t, k + order)
            self.net.add_loads(self.straight.k, self.straight.c, self.column, 0, 0)
            factor *= self.part
            self._enter_column(2 * n + k, factor)
            self.state[2 * n + k] = 0.0
            self.rates[(2 * n + k) * size + 2 * n + k - 1] = 1.0
        at = 2 * n + _POWERS
        for s in range(self.signals.count):
            if self.signals.segment[self._segment(s) + AMPLITUDE] != 0.0:
                self._enter_sinusoid(s, at, t)
                at += 2
        self._enter_start()

    def _enter_start(self) -> None:
        """Set the column of the 1: the acceleration at the start minus that due to the other columns."""
        n, size = self.n, self.size
        for i in range(n):
            x = self.part * self.part * self.a0[i]
            for j in range(n):
                x -= self.rates[(n + i) * size + n + j] * (self.v0[j] * self.part)
            for j in range(2 * n + _POWERS, size):
                x -= self.rates[(n + i) * size + j] * self.state[j]
            self.rates[(n + i) * size + 2 * n] = x

    def _segment(self, s: int) -> int:
        return (self.signals.signal_first[s] + self.signals.signal_now[s]) * SEGMENT

    def _enter_sinusoid(self, s: int, at: int, t: float) -> None:
        """Enter cosine and sine of signal s, which rotate at w; its derivatives are -w sin, -w^2 cos."""
        g = self._segment(s)
        amplitude, speed = self.signals.segment[g + AMPLITUDE], self.signals.segment[g + SPEED]
        angle = self.signals.segment[g + ANGLE] + speed * (t - self.signals.segment[g + ORIGIN])
        self.state[at], self.state[at + 1] = cos(angle), sin(angle)
        self.rates[at * self.size + at + 1] = -speed * self.part
        self.rates[(at + 1) * self.size + at] = speed * self.part
        for side in range(2):
            self._clear()
            if side == 0:
                self.signals.road[4 * s] = amplitude
                self.signals.road[4 * s + 2] = -amplitude * speed * speed
            else:
                self.signals.road[4 * s + 1] = -amplitude * speed
            self.net.add_loads(self.straight.k, self.straight.c, self.column, 0, 0)
            self._enter_column(at + side, self.part * self.part)

    def _clear(self) -> None:
        for i in range(4 * self.signals.count):
            self.signals.road[i] = 0.0
        for i in range(self.n):
            self.column[i] = 0.0

    def _derivative(self, s: int, t: float, order: int) -> float:
        """Return a derivative, of order 1 or more, of the cubic part of signal s."""
        g = self._segment(s)
        x = t - self.signals.segment[g + ORIGIN]
        segment = self.signals.segment
        c1, c2, c3 = segment[g + C1], segment[g + C2], segment[g + C3]
        if order == 1:
            return c1 + x * (2.0 * c2 + x * 3.0 * c3)
        if order == 2:
            return 2.0 * c2 + 6.0 * c3 * x
        return 6.0 * c3 if order == 3 else 0.0

    def _enter_column(self, j: int, factor: float) -> None:
        """Enter the acceleration due to the force in `column`; sticking rows follow their roads."""
        solve(self.net.mass_factor, 0, self.n, self.column)
        if self.net.branches.stuck:
            self.net.sticking.stick(
                self.net.mass_factor, 0, self.column, self.net.sticking.zero, 2, self.multiplier
            )
        for i in range(self.n):
            self.rates[(self.n + i) * self.size + j] = factor * self.column[i]

    def _sum_series(self) -> None:
        """Set `change` to exp(X) - 1 = X + X^2/2 + ..."""
        size = self.size * self.size
        for i in range(size):
            self.term[i] = self.change[i] = self.rates[i]
        for order in range(2, _TERMS + 1):
            self._multiply(self.term, self.rates)
            for i in range(size):
                self.term[i] = self.product[i] / order
                self.change[i] += self.term[i]

    def _multiply(self, left: Doubles, right: Doubles) -> None:
        """Set `product` to the product of two matrices, most of whose entries are zero."""
        size = self.size
        for i in range(size):
            for j in range(size):
                self.product[i * size + j] = 0.0
            for k in range(size):
                x = left[i * size + k]
                if x != 0.0:
                    for j in range(size):
                        self.product[i * size + j] += x * right[k * size + j]

    def _apply(self) -> None:
        """x <- x + D x"""
        size = self.size
        for i in range(size):
            x = 0.0
            for j in range(size):
                x += self.change[i * size + j] * self.state[j]
            self.step[i] = x
        for i in range(size):
            self.state[i] += self.step[i]


class Exact(Method):
    """The matrix exponential; the step is chosen so that the septic through its ends is accurate, too."""

    def __init__(self, *given: Any) -> None:
        Method.__init__(self, *given)
        self.controls = self.exact = True
        self.propagator = Propagator(self.motion, self.balance)

    @staticmethod
    def order_of(system: System, step: float, tolerance: float, order: int) -> int:
        """Return the order of the septic; the motion itself is exact at any step."""
        return 8

    @staticmethod
    def limit_of(order: int) -> float:
        return 0.0

    @staticmethod
    def refusal(system: System) -> str:
        """Return why a system is not linear in each of its branches; empty if it is."""
        return not_straight(system)

    def attempt(self, t: float, h: float) -> int:
        """Take the exact step; its error is that of the septic through its ends, halfway.

        Each derivative of the septic is less accurate than the one before: with e the error of q, up to
        3.8 e / h in v and 32 e / h^2 in a. So it must be much more accurate in q than q alone requires.
        """
        status = self.propagator.attempt(t, h)
        if status != 0:
            return status
        self.net.signals.all_signals(t + h)  # the propagator uses their numbers
        self.end(t + h)
        self.errors.begin(h)
        self.errors.read_middle(h)
        for i in range(self.n):
            # errors do not accumulate here, so one step may use the whole tolerance; the rate of the
            # septic has the rounding of a difference of q over the step
            rounding = 1e-15 * (fabs(self.motion.q[i]) + fabs(self.motion.qb[i])) / h
            off_q = fabs(self.errors.septic_q[i] - self.propagator.q1[i])
            off_v = fabs(self.errors.septic_v[i] - self.propagator.v1[i]) - rounding
            self.errors.note(_SHARE * _FINER * off_q)
            self.errors.note(_SHARE * self.modes.velocity_scale[i] * off_v)
        self.errors.error /= self.errors.allowed
        return 0


@of_python
def not_straight(system: System) -> str:
    """Return why a system is not linear in each of its branches; empty if it is."""
    for element in system.elements:
        for what in ("spring", "damper", "modulation"):
            for piece in getattr(element, what).pieces:
                if not piece.is_straight:
                    return f"the {what} of {element.name!r} is curved"
        if any(piece.coefficients[1] for piece in element.modulation.pieces):
            return f"the damper of {element.name!r} depends on deflection"
    for name, signal in system.signals.items():
        if any(segment.amplitude and segment.phase[2] for segment in signal.segments):
            return f"the frequency of {name!r} changes in time"
    return ""
