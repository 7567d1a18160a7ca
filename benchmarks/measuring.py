"""Times of several functions that take turns, so that a busy machine is busy for all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import ceil
from statistics import median

from phaseplane.scenarios.studies.workbench import timed

_TURN = 2e-3  # s that a turn takes, about or more


def medians(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median time of each function over rounds in which all of them have their turn, s.

    A turn of what is over sooner than in two milliseconds is as many calls as take about so long, and
    the mean of them: what the one before it has left in the processor says nothing about either. Anything
    else is called once more before it is timed, for the same reason.
    """
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            calls = ceil(_TURN / timed(function)[1])
            times[name].append(sum(timed(function)[1] for _ in range(calls)) / calls)
    return {name: median(taken) for name, taken in times.items()}
