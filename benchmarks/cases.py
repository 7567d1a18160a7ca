"""The functions to time: single steps, whole runs, and thousands of runs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib import import_module
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Any

import hard_coded
from phaseplane.scenarios.studies import peers
from phaseplane.scenarios.studies.accuracy import Solver, solvers
from phaseplane.scenarios.studies.problems import PROBLEMS
from phaseplane.scenarios.studies.reference import largest_error, truth
from phaseplane.scenarios.studies.workbench import Prepared, UnableError, Workbench
from phaseplane.suspension import engine
from phaseplane.suspension.batch import run_many

STEP, DURATION = 1e-3, 2.0
STEPS = round(DURATION / STEP)
PACKAGED = ("numbalsoda dop853", "numbalsoda lsoda", "heyoka")
"""The peers that are within an order of magnitude."""
_BLOW_OFF = {
    "damper.rebound_limit": 588.0, "damper.bump_limit": 294.0, "damper.limit_slope": 300.0,
    "solver.tolerance": 1e-4,
}  # fmt: skip
_DRAWN = {
    "sprung_mass": (200.0, 400.0), "damper.rebound_rate": (1500.0, 2500.0),
    "speed": (10.0, 25.0), "road.height": (0.03, 0.06),
}  # fmt: skip
RACERS = ("extrapolated", *PACKAGED, "rk4, numba")


def uncompiled_integrator() -> Any:
    """Import the integrator from its Python source, in addition to the compiled one."""
    name = "uncompiled_kernel"
    package = ModuleType(name)
    package.__path__ = [str(engine.KERNEL)]
    sys.modules.setdefault(name, package)
    with engine._cython_directives():
        return import_module(f"{name}.integrator").Integrator


def fixed_steps(integrator_class: Any, method: str = "equilibrium") -> Callable[[], int]:
    """Return a run of the quarter car over its bump in fixed steps, which returns their number."""
    integrator = integrator_class(PROBLEMS["lift_off"]().system, method, STEP, energy=False)
    start = integrator.snapshot()

    def go() -> int:
        assert integrator.advance(DURATION) == 0
        return int(integrator.step_count)

    return Prepared(lambda: integrator.restore(start), go)


def hard_coded_steps(folder: Path) -> dict[str, Callable[[], object]]:
    """Return the same steps hard-coded in C, in numba if installed, and in plain floats."""
    made: dict[str, Callable[[], object]] = {
        "C": partial(hard_coded.compiled_by_cc(folder), STEPS, STEP)
    }
    try:
        from numba import njit  # noqa: PLC0415
    except ImportError:
        pass
    else:
        made["numba"] = partial(njit(hard_coded.run), STEPS, STEP)
    return made | {"plain floats": partial(hard_coded.run, STEPS, STEP)}


def c_steps_in_threads(folder: Path, threads: int) -> Callable[[], object]:
    """Return hard-coded steps in C: runs of a few milliseconds distributed to threads."""
    run = hard_coded.compiled_by_cc(folder)
    pool = ThreadPoolExecutor(threads)
    # short enough that the motion does not decay to denormal numbers, which are slow
    return lambda: list(pool.map(run, [100 * STEPS] * 10, [STEP] * 10))


def racers(problem: str) -> list[tuple[Solver, float, float, Callable[[], object]]]:
    """Return solver, setting, error and run of the fast solvers on a problem."""
    made = PROBLEMS[problem]()
    bench = Workbench(made, truth(made))
    interval = made.duration / made.intervals
    found = []
    for solver in solvers(with_peers=True):
        if solver.name not in RACERS or solver.family == "FMU" or solver.missing:
            continue
        for value in solver.values:
            setting = value * interval if solver.knob == "step" else value
            try:
                run = solver.prepare(bench, setting)
                error = largest_error(run(), bench.true)
            except (UnableError, ArithmeticError):
                continue
            found.append((solver, setting, error, run))
            if error < 1e-12:
                break
    return found


def lsoda_run(tolerance: float = 1e-4) -> Callable[[], object]:
    """Return a run of 2 s by scipy's LSODA with a compiled right-hand side."""
    problem = PROBLEMS["lift_off"]()
    return peers.scipy_method("LSODA", Workbench(problem, truth(problem)), tolerance)


def batch_of_runs(count: int, workers: int) -> Callable[[], object]:
    """Return a batch of different quarter cars, 2 s at 1e-4, with lift-off and blow-off."""
    random = Random(1)
    cars = [
        {**_BLOW_OFF, **{name: random.uniform(*between) for name, between in _DRAWN.items()}}
        for _ in range(count)
    ]
    times = [k * DURATION / 400 for k in range(401)]
    outputs = ("body_displacement", "wheel_displacement")
    return lambda: run_many("QuarterCar", cars, times, outputs, workers)
