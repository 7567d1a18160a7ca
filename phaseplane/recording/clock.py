"""The timelines of a recording.

Steps are stored once, on the timelines `t` (time of the motion) and `step`. The timeline `stage` has the
ticks of the story, which is stored apart. The viewer plays both at one rate, so the ticks of the story of
a long motion are several counts apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count, takewhile

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.paper import Integers, Reals

_LEAST_SHOWN = 40  # ticks in which the viewer plays all steps, if there are as many


@dataclass(frozen=True, slots=True)
class Clock:
    """The timelines of a construction: the start of each step and the end of the last.

    Without a construction they are empty, and `t` is the only timeline.
    """

    times: Reals  # s
    steps: Integers
    ticks: Reals  # times of the ticks of the story, s

    @property
    def stride(self) -> int:
        """How many steps pass while one tick of the story is shown: 1, 2, 5, 10, 20 and so on.

        All steps then take as long as 40 to 100 ticks, or as there are if these are fewer.
        """
        sizes = (size * 10**power for power in count() for size in (1, 2, 5))
        few = takewhile(lambda size: len(self.steps) >= _LEAST_SHOWN * size, sizes)
        return max(few, default=1)

    @classmethod
    def of(cls, drawing: Drawing | None, ticks: Sequence[float] = ()) -> Clock:
        """Return the clock of a construction, or one of time only if there is none."""
        if drawing is None:
            return cls(np.zeros(0), np.zeros(0, np.int64), np.zeros(0))
        last = drawing.frames[-1]
        return cls(
            np.array([*drawing.frames.times, last.time + last.duration]),
            np.array([*drawing.frames.steps, last.step + 1]),
            np.array(ticks, float),
        )

    def columns(self, rows: Integers) -> list[rr.TimeColumn]:
        """Return the time columns of rows that belong to the steps with these indices."""
        return [seconds(self.times[rows]), self.counts(rows)]

    def counts(self, rows: Integers) -> rr.TimeColumn:
        """Return the steps with these indices on their timeline."""
        return rr.TimeColumn("step", sequence=self.steps[rows])

    def stages(self, ticks: Integers) -> list[rr.TimeColumn]:
        """Return the time columns of the ticks of the story with these numbers."""
        return [rr.TimeColumn("stage", sequence=self.stride * ticks)]

    @property
    def story(self) -> list[rr.TimeColumn]:
        """The time columns of all ticks of the story."""
        return self.stages(np.arange(len(self.ticks)))

    def over(self, times: Reals) -> Iterator[tuple[Reals, list[rr.TimeColumn]]]:
        """Yield some times of a run with their time columns.

        First those of the steps, on `t` and `step`; then the other `times`, on `t` only; then those of
        the story, on `stage`. Steps and ticks outside of `times` are left out: they may be still to come.
        """
        steps, ticks = (
            np.flatnonzero((of >= times[0] - 1e-9) & (of <= times[-1] + 1e-9))
            for of in (self.times, self.ticks)
        )
        if len(steps):
            yield self.times[steps], self.columns(steps)
            times = times[~np.isin(np.rint(1e9 * times), np.rint(1e9 * self.times))]
        if len(times):
            yield times, [seconds(times)]
        if len(ticks):
            yield self.ticks[ticks], self.stages(ticks)


def seconds(times: npt.ArrayLike) -> rr.TimeColumn:
    """Return times on the timeline `t`."""
    nanoseconds = np.rint(np.asarray(times, float) * 1e9)
    return rr.TimeColumn("t", duration=nanoseconds.astype("timedelta64[ns]"))
