"""Two runs held against each other, column by column."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Columns = Mapping[str, npt.NDArray[np.float64]]


@dataclass(frozen=True, slots=True)
class Difference:
    """How far one column lies from the same one of another run.

    Parameters
    ----------
    name : of the column
    largest : magnitude of the largest difference, in the column's unit
    peak : largest magnitude of either column where both are known
    time : the instant of the largest difference, s
    """

    name: str
    largest: float
    peak: float
    time: float

    @property
    def relative(self) -> float:
        """The largest difference over the peak; 0 where both columns vanish."""
        return self.largest / self.peak if self.peak > 0.0 else 0.0


def compared(ours: Columns, other: Columns, names: Iterable[str] | None = None) -> list[Difference]:
    """The differences of the columns that both have, largest relative one first.

    The other run is read at our instants, between its own by straight lines, over the time that both
    have in common.

    Parameters
    ----------
    ours, other : `time` (s) and columns of the same length, in the same units
    names : only these columns

    Raises
    ------
    ValueError : no column or no time in common.
    """
    common = [name for name in ours if name in other and name != "time"]
    if names is not None:
        common = [name for name in names if name in common]
    if not common:
        raise ValueError("no column in common")
    time, then = ours["time"], other["time"]
    both = (time >= then[0] - 1e-12) & (time <= then[-1] + 1e-12)
    if not both.any():
        raise ValueError(
            f"no time in common: {time[0]:g} to {time[-1]:g} s and {then[0]:g} to {then[-1]:g} s"
        )
    time = time[both]
    found = []
    for name in common:
        a = ours[name][both].astype(float)
        b = np.interp(time, then, other[name].astype(float))
        gap = abs(a - b)
        gap[np.isnan(a) & np.isnan(b)] = 0.0
        row = int(np.nan_to_num(gap, nan=np.inf).argmax())
        largest = float(np.nan_to_num(gap[row], nan=np.inf))
        peak = float(max(np.nanmax(abs(a), initial=0.0), np.nanmax(abs(b), initial=0.0)))
        found.append(Difference(name, largest, peak, float(time[row])))
    return sorted(found, key=lambda difference: -difference.relative)
