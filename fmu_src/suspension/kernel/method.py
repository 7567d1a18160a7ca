"""The contract of a method: what it is given, what it must return, and what the steps must know of it."""

from __future__ import annotations

from .outcomes import DIVERGED


class Method:
    """One way to step from the state now to one that is h later, with all branches fixed.

    A method of the kernel derives from this class, sets what it differs in, and replaces `attempt`; its
    name goes into `methods.METHODS`. It is given `motion` (the state now), `balance` (the equation of
    motion of the branches, with its loads at `instants`), `modes` and `errors`. `attempt` must write the
    end to `motion.qb` and `motion.vb`, and with `balance.end` the acceleration and its rate there to
    `motion.ab` and `motion.jb`; it returns 0, or why there is no such step.

    A method in Python replaces `step` instead; it is slower. Either way `order_of` and `limit_of`, which
    are asked before there is a method, say what is known of it.

    Parameters
    ----------
    motion, balance, modes, errors : of the steps
    order : what `order_of` has returned
    theta : parameter of methods that go beyond the step
    """

    def __init__(self, motion, balance, modes, errors, order, theta):
        self.motion, self.balance, self.modes, self.errors = motion, balance, modes, errors
        self.net, self.n = self.motion.net, self.motion.n
        self.order, self.theta = order, theta
        self.limit = self.limit_of(order)
        # damping, as share of the critical one, with which no mode grows up to a phase of 6; 0: none is
        self.least_damping = 0.0
        # whether it finds its error, so that the tolerance can choose its steps
        self.controls = False
        self.most_error = 1.0  # over the one allowed, before a step is repeated
        self.reads_switches = False  # whether states within a step may be read from its septic
        self.exact = False  # whether its motion is accurate even where the ledger is not
        # the interpolant of a step: a septic through its ends, or a cubic, whose third derivative may
        # follow from the displacement at the end instead of the acceleration there
        self.cubic = self.to_end = False

    @staticmethod
    def order_of(system, step, tolerance, order):
        """Return the order: of a system, a fixed step (0 if chosen), a tolerance, the order asked for."""
        return 2

    @staticmethod
    def limit_of(order):
        """Return the largest omega h at which no undamped mode grows; 0 if there is no limit."""
        return 12.0**0.5

    @staticmethod
    def instants(order, theta):
        """Return where in a step the loads are needed, as fractions of it, ascending to the end."""
        return [1.0]

    @staticmethod
    def refusal(system):
        """Return why the method cannot take a system; empty if it can."""
        return ""

    def enter(self):
        """Forget what belongs to other branches: they have changed, or the state has."""

    def attempt(self, t, h):
        """Step from t to t + h; return 0 or a key of `integrator.FAILURES`."""
        try:
            q = [self.motion.q[i] for i in range(self.n)]
            v = [self.motion.v[i] for i in range(self.n)]
            q, v = self.step(t, h, q, v)
            for i in range(self.n):
                self.motion.qb[i], self.motion.vb[i] = q[i], v[i]
        except Exception as error:
            self.net.failure = self.net.failure or error
            return DIVERGED
        self.balance.end(t + h, self.motion.qb, self.motion.vb, self.motion.ab, self.motion.jb)
        return 0

    def step(self, t, h, q, v):
        """Return displacements and velocities at t + h, from those at t: for a method in Python."""
        raise NotImplementedError(f"{type(self).__name__} defines no step")

    def accelerations(self, t, q, v):
        """Return the accelerations of a state at any time t, by the equation of motion (m/s^2)."""
        n, errors = self.n, self.errors
        for i in range(n):
            errors.septic_q[i], errors.septic_v[i] = q[i], v[i]
        self.balance.accelerations(t, errors.septic_q, errors.septic_v, errors.middle_a)
        return [errors.middle_a[i] for i in range(n)]
