"""Second-order equations solved in this process, in place of an FMU."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter

import numpy as np
from phaseplane.suspension.variables import Value

from phaseplane.equations import motions

from ..columns import Column
from ..progress import Progress, silent
from ..scene.equation import formula_of, start_of
from .drive import INTERRUPTED


def solve(
    parameters: Mapping[str, Value],
    times: Column,
    *,
    starts: Sequence[tuple[float, float]] = (),
    progress: Progress = silent,
    interrupted: Callable[[], int] = lambda: 0,
) -> tuple[dict[str, Column], float, str]:
    """Return the motion at the given times, to ten digits, followed through the switches of f.

    Parameters
    ----------
    parameters : of the equation
    times : s, ascending
    starts : x and x' of further starts, whose motions are columns of their own
    progress : called after every step with the fraction done, 0 to 1
    interrupted : asked after every step whether to stop there

    Returns
    -------
    The columns up to where the first of the motions ends, the run time in s, and why it ended early (""
    if not).
    """
    started = perf_counter()
    switching = formula_of(parameters).switching
    starts = (start_of(parameters), *starts)

    def going_on(time: float) -> bool:
        progress((time - times[0]) / (times[-1] - times[0]))
        return not interrupted()

    columns: dict[str, Column] = {}
    found = motions(switching, starts, times.tolist(), going_on)
    rows = min(len(one.times) for one in found)
    complaint = ""
    for number, (start, one) in enumerate(zip(starts, found, strict=True)):
        if one.complaint and len(one.times) == rows and not complaint:
            complaint = one.complaint
            if len(starts) > 1:
                complaint = f"from the start ({start[0]:g}, {start[1]:g}) {complaint}"
        prefix = f"start{number + 1}_" if number else ""
        columns |= {
            f"{prefix}displacement": np.array(one.displacements),
            f"{prefix}velocity": np.array(one.velocities),
            f"{prefix}acceleration": np.array(one.accelerations),
        }
    made = {"time": times, **columns}
    return (
        {name: column[:rows] for name, column in made.items()},
        perf_counter() - started,
        complaint or (INTERRUPTED if interrupted() else ""),
    )
