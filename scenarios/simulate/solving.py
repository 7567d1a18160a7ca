"""Second-order equations solved in this process, in place of an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.variables import Value

from phaseplane.equations import motion

from ..scene.equation import formula_of


def solve(
    parameters: Mapping[str, Value], times: npt.NDArray[np.float64]
) -> tuple[dict[str, npt.NDArray[np.float64]], float, str]:
    """Return the motion at the given times, to ten digits, followed through the switches of f.

    Returns
    -------
    The columns up to where the solution ends, the run time in s, and why it ended early ("" if not).
    """
    start = float(parameters["displacement_start"]), float(parameters["velocity_start"])
    started = perf_counter()
    found = motion(formula_of(parameters).switching, start, times.tolist())
    columns = {
        "time": np.array(found.times),
        "displacement": np.array(found.displacements),
        "velocity": np.array(found.velocities),
        "acceleration": np.array(found.accelerations),
    }
    return columns, perf_counter() - started, found.complaint
