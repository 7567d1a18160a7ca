"""Second-order equations solved in this process, in place of an FMU."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import perf_counter

import numpy as np
from phaseplane.suspension.variables import Value

from phaseplane.equations import motion

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

    def going_on(number: int, ended: bool, time: float) -> bool:
        part = (time - times[0]) / (times[-1] - times[0])
        progress((number + part) / len(starts))
        return ended or not interrupted()

    columns: dict[str, Column] = {}
    rows, complaint = len(times), ""
    for number, start in enumerate(starts):
        # after an interrupt, the others still follow up to where the interrupted one has come
        ended = number > 0 and bool(interrupted())
        found = motion(switching, start, times[:rows].tolist(), partial(going_on, number, ended))
        if len(found.times) < rows:
            rows, complaint = len(found.times), found.complaint
            if complaint and len(starts) > 1:
                complaint = f"from the start ({start[0]:g}, {start[1]:g}) {complaint}"
        prefix = f"start{number + 1}_" if number else ""
        columns |= {
            f"{prefix}displacement": np.array(found.displacements),
            f"{prefix}velocity": np.array(found.velocities),
            f"{prefix}acceleration": np.array(found.accelerations),
        }
    made = {"time": times, **columns}
    return (
        {name: column[:rows] for name, column in made.items()},
        perf_counter() - started,
        complaint or (INTERRUPTED if interrupted() else ""),
    )
