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
from math import isfinite
from operator import itemgetter
from typing import Any

from .engine import FAILURES, Integrator
from .models import build, build_checked
from .remembering import Remembering
from .series import Series, at_the_end, over_time
from .session import start_state
from .systems import System
from .variables import ParameterError, Value, checked_parameters, refuse_unknown, variables

_CHUNK = 64  # runs that a thread takes at a time


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
    chunks = [parameter_sets[k : k + _CHUNK] for k in range(0, len(parameter_sets), _CHUNK)]
    found: list[Outcome] = []
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        benches: list[_Bench] = []  # those that no thread works at

        def run_chunk(sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
            bench = benches.pop() if benches else _Bench(task)
            outcomes = [bench.run(given) for given in sets]
            benches.append(bench)
            return outcomes

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


class _Bench:
    """Where runs are made one after the other: a run begins with what the one before has left.

    The system is made anew as far as parameters have changed, and the integrator begins anew with it
    as long as it fits.
    """

    def __init__(self, task: _Task) -> None:
        self._task = task
        self._parameters = Remembering()
        self._solver: tuple[Value, ...] = ()
        self._integrator: Any = None

    def run(self, given: Mapping[str, object]) -> Outcome:
        """Make one run; what its parameters do not allow is its failure."""
        task, p = self._task, self._parameters
        try:
            p.update(checked_parameters(task.model, given))
            system = build_checked(task.model, p)
            self._set_up(system)
            state = start_state(system, p, task.times[0])
            if state is not None:
                self._integrator.set_state(*state)
        except ValueError as error:  # a ParameterError among them
            return Outcome({}, str(error))
        status = self._series.run(system, self._integrator)
        columns = self._series.columns()
        if status != 0:
            at, step = self._integrator.time, self._integrator.step_count
            return Outcome(columns, f"{FAILURES[status]} at {at:.6g} s, in step {step}")
        return Outcome(columns, at_end=self._series.ends())

    def _set_up(self, system: System) -> None:
        task = self._task
        solver = method, step, tolerance, theta, beyond = _solver(self._parameters)
        if solver == self._solver and self._integrator.restart(system, task.times[0]):
            return
        self._integrator = Integrator(
            system, method, step, tolerance, task.times[0],
            energy=False, theta=theta, beyond_stable=beyond,
        )  # fmt: skip
        self._series = Series(system, task.times, task.outputs, task.at_end)
        self._solver = solver


_solver = itemgetter(
    "solver.method", "solver.step", "solver.tolerance", "solver.theta", "solver.beyond_stable"
)
