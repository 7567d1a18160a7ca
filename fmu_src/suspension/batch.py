"""Many runs of one model with other parameters each, over all cores.

The integrator gives Python's lock back while it steps, so plain threads run side by side. A run that
cannot be made is a record with its reason; the others go on.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, isfinite
from operator import itemgetter
from typing import Any

from .engine import FAILURES, Integrator, run_all
from .models import build, build_checked
from .remembering import Remembering
from .series import Series, at_the_end, over_time
from .session import start_state
from .systems import System
from .variables import ParameterError, Value, checked_parameters, refuse_unknown, variables

_CHUNK = 64  # runs that a thread takes at a time
_GROUP = 8  # of them that it steps without Python's lock


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one run.

    Parameters
    ----------
    columns : values over the instants by the name of the output; up to where the run came
    failure : why it ended before the last instant, or empty
    at_end : values at the last instant by the name of the output; none if the run ended before
    """

    columns: Mapping[str, Sequence[float]]
    failure: str = ""
    at_end: Mapping[str, float] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether the whole run could be made."""
        return not self.failure


def run_many(
    model: str,
    parameter_sets: Sequence[Mapping[str, object]],
    times: Sequence[float],
    outputs: Sequence[str],
    workers: int | None = None,
    *,
    at_end: Sequence[str] = (),
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
    >>> from suspension.batch import run_many
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
    task = _Task(model, instants, tuple(outputs), tuple(at_end))
    workers = workers or os.cpu_count() or 1
    size = min(_CHUNK, ceil(len(parameter_sets) / (4 * workers)) or 1)
    chunks = [parameter_sets[k : k + size] for k in range(0, len(parameter_sets), size)]
    found: list[Outcome] = []
    # those that no thread works at
    benches = [_Bench(task, 1 if workers == 1 else _GROUP) for _ in range(workers)]

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


class _Place:
    """An integrator and its columns, for one run after the other.

    A run begins with what the one before has left: the integrator begins anew as long as the system fits.
    """

    def __init__(self, task: _Task) -> None:
        self._task = task
        self._solver: tuple[Value, ...] = ()
        self.integrator: Any = None

    def begin(self, system: System, parameters: Mapping[str, Value]) -> None:
        """Prepare a run; a ValueError says why it cannot be made."""
        task, start = self._task, self._task.times[0]
        solver = method, step, tolerance, theta, beyond = _solver(parameters)
        if solver != self._solver or not self.integrator.restart(system, start):
            self.integrator = Integrator(
                system, method, step, tolerance, start,
                energy=False, theta=theta, beyond_stable=beyond,
            )  # fmt: skip
            self._series = Series(system, task.times, task.outputs, task.at_end)
            self._solver = solver
        state = start_state(system, parameters, start)
        if state is not None:
            self.integrator.set_state(*state)
        self._series.prepare(system, self.integrator)

    def outcome(self, status: int) -> Outcome:
        """What became of the run."""
        columns = self._series.columns()
        if status != 0:
            at, step = self.integrator.time, self.integrator.step_count
            return Outcome(columns, f"{FAILURES[status]} at {at:.6g} s, in step {step}")
        return Outcome(columns, at_end=self._series.ends())


class _Bench:
    """Where runs are made in groups: a system is made anew as far as parameters have changed.

    The groups let several threads take turns seldom: all of a group are prepared, then all of them run
    without Python's lock.
    """

    def __init__(self, task: _Task, group: int) -> None:
        self._model = task.model
        self._parameters = Remembering()
        self._places = [_Place(task) for _ in range(group)]

    def run(self, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        """Make a run for each set; what its parameters do not allow is its failure."""
        size = len(self._places)
        groups = (sets[k : k + size] for k in range(0, len(sets), size))
        return [outcome for group in groups for outcome in self._run_group(group)]

    def _run_group(self, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
        begun = [self._begin(*each) for each in zip(self._places, sets, strict=False)]
        places = [place for place in begun if isinstance(place, _Place)]
        statuses = iter(run_all([place.integrator for place in places]))
        return [one.outcome(next(statuses)) if isinstance(one, _Place) else one for one in begun]

    def _begin(self, place: _Place, given: Mapping[str, object]) -> _Place | Outcome:
        try:
            self._parameters.update(checked_parameters(self._model, given))
            place.begin(build_checked(self._model, self._parameters), self._parameters)
        except ValueError as error:  # a ParameterError among them
            return Outcome({}, str(error))
        return place


_solver = itemgetter(
    "solver.method", "solver.step", "solver.tolerance", "solver.theta", "solver.beyond_stable"
)
