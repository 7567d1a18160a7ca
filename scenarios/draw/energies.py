"""The energies of a run: kinetic, stored, dissipated and supplied.

T + U + D = W + the energy at the start. The entries are those of the integrator's ledger, for each road
and each load. A model takes the same internal steps here as in its FMU; at each row a copy of its state
is stepped to that time and read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf, nan, nextafter
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import Value

Reals = npt.NDArray[np.float64]


class _Entries(NamedTuple):
    """The entries of the ledger at one time, J.

    Parameters
    ----------
    kinetic, stored : energy of all masses, and of all elements
    supplied : work of each road and load so far
    residual : error of the balance
    """

    kinetic: float
    stored: float
    supplied: Sequence[float]
    residual: float

    @property
    def held(self) -> float:
        """The kinetic and stored energy."""
        return self.kinetic + self.stored


def energies(
    model: str, parameters: Mapping[str, Value], times: Sequence[float] | Reals
) -> dict[str, Reals]:
    """Return the energies at the times of a run by name, J; NaN once the run has failed.

    The dissipated energy includes the work of all dampers, of friction and of plastic flow, and what a
    damped tyre loses or gains at lift-off and touchdown. If more than one road or load supplies energy,
    each also has a column.

    Parameters
    ----------
    model : key of `suspension.variables.MODELS`
    parameters : its public parameters, SI
    times : s, ascending; the run starts at the first time
    """
    session = Session(model, parameters, float(times[0]))
    names = session.sources
    start = _entries(session.integrator)
    rows = [
        (
            now.kinetic,
            now.stored,
            # from the balance: all work on the elements that no other entry has
            start.held - now.held + sum(now.supplied) + now.residual,
            sum(now.supplied),
            *now.supplied,
        )
        for now in _at(session.integrator, [float(t) for t in times])
    ]
    rows += [(nan,) * (4 + len(names))] * (len(times) - len(rows))
    kinetic, stored, dissipated, supplied, *sources = np.array(rows, float).T
    found = {
        "kinetic_energy": kinetic,
        "stored_energy": stored,
        "dissipated_energy": dissipated,
        "supplied_energy": supplied,
    }
    several = {
        f"{name}_supplied_energy": column
        for name, column in zip(names, sources, strict=True)
        if np.any(column != 0.0)
    }
    return found | (several if len(several) > 1 else {})


def _at(integrator: Any, times: Sequence[float]) -> Iterator[_Entries]:
    """Yield the entries at ascending times, until the integrator fails; it takes its own steps."""
    before = ahead = integrator.snapshot()  # of its last step, and after it
    reached = integrator.time
    for t in times:
        if reached < t:
            integrator.restore(ahead)
        while reached < t:
            before = ahead
            if integrator.advance(nextafter(reached, inf)) != 0:
                return
            reached, ahead = integrator.time, integrator.snapshot()
        integrator.restore(before if t < reached else ahead)
        if t < reached and integrator.advance(t, stop=True) != 0:
            return
        yield _entries(integrator)


def _entries(integrator: Any) -> _Entries:
    kinetic, stored, _, supplied = integrator.energies()
    return _Entries(kinetic, sum(stored), supplied, integrator.residual_end)
