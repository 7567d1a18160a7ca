"""Measures of the model's small motions about rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

from phaseplane.suspension.models import build
from phaseplane.suspension.variables import Variable

from .. import measures
from .reading import Measure, Reading, Run


def of_modes(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield natural frequencies and damping ratios, lowest frequency first."""
    if "stable_step" in outputs:  # a model of this package
        for name, unit, what in (
            ("natural_frequencies", "Hz", "frequency"),
            ("damping_ratios", "1", "damping_ratio"),
        ):
            about = f"{name.replace('_', ' ')} of small motions about rest, lowest frequency first"
            yield Measure(name, unit, (), partial(_of_run, what), about, at_end=True)


def _of_run(what: str, run: Run) -> Reading:
    if not run.model:
        return Reading(None)
    level = {"road.shape": "flat"} if "road.shape" in run.parameters else {}
    modes = measures.linearised.linearised(build(run.model, {**run.parameters, **level})).modes()
    return Reading(tuple(getattr(mode, what) for mode in modes))
