"""What comes out of a run, and how it is followed while it goes on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from fmpy.simulation import Recorder

Columns = dict[str, npt.NDArray[np.float64]]
Progress = Callable[[float], None]
Watch = Callable[["Recorder"], None]
INTERRUPTED = "interrupted"
"""Why a run ended early, if it was told to."""


@dataclass(frozen=True)
class Drive:
    """What came out of the FMU: all columns read, and why it ended early, if it did."""

    columns: Columns
    run_time: float
    complaint: str
    uncompiled: bool
