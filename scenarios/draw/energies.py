"""Where the energy of a run is: moving, stored, dissipated, brought in (L2 eqs. 21, 26).

T + U + D = W + the energy at the start. The account is the ledger of the integrator, road by road and
load by load. A model of this project takes the same internal steps here as in its FMU; at each row its
state is taken aside, led on to that instant, and read.
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
    """What the ledger says at one instant, J.

    Parameters
    ----------
    kinetic, stored : of all masses, of all elements
    supplied : by each road and load so far
    residual : what the balance lacks
    """

    kinetic: float
    stored: float
    supplied: Sequence[float]
    residual: float

    @property
    def held(self) -> float:
        """What moves and what is stored."""
        return self.kinetic + self.stored


def energies(
    model: str, parameters: Mapping[str, Value], times: Sequence[float] | Reals
) -> dict[str, Reals]:
    """Columns of energy at the instants of a run, J, by name; not numbers once the run has failed.

    What is dissipated is the works of all dampers, of friction and of flow, and what a damped tyre
    loses or gains where its contact ends or begins. Where more than one road or load brings energy in,
    each has a column of its own besides.

    Parameters
    ----------
    model : key of `suspension.variables.MODELS`
    parameters : its public parameters, SI
    times : s, ascending; the run starts at the first one
    """
    session = Session(model, parameters, float(times[0]))
    names = session.sources
    start = _entries(session.integrator)
    rows = [
        (
            now.kinetic,
            now.stored,
            # the balance: with it, all that any element took up and no other entry has
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
    """The entries at ascending instants, as far as the integrator comes, step by step of its own."""
    before = integrator.snapshot()
    for t in times:
        while integrator.time < t:
            before = integrator.snapshot()
            if integrator.advance(nextafter(integrator.time, inf)) != 0:
                return
        if integrator.time == t:
            yield _entries(integrator)
            continue
        ahead = integrator.snapshot()
        integrator.restore(before)
        if integrator.advance(t, stop=True) != 0:
            return
        yield _entries(integrator)
        integrator.restore(ahead)


def _entries(integrator: Any) -> _Entries:
    kinetic, stored, _, supplied = integrator.energies()
    return _Entries(kinetic, sum(stored), supplied, integrator.residual_end)
