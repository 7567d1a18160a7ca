"""Times of several functions that take turns, so that a busy machine is busy for all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import median

from scenarios.studies.workbench import timed


def medians(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median time of each function over rounds in which all of them run once, s.

    Each runs once more before it is timed: what the one before it has left in the processor's
    caches says nothing about either.
    """
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            timed(function)
            times[name].append(timed(function)[1])
    return {name: median(taken) for name, taken in times.items()}
