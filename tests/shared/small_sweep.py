"""A sweep of six short runs, and its files."""

from __future__ import annotations

import csv
from pathlib import Path

from command_line import written

GRID = """
scene = "scene.toml"
measures = ["peak.body_displacement", "lift_off_count"]
[vary]
speed = { from = "36 km/h", to = 20.0, count = 3 }
"road.height" = ["2 cm", 0.05]
"""
HEAD = GRID.partition("[vary]")[0]
SCENE = """
fmu = "QuarterCar"
duration = 0.2
[show]
output_interval = "5 ms"
"""


def sweep_file(text: str = GRID, name: str = "sweep.toml") -> str:
    return written(text, name)


def rows(folder: str = "out/sweeps/sweep") -> list[dict[str, str]]:
    with Path(folder, "runs.csv").open(newline="") as file:
        return list(csv.DictReader(file))
