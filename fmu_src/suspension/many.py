"""Numbers that many runs have in place of one, so that a system is made once for all of them.

What makes systems from parameters only calculates and compares. Given arrays it calculates with all runs
at once, as long as every comparison turns out the same for all; where one does not, the runs part.
"""

from __future__ import annotations

from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

Whatever = TypeVar("Whatever")


class PartingError(Exception):
    """A comparison that does not turn out the same for all runs.

    Parameters
    ----------
    which : of each run, how it turned out for that one
    """

    def __init__(self, which: npt.NDArray[np.bool_]) -> None:
        super().__init__("a comparison turns out differently from run to run")
        self.which = which


class Many(np.ndarray[Any, np.dtype[np.float64]]):
    """The values of one number in several runs.

    Arithmetic gives each run what floats give it, to the bit. It is no float: what needs one, such as
    a function of `math`, raises a TypeError.
    """

    def __bool__(self) -> bool:
        which = np.asarray(self, dtype=bool)
        if which.all():
            return True
        if which.any():
            raise PartingError(which)
        return False

    def __iadd__(self, other: Any) -> Any:  # type: ignore[misc]
        """Another number, as of floats: nobody who has the old one sees it change."""
        return self + other

    def __isub__(self, other: Any) -> Any:  # type: ignore[misc]
        return self - other

    def __imul__(self, other: Any) -> Any:  # type: ignore[misc]
        return self * other

    def __itruediv__(self, other: Any) -> Any:  # type: ignore[misc]
        return self / other

    def __float__(self) -> float:
        raise TypeError("several runs have no single number")


def many(values: npt.NDArray[np.float64]) -> float | Many:
    """One number if all of them are equal, else all of them."""
    first = values[0]
    return float(first) if (values == first).all() else values.view(Many)


def of_run(whatever: Whatever, run: int) -> Whatever:
    """The same with the number of one run in place of those of many, also within tuples."""
    return cast("Whatever", _of_run(whatever, run))


def _of_run(whatever: object, run: int) -> object:
    if isinstance(whatever, Many):
        return float(np.asarray(whatever)[run])
    if not isinstance(whatever, tuple):
        return whatever
    parts = [_of_run(part, run) for part in whatever]
    if all(new is old for new, old in zip(parts, whatever, strict=True)):
        return whatever
    make = getattr(whatever, "_make", tuple)  # named tuples have it
    return make(parts)


def table(numbers: list[float | Many], runs: int) -> npt.NDArray[np.float64]:
    """A row for each run with its own of all numbers."""
    rows = np.empty((runs, len(numbers)))
    rows[:] = [0.0 if isinstance(x, Many) else x for x in numbers]
    for k, x in enumerate(numbers):
        if isinstance(x, Many):
            rows[:, k] = x
    return rows
