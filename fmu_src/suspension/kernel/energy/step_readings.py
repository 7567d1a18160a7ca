"""The last step read at the points of a quadrature, and the integrals over it from which works follow."""

from __future__ import annotations

from ..language import Doubles
from ..motion.dense import Dense
from ..motion.rows import Rows

_THIRD, _TWO_THIRDS = 1.0 / 3.0, 2.0 / 3.0
POINTS, ENDS = 4, 8  # of the quadrature; numbers at both ends of a step
_POINT = (
    0.06943184420297371239, 0.33000947820757186760, 0.66999052179242813240, 0.93056815579702628761,
)  # fmt: skip
_WEIGHT = (
    0.17392742256872692869, 0.32607257743127307131, 0.32607257743127307131, 0.17392742256872692869,
)  # fmt: skip


class StepReadings:
    """Deflections, rates and signals within the last step."""

    def __init__(self, rows: Rows, dense: Dense) -> None:
        self.rows, self.dense = rows, dense
        self.net, self.row = self.rows.motion.net, self.rows.row
        self.elements, self.signals = self.net.elements, self.net.signals
        memory = self.net.memory
        most, signals = max(self.elements.rows, 1), max(self.signals.count, 1)
        self.point, self.weight = memory.doubles(_POINT), memory.doubles(_WEIGHT)
        # q and h v at the points if, of q, h v, h^2 a and h^3 j at both ends, one is 1 and the others 0
        self.value, self.rate = memory.zeros(POINTS * ENDS), memory.zeros(POINTS * ENDS)
        self._find_factors()
        # of each row: the integrals of its rate w and of w^2 over the step
        self.way, self.square = memory.zeros(most), memory.zeros(most)
        # of each row at the points: deflection, rate; of each signal: value, rate
        self.d, self.w = memory.zeros(POINTS * most), memory.zeros(POINTS * most)
        self.u, self.du = memory.zeros(POINTS * signals), memory.zeros(POINTS * signals)
        # literal, as this is a C array
        self.ends = [0.0] * 8

    def _find_factors(self) -> None:
        """Find `value` and `rate` by reading the interpolant of a step of 1 s."""
        self.dense.start, self.dense.end = 0.0, 1.0
        self._find_factor(self.dense.qa, 0)
        self._find_factor(self.dense.va, 1)
        self._find_factor(self.dense.aa, 2)
        self._find_factor(self.dense.ja, 3)
        self._find_factor(self.dense.qb, 4)
        self._find_factor(self.dense.vb, 5)
        self._find_factor(self.dense.ab, 6)
        self._find_factor(self.dense.jb, 7)
        self.dense.known = False
        self.dense.read(0.0)  # of a step at rest, which leaves no numbers behind
        self.dense.start, self.dense.end, self.dense.known = 0.0, 0.0, False

    def _find_factor(self, end: Doubles, m: int) -> None:
        end[0], self.dense.known = 1.0, False
        for k in range(POINTS):
            self.dense.read(self.point[k])
            self.value[ENDS * k + m], self.rate[ENDS * k + m] = self.dense.q[0], self.dense.v[0]
        end[0] = 0.0

    def read_signals(self, h: float) -> None:
        """Find values and rates of all signals at the points."""
        for k in range(POINTS):
            self.signals.all_signals(self.dense.start + self.point[k] * h)
            for s in range(self.signals.count):
                self.u[POINTS * s + k] = self.signals.road[4 * s]
                self.du[POINTS * s + k] = self.signals.road[4 * s + 1]

    def read_ends(self, direction: Doubles, at: int, h: float) -> None:
        """Set `ends` to displacement and derivatives along a direction at both ends of the step."""
        n = self.net.n
        for k in range(ENDS):
            self.ends[k] = 0.0
        for i in range(n):
            b = direction[at + i]
            if b != 0.0:
                self.ends[0] += b * self.dense.qa[i]
                self.ends[1] += b * self.dense.va[i]
                self.ends[2] += b * self.dense.aa[i]
                self.ends[3] += b * self.dense.ja[i]
                self.ends[4] += b * self.dense.qb[i]
                self.ends[5] += b * self.dense.vb[i]
                self.ends[6] += b * self.dense.ab[i]
                self.ends[7] += b * self.dense.jb[i]
        self._scale_ends(h)

    def _take_ends(self, r: int, h: float) -> None:
        """Set `ends` likewise to those of row r, on a road that does not move."""
        for k in range(ENDS):
            self.ends[k] = self.row[ENDS * r + k]
        self._scale_ends(h)

    def _scale_ends(self, h: float) -> None:
        """Multiply derivatives by powers of h."""
        for k in range(1, 4):
            for m in range(k, 4):
                self.ends[m] *= h
                self.ends[m + 4] *= h

    def read_row(self, r: int, h: float, moving: bool) -> None:
        """Find deflection and rate of a row at the points."""
        s = -1
        if moving:
            s = self.elements.row_signal[r]
            self.read_ends(self.elements.row_direction, self.net.n * r, h)
        else:
            self._take_ends(r, h)
        way = 0.0
        square = 0.0
        for k in range(POINTS):
            d = 0.0
            w = 0.0
            for m in range(ENDS):
                d += self.value[ENDS * k + m] * self.ends[m]
                w += self.rate[ENDS * k + m] * self.ends[m]
            w /= h
            if s >= 0:
                d -= self.u[POINTS * s + k]
                w -= self.du[POINTS * s + k]
            self.d[POINTS * r + k] = d
            self.w[POINTS * r + k] = w
            way += self.weight[k] * w
            square += self.weight[k] * w * w
        self.way[r], self.square[r] = h * way, h * square

    def sum_row(self, r: int, h: float) -> None:
        """Find the integrals of w and w^2 alone, for a row on a road that does not move."""
        if self.dense.cubic:
            self._sum_cubic(r, h)
            return
        self._take_ends(r, h)
        square = 0.0
        for k in range(POINTS):
            w = 0.0
            for m in range(ENDS):
                w += self.rate[ENDS * k + m] * self.ends[m]
            square += self.weight[k] * w * w
        self.way[r], self.square[r] = self.ends[4] - self.ends[0], square / h

    def _sum_cubic(self, r: int, h: float) -> None:
        """Find them for a cubic, whose rate is c1 + c2 x + c3 x^2."""
        at = ENDS * r
        way, c1 = self.row[at + 4] - self.row[at], self.row[at + 1]
        c2, c3 = h * self.row[at + 2], h * self.row[at + 6]
        c3 = 3.0 * (way / h - c1 - 0.5 * c2) if self.dense.to_end else 0.5 * (c3 - c2)
        square = c1 * (c1 + c2 + _TWO_THIRDS * c3) + c2 * (_THIRD * c2 + 0.5 * c3) + 0.2 * c3 * c3
        self.way[r], self.square[r] = way, h * square
