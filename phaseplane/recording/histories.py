"""Which columns of a run are plotted together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .quantities import QUANTITIES, Quantity, in_words, quantity_of
from .styles import legible


@dataclass(frozen=True, slots=True)
class Panel:
    """The columns of one quantity.

    Parameters
    ----------
    times : shape (n,), s
    values : shape (n, columns), in the unit in which the quantity is shown
    """

    quantity: Quantity
    names: tuple[str, ...]
    times: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]

    @property
    def labels(self) -> list[str]:
        """Names as they are shown, with the unit."""
        return [legible(f"{in_words(name)} [{self.quantity.unit}]") for name in self.names]


def panels(histories: Mapping[str, npt.ArrayLike] | None) -> list[Panel]:
    """The columns by quantity, without those whose names do not say what they are.

    Parameters
    ----------
    histories : `time` (s) and columns of the same length over it, in SI

    Raises
    ------
    ValueError : no column `time`, or columns of unequal length.
    """
    if not histories:
        return []
    if "time" not in histories:
        raise ValueError(f"histories need a column 'time'; given: {', '.join(histories)}")
    columns = {name: np.asarray(column, float) for name, column in histories.items()}
    times = columns["time"]
    for name, column in columns.items():
        if column.ndim != 1 or len(column) != len(times):
            raise ValueError(
                f"history {name!r} has the shape {column.shape}, 'time' {times.shape}: "
                "all columns must be of one length"
            )
    found = [
        (quantity, tuple(name for name in columns if quantity_of(name) is quantity))
        for quantity in QUANTITIES
    ]
    return [
        Panel(
            quantity, names, times, quantity.factor * np.column_stack([columns[n] for n in names])
        )
        for quantity, names in found
        if names
    ]
