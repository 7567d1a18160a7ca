"""Start-up time: whole commands compared with processes that only import the libraries they need.

    python benchmarks/startup.py [--rounds 15] [--only help,bare,whole]

Each round starts every process once, one after the other. Ratios are of medians over the rounds,
without the first, which packs the FMU of the scene. The load of the machine is told: on a busy one,
processor times compare better than wall times.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from time import perf_counter

from phaseplane.scenarios.studies.accuracy_report import compared_versions, machine

HERE = Path(__file__).parent
PHASEPLANE = "from phaseplane.scenarios.cli import main; main()"
BARE = ("--set", "show.figures=[]", "--set", "show.recording=false")
# sizes of the figures of `run ap57`, in inches
EMPTY = """
import fmpy, numpy, rerun
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
for i, size in enumerate([(9.0, 7.5), (8.79, 11.5)]):
    figure = Figure(figsize=size, dpi=150)
    FigureCanvasAgg(figure)
    figure.savefig(f"{i}.png")
"""


@dataclass(frozen=True, slots=True)
class Part:
    """One ratio: a command, its reference and its bar.

    Parameters
    ----------
    arguments : of `phaseplane`
    against : code of the reference process
    """

    name: str
    arguments: tuple[str, ...]
    against: str
    bar: float


PARTS = {
    "help": Part("phaseplane --help / import click", ("--help",), "import click", 1.5),
    "bare": Part(
        "run ap57, nothing drawn / import fmpy", ("run", "ap57", *BARE), "import fmpy", 1.8
    ),
    "whole": Part("run ap57 / its libraries and two empty figures", ("run", "ap57"), EMPTY, 1.5),
}


@dataclass(frozen=True, slots=True)
class Seconds:
    """Times of a process, s: wall time, and processor time including its children."""

    clock: float
    processor: float


def begun(code: str, arguments: Sequence[str], folder: Path) -> Seconds:
    """Return the times of one process.

    Raises
    ------
    CalledProcessError : if it fails.
    """
    # as for users: Python keeps its compiled files
    around = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-P", "-c", code, *arguments]
    before, started = _processor_time(), perf_counter()
    subprocess.run(command, cwd=folder, env=around, check=True, capture_output=True)
    return Seconds(perf_counter() - started, _processor_time() - before)


def _processor_time() -> float:
    """Return the processor time of all processes that have been waited for, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)  # `os.times` counts in hundredths
    return used.ru_utime + used.ru_stime


def measured(names: Sequence[str], rounds: int) -> dict[str, tuple[Seconds, Seconds]]:
    """Return the median times of each command and of its reference."""
    processes = {
        **{(name, "ours"): (PHASEPLANE, PARTS[name].arguments) for name in names},
        **{(name, "against"): (PARTS[name].against, ()) for name in names},
    }
    taken: dict[tuple[str, str], list[Seconds]] = {process: [] for process in sorted(processes)}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds + 1):
            for process, times in taken.items():
                times.append(begun(*processes[process], Path(folder)))
    medians = {
        process: Seconds(median(t.clock for t in times[1:]), median(t.processor for t in times[1:]))
        for process, times in taken.items()
    }
    return {name: (medians[name, "ours"], medians[name, "against"]) for name in names}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=15)
    options.add_argument("--only", default=",".join(PARTS))
    options.add_argument("--print", action="store_true", dest="only_print", help="write no file")
    given = options.parse_args()
    load = os.getloadavg()[0]
    found = measured(given.only.split(","), given.rounds)
    ratios = {}
    for name, (ours, against) in found.items():
        part = PARTS[name]
        ratio = ours.clock / against.clock
        ratios[part.name] = {
            "seconds": asdict(ours),
            "against": asdict(against),
            "value": ratio,
            "of_processors": ours.processor / against.processor,
            "bar": part.bar,
            "holds": ratio <= part.bar,
        }
        print(
            f"{part.name:<50} {1e3 * ours.clock:6.0f} ms against {1e3 * against.clock:6.0f} ms: "
            f"{ratio:.2f}, processor time {ours.processor / against.processor:.2f}, bar {part.bar}"
        )
    if not given.only_print:
        data = {
            "date": datetime.now(UTC).date().isoformat(),
            "machine": machine(),
            "versions": compared_versions(),
            "rounds": given.rounds,
            "load": {"processors": os.cpu_count(), "before": load, "after": os.getloadavg()[0]},
            "ratios": ratios,
        }
        (HERE / "startup.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
