"""The energy ledger: the energy dissipated by elements and the work of roads and loads, step by step.

The powers are integrated over the dense output of each step by four-point Gauss-Legendre quadrature,
which has the order of that output, 8. Deflection and rate of a row at the four points are sums over its
value and derivatives at both ends of the step. With a straight damper, f + c w, the work in a step is
f times the integral of w plus c times that of w^2, for all elements of a row from the same two numbers.
While roads stand still these two follow from the ends alone, as does the energy of straight springs.
"""

from __future__ import annotations

from functools import cache

import cython

if not cython.compiled:
    from math import fabs

_SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION, _KINDS = 0, 1, 2, 3, 4, 5  # as in elements
_ELASTIC = 1
_POINTS, _ENDS = 4, 8  # of the quadrature; numbers at both ends of a step
_TIMES = 2.0  # times the energy accounted for
_LEAST = 1e-9  # J, which rounding alone may cause
_POINT = (
    0.06943184420297371239, 0.33000947820757186760, 0.66999052179242813240, 0.93056815579702628761,
)  # fmt: skip
_WEIGHT = (
    0.17392742256872692869, 0.32607257743127307131, 0.32607257743127307131, 0.17392742256872692869,
)  # fmt: skip


class Ledger:
    """Works so far, J: dissipated by each element, done by each signal as a road or a load.

    Parameters
    ----------
    balance : equation of motion of the present branches
    dense : dense output of the last step
    """

    def __init__(self, balance, dense):
        self.balance, self.dense = balance, dense
        self.net = self.balance.net
        elements, rows = self.net.elements, max(self.net.rows, 1)
        self.works = elements + self.net.signals
        memory = self.net.memory
        # so far; what jumps of roads have brought in since the last step; in a part of that step
        self.state = self.net.state
        kept = self.state.memory
        self.work, self.brought = kept.zeros(self.works), kept.zeros(self.works)
        self.part = memory.zeros(self.works)
        # the entries at the time looked at last: kinetic energy, energy of each element, works until then
        self.kinetic = 0.0
        self.kept, self.until = memory.zeros(elements), memory.zeros(self.works)
        self.scratch = memory.zeros(self.net.n)
        self.point, self.weight = memory.doubles(_POINT), memory.doubles(_WEIGHT)
        value, rate = _readings(self.dense.cubic, self.dense.to_end)
        self.value, self.rate = memory.doubles(value), memory.doubles(rate)
        # of each element: force at rest and damping of what dissipates, and whether it is curved
        self.loss, self.loss_rate = memory.zeros(elements), memory.zeros(elements)
        self.curved = memory.marks(elements)
        # of each row: whether it dissipates, and by a curved law; the integrals of w and w^2 over a step
        self.lossy, self.needs_points = memory.marks(rows), memory.marks(rows)
        self.way, self.square = memory.zeros(rows), memory.zeros(rows)
        # the energy that it stores, e0 + e1 d + e2 d^2; or whether that is the sum of its elements
        self.e0, self.e1, self.e2 = memory.zeros(rows), memory.zeros(rows), memory.zeros(rows)
        self.by_element = memory.marks(rows)
        # of each row at the points: deflection, rate; of each signal: value, rate
        self.d, self.w = memory.zeros(_POINTS * rows), memory.zeros(_POINTS * rows)
        signals = max(self.net.signals, 1)
        self.u, self.du = memory.zeros(_POINTS * signals), memory.zeros(_POINTS * signals)
        self.ends = [0.0] * 8  # literal, as this is a C array
        self.start()

    def start(self):
        """Reset all works to zero."""
        # energy that roads and loads have moved in or out, all counted as positive
        self.state.supplied = self.state.most_stored = 0.0
        self.state.residual_start = self.state.residual_end = 0.0
        for i in range(self.works):
            self.work[i] = self.brought[i] = 0.0

    def enter(self):
        """Read what dissipates and what stores energy in the present branches."""
        for r in range(self.net.rows):
            self.lossy[r] = self.needs_points[r] = self.by_element[r] = 0
            self.e0[r] = self.e1[r] = self.e2[r] = 0.0
        for e in range(self.net.elements):
            self._enter_energy(e)
            at = _KINDS * e
            f = self.net.branch[at + _FRICTION] * self.net.friction[e]
            c = 0.0
            self.curved[e] = 0
            if not self.net.branch[at + _CONTACT]:
                if self.net.damper_is_straight(e):
                    p = self.net.piece_now(e, _DAMPER)
                    factor = 1.0
                    if self.net.modulated[e]:
                        factor = self.net.law(self.net.piece_now(e, _MODULATION), 0.0)
                    f += factor * self.net.intercept(p)
                    c = factor * self.net.law_slope(p, 0.0)
                else:
                    self.curved[e] = 1
                if self.net.yields[e] and self.net.branch[at + _SPRING] != _ELASTIC:
                    f += self.net.flow_force(e)
            self.loss[e], self.loss_rate[e] = f, c
            if self.curved[e]:
                self.needs_points[self.net.element_row[e]] = 1
            if f != 0.0 or c != 0.0:
                self.lossy[self.net.element_row[e]] = 1

    def _enter_energy(self, e):
        """Add the potential of element e to that of its row, if it is a parabola."""
        r = self.net.element_row[e]
        if self.net.branch[_KINDS * e + _CONTACT]:
            self.e0[r] += self.net.free_potential(e, 0.0)
            self.e1[r] += self.net.limit[e]
        elif self.net.yields[e] or not self.net.spring_is_straight(e):
            self.by_element[r] = 1
        else:
            p = self.net.piece_now(e, _SPRING)
            k = self.net.law_slope(p, 0.0)
            self.e0[r] += self.net.potential(p, 0.0)
            self.e1[r] += self.net.intercept(p)
            self.e2[r] += 0.5 * k

    def book(self):
        """Add the works of the last step, with the branches of that step."""
        h = self.dense.end - self.dense.start
        for i in range(self.net.elements, self.works):
            self.brought[i] = 0.0
        if h <= 0.0:
            return
        moving = not self.net.still()
        if moving and self.net.stuck:
            self._book_points()
            return
        if moving:
            self._read_signals(h)
        else:
            self.net.all_signals(self.dense.end)
        for r in range(self.net.rows):
            if moving or self.needs_points[r]:
                self._read_row(r, h, moving)
            elif self.lossy[r]:
                self._sum_row(r, h)
        for e in range(self.net.elements):
            self._book_element(e, h)
        if moving:
            for r in range(self.net.rows):
                if self.net.row_signal[r] >= 0:
                    self._book_road(r, h)
        for m in range(self.net.loads):
            self._book_load(m, h, moving)

    def _read_signals(self, h):
        """Find values and rates of all signals at the points."""
        for k in range(_POINTS):
            self.net.all_signals(self.dense.start + self.point[k] * h)
            for s in range(self.net.signals):
                self.u[_POINTS * s + k] = self.net.road[4 * s]
                self.du[_POINTS * s + k] = self.net.road[4 * s + 1]

    def _read_ends(self, direction, at, h):
        """Set `ends` to displacement and derivatives along a direction at both ends of the step."""
        n = self.net.n
        for k in range(_ENDS):
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
        for k in range(1, 4):
            for m in range(k, 4):
                self.ends[m] *= h
                self.ends[m + 4] *= h

    def _read_row(self, r, h, moving):
        """Find deflection and rate of a row at the points."""
        self._read_ends(self.net.row_direction, self.net.n * r, h)
        s = self.net.row_signal[r]
        way = 0.0
        square = 0.0
        for k in range(_POINTS):
            d = 0.0
            w = 0.0
            for m in range(_ENDS):
                d += self.value[_ENDS * k + m] * self.ends[m]
                w += self.rate[_ENDS * k + m] * self.ends[m]
            w /= h
            if s >= 0 and moving:
                d -= self.u[_POINTS * s + k]
                w -= self.du[_POINTS * s + k]
            elif s >= 0:
                d -= self.net.road[4 * s]
            self.d[_POINTS * r + k] = d
            self.w[_POINTS * r + k] = w
            way += self.weight[k] * w
            square += self.weight[k] * w * w
        self.way[r], self.square[r] = h * way, h * square

    def _sum_row(self, r, h):
        """Find the integrals of w and w^2 alone, of a row on a road that stands still."""
        self._read_ends(self.net.row_direction, self.net.n * r, h)
        self.way[r] = self.ends[4] - self.ends[0]
        square = 0.0
        if self.dense.cubic:
            c1, c2, c3 = self.ends[1], self.ends[2], 0.5 * (self.ends[6] - self.ends[2])
            if self.dense.to_end:
                c3 = 3.0 * (self.way[r] - c1 - 0.5 * c2)
            # of c1 + c2 x + c3 x^2
            square = c1 * (c1 + c2 + c3 / 1.5) + c2 * (c2 / 3.0 + 0.5 * c3) + 0.2 * c3 * c3
        else:
            for k in range(_POINTS):
                w = 0.0
                for m in range(_ENDS):
                    w += self.rate[_ENDS * k + m] * self.ends[m]
                square += self.weight[k] * w * w
        self.square[r] = square / h

    def _book_element(self, e, h):
        """Add what element e has dissipated."""
        f, c = self.loss[e], self.loss_rate[e]
        if f == 0.0 and c == 0.0 and not self.curved[e]:
            return
        r = self.net.element_row[e]
        work = f * self.way[r] + c * self.square[r]
        if self.curved[e]:
            for k in range(_POINTS):
                w = self.w[_POINTS * r + k]
                force = self.net.damper_force_at(e, self.d[_POINTS * r + k], w)
                work += self.weight[k] * h * force * w
        self.work[e] += work
        if work < 0.0:
            self.state.supplied -= work

    def _book_road(self, r, h):
        """Add the work of the road under row r."""
        s = self.net.row_signal[r]
        bent = -1
        for p in range(self.balance.bends):
            if self.balance.bent_row[p] == r:
                bent = p
        for k in range(_POINTS):
            rate = self.du[_POINTS * s + k]
            if rate != 0.0:
                d, w = self.d[_POINTS * r + k], self.w[_POINTS * r + k]
                force = self.net.branch_f[r] + self.net.branch_k[r] * d + self.net.branch_c[r] * w
                if bent >= 0:
                    self.balance.bend(bent, d, w)
                    force += self.balance.force[bent]
                self._supply(s, -self.weight[k] * h * force * rate)

    def _book_load(self, m, h, moving):
        """Add the work of load m."""
        s = self.net.load_signal[m]
        if not moving and self.net.road[4 * s] == 0.0:
            return
        self._read_ends(self.net.load_direction, self.net.n * m, h)
        if not moving:
            self._supply(s, self.net.road[4 * s] * (self.ends[4] - self.ends[0]))
            return
        for k in range(_POINTS):
            way = 0.0
            for i in range(_ENDS):
                way += self.rate[_ENDS * k + i] * self.ends[i]
            self._supply(s, self.weight[k] * self.u[_POINTS * s + k] * way)

    def _book_points(self):
        """Add the works point by point, with the forces of sticking rows on moving roads."""
        self.find_part(self.dense.start)
        for i in range(self.works):
            if i >= self.net.elements:
                self._supply(i - self.net.elements, self.part[i])
            else:
                self.work[i] += self.part[i]

    def find_part(self, since):
        """Find the works from a time within the last step to its end, in the present branches."""
        h = self.dense.end - since
        for i in range(self.works):
            self.part[i] = 0.0
        for k in range(_POINTS):
            t = since + self.point[k] * h
            self.dense.read(t)
            self.net.all_signals(t)
            self.net.row_states(self.dense.q, self.dense.v)
            self.net.row_forces()
            self.net.accelerate(self.scratch)
            self.net.hold(self.net.multiplier)
            weight = self.weight[k] * h
            for e in range(self.net.elements):
                self.part[e] += weight * self.net.dissipation(e)
            for r in range(self.net.rows):
                s = self.net.row_signal[r]
                if s >= 0:
                    power = -self.net.row_f[r] * self.net.road[4 * s + 1]
                    self.part[self.net.elements + s] += weight * power
            for m in range(self.net.loads):
                w = 0.0
                for i in range(self.net.n):
                    w += self.net.load_direction[m * self.net.n + i] * self.dense.v[i]
                s = self.net.load_signal[m]
                self.part[self.net.elements + s] += weight * self.net.road[4 * s] * w

    def take_stock(self, q, v):
        """Find the kinetic energy and what each element stores, in a state on the present roads."""
        self.net.row_states(q, v)
        self.kinetic = self.net.energy(v)
        for e in range(self.net.elements):
            self.kept[e] = self.net.element_energy(e, self.net.row_d[self.net.element_row[e]])
            self.kinetic -= self.kept[e]

    def _supply(self, signal, energy):
        self.work[self.net.elements + signal] += energy
        self.state.supplied += fabs(energy)

    def bring_in(self, signal, energy):
        """Add the work of a jump of a road, J."""
        self.brought[self.net.elements + signal] += energy
        self._supply(signal, energy)

    def lose(self, e, energy):
        """Add what element e dissipates as its road jumps, J."""
        self.work[e] += energy

    def grows(self):
        """Return whether the stored energy is far more than the initial energy and all energy supplied.

        Only roads, loads and driving dampers can add energy; the exchange at contact switches has its
        own entry. A correct run never reaches twice that sum, as energy supplied still counts after it
        has left the system; with unstable steps the energy soon exceeds it.
        """
        return (
            self.stored > _TIMES * (fabs(self.state.initial_energy) + self.state.supplied) + _LEAST
        )

    def is_out_of_balance(self):
        """Return whether the residual exceeds all energy ever stored or supplied: the run is wrong."""
        most = max(self.state.most_stored, self.state.supplied) + fabs(self.state.initial_energy)
        return fabs(self.state.residual_end) > most + _LEAST

    def strike_balance(self, t, q, v):
        """Find T + U + dissipated - supplied - exchanged at contact switches - initial: 0 if exact."""
        self.net.all_signals(t)
        self.stored = self._energy(q, v) - self.state.exchange
        self.state.most_stored = max(self.state.most_stored, fabs(self.stored))
        balance = self.stored - self.state.initial_energy
        for i in range(self.net.elements):
            balance += self.work[i]
        for i in range(self.net.elements, self.works):
            balance -= self.work[i]
        self.state.residual_start = self.state.residual_end
        self.state.residual_end = balance

    def _energy(self, q, v):
        """Return kinetic energy plus the potential of all rows."""
        n = self.net.n
        twice = 0.0
        for i in range(n):
            for k in range(n):
                twice += v[i] * self.net.mass[i * n + k] * v[k]
        energy = 0.5 * twice
        for r in range(self.net.rows):
            s = self.net.row_signal[r]
            d = -self.net.road[4 * s] if s >= 0 else 0.0
            for i in range(n):
                d += self.net.row_direction[r * n + i] * q[i]
            energy += self.e0[r] + d * (self.e1[r] + d * self.e2[r])
            if self.by_element[r]:
                for e in range(self.net.elements):
                    if self.net.element_row[e] == r:
                        energy += self._energy_of_curved(e, d)
        return energy

    def _energy_of_curved(self, e, d):
        """Return the potential of element e at d, unless it is in that of its row."""
        if self.net.branch[_KINDS * e + _CONTACT]:
            return 0.0
        if self.net.yields[e] or not self.net.spring_is_straight(e):
            return self.net.element_energy(e, d)
        return 0.0

    def carry_on(self, residual):
        """Continue the present balance from an earlier residual, J."""
        self.state.initial_energy += self.state.residual_end - residual
        self.state.residual_start = self.state.residual_end = residual


@cache
def _readings(cubic, to_end):
    """Return displacement and rate over h at the points for each of the numbers at the ends alone, 1.

    The numbers are q, h v, h^2 a and h^3 j at the start and at the end; see `dense` for the forms.
    """
    values, rates = [], []
    for x in _POINT:
        for k in range(_ENDS):
            q0, v0, a0, j0, q1, v1, a1, j1 = (float(i == k) for i in range(_ENDS))
            c0, c1, c2, c3 = q0, v0, a0 / 2.0, j0 / 6.0
            s0 = s1 = s2 = s3 = 0.0
            if cubic:
                c3 = q1 - c0 - c1 - c2 if to_end else (a1 - a0) / 6.0
            else:
                d0, d1 = q1 - c0 - c1 - c2 - c3, v1 - c1 - 2.0 * c2 - 3.0 * c3
                d2, d3 = a1 / 2.0 - c2 - 3.0 * c3, j1 / 6.0 - c3
                s0, s1, s2 = d0, d1 - 4.0 * d0, d2 - 4.0 * d1 + 10.0 * d0
                s3 = d3 - 4.0 * d2 + 10.0 * d1 - 20.0 * d0
            value, rate = s3, 0.0
            for c, node in (
                (s2, 1.0),
                (s1, 1.0),
                (s0, 1.0),
                (c3, 0.0),
                (c2, 0.0),
                (c1, 0.0),
                (c0, 0.0),
            ):
                rate = rate * (x - node) + value
                value = value * (x - node) + c
            values.append(value)
            rates.append(rate)
    return values, rates
