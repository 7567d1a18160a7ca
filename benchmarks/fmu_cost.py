"""Cost of an FMU compared with FMPy's own; writes `fmu_cost.json`.

    python benchmarks/fmu_cost.py [--print]

Four FMUs are stepped in turn, so that a busy machine slows all of them: one in C and a pythonfmu
slave that do nothing, and `QuarterCar` of both kinds. Minima of the processor time of short series of
steps are compared. A host in C steps the native one by itself.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

from fmpy import extract, read_model_description
from fmpy.model_description import ModelVariable
from fmpy.simulation import instantiate_fmu
from measuring import arguments, medians, stored
from native_fmu import OUTPUTS, native_fmu
from phaseplane.vehicle_fmus.build import build
from phaseplane.vehicle_fmus.native import compilers, pack
from phaseplane.vehicle_fmus.wrapper import mend_unpacked

import phaseplane

STEP, STRETCH, ROUNDS = 1e-3, 40, 25  # s, steps
READ = (
    "body_displacement", "body_velocity", "body_acceleration", "wheel_displacement",
    "wheel_velocity", "wheel_acceleration", "suspension_deflection", "contact_force",
)  # fmt: skip

_EMPTY_SLAVE = f"""
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Empty(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = [0.0] * {OUTPUTS}
        for k in range({OUTPUTS}):
            self.register_variable(
                Real(f"y{{k}}", causality=Fmi2Causality.output, getter=lambda: 0.0)
            )

    def do_step(self, current_time, step_size):
        return True

    def get_real(self, vrs):
        values = self.values
        return [values[vr] for vr in vrs]
"""


def empty_fmu(folder: Path) -> Path:
    """Build a pythonfmu slave that does nothing, to measure the cost of the wrapper."""
    (folder / "empty.py").write_text(_EMPTY_SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "empty.py"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "Empty.fmu"


def instance(fmu: Path) -> tuple[Any, dict[str, ModelVariable]]:
    """Return an instance of an FMU in FMPy's slave interface, and its variables by name."""
    folder = extract(str(fmu))
    mend_unpacked(Path(folder))  # an FMU that only pythonfmu has packed
    description = read_model_description(folder, validate=False)
    made = instantiate_fmu(folder, description, "CoSimulation")
    return made, {v.name: v for v in description.modelVariables}


def begin_anew(slave: Any) -> None:
    """Let an instance begin at its start."""
    slave.reset()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()


def stepped(fmu: Path, names: tuple[str, ...]) -> Callable[[], float]:
    """Return what measures one step and eight values: the least time over series of steps of a run, s."""
    slave, known = instance(fmu)
    read = [known[name].valueReference for name in names]

    def least() -> float:
        begin_anew(slave)
        best = float("inf")
        for k in range(ROUNDS):
            started = process_time()
            for step in range(k * STRETCH, (k + 1) * STRETCH):
                slave.doStep(step * STEP, STEP)
                slave.getReal(read)
            best = min(best, (process_time() - started) / STRETCH)
        return best

    return least


def native_car(folder: Path, **settings: object) -> Path:
    """Pack the native FMU for this machine."""
    given = {name.replace("__", "."): value for name, value in settings.items()}
    platforms = [compilers.this_platform()]
    (file,) = pack.build(
        ["QuarterCar"], folder / "native", platforms=platforms, parameters={"QuarterCar": given}
    )
    return file


def best_of(functions: dict[str, Callable[[], float]], rounds: int) -> dict[str, float]:
    """Return the least value of each function over interleaved rounds."""
    found = [{name: function() for name, function in functions.items()} for _ in range(rounds)]
    return {name: min(one[name] for one in found) for name in functions}


def step_costs(folder: Path, rounds: int = 15) -> dict[str, float]:
    """Return the time of one doStep and eight getReal for each of the four FMUs, s."""
    blank = tuple(f"y{k}" for k in range(OUTPUTS))
    functions = {
        "empty": stepped(native_fmu(folder), blank),
        "wrapper": stepped(empty_fmu(folder), blank),
        "QuarterCar": stepped(build(["QuarterCar"], folder)[0], READ),
        "native QuarterCar": stepped(native_car(folder), READ),
    }
    return best_of(functions, rounds)


def in_host(folder: Path, fmu: Path, what: str, *words: object) -> list[float]:
    """Let the host in C measure a native FMU; words that are names of variables become references."""
    unpacked = Path(extract(str(fmu)))
    description = read_model_description(str(unpacked), validate=False)
    references = {v.name: v.valueReference for v in description.modelVariables}
    source = Path(__file__).parents[1] / "tests" / "vehicle_fmus" / "native" / "loading.c"
    program = folder / "loading"
    subprocess.run(
        ["cc", "-O2", f"-I{pack.HEADERS}", "-o", str(program), str(source), "-ldl"], check=True
    )
    library = unpacked / "binaries" / "linux64" / "QuarterCar.so"
    done = subprocess.run(
        [str(program), str(library), description.guid, what,
         *(str(references.get(str(word), word)) for word in words)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return [1e-9 * float(time) for time in done.stdout.split()]


def host_costs(folder: Path) -> dict[str, float]:
    """Return the processor time of the native FMU in a host in C, s: a step with 8 values, an instance.

    An instance is made, initialised and freed. On 200 m of random road, with 640 corners a second, the
    integrator makes two steps in three of the host's.
    """
    step, instance = in_host(folder, native_car(folder), "time", 1000, STEP, *READ)
    random = native_car(folder, road__shape="random")
    on_random, another = in_host(folder, random, "time", 1000, STEP, *READ)
    return {
        "step": step,
        "instance": instance,
        "step on random road": on_random,
        "instance with random road": another,
    }


def tuned_in_python(folder: Path, rounds: int = 5) -> dict[str, float]:
    """Return the time of a doStep of the Python FMU, and of one with another damper rate before, s.

    On a road as input, and on a bump, where the integrator goes ahead as long as nothing changes. The
    first changes, in which the system is built again, are not counted.
    """
    functions: dict[str, Callable[[], float]] = {}
    for shape in ("input", "bump"):
        (fmu,) = build(["QuarterCar"], folder, parameters={"QuarterCar": {"road.shape": shape}})
        slave, known = instance(fmu)
        rate = known["damper.rebound_rate"].valueReference
        for tuned in (False, True):
            what = f"{'setReal + ' if tuned else ''}doStep on {shape}"
            functions[what] = partial(_time_tuned, slave, rate, tuned=tuned)
    return best_of(functions, rounds)


def _time_tuned(slave: Any, rate: int, *, tuned: bool) -> float:
    begin_anew(slave)
    steps = ROUNDS * STRETCH
    started = 0.0
    for step in range(-STRETCH, steps):
        if step == 0:
            started = process_time()
        if tuned:
            slave.setReal([rate], [1500.0 + step])
        slave.doStep((STRETCH + step) * STEP, STEP)
    return (process_time() - started) / steps


def tuning_costs(folder: Path) -> dict[str, float]:
    """Return the processor time of a step on a road as input, and of one with another spring rate, s.

    On a random road, too, where the integrator goes ahead as long as nothing changes.
    """
    found = []
    for shape in ("input", "random"):
        fmu = native_car(folder, road__shape=shape)
        found.append(in_host(folder, fmu, "tune", 1000, STEP, "spring.rate", 30000.0))
    (step, tuned), (_, on_random) = found
    return {
        "step on sampled road": step,
        "step with parameter tuned": tuned,
        "step with parameter tuned on random road": on_random,
    }


def run_costs(folder: Path, rounds: int = 9) -> dict[str, float]:
    """Return the processor time of `phaseplane.run` with its measures, 4 s at 1 ms, s.

    "FMPy" calls doStep, getReal, getInteger and getBoolean of the same FMU for the same outputs.
    """
    seconds = 4.0
    through_fmu = phaseplane.run("ap57", through="fmu", duration=seconds)
    slave, known = instance(build(["QuarterCar"], folder)[0])
    wanted: dict[str, list[int]] = {"Real": [], "Integer": [], "Boolean": []}
    for variable in known.values():
        if variable.causality == "output" and variable.name in through_fmu:
            wanted[variable.type].append(variable.valueReference)

    def by_fmpy() -> None:
        begin_anew(slave)
        for step in range(round(seconds / STEP)):
            slave.doStep(step * STEP, STEP)
            for kind, references in wanted.items():
                getattr(slave, f"get{kind}")(references)

    return medians(
        {
            "in process": lambda: phaseplane.run("ap57", duration=seconds),
            "through the FMU": lambda: phaseplane.run("ap57", through="fmu", duration=seconds),
            "FMPy": by_fmpy,
        },
        rounds,
    )


def main() -> None:
    given = arguments(__doc__)
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        step = step_costs(folder)
        tables = {
            "doStep + 8 getReal": step,
            "native QuarterCar in a host in C": host_costs(folder) | tuning_costs(folder),
            "QuarterCar whose damper rate changes in every step": tuned_in_python(folder),
            "phaseplane.run with its measures, 4 s at 1 ms": run_costs(folder),
        }
    results: dict[str, dict[str, float]] = {
        f"{what}, us": {name: round(1e6 * t, 2) for name, t in table.items()}
        for what, table in tables.items()
    }
    cars = ("QuarterCar", "native QuarterCar")
    results["ratio to the empty one"] = {car: round(step[car] / step["empty"], 2) for car in cars}
    print(json.dumps(results, indent=1))
    if not given.only_print:
        stored("fmu_cost", results)


if __name__ == "__main__":
    main()
