"""Peaks and root mean squares of any output."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from math import sqrt

from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run

_NOT_MOTION = (
    "airborne_time", "last_lift_off", "last_touchdown", "energy_residual", "stable_step",
)  # fmt: skip


def of_motion(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """`peak.X`, `rms.X` and `amplitude.X` of every output X that is a number in time."""
    for name, output in outputs.items():
        if type(output.start) is float and not name.endswith(_NOT_MOTION):
            unit = output.unit or "1"
            yield Measure(
                f"peak.{name}", unit, (name,), partial(peak, name),
                f"value of largest magnitude of {name} among the rows, with its sign",
            )  # fmt: skip
            yield Measure(
                f"rms.{name}", unit, (name,), partial(root_mean_square, name),
                f"root of the time mean of the square of {name}",
            )  # fmt: skip
            yield Measure(
                f"amplitude.{name}", unit, (name,), partial(amplitude, name),
                f"half of largest minus smallest {name} over the second half of the run: the "
                "amplitude of a steady vibration, when what the start has set off has died away",
            )  # fmt: skip


def peak(name: str, run: Run) -> Reading:
    """The value of largest magnitude among the rows, the first of equals, with its sign."""
    column = run.columns[name]
    return _at(run, name, int(abs(column).argmax()))


def amplitude(name: str, run: Run) -> Reading:
    """Half of largest minus smallest value over the second half of the run."""
    late = run.columns[name][run.time >= 0.5 * (run.time[0] + run.time[-1])]
    return Reading(0.5 * float(late.max() - late.min()))


def smallest(name: str, run: Run) -> Reading:
    """The smallest value among the rows."""
    return _at(run, name, int(run.columns[name].argmin()))


def last(name: str, run: Run) -> Reading:
    """The value at the end of the run."""
    return Reading(run.columns[name][-1].item())


def root_mean_square(name: str, run: Run) -> Reading:
    """sqrt(1/T integral x^2 dt), by the trapezoidal rule over the rows."""
    return Reading(sqrt(run.mean(run.columns[name] ** 2)))


def instants(name: str, run: Run) -> Reading:
    """The instants that an output held one after the other; -1 stands for none yet."""
    held: Iterable[float] = run.columns[name].tolist()
    found, before = [], -1.0
    for instant in held:
        if instant not in (before, -1.0):
            found.append(instant)
        before = instant
    return Reading(tuple(found))


def first_instant(name: str, run: Run) -> Reading:
    """The first of `instants`."""
    found = instants(name, run).value
    return Reading(found[0] if isinstance(found, tuple) and found else None)


def _at(run: Run, name: str, row: int) -> Reading:
    return Reading(float(run.columns[name][row]), float(run.time[row]))
