"""Many runs of one model with different parameters, on all cores.

The integrator releases the global interpreter lock while it steps, so threads run in parallel. A run
that fails is recorded with its reason; the others continue.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from math import ceil, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..declared import solver_settings
from ..engine import Integrator
from ..equilibrium import start_state
from ..models import MODELS, SOURCES, build, cached
from ..notices import of_overruns, of_unstable
from ..outputs import reading_of
from ..reasons import why_raised, why_stopped
from ..systems import System
from ..variable import Variable
from ..variables import ParameterError, checked_parameters, refuse_unknown, variables
from ..variables import outputs as outputs_of
from .series import RESIDUAL, Ended, Series, is_at_end, is_over_time

if TYPE_CHECKING:
    from .slots import Slots

_CHUNK = 1024  # runs per task of a thread
_MANY = 32  # runs from which on their systems are built by columns
_MOST_KINDS = 8  # of systems, with an integrator for each
_MOST_NUMBERS = 4_000_000  # of systems whose runs are yet to be made


class Outcome(NamedTuple):
    """The result of one run.

    Parameters
    ----------
    columns : values over time by the name of the output, (times,); shorter if the run failed
    failure : why it ended before the last time, or empty
    at_end : values at the last time by the name of the output; empty if the run failed
    switches : times at which an element changed its branch, s, ascending, if corners are requested
    joints : times at which the course of a road or load may have a corner, likewise
    closer : values at the times that `closer` has returned, with `time`; empty if the run failed
    notices : what may make it less accurate than was asked for
    """

    columns: Mapping[str, npt.NDArray[np.float64]]
    failure: str = ""
    at_end: Mapping[str, float] = {}
    switches: Sequence[float] = ()
    joints: Sequence[float] = ()
    closer: Mapping[str, npt.NDArray[np.float64]] = {}
    notices: Sequence[str] = ()

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
    closer: Callable[[Outcome], Sequence[float]] | None = None,
    progress: Callable[[float], None] | None = None,
    going_on: Callable[[float], bool] | None = None,
) -> list[Outcome]:
    """Run a model once for each set of parameters.

    Roads are internal: there are no inputs. Of energies only the residual of the balance is computed.

    Parameters
    ----------
    model : key of `variables.MODELS`
    parameter_sets : parameters that are not at their defaults, for each run
    times : s, ascending; the first is the start
    outputs : outputs over time: motions, deflections, forces, contact, the road; see `outputs_over_time`
    workers : number of threads; None for one per core
    at_end : counts and sums at the last time; see `outputs_at_end`
    corners : whether to return the times at which outputs may jump or have a corner
    closer : returns further times after the start, s, ascending, at which the outputs of a run are
        wanted too, once it has been made
    progress : called with the fraction done, 0 to 1
    going_on : called every few thousand steps of a run with its time, s; False ends the run there, which
        is a failure that keeps what it has

    Returns
    -------
    An outcome for each set, in the same order.

    Raises
    ------
    ParameterError : unknown model or output, times that do not ascend, or no worker. Bad parameters, and
        what a function of a system raises, are a failure of their run only.

    Examples
    --------
    >>> from phaseplane.suspension.batch import run_many
    >>> cars = [{"damper.rebound_rate": rate} for rate in (500.0, 1000.0, -1.0)]
    >>> soft, hard, wrong = run_many("QuarterCar", cars, [0.0, 0.1, 0.2], ["body_displacement"])
    >>> len(soft.columns["body_displacement"])
    3
    >>> wrong.failure
    'damper.rebound_rate = -1: must be at least 0 N.s/m'
    """
    instants = array("d", times)
    if not instants or not np.all(np.isfinite(instants)):
        raise ParameterError("times must be finite, and at least one must be given")
    if np.any(np.diff(instants) < 0.0):
        raise ParameterError("times must ascend")
    if workers is not None and workers < 1:
        raise ParameterError(f"workers = {workers}: must be at least 1")
    for names, known in ((outputs, outputs_over_time), (at_end, outputs_at_end)):
        refuse_unknown(names, known(model), f"a batch of {model} has no output")
    declared = outputs_of(model)
    task = _Task(
        model,
        instants,
        {name: declared[name] for name in outputs},
        {name: declared[name] for name in at_end},
        corners,
        closer,
        going_on,
    )
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
    ParameterError : unknown model, or a source of signals, which cannot be run by itself.
    """
    return [*_over_time_and_at_end(model)[0]]


def outputs_at_end(model: str) -> list[str]:
    """Return the outputs that a batch can record at the last time.

    Raises
    ------
    ParameterError : unknown model, or a source of signals, which cannot be run by itself.
    """
    return [*_over_time_and_at_end(model)[1]]


@cached
def _over_time_and_at_end(model: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if model in SOURCES:
        raise ParameterError(
            f"{model} cannot be run by itself; models that can are {', '.join(MODELS)}"
        )
    system = build(model, {})
    readings = {name: reading_of(v, system) for name, v in outputs_of(model).items()}
    over_time, at_end = (
        tuple(name for name, reading in readings.items() if wanted(reading))
        for wanted in (is_over_time, is_at_end)
    )
    return over_time, at_end


class _Task(NamedTuple):
    """What all runs have in common."""

    model: str
    times: array[float]
    outputs: Mapping[str, Variable]
    at_end: Mapping[str, Variable]
    corners: bool
    closer: Callable[[Outcome], Sequence[float]] | None
    going_on: Callable[[float], bool] | None


@dataclass(slots=True)
class _Kind:
    """Runs of systems that differ only in their numbers, made by one integrator.

    Parameters
    ----------
    solver : from `solver_settings`
    runs : those yet to be made
    systems : of these runs, if they are needed beside their numbers
    numbers : the rows of their systems, one after the other
    """

    solver: Mapping[str, Any]
    integrator: Integrator
    series: Series
    runs: list[int] = field(default_factory=list)
    systems: list[System] = field(default_factory=list)
    numbers: array[float] = field(default_factory=lambda: array("d"))


class _Bench:
    """One thread's integrators, one for each kind of system."""

    def __init__(self, task: _Task) -> None:
        self._task = task
        self._kinds: list[_Kind] = []
        # by the parameters that vary and those that do not: how rows follow from them, and their kind
        self._known: dict[tuple[object, ...], tuple[Slots, _Kind] | None] = {}

    def run(self, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        """Make a run for each set; bad parameters are a failure of their run."""
        found = [_NOTHING] * len(sets)
        entered = self._enter_together(sets)
        for run, given in enumerate(sets):
            if run in entered:
                continue
            try:
                kind = self._enter(run, given)
            except Exception as error:  # functions of users may raise anything
                found[run] = Outcome({}, why_raised(error))
            else:
                if len(kind.numbers) > _MOST_NUMBERS:
                    self._make(kind, found)
                if len(self._kinds) > _MOST_KINDS:
                    self._make(self._kinds.pop(), found)
        for kind in self._kinds:
            self._make(kind, found)
        return found

    def _enter_together(self, sets: Sequence[Mapping[str, object]]) -> set[int]:
        """Add the runs whose systems differ only in their numbers, column by column; return which."""
        first = sets[0]
        if len(sets) < _MANY or any(given.keys() != first.keys() for given in sets):
            return set()
        declared = {v.name: v for v in variables(self._task.model)}
        varied = [name for name in first if any(given[name] != first[name] for given in sets)]
        if not varied or not all(_is_number(declared.get(name)) for name in varied):
            return set()
        found = self._slots(first, varied)
        if found is None or len(sets) * found[0].width > _MOST_NUMBERS:
            return set()
        slots, kind = found
        columns = {
            name: _column(declared[name], [given[name] for given in sets]) for name in varied
        }
        rows, valid = slots.rows(columns)
        for column in columns.values():
            valid &= np.isfinite(column)
        runs: list[int] = np.flatnonzero(valid).tolist()
        kind.numbers.frombytes(rows[runs].tobytes())
        kind.runs += runs
        if kind.series.needs_systems:
            kind.systems += [build(self._task.model, sets[run]) for run in runs]
        return set(runs)

    def _slots(
        self, first: Mapping[str, object], varied: Sequence[str]
    ) -> tuple[Slots, _Kind] | None:
        """Return how rows depend on the varied parameters; None if each system must be built."""
        model = self._task.model
        try:
            parameters = checked_parameters(model, first)
        except ValueError:
            return None
        same = tuple((name, value) for name, value in parameters.items() if name not in varied)
        key = (*varied, *same)
        if key in self._known:
            known = self._known[key]
            if known is None or any(kind is known[1] for kind in self._kinds):
                return known
        try:
            kind = self._kind(solver_settings(parameters), build(model, parameters))
            from .slots import Slots  # noqa: PLC0415  (a single run needs none)

            slots = Slots(model, parameters, varied, kind.integrator, self._task.times[0])
            self._known[key] = slots, kind
        except Exception:
            self._known[key] = None
        return self._known[key]

    def _enter(self, run: int, given: Mapping[str, object]) -> _Kind:
        """Build the system of a run, and add it to those of its kind.

        Raises
        ------
        ValueError : bad parameters, or a system that the method cannot integrate.
        Exception : any that a function of the system has raised.
        """
        model = self._task.model
        parameters = checked_parameters(model, given)
        system = build(model, parameters)
        state = start_state(system, parameters, self._task.times[0])
        kind = self._kind(solver_settings(parameters), system)
        kind.integrator.add_row(kind.numbers, system, *state, self._task.times[0])
        kind.runs.append(run)
        if kind.series.needs_systems:
            kind.systems.append(system)
        return kind

    def _kind(self, solver: Mapping[str, Any], system: System) -> _Kind:
        """Return the kind of a system, the latest first."""
        for k, kind in enumerate(self._kinds):
            if kind.solver == solver and kind.integrator.fits(system):
                if k:
                    self._kinds.insert(0, self._kinds.pop(k))
                return kind
        task = self._task
        asked = any(reading_of(v, system) == RESIDUAL for v in task.outputs.values())
        energy = solver["energy"] and asked
        integrator = Integrator(system, start=task.times[0], **{**solver, "energy": energy})
        integrator.going_on = task.going_on
        series = Series(
            integrator, system, task.times, task.outputs, task.at_end, task.corners,
            task.closer is not None,
        )  # fmt: skip
        self._kinds.insert(0, _Kind(solver, integrator, series))
        return self._kinds[0]

    def _make(self, kind: _Kind, found: list[Outcome]) -> None:
        """Make all runs of a kind."""
        runs, kind.runs = kind.runs, []
        systems, kind.systems = kind.systems, []
        numbers, kind.numbers = kind.numbers, array("d")
        if runs:
            kind.series.take(systems, numbers)
            for run, outcome in zip(runs, self._outcomes(kind, len(runs), systems), strict=True):
                found[run] = outcome

    def _outcomes(self, kind: _Kind, runs: int, systems: Sequence[System]) -> Iterator[Outcome]:
        """Make all runs that the series of a kind has taken, and yield their outcomes."""
        series, step = kind.series, kind.solver["step"]
        _, times, names, _, corners, closer, _ = self._task
        columns = np.empty((len(names), runs, len(times)))
        of_runs = list(zip(*columns, strict=True)) or [()] * runs
        first = 0
        while first < runs:
            ended = series.go(first, columns)
            for k, one in enumerate(ended):
                values = of_runs[first + k]
                switches, joints = (
                    (series.switches(k), systems[first + k].joints) if corners else ((), ())
                )
                said = [*_notices(one, step)]
                if one.status == 0:
                    found = dict(zip(names, values, strict=True))
                    ends = series.ends(k, one)
                    outcome = Outcome(found, "", ends, switches, joints, notices=said)
                    if closer is not None and (more := array("d", closer(outcome))):
                        there = zip(names, series.again(first + k, k, more), strict=True)
                        outcome = outcome._replace(closer={"time": np.array(more), **dict(there)})
                    yield outcome
                    continue
                found = {name: x[: one.filled] for name, x in zip(names, values, strict=True)}
                where = f"at {one.time:.6g} s, in step {one.steps}"
                if failure := series.failure(k):
                    why = why_raised(failure, where)
                else:
                    why = why_stopped(one.status, where, fixed=step > 0.0)
                yield Outcome(found, why, {}, switches, joints, notices=said)
            first += len(ended)


def _notices(one: Ended, step: float) -> Iterator[str]:
    """Yield what a run says at its end; see `Notices`.

    Parameters
    ----------
    step : the fixed step, s; 0 if there is none
    """
    if step > 0.0 and one.beyond_step > 0.0:
        yield of_unstable(step, one.beyond_since, one.beyond_step)
    if one.overruns:
        yield of_overruns(one.time)


def _is_number(variable: Variable | None) -> bool:
    """Return whether a parameter is a number that may vary within a batch of columns."""
    return (
        variable is not None
        and isinstance(variable.start, float)
        and not variable.name.startswith("solver.")
    )


def _column(variable: Variable, values: list[object]) -> npt.NDArray[np.float64]:
    """Return numbers in SI; NaN for those that cannot be taken."""
    if any(type(value) is not float for value in values):
        return np.array([_checked(variable, value) for value in values])
    numbers = np.array(values, np.float64) + 0.0  # never -0.0
    least, largest = variable.bounds
    return np.where((least <= numbers) & (numbers <= largest), numbers, nan)


def _checked(variable: Variable, value: object) -> float:
    """Return a number in SI; NaN if it cannot be taken."""
    try:
        return float(variable.checked(value))
    except ParameterError:
        return nan
