"""The interface of a method: what it is given, what it must return, and the properties it declares."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..language import Numbers, inline, of_python, takes_gil
from ..motion.balance import Balance
from ..motion.errors import Errors
from ..motion.modes import Modes
from ..motion.motion import Motion
from ..outcomes import DIVERGED

if TYPE_CHECKING:
    from ...systems import System


class Method:
    """One way to step from the present state to the state h later, with all branches fixed.

    A method of the kernel is a class derived from this one. It sets the attributes in which it differs,
    and overrides `attempt`; its name goes into `registry.METHODS`. It is given `motion` (the present
    state), `balance` (the equation of motion of the branches, with its loads at `instants`), `modes` and
    `errors`. `attempt` must write the end to `motion.qb` and `motion.vb`, then call `end`, which finds
    the acceleration and its rate there, and leave the signals as they are there. It returns 0, or the
    reason why there is no such step.

    A method in Python overrides `step` instead; it is slower. Both kinds declare their properties by
    `order_of` and `limit_of`, which are called before the method is made.

    Parameters
    ----------
    motion, balance, modes, errors : those of the stepper
    order : the order that `order_of` has returned
    theta : parameter of methods that seek equilibrium beyond the end of the step
    """

    n: int
    order: int
    theta: float
    limit: float
    least_damping: float
    most_error: float
    controls: bool
    exact: bool
    cubic: bool
    to_end: bool

    def __init__(
        self,
        motion: Motion,
        balance: Balance,
        modes: Modes,
        errors: Errors,
        order: int,
        theta: float,
    ) -> None:
        self.motion, self.balance, self.modes, self.errors = motion, balance, modes, errors
        self.net, self.n = self.motion.net, self.motion.n
        self.order, self.theta = order, theta
        self.limit = self.limit_of(order)
        # damping with which no mode grows up to a phase of 6, see `Modes.bound`; 0 if none is enough
        self.least_damping = 0.0
        # whether it estimates its error, so that the tolerance can choose its steps
        self.controls = False
        self.most_error = 1.0  # error, over the one allowed, beyond which a step is repeated
        # whether its motion is accurate even where the ledger and the septic of a step are not
        self.exact = False
        # the interpolant of a step: a septic through its ends, or a cubic, whose third derivative may
        # follow from the displacement at the end instead of the acceleration there
        self.cubic = self.to_end = False

    @staticmethod
    def order_of(system: System, step: float, tolerance: float, order: int) -> int:
        """Return the order for a system, a fixed step (0: automatic), a tolerance and a desired order."""
        return 2

    @staticmethod
    def limit_of(order: int) -> float:
        """Return the largest omega h at which no undamped mode grows; 0 if there is no limit."""
        return 12.0**0.5

    @staticmethod
    def instants(order: int, theta: float) -> list[float]:
        """Return the instants at which a step needs the loads, as fractions of it, ascending."""
        return [1.0]

    @staticmethod
    def refusal(system: System) -> str:
        """Return why the method cannot integrate a system; empty if it can."""
        return ""

    def enter(self) -> None:
        """Discard what belongs to earlier branches, after a change of the branches or of the state."""

    @takes_gil
    def attempt(self, t: float, h: float) -> int:
        """Step from t to t + h; return 0 or a key of `outcomes.FAILURES`."""
        try:
            q = [self.motion.q[i] for i in range(self.n)]
            v = [self.motion.v[i] for i in range(self.n)]
            qb, vb = self.step(t, h, q, v)
            for i in range(self.n):
                self.motion.qb[i], self.motion.vb[i] = qb[i], vb[i]
        except BaseException as error:  # an interrupt, too, as C cannot pass it on
            self.net.laws.note_failure(error)
            return DIVERGED
        self.end(t + h)
        return 0

    @inline
    def end(self, t: float) -> None:
        """Find acceleration and jerk at the end of the attempt, t, which is read with the jerks there."""
        self.balance.end(t, False)
        self.errors.keep_jerks()

    @of_python
    def step(self, t: float, h: float, q: Numbers, v: Numbers) -> tuple[Numbers, Numbers]:
        """Return displacements and velocities at t + h from those at t; a method in Python defines it."""
        raise NotImplementedError(f"{type(self).__name__} defines no step")

    @of_python
    def accelerations(self, t: float, q: Numbers, v: Numbers) -> list[float]:
        """Return the accelerations of a state at any time t, by the equation of motion (m/s^2)."""
        n, errors = self.n, self.errors
        for i in range(n):
            errors.septic_q[i], errors.septic_v[i] = q[i], v[i]
        self.balance.accelerations(t, errors.septic_q, errors.septic_v, errors.middle_a)
        return [errors.middle_a[i] for i in range(n)]
