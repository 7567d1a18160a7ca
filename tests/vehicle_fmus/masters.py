"""Drives FMUs and systems in hosts of others, in a process of its own: `masters.py HOST JOBS.json`.

A job names the file, communication step, number of steps, start values and the variables to read after
every step; the last line printed is the list of what each job gave.
"""

from __future__ import annotations

import json
import sys
from typing import Any


def libcosimpy(job: dict[str, Any]) -> list[list[float]]:
    """By libcosim (Open Simulation Platform)."""
    from libcosimpy.CosimEnums import CosimVariableType as Kind  # noqa: PLC0415
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    nanoseconds = round(1e9 * job["step"])
    if job["file"].endswith(".fmu"):
        execution = CosimExecution.from_step_size(nanoseconds)
        execution.add_local_slave(CosimLocalSlave(job["file"], "vehicle"))
    else:  # an unpacked system
        execution = CosimExecution.from_ssp_file(job["file"], nanoseconds)
    vehicle = execution.slave_index_from_instance_name("vehicle")
    variables = {v.name.decode(): v for v in execution.slave_variables(vehicle)}
    setters = {
        Kind.REAL: execution.real_initial_value,
        Kind.BOOLEAN: execution.boolean_initial_value,
        Kind.STRING: execution.string_initial_value,
    }
    for name, value in job.get("start", {}).items():
        variable = variables[name]
        setters[Kind(variable.type)](vehicle, variable.reference, value)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    references = [variables[name].reference for name in job["outputs"]]
    rows = []
    for _ in range(job["steps"]):
        if not execution.step():
            raise RuntimeError("a step failed")
        rows.append(observer.last_real_values(vehicle, references))
    return rows


def ecospy(job: dict[str, Any]) -> list[list[float]]:
    """By Ecos."""
    from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: PLC0415

    names = [f"vehicle::{name}" for name in job["outputs"]]

    def run(simulation: EcosSimulation, parameters: str | None) -> list[list[float]]:
        simulation.init(parameter_set=parameters)
        rows = []
        for _ in range(job["steps"]):
            simulation.step()
            rows.append([simulation.get_real(name) for name in names])
        simulation.terminate()
        return rows

    if job["file"].endswith(".ssp"):
        with EcosSimulation(ssp_path=job["file"], step_size=job["step"]) as simulation:
            return run(simulation, None)
    with EcosSimulationStructure() as structure:
        structure.add_model("vehicle", job["file"])
        values = {f"vehicle::{name}": value for name, value in job.get("start", {}).items()}
        if values:
            structure.add_parameter_set("own", values)
        with EcosSimulation(structure=structure, step_size=job["step"]) as simulation:
            return run(simulation, "own" if values else None)


if __name__ == "__main__":
    host, jobs = sys.argv[1:]
    with open(jobs, encoding="utf-8") as file:
        results = [globals()[host](job) for job in json.load(file)]
    print("\n" + json.dumps(results))
