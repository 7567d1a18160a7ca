"""Second-order equations solved in this process, in place of an FMU."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from time import perf_counter

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.variables import Value

from phaseplane.equations import motion

from ..scene.equation import formula_of
from .drive import INTERRUPTED, Progress


def solve(
    parameters: Mapping[str, Value],
    times: npt.NDArray[np.float64],
    *,
    progress: Progress | None = None,
    interrupted: Callable[[], int] = lambda: 0,
) -> tuple[dict[str, npt.NDArray[np.float64]], float, str]:
    """Return the motion at the given times, to ten digits, followed through the switches of f.

    Parameters
    ----------
    parameters : of the equation
    times : s, ascending
    progress : called after every step with the fraction done, 0 to 1
    interrupted : asked after every step whether to stop there

    Returns
    -------
    The columns up to where the solution ends, the run time in s, and why it ended early ("" if not).
    """
    start = float(parameters["displacement_start"]), float(parameters["velocity_start"])
    started = perf_counter()

    def going_on(time: float) -> bool:
        if progress is not None:
            progress((time - times[0]) / (times[-1] - times[0]))
        return not interrupted()

    found = motion(formula_of(parameters).switching, start, times.tolist(), going_on)
    columns = {
        "time": np.array(found.times),
        "displacement": np.array(found.displacements),
        "velocity": np.array(found.velocities),
        "acceleration": np.array(found.accelerations),
    }
    return (
        columns,
        perf_counter() - started,
        found.complaint or (INTERRUPTED if interrupted() else ""),
    )
