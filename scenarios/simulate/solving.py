"""Second-order equations solved by scipy, in place of an FMU."""

from __future__ import annotations

import math
from collections.abc import Mapping
from time import perf_counter

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.variables import Value
from scipy.integrate import solve_ivp

from ..scene.equation import function_of

_NO_FURTHER = (
    "no step is short enough: the acceleration is not a number there, or grows without bound"
)


def solve(
    parameters: Mapping[str, Value], times: npt.NDArray[np.float64]
) -> tuple[dict[str, npt.NDArray[np.float64]], float, str]:
    """Return the motion at the given times, by scipy's DOP853 to ten digits.

    Returns
    -------
    The columns up to where the solution ends, the run time in s, and why it ended early ("" if not).
    """
    function, _ = function_of(str(parameters["equation"]))

    def acceleration(x: float, v: float, t: float) -> float:
        try:
            return -function(v, x, t)
        except OverflowError:  # the solver then tries a shorter step
            return math.nan

    def slope(t: float, state: npt.NDArray[np.float64]) -> tuple[float, float]:
        x, v = state.tolist()
        return v, acceleration(x, v, t)

    started = perf_counter()
    y = np.array([[parameters["displacement_start"]], [parameters["velocity_start"]]], float)
    reached = times[:1]
    with np.errstate(all="ignore"):  # a NaN ends the run with a message
        solution = solve_ivp(
            slope, (times[0], times[-1]), y[:, 0], method="DOP853", t_eval=times, rtol=1e-10,
            atol=1e-12, max_step=(times[-1] - times[0]) / 50.0,
        )  # fmt: skip
    if len(solution.t):  # else it reached only the first instant
        reached, y = solution.t, solution.y
    complaint = "" if solution.success else _NO_FURTHER
    accelerations = [acceleration(x, v, t) for x, v, t in zip(*y.tolist(), reached, strict=True)]
    columns = {
        "time": reached,
        "displacement": y[0],
        "velocity": y[1],
        "acceleration": np.array(accelerations),
    }
    return columns, perf_counter() - started, complaint
