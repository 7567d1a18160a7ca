"""Many runs of one model with different parameters, on all cores.

The integrator releases the global interpreter lock while it steps, so threads run in parallel. A run
that fails is recorded with its reason; the others continue.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, isfinite
from operator import itemgetter
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from .engine import Integrator, why_stopped
from .many import PartingError, many, table
from .models import build, build_checked
from .series import Series, at_the_end, over_time
from .session import start_state
from .systems import System
from .variable import Variable
from .variables import ParameterError, Value, checked_parameters, refuse_unknown, variables

_CHUNK = 1024  # runs per task of a thread
_MOST_NUMBERS = 4_000_000  # in one table of systems


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of one run.

    Parameters
    ----------
    columns : values over time by the name of the output, (times,); shorter if the run failed
    failure : why it ended before the last time, or empty
    at_end : values at the last time by the name of the output; empty if the run failed
    switches : times at which an element changed its branch, s, ascending, if corners are requested
    joints : times at which the course of a road or load may have a corner, likewise
    """

    columns: Mapping[str, npt.NDArray[np.float64]]
    failure: str = ""
    at_end: Mapping[str, float] = field(default_factory=dict)
    switches: Sequence[float] = ()
    joints: Sequence[float] = ()

    @property
    def ok(self) -> bool:
        """Whether the run reached the last time."""
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

    Roads are internal: there are no inputs. Energies are not computed.

    Parameters
    ----------
    model : key of `variables.MODELS`
    parameter_sets : parameters that are not at their defaults, for each run
    times : s, ascending; the first is the start
    outputs : motions, deflections, forces, contact and the road over time; see `outputs_over_time`
    workers : number of threads; None for one per core
    at_end : counts and sums at the last time; see `outputs_at_end`
    corners : whether to return the times at which outputs may jump or have a corner
    progress : called with the fraction done, 0 to 1

    Returns
    -------
    An outcome for each set, in the same order.

    Raises
    ------
    ParameterError : unknown model or output, or times that do not ascend. Bad parameters are a failure
        of their run only.

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
        raise ParameterError("times must be finite, and at least one must be given")
    if any(b < a for a, b in pairwise(instants)):
        raise ParameterError("times must ascend")
    for names, known in ((outputs, outputs_over_time), (at_end, outputs_at_end)):
        refuse_unknown(names, known(model), f"a batch of {model} has no output")
    task = _Task(model, instants, tuple(outputs), tuple(at_end), corners)
    workers = workers or os.cpu_count() or 1
    size = min(_CHUNK, ceil(len(parameter_sets) / (2 * workers)) or 1)
    chunks = [parameter_sets[k : k + size] for k in range(0, len(parameter_sets), size)]
    found: list[Outcome] = []
    benches = [_Bench(task) for _ in range(workers)]  # those not in use by a thread

    def run_chunk(sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        bench = benches.pop()
        try:
            return bench.run(sets)
        finally:
            benches.append(bench)

    with ExitStack() as stack:
        each: Callable[..., Iterator[list[Outcome]]] = map
        if len(chunks) > 1:
            from concurrent.futures import ThreadPoolExecutor  # noqa: PLC0415  (a run needs none)

            each = stack.enter_context(ThreadPoolExecutor(workers)).map
        for part in each(run_chunk, chunks):
            found += part
            if progress is not None:
                progress(len(found) / len(parameter_sets))
    return found


def outputs_over_time(model: str) -> list[str]:
    """Return the outputs that a batch can record over time.

    Raises
    ------
    ParameterError : unknown model.
    """
    return over_time(_as_it_comes(model))


def outputs_at_end(model: str) -> list[str]:
    """Return the outputs that a batch can record at the last time.

    Raises
    ------
    ParameterError : unknown model.
    """
    return at_the_end(_as_it_comes(model))


def _as_it_comes(model: str) -> System:
    variables(model)  # refuses an unknown model
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
    """One thread's integrator and series, which make runs from systems built for many runs at once."""

    def __init__(self, task: _Task) -> None:
        self._task = task
        self._solver: tuple[Value, ...] = ()
        self._integrator: Any = None
        self._series: Any = None

    def run(self, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        """Make a run for each set; bad parameters are a failure of their run."""
        found = [_NOTHING] * len(sets)
        for runs in _with_equal_texts(self._task.model, sets):
            self._run_together(sets, runs, found)
        return found

    def _run_together(
        self, sets: Sequence[Mapping[str, object]], runs: Sequence[int], found: list[Outcome]
    ) -> None:
        """Make runs together if possible, else in parts, in the end one by one."""
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
        """Build the systems of all sets at once, and prepare their runs.

        Raises
        ------
        PartingError : systems that differ in more than their numbers.
        ValueError : a system that the method cannot integrate.
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
        """Make an integrator for systems like the example, and the series that collects its columns."""
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
        """Make all runs, and yield their outcomes."""
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
                why = why_stopped(one.status, f"at {one.time:.6g} s, in step {one.steps}")
                yield Outcome(found, why, {}, *corners)
            first += len(ended)


_solver = itemgetter(
    "solver.method", "solver.step", "solver.tolerance", "solver.theta", "solver.beyond_stable"
)


def _with_equal_texts(model: str, sets: Sequence[Mapping[str, object]]) -> Iterable[list[int]]:
    """Group runs that give the same parameters, with equal values except for numbers of the system."""
    declared = _declared(model)
    texts: dict[tuple[str, ...], list[str]] = {}
    together: dict[object, list[int]] = {}
    for run, given in enumerate(sets):
        names = tuple(given)
        if names not in texts:
            texts[names] = [name for name in names if not _is_number(declared.get(name))]
        values = [given[name] for name in texts[names]]
        # True, 1 and 1.0 are equal, but not the same parameter value
        key = (names, *values, *map(type, values))
        try:
            together.setdefault(key, []).append(run)
        except TypeError:  # unhashable, which no parameter can be
            together[run] = [run]
    return together.values()


def _declared(model: str) -> dict[str, Variable]:
    return {v.name: v for v in variables(model) if v.causality == "parameter"}


def _is_number(declared: Variable | None) -> bool:
    """Return whether a parameter may differ among runs that are made together."""
    return (
        declared is not None
        and isinstance(declared.start, float)
        and not declared.name.startswith("solver.")
    )


def _together(model: str, sets: Sequence[Mapping[str, object]]) -> dict[str, Value]:
    """Return all parameters of sets that give the same names, with many numbers in place of one.

    Raises
    ------
    ParameterError : a value that its parameter does not allow.
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
