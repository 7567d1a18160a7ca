"""The result of driving an FMU, and the callbacks during a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from .stepping import Rows

Columns = dict[str, npt.NDArray[np.float64]]
Watch = Callable[["Rows"], None]
INTERRUPTED = "interrupted"
"""The reason of a run that was stopped by a signal."""


@dataclass(frozen=True)
class Drive:
    """The result of driving an FMU: the columns read, and why the run stopped early ("" if not)."""

    columns: Columns
    run_time: float
    complaint: str
    uncompiled: bool
