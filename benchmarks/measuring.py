"""Interleaved timing of several functions, so that a busy machine slows all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import ceil
from statistics import median
from time import process_time

from phaseplane.scenarios.studies.workbench import timed

_TURN = 2e-3  # least time of a turn, approximately, s


def medians(
    functions: Mapping[str, Callable[[], object]],
    rounds: int,
    clock: Callable[[], float] = process_time,
) -> dict[str, float]:
    """Return the median time of each function over rounds in which each has one turn, s.

    A turn is the mean of as many calls as take about two milliseconds, at least one. An uncounted call
    before it warms the caches, so that the previous function has no influence.

    Parameters
    ----------
    clock : processor time, which other programs do not lengthen; `perf_counter` for several threads
    """
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            calls = ceil(_TURN / timed(function, clock)[1])
            times[name].append(sum(timed(function, clock)[1] for _ in range(calls)) / calls)
    return {name: median(taken) for name, taken in times.items()}
