"""The energies of a run at any time, and whether errors have added up in them."""

from __future__ import annotations

import cython

if not cython.compiled:
    from math import fabs

_FIRST_LOOK = 1000  # steps before the energies are looked at; later after twice as many each time
_DRIFT = 30.0  # tolerances by which the energy may be off, of all energy held, taken and brought in
_LEAST_DRIFT = 1e-9


class Account:
    """The energies at the time looked at last, J, of a run that may change its integrator.

    Parameters
    ----------
    memory : where the arrays lie
    signals : number of roads and loads, which supply energy
    """

    def __init__(self, memory, signals):
        self.memory, self.signals = memory, signals
        self.kinetic = self.stored = self.dissipated = 0.0
        self.opening = 0.0  # what the account opened with
        self.supplied, self.carried = self.memory.zeros(signals), self.memory.zeros(signals)
        self.start()

    def start(self):
        """Start anew: errors have not added up yet."""
        # whether they have, and the number of steps after which to look at that
        self.drifts, self.look_at = 0, _FIRST_LOOK

    def begin(self, integrator):
        """Let the energies start, where the integrator's ledger begins."""
        self.dissipated = 0.0
        for s in range(self.signals):
            self.supplied[s] = 0.0
        self.carry(integrator)

    def carry(self, integrator):
        """Let the energies found last go on, where the integrator's ledger begins anew.

        What the elements store otherwise is no work.
        """
        dissipated = self.dissipated
        for s in range(self.signals):
            self.carried[s] = self.supplied[s]
        self._look(integrator, integrator.state.time)
        # constant but for the residual
        self.opening = dissipated + self.kinetic + self.stored - integrator.state.residual_end

    def find(self, integrator, time):
        """Find the energies at a time.

        Where the last step goes beyond it, they are those of its interpolant. What is dissipated
        follows from the balance: all work on the elements that no other entry has.
        """
        self._look(integrator, time)
        self.dissipated = self.opening - (self.kinetic + self.stored)
        for s in range(self.signals):
            since = integrator.ledger.until[integrator.net.elements + s]
            self.dissipated += since
            self.supplied[s] = self.carried[s] + since
        self.dissipated += integrator.residual_at(time)

    def _look(self, integrator, time):
        """Let the ledger find its entries at a time, and add up what the elements store."""
        integrator.find_energies(time)
        self.kinetic = integrator.ledger.kinetic
        self.stored = 0.0
        for e in range(integrator.net.elements):
            self.stored += integrator.ledger.kept[e]

    def energies(self):
        """Return the kinetic, stored, dissipated and supplied energies found last, J."""
        supplied = [self.supplied[s] for s in range(self.signals)]
        return self.kinetic, self.stored, self.dissipated, tuple(supplied)

    def find_drift(self, integrator):
        """Return the part of all energy by which the balance is off, if errors have added up; else 0.

        They do in a long run without damping, where nothing forgets them. It is told once.
        """
        if self.drifts or integrator.state.step_count < self.look_at:
            return 0.0
        self.look_at = 2 * integrator.state.step_count
        integrator.find_energies(integrator.dense.end)
        # all that has been there, and what has gone through it: a residual of that is no drift
        turned_over = integrator.ledger.kinetic
        for e in range(integrator.net.elements):
            turned_over += fabs(integrator.ledger.kept[e])
        for k in range(integrator.ledger.works):
            turned_over += fabs(integrator.ledger.until[k])
        off = fabs(integrator.state.residual_end)
        tolerated = max(_DRIFT * integrator.stepper.errors.tolerance, _LEAST_DRIFT)
        if off <= tolerated * turned_over:
            return 0.0
        self.drifts = 1
        return off / turned_over
