"""The energy ledger: the energy dissipated by elements and the work of roads and loads, step by step.

The powers are integrated over the dense output of each step by four-point Gauss-Legendre quadrature,
which has the order of that output, 8.
"""

from __future__ import annotations

import cython

from .arrays import doubles

if not cython.compiled:
    from math import fabs

_POINTS = 4
_TIMES = 2.0  # times the energy accounted for
_LEAST = 1e-9  # J, which rounding alone may cause


class Ledger:
    """Works so far, J: dissipated by each element, done by the road of each row, by each load.

    Parameters
    ----------
    network : network of the system
    dense : dense output of its last step
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
        """Reset all works to zero."""
        # energy that roads and loads have moved in or out, all counted as positive
        self.supplied = self.most_stored = 0.0
        self.residual_start = self.residual_end = 0.0
        for i in range(self.net.works):
            self.work[i] = 0.0

    def book(self):
        """Add the works of the last step, with the branches of that step."""
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
        """Add the work of a jump of a road, J."""
        for r in range(self.net.rows):
            if self.net.row_signal[r] == signal:
                self.work[self.net.elements + r] += energy
                break
        self.supplied += fabs(energy)

    def grows(self):
        """Return whether the stored energy is far more than the initial energy and all energy supplied.

        Only roads, loads and driving dampers can add energy; the exchange at contact switches has its
        own entry. A correct run never reaches twice that sum, as energy supplied still counts after it
        has left the system; with unstable steps the energy soon exceeds it.
        """
        return self.stored > _TIMES * (fabs(self.initial_energy) + self.supplied) + _LEAST

    def is_out_of_balance(self):
        """Return whether the residual exceeds all energy ever stored or supplied: the run is wrong."""
        most = max(self.most_stored, self.supplied) + fabs(self.initial_energy)
        return fabs(self.residual_end) > most + _LEAST

    def strike_balance(self, t, q, v):
        """Find T + U + dissipated - supplied - exchanged at contact switches - initial: 0 if exact."""
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
        """Continue the present balance from an earlier residual, J."""
        self.initial_energy += self.residual_end - residual
        self.residual_start = self.residual_end = residual
