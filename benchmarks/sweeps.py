"""Runs of a sweep per second, results written; writes `sweeps.json`.

    python benchmarks/sweeps.py [--runs 10000] [--rounds 3] [--print]

Quarter cars with lift-off, 2 s at 1e-4, vary in three parameters. They run as a sweep from its file to
its folder, in the integrator's own batch with the same outputs, in a loop over scipy's LSODA, and as a
sweep through the FMU. All are interleaved, and medians of several rounds are compared. Times are wall
time and processor time; on a busy machine processor time is the better measure.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import cases
from measuring import Seconds, arguments, median_of, seconds, stored
from phaseplane.scenarios.sweeps.job import run_sweep
from phaseplane.scenarios.sweeps.plan import Plan, load_plan
from phaseplane.suspension.batch import run_many

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
        taken: dict[str, list[Seconds]] = {way: [] for way in ways}
        for _ in range(rounds):
            for way, (function, _) in ways.items():
                taken[way].append(seconds(function))
    found = {}
    for way, (_, count) in ways.items():
        took = median_of(taken[way])
        found[way] = {
            "runs": count,
            "seconds": took.clock,
            "processor_seconds": took.processor,
            "runs_per_second": count / took.clock,
        }
    return found


def main() -> None:
    given = arguments(__doc__, runs=10_000, rounds=3)
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
        stored("sweeps", {"ways": found, "sweep_over_batch": ratios})


if __name__ == "__main__":
    main()
