"""The energy ledger: what elements dissipate and what roads and loads bring in, step by step.

The powers are integrated over the dense output of each step by Gauss and Legendre's four points,
which are right to order 8 as it is.
"""

from __future__ import annotations

import cython

from .arrays import doubles

if not cython.compiled:
    from math import fabs

_POINTS = 4
_TIMES = 2.0  # the energy known of
_LEAST = 1e-9  # J, of which rounding alone may be the cause


class Ledger:
    """Works so far, J: dissipated by each element, brought in by each row's road, by each load.

    Parameters
    ----------
    network, dense : of the system, of its last step
    """

    def __init__(self, network, dense):
        self.net, self.dense = network, dense
        self.power, self.work = doubles([0.0] * network.works), doubles([0.0] * network.works)
        self.scratch = doubles([0.0] * network.n)
        self.point = doubles(
            (
                0.06943184420297371239,
                0.33000947820757186760,
                0.66999052179242813240,
                0.93056815579702628761,
            )
        )
        self.weight = doubles(
            (
                0.17392742256872692869,
                0.32607257743127307131,
                0.32607257743127307131,
                0.17392742256872692869,
            )
        )
        self.initial_energy = 0.0
        self.start()

    def start(self):
        """Nothing has been done yet."""
        # what roads and loads have moved in and out, every joule counted as one
        self.supplied = self.most_stored = 0.0
        self.residual_start = self.residual_end = 0.0
        for i in range(self.net.works):
            self.work[i] = 0.0

    def book(self):
        """Enter the works of the last step, with the branches of that step."""
        h = self.dense.end - self.dense.start
        for k in range(_POINTS):
            t = self.dense.start + self.point[k] * h
            self.dense.read(t)
            self.net.all_signals(t)
            self.net.row_states(self.dense.q, self.dense.v)
            self.net.row_forces()
            if self.net.stuck:
                self.net.accelerate(self.scratch)
                self.net.hold(self.net.multiplier)
            self.net.powers(self.dense.v, self.power)
            for i in range(self.net.works):
                self.work[i] += self.weight[k] * h * self.power[i]
                if i >= self.net.elements or self.power[i] < 0.0:
                    self.supplied += self.weight[k] * h * fabs(self.power[i])

    def bring_in(self, signal, energy):
        """Book what a jump of a road does, J."""
        for r in range(self.net.rows):
            if self.net.row_signal[r] == signal:
                self.work[self.net.elements + r] += energy
                break
        self.supplied += fabs(energy)

    def grows(self):
        """Whether far more energy is there than ever was, or was brought in.

        Nothing but roads, loads and dampers that drive can add to it; the exchange at contact
        switches is an entry of its own and no growth. A right run never has twice that, for every
        joule brought in counts although most go again; steps too long soon have.
        """
        return self.stored > _TIMES * (fabs(self.initial_energy) + self.supplied) + _LEAST

    def is_out_of_balance(self):
        """Whether the balance lacks more than was ever stored or brought in: nothing of it is right."""
        most = max(self.most_stored, self.supplied) + fabs(self.initial_energy)
        return fabs(self.residual_end) > most + _LEAST

    def strike_balance(self, t, q, v):
        """T + U + dissipated - brought in - exchanged at contact switches - its start: 0 if exact."""
        self.net.all_signals(t)
        self.net.row_states(q, v)
        self.stored = self.net.energy(v) - self.net.exchange
        self.most_stored = max(self.most_stored, fabs(self.stored))
        balance = self.stored - self.initial_energy
        for i in range(self.net.elements):
            balance += self.work[i]
        for i in range(self.net.elements, self.net.works):
            balance -= self.work[i]
        self.residual_start = self.residual_end
        self.residual_end = balance

    def carry_on(self, residual):
        """Let the balance just struck stand at a residual that was there before, J."""
        self.initial_energy += self.residual_end - residual
        self.residual_start = self.residual_end = residual
