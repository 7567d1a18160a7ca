"""Times of several functions that take turns, so that a busy machine is busy for all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from statistics import median

from scenarios.studies.workbench import timed


def medians(functions: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median time of each function over rounds in which all of them run once, s."""
    times: dict[str, list[float]] = {name: [] for name in functions}
    for function in functions.values():
        function()  # caches, compilers
    for _ in range(rounds):
        for name, function in functions.items():
            times[name].append(timed(function)[1])
    return {name: median(taken) for name, taken in times.items()}
