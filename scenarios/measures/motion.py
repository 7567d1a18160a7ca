"""Peaks, root mean squares and amplitudes of any output."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import inf, sqrt
from operator import neg
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run, late

if TYPE_CHECKING:
    from ..columns import Column

_ROUNDING = 1e-12  # of the largest magnitude
_STARTED = re.compile(r"start(\d+)_(\w+)")  # of an equation with several starts
_NOT_MOTION = (
    "airborne_time", "last_lift_off", "last_touchdown", "energy_residual", "stable_step",
)  # fmt: skip


def start_of(output: str) -> tuple[int, str]:
    """Return the number of the start that an output belongs to, and its name for the first start."""
    found = _STARTED.fullmatch(output)
    return (int(found[1]), found[2]) if found else (1, output)


def of_motion(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield `peak.X`, `rms.X` and `amplitude.X` of every output X that is a real number."""
    for name, output in outputs.items():
        if type(output.start) is float and not name.endswith(_NOT_MOTION):
            for what, take, about, details in (
                ("peak", peak, f"signed value of largest magnitude of {name}", "peak"),
                ("rms", root_mean_square, f"root mean square of {name}", "mean"),
                ("amplitude", amplitude,
                 f"half the range of {name} over the second half of the run: the amplitude of a "
                 "steady vibration once the transient has died away", "late range"),
            ):  # fmt: skip
                yield Measure(
                    f"{what}.{name}", output.unit or "1", (name,), partial(take, name), about,
                    details=details,
                )  # fmt: skip


def peak(name: str, run: Run) -> Reading:
    """Return the signed value of largest magnitude, the first of equals."""
    return _reading(run.closely(name), abs)


def amplitude(name: str, run: Run) -> Reading:
    """Return half the range over the second half of the run; rounding errors of a constant are 0."""
    _, values = run.closely(name, late(run.time))
    return Reading(0.5 * _rounded(float(values.max() - values.min()), values))


def smallest(name: str, run: Run) -> Reading:
    """Return the smallest value."""
    return _reading(run.closely(name), neg)


def last(name: str, run: Run) -> Reading:
    """Return the value at the end of the run."""
    return Reading(run.columns[name][-1].item())


def root_mean_square(name: str, run: Run) -> Reading:
    """Return sqrt(1/T integral x^2 dt)."""
    return Reading(sqrt(run.mean(square, name)))


def square(column: Column) -> Column:
    """Return x^2."""
    return column * column


def instants(name: str, run: Run) -> Reading:
    """Return the successive values of an output that holds times; -1 means none yet."""
    held = run.closely(name)[1]
    return Reading(tuple(held[np.diff(held, prepend=-1.0) != 0.0].tolist()))


def first_instant(name: str, run: Run) -> Reading:
    """Return the first of `instants`, or None."""
    found = instants(name, run).value
    return Reading(found[0] if isinstance(found, tuple) and found else None)


def _reading(found: tuple[Column, Column], height: Callable[[Column], Column]) -> Reading:
    """Return the value of largest `height`, and its time: the first of those equal but for rounding."""
    time, values = found
    heights = height(values)
    row = int((heights >= heights.max() - _ROUNDING * abs(values).max()).argmax())
    return Reading(_rounded(float(values[row]), values), float(time[row]))


def _rounded(value: float, column: Column) -> float:
    """Return a value taken from a column, or 0 if it is zero but for rounding."""
    return 0.0 if abs(value) <= _ROUNDING * abs(column).max() < inf else value
