"""Find when a quantity, given by its derivatives at both ends of a step, first leaves its bounds.

A polynomial in Bernstein form is between its smallest and largest coefficient, so for most steps it is
enough to compare six or eight numbers; the others need bisection and Newton's method.
"""

from __future__ import annotations

from math import fabs

from ..language import Doubles, inline

_CLOSE = 1e-8  # of a step; Newton's next correction would be of the order of its square
# a motion that has decayed so far is at rest: soon its numbers have no digits left, and random signs
_NOTHING = 1e-290


@inline
def reach_of_septic(x: Doubles, at: int, h: float) -> float:
    """Return how far the coefficients that one end sets are at most from the value there, x[at]."""
    reach = h * 3.0 / 7.0 * fabs(x[at + 1]) + h * h / 14.0 * fabs(x[at + 2])
    return reach + h * h * h / 210.0 * fabs(x[at + 3])


@inline
def reach_of_quintic(dx: float, ddx: float, h: float) -> float:
    """Return how far the coefficients that one end sets are at most from the value there."""
    return 0.4 * h * fabs(dx) + 0.05 * h * h * fabs(ddx)


class Crossing:
    """A Hermite polynomial on (0, 1), and the search for its first exit."""

    def __init__(self) -> None:
        self.bezier, self.casteljau = [0.0] * 8, [0.0] * 8
        self.terms, self.slope_terms = [0.0] * 8, [0.0] * 8
        self.halves = [0.0] * 512
        self.slot_low, self.slot_width = [0.0] * 64, [0.0] * 64

    def hermite7(self, x: Doubles, at: int, h: float) -> None:
        """Set the septic through value and three derivatives at both ends, x[at:] and x[at + 4:]."""
        b = self.bezier
        d1 = h * x[at + 1] / 7.0
        d2 = h * h * x[at + 2] / 42.0
        d3 = h * h * h * x[at + 3] / 210.0
        b[0] = x[at]
        b[1] = x[at] + d1
        b[2] = x[at] + 2.0 * d1 + d2
        b[3] = x[at] + 3.0 * d1 + 3.0 * d2 + d3
        d1 = h * x[at + 5] / 7.0
        d2 = h * h * x[at + 6] / 42.0
        d3 = h * h * h * x[at + 7] / 210.0
        b[7] = x[at + 4]
        b[6] = x[at + 4] - d1
        b[5] = x[at + 4] - 2.0 * d1 + d2
        b[4] = x[at + 4] - 3.0 * d1 + 3.0 * d2 - d3

    def hermite5(
        self, x0: float, dx0: float, ddx0: float, x1: float, dx1: float, ddx1: float, h: float
    ) -> None:
        """Set the quintic through value and two derivatives at both ends."""
        b = self.bezier
        d1 = h * dx0 / 5.0
        d2 = h * h * ddx0 / 20.0
        b[0] = x0
        b[1] = x0 + d1
        b[2] = x0 + 2.0 * d1 + d2
        d1 = h * dx1 / 5.0
        d2 = h * h * ddx1 / 20.0
        b[5] = x1
        b[4] = x1 - d1
        b[3] = x1 - 2.0 * d1 + d2

    def hermite3(self, x0: float, dx0: float, x1: float, dx1: float, h: float) -> None:
        """Set the cubic through value and derivative at both ends."""
        b = self.bezier
        b[0] = x0
        b[1] = x0 + h * dx0 / 3.0
        b[2] = x1 - h * dx1 / 3.0
        b[3] = x1

    def exit(self, bound: float, side: int, degree: int, departing: int) -> float:
        """Return the first fraction of the step at which the polynomial crosses the bound outwards, or 2.

        A branch just entered starts on its bound. That root is divided out, so that even an immediate
        return is found. After a jump of a road's velocity a branch may also start far from its bound.
        """
        c = self.halves
        m = degree
        largest = 0.0
        for i in range(degree + 1):
            c[i] = (self.bezier[i] - bound) * -side
            largest = max(largest, fabs(c[i]))
        if largest < _NOTHING:
            return 2.0
        if departing and fabs(c[0]) <= 1e-3 * largest:
            # a value that has just entered its branch starts exactly on the bound, despite rounding
            start = c[0]
            for i in range(degree + 1):
                c[i] -= start
            # p(s)/s in Bernstein form, repeated while the derivative also vanishes to rounding (a start
            # at rest, friction that has just broken loose, flow that has just ended)
            for _k in range(3):
                largest = 0.0
                for i in range(m):
                    c[i] = c[i + 1] * m / (i + 1)
                    largest = max(largest, fabs(c[i]))
                m -= 1
                if fabs(c[0]) > 1e-9 * largest or largest == 0.0:
                    break
        if c[0] < 0.0:
            return 0.0
        return self.first_root(m)

    def first_root(self, m: int) -> float:
        """Return the first root of the Bernstein polynomial at `halves[0..m]` from positive to negative.

        Bisection (de Casteljau) until one sign change is left, then bracketed Newton. Slot `depth` of
        `halves` holds the current interval, the slots below it the right halves still to be searched.
        """
        c = self.halves
        depth = 0
        self.slot_low[0] = 0.0
        self.slot_width[0] = 1.0
        while depth >= 0:
            at = 8 * depth
            lo = self.slot_low[depth]
            width = self.slot_width[depth]
            changes = 0
            negative = 0
            for i in range(m + 1):
                if c[at + i] < 0.0:
                    negative = 1
                if i > 0 and (c[at + i] < 0.0) != (c[at + i - 1] < 0.0):
                    changes += 1
            if not negative:
                depth -= 1
                continue
            if c[at] < 0.0 or width < 1e-14:
                return lo
            if changes == 1:
                return lo + width * self._single_root(at, m)
            # the right half stays in this slot, the left half goes on top
            width *= 0.5
            top = at + 8
            for i in range(m + 1):
                self.casteljau[i] = c[at + i]
            for k in range(m + 1):
                c[top + k] = self.casteljau[0]
                c[at + m - k] = self.casteljau[m - k]
                for i in range(m - k):
                    self.casteljau[i] = 0.5 * (self.casteljau[i] + self.casteljau[i + 1])
            self.slot_low[depth + 1] = lo
            self.slot_width[depth + 1] = width
            self.slot_low[depth] = lo + width
            self.slot_width[depth] = width
            depth += 1
        return 2.0

    def _single_root(self, at: int, m: int) -> float:
        """Return the only root in (0, 1) of the polynomial at `halves[at..at+m]`, by bracketed Newton.

        Value and slope are sums of c C(m, i) x^i (1 - x)^(m - i), evaluated by Horner's scheme.
        """
        c = self.halves
        b = self.terms
        d = self.slope_terms
        binomial = 1.0
        for i in range(m):
            b[i] = binomial * c[at + i]
            # m C(m - 1, i) = (m - i) C(m, i)
            d[i] = binomial * (m - i) * (c[at + i + 1] - c[at + i])
            binomial *= (m - i) / (i + 1.0)
        b[m] = c[at + m]
        lo = 0.0
        hi = 1.0
        x = c[at] / (c[at] - c[at + m])
        for _iteration in range(60):
            rest = 1.0
            value = b[m]
            slope = 0.0
            for i in range(m - 1, -1, -1):
                slope = slope * x + d[i] * rest
                rest *= 1.0 - x
                value = value * x + b[i] * rest
            if value >= 0.0:
                lo = x
            else:
                hi = x
            new = x - value / slope if slope != 0.0 else 0.5 * (lo + hi)
            if not (lo <= new <= hi):
                new = 0.5 * (lo + hi)
            if fabs(new - x) <= _CLOSE or hi - lo <= 1e-15:
                return new
            x = new
        return x

    def value(self, x: float, degree: int) -> float:
        """Return the polynomial at a fraction x of the step (de Casteljau)."""
        c = self.casteljau
        for i in range(degree + 1):
            c[i] = self.bezier[i]
        for k in range(degree):
            for i in range(degree - k):
                c[i] += x * (c[i + 1] - c[i])
        return c[0]

    def extent(self, degree: int) -> None:
        """Set `low` and `high` to the smallest and largest coefficient."""
        b = self.bezier
        self.low = b[0]
        self.high = b[0]
        for i in range(1, degree + 1):
            if b[i] < self.low:
                self.low = b[i]
            elif b[i] > self.high:
                self.high = b[i]
