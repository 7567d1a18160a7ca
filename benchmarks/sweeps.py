"""Runs of a sweep per second, results written; writes `sweeps.json`.

    python benchmarks/sweeps.py [--runs 10000] [--rounds 3] [--print]

Quarter cars with lift-off, 2 s at 1e-4, vary in three parameters. They run as a sweep from its file to
its folder, in the integrator's own batch with the same outputs, in a loop over scipy's LSODA, and as a
sweep through the FMU. All are interleaved, and medians of several rounds are compared. Times are wall
time and processor time; on a busy machine processor time is the better measure.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

import cases
from phaseplane.scenarios.studies.accuracy_report import compared_versions, machine
from phaseplane.scenarios.sweeps.job import run_sweep
from phaseplane.scenarios.sweeps.plan import Plan, load_plan
from phaseplane.suspension.batch import run_many

HERE = Path(__file__).parent
SWEEP = """
scene = "scene.toml"
method = "latin_hypercube"
runs = {runs}
measures = ["peak.body_displacement", "peak.body_acceleration", "lift_off_count", "airborne_time"]
[vary]
sprung_mass = {{ from = 200.0, to = 400.0 }}
"damper.bump_rate" = {{ from = 300.0, to = 900.0 }}
speed = {{ from = 10.0, to = 25.0 }}
"""
SCENE = """
extends = "ap57"
duration = "2 s"
[parameters]
solver.tolerance = 1e-4
[show]
output_interval = "5 ms"
"""
FEWER = 100  # factor by which the slowest ways have fewer runs


def sweep(folder: Path, runs: int, through: str = "process") -> Callable[[], object]:
    """Return a sweep from its file to its folder."""
    (folder / "scene.toml").write_text(SCENE)
    file = folder / f"{through}.toml"
    file.write_text(SWEEP.format(runs=runs))
    return lambda: run_sweep(file, folder / f"out_{through}", through=through)


def batch(plan: Plan) -> Callable[[], object]:
    """Return the integrator's batch over the same cars, with the outputs that the measures need."""
    sets = [
        {**plan.scene.parameters, **dict(zip(plan.keys, point, strict=True))}
        for point in plan.points
    ]
    count = round(plan.scene.duration / plan.scene.show.output_interval)
    times = [k * plan.scene.show.output_interval for k in range(count + 1)]
    outputs = ["body_displacement", "body_acceleration"]
    ends = ["lift_off_count", "airborne_time"]
    return lambda: run_many(plan.scene.fmu.model, sets, times, outputs, at_end=ends)


def timed(function: Callable[[], object]) -> tuple[float, float]:
    """Return wall time and processor time including children, s."""
    before, started = os.times(), perf_counter()
    function()
    elapsed, after = perf_counter() - started, os.times()
    return elapsed, sum(after[:4]) - sum(before[:4])


def measured(runs: int, rounds: int) -> dict[str, dict[str, float]]:
    """Return the times of each way, s, and its runs per second."""
    lsoda, few = cases.lsoda_run(), max(1, runs // FEWER)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = sweep(folder, runs)
        through_fmu = sweep(folder, few, "fmu")
        ways = {
            "sweep": (whole, runs),
            "batch": (batch(load_plan(folder / "process.toml")), runs),
            "sweep through the FMU": (through_fmu, few),
            "scipy LSODA": (lambda: [lsoda() for _ in range(few)], few),
        }
        taken: dict[str, list[tuple[float, float]]] = {way: [] for way in ways}
        for _ in range(rounds):
            for way, (function, _) in ways.items():
                taken[way].append(timed(function))
    return {
        way: {
            "runs": count,
            "seconds": median(clock for clock, _ in taken[way]),
            "processor_seconds": median(cpu for _, cpu in taken[way]),
            "runs_per_second": count / median(clock for clock, _ in taken[way]),
        }
        for way, (_, count) in ways.items()
    }


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--runs", type=int, default=10_000)
    options.add_argument("--rounds", type=int, default=3)
    options.add_argument("--print", action="store_true", dest="only_print", help="write no file")
    given = options.parse_args()
    found = measured(given.runs, given.rounds)
    for way, row in found.items():
        print(
            f"{way:<22} {row['runs']:>6} runs {row['seconds']:8.2f} s, processor "
            f"{row['processor_seconds']:8.2f} s {row['runs_per_second']:8.1f} runs/s"
        )
    ratios = {
        kind: found["sweep"][kind] / found["batch"][kind]
        for kind in ("seconds", "processor_seconds")
    }
    print(
        f"sweep / batch: {ratios['seconds']:.2f}, processor time {ratios['processor_seconds']:.2f}"
    )
    if not given.only_print:
        data = {
            "machine": machine(),
            "versions": compared_versions(),
            "ways": found,
            "sweep_over_batch": ratios,
        }
        (HERE / "sweeps.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
