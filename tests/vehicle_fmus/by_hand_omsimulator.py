"""An FMU and a system in OMSimulator, compared with this process; to be run by hand.

    python tests/vehicle_fmus/by_hand_omsimulator.py /path/to/bin/OMSimulator

OMSimulator is no Python program, so libpython is loaded before it. Nothing but a difference below 1e-9 of
the peak ends with status 0.
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from phaseplane.suspension.session import Session
from phaseplane.vehicle_fmus.build import build
from phaseplane.vehicle_fmus.systems import connections

MODEL, STEP, STEPS = "QuarterCar", 1e-3, 200  # s
SHOWN = ("body_displacement", "wheel_velocity", "contact_force")


def in_omsimulator(program: str, file: Path) -> list[list[float]]:
    """The values shown after every step."""
    library = Path(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("INSTSONAME"))
    results = file.with_name(f"{file.stem}_results.csv")
    subprocess.run(
        [program, f"--stopTime={STEP * STEPS}", f"--stepSize={STEP}", f"--resultFile={results}",
         f"--tempDir={file.parent}", str(file)],
        check=True, env={**os.environ, "LD_PRELOAD": str(library)},
    )  # fmt: skip
    with results.open() as stream:
        rows = list(csv.DictReader(stream))
    columns = [next(key for key in rows[0] if key.strip('" ').endswith(name)) for name in SHOWN]
    at = {round(float(row["time"]) / STEP): [float(row[key]) for key in columns] for row in rows}
    return [at[k] for k in range(1, STEPS + 1)]


def here(sampled: bool) -> list[list[float]]:
    """The same in this process: with a road of its own, or with samples of one."""
    vehicle = Session(MODEL, {"road.shape": "input"} if sampled else {})
    road = Session("Road", {})
    rows = []
    for k in range(1, STEPS + 1):
        for output, name in connections(MODEL).items() if sampled else ():
            vehicle.set_input(name, float(road.value(output)))
        vehicle.advance(k * STEP)
        road.advance(k * STEP)
        rows.append([float(vehicle.value(name)) for name in SHOWN])
    return rows


def main(program: str) -> int:
    """Run both, print the largest differences."""
    good = True
    with tempfile.TemporaryDirectory() as folder:
        build([MODEL], Path(folder), ssp=True)
        for kind in ("fmu", "ssp"):
            theirs = in_omsimulator(program, Path(folder, f"{MODEL}.{kind}"))
            ours = here(sampled=kind == "ssp")
            for name, one, other in zip(
                SHOWN, zip(*ours, strict=True), zip(*theirs, strict=True), strict=True
            ):
                apart = max(abs(a - b) for a, b in zip(one, other, strict=True))
                apart /= max(map(abs, one))
                good = good and apart < 1e-9
                print(f"{MODEL}.{kind}  {name:<20} {apart:.1e} of the peak")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
