"""This package's solvers: in-process, through the FMU, and by graphical construction."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from phaseplane.suspension.engine import Filling
from phaseplane.suspension.models import FILES
from phaseplane.suspension.reasons import why_stopped
from phaseplane.suspension.variables import MODELS, checked_parameters

from ..draw.constructions import draw_construction
from ..draw.planes import planes_of
from ..errors import InputError, one_line
from ..simulate.fmu_cache import cached_fmu
from .equations import Vector
from .workbench import Prepared, Run, UnableError, Workbench

_SAME = 1e-6  # of an interval: a drawn point this close to an output time counts as there


def in_process(bench: Workbench, **options: Any) -> Prepared:
    """Return a run that is one call of the integrator, set up beforehand; without ledger by default."""
    problem = bench.problem
    try:
        integrator = problem.integrator(**{"energy": False, **options})
    except ValueError as error:
        raise UnableError(str(error)) from None
    start, times = integrator.snapshot(), problem.times

    def go() -> Vector:
        out = np.empty((len(problem.system.mass), len(times)))
        status = Filling(integrator, times, out.reshape(-1)).fill()
        if status:
            where = f"at {integrator.time:.6g} s"
            fixed = bool(options.get("step"))
            raise ArithmeticError(
                why_stopped(status, where, integrator, problem.system, fixed=fixed)
            )
        return out.T

    return Prepared(lambda: integrator.restore(start), go)


@cache
def _unpacked(model: str, file: Path | None) -> Path:
    """Return the folder of the unpacked FMU of a file, or else of a model."""
    spare = Path(tempfile.mkdtemp(prefix="phaseplane-"))
    atexit.register(shutil.rmtree, spare, ignore_errors=True)
    if file is None:
        return cached_fmu(model, spare)[0]
    with ZipFile(file) as archive:
        archive.extractall(spare)
    return spare


def through_fmu(bench: Workbench, tolerance: float) -> Run:
    """Return a run of `fmpy.simulate_fmu` at the output interval, with an instance that is reset."""
    from fmpy import read_model_description, simulate_fmu  # noqa: PLC0415  (heavy)
    from fmpy.simulation import instantiate_fmu  # noqa: PLC0415  (heavy)

    from ..simulate.driver import Log, refuse_other_platforms  # noqa: PLC0415  (needs FMPy)

    problem = bench.problem
    if problem.model not in FILES:
        raise UnableError("FMUs are measured only for models of the package and .fmu files")
    folder = str(_unpacked(problem.model, problem.file))
    description = read_model_description(folder, validate=False)
    refuse_other_platforms(Path(folder), description)
    log = Log()
    instance = instantiate_fmu(folder, description, "CoSimulation", logger=log.taker(description))
    names = [f"{name}_displacement".removeprefix("_") for name in problem.system.coordinates]
    settings = {**problem.parameters, "solver.tolerance": tolerance}

    def run() -> Vector:
        instance.reset()
        try:
            table = simulate_fmu(
                folder,
                validate=False,
                start_time=0.0,
                stop_time=problem.duration,
                output_interval=problem.duration / problem.intervals,
                start_values=settings,
                output=names,
                model_description=description,
                fmu_instance=instance,
                terminate=False,
            )
        except Exception as error:
            raise RuntimeError(log.complaint() or one_line(error)) from error
        return np.column_stack([table[name] for name in names])

    return run


def drawn(rule: str, bench: Workbench, step: float) -> Run:
    """Return a run of the graphical construction with equal steps (AP57 section 4)."""
    problem = bench.problem
    if problem.model not in MODELS:
        raise UnableError("there is no construction of this system")
    parameters = checked_parameters(problem.model, problem.parameters)
    settings = {"rule": rule, "step": step}
    try:
        planes_of(problem.model, parameters, settings)
    except InputError as error:
        raise UnableError(one_line(error).removeprefix("construction: ")) from None
    names = [f"{name}_displacement".removeprefix("_") for name in problem.system.coordinates]
    interval = problem.duration / problem.intervals

    def run() -> Vector:
        drawing = draw_construction(problem.model, parameters, settings, problem.duration + step)
        rows = np.full((len(problem.times), len(names)), np.nan)
        for frame in drawing:
            k = round(frame.time / interval)
            if abs(frame.time - k * interval) < _SAME * interval and k < len(rows):
                rows[k] = [frame.readings[name] for name in names]
        if np.isnan(rows).any():
            raise ArithmeticError("the construction has no point at some output times")
        return rows

    return run
