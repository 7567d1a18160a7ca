"""The energies of a run: kinetic, stored, dissipated and supplied, as the outputs of its model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan

import numpy as np
from phaseplane.suspension.variables import Value, outputs

from ..columns import Column
from ..measures.solution import stepped


def energies(
    model: str, parameters: Mapping[str, Value], times: Sequence[float] | Column
) -> dict[str, Column]:
    """Return the energies at the times of a run by name, J; NaN once the run has failed.

    Work is listed by road and force only if several do any.

    Parameters
    ----------
    model : key of `suspension.variables.MODELS`
    parameters : its public parameters, SI
    times : s, ascending; the run starts at the first time
    """
    names = [name for name in outputs(model) if name.endswith("_energy")]
    run = stepped(model, parameters, np.asarray(times, float), names)
    missing = (0, len(times) - len(run.columns["time"]))
    found = {name: np.pad(run.columns[name], missing, constant_values=nan) for name in names}
    sources = [name for name in names if name.endswith("_supplied_energy")]
    idle = [name for name in sources if not np.nan_to_num(found[name]).any()]
    for name in sources if len(sources) - len(idle) < 2 else idle:
        del found[name]
    return found
