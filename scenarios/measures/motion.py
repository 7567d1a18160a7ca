"""Peaks and root mean squares of any output."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from math import sqrt
from operator import neg
from typing import TYPE_CHECKING

from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run, late

if TYPE_CHECKING:
    from .reading import Column

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
                f"value of largest magnitude of {name}, with its sign", details="peak",
            )  # fmt: skip
            yield Measure(
                f"rms.{name}", unit, (name,), partial(root_mean_square, name),
                f"root of the time mean of the square of {name}", details="switches",
            )  # fmt: skip
            yield Measure(
                f"amplitude.{name}", unit, (name,), partial(amplitude, name),
                f"half of largest minus smallest {name} over the second half of the run: the "
                "amplitude of a steady vibration, when what the start has set off has died away",
                details="late range",
            )  # fmt: skip


def peak(name: str, run: Run) -> Reading:
    """The value of largest magnitude, the first of equals, with its sign."""
    return _reading(run.closely(name), abs)


def amplitude(name: str, run: Run) -> Reading:
    """Half of largest minus smallest value over the second half of the run."""
    _, values = run.closely(name, late(run.time))
    return Reading(0.5 * float(values.max() - values.min()))


def smallest(name: str, run: Run) -> Reading:
    """The smallest value."""
    return _reading(run.closely(name), neg)


def last(name: str, run: Run) -> Reading:
    """The value at the end of the run."""
    return Reading(run.columns[name][-1].item())


def root_mean_square(name: str, run: Run) -> Reading:
    """sqrt(1/T integral x^2 dt)."""
    return Reading(sqrt(run.mean(square, name)))


def square(column: Column) -> Column:
    """x^2."""
    return column * column


def instants(name: str, run: Run) -> Reading:
    """The instants that an output held one after the other; -1 stands for none yet."""
    held: Iterable[float] = run.closely(name)[1].tolist()
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


def _reading(found: tuple[Column, Column], height: Callable[[Column], Column]) -> Reading:
    """The value that is highest in some sense, and its instant."""
    time, values = found
    row = int(height(values).argmax())
    return Reading(float(values[row]), float(time[row]))
