"""Find which element leaves its branch first within an attempted step, and when.

All quantities with a bound in the present branches are watched: a deflection or rate that may reach a
corner, the force of a tyre that may leave the road or meet it again, the gap below a tyre in flight,
the force of sticking. Each is a polynomial through its value and derivatives at both ends of the step.
"""

from __future__ import annotations

from math import fabs

from ..language import Doubles, inline
from ..layout import BRANCHES, CONTACT, DAMPER, FRICTION, MODULATION, SPRING
from ..methods.stepper import Stepper
from ..motion.errors import ROUNDING_OF_RATES
from ..network.elements import KINDS
from ..network.network import SLAVED
from .bernstein import Crossing, reach_of_quintic, reach_of_septic

_NEVER = 1e299  # a larger bound stands for none
_STRETCHES = 8  # of a step, in each of which the force of a tyre in flight is a quintic


class Switches:
    """The watched quantities in the present branches of a stepper's network."""

    def __init__(self, stepper: Stepper) -> None:
        self.stepper = stepper
        self.net = self.stepper.net
        self.elements = self.net.elements
        self.rows, self.row = self.stepper.rows, self.stepper.rows.row
        self.crossing = Crossing()
        most = len(KINDS) * self.elements.count
        memory = self.net.memory
        self.watched = 0
        self.watched_element, self.watched_kind = memory.marks(most), memory.marks(most)
        self.low, self.high = memory.zeros(most), memory.zeros(most)
        # the place of each in `row`, if that and straight forces are all it follows from; otherwise -1
        self.place = memory.marks(most)
        # the longest step for which the coefficients that an end of the attempt sets are within these
        # bounds, as far as is known, s
        self.far_start, self.far_end = memory.zeros(most), memory.zeros(most)
        # four numbers of a row, as in `rows`, at the ends of all parts
        self.point = memory.zeros(4 * (_STRETCHES + 1))
        self.straight = self.stepper.balance.straight
        # fractions of the attempt: the switch found, and the one after it
        self.at = self.next = 2.0
        self.element = self.kind = self.side = 0
        self.across = False  # whether the switch found is the end of a gap
        # whether only the opening of a gap was found, which is watched from there on
        self.only_opens = False
        self.recedes = False

    def enter_branches(self) -> None:
        """List the watched quantities, after a change of branch."""
        self.watched = 0
        self.rows.forget()
        for m in range(self.net.branches.switchable):
            e = self.net.branches.switch_element[m]
            kind = self.net.branches.switch_kind[m]
            # a row that sticks passes no corner, despite rounding
            if kind < CONTACT and self.net.branches.row_stuck[self.elements.row_of[e]]:
                continue
            low = self.net.branches.bound(e, kind, -1)
            high = self.net.branches.bound(e, kind, 1)
            if low > -_NEVER or high < _NEVER:
                k = self.watched
                self.watched_element[k], self.watched_kind[k] = e, kind
                self.low[k], self.high[k] = low, high
                self.place[k] = 8 * self.elements.row_of[e] + (1 if kind == DAMPER else 0)
                if kind == FRICTION or (kind == CONTACT and self.straight.curved[e]):
                    self.place[k] = -1
                self.watched += 1

    def first(self, t: float, h: float) -> float:
        """Return the earliest switch from t to t + h as a fraction of h, or 2 if there is none."""
        self.at = self.next = 2.0
        if self.watched == 0:
            return 2.0
        self.rows.read(t, h)
        for k in range(self.watched):
            e, kind = self.watched_element[k], self.watched_kind[k]
            self.far_end[k] = 0.0
            if kind == CONTACT and self._searches_flight(k, e, h):
                continue
            if self._stays_far(k, e, kind, h):
                continue
            degree = self.polynomial(e, kind, h)
            self.crossing.extent(degree)
            if self.crossing.low < self.low[k]:
                self._search(k, -1, self.low[k], degree, h)
            if self.crossing.high > self.high[k]:
                self._search(k, 1, self.high[k], degree, h)
        return self.at

    def _stays_far(self, k: int, e: int, kind: int, h: float) -> bool:
        """Return whether all coefficients of the polynomial of a watched quantity are within its bounds.

        Each end sets half of them. If the step continues the last one, those of its start have already
        been compared.
        """
        if self.place[k] < 0 or (kind == CONTACT and self._is_slaved(e, h)):
            return False
        if not self._is_far(k, e, kind, 4, h):
            return False
        self.far_end[k] = h
        if self.rows.continues and self.far_start[k] >= h:
            return True
        return self._is_far(k, e, kind, 0, h)

    def _is_far(self, k: int, e: int, kind: int, end: int, h: float) -> bool:
        """Return whether the coefficients that one end sets (0: the start, 4) are within the bounds."""
        at = self.place[k] + end
        x = self.row[at]
        if kind == CONTACT:
            self._contact_force(e, at)
            x = self.elements.force0
            reach = reach_of_quintic(self.elements.force1, self.elements.force2, h)
        elif kind == DAMPER:
            reach = reach_of_quintic(self.row[at + 1], self.row[at + 2], h)
        else:
            reach = reach_of_septic(self.row, at, h)
        return x - reach > self.low[k] and x + reach < self.high[k]

    def carry_on(self) -> None:
        """After the attempt was accepted, take its end as the start of the next one."""
        self.rows.carry_on()
        # copied, not exchanged: a state of a native FMU is a copy of all numbers, and of no addresses
        for k in range(self.watched):
            self.far_start[k] = self.far_end[k]

    def polynomial(self, e: int, kind: int, h: float) -> int:
        """Set the polynomial of a watched quantity over the attempt; return its degree."""
        at = 8 * self.elements.row_of[e]
        if kind in (SPRING, MODULATION):
            self.crossing.hermite7(self.row, at, h)
            return 7
        if kind == CONTACT:
            self._contact_force(e, at)
            f0, f1, f2 = self.elements.force0, self.elements.force1, self.elements.force2
            self._contact_force(e, at + 4)
            e0, e1, e2 = self.elements.force0, self.elements.force1, self.elements.force2
            if self._is_slaved(e, h):
                f1 += self._rate_left(e, self.stepper.motion.j, self.stepper.motion.jerk)
                self.crossing.hermite3(f0, f1, e0, self._end_rate(e, h), h)
                return 3
            self.crossing.hermite5(f0, f1, f2, e0, e1, e2, h)
            return 5
        if kind == FRICTION and self.elements.branch[BRANCHES * e + FRICTION] == 0:
            # the force of sticking
            self.crossing.hermite3(
                self.stepper.motion.multiplier[e], self.stepper.motion.multiplier_rate[e],
                self.net.sticking.multiplier[e], self.net.sticking.multiplier_rate[e], h,
            )  # fmt: skip
            return 3
        self.crossing.hermite5(
            self.row[at + 1], self.row[at + 2], self.row[at + 3],
            self.row[at + 5], self.row[at + 6], self.row[at + 7], h,
        )  # fmt: skip
        return 5

    def _is_slaved(self, e: int, h: float) -> bool:
        """Return whether a tyre on the road stops its masses within a small part of the attempt."""
        if not self.stepper.errors.own_jerks or self.elements.branch[BRANCHES * e + CONTACT]:
            return False
        mobility = self.net.mobility[self.elements.row_of[e]]
        return self.straight.damper_c[e] * mobility * h > SLAVED

    def _rate_left(self, e: int, j: Doubles, jerk: Doubles) -> float:
        """Return by how much the rate of a force differs with the jerks that describe the step.

        M j = p' - sum b f': like the force of a strong damper, its rate is what the others leave for it.
        """
        r = self.elements.row_of[e]
        less = 0.0
        for i in range(self.net.n):
            less += self.elements.row_direction[r * self.net.n + i] * (j[i] - jerk[i])
        return less / self.net.mobility[r]

    def _end_rate(self, e: int, h: float) -> float:
        """Return the rate of the contact force last found, at the end of the attempt."""
        if not self._is_slaved(e, h):
            return self.elements.force1
        return self.elements.force1 + self._rate_left(
            e, self.stepper.motion.jb, self.stepper.motion.end_jerk
        )

    def _left_over(self, e: int, acceleration: float) -> float:
        """Return the force that the others leave for a tyre, minus its own, which has yet to decay.

        It is reduced slightly, by the effect of rounded rates on the force, so that a tyre that has left
        the road does not meet it again at once.
        """
        fastest = 0.0
        for i in range(self.net.n):
            fastest = max(fastest, fabs(self.stepper.motion.vb[i]))
        lost = ROUNDING_OF_RATES * self.straight.damper_c[e] * fastest * self.side
        return acceleration / self.net.mobility[self.elements.row_of[e]] - lost

    @inline
    def _contact_force(self, e: int, at: int) -> None:
        """Find the force as `unlimited_force` does, with fewer operations if all pieces are straight."""
        if self.straight.curved[e]:
            self.elements.unlimited_force(e, self.row, at)
            return
        f = self.straight.spring_f[e] + self.straight.damper_f[e]
        k, c = self.straight.spring_k[e], self.straight.damper_c[e]
        v, a = self.row[at + 1], self.row[at + 2]
        self.elements.force0 = f + k * self.row[at] + c * v
        self.elements.force1 = k * v + c * a
        self.elements.force2 = k * a + c * self.row[at + 3]

    def _search(self, k: int, side: int, bound: float, degree: int, h: float) -> None:
        """Store the first exit over a bound, if it is the earliest."""
        e, kind = self.watched_element[k], self.watched_kind[k]
        returns = self.net.branches.departing[BRANCHES * e + kind] == side
        if returns and kind == SPRING and self._is_within_error(bound, side):
            return
        departing = returns or (
            # exactly on the bound, as at rest; contact and sticking start inside
            self.crossing.bezier[0] == bound
            and kind != CONTACT
            and (kind != FRICTION or self.elements.branch[BRANCHES * e + FRICTION] != 0)
        )
        at = self.crossing.exit(bound, side, degree, departing)
        if self._takes_earliest(k, at, side) and kind == CONTACT and side < 0:
            self._look_for_gap(e, at, h)

    def _is_within_error(self, bound: float, side: int) -> bool:
        """Return whether the quantity last read passes a bound by no more than the error allowed.

        Just after a corner, such a switch would be reversed again and again: an element that hardly moves
        yet may leave the corner on one side by the error of an attempt in the branch of the other side.
        """
        beyond = bound - self.crossing.low if side < 0 else self.crossing.high - bound
        return self.stepper.errors.controlled and beyond <= self.stepper.errors.allowed

    def _look_for_gap(self, e: int, at: float, h: float) -> None:
        """Find whether contact is not regained after all, as a gap has opened by then."""
        self.crossing.hermite7(self.row, 8 * self.elements.row_of[e], h)
        self.only_opens = self.crossing.value(at, 7) > self.net.branches.opening[e]

    def _takes_earliest(self, k: int, at: float, side: int) -> bool:
        """Store an exit if it is earlier than those found so far, and return whether it is.

        A damper and friction along one row have the same rate, so their exits coincide and neither is the
        next one.
        """
        if at >= self.at:
            if at > self.at:
                self.next = min(self.next, at)
            return False
        self.at, self.next = at, self.at
        self.element = self.watched_element[k]
        self.kind = self.watched_kind[k]
        self.side = side
        self.across = self.only_opens = False
        return True

    def _searches_flight(self, k: int, e: int, h: float) -> bool:
        """Search for the end of a flight, and return true, if the force of tyre e does not show it.

        That is while there is a gap below the tyre, or if its law is curved.
        """
        if not self.elements.branch[BRANCHES * e + CONTACT]:
            return False
        if self.row[8 * self.elements.row_of[e]] > self.net.branches.opening[e]:
            self._search_gap(k, h)
            return True
        if self.straight.curved[e]:
            self._search_touchdown(k, h)
            return True
        return False

    def _search_gap(self, k: int, h: float) -> None:
        """Store the time at which a gap closes, if it is the earliest."""
        e = self.watched_element[k]
        bound = self.net.branches.opening[e]
        self.crossing.hermite7(self.row, 8 * self.elements.row_of[e], h)
        self.crossing.extent(7)
        if self.crossing.low < bound:
            departing = self.net.branches.departing[BRANCHES * e + CONTACT] == -1
            at = self.crossing.exit(bound, -1, 7, departing)
            if self._takes_earliest(k, at, -1):
                self.across = True

    def _search_touchdown(self, k: int, h: float) -> None:
        """Store the time at which a tyre in flight presses again by a curved law, if it is the earliest.

        As its force does not act, the error does not keep steps so short that one quintic describes it.
        It is followed in parts.
        """
        e = self.watched_element[k]
        departing = self.net.branches.departing[BRANCHES * e + CONTACT] == -1
        share = 1.0 / _STRETCHES
        self._read_points(self.elements.row_of[e], h, share)
        for m in range(_STRETCHES):
            self.elements.unlimited_force(e, self.point, 4 * m)
            f0, f1, f2 = self.elements.force0, self.elements.force1, self.elements.force2
            self.elements.unlimited_force(e, self.point, 4 * m + 4)
            e0, e1, e2 = self.elements.force0, self.elements.force1, self.elements.force2
            self.crossing.hermite5(f0, f1, f2, e0, e1, e2, h * share)
            at = self.crossing.exit(self.low[k], -1, 5, departing and m == 0)
            if at <= 1.0:
                at = (m + at) * share
                if self._takes_earliest(k, at, -1):
                    self._look_for_gap(e, at, h)
                return

    def _read_points(self, r: int, h: float, share: float) -> None:
        """Read the deflection of row r and three derivatives at the ends of all parts of the attempt."""
        self.crossing.hermite7(self.row, 8 * r, h)
        for order in range(4):
            degree = 7 - order
            for m in range(_STRETCHES + 1):
                self.point[4 * m + order] = self.crossing.value(m * share, degree)
            for i in range(degree):
                rise = self.crossing.bezier[i + 1] - self.crossing.bezier[i]
                self.crossing.bezier[i] = degree * rise / h

    def lateness(self, t: float) -> float:
        """Return by how much the attempt, which ends at t, passed the switch found, s; 0 if unknown.

        `recedes` is set if the watched quantity is still within its branch and moves away from the bound:
        an attempt of that length does not reach it.
        """
        e, kind = self.element, self.kind
        at = 8 * self.elements.row_of[e]
        self.rows.read_end(self.elements.row_of[e], t)
        bound = self.net.branches.bound(e, kind, self.side)
        if self.across:
            value, rate, bound = self.row[at + 4], self.row[at + 5], self.net.branches.opening[e]
        elif kind == CONTACT:
            self.elements.unlimited_force(e, self.row, at + 4)
            value = self.elements.force0
            rate = self._end_rate(e, t - self.stepper.errors.time)
            if self._is_slaved(e, t - self.stepper.errors.time):
                value += self._left_over(e, self.row[at + 6])
        elif kind == FRICTION and self.elements.branch[BRANCHES * e + FRICTION] == 0:
            value, rate = self.net.sticking.multiplier[e], self.net.sticking.multiplier_rate[e]
        else:
            order = 1 if kind in (DAMPER, FRICTION) else 0
            value, rate = self.row[at + 4 + order], self.row[at + 5 + order]
        over = value - bound
        self.miss = fabs(over)
        self.recedes = over * self.side < 0.0 and rate * self.side < 0.0
        return over / rate if rate != 0.0 else 0.0
