"""The functions to time: single steps, whole runs, and thousands of runs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Any

import hard_coded
from dop853 import landing
from phaseplane.scenarios.studies import peers, project_solvers
from phaseplane.scenarios.studies.accuracy import Solver, solvers
from phaseplane.scenarios.studies.problems import PROBLEMS, of_model
from phaseplane.scenarios.studies.reference import largest_error, truth
from phaseplane.scenarios.studies.workbench import Prepared, Run, UnableError, Workbench
from phaseplane.suspension import characteristics, engine, roads
from phaseplane.suspension.batch import run_many
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, System

STEP, DURATION = 1e-3, 2.0
STEPS = round(DURATION / STEP)
STRAIGHT = ("lift_off", "half_car")
"""Races on systems that are linear in each branch."""
CURVED = ("curved", "curved_half_car")
"""Races on systems with a curved force in each suspension."""
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
ANEW, LANDING = "extrapolated, begun anew", "hard-coded dop853, numba"
RESTORES, TUNINGS = 1000, 300  # in one call


def uncompiled_integrator() -> Any:
    """Import the integrator from its Python source, in addition to the compiled one."""
    name = "uncompiled_kernel"
    package = ModuleType(name)
    package.__path__ = [str(engine.KERNEL)]
    sys.modules.setdefault(name, package)
    with engine.cython_directives():
        return import_module(f"{name}.interface").Integrator


def fixed_steps(
    integrator_class: Any, method: str = "equilibrium", system: System | None = None
) -> Callable[[], int]:
    """Return a run in fixed steps, of the quarter car over its bump, which returns their number."""
    system = system or PROBLEMS["lift_off"]().system
    integrator = integrator_class(system, method, STEP, energy=False)
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


@dataclass(frozen=True, slots=True)
class Racer:
    """A run by one solver at one setting, and its error relative to the largest displacement."""

    solver: str
    setting: float
    error: float
    run: Run


@cache
def workbench(problem: str, **parameters: float) -> Workbench:
    """Return the workbench of a problem, with some parameters changed."""
    made = PROBLEMS[problem]()
    if parameters:
        changed = {name.replace("__", "."): value for name, value in parameters.items()}
        made = of_model("", "", made.kind, made.model, {**made.parameters, **changed})
    return Workbench(made, truth(made))


def racers(problem: str) -> list[Racer]:
    """Return the fast solvers on a problem, each at all settings that it can take."""
    bench = workbench(problem)
    made = bench.problem
    interval = made.duration / made.intervals
    entered = [
        solver
        for solver in solvers(with_peers=True)
        if solver.name in RACERS and solver.family != "FMU" and not solver.missing
    ]
    tolerances = entered[0].values
    entered += [
        Solver(ANEW, "incremental", "tolerance", tolerances, begun_anew),
        Solver(LANDING, "peer", "tolerance", tolerances, landing, ("numba",)),
    ]
    found = []
    for solver in entered:
        if solver.missing:
            continue
        for value in solver.values:
            setting = value * interval if solver.knob == "step" else value
            try:
                run = solver.prepare(bench, setting)
                error = largest_error(run(), bench.true)
            except UnableError:
                break
            except ArithmeticError:
                continue
            found.append(Racer(solver.name, setting, error, run))
            if error < 1e-12:
                break
    return found


def begun_anew(bench: Workbench, tolerance: float) -> Run:
    """Return a run of the default solver that includes the return to its start."""
    prepared = project_solvers.in_process(bench, tolerance=tolerance)

    def run() -> Any:
        prepared.reset()
        return prepared.go()

    return run


def session_steps() -> Callable[[], int]:
    """Return a run of a session in fixed steps, energy ledger included, which returns their number."""
    made = workbench("lift_off").problem
    fixed = {"solver.method": "equilibrium", "solver.step": STEP}
    session = Session(made.model, {**made.parameters, **fixed})
    start = session.snapshot()

    def go() -> int:
        session.advance(DURATION)
        return int(session.integrator.step_count)

    return Prepared(lambda: session.restore(start), go)


def new_session() -> Callable[[], object]:
    """Return the making of a session of the quarter car from a few parameters."""
    return lambda: Session("QuarterCar", {"sprung_mass": 310.0, "speed": 15.0})


def tunings(road: str) -> Callable[[], int]:
    """Return a run on a road in which a parameter changes every millisecond, and how often it does."""
    sessions: list[Session] = []

    def go() -> int:
        for k in range(TUNINGS):
            sessions[-1].set_parameter("damper.rebound_rate", 1000.0 + k)
            sessions[-1].advance(1e-3 * (k + 1))
        return TUNINGS

    return Prepared(lambda: sessions.append(Session("QuarterCar", {"road.shape": road})), go)


def restores() -> Callable[[], object]:
    """Return many returns of the quarter car's integrator to its start."""
    integrator = Integrator(PROBLEMS["lift_off"]().system)
    start = integrator.snapshot()

    def go() -> None:
        for _ in range(RESTORES):
            integrator.restore(start)

    return go


def chain(masses: int) -> System:
    """Return masses in a row, joined by linear springs and dampers, the first one also to the road."""
    spring, damper = characteristics.linear(2e4), characteristics.linear(100.0)
    rows = [tuple(float(i == k) - float(i == k - 1) for i in range(masses)) for k in range(masses)]
    return System(
        coordinates=tuple(f"mass_{k}" for k in range(masses)),
        mass=tuple(tuple(10.0 * (i == k) for i in range(masses)) for k in range(masses)),
        elements=tuple(
            Element(f"link_{k}", row, spring, damper, "" if k else "road")
            for k, row in enumerate(rows)
        ),
        signals={"road": roads.sine(0.01, 5.0, 10.0)},
        scales=(0.01,) * masses,
    )


def on_leaf_springs(friction: float) -> System:
    """Return a quarter car whose suspension sticks by so much friction, N; 0 for none."""
    return build("QuarterCar", {"friction": friction, "road.shape": "sine", "lift_off": False})


def lsoda_run(tolerance: float = 1e-4) -> Callable[[], object]:
    """Return a run of 2 s by scipy's LSODA with a compiled right-hand side."""
    return peers.scipy_method("LSODA", workbench("lift_off"), tolerance)


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
