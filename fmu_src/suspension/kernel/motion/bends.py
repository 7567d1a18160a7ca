"""The curved forces of the present branches, row by row, with their derivatives."""

from __future__ import annotations

from ..language import inline
from ..layout import (
    BRANCHES,
    CONTACT,
    DAMPER,
    LAWS,
    MODULATION,
    OWN,
    PIECE,
    SPRING,
    START,
    UNBOUNDED,
)
from .straight import Straight


class Bends:
    """The rows on which curved springs or dampers act."""

    def __init__(self, straight: Straight) -> None:
        self.straight, self.net = straight, straight.net
        self.elements, self.laws = self.net.elements, self.net.laws
        rows, laws = max(self.elements.rows, 1), LAWS * self.elements.count
        memory = self.net.memory
        self.count = 0  # of such rows
        # whether any of their laws consists of joined pieces, or changes a damper with the deflection
        self.joined = self.modulated = False
        self.order = 3  # of the iteration with the curvatures of all laws; 2 if one is not known
        # of each: the number of the row, and the first of its curved laws
        self.row, self.first = memory.marks(rows), memory.marks(rows + 1)
        # of each curved law: the piece found last, where it begins and ends if others are joined with it,
        # and its kind; a modulation comes before its damper
        self.piece, self.law = memory.marks(laws), memory.marks(laws)
        self.low, self.high = memory.zeros(laws), memory.zeros(laws)
        # of each curved row, at the state last evaluated; literal sizes, as these are C arrays
        self.force, self.force_k, self.force_c = [0.0] * 64, [0.0] * 64, [0.0] * 64
        self.bow = [0.0] * 64  # its second derivative along a line
        # the modulation of the damper that follows, and two derivatives
        self.factor, self.factor_k, self.factor_kk = 1.0, 0.0, 0.0

    def enter(self) -> None:
        """List the curved pieces, row by row."""
        self.count = count = 0
        self.joined = self.modulated = False
        self.order = 3
        if self.net.branches.always_straight:
            return
        for r in range(self.elements.rows):
            first = count
            for e in range(self.elements.count):
                if self.elements.row_of[e] != r or self.elements.branch[BRANCHES * e + CONTACT]:
                    continue
                if self.straight.bent_spring[e]:
                    self.piece[count] = self.elements.piece_now(e, SPRING)
                    self.law[count] = SPRING
                    count += 1
                if self.straight.bent_damper[e]:
                    if self.elements.modulated[e]:
                        self.modulated = True
                        self.piece[count] = self.elements.piece_now(e, MODULATION)
                        self.law[count] = MODULATION
                        count += 1
                    self.piece[count] = self.elements.piece_now(e, DAMPER)
                    self.law[count] = DAMPER
                    count += 1
            for k in range(first, count):
                p = self.piece[k]
                self._bound(k)
                if self.laws.run_last[p] > self.laws.run_first[p]:
                    self.joined = True
                if self.laws.piece[PIECE * p + OWN] != 0.0:
                    self.order = 2
            if count > first:
                self.row[self.count], self.first[self.count] = r, first
                self.count += 1
                self.first[self.count] = count

    def _bound(self, i: int) -> None:
        """Find where the piece of law i begins and ends."""
        p = self.piece[i]
        self.low[i], self.high[i] = -UNBOUNDED, UNBOUNDED
        if p > self.laws.run_first[p]:
            self.low[i] = self.laws.piece[PIECE * p + START]
        if p < self.laws.run_last[p]:
            self.high[i] = self.laws.piece[PIECE * (p + 1) + START]

    @inline
    def find(self, p: int, d: float, w: float, dd: float, dw: float) -> None:
        """Find the force of curved row p at deflection d and rate w, and its derivatives.

        `bow` is the second derivative along a line on which d and w change in proportion to dd and dw.
        """
        self.force[p] = self.force_k[p] = self.force_c[p] = self.bow[p] = 0.0
        for i in range(self.first[p], self.first[p + 1]):
            law = self.law[i]
            x = w if law == DAMPER else d
            if self.joined and not self.low[i] <= x < self.high[i]:
                self.piece[i] = self.laws.place(self.piece[i], x)
                self._bound(i)
            self.laws.read_piece(self.piece[i], x)
            if law == MODULATION:
                self._keep_factor()
                continue
            if law == DAMPER and self.modulated:
                self._modulate(p, dd, dw)
            self.force[p] += self.laws.value
            if law == SPRING:
                self.force_k[p] += self.laws.slope
                self.bow[p] += self.laws.curvature * dd * dd
            else:
                self.force_c[p] += self.laws.slope
                self.bow[p] += self.laws.curvature * dw * dw

    def _keep_factor(self) -> None:
        """Keep the modulation last read, for the damper that follows."""
        self.factor = self.laws.value
        self.factor_k, self.factor_kk = self.laws.slope, self.laws.curvature

    def _modulate(self, p: int, dd: float, dw: float) -> None:
        """Multiply the damper last read by its modulation, and add what follows from that alone."""
        value, slope = self.laws.value, self.laws.slope
        self.force_k[p] += self.factor_k * value
        self.bow[p] += (2.0 * self.factor_k * slope * dw + self.factor_kk * value * dd) * dd
        self.laws.value, self.laws.slope = self.factor * value, self.factor * slope
        self.laws.curvature *= self.factor
        self.factor, self.factor_k, self.factor_kk = 1.0, 0.0, 0.0

    def stays(self, p: int, d: float, w: float) -> bool:
        """Return whether d and w are in the same pieces of row p as those found last."""
        for i in range(self.first[p], self.first[p + 1]):
            x = w if self.law[i] == DAMPER else d
            if not self.low[i] <= x < self.high[i]:
                return False
        return True
