"""The energies of a run at any time, and whether errors have accumulated in their balance."""

from __future__ import annotations

from math import fabs

from ..arrays import Memory
from ..energy.ledger import unknown_energy
from ..integrator import Integrator
from ..language import Long, of_python, open_to_python

# steps before the balance is first checked; then whenever their number has doubled
_FIRST_LOOK = 1000
# residual allowed, in tolerances, relative to all energy stored, dissipated and supplied
_DRIFT = 30.0
_LEAST_DRIFT = 1e-9


class Account:
    """The energies of a run at the time last requested, J; the run may change its integrator."""

    opening: float
    drifts: bool
    look_at: Long

    def __init__(self, memory: Memory, signals: int) -> None:
        self.memory, self.signals = memory, signals
        self.kinetic = self.stored = self.dissipated = 0.0
        # energy dissipated before the ledger of the present integrator, J
        self.opening = 0.0
        self.supplied, self.carried = self.memory.zeros(signals), self.memory.zeros(signals)
        self.start()

    def start(self) -> None:
        """Reset the check: errors have not accumulated yet."""
        # whether they have, and the number of steps after which to check that next
        self.drifts, self.look_at = False, _FIRST_LOOK

    @open_to_python
    def begin(self, integrator: Integrator) -> None:
        """Start from zero dissipated and supplied energy, as the integrator's ledger does."""
        self.dissipated = 0.0
        for s in range(self.signals):
            self.supplied[s] = 0.0
        self.carry(integrator)

    @open_to_python
    def carry(self, integrator: Integrator) -> None:
        """Continue from the energies found last, although the integrator's ledger starts from zero.

        A change of the energy stored in the elements at this time is not work.
        """
        for s in range(self.signals):
            self.carried[s] = self.supplied[s]
        self._look(integrator, integrator.state.time)
        self.opening = self.dissipated - integrator.ledger.lost()

    @open_to_python
    def find(self, integrator: Integrator, time: float) -> None:
        """Find the energies at a time; without the ledger those dissipated and supplied are NaN.

        If the last step extends beyond it, they are read from the interpolant of the step.
        """
        self._look(integrator, time)
        if not integrator.energy:
            self.dissipated = unknown_energy()
            for s in range(self.signals):
                self.supplied[s] = self.dissipated
            return
        self.dissipated = self.opening + integrator.ledger.lost()
        for s in range(self.signals):
            since = integrator.ledger.until[integrator.net.elements.count + s]
            self.supplied[s] = self.carried[s] + since

    def _look(self, integrator: Integrator, time: float) -> None:
        """Read the ledger at a time, and add up the energy stored in the elements."""
        integrator.find_energies(time)
        self.kinetic = integrator.ledger.kinetic
        self.stored = 0.0
        for e in range(integrator.net.elements.count):
            self.stored += integrator.ledger.kept[e]

    @of_python
    def energies(self) -> tuple[float, float, float, tuple[float, ...]]:
        """Return the kinetic, stored, dissipated and supplied energies found last, J."""
        supplied = [self.supplied[s] for s in range(self.signals)]
        return self.kinetic, self.stored, self.dissipated, tuple(supplied)

    @open_to_python
    def find_drift(self, integrator: Integrator) -> float:
        """Return the residual relative to all energy, if errors have accumulated; otherwise 0.

        They accumulate in a long run without damping, because no error decays. This is reported once.
        """
        if not integrator.energy or self.drifts or integrator.state.step_count < self.look_at:
            return 0.0
        self.look_at = 2 * integrator.state.step_count
        integrator.find_energies(integrator.dense.end)
        # all energy stored, dissipated and supplied: a small share of it is not a drift
        turned_over = integrator.ledger.kinetic
        for e in range(integrator.net.elements.count):
            turned_over += fabs(integrator.ledger.kept[e])
        for k in range(integrator.ledger.works):
            turned_over += fabs(integrator.ledger.until[k])
        off = fabs(integrator.ledger.residual())
        tolerated = max(_DRIFT * integrator.stepper.errors.tolerance, _LEAST_DRIFT)
        if off <= tolerated * turned_over:
            return 0.0
        self.drifts = True
        return off / turned_over
