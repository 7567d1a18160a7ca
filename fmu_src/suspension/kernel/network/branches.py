"""How elements change their branches: bounds, sticking, contact, flow, and the branches of a step.

The branches of a step are stored (`keep_branches`), so that results within it can be found after they
have changed (`exchange_branches`).
"""

from __future__ import annotations

from math import fabs

from ..arrays import Memory
from ..language import Doubles
from ..layout import (
    BRANCHES,
    C0,
    C1,
    CONTACT,
    DAMPER,
    FRICTION,
    LAWS,
    MODULATION,
    ORIGIN,
    PIECE,
    SPRING,
    START,
    UNBOUNDED,
)
from ..state import KernelState
from .elements import ELASTIC, Elements

_CREEP = 1e-10  # 1/s; times the scale of the motion, the slip rate that counts as rest


class Branches:
    """The bounds of the elements' branches, and which branches have just changed."""

    laws_size: int

    def __init__(self, memory: Memory, state: KernelState, elements: Elements) -> None:
        self.state, self.elements = state, elements
        self.laws, self.signals = self.elements.laws, self.elements.signals
        count = self.elements.count
        self.laws_size = 0  # count of the numbers that `enter_elements` has read
        kinds = BRANCHES * count
        kept = self.state.memory
        self.opening = memory.zeros(count)  # deflection beyond which there is a gap
        self.breakaway = memory.zeros(count)  # largest force of friction while it sticks
        self.initial_set = memory.zeros(count)
        self.departing = kept.marks(kinds)
        self.stuck = 0
        self.stuck_element, self.row_stuck = memory.marks(count), memory.marks(self.elements.rows)
        self.kept_branch = kept.marks(kinds)
        self.kept_set = kept.zeros(count)
        self.kept_signal = kept.marks(max(self.signals.count, 1))
        self.switch_element, self.switch_kind = memory.marks(kinds), memory.marks(kinds)

    def forget_branches(self) -> None:
        """Reset all branches to the state before any motion."""
        for s in range(self.signals.count):
            self.signals.signal_now[s] = self.kept_signal[s] = 0
        for e in range(self.elements.count):
            self.kept_set[e] = 0.0
        for k in range(BRANCHES * self.elements.count):
            self.elements.branch[k] = self.departing[k] = self.kept_branch[k] = 0
        self.stuck = 0
        self.state.exchange = 0.0

    def enter_elements(self, x: Doubles, at: int) -> int:
        """Read all elements from x[at:], as given by `element_numbers`; return where they end."""
        first = at
        for e in range(self.elements.count):
            at = self.elements.enter_element(e, x, at)
            self.initial_set[e] = x[at]
            self.opening[e] = x[at + 1]
            self.breakaway[e] = x[at + 2]
            at += 3
        self.laws_size = at - first
        self.list_switchable()
        return at

    def list_switchable(self) -> None:
        """List the branches that can change, and find whether all forces are straight in every branch."""
        self.switchable = 0
        self.always_straight = True
        for e in range(self.elements.count):
            for kind in range(BRANCHES):
                if kind == CONTACT:
                    several = self.elements.limit[e] < UNBOUNDED
                elif kind == FRICTION:
                    several = self.elements.friction[e] > 0.0
                else:
                    # flow ends where the rate changes sign
                    first = self.laws.first[LAWS * e + kind]
                    last = first + self.laws.pieces[LAWS * e + kind] - 1
                    several = self.laws.run_last[first] < last or (
                        kind == DAMPER and self.elements.yields[e] != 0
                    )
                if several:
                    self.switch_element[self.switchable] = e
                    self.switch_kind[self.switchable] = kind
                    self.switchable += 1
            for p in range(self.laws.first[LAWS * e], self.laws.first[LAWS * (e + 1)]):
                if not self.laws.straight[p]:
                    self.always_straight = False
            if self.elements.modulated[e]:
                self.always_straight = False

    # -- changes --------------------------------------------------------------------------------------

    def bound(self, e: int, kind: int, side: int) -> float:
        """Return the value at which element e leaves its branch downwards (side -1) or upwards (+1)."""
        now = self.elements.branch[BRANCHES * e + kind]
        if kind == CONTACT:
            if now:
                return self.elements.limit[e] if side < 0 else UNBOUNDED
            return self.elements.limit[e] if side > 0 else -UNBOUNDED
        if kind == FRICTION:
            if now == 0:
                return side * self.breakaway[e]
            return 0.0 if now == -side else side * UNBOUNDED
        if self.elements.yields[e] and kind != MODULATION:
            spring = self.elements.branch[BRANCHES * e + SPRING]
            if kind == DAMPER or spring != ELASTIC:
                # flow upwards ends when the rate falls to zero, flow downwards when it rises to zero
                if kind == DAMPER and spring == ELASTIC - side:
                    return 0.0
                return side * UNBOUNDED
        law = LAWS * e + kind
        p, end = self.laws.first[law] + now, self.laws.first[law] + self.laws.pieces[law]
        if side < 0:
            return self.laws.piece[p * PIECE + START] if now > 0 else -UNBOUNDED
        above = self.laws.run_last[p] + 1
        return self.laws.piece[above * PIECE + START] if above < end else UNBOUNDED

    def enter(self, e: int, kind: int, side: int, t: float, q: Doubles, v: Doubles) -> int:
        """Move element e to its neighbouring branch; return the number of the new branch."""
        at = BRANCHES * e + kind
        if self.elements.yields[e] and kind == DAMPER:
            self.signals.all_signals(t)
            self.elements.row_states(q, v)
            self._unload(e, self.elements.row_d[self.elements.row_of[e]])
            self.departing[at] = 0
            self.departing[BRANCHES * e + SPRING] = -side
            return ELASTIC
        if kind == FRICTION:
            # an element that stops slipping sticks, even if only for an instant, unless it has already
            # slipped back a little in a long step
            self.signals.all_signals(t)
            self.elements.row_states(q, v)
            back = self.elements.row_v[self.elements.row_of[e]] * side > _CREEP * self.state.scale
            self.elements.branch[at] = side if self.elements.branch[at] == 0 or back else 0
            self.list_stuck()
            self.departing[at] = -side if self.elements.branch[at] != 0 and not back else 0
            return self.elements.branch[at]
        if kind == CONTACT:
            self.elements.branch[at] = 1 if side > 0 else 0
            self.book_exchange(e, t, q, v)
        else:
            first = self.laws.first[LAWS * e + kind]
            p = first + self.elements.branch[at]
            # values that are not finite would otherwise lead beyond the last piece
            if side > 0:
                p = min(self.laws.run_last[p] + 1, first + self.laws.pieces[LAWS * e + kind] - 1)
            elif p > first:
                p = self.laws.run_first[p - 1]
            self.elements.branch[at] = p - first
        self.departing[at] = -side
        return self.elements.branch[at]

    def locate_branches(self, t: float, q: Doubles, v: Doubles) -> None:
        """Choose every branch by the present state; at a corner the upper piece, until the next step."""
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        branch = self.elements.branch
        for e in range(self.elements.count):
            d = self.elements.row_d[self.elements.row_of[e]]
            w = self.elements.row_v[self.elements.row_of[e]]
            at = BRANCHES * e
            if not self.elements.yields[e]:  # otherwise it depends on the history
                branch[at + SPRING] = self.laws.piece_at(LAWS * e + SPRING, d)
            branch[at + DAMPER] = self.laws.piece_at(LAWS * e + DAMPER, w)
            branch[at + MODULATION] = self.laws.piece_at(LAWS * e + MODULATION, d)
            if self.elements.limit[e] < UNBOUNDED:
                force = self.laws.law(self.elements.piece_now(e, SPRING), d)
                force += self.elements.damper_force(e)
                off = force > self.elements.limit[e] or d > self.opening[e]
                branch[at + CONTACT] = 1 if off else 0
            if self.elements.friction[e] > 0.0:
                self._follow_slip(e, w)
        self.list_stuck()
        self.mark_bounds()

    def follow(self, t: float, q: Doubles, v: Doubles) -> None:
        """Choose the branches of the next step by the state at its start, without locating a switch."""
        self.locate_branches(t, q, v)
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                d = self.elements.row_d[self.elements.row_of[e]]
                w = self.elements.row_v[self.elements.row_of[e]]
                at = BRANCHES * e + SPRING
                if self.elements.branch[at] != ELASTIC:
                    if w * (self.elements.branch[at] - ELASTIC) < 0.0:
                        self._unload(e, d)
                elif d > self.bound(e, SPRING, 1):
                    self.elements.branch[at] = ELASTIC + 1
                elif d < self.bound(e, SPRING, -1):
                    self.elements.branch[at] = ELASTIC - 1

    def mark_bounds(self) -> None:
        """Mark the variables that are exactly on a bound of their branch, as they often are at rest."""
        for k in range(self.switchable):
            e = self.switch_element[k]
            kind = self.switch_kind[k]
            r = self.elements.row_of[e]
            x = UNBOUNDED  # contact is never marked: it starts inside
            if kind in (SPRING, MODULATION):
                x = self.elements.row_d[r]
            elif kind == DAMPER or (
                kind == FRICTION and self.elements.branch[BRANCHES * e + FRICTION] != 0
            ):
                x = self.elements.row_v[r]
            mark = 0
            if x < UNBOUNDED and x == self.bound(e, kind, -1):
                mark = -1
            elif x < UNBOUNDED and x == self.bound(e, kind, 1):
                mark = 1
            self.departing[BRANCHES * e + kind] = mark

    def clear_marks(self) -> None:
        """Clear all marks of variables on their bounds."""
        for k in range(self.switchable):
            self.departing[BRANCHES * self.switch_element[k] + self.switch_kind[k]] = 0

    def book_exchange(self, e: int, t: float, q: Doubles, v: Doubles) -> None:
        """Book the jump of a tyre's potential when it leaves the road or meets it again.

        A damped tyre does so at a deflection other than its free length; the difference is neither
        stored nor dissipated, and has its own entry in the balance.
        """
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        d = self.elements.row_d[self.elements.row_of[e]]
        change = self.elements.free_potential(e, d)
        change -= self.laws.potential(self.elements.piece_now(e, SPRING), d)
        self.state.exchange += change if self.elements.branch[BRANCHES * e + CONTACT] else -change

    # -- sticking -------------------------------------------------------------------------------------

    def list_stuck(self) -> None:
        """List the elements that stick, and mark the rows whose deflection they hold."""
        self.stuck = 0
        for r in range(self.elements.rows):
            self.row_stuck[r] = 0
        for e in range(self.elements.count):
            slips = self.elements.branch[BRANCHES * e + FRICTION] != 0
            if self.elements.friction[e] > 0.0 and not slips:
                self.stuck_element[self.stuck] = e
                self.stuck += 1
                self.row_stuck[self.elements.row_of[e]] = 1

    def follow_slips(self, t: float, q: Doubles, v: Doubles) -> None:
        """Update sticking and the direction of slip after a jump of a road's rate."""
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        for k in range(self.switchable):
            if self.switch_kind[k] == FRICTION:
                e = self.switch_element[k]
                self._follow_slip(e, self.elements.row_v[self.elements.row_of[e]])
        self.list_stuck()

    def _follow_slip(self, e: int, w: float) -> None:
        at = BRANCHES * e + FRICTION
        if self.elements.branch[at] != 0 or fabs(w) > _CREEP * self.state.scale:
            self.elements.branch[at] = 1 if w > 0.0 else (-1 if w < 0.0 else 0)

    # -- yield ----------------------------------------------------------------------------------------

    def settle(self, t: float, q: Doubles, v: Doubles) -> None:
        """Set the initial permanent sets; an element that starts beyond its yield force has flowed."""
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                d = self.elements.row_d[self.elements.row_of[e]]
                self.elements.branch[BRANCHES * e + SPRING] = ELASTIC
                self.move_set(e, self.initial_set[e])
                for side in range(-1, 2, 2):
                    if (d - self.bound(e, SPRING, side)) * side > 0.0:
                        self.elements.branch[BRANCHES * e + SPRING] = ELASTIC + side
                        self._unload(e, d)

    def present_set(self, e: int) -> float:
        """Return the permanent set of element e, where its elastic piece has no force."""
        return self.laws.piece[(self.laws.first[LAWS * e] + ELASTIC) * PIECE + ORIGIN]

    def move_set(self, e: int, permanent_set: float) -> None:
        """Move the elastic piece: its zero and its ends on the two lines of flow."""
        piece, at = self.laws.piece, (self.laws.first[LAWS * e] + ELASTIC) * PIECE
        above = at + PIECE
        rate, flow, line = self.elements.elastic_rate(e), piece[above + C1], piece[above + C0]
        piece[at + ORIGIN] = permanent_set
        piece[at + START] = (rate * permanent_set - line) / (rate - flow)
        piece[above + START] = (rate * permanent_set + line) / (rate - flow)

    def _unload(self, e: int, d: float) -> None:
        """End the flow at deflection d: the element is elastic again, with its new permanent set."""
        self.move_set(e, self.elements.permanent_set(e, d))
        self.elements.branch[BRANCHES * e + SPRING] = ELASTIC

    # -- the branches of the last step ----------------------------------------------------------------

    def keep_branches(self) -> None:
        """Store the present branches before they change at the end of a step."""
        for s in range(self.signals.count):
            self.kept_signal[s] = self.signals.signal_now[s]
        for k in range(self.switchable):
            at = BRANCHES * self.switch_element[k] + self.switch_kind[k]
            self.kept_branch[at] = self.elements.branch[at]
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                self.kept_set[e] = self.present_set(e)

    def exchange_branches(self) -> None:
        """Exchange the present branches for the stored ones; a second call reverses it."""
        for s in range(self.signals.count):
            now = self.signals.signal_now[s]
            self.signals.signal_now[s] = self.kept_signal[s]
            self.kept_signal[s] = now
        for k in range(self.switchable):
            at = BRANCHES * self.switch_element[k] + self.switch_kind[k]
            now = self.elements.branch[at]
            self.elements.branch[at] = self.kept_branch[at]
            self.kept_branch[at] = now
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                permanent_set = self.present_set(e)
                self.move_set(e, self.kept_set[e])
                self.kept_set[e] = permanent_set
        self.list_stuck()
