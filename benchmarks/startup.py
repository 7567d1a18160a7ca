"""Start-up time: whole commands compared with processes that only import the libraries they need.

    python benchmarks/startup.py [--rounds 15] [--only help,bare,whole] [--print]

Each round starts every process once, one after the other. Ratios are of medians over the rounds,
without the first, which packs the FMU of the scene. The load of the machine is told: on a busy one,
processor times compare better than wall times.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial

from measuring import Seconds, arguments, median_of, seconds, stored

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


def started(code: str, arguments: Sequence[str], folder: str) -> None:
    """Run one process to its end.

    Raises
    ------
    CalledProcessError : if it fails.
    """
    # as for users: Python keeps its compiled files
    around = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    command = [sys.executable, "-P", "-c", code, *arguments]
    subprocess.run(command, cwd=folder, env=around, check=True, capture_output=True)


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
                times.append(seconds(partial(started, *processes[process], folder)))
    medians = {process: median_of(times[1:]) for process, times in taken.items()}
    return {name: (medians[name, "ours"], medians[name, "against"]) for name in names}


def main() -> None:
    given = arguments(__doc__, rounds=15, only=",".join(PARTS))
    ratios = {}
    for name, (ours, against) in measured(given.only.split(","), given.rounds).items():
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
        stored("startup", {"rounds": given.rounds, "ratios": ratios})


if __name__ == "__main__":
    main()
