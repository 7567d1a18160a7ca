"""Many runs of one model with other parameters each, over all cores.

The integrator gives Python's lock back while it steps, so plain threads run side by side. A run that
cannot be made is a record with its reason; the others go on.
"""

from __future__ import annotations

import os
from array import array
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise, repeat
from math import isfinite

from .engine import FAILURES, Integrator
from .models import build
from .session import start_state
from .variables import ParameterError, checked_parameters, refuse_unknown, variables

_ORDERS = ("displacement", "velocity", "acceleration")
_CHUNK = 16  # runs that a thread takes at a time


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one run.

    Parameters
    ----------
    columns : values over the instants by the name of the output; up to where the run came
    failure : why it ended before the last instant, or empty
    """

    columns: Mapping[str, array[float]]
    failure: str = ""

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
    progress: Callable[[float], None] | None = None,
) -> list[Outcome]:
    """Run a model once for each set of parameters.

    Roads are internal: there are no inputs. The energy ledger is not kept.

    Parameters
    ----------
    model : key of `variables.MODELS`
    parameter_sets : parameters that are not at their defaults, for each run
    times : s, ascending; the first is the start
    outputs : displacements, velocities and accelerations of coordinates
    workers : threads; None for one on each core
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
    task = _Task.of(model, instants, outputs)
    chunks = [parameter_sets[k : k + _CHUNK] for k in range(0, len(parameter_sets), _CHUNK)]
    found: list[Outcome] = []
    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        for part in pool.map(_run_chunk, repeat(task), chunks):
            found += part
            if progress is not None:
                progress(len(found) / len(parameter_sets))
    return found


@dataclass(frozen=True, slots=True)
class _Task:
    """What all runs have in common: for each output its order of derivative and its coordinate."""

    model: str
    times: array[float]
    columns: Mapping[str, tuple[int, int]]

    @classmethod
    def of(cls, model: str, times: array[float], outputs: Sequence[str]) -> _Task:
        variables(model)  # refuses a model that is not known
        coordinates = build(model, checked_parameters(model, {})).coordinates
        known = {
            f"{name}_{what}".lstrip("_"): (order, i)
            for i, name in enumerate(coordinates)
            for order, what in enumerate(_ORDERS)
        }
        refuse_unknown(outputs, known, f"a batch of {model} has no output")
        return cls(model, times, {name: known[name] for name in outputs})


def _run_chunk(task: _Task, sets: Sequence[Mapping[str, object]]) -> list[Outcome]:
    return [_run(task, given) for given in sets]


def _run(task: _Task, given: Mapping[str, object]) -> Outcome:
    try:
        parameters = checked_parameters(task.model, given)
        system = build(task.model, parameters)
        integrator = Integrator(
            system,
            parameters["solver.method"],
            parameters["solver.step"],
            parameters["solver.tolerance"],
            task.times[0],
            energy=False,
            theta=parameters["solver.theta"],
            beyond_stable=parameters["solver.beyond_stable"],
        )
        state = start_state(system, parameters, task.times[0])
        if state is not None:
            integrator.set_state(*state)
    except ValueError as error:  # a ParameterError among them
        return Outcome({}, str(error))
    n, count = len(system.mass), len(task.times)
    wanted = {order for order, _ in task.columns.values()} | {0}
    filled = {order: array("d", bytes(8 * n * count)) for order in wanted}
    status = integrator.run(task.times, filled[0], filled.get(1), filled.get(2))
    end = n * integrator.filled
    columns = {name: filled[order][i:end:n] for name, (order, i) in task.columns.items()}
    failure = ""
    if status != 0:
        failure = f"{FAILURES[status]} at {integrator.time:.6g} s, in step {integrator.step_count}"
    return Outcome(columns, failure)
