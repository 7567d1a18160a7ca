"""Many runs of one model with other parameters each, over all cores.

The integrator gives Python's lock back while it steps, so plain threads run side by side. A run that
cannot be made is a record with its reason; the others go on.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, isfinite
from operator import itemgetter
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from .engine import FAILURES, Integrator
from .many import PartingError, many, table
from .models import build, build_checked
from .series import Series, at_the_end, over_time
from .session import start_state
from .systems import System
from .variable import Variable
from .variables import ParameterError, Value, checked_parameters, refuse_unknown, variables

_CHUNK = 1024  # runs that a thread takes at a time
_MOST_NUMBERS = 4_000_000  # in one table of systems


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one run.

    Parameters
    ----------
    columns : values over the instants by the name of the output, (instants,); up to where the run came
    failure : why it ended before the last instant, or empty
    at_end : values at the last instant by the name of the output; none if the run ended before
    switches : instants at which an element changed its branch, s, ascending, if corners are wanted
    joints : instants at which the course of a road or load may have a corner, likewise
    """

    columns: Mapping[str, npt.NDArray[np.float64]]
    failure: str = ""
    at_end: Mapping[str, float] = field(default_factory=dict)
    switches: Sequence[float] = ()
    joints: Sequence[float] = ()

    @property
    def ok(self) -> bool:
        """Whether the whole run could be made."""
        return not self.failure


_NOTHING = Outcome({})


def run_many(
    model: str,
    parameter_sets: Sequence[Mapping[str, object]],
    times: Sequence[float],
    outputs: Sequence[str],
    workers: int | None = None,
    *,
    at_end: Sequence[str] = (),
    corners: bool = False,
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Run a model once for each set of parameters.

    Roads are internal: there are no inputs. The energy ledger is not kept.

    Parameters
    ----------
    model : key of `variables.MODELS`
    parameter_sets : parameters that are not at their defaults, for each run
    times : s, ascending; the first is the start
    outputs : motions, deflections, forces, contact and the road over time: see `outputs_over_time`
    workers : threads; None for one on each core
    at_end : outputs at the last instant, of those that add up: see `outputs_at_end`
    corners : whether the instants are wanted at which outputs may jump or have a corner
    progress : called with the part done, 0 to 1

    Returns
    -------
    An outcome for each set, in their order.

    Raises
    ------
    ParameterError : unknown model or output, or instants that do not ascend. Parameters that are wrong
        are the failure of their own run.

    Examples
    --------
    >>> from phaseplane.suspension.batch import run_many
    >>> cars = [{"damper.rebound_rate": rate} for rate in (500.0, 1000.0, -1.0)]
    >>> soft, hard, wrong = run_many("QuarterCar", cars, [0.0, 0.1, 0.2], ["body_displacement"])
    >>> len(soft.columns["body_displacement"])
    3
    >>> wrong.failure
    'damper.rebound_rate = -1: must be at least 0 in N.s/m'
    """
    instants = array("d", times)
    if not instants or not all(map(isfinite, instants)):
        raise ParameterError("times must be at least one finite instant")
    if any(b < a for a, b in pairwise(instants)):
        raise ParameterError("times must ascend")
    for names, known in ((outputs, outputs_over_time), (at_end, outputs_at_end)):
        refuse_unknown(names, known(model), f"a batch of {model} has no output")
    task = _Task(model, instants, tuple(outputs), tuple(at_end), corners)
    workers = workers or os.cpu_count() or 1
    size = min(_CHUNK, ceil(len(parameter_sets) / (2 * workers)) or 1)
    chunks = [parameter_sets[k : k + size] for k in range(0, len(parameter_sets), size)]
    found: list[Outcome] = []
    benches = [_Bench(task) for _ in range(workers)]  # those that no thread works at

    def run_chunk(sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        bench = benches.pop()
        try:
            return bench.run(sets)
        finally:
            benches.append(bench)

    with ThreadPoolExecutor(workers) as pool:
        for part in pool.map(run_chunk, chunks):
            found += part
            if progress is not None:
                progress(len(found) / len(parameter_sets))
    return found


def outputs_over_time(model: str) -> list[str]:
    """Outputs that a batch gives at every instant.

    Raises
    ------
    ParameterError : unknown model.
    """
    return over_time(_as_it_comes(model))


def outputs_at_end(model: str) -> list[str]:
    """Outputs that a batch gives at the last instant.

    Raises
    ------
    ParameterError : unknown model.
    """
    return at_the_end(_as_it_comes(model))


def _as_it_comes(model: str) -> System:
    variables(model)  # refuses a model that is not known
    return build(model, checked_parameters(model, {}))


@dataclass(frozen=True, slots=True)
class _Task:
    """What all runs have in common."""

    model: str
    times: array[float]
    outputs: tuple[str, ...]
    at_end: tuple[str, ...]
    corners: bool


class _Bench:
    """Where runs are made, as many as can be from systems made for all of them at once."""

    def __init__(self, task: _Task) -> None:
        self._task = task
        self._solver: tuple[Value, ...] = ()
        self._integrator: Any = None
        self._series: Any = None

    def run(self, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        """Make a run for each set; what its parameters do not allow is its failure."""
        found = [_NOTHING] * len(sets)
        for runs in _with_equal_texts(self._task.model, sets):
            self._run_together(sets, runs, found)
        return found

    def _run_together(
        self, sets: Sequence[Mapping[str, object]], runs: Sequence[int], found: list[Outcome]
    ) -> None:
        """Runs as one where that can be, else in parts, at last each by itself."""
        parts: Iterable[Sequence[int]]
        try:
            self._enter([sets[run] for run in runs])
        except PartingError as parting:
            which = dict(zip(runs, parting.which.tolist(), strict=True))
            parts = [[run for run in runs if which[run] is side] for side in (True, False)]
        except (ValueError, TypeError, ArithmeticError) as error:
            if len(runs) == 1:
                if not isinstance(error, ValueError):
                    raise
                found[runs[0]] = Outcome({}, str(error))
                return
            parts = [[run] for run in runs]
        else:
            for run, outcome in zip(runs, self._outcomes(len(runs)), strict=True):
                found[run] = outcome
            return
        for part in parts:
            self._run_together(sets, part, found)

    def _enter(self, sets: Sequence[Mapping[str, object]]) -> None:
        """Make systems for all sets at once, and get ready for their runs.

        Raises
        ------
        PartingError : systems that differ in more than their numbers.
        ValueError : a system that the method cannot take.
        """
        model = self._task.model
        with np.errstate(all="raise", under="ignore"):
            parameters = _together(model, sets)
            system = build_checked(model, parameters)
            rest = (0.0,) * len(system.mass)
            state = start_state(system, parameters, self._task.times[0]) or (rest, rest)
            if self._solver == _solver(parameters) and self._integrator.fits(system):
                self._series.enter(system)
            else:
                self._have_integrator(system, parameters, sets[0])
            numbers = self._integrator.row(system, *state)
        if len(numbers) * len(sets) > _MOST_NUMBERS and len(sets) > 1:
            raise PartingError(np.arange(len(sets)) < len(sets) // 2)
        self._series.take(table(numbers, len(sets)))

    def _have_integrator(
        self, system: System, parameters: Mapping[str, Value], example: Mapping[str, object]
    ) -> None:
        """An integrator that systems like the example fit, and what makes columns of its runs."""
        task = self._task
        self._solver = ()
        method, step, tolerance, theta, beyond = solver = _solver(parameters)
        self._integrator = Integrator(
            build(task.model, checked_parameters(task.model, example)),
            method, step, tolerance, task.times[0],
            energy=False, theta=theta, beyond_stable=beyond,
        )  # fmt: skip
        self._series = Series(
            self._integrator, system, task.times, task.outputs, task.at_end, task.corners
        )
        self._solver = solver

    def _outcomes(self, runs: int) -> Iterator[Outcome]:
        """Make all runs, and say what became of them."""
        names, times = self._task.outputs, self._task.times
        columns = np.empty((len(names), runs, len(times)))
        of_runs = list(zip(*columns, strict=True)) or [()] * runs
        joints = self._series.joints(runs) if self._task.corners else [()] * runs
        first = 0
        while first < runs:
            ended = self._series.go(first, columns)
            for k, one in enumerate(ended):
                values = of_runs[first + k]
                switches = self._series.switches(k) if self._task.corners else ()
                corners = (switches, joints[first + k])
                if one.status == 0:
                    found = dict(zip(names, values, strict=True))
                    yield Outcome(found, "", self._series.ends(k, one), *corners)
                    continue
                found = {name: x[: one.filled] for name, x in zip(names, values, strict=True)}
                why = f"{FAILURES[one.status]} at {one.time:.6g} s, in step {one.steps}"
                yield Outcome(found, why, {}, *corners)
            first += len(ended)


_solver = itemgetter(
    "solver.method", "solver.step", "solver.tolerance", "solver.theta", "solver.beyond_stable"
)


def _with_equal_texts(model: str, sets: Sequence[Mapping[str, object]]) -> Iterable[list[int]]:
    """The runs that give the same parameters, and the same for all that are no numbers of the system."""
    declared = _declared(model)
    texts: dict[tuple[str, ...], list[str]] = {}
    together: dict[object, list[int]] = {}
    for run, given in enumerate(sets):
        names = tuple(given)
        if names not in texts:
            texts[names] = [name for name in names if not _is_number(declared.get(name))]
        values = [given[name] for name in texts[names]]
        # what is equal need not be the same: True, 1 and 1.0
        key = (names, *values, *map(type, values))
        try:
            together.setdefault(key, []).append(run)
        except TypeError:  # no value that any parameter could have
            together[run] = [run]
    return together.values()


def _declared(model: str) -> dict[str, Variable]:
    return {v.name: v for v in variables(model) if v.causality == "parameter"}


def _is_number(declared: Variable | None) -> bool:
    """Whether a parameter may differ among runs that are made together."""
    return (
        declared is not None
        and isinstance(declared.start, float)
        and not declared.name.startswith("solver.")
    )


def _together(model: str, sets: Sequence[Mapping[str, object]]) -> dict[str, Value]:
    """All parameters of sets that give the same ones, with many numbers in place of one.

    Raises
    ------
    ParameterError : a value that one of them does not allow.
    """
    declared = _declared(model)
    parameters = checked_parameters(model, sets[0])
    for name in sets[0]:
        if _is_number(declared[name]):
            check = declared[name].checked
            given = [one[name] for one in sets]
            if not {*map(type, given)} <= {float, int}:
                given = [check(value) for value in given]
            values = np.array(given, dtype=float) + 0.0  # never -0.0
            for extreme in (values.min(), values.max()):
                check(float(extreme))
            parameters[name] = cast("float", many(values))
    return parameters
