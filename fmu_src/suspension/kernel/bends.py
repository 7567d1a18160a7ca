"""The curved forces of the present branches, row by row, with their derivatives."""

from __future__ import annotations

from .layout import BRANCHES, CONTACT, DAMPER, MODULATION, SPRING


class Bends:
    """The rows on which curved springs or dampers act.

    Parameters
    ----------
    network : network of the system
    """

    def __init__(self, network):
        self.net = network
        rows, laws = max(self.net.rows, 1), 2 * self.net.elements
        memory = self.net.memory
        self.count = 0  # of such rows
        self.joined = False  # whether any of their laws consists of joined pieces
        # of each: the number of the row, and the first of its curved laws
        self.row, self.first = memory.marks(rows), memory.marks(rows + 1)
        # of each curved law: its piece, the piece of the modulation, and the kind of law
        self.piece, self.factor = memory.marks(laws), memory.marks(laws)
        self.law = memory.marks(laws)
        # of each curved row, at the state last evaluated
        self.force, self.force_k = memory.zeros(rows), memory.zeros(rows)
        self.force_c = memory.zeros(rows)

    def enter(self):
        """List the curved pieces, row by row."""
        self.count = count = 0
        self.joined = False
        if self.net.always_straight:
            return
        for r in range(self.net.rows):
            first = count
            for e in range(self.net.elements):
                if self.net.element_row[e] != r or self.net.branch[BRANCHES * e + CONTACT]:
                    continue
                if not self.net.spring_is_straight(e):
                    self.piece[count] = self.net.piece_now(e, SPRING)
                    self.law[count] = SPRING
                    count += 1
                if not self.net.damper_is_straight(e):
                    self.piece[count] = self.net.piece_now(e, DAMPER)
                    self.factor[count] = self.net.piece_now(e, MODULATION)
                    self.law[count] = MODULATION if self.net.modulated[e] else DAMPER
                    count += 1
            for k in range(first, count):
                p = self.piece[k]
                if self.net.run_last[p] > self.net.run_first[p]:
                    self.joined = True
            if count > first:
                self.row[self.count], self.first[self.count] = r, first
                self.count += 1
                self.first[self.count] = count

    def find(self, p, d, w):
        """Find the force of curved row p at deflection d and rate w, and its derivatives."""
        force = 0.0
        k = 0.0
        c = 0.0
        for i in range(self.first[p], self.first[p + 1]):
            if self.law[i] == SPRING:
                self.net.law_and_slope(self.piece[i], d)
                force += self.net.value
                k += self.net.slope
                continue
            self.net.law_and_slope(self.piece[i], w)
            if self.law[i] == DAMPER:
                force += self.net.value
                c += self.net.slope
                continue
            damping, slope = self.net.value, self.net.slope
            self.net.law_and_slope(self.factor[i], d)
            force += damping * self.net.value
            c += slope * self.net.value
            k += damping * self.net.slope
        self.force[p], self.force_k[p], self.force_c[p] = force, k, c
