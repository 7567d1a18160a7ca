"""Every FMU takes the same internal steps however it is stepped, rolled back or moved elsewhere."""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest
from hosting import in_python
from phaseplane.suspension.models import FILES
from phaseplane.suspension.session import unsealed
from phaseplane.suspension.variables import MODELS

END = 0.25  # s
STEPPED = [model for model in FILES if model in MODELS]
# an instant in mid flight, or in mid yielding
AMID = {"QuarterCar": 0.05, "HalfCar": 0.17, "Elastoplastic": 0.45}


@pytest.fixture(params=STEPPED)
def model(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def outputs(vehicle: Any) -> list[str]:
    return [v.name for v in vehicle.description.modelVariables if v.causality == "output"]


def read(vehicle: Any) -> list[Any]:
    return [vehicle.get(name) for name in outputs(vehicle)]


def kept(vehicle: Any) -> bytes:
    state = vehicle.fmu.getFMUstate()
    content = bytes(vehicle.fmu.serializeFMUstate(state))
    vehicle.fmu.freeFMUstate(state)
    return content


def internal(vehicle: Any) -> str:
    """The integrator's whole state, bit by bit."""
    session = unsealed(kept(vehicle))["session"].encode()
    return str(unsealed(session)["integrator"])


def grid(step: float, jitter: float = 0.0) -> list[float]:
    """Communication points up to END, moved by rounding errors."""
    inner = np.arange(1, round(END / step + 0.4)) * step
    moved = inner * (1.0 + jitter * np.random.default_rng(1).uniform(-1.0, 1.0, len(inner)))
    return [0.0, *(float(t) for t in moved if t < END - 1e-9), END]


def walk(vehicle: Any, times: list[float]) -> dict[float, list[Any]]:
    rows = {}
    for before, now in itertools.pairwise(times):
        vehicle.step(before, now)
        rows[now] = read(vehicle)
    return rows


def test_internal_steps_are_the_same_whatever_the_communication_step(vehicle: Any) -> None:
    found, shared = [], []
    varied = [0.0, *sorted(np.random.default_rng(2).uniform(0.0, END, 60).tolist()), END]
    grids = [[0.0, END], grid(1e-4), grid(1e-3), grid(7.3e-3), grid(1e-3, 4e-16), varied]
    for times in grids:
        with vehicle.instance():
            vehicle.start()
            if len(times) > 1000:  # so that reading does not take for ever
                for before, now in itertools.pairwise(times):
                    vehicle.step(before, now)
                rows = {END: read(vehicle)}
            else:
                rows = walk(vehicle, times)
            found.append(internal(vehicle))
            shared.append(rows)
    assert len(set(found)) == 1
    for rows in shared[1:]:
        for instant in rows.keys() & shared[2].keys():
            assert rows[instant] == shared[2][instant]
    assert all(END in rows for rows in shared)


def test_rolling_back_leaves_no_trace(vehicle: Any) -> None:
    times = grid(7.3e-3)
    with vehicle.instance():
        vehicle.start()
        straight = walk(vehicle, times)
        expected = internal(vehicle)
    with vehicle.instance():
        vehicle.start()
        rows = {}
        for before, now in itertools.pairwise(times):
            state = vehicle.fmu.getFMUstate()
            vehicle.step(before, before + 0.021)  # too far
            vehicle.fmu.setFMUstate(state)
            vehicle.fmu.freeFMUstate(state)
            vehicle.step(before, now)
            rows[now] = read(vehicle)
        assert rows == straight
        assert internal(vehicle) == expected


_CONTINUE = """
import json, sys
from fmpy import read_model_description
from fmpy.simulation import instantiate_fmu
folder, start, state, names = sys.argv[1], float(sys.argv[2]), sys.argv[3], sys.argv[4:]
description = read_model_description(folder)
references = {v.name: v.valueReference for v in description.modelVariables}
fmu = instantiate_fmu(folder, description, "CoSimulation")
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
fmu.setFMUstate(fmu.deSerializeFMUstate(bytes.fromhex(state)))
rows = []
for k in range(20):
    fmu.doStep(start + 0.01 * k, 0.01)
    rows.append([x.hex() for x in fmu.getReal([references[n] for n in names])])
fmu.freeInstance()
print(json.dumps(rows))
"""


@pytest.mark.sampled
@pytest.mark.parametrize("model", AMID)
@pytest.mark.parametrize("given", [{}, {"road__shape": "input"}])
def test_another_process_continues_to_the_bit(
    model: str, given: dict[str, str], host: Any, folders: dict[str, str]
) -> None:
    vehicle, instant = host(folders[model]), AMID[model]
    if model == "Elastoplastic":
        given = {}
    names = [v.name for v in vehicle.description.modelVariables
             if v.causality == "output" and v.type == "Real"]  # fmt: skip
    with vehicle.instance():
        vehicle.start(**given)
        if given:  # thrown up by a road that falls away
            axle = "" if model == "QuarterCar" else "rear_"
            vehicle.set(**{f"{axle}road_elevation": 0.05, f"{axle}road_velocity": -4.0})
        vehicle.step(0.0, instant)
        amid = {"QuarterCar": "airborne", "HalfCar": "rear_airborne", "Elastoplastic": "yielding"}
        assert vehicle.get(amid[model])
        state = kept(vehicle)
        rows = []
        for k in range(20):
            vehicle.step(instant + 0.01 * k, instant + 0.01 * k + 0.01)
            rows.append([vehicle.get(name).hex() for name in names])
    assert json.loads(in_python(_CONTINUE, folders[model], instant, state.hex(), *names)) == rows
