"""Python hosts that end in several ways: `ending.py HOST ENDING FREED STATUS FMU...`.

Every FMU is instantiated and stepped. ENDING says how the host ends: `done`; `refused`, after the last
FMU has refused a value; or `interrupted`, by SIGINT, which it waits for once it has printed `waiting`.
FREED says how many instances are freed, the first ones (in libcosim and Ecos all or none can be). The
host ends with STATUS.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from math import nan
from time import sleep
from typing import Any

Free = Callable[[int], Any]
alive: list[Any] = []  # what is not freed lives until the interpreter ends


def fmpy(files: Sequence[str], refused: bool) -> Free:
    """By FMPy: a parameter is refused at the end of initialisation, or by the first step."""
    from fmpy import extract, read_model_description  # noqa: PLC0415
    from fmpy.fmi1 import FMICallException  # noqa: PLC0415
    from fmpy.simulation import instantiate_fmu  # noqa: PLC0415

    for file in files:
        folder = extract(file)
        description = read_model_description(folder)
        fmu = instantiate_fmu(folder, description, "CoSimulation")
        alive.append(fmu)
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        try:
            if refused and file == files[-1]:
                fmu.setReal([0], [-1.0])
            fmu.exitInitializationMode()
            fmu.doStep(0.0, 0.01)
        except FMICallException:
            assert refused
        else:
            assert not (refused and file == files[-1])

    def free(count: int) -> None:
        for fmu in alive[:count]:
            fmu.freeInstance()

    return free


def libcosimpy(files: Sequence[str], refused: bool) -> Free:
    """By libcosim: a step is refused, after an input that is not a number."""
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415
    from libcosimpy.CosimManipulator import CosimManipulator  # noqa: PLC0415
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415

    log_output_level(CosimLogLevel.FATAL)
    execution = CosimExecution.from_step_size(10_000_000)
    slaves = [CosimLocalSlave(file, f"vehicle {k}") for k, file in enumerate(files)]
    indices = [execution.add_local_slave(slave) for slave in slaves]
    alive.extend([execution, *slaves])
    assert execution.step()
    if refused:
        override = CosimManipulator.create_override()
        execution.add_manipulator(override)
        alive.append(override)
        variables = {v.name: v.reference for v in execution.slave_variables(indices[-1])}
        override.slave_real_values(indices[-1], [variables[b"body_force"]], [nan])
        assert not execution.step()
    del execution, slaves
    return lambda count: count and alive.clear()


def ecospy(files: Sequence[str], refused: bool) -> Free:
    """By Ecos: a step is refused, after an input that is not a number."""
    from ecospy import EcosSimulation, EcosSimulationStructure  # noqa: PLC0415

    structure = EcosSimulationStructure()
    for k, file in enumerate(files):
        structure.add_model(f"vehicle{k}", file)
    if refused:
        structure.add_parameter_set("refused", {f"vehicle{len(files) - 1}::body_force": nan})
    simulation = EcosSimulation(structure=structure, step_size=0.01)
    alive.extend([structure, simulation])
    simulation.init(parameter_set="refused" if refused else None)
    simulation.step()
    good = simulation.get_bool(f"vehicle{len(files) - 1}::ok")
    assert good != refused
    del structure, simulation

    def free(count: int) -> None:
        if count:
            alive[1].terminate()
            alive.clear()

    return free


def main(host: str, ending: str, freed: str, status: str, *files: str) -> int:
    """Run the FMUs to their end."""
    free = globals()[host](files, ending == "refused")
    if ending == "interrupted":
        try:
            print("waiting", flush=True)
            while True:
                sleep(0.01)  # `signal.pause` misses what comes just before it
        except KeyboardInterrupt:
            pass
    free(int(freed))
    return int(status)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
