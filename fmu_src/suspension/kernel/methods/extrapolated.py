"""The extrapolated incremental step, and the single incremental step that ends in equilibrium.

In a linear branch the last column of the extrapolation (see `columns`) is more accurate than the one
before by the square of the phase of the fast modes, if that is small. With this factor, errors are
proportional to the tolerance. An infinitely damped mode is multiplied by -1 in each substep and by the
sum of w (-1)^n in a macro step, where w are the weights of the extrapolation: -0.59 for 1, 2, 3 and 5
substeps, but 6.2 if the last column had 4.
"""

from __future__ import annotations

from math import fabs
from typing import TYPE_CHECKING, Any

from ..language import inline, of_python
from ..motion.errors import _SHARE, ROUNDING_OF_RATES
from ..outcomes import DIVERGED
from ..substep.columns import SEQUENCES, Columns, instants_of
from .method import Method

if TYPE_CHECKING:
    from ...systems import Element, System

# Phase per macro step, of the fastest mode, its decay and the road together, below which the last column
# is more accurate than the one before by the square of the phase, but at most by `_MOST_BETTER`.
_SLOW_PHASE = 2.0
_MOST_BETTER = 10.0
# least share of the difference of these columns that is taken as the error with curved forces
_BENT_BETTER = 0.4
_STIFF_PHASE = 100.0  # phase of the fastest motion beyond which jerks do not describe a step
# error of a step, over its share of the tolerance, up to which it is not repeated: few steps have it, and
# to repeat them costs more than to take all a little shorter
_EXCESS = 2.5
_FINE_TOLERANCE = 1e-4  # tolerance below which order 8 is faster than order 6
_LINK = 1e4  # times the fastest frequency; a damper with a decay this fast acts like a rigid link
# By order: the damping with which no mode grows up to a phase of 6, and with 1.8 times as much up to
# one of 8.4 (see `modes`; a single column takes no longer steps), and the largest omega h at which an
# undamped mode grows by less than 1/1000.
_LEAST_DAMPING = {2: 1e3, 4: 0.04, 6: 0.017, 8: 0.008}
_LIMITS = {2: 12.0**0.5, 4: 2.2, 6: 2.2, 8: 3.2}


class Extrapolated(Method):
    """Columns of 1, 2, 3 and 5 incremental steps, extrapolated to order 8; or to 2, 4, 6 with fewer."""

    def __init__(self, *given: Any) -> None:
        Method.__init__(self, *given)
        self.controls = self.order > 2  # a single column has none before it to compare with
        self.most_error = _EXCESS
        self.least_damping = _LEAST_DAMPING[self.order]
        sequence = SEQUENCES[self.order]
        self.columns = Columns(self.motion, self.balance, sequence, instants_of(sequence)[1])

    @staticmethod
    def order_of(system: System, step: float, tolerance: float, order: int) -> int:
        if order:
            return order
        return 8 if tolerance < _FINE_TOLERANCE or step > 0.0 or _is_stiffly_damped(system) else 6

    @staticmethod
    def limit_of(order: int) -> float:
        return _LIMITS[order]

    @staticmethod
    def instants(order: int, theta: float) -> list[float]:
        return instants_of(SEQUENCES[order])[0]

    def enter(self) -> None:
        """Discard the matrices."""
        self.columns.inverses.forget()

    def attempt(self, t: float, h: float) -> int:
        """Step from t to t + h; return 0 or a key of `outcomes.FAILURES`."""
        return self.extrapolate(t, h)

    @inline
    def extrapolate(self, t: float, h: float) -> int:
        """Take all columns, and find the error from the last two."""
        self.balance.prepare(t, h)
        if self.balance.bends.count:
            self.columns.iteration.enough = self.errors.negligible(h)
        status = self.columns.attempt(h, self.motion.a)
        if status != 0:
            return status
        if self.columns.extrapolate() != 0:
            return DIVERGED
        if self.order > 2 or self.balance.bends.count or self.balance.branches.stuck:
            self.balance.end(t + h, True)
        else:
            self.balance.end_in_equilibrium()
        self.errors.find_jerks(h)
        if self.errors.controlled:
            self._find_error(h)
        return 0

    @inline
    def _find_error(self, h: float) -> None:
        """Find the error of the attempt, in units of the one allowed."""
        self.errors.begin(h)
        rounding = 0.0  # of velocities, which matters where strong damping multiplies it
        for i in range(self.n):
            rounding = max(rounding, ROUNDING_OF_RATES * fabs(self.motion.vb[i]))
        for i in range(self.n):
            error = max(0.0, fabs(self.columns.error_v[i]) - rounding)
            self.errors.note(fabs(self.columns.error_q[i]))
            self.errors.note(error * self.errors.velocity_scale[i])
        self._expect_better(h)
        if self.balance.bends.count:
            self.errors.note_middle(h)
        else:
            self.errors.note_reading(h)
        if h * self.modes.quickest > _STIFF_PHASE:
            self._check_reading(h)
        self.errors.error /= self.errors.allowed

    @inline
    def _expect_better(self, h: float) -> None:
        """Reduce the error by the square of the phase, if small: the last column is that much better.

        With curved forces it is reduced by the phase only, as the changes of these forces count, too.
        """
        phase = h * (self.modes.quickest + self.modes.road_rate) / _SLOW_PHASE
        if phase < 1.0 and self.balance.bends.count:
            self.errors.error *= max(phase, _BENT_BETTER)
        elif phase < 1.0:
            better = phase * phase
            if better > 1.0 / _MOST_BETTER:
                self.errors.order += 2
            else:
                better = 1.0 / _MOST_BETTER
            self.errors.error *= better

    @inline
    def _check_reading(self, h: float) -> None:
        """Count the effect of the end jerks on the septic halfway as an error, for stiff motions.

        If a motion decays within a small part of the step, the jerks contain its remainder times the
        square of its decay rate, and do not describe the step.
        """
        for i in range(self.n):
            self.errors.note(
                _SHARE * h * h * h / 768.0 * fabs(self.motion.end_jerk[i] - self.motion.jerk[i])
            )


class Equilibrium(Extrapolated):
    """One incremental step to the equilibrium at its end: the single column, of order 2."""

    def __init__(self, *given: Any) -> None:
        Extrapolated.__init__(self, *given)
        self.most_error = 1.0
        self.cubic = True

    @staticmethod
    def order_of(system: System, step: float, tolerance: float, order: int) -> int:
        return 2


@of_python
def _is_stiffly_damped(system: System) -> bool:
    """Return whether a damper acts like a rigid link: c b'M^-1 b >> omega_max.

    Order 8 damps such a motion in every step, order 6 hardly (see above). Only the diagonal of M is used.
    """
    fastest = 0.0
    for element in system.elements:
        fastest += abs(element.spring.tangent(0.0)) * _mobility(system, element)
    for element in system.elements:
        for piece in element.damper.pieces:
            rate = abs(piece.coefficients[1]) + abs(piece.saturation) / piece.scale
            decay = rate * _mobility(system, element)
            if decay * decay > _LINK * _LINK * fastest:
                return True
    return False


@of_python
def _mobility(system: System, element: Element) -> float:
    return sum(b * b / system.mass[i][i] for i, b in enumerate(element.direction))
