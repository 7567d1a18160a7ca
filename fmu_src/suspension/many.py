"""Arrays of one number in many runs, with which a system is built once for all of them.

The functions that build systems from parameters only calculate and compare. Given arrays they calculate
for all runs at once, as long as every comparison has the same result in all; if not, the runs part.
"""

from __future__ import annotations

from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

Whatever = TypeVar("Whatever")


class PartingError(Exception):
    """A comparison with different results in different runs.

    Parameters
    ----------
    which : its result in each run
    """

    def __init__(self, which: npt.NDArray[np.bool_]) -> None:
        super().__init__("a comparison has different results in different runs")
        self.which = which


class Many(np.ndarray[Any, np.dtype[np.float64]]):
    """The values of one number in several runs.

    Arithmetic gives the same results for each run as with floats, to the bit. It is not a float: a
    function that needs one, such as those of `math`, raises a TypeError.
    """

    def __bool__(self) -> bool:
        which = np.asarray(self, dtype=bool)
        if which.all():
            return True
        if which.any():
            raise PartingError(which)
        return False

    def __iadd__(self, other: Any) -> Any:  # type: ignore[misc]
        """Return a new number, as floats do: other references to the old one are not affected."""
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
    """Return a single number if all values are equal, else all of them."""
    first = values[0]
    return float(first) if (values == first).all() else values.view(Many)


def of_run(whatever: Whatever, run: int) -> Whatever:
    """Replace the numbers of many runs by that of one run, also within tuples."""
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
    """Return the numbers of each run, (runs, numbers)."""
    rows = np.empty((runs, len(numbers)))
    rows[:] = [0.0 if isinstance(x, Many) else x for x in numbers]
    for k, x in enumerate(numbers):
        if isinstance(x, Many):
            rows[:, k] = x
    return rows
