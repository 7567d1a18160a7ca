"""Points of smooth tables: steps end there if the jump of the second derivative of a force matters.

It affects the result of the extrapolation much more than the difference of its columns. A step is
shortened to end just before the point, as what comes after it would spoil the step; its septic is then
continued to the point.
"""

from __future__ import annotations

import cython

from .layout import CONTACT, DAMPER, PIECE, START

if not cython.compiled:
    from math import fabs

_JUMP = 40.0  # largest error of a step in which a second derivative jumps, over the error found
_LIKELY = 0.6  # of the step proposed by the last error; a shorter one may pass points
_LEAST_KNOT = 0.02  # of a step: a point closer to its ends does not matter
_CLOSE_KNOT = 1e-4  # of a step that must be repeated anyway
_SHORT_OF_KNOT = 0.995  # of the way to a point, where a step aims
_NEAR_KNOT = 0.1  # of a step: its septic is continued to a point that is closer
_BEYOND_END = 1e-6  # of a step: so far beyond the end of a table, which is a switch
_COARSE = 6  # order at tolerances for which it is enough to end just before a point


class Knots:
    """The next point of a smooth table.

    Parameters
    ----------
    switches : reads the rows at both ends of an attempt
    """

    def __init__(self, switches):
        self.switches = switches
        self.stepper, self.motion = self.switches.stepper, self.switches.motion
        self.net, self.crossing = self.switches.net, self.switches.crossing
        # the point found last: where the attempt passes it, its value, that of `switches.row` which
        # passes it, and whether the table ends there
        self.at = self.value = 0.0
        self.row = 0
        self.is_end = False

    def ahead(self, h, end):
        """Return the step h, or a shorter one that is expected to end on a point before time `end`."""
        shorter = min(h, end - self.motion.state.time)
        if shorter <= _LIKELY * self.motion.state.proposal:
            return h
        self.motion.foresee(shorter)
        self._find(shorter, _LEAST_KNOT)
        return self._cut(shorter) if self.at < 1.0 - _LEAST_KNOT else h

    def within(self, h):
        """Return the length h of the attempt, or a shorter one to a point that it should end on."""
        most = self.stepper.method.most_error
        if self.stepper.errors.error <= 1.0 / _JUMP:
            return h
        least = _LEAST_KNOT if self.stepper.errors.error <= most else _CLOSE_KNOT
        self._find(h, least)
        return self._cut(h) if self.at < 1.0 - least else h

    def _cut(self, h):
        return _SHORT_OF_KNOT * self.at * h

    def met(self, h):
        """Return the length of the attempt if it is continued to the point found last, or else h.

        The point is found by Newton's method along the Taylor series of the row at the end.
        """
        if self.stepper.method.order <= _COARSE or self.stepper.errors.own_jerks:
            return h
        self.switches.read_attempt(self.motion.state.time, h)
        row, at = self.switches.row, self.row + 4
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
        if self.is_end:
            step += _BEYOND_END * h
        if fabs(step - h) < _NEAR_KNOT * h and self.stepper.errors.can_read(step / h, h):
            return step
        return h

    def _find(self, h, least):
        """Find where the attempt first passes a point of a table, or its end; 2 if it passes none.

        Passages before the fraction `least` do not count.
        """
        self.at = 2.0
        self.switches.read_attempt(self.motion.state.time, h)
        for e in range(self.net.elements):
            for kind in range(CONTACT):
                p = self.net.piece_now(e, kind)
                first, last = self.net.run_first[p], self.net.run_last[p]
                if first == last:
                    continue
                row = 8 * self.net.element_row[e] + (1 if kind == DAMPER else 0)
                k = self.net.place(p, self.switches.row[row])
                degree = self.switches.polynomial(e, kind, h)
                self.crossing.extent(degree)
                for m in range(k, first - 1, -1):
                    at = PIECE * m + START
                    value = self.net.piece[at] if m > first else self.net.low[m]
                    if not self._passes_at_once(value, -1, degree, least, row, m == first):
                        break
                for m in range(k, last + 1):
                    at = PIECE * (m + 1) + START
                    value = self.net.piece[at] if m < last else self.net.high[m]
                    if not self._passes_at_once(value, 1, degree, least, row, m == last):
                        break

    def _passes_at_once(self, value, side, degree, least, row, is_end):
        """Return whether the polynomial of a row passes a point before `least`.

        If it passes the point later, but earlier than others found, the point is stored.
        """
        if not (self.crossing.low < value if side < 0 else self.crossing.high > value):
            return 0
        at = self.crossing.exit(value, side, degree, False)
        if least <= at < self.at:
            self.at, self.value, self.row, self.is_end = at, value, row, is_end
        return at < least
