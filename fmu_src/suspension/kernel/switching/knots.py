"""Points where smooth pieces meet: steps end there if the jump of a force's second derivative matters.

If the second derivative of an acceleration jumps by J within a step h, the columns integrate it as the
trapezoidal rule does, and the extrapolated velocity is wrong by up to `_MISSED_JUMP` J h^3, much more
than their difference shows. If that is too much, the step is shortened to end just before the point, as
what comes after it would spoil the step; its septic is then continued to the point. Jumps of the third
derivative and the zeros of power laws count as such jumps that grow with the way passed in the step.
"""

from __future__ import annotations

from math import fabs, pow

from ..language import Doubles, inline
from ..layout import CONTACT, DAMPER, LAWS, MODULATION, PIECE, SPRING, START
from ..network.laws import _FARTHEST
from .bernstein import reach_of_quintic, reach_of_septic
from .switches import Switches

# largest sum of w B3(x n) / (6 n^3) over the columns of n substeps with weights w, where the jump is at x
# in the step, and B3 is the periodic Bernoulli polynomial; the same at orders 6 and 8
_MISSED_JUMP = 6.2e-4
_MOST_EFFECT = 0.5  # of a point, over the error allowed; at fine tolerances half of it
_LIKELY = 0.6  # of the step proposed by the last error; a shorter one may pass points
_LEAST_KNOT = 0.02  # of a step: a point closer to its ends does not matter
_CLOSE_KNOT = 1e-4  # of a step that must be repeated anyway
_SHORT_OF_KNOT = 0.995  # of the way to a point, where a step aims
_NEAR_KNOT = 0.1  # of a step: its septic is continued to a point that is closer
_BEYOND_END = 1e-6  # of a step: so far beyond the end of a table, which is a switch
_COARSE = 6  # order at tolerances for which it is enough to end just before a point


class Knots:
    """The next point of a smooth table."""

    def __init__(self, switches: Switches) -> None:
        self.switches = switches
        stepper = self.switches.stepper
        self.motion, self.rows = stepper.motion, stepper.rows
        self.errors, self.method = stepper.errors, stepper.method
        self.net, self.crossing = self.switches.net, self.switches.crossing
        self.elements, self.laws = self.net.elements, self.net.laws
        # the laws of joined pieces, and one piece of each
        self.count, laws = 0, LAWS * self.elements.count
        memory = self.net.memory
        self.element, self.kind = memory.marks(laws), memory.marks(laws)
        self.piece = memory.marks(laws)
        coarse = self.method.order <= _COARSE
        self.most_effect = _MOST_EFFECT if coarse else 0.5 * _MOST_EFFECT
        # where the attempt should end, and whether that is just before a point: its value, that of
        # `rows.row` which passes it, and whether the table ends there
        self.at = self.value = 0.0
        self.row = 0
        self.lands = self.ends_table = False
        # of the piece searched: its end, and whether it is that of the table
        self.bound = 0.0
        self.is_end = False
        self.way = 0.0  # of the argument of a law in the attempt, for its effect

    def enter_branches(self) -> None:
        """List the laws of joined pieces, after a change of branch."""
        self.count = 0
        for e in range(self.elements.count):
            for kind in range(CONTACT):
                p = self.elements.piece_now(e, kind)
                if self.laws.run_last[p] > self.laws.run_first[p]:
                    k = self.count
                    self.element[k], self.kind[k], self.piece[k] = e, kind, p
                    self.count += 1

    def ahead(self, h: float, end: float) -> float:
        """Return the step h, or a shorter one that points before time `end` are expected to allow."""
        shorter = min(h, end - self.motion.state.time)
        if shorter <= _LIKELY * self.motion.state.proposal:
            return h
        self.motion.foresee(shorter)
        self.net.signals.all_signals(self.motion.state.time + shorter)
        self.errors.begin(shorter)
        self._find(shorter, _LEAST_KNOT, self.most_effect)
        return self.at * shorter if self.at < 1.0 else h

    def within(self, h: float) -> float:
        """Return the length h of the attempt, or a shorter one that the points it passes allow."""
        most = self.method.most_error
        least = _LEAST_KNOT if self.errors.error <= most else _CLOSE_KNOT
        self._find(h, least, self.most_effect * most)
        return self.at * h if self.at < 1.0 else h

    def met(self, h: float) -> float:
        """Return the length of the attempt if it is continued to the point found last, or else h.

        The point is found by Newton's method along the Taylor series of the row at the end.
        """
        if not self.lands or self.method.order <= _COARSE or self.errors.own_jerks:
            return h
        self.rows.read(self.motion.state.time, h)
        row, at = self.rows.row, self.row + 4
        third = 0.0 if at % 2 else row[at + 3]  # of a rate it is not known
        way = 0.0
        for _iteration in range(4):
            over = row[at] - self.value
            over += way * (row[at + 1] + way * (row[at + 2] / 2.0 + way * third / 6.0))
            rate = row[at + 1] + way * (row[at + 2] + way * third / 2.0)
            if rate == 0.0:
                return h
            way -= over / rate
        step = h + way
        if self.ends_table:
            step += _BEYOND_END * h
        if fabs(step - h) >= _NEAR_KNOT * h or self._passes_another(step - h):
            return h
        return step if self.errors.can_read(step / h, h) else h

    @inline
    def _argument(self, e: int, kind: int) -> int:
        """Return where `rows.row` has the argument of a law at the start of the attempt."""
        return 8 * self.elements.row_of[e] + (1 if kind == DAMPER else 0)

    def _passes_another(self, way: float) -> bool:
        """Return whether the attempt, continued by `way`, passes a point of another row.

        The jerk at its end would be that beyond the point, and would not describe it.
        """
        row = self.rows.row
        for i in range(self.count):
            at = self._argument(self.element[i], self.kind[i])
            if at == self.row:
                continue
            x = row[at + 4]
            there = x + way * (row[at + 5] + way * row[at + 6] / 2.0)
            if self.laws.place(self.piece[i], x) != self.laws.place(self.piece[i], there):
                return True
        return False

    def _find(self, h: float, least: float, most: float) -> None:
        """Find the fraction of the attempt after which it should end because of points; 2 if nowhere.

        That is the first point, or beyond it, if the points passed have an effect of at most `most` times
        the error allowed in such a step. Passages before the fraction `least` do not count.
        """
        self.at = 2.0
        self.rows.read(self.motion.state.time, h)
        for i in range(self.count):
            e, kind, p = self.element[i], self.kind[i], self.piece[i]
            first, last = self.laws.run_first[p], self.laws.run_last[p]
            row = self._argument(e, kind)
            k = self.laws.place(p, self.rows.row[row])
            if self._stays(k, kind, row, h):
                continue
            degree = self.switches.polynomial(e, kind, h)
            self.crossing.extent(degree)
            unit = -1.0
            for side in range(-1, 2, 2):
                m = k
                while first <= m <= last and self._passes(m, side):
                    if unit < 0.0:
                        unit = self._effect(e, kind, h) / (most * self.errors.allowed)
                    share = self._longest_share(m if side < 0 else m + 1, unit)
                    if share < 1.0 and self._ends(side, degree, least, row, share):
                        break
                    m += side

    @inline
    def _stays(self, p: int, kind: int, at: int, h: float) -> bool:
        """Return whether all coefficients of the argument's polynomial are within piece p.

        This takes fewer operations than to find them.
        """
        low, high = self._end(p, -1), self._end(p, 1)
        row = self.rows.row
        for x in range(at, at + 8, 4):
            if kind == DAMPER:
                reach = reach_of_quintic(row[x + 1], row[x + 2], h)
            else:
                reach = reach_of_septic(row, x, h)
            if not (row[x] - reach > low and row[x] + reach < high):
                return False
        return True

    @inline
    def _end(self, p: int, side: int) -> float:
        """Return where piece p ends on a side."""
        if self._is_last(p, side):
            return self.laws.low[p] if side < 0 else self.laws.high[p]
        return self.laws.piece[PIECE * (p if side < 0 else p + 1) + START]

    @inline
    def _is_last(self, p: int, side: int) -> bool:
        """Return whether no piece is joined with p on a side."""
        return p == (self.laws.run_first[p] if side < 0 else self.laws.run_last[p])

    @inline
    def _passes(self, p: int, side: int) -> bool:
        """Find the end of piece p; return whether the polynomial may pass it."""
        self.bound, self.is_end = self._end(p, side), self._is_last(p, side)
        return self.crossing.low < self.bound if side < 0 else self.crossing.high > self.bound

    def _effect(self, e: int, kind: int, h: float) -> float:
        """Return the error that the attempt makes where the second derivative of a law jumps by 1, m."""
        n, r = self.net.n, self.elements.row_of[e]
        row, at = self.rows.row, self._argument(e, kind)
        rate = max(fabs(row[at + 1]), fabs(row[at + 5]), fabs(row[at + 4] - row[at]) / h)
        self.way = rate * h
        most = 0.0
        for i in range(n):
            response = fabs(self.elements.row_response[n * r + i])
            most = max(most, response * self.errors.velocity_scale[i])
        if self.elements.modulated[e]:
            most *= self._factor(e, kind, row, 8 * r)
        return _MISSED_JUMP * h * h * h * rate * rate * most

    def _longest_share(self, p: int, unit: float) -> float:
        """Return the part of the attempt that may be stepped across the beginning of piece p; 1 for all.

        `unit` is the effect of a jump of the second derivative by 1, over the one allowed.
        """
        size = unit * self.laws.jump[p]
        root = 3.0
        if unit > 0.0 and self.laws.rough[p] > 0.0:
            growth = self.laws.growth[p]
            rough = unit * self.laws.rough[p] * pow(min(self.way, _FARTHEST), growth)
            if rough > size:
                root += growth
            size += rough
        return pow(size, -1.0 / root) if size > 1.0 else 1.0

    def _factor(self, e: int, kind: int, row: Doubles, at: int) -> float:
        """Return the larger of the factors of a modulated damper's law at both ends of the attempt."""
        if kind == SPRING:
            return 1.0
        other = self.elements.piece_now(e, MODULATION if kind == DAMPER else DAMPER)
        at += 1 if kind == MODULATION else 0
        start = self.laws.law(other, row[at])
        return max(fabs(start), fabs(self.laws.law(other, row[at + 4])))

    def _ends(self, side: int, degree: int, least: float, row: int, share: float) -> bool:
        """Let the attempt end on the point in `bound`, or beyond it, if it passes it after `least`.

        A part of the attempt no longer than `share` may pass it. Return whether points that are passed
        later make no difference.
        """
        at = self.crossing.exit(self.bound, side, degree, False)
        if not least <= at < 1.0 - least:
            return at >= 1.0 - least
        end = _SHORT_OF_KNOT * max(at, share)
        if end < self.at:
            self.at = end
            self.lands = end == _SHORT_OF_KNOT * at
            self.value, self.row, self.ends_table = self.bound, row, self.is_end
        return _SHORT_OF_KNOT * at >= self.at
