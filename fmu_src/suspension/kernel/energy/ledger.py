"""The energy ledger: the energy dissipated by elements and the work of roads and loads, step by step.

The powers are integrated over the dense output of each step by four-point Gauss-Legendre quadrature,
which has the order of that output, 8. Deflection and rate of a row at the four points are sums over its
value and derivatives at both ends of the step. With a straight damper, f + c w, the work in a step is
f times the integral of w plus c times that of w^2, for all elements of a row from the same two numbers.
While roads do not move, these two follow from the ends alone, as does the energy of straight springs.
"""

from __future__ import annotations

from math import fabs

from ..language import Doubles
from ..layout import BRANCHES, CONTACT, FRICTION, SPRING, UNBOUNDED
from ..motion.balance import Balance
from ..motion.dense import Dense
from ..motion.rows import Rows
from ..network.elements import ELASTIC
from ..outcomes import ENERGY_GROWS, OUT_OF_BALANCE, REACHED
from .potential import Potential
from .step_readings import ENDS, POINTS, StepReadings

_TIMES = 2.0  # times the energy accounted for: more stored energy than that is wrong
_LEAST = 1e-9  # J; rounding alone may cause as much
# what a row that dissipates needs of a step: the integrals of w and w^2, or its rates at all points
_SUMS, _AT_POINTS = 1, 2


class Ledger:
    """Works so far, J: dissipated by each element, done by each signal as a road or a load."""

    def __init__(self, balance: Balance, rows: Rows, dense: Dense) -> None:
        self.balance, self.dense = balance, dense
        self.net = self.balance.net
        self.elements = self.net.elements
        elements, most = self.elements.count, max(self.elements.rows, 1)
        self.works = elements + self.net.signals.count
        memory = self.net.memory
        # works so far; those of jumps of roads at the time of the last jump; those in a part of a step
        self.state = self.net.state
        kept = self.state.memory
        self.work, self.brought = kept.zeros(self.works), kept.zeros(self.works)
        self.part = memory.zeros(self.works)
        # the entries at the time last requested: kinetic energy, energy of each element, works until
        # then, and what contact switches have exchanged
        self.kinetic = self.exchanged = 0.0
        self.kept, self.until = memory.zeros(elements), memory.zeros(self.works)
        # of each element: force at rest and damping of its dissipative part, and whether that is curved
        self.loss, self.loss_rate = memory.zeros(elements), memory.zeros(elements)
        self.curved = memory.marks(elements)
        self.dissipating, self.element = 0, memory.marks(elements)  # how many dissipate, and which
        self.needs = memory.marks(most)  # of each row: nothing, `_SUMS` or `_AT_POINTS`
        self.rows, self.row = 0, memory.marks(most)  # how many rows need either, and which
        self.moving = False  # whether any signal changes within the step
        self.loaded = False  # whether any load is not zero throughout the present segments
        self.readings = StepReadings(rows, dense)
        self.potential = Potential(self.balance.straight)
        self.start()

    def start(self) -> None:
        """Reset the works of signals, and all balances."""
        # energy that roads and loads have moved in or out, all counted as positive
        self.state.supplied = self.state.most_stored = 0.0
        for i in range(self.elements.count, self.works):
            self.work[i] = self.brought[i] = 0.0

    def enter(self) -> None:
        """Read which forces dissipate and which store energy in the present branches and segments."""
        for r in range(self.elements.rows):
            self.needs[r] = 0
        self.potential.enter()
        self.dissipating = 0
        for e in range(self.elements.count):
            at = BRANCHES * e
            f = self.elements.branch[at + FRICTION] * self.elements.friction[e]
            c = 0.0
            self.curved[e] = 0
            if not self.elements.branch[at + CONTACT]:
                if self.balance.straight.bent_damper[e]:
                    self.curved[e] = 1
                else:
                    f += self.balance.straight.damper_f[e]
                    c = self.balance.straight.damper_c[e]
                if self.elements.yields[e] and self.elements.branch[at + SPRING] != ELASTIC:
                    f += self.elements.flow_force(e)
            self.loss[e], self.loss_rate[e] = f, c
            if f != 0.0 or c != 0.0 or self.curved[e]:
                r = self.elements.row_of[e]
                self.needs[r] = _AT_POINTS if self.curved[e] else max(self.needs[r], _SUMS)
                self.element[self.dissipating] = e
                self.dissipating += 1
        self.rows = 0
        for r in range(self.elements.rows):
            if self.needs[r]:
                self.row[self.rows] = r
                self.rows += 1
        self.loaded = False
        for m in range(self.net.loads):
            s = self.net.load_signal[m]
            if self.net.signals.road[4 * s] != 0.0 or not self.net.signals.is_level(s):
                self.loaded = True

    def read_rows(self, t: float, h: float) -> None:
        """Read the rows at both ends of the attempt that becomes the last step, unless signals change."""
        self.moving = not (self.balance.loads_hold or self.net.signals.still())
        if not (self.moving or self.readings.rows.end_known):
            self.readings.rows.read(t, h)

    def book(self) -> None:
        """Add the works of the last step, with its branches; leave the signals at its end."""
        h = self.dense.end - self.dense.start
        self.state.exchange_in_step = self.state.exchange
        if h > 0.0 and self.moving:
            if self.net.branches.stuck:
                self._book_points()
            else:
                self.readings.read_signals(h)
        if self.moving:
            self.net.signals.all_signals(self.dense.end)
        if h > 0.0 and not (self.moving and self.net.branches.stuck):
            self._book_parts(h, self.moving)

    def _book_parts(self, h: float, moving: bool) -> None:
        """Add the works of elements, roads and loads one by one, with the signals read before."""
        if moving:
            for r in range(self.elements.rows):
                self.readings.read_row(r, h, True)
        else:
            for k in range(self.rows):
                r = self.row[k]
                if self.needs[r] == _AT_POINTS:
                    self.readings.read_row(r, h, False)
                else:
                    self.readings.sum_row(r, h)
        for k in range(self.dissipating):
            self._book_element(self.element[k], h)
        if moving:
            for r in range(self.elements.rows):
                if self.elements.row_signal[r] >= 0:
                    self._book_road(r, h)
        if self.loaded:
            for m in range(self.net.loads):
                self._book_load(m, h, moving)

    def _book_element(self, e: int, h: float) -> None:
        """Add what element e has dissipated."""
        r = self.elements.row_of[e]
        work = self.loss[e] * self.readings.way[r] + self.loss_rate[e] * self.readings.square[r]
        if self.curved[e]:
            for k in range(POINTS):
                w = self.readings.w[POINTS * r + k]
                force = self.elements.damper_force_at(e, self.readings.d[POINTS * r + k], w)
                work += self.readings.weight[k] * h * force * w
        self.work[e] += work
        if work < 0.0:
            self.state.supplied -= work

    def _book_road(self, r: int, h: float) -> None:
        """Add the work of the road under row r."""
        s = self.elements.row_signal[r]
        bent = -1
        for p in range(self.balance.bends.count):
            if self.balance.bends.row[p] == r:
                bent = p
        for k in range(POINTS):
            rate = self.readings.du[POINTS * s + k]
            if rate != 0.0:
                d, w = self.readings.d[POINTS * r + k], self.readings.w[POINTS * r + k]
                force = self.balance.straight.force(r, d, w)
                if bent >= 0:
                    self.balance.bends.find(bent, d, w, 0.0, 0.0)
                    force += self.balance.bends.force[bent]
                self._supply(s, -self.readings.weight[k] * h * force * rate)

    def _book_load(self, m: int, h: float, moving: bool) -> None:
        """Add the work of load m."""
        s = self.net.load_signal[m]
        if not moving and self.net.signals.road[4 * s] == 0.0:
            return
        self.readings.read_ends(self.net.load_direction, self.net.n * m, h)
        if not moving:
            self._supply(
                s, self.net.signals.road[4 * s] * (self.readings.ends[4] - self.readings.ends[0])
            )
            return
        for k in range(POINTS):
            way = 0.0
            for i in range(ENDS):
                way += self.readings.rate[ENDS * k + i] * self.readings.ends[i]
            self._supply(s, self.readings.weight[k] * self.readings.u[POINTS * s + k] * way)

    def _book_points(self) -> None:
        """Add the works point by point, with the forces of sticking rows on moving roads."""
        self.find_part(self.dense.start)
        for i in range(self.works):
            if i >= self.elements.count:
                self._supply(i - self.elements.count, self.part[i])
            else:
                self.work[i] += self.part[i]

    def find_part(self, since: float) -> None:
        """Find the works from a time within the last step to its end, in the present branches."""
        h = self.dense.end - since
        for i in range(self.works):
            self.part[i] = 0.0
        for k in range(POINTS):
            t = since + self.readings.point[k] * h
            self.dense.read(t)
            self.net.signals.all_signals(t)
            self.elements.row_states(self.dense.q, self.dense.v)
            self.elements.row_forces()
            self.net.accelerate(self.dense.a)  # for the forces of sticking
            self.net.sticking.hold()
            weight = self.readings.weight[k] * h
            for e in range(self.elements.count):
                self.part[e] += weight * self.elements.dissipation(e)
            for r in range(self.elements.rows):
                s = self.elements.row_signal[r]
                if s >= 0:
                    power = -self.elements.row_f[r] * self.net.signals.road[4 * s + 1]
                    self.part[self.elements.count + s] += weight * power
            for m in range(self.net.loads):
                w = 0.0
                for i in range(self.net.n):
                    w += self.net.load_direction[m * self.net.n + i] * self.dense.v[i]
                s = self.net.load_signal[m]
                self.part[self.elements.count + s] += weight * self.net.signals.road[4 * s] * w

    def take_stock(self, q: Doubles, v: Doubles) -> None:
        """Find the kinetic energy and that stored in each element, with the signals in `road`."""
        self.elements.row_states(q, v)
        self.kinetic = self.net.energy(v)
        for e in range(self.elements.count):
            r = self.elements.row_of[e]
            self.kept[e] = self.elements.element_energy(e, self.elements.row_d[r])
            if self.net.series.of_element[e] >= 0:
                w = self.elements.row_v[r]
                self.kept[e] = 0.5 * w * self.net.series.force(e, w)
            self.kinetic -= self.kept[e]

    def _supply(self, signal: int, energy: float) -> None:
        self.work[self.elements.count + signal] += energy
        self.state.supplied += fabs(energy)

    def bring_in(self, signal: int, energy: float) -> None:
        """Add the work of a jump of a road at the present time, J."""
        if self.state.brought_at != self.state.time:
            self.state.brought_at = self.state.time
            for i in range(self.works):
                self.brought[i] = 0.0
        self.brought[self.elements.count + signal] += energy
        self._supply(signal, energy)

    def lose(self, e: int, energy: float) -> None:
        """Add the energy that element e dissipates as its road jumps, J."""
        self.work[e] += energy

    def find_until(self, time: float) -> None:
        """Find the works until a time within the last step, in the branches of that step."""
        self.find_part(time)
        jumped = self.state.brought_at == self.dense.end
        for i in range(self.works):
            self.until[i] = self.work[i] - self.part[i]
            if jumped:
                self.until[i] -= self.brought[i]
        self.exchanged = self.state.exchange_in_step

    def find_all(self) -> None:
        """Find the works up to the present time."""
        for i in range(self.works):
            self.until[i] = self.work[i]
        self.exchanged = self.state.exchange

    def lost(self) -> float:
        """Return the energy dissipated by all elements, less what contact switches have exchanged.

        This and the residual are those at the time for which the entries were last found.
        """
        lost = -self.exchanged
        for e in range(self.elements.count):
            lost += self.until[e]
        return lost

    def residual(self) -> float:
        """Return T + U + dissipated - supplied - exchanged at contact switches - initial: 0 if exact."""
        balance = self.kinetic + self.lost() - self.state.initial_energy
        for e in range(self.elements.count):
            balance += self.kept[e]
        for i in range(self.elements.count, self.works):
            balance -= self.until[i]
        return balance

    def check(self, q: Doubles, v: Doubles, exact: bool) -> int:
        """Return 0, or `ENERGY_GROWS` or `OUT_OF_BALANCE` if the run is wrong.

        Only roads, loads and driving dampers can add energy; the exchange at contact switches has its
        own entry. A correct run never stores twice the sum of initial energy and all energy supplied,
        as energy supplied still counts after it has left the system; with unstable steps the energy soon
        exceeds it. Nor does its residual exceed all energy ever stored or supplied; an `exact` method
        has no errors that this could reveal.
        """
        stored = self.potential.energy(q, v) - self.state.exchange
        self.state.most_stored = max(self.state.most_stored, fabs(stored))
        initial = fabs(self.state.initial_energy)
        if stored > _TIMES * (initial + self.state.supplied) + _LEAST:
            return ENERGY_GROWS
        balance = stored - self.state.initial_energy
        for i in range(self.elements.count):
            balance += self.work[i]
        for i in range(self.elements.count, self.works):
            balance -= self.work[i]
        most = max(self.state.most_stored, self.state.supplied) + initial
        if not (exact or fabs(balance) <= most + _LEAST):
            return OUT_OF_BALANCE
        return REACHED

    def carry_on(self, residual: float) -> None:
        """Continue the balance for which the entries were last found from an earlier residual, J."""
        change = self.residual() - residual
        self.state.initial_energy += change


def unknown_energy() -> float:
    """Return NaN, for which the small language has no name."""
    beyond = UNBOUNDED
    beyond *= beyond
    return beyond - beyond
