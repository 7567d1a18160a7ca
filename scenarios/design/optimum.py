"""The best parameters: an objective and constraints over measures, and the trade-off of two measures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path

import numpy as np

from ..errors import InputError, NoResultError, blaming
from ..measures import has_sign
from ..progress import Progress, silent
from ..scene.expectations import Bounds, bounds_from, unknown_measure
from ..sweeps.plan import Plan, scene_of_file
from ..sweeps.running import run_chunk
from ..toml_files import dotted, read_content
from .files import OptimumFile, SearchOfOptimum, read_study
from .space import Points, Runs, Space, differences, journaled

_WORST = 1e30  # for a run that failed or lacks a measure
_CLOSE = 1e-6  # relative violation of a bound that counts as none
_STEPS, _USUAL_STEPS = 12, 4  # of a local search, at most and as a rule
_TOLERANCE = 1e-4  # relative to the objective


@dataclass(frozen=True)
class Problem:
    """An optimisation.

    Parameters
    ----------
    space : the parameters and their ranges
    objective : name of the measure
    sign : 1 to minimise it, -1 to maximise it
    against : name of a second measure to be traded off against it, or ""
    bounds : bounds on measures
    search : settings of the search
    """

    space: Space
    objective: str
    sign: float
    against: str
    bounds: Mapping[str, Bounds]
    search: SearchOfOptimum

    @property
    def measures(self) -> tuple[str, ...]:
        """The measures that every run needs."""
        return self.space.plan.measures

    def sizes(self, numbers: Points, measure: str) -> Points:
        """Return a measure of each run, of a peak its magnitude; NaN where the run lacks any measure."""
        column = numbers[:, self.measures.index(measure)]
        known = np.where(np.isfinite(numbers).all(axis=1), column, np.nan)
        return abs(known) if has_sign(measure) else known

    def cost(self, numbers: Points) -> Points:
        """Return the value to minimise, for each run; large where it failed or lacks a measure."""
        return np.nan_to_num(self.sign * self.sizes(numbers, self.objective), nan=_WORST)

    def other(self) -> Problem:
        """Return the problem whose objective is the smallest magnitude of the second measure."""
        return replace(self, objective=self.against, sign=1.0)

    def violations(self, numbers: Points) -> Points:
        """Return the relative violation of each bound, (runs, bounds); below 0 if it holds.

        It is large where a run failed or lacks a measure, even one without bounds.
        """
        rows = []
        for name, bound in self.bounds.items():
            column = self.sizes(numbers, name)
            for limit, side in ((bound.min, -1.0), (bound.max, 1.0)):
                if limit is not None:
                    broken = side * (column - limit) / (abs(limit) or 1.0)
                    rows.append(np.nan_to_num(broken, nan=_WORST))
        return np.array(rows).T.reshape(len(numbers), -1)


@dataclass(frozen=True)
class Optimum:
    """The result of an optimisation.

    Parameters
    ----------
    problem : the problem
    before, best : the scene's point and the best one, in shares of the ranges
    numbers_before, numbers : the measures of both
    feasible : whether the best point keeps all bounds
    without_effect : names of the parameters on which no measure depends
    front : points of the trade-off, and their measures, if there is one
    points, measured : all runs
    made : number of runs made now
    """

    problem: Problem
    before: Points
    best: Points
    numbers_before: Points
    numbers: Points
    feasible: bool
    without_effect: tuple[str, ...]
    front: tuple[Points, Points]
    points: Points
    measured: Points
    made: int

    @property
    def envelope(self) -> Points:
        """The measures of the runs within all bounds that no other one beats, along the trade-off."""
        if not len(self.front[1]):
            return self.front[1]
        problem = self.problem
        kept = (problem.violations(self.measured) <= _CLOSE).all(axis=1)
        table: Points = np.vstack([self.front[1], self.measured[kept]])
        return table[_front(problem, table)]


def read_problem(path: Path) -> Problem:
    """Read an optimisation.

    Raises
    ------
    InputError : if the file is not valid; one line with file, key, value and what is allowed.
    """
    content = read_content(path)
    said = read_study(OptimumFile, path, content)
    objective, against = said.minimise or said.maximise, said.against
    flat = dict(dotted(said.constrain or {}, ("min", "max")))
    scene = scene_of_file(path, said.scene)
    known = scene.fmu.measures()
    for name in flat:
        if name not in known:
            raise InputError(f"{path}: constrain: {unknown_measure(name, known)}")
    keys = {objective: "minimise" if said.minimise else "maximise"}
    keys |= {against: "against"} if against else {}
    constrained = {name: "constrain" for name in flat if name not in keys}
    space = Space.read(path, content, scene, keys | constrained)
    bounds = {}
    for name, raw in flat.items():
        with blaming(f"{path}: constrain.{name}"):
            bounds[name] = bounds_from(raw, known[name].unit_of_one)
        if has_sign(name) and min(bounds[name].min or 0.0, bounds[name].max or 0.0) < 0.0:
            raise InputError(
                f"{path}: constrain.{name}: the magnitude of a peak counts; give a bound that is not "
                "negative"
            )
    sign = 1.0 if said.minimise else -1.0
    search = said.search or SearchOfOptimum()
    return Problem(space, objective, sign, against, bounds, search)


def solve(problem: Problem, journal: Path, progress: Progress = silent) -> Optimum:
    """Find the best parameters: a differential evolution, then a sequential quadratic programme.

    Each generation, and the differences of each gradient, are one batch of runs.

    Parameters
    ----------
    journal : file of the runs so far, from which an interrupted search continues
    progress : called with the fraction done, 0 to 1

    Raises
    ------
    NoResultError : if no run has all measures, or no measure depends on any of the parameters.
    """
    search, space = problem.search, problem.space
    count = len(space.plan.keys)
    local = 2 + (max(search.trade_offs, 2) - 1 if problem.against else 0)
    stages = (
        search.population * count * (search.generations + 1),
        *[_USUAL_STEPS * (1 + 2 * count)] * local,
    )
    with journaled(space, _measures_of, journal, problem.measures, stages, progress) as runs:
        before = space.given()
        at_start = runs.at(before)
        without_effect = _without_effect(runs, before)
        if all(without_effect):
            raise NoResultError(
                f"{space.plan.file}: no measure depends on {' or '.join(space.plan.keys)}: all measures "
                "are the same at both ends and in the middle of each range"
            )
        evolved = _evolved(problem, runs)
        if any(without_effect):  # perhaps it has one elsewhere
            elsewhere = _without_effect(runs, evolved)
            without_effect = [a and b for a, b in zip(without_effect, elsewhere, strict=True)]
        for start in (evolved, *([before] if np.isfinite(at_start).all() else [])):
            _refine(problem, runs, start)
        best = _best(problem, runs)
        numbers = runs.at(best)
        if not np.isfinite(numbers).all():
            raise NoResultError(
                f"{space.plan.file}: every run fails or lacks one of {', '.join(problem.measures)}"
            )
        feasible = bool((problem.violations(numbers) <= _CLOSE).all())
        wanted = problem.against and feasible
        front = _trade_off(problem, runs, best) if wanted else (best[None][:0], numbers[:0])
        best = _best(problem, runs)  # its runs may include a better one
        numbers = runs.at(best)
        return Optimum(
            problem, before, best, at_start[0], numbers[0],
            feasible, tuple(compress(space.plan.keys, without_effect)), front, runs.points,
            runs.at(runs.points), runs.made,
        )  # fmt: skip


def _measures_of(plan: Plan) -> list[tuple[float | None, ...]]:
    through = "process" if plan.scene.fmu.path is None else "fmu"
    rows = run_chunk(plan, range(len(plan.points)), through)
    return [tuple(None if x is None else float(x) for x in row.values) for row in rows]


def _without_effect(runs: Runs, point: Points) -> list[bool]:
    """Return for each parameter whether the measures are equal along its range through a point."""
    found = []
    for k in range(len(point)):
        probes = np.tile(point, (3, 1))
        probes[:, k] = (0.0, 0.5, 1.0)
        numbers = runs.at(probes)
        found.append(bool((numbers == numbers[0]).all()))
    return found


def _evolved(problem: Problem, runs: Runs) -> Points:
    """Return the best point of a differential evolution."""
    from scipy.optimize import NonlinearConstraint, differential_evolution  # noqa: PLC0415

    count = len(problem.space.plan.keys)

    def broken(x: Points) -> Points:
        """Return the violations at one point, (bounds,), or at several, (bounds, points)."""
        found = problem.violations(runs.at(x.T))
        return found[0] if x.ndim == 1 else found.T

    constraints = (NonlinearConstraint(broken, -np.inf, 0.0),) if problem.bounds else ()
    found = differential_evolution(
        lambda x: problem.cost(runs.at(x.T)), [(0.0, 1.0)] * count, vectorized=True,
        updating="deferred", init="sobol", popsize=problem.search.population,
        maxiter=problem.search.generations, rng=problem.search.seed, polish=False,
        constraints=constraints, tol=1e-4,
    )  # fmt: skip
    runs.end_stage()
    return found.x


def _refine(problem: Problem, runs: Runs, start: Points) -> None:
    """Make runs to the optimum nearest to a point, by sequential quadratic programming."""
    from scipy.optimize import minimize  # noqa: PLC0415

    size = float(abs(problem.cost(runs.at(start))[0])) or 1.0

    def costs(points: Points) -> Points:
        return problem.cost(runs.at(points)) / size

    def margins(points: Points) -> Points:
        return -problem.violations(runs.at(points))

    constraint = {
        "type": "ineq",
        "fun": lambda x: margins(x)[0],
        "jac": lambda x: differences(margins, x),
    }
    minimize(
        lambda x: float(costs(x)[0]), start, jac=lambda x: differences(costs, x),
        bounds=[(0.0, 1.0)] * len(start), method="SLSQP",
        constraints=[constraint] if problem.bounds else [],
        options={"maxiter": _STEPS, "ftol": _TOLERANCE},
    )  # fmt: skip
    runs.end_stage()


def _best(problem: Problem, runs: Runs) -> Points:
    """Return the best of all runs, the first of equals: feasible first, then by cost."""
    points = runs.points
    numbers = runs.at(points)
    broken = np.maximum(problem.violations(numbers), 0.0)
    broken = np.where(broken <= _CLOSE, 0.0, broken).sum(axis=1)
    return points[np.lexsort((problem.cost(numbers), broken))[0]]


def _trade_off(problem: Problem, runs: Runs, best: Points) -> tuple[Points, Points]:
    """Return points of the front from the best one to the best by the second measure.

    Between the two ends the second measure is bounded, step by step, and the objective optimised.
    """
    against, other = problem.against, problem.other()
    _refine(other, runs, _best(other, runs))
    end = _best(other, runs)
    first, last = (float(other.cost(runs.at(x))[0]) for x in (best, end))
    along = [problem, other]
    for limit in np.linspace(first, last, max(problem.search.trade_offs, 2))[1:-1]:
        within = _within(problem.bounds.get(against, Bounds()), limit)
        limited = replace(problem, bounds={**problem.bounds, against: within})
        _refine(limited, runs, _best(limited, runs))
        along.append(limited)
    points = np.array([_best(one, runs) for one in along])
    numbers = runs.at(points)
    kept = _front(problem, numbers)
    return points[kept], numbers[kept]


def _front(problem: Problem, numbers: Points) -> Points:
    """Return the indices of the runs that no other one beats in both measures."""
    return undominated(np.column_stack([problem.cost(numbers), problem.other().cost(numbers)]))


def _within(bounds: Bounds, limit: float) -> Bounds:
    """Return the bounds on a measure whose size is limited, too."""
    return replace(bounds, max=limit if bounds.max is None else min(bounds.max, limit))


def undominated(costs: Points) -> Points:
    """Return the indices of the rows that no other row beats in both columns, by the first column.

    Parameters
    ----------
    costs : values to minimise, (points, 2)
    """
    order = np.lexsort((costs[:, 1], costs[:, 0]))
    least = np.minimum.accumulate(costs[order, 1])
    better = np.concatenate([[True], costs[order, 1][1:] < least[:-1]])
    return order[better]
