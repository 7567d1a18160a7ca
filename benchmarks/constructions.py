"""Speed of constructing the geometry of a motion, and of writing its recording.

    python benchmarks/constructions.py [--steps 10000] [--rounds 5]

The worked example with lift-off on a random road, in steps of 0.1 ms. Measurements are interleaved,
and medians of the processor time are printed.
"""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

from measuring import arguments, medians
from phaseplane.scenarios.draw.planes import planes_of
from phaseplane.suspension.variables import checked_parameters

from phaseplane.constructions import RULES, construct_motion, delta
from phaseplane.recording import DETAILS, Content, record


def main() -> None:
    """Print frames per second of geometry, for each rule, and of recording, for each detail."""
    given = arguments(__doc__, steps=10_000, rounds=5)
    road = {"road.shape": "random", "road.class": "C", "road.length": 40.0}
    planes = planes_of("QuarterCar", checked_parameters("QuarterCar", road), {})
    drawing = construct_motion(planes, delta, step=1e-4, steps=given.steps)
    with tempfile.TemporaryDirectory() as folder:
        geometry = {
            f"geometry, {rule.name}": partial(
                construct_motion, planes, rule, step=1e-4, steps=given.steps
            )
            for rule in RULES.values()
        }
        recording = {
            f"recording, {detail}": partial(
                record,
                Content(drawing.title, drawing, detail=detail),
                Path(folder, f"{detail}.rrd"),
            )
            for detail in DETAILS
        }
        times = medians({**geometry, **recording}, given.rounds)
    frames = len(drawing.frames)
    print(f"{frames} frames\n")
    for what, taken in times.items():
        print(f"{what:<32}{taken:>8.3f} s  {frames / taken:>9.0f} frames/s")


if __name__ == "__main__":
    main()
