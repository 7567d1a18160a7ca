"""Parameters fitted to measured signals by least squares, with their confidence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
from phaseplane.suspension.batch import Outcome, outputs_over_time, run_many
from phaseplane.suspension.units import counted
from phaseplane.suspension.variables import MODELS, Value

from ..errors import InputError, NoResultError
from ..measures.solution import Solution, in_steps, stepped
from ..progress import Progress, silent
from ..results.signals import signals_in
from ..scene.fmus import lacks_ledger
from ..scene.schema import Scene
from ..simulate.controlling import driven
from ..sweeps.plan import Plan, scene_of_file
from ..toml_files import read_content
from .files import FitFile, SearchOfFit, read_study
from .space import Points, Runs, Space, differences, journaled

LEVEL = 0.95  # of confidence
_STEPS, _USUAL_STEPS = 60, 10  # of the least squares, at most and as a rule
_ALIKE = 0.95  # correlation above which two parameters are hardly distinguished
_LOST = 1e-3  # of the largest change of the signals: less is within the error of its differences
_INVOLVED = 1e-6  # of the square of a direction: its part along a parameter that is involved in it


@dataclass(frozen=True)
class Task:
    """Parameters to be fitted.

    Parameters
    ----------
    space : the parameters and their ranges
    time : times of the samples, s
    signals : measured columns by the name of the output, SI
    search : settings of the search
    """

    space: Space
    time: Points
    signals: Mapping[str, Points]
    search: SearchOfFit


@dataclass(frozen=True)
class Fit:
    """Fitted parameters.

    Parameters
    ----------
    task : what was fitted
    values : the parameters, SI
    errors : half widths of their intervals of 95 % confidence, SI; infinite if the signals do not
        depend on the parameter, or determine only a combination of it with others
    correlation : of the parameters with each other
    columns : the outputs with the fitted parameters
    residual : root mean square of the difference over that of the signal, by output
    at_bound : names of the parameters that end at a bound
    made : number of runs made now
    """

    task: Task
    values: Points
    errors: Points
    correlation: Points
    columns: Mapping[str, Points]
    residual: Mapping[str, float]
    at_bound: tuple[str, ...]
    made: int

    def unknown(self) -> dict[str, list[str]]:
        """Return the parameters without an interval, each with those in combination with it, if any."""
        keys = [
            (k, key) for k, key in enumerate(self.task.space.plan.keys) if np.isinf(self.errors[k])
        ]
        return {
            a: [b for j, b in keys if j != i and self.correlation[i, j] != 0.0] for i, a in keys
        }

    def alike(self) -> list[tuple[str, str, float]]:
        """Return the pairs of parameters that the signals hardly distinguish, with their correlation."""
        return [
            (a, b, float(self.correlation[i, j]))
            for (i, a), (j, b) in combinations(enumerate(self.task.space.plan.keys), 2)
            if abs(self.correlation[i, j]) > _ALIKE
        ]


def read_task(path: Path) -> Task:
    """Read a fit.

    Raises
    ------
    InputError : if the file or its signals are not valid; one line that says what is allowed.
    """
    content = read_content(path)
    said = read_study(FitFile, path, content)
    scene = scene_of_file(path, said.scene)
    if not scene.fmu.in_package:
        raise InputError(f"{path}: scene: only models of this package can be fitted")
    space = Space.read(path, content, scene, {"step_count": "measured"})
    whole = replace(scene.fmu, variables=MODELS[scene.fmu.model])  # also without its energy ledger
    units = {name: variable.unit or "1" for name, variable in whole.outputs().items()}
    columns = signals_in(path, content, units)
    lacking = [name for name in columns if name not in {"time", *scene.fmu.outputs()}]
    if lacking:
        raise InputError(f"{path}: measured: {lacks_ledger(lacking[0])}")
    during = (columns["time"] >= 0.0) & (columns["time"] <= scene.duration)
    time = columns.pop("time")[during]
    if len(time) <= len(space.plan.keys):
        raise InputError(
            f"{path}: measured: {counted(len(time), 'sample')} within 0 and {scene.duration:g} s of the "
            "scene; a fit needs more samples than parameters; see time_shift"
        )
    signals = {name: column[during] for name, column in columns.items()}
    for name, x in signals.items():
        with np.errstate(over="ignore"):
            if not 0.0 < np.mean(np.square(x)) < np.inf:
                raise InputError(
                    f"{path}: measured: {name}: its samples are all 0, or too large to be squared; a fit "
                    "takes differences over their root mean square; name the signals to be fitted, "
                    "without this one, in measured.columns"
                )
    return Task(space, time, signals, said.search or SearchOfFit())


def fit(task: Task, journal: Path, progress: Progress = silent) -> Fit:
    """Fit the parameters: least squares over all signals, each over its root mean square.

    The best of several starts is followed to its minimum by a trust-region method within the bounds. The
    confidence is that of linear regression there, from the residuals of each signal, widened if they are
    correlated in time.

    Raises
    ------
    NoResultError : if no run succeeds.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415
    from scipy.stats import qmc, t  # noqa: PLC0415

    space, count = task.space, len(task.space.plan.keys)
    target = np.concatenate([np.asarray(task.signals[name]) for name in task.signals])
    weight = np.concatenate([
        np.full(len(x), 1.0 / np.sqrt(np.mean(np.square(x)))) for x in task.signals.values()
    ])  # fmt: skip
    stages = (1 + task.search.starts, _USUAL_STEPS * (1 + 2 * count))

    def make(plan: Plan) -> Iterator[Sequence[float | None]]:
        return _signals_of(plan, task)

    said = (tuple(task.signals), task.time.tobytes(), target.tobytes())
    with journaled(space, make, journal, said, stages, progress) as runs:
        before = space.given()
        sampler = qmc.Sobol(count, rng=task.search.seed)
        power = int(np.ceil(np.log2(task.search.starts)))
        starts = np.concatenate([before[None], sampler.random_base2(power)[: task.search.starts]])
        apart = np.sum(np.square(weight * (runs.at(starts) - target)), axis=1)
        if not np.isfinite(apart).any():
            raise NoResultError(f"{space.plan.file}: no run succeeds")
        runs.end_stage()
        start = np.clip(starts[int(np.nanargmin(apart))], 1e-6, 1.0 - 1e-6)
        found = least_squares(
            lambda x: _residuals(runs, x, target, weight), start,
            jac=lambda x: weight[:, None] * differences(runs.at, x),
            bounds=(0.0, 1.0), max_nfev=_STEPS, xtol=1e-10, ftol=1e-12,
        )  # fmt: skip
        left = _residuals(runs, found.x, target, weight)
        runs.end_stage()
        freedom = max(len(left) - count, 1)
        deviations, correlation = _spread(found.jac, left, len(task.signals))
        fitted = _apart(runs.at(found.x)[0], task)
        return Fit(
            task, space.values(found.x),
            float(t.ppf(0.5 + 0.5 * LEVEL, freedom)) * deviations * space.widths,
            correlation, fitted,
            {
                name: float(np.sqrt(np.mean(np.square(fitted[name] - x)) / np.mean(np.square(x))))
                for name, x in task.signals.items()
            },
            space.at_bound(found.x), runs.made,
        )  # fmt: skip


def _residuals(runs: Runs, x: Points, target: Points, weight: Points) -> Points:
    found: Points = weight * (runs.at(x)[0] - target)
    if not np.isfinite(found).all():
        raise NoResultError(
            f"{runs.space.plan.file}: a run fails near the minimum; narrow the ranges of [vary]"
        )
    return found


def _spread(jacobian: Points, left: Points, signals: int) -> tuple[Points, Points]:
    """Return the standard deviations of the parameters, and their correlation.

    A direction in which the signals do not change has any length: the parameters that are involved in it
    are not known, and among themselves correlated as along it.
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    sizes[sizes == 0.0] = 1.0
    _, changes, directions = np.linalg.svd(jacobian / sizes, full_matrices=False)
    lost = directions[changes <= _LOST * changes[0]]
    along = lost.T @ lost
    unknown = np.diag(along) > _INVOLVED
    covariance = _covariance(jacobian / sizes, left, signals)
    scatter = np.where(unknown[:, None] & unknown, along, covariance)
    scatter[unknown[:, None] != unknown] = 0.0
    scatter[abs(scatter) <= _INVOLVED * unknown] = 0.0
    deviations = np.sqrt(np.diag(scatter))
    scale = np.where(deviations > 0.0, deviations, 1.0)
    return np.where(unknown, np.inf, deviations / sizes), scatter / np.outer(scale, scale)


def _covariance(jacobian: Points, left: Points, signals: int) -> Points:
    """Return the covariance of the parameters, (J'J)^-1 J'SJ (J'J)^-1, in directions that are not lost.

    S has for each signal the variance of its own residuals, as signals may differ in noise. With a
    correlation r from sample to sample, n samples are worth n (1 - r) / (1 + r) independent ones.
    """
    rows, count = jacobian.shape
    inverse = np.linalg.pinv(jacobian.T @ jacobian, rcond=_LOST**2, hermitian=True)
    scatter = np.zeros((count, count))
    for slopes, x in zip(np.split(jacobian, signals), np.split(left, signals), strict=True):
        power = float(x @ x)
        r = min(max(0.0, float(x[1:] @ x[:-1]) / (power or 1.0)), 0.999)
        variance = power / len(x) * rows / max(rows - count, 1)
        scatter += slopes.T @ slopes * variance * (1.0 + r) / (1.0 - r)
    return inverse @ scatter @ inverse


def _signals_of(plan: Plan, task: Task) -> Iterator[Sequence[float | None]]:
    """Yield the outputs of each run at the times of the samples, one after the other."""
    names, scene = list(task.signals), plan.scene
    early = task.time[0] > 0.0
    times = np.insert(task.time, 0, 0.0) if early else task.time
    sets = [{**scene.start_values, **plan.varied(point)} for point in plan.points]
    for run in _runs(scene, sets, times, names):
        if run.failure:
            yield [None] * (len(task.time) * len(names))
        else:
            yield np.concatenate([run.columns[n][int(early) :] for n in names]).tolist()


def _runs(
    scene: Scene, sets: Sequence[Mapping[str, Value]], times: Points, names: Sequence[str]
) -> Iterable[Outcome | Solution]:
    """Return a run for each set of parameters, under the controller of the scene if it has one."""
    model = scene.fmu.model
    if scene.controller is None and {*names} <= {*outputs_over_time(model)}:
        return run_many(model, sets, times.tolist(), names)
    drive = in_steps if scene.controller is None else partial(driven, controller=scene.controller)
    return (stepped(model, one, times, names, drive=drive) for one in sets)


def _apart(numbers: Points, task: Task) -> dict[str, Points]:
    return dict(zip(task.signals, np.split(numbers, len(task.signals)), strict=True))
