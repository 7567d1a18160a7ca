"""Wilson's method: equilibrium beyond the step, so that linear systems are stable at any step."""

from __future__ import annotations

from math import isfinite
from typing import Any

from ..outcomes import DIVERGED
from ..substep.columns import Columns
from .method import Method


class Wilson(Method):
    """(15.12), (15.13) up to theta h, equilibrium there, and 1/theta of the change of acceleration."""

    def __init__(self, *given: Any) -> None:
        Method.__init__(self, *given)
        self.columns = Columns(self.motion, self.balance, (1,), [0])
        self.start_a = self.net.memory.zeros(self.n)

    @staticmethod
    def limit_of(order: int) -> float:
        return 0.0

    @staticmethod
    def instants(order: int, theta: float) -> list[float]:
        return [theta]

    def enter(self) -> None:
        """Discard the matrices."""
        self.columns.inverses.forget()

    def attempt(self, t: float, h: float) -> int:
        """Step from t to t + h; return 0 or a key of `outcomes.FAILURES`."""
        n = self.n
        self.balance.prepare(t, h)
        for i in range(n):
            self.start_a[i] = self.motion.a[i] + self.motion.drift[i]
        self.columns.iteration.enough = 0.0
        status = self.columns.attempt(self.theta * h, self.start_a)
        if status != 0:
            return status
        for i in range(n):
            a0 = self.start_a[i]
            a1 = a0 + (self.columns.a[i] - a0) / self.theta
            self.motion.drift_end[i] = a1
            self.motion.vb[i] = self.motion.v[i] + h / 2.0 * (a0 + a1)
            self.motion.qb[i] = (
                self.motion.q[i] + h * self.motion.v[i] + h * h / 6.0 * (2.0 * a0 + a1)
            )
            if not (isfinite(self.motion.qb[i]) and isfinite(self.motion.vb[i])):
                return DIVERGED
        self.end(t + h)
        for i in range(n):
            self.motion.drift_end[i] = self.motion.drift_end[i] - self.motion.ab[i]
        return 0
