"""The step rules of the constructions compared with the exact motion: errors, orders, times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from itertools import pairwise
from math import log2, nan
from operator import attrgetter
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.session import SimulationError, simulate

from phaseplane import constructions

from .. import simulate as simulating
from ..draw.constructions import draw_construction
from ..draw.planes import planes_of
from ..errors import InputError, one_line
from ..results.quantities import span
from ..scene.equation import EQUATION

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ..columns import Column, Columns
    from ..scene.schema import Scene


_TOLERANCE = 1e-12  # of the integrator for the exact motion
_HALVINGS = 2
_REPEATS = 15  # runs of a rule at most
_LONG_ENOUGH = 1.0  # s of them, after which there are no more
_INTEGRATOR = {"tangent": 2, "mean": 2, "equilibrium": 2}  # order of each method with fixed steps


@dataclass(frozen=True, slots=True)
class RuleResult:
    """The result of a step rule on a scene.

    Parameters
    ----------
    rule : its name; `integrator: ...` for a method of the integrator
    stated_order : its stated order of convergence
    errors : largest error of each displacement over the steps, m
    orders : orders of the largest error, measured by halving the step twice; nan if the error is zero
    steps : number of steps
    seconds : processor time of all steps, the shortest of at most fifteen runs
    failure : why it failed, or empty
    """

    rule: str
    stated_order: int
    errors: dict[str, float]
    orders: tuple[float, ...]
    steps: int
    seconds: float
    failure: str = ""


@dataclass(frozen=True, slots=True)
class _Motion:
    """Displacements by name at the ends of steps, with the number of steps and the time."""

    times: Column
    columns: Columns
    steps: int
    seconds: float


def measure_rules(scene: Scene) -> list[RuleResult]:
    """Return the results of all rules, and of the integrator, with the step of the scene's construction.

    Raises
    ------
    InputError : if the scene's model has no construction, or it has a controller.
    """
    names = _displacements(scene)
    scene.refuse_controller("the rules are measured on")
    results = [
        _measured(name, rule.order, scene, partial(_drawn, scene, name, names))
        for name, rule in constructions.RULES.items()
    ]
    if scene.fmu.model != EQUATION:
        results += [
            _measured(f"integrator: {name}", order, scene, partial(_stepped, scene, name, names))
            for name, order in _INTEGRATOR.items()
        ]
    return results


def _displacements(scene: Scene) -> list[str]:
    """Return the displacements of the planes and of the bodies."""
    planes = planes_of(scene.fmu.model, scene.all_parameters, asdict(scene.construction))
    shown = [plane.name for plane in planes.planes]
    bodies = [name for name in scene.fmu.outputs() if name.endswith("body_displacement")]
    axles = any(name.startswith("front_") for name in bodies)
    return shown + [name for name in bodies if not axles or not name.startswith("body")]


def _measured(name: str, order: int, scene: Scene, run: Callable[[float], _Motion]) -> RuleResult:
    step = scene.construction.step
    try:
        motion, spent = run(step), 0.0
        for _ in range(1, _REPEATS):
            spent += motion.seconds
            if spent > _LONG_ENOUGH:
                break
            motion = min(motion, run(step), key=attrgetter("seconds"))
        errors = _errors(scene, motion)
        worst = [max(errors.values())]
        for halving in range(1, _HALVINGS + 1):
            worst.append(max(_errors(scene, run(step / 2**halving)).values()))
    except (ArithmeticError, SimulationError) as error:
        return RuleResult(name, order, {}, (), 0, nan, one_line(error))
    orders = (log2(f / g) if g > 0.0 else nan for f, g in pairwise(worst))
    return RuleResult(name, order, errors, tuple(orders), motion.steps, motion.seconds)


def _drawn(scene: Scene, rule: str, names: Sequence[str], step: float) -> _Motion:
    settings = {**asdict(scene.construction), "rule": rule, "step": step, "shortcut": False}
    started = process_time()
    drawing = draw_construction(
        scene.fmu.model, scene.all_parameters, settings, scene.construction_time
    )
    seconds = process_time() - started
    columns = {name: np.array([f.readings[name] for f in drawing.frames]) for name in names}
    times = np.array([frame.time for frame in drawing.frames])
    return _Motion(times, columns, len(times), seconds)


def _stepped(scene: Scene, method: str, names: Sequence[str], step: float) -> _Motion:
    steps = round(scene.construction_time / step)
    times = np.linspace(0.0, steps * step, steps + 1)
    started = process_time()
    columns = _simulated(scene, times, names, method, step)
    return _Motion(times, columns, steps, process_time() - started)


def _errors(scene: Scene, motion: _Motion) -> dict[str, float]:
    """Return the largest error of each displacement, m."""
    names = list(motion.columns)
    exact = (
        simulating.solving.solve(scene.all_parameters, motion.times)[0]
        if scene.fmu.model == EQUATION
        else _simulated(scene, motion.times, names)
    )
    return {name: float(np.max(np.abs(motion.columns[name] - exact[name]))) for name in names}


def _simulated(
    scene: Scene,
    times: Column,
    names: Sequence[str],
    method: str = "extrapolated",
    step: float = 0.0,
) -> Columns:
    solver = {"solver.method": method, "solver.step": step, "solver.tolerance": _TOLERANCE}
    parameters = {**scene.all_parameters, **solver}
    columns = simulate(scene.fmu.model, parameters, times.tolist(), names)
    return {name: np.asarray(columns[name]) for name in names}


def rules_table(scene: Scene, results: Sequence[RuleResult]) -> str:
    """Return the results as text."""
    return "\n".join(_lines(scene, results))


def _lines(scene: Scene, results: Sequence[RuleResult]) -> Iterator[str]:
    names = next((list(r.errors) for r in results if r.errors), [])
    if not names:
        raise InputError(f"no rule can be drawn: {results[0].failure}")
    factor, unit = (1.0, "") if scene.fmu.model == EQUATION else (1e3, " in mm")
    heads = [f"{name.replace('_', ' '):>9}" for name in names]
    yield (
        f"largest error{unit} with steps of {span(scene.construction.step)} over "
        f"{scene.construction_time:g} s, and the order measured by halving them twice"
    )
    yield ""
    yield f"{'rule':<24}{'  '.join(heads)}  order  measured    steps  seconds  steps/s"
    for r in results:
        if r.failure:
            yield f"{r.rule:<24}{r.failure}"
            continue
        errors = "  ".join(
            f"{factor * r.errors[name]:>{len(head)}.4g}"
            for name, head in zip(names, heads, strict=True)
        )
        orders = ", ".join(f"{order:.2f}" for order in r.orders)
        yield (
            f"{r.rule:<24}{errors}  {r.stated_order:>5}  {orders:<10}  {r.steps:>5}  "
            f"{r.seconds:>7.4f}  {r.steps / r.seconds:>7.0f}"
        )


def as_data(scene: Scene, results: Sequence[RuleResult]) -> dict[str, Any]:
    """Return the results as plain data."""
    return {
        "scene": scene.name,
        "step": scene.construction.step,
        "duration": scene.construction_time,
        "rules": [asdict(result) for result in results],
    }
