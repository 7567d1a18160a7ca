"""The measures of a run, from the model's solution where it is known, else from the rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import simulate
from ..errors import one_line
from ..measures import Measure, Reading, Run, take
from ..measures.solution import Solution, apart, instants, refinement, simulated, solved
from ..results.quantities import span
from ..scene.equation import EQUATION

if TYPE_CHECKING:
    from ..columns import Columns
    from ..scene.schema import Scene


_AGREES = 1e-6  # of their peaks: largest difference between rows and solution


@dataclass(frozen=True)
class Measured:
    """The measures of a run.

    Parameters
    ----------
    readings : readings by the names of the measures
    run : times and outputs from which most of them are taken
    interval : largest time between two points, s; 0 if no measure needs the course over time
    agreement : largest difference between the FMU's rows and the model's solution, over the peaks;
        None if there is no such solution
    remarks : remarks for the report
    """

    readings: dict[str, Reading]
    run: Run
    interval: float = 0.0
    agreement: float | None = None
    remarks: tuple[str, ...] = ()


def evaluate(scene: Scene, rows: Columns, own: Solution | None = None) -> Measured:
    """Take the measures of a scene.

    Parameters
    ----------
    scene : the scene that was run
    rows : columns read from the FMU
    own : the model's solution, if it is known already
    """
    known = scene.fmu.measures()
    model = "" if scene.fmu.path else scene.fmu.model
    parameters = scene.all_parameters
    run = Run(rows, parameters, model)
    over_time = [known[name] for name in scene.measures if known[name].over_time]
    during = {one.output for one in scene.during}
    if not over_time and not during:
        return Measured(take(known, scene.measures, run), run)
    interval, agreement, remarks = scene.communication_step, None, []
    if own is None and scene.fmu.is_ours and len(rows["time"]) > 1:
        own, agreement = _solution(scene, rows, over_time, during)
        if own.failure or agreement > _AGREES:
            why = own.failure or (
                f"they differ from this version's solution by up to {agreement:.2g} of the peaks; the "
                "FMU may be of another version"
            )
            remarks.append(f"measures are taken from the rows: {one_line(why)}")
            own = None
    if own is not None and len(own.columns["time"]) > 1:
        interval = float(own.columns["time"][1] - own.columns["time"][0])
        run = Run(own.columns, parameters, model, own.details)
    if scene.controller is not None:
        remarks.append(
            f"measures under a controller are taken from points {span(interval)} apart; a smaller "
            "output_interval shows what is between them"
        )
    elif own is None and not scene.fmu.is_ours:
        remarks.append(
            f"measures are taken at the communication points, every {span(interval)}; extremes "
            "between them are not detected"
        )
    remarks += _too_coarse(over_time, interval)
    taken = take(known, scene.measures, run, Run(rows, parameters, model))
    return Measured(taken, run, interval, agreement, tuple(remarks))


def read_at(scene: Scene, instants: Sequence[float], outputs: Iterable[str]) -> Columns:
    """Return the model's solution at the given times and at the start, or {} if it is not known."""
    time = np.array(sorted({0.0, *instants}))
    if scene.fmu.model == EQUATION:
        starts = scene.construction.starts
        return simulate.solving.solve(scene.all_parameters, time, starts=starts)[0]
    if not scene.fmu.is_ours:
        return {}
    own = next(simulated(scene.fmu.model, [scene.all_parameters], time, set(outputs)))
    return {} if own.failure else own.columns


def _solution(
    scene: Scene, rows: Columns, measures: list[Measure], during: set[str]
) -> tuple[Solution, float]:
    """Return the model's solution up to the last row, and the difference of the rows from it."""
    reached, interval = float(rows["time"][-1]), scene.communication_step
    time = instants(reached, interval, refinement(scene.duration, interval))
    solution = next(solved(scene.fmu.model, [scene.all_parameters], time, measures, during))
    return solution, apart(rows, solution)


def _too_coarse(measures: list[Measure], interval: float) -> Iterator[str]:
    """Yield remarks on the measures whose points are too far apart."""
    for measure in measures:
        if interval > measure.longest_interval * (1.0 + 1e-9):
            yield (
                f"{measure.name} is taken from points {span(interval)} apart; it needs points at "
                f"most {span(measure.longest_interval)} apart"
            )
