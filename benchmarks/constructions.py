"""Speed of constructing the geometry of a motion, and of writing its recording.

    python benchmarks/constructions.py [STEPS]

The worked example with lift-off on a random road, in steps of 0.1 ms. Measurements are interleaved,
and the median of five is printed.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

from phaseplane.scenarios.draw.planes import planes_of
from phaseplane.suspension.variables import checked_parameters

from phaseplane.constructions import RULES, construct_motion
from phaseplane.recording import Content, record

REPEATS = 5


def main(steps: int = 10_000) -> None:
    """Print frames per second of geometry, for each rule, and of recording, for each detail."""
    road = {"road.shape": "random", "road.class": "C", "road.length": 40.0}
    planes = planes_of("QuarterCar", checked_parameters("QuarterCar", road), {})
    times: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(REPEATS):
            for rule in RULES.values():
                started = perf_counter()
                drawing = construct_motion(planes, rule, step=1e-4, steps=steps)
                times.setdefault(f"geometry, {rule.name}", []).append(perf_counter() - started)
            for detail in ("trail", "steps", "stages"):
                started = perf_counter()
                shown = Content(drawing.title, drawing, detail=detail)
                record(shown, Path(folder, f"{detail}.rrd"))
                times.setdefault(f"recording, {detail}", []).append(perf_counter() - started)
    frames = len(drawing.frames)
    print(f"{frames} frames\n")
    for what, seconds in times.items():
        taken = median(seconds)
        print(f"{what:<32}{taken:>8.3f} s  {frames / taken:>9.0f} frames/s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
