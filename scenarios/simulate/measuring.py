"""The measures of a run: of the model's own solution where it is known, else of the rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .. import simulate
from ..errors import one_line
from ..measures import Measure, Reading, Run, catalogue, take
from ..measures.solution import Solution, apart, instants, refinement, simulated, solved
from ..scene.equation import EQUATION

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..scene.schema import Scene

    Columns = Mapping[str, npt.NDArray[np.float64]]

_AGREES = 1e-6  # of their peaks: rows that lie no further from the solution are rows of it


@dataclass(frozen=True)
class Measured:
    """What has been measured of a run.

    Parameters
    ----------
    readings : by the names of the measures
    run : instants and outputs from which most of them are taken
    interval : from one instant to the next at most, s; 0 if no course over time was wanted
    agreement : largest difference of the FMU's rows from the model's own solution, over the peaks;
        None where there is no such solution
    remarks : what one should know of it
    """

    readings: dict[str, Reading]
    run: Run
    interval: float = 0.0
    agreement: float | None = None
    remarks: tuple[str, ...] = ()


def measured(scene: Scene, rows: Columns, own: Solution | None = None) -> Measured:
    """Take the measures of a scene.

    Parameters
    ----------
    scene : what was run
    rows : columns as the FMU has given them
    own : the solution, where it is known already
    """
    known = catalogue(scene.fmu.outputs())
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
                f"they lie up to {agreement:.2g} of the peaks from the model's own solution, as those "
                "of another version of it would"
            )
            remarks.append(f"measured at the rows: {one_line(why)}")
            own = None
    if own is not None and len(own.columns["time"]) > 1:
        interval = float(own.columns["time"][1] - own.columns["time"][0])
        run = Run(own.columns, parameters, model, own.details)
    elif own is None and not scene.fmu.is_ours:
        remarks.append(
            f"measured at the communication points, every {1e3 * interval:g} ms: what happens "
            "between them is not seen"
        )
    remarks += _too_coarse(over_time, interval)
    taken = take(known, scene.measures, run, Run(rows, parameters, model))
    return Measured(taken, run, interval, agreement, tuple(remarks))


def read_at(scene: Scene, instants: Sequence[float], outputs: Iterable[str]) -> Columns:
    """The model's own solution at some instants, and at the start; nothing where it is not known."""
    time = np.unique([0.0, *instants])
    if scene.fmu.model == EQUATION:
        return simulate.solving.solve(scene.all_parameters, time)[0]
    if not scene.fmu.is_ours:
        return {}
    own = next(simulated(scene.fmu.model, [scene.all_parameters], time, set(outputs)))
    return {} if own.failure else own.columns


def _solution(
    scene: Scene, rows: Columns, measures: list[Measure], during: set[str]
) -> tuple[Solution, float]:
    """The model's own solution as far as the rows go, and how far they lie from it."""
    reached, interval = float(rows["time"][-1]), scene.communication_step
    time = instants(reached, interval, refinement(scene.duration, interval))
    solution = next(solved(scene.fmu.model, [scene.all_parameters], time, measures, during))
    return solution, apart(rows, solution)


def _too_coarse(measures: list[Measure], interval: float) -> Iterator[str]:
    """What is said of measures whose instants lie too far apart."""
    for measure in measures:
        if interval > measure.longest_interval * (1.0 + 1e-9):
            yield (
                f"{measure.name} is taken from points {1e3 * interval:g} ms apart: they should be "
                f"{1e3 * measure.longest_interval:g} ms apart at most"
            )
