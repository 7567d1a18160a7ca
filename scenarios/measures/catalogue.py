"""All measures that a model's outputs allow, by name, and how to take them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache, partial
from types import MappingProxyType

import numpy as np
from phaseplane.suspension.variables import Variable

from .axle import of_axles
from .modal import of_modes
from .motion import last, of_motion, start_of
from .motion import peak as largest
from .reading import COUNT, Measure, Reading, Run
from .ride import of_ride
from .road import of_roads
from .sensitivity import of_sensitivity

# The measures taken by default: cheap and of general interest.
_DEFAULT_PEAKS = ("_displacement", "_deflection", "_acceleration")
_DEFAULT = (
    "lift_off_count", "airborne_time", "lift_offs", "touchdowns", "smallest_contact_force",
    "energy_residual", "step_count",
)  # fmt: skip


def catalogue(outputs: Mapping[str, Variable]) -> Mapping[str, Measure]:
    """Return every measure of a model, by name.

    Parameters
    ----------
    outputs : outputs of the model, by name
    """
    return _measures_of(tuple(outputs.values()))


@lru_cache(maxsize=16)
def _measures_of(variables: tuple[Variable, ...]) -> Mapping[str, Measure]:
    """Return the catalogue, made once for each model."""
    outputs = {variable.name: variable for variable in variables}
    measures = [
        *of_motion(outputs), *of_axles(outputs), *of_ride(outputs), *of_roads(outputs),
        *of_modes(outputs), *of_sensitivity(outputs), *_of_the_solver(outputs),
    ]  # fmt: skip
    return MappingProxyType({measure.name: measure for measure in measures})


def default_measures(known: Mapping[str, Measure], shown: Iterable[str]) -> tuple[str, ...]:
    """Return the default measures: peaks of the motions shown, contact, the solver.

    If none of these motions is shown, peaks of all outputs shown.
    """
    shown = list(shown)
    motions = [name for name in shown if start_of(name)[1].endswith(_DEFAULT_PEAKS)]
    peaks = {f"peak.{name}" for name in motions or shown}
    return tuple(name for name in known if name in peaks or name.endswith(_DEFAULT))


def has_sign(measure: str) -> bool:
    """Whether a measure has a sign for its direction, and is compared by its magnitude."""
    return measure.startswith("peak.")


def outputs_needed(known: Mapping[str, Measure], names: Iterable[str]) -> set[str]:
    """Return the outputs that the named measures need."""
    return {output for name in names for output in known[name].needs}


def take(
    known: Mapping[str, Measure], names: Iterable[str], run: Run, rows: Run | None = None
) -> dict[str, Reading]:
    """Take measures of a run; a reading is None if the run lacks its columns.

    Parameters
    ----------
    known : the catalogue
    names : names of the measures
    run : the outputs over time
    rows : the outputs at the rows and at the end, if they are not in `run`
    """
    with np.errstate(over="ignore", invalid="ignore"):  # the reading is not finite then
        return {
            name: _taken(known[name], run if rows is None or known[name].over_time else rows)
            for name in names
        }


def _taken(measure: Measure, run: Run) -> Reading:
    there = len(run.time) > 0 and all(needed in run.columns for needed in measure.needs)
    return measure.take(run) if there else Reading(None)


def _of_the_solver(outputs: Mapping[str, Variable]) -> Iterable[Measure]:
    for name, how, unit, about in (
        ("energy_residual", largest, "J", "largest error of the energy balance, at the rows"),
        ("step_count", last, COUNT, "internal steps of the integrator"),
    ):
        if name in outputs:
            yield Measure(
                name, unit, (name,), partial(how, name), about, at_end=how is last,
                at_rows=how is not last,
            )  # fmt: skip
