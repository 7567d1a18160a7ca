"""Macro steps by one method from the present state with all branches fixed, and how to shorten them."""

from __future__ import annotations

from ..language import inline
from ..motion.balance import MOST_COORDINATES, MOST_ROWS, Balance
from ..motion.dense import Dense
from ..motion.errors import Errors
from ..motion.modes import Modes
from ..motion.motion import Motion
from ..motion.rows import Rows
from ..network.network import Network
from .method import Method


class Stepper:
    """Attempts macro steps from the present state; the integrator decides whether to accept them.

    Parameters
    ----------
    network : network of the system
    method : a class of `registry.METHODS`
    order : the order that its `order_of` has returned
    tolerance : relative to the largest motion so far
    theta : of `wilson`
    """

    def __init__(
        self, network: Network, method: type[Method], order: int, tolerance: float, theta: float
    ) -> None:
        n = network.n
        if n > MOST_COORDINATES:
            raise ValueError(
                f"a system of {n} coordinates: at most {MOST_COORDINATES} are possible"
            )
        if network.elements.rows > MOST_ROWS:
            raise ValueError(
                f"elements along {network.elements.rows} directions: at most {MOST_ROWS} are possible"
            )
        self.net, self.n = network, n
        self.motion = Motion(network)
        self.balance = Balance(self.motion, method.instants(order, theta))
        self.modes = Modes(self.balance)
        self.errors = Errors(self.motion, self.balance, self.modes, tolerance)
        self.rows = Rows(self.motion, self.balance, self.errors)
        self.method: Method = method(
            self.motion, self.balance, self.modes, self.errors, order, theta
        )

    def refresh(self, t: float) -> None:
        """Update tangents, acceleration, jerk and fastest mode after a change of branch or state."""
        self.balance.enter()
        self.method.enter()
        self.balance.begin(t)
        if self.net.branches.stuck:
            self.motion.keep_multipliers()
        self.modes.follow()

    def attempt(self, t: float, h: float) -> int:
        """Step from t to t + h with all branches fixed; write the end to qb, vb, ab, jb."""
        self.rows.end_known = self.net.laws.failed = False
        self.errors.time, self.errors.step = t, h
        self.errors.order = self.method.order - 1
        return self.method.attempt(t, h)

    def shift_end(self, t: float, late: float) -> None:
        """Move the end of the attempt slightly, to t, along its Taylor series."""
        self.rows.end_known = False
        for i in range(self.n):
            a, j = self.motion.ab[i], self.motion.jb[i]
            v = self.motion.vb[i]
            self.motion.qb[i] = self.motion.qb[i] + late * (v + late * (a / 2.0 + late * j / 6.0))
            self.motion.vb[i] = v + late * (a + late * j / 2.0)
        own_jerks = self.errors.own_jerks
        self.method.end(t)
        if own_jerks:
            self.errors.find_jerks(t - self.errors.time)

    @inline
    def stop_within(self, t: float, dense: Dense) -> None:
        """End the attempt at t, on the septic `dense` through its ends."""
        self.rows.end_known = False
        dense.read(t)
        for i in range(self.n):
            self.motion.qb[i], self.motion.vb[i] = dense.q[i], dense.v[i]
        self.method.end(t)
