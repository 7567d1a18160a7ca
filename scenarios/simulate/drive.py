"""The result of driving an FMU, and the callbacks during a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..columns import Columns


class RowsSoFar(Protocol):
    """The rows of a run that is under way."""

    @property
    def names(self) -> Sequence[str]: ...

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice, /) -> Any: ...


Watch = Callable[[RowsSoFar], None]
INTERRUPTED = "interrupted"
"""The reason of a run that was stopped by a signal."""


@dataclass(frozen=True)
class Drive:
    """The result of driving an FMU: the columns read, and why the run stopped early ("" if not).

    `warnings` are what it has logged besides.
    """

    columns: Columns
    run_time: float
    complaint: str
    uncompiled: bool
    warnings: tuple[str, ...] = ()


class Passed:
    """The rows of a run that is done, up to the time that has passed since it was begun."""

    def __init__(self, columns: Columns) -> None:
        self.names = list(columns)
        self._table = np.column_stack([np.asarray(column, float) for column in columns.values()])
        self.count = 0

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, rows: slice) -> Any:
        """Return rows as an array of shape (rows, columns)."""
        return self._table[: self.count][rows]
