"""Measures of the model's small motions about rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from phaseplane.suspension.variables import Variable

from .. import measures
from .reading import Measure, Reading, Run


def of_modes(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield natural frequencies and damping ratios, lowest frequency first, and their extremes."""
    if "stable_step" not in outputs:  # no model of this package
        return
    for name, unit, what, meant, extremes in (
        (
            "natural_frequencies",
            "Hz",
            "frequency",
            "|s| / 2 pi",
            {"lowest_natural_frequency": min, "highest_natural_frequency": max},
        ),
        ("damping_ratios", "1", "damping_ratio", "-Re s / |s|", {"least_damping_ratio": min}),
    ):
        about = (
            f"{name.replace('_', ' ')} of small damped motions about rest, lowest frequency first: "
            f"{meant} of each eigenvalue s"
        )
        taken = partial(_of_run, what)
        yield Measure(name, unit, (), taken, about, at_end=True, single=tuple(extremes))
        for single, extreme in extremes.items():
            about = f"{single.replace('_', ' ')} of small damped motions about rest"
            yield Measure(single, unit, (), partial(_extreme, extreme, taken), about, at_end=True)


def _extreme(extreme: Callable[[Any], float], taken: Callable[[Run], Reading], run: Run) -> Reading:
    values = taken(run).value
    return Reading(extreme(values) if values else None)


def _of_run(what: str, run: Run) -> Reading:
    if not run.model:
        return Reading(None)
    modes = measures.linearised.about_rest(run.model, run.parameters).modes()
    return Reading(tuple(getattr(mode, what) for mode in modes))
