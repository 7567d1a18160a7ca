"""Instances made and freed by the thousand: none fails, and they grow by the wrapper's leak alone."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from fmpy import extract
from hosting import in_python
from phaseplane.vehicle_fmus.wrapper import mend_unpacked

CYCLES = 1000
# What a slave that does nothing loses in one cycle is the wrapper's doing; ours may add this much.
ALLOWED = 2.0  # KiB

_EMPTY_SLAVE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Empty(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = 0.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        return True
"""

_CYCLE = """
import gc, json, sys
from pathlib import Path
from fmpy import read_model_description
from fmpy.simulation import instantiate_fmu

folder, cycles = sys.argv[1], int(sys.argv[2])
description = read_model_description(folder)

def cycle(k):
    fmu = instantiate_fmu(folder, description, "CoSimulation")
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    for step in range(10):
        fmu.doStep(0.01 * step, 0.01)
        fmu.getReal([description.outputs[0].variable.valueReference])
    state = fmu.getFMUstate() if description.coSimulation.canGetAndSetFMUstate else None
    if state is not None:
        fmu.freeFMUstate(state)
    fmu.terminate()
    fmu.freeInstance()

def resident():
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4.0

for k in range(cycles // 5):
    cycle(k)
before = resident()
for k in range(cycles):
    cycle(k)
print(json.dumps((resident() - before) / cycles))
"""


def growth(folder: str) -> float:
    """KiB by which a process grows in one cycle."""
    return float(in_python(_CYCLE, folder, CYCLES))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="not on this platform: reads /proc")
def test_a_thousand_cycles(folders: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "empty.py").write_text(_EMPTY_SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "empty.py", "--handle-state"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    empty = extract(str(tmp_path / "Empty.fmu"), str(tmp_path / "empty"))
    mend_unpacked(Path(empty))  # as ours is, so that it ends as well
    wrapper = growth(empty)
    ours = growth(folders["QuarterCar"])
    print(f"KiB for each cycle: {ours:.2f}, of which the wrapper's own {wrapper:.2f}")
    assert ours - wrapper < ALLOWED
