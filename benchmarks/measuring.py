"""What the benchmarks share: interleaved timing, their arguments, and their files of results."""

from __future__ import annotations

import json
import os
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from math import ceil
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

from phaseplane.scenarios.studies.accuracy_report import compared_versions, machine
from phaseplane.scenarios.studies.workbench import timed

HERE = Path(__file__).parent
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


@dataclass(frozen=True, slots=True)
class Seconds:
    """Times of a job, s: wall time, and processor time including child processes."""

    clock: float
    processor: float


def seconds(job: Callable[[], object]) -> Seconds:
    """Return the times of a job."""
    before, started = _processor_time(), perf_counter()
    job()
    return Seconds(perf_counter() - started, _processor_time() - before)


def _processor_time() -> float:
    """Return the processor time of this process and of those that it has waited for, s."""
    import resource  # noqa: PLC0415  (not on every system)

    who = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)  # `os.times` counts in hundredths
    return sum(used.ru_utime + used.ru_stime for used in map(resource.getrusage, who))


def median_of(times: list[Seconds]) -> Seconds:
    """Return the median of each of the two times."""
    return Seconds(median(t.clock for t in times), median(t.processor for t in times))


def arguments(about: str, **defaults: int | str) -> Namespace:
    """Return the arguments of a benchmark: those with defaults, and whether to write no files."""
    options = ArgumentParser(description=about.splitlines()[0])
    for name, default in defaults.items():
        options.add_argument(f"--{name}", type=type(default), default=default)
    options.add_argument("--print", action="store_true", dest="only_print", help="write no files")
    return options.parse_args()


def stored(name: str, results: Mapping[str, Any]) -> dict[str, Any]:
    """Write results to a JSON file of this folder, after date, machine and versions; return it all."""
    data = {
        "date": datetime.now(UTC).date().isoformat(),
        "machine": machine() | {"load": os.getloadavg()[0]},
        "versions": compared_versions(),
        **results,
    }
    (HERE / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    return data
