"""Timelines, styles and texts as rerun's components.

Every row is stored once, with all timelines on which it is seen: `t` (time of the motion), `step`, and
`stage`, which counts the stages of all steps in order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from phaseplane.constructions.primitives import Drawing

from . import sheet
from .styles import Style, style, typeset

Integers = npt.NDArray[np.int64]
Reals = npt.NDArray[np.float64]

_STRIPS = rr.components.LineStrip2DBatch([]).as_arrow_array().type

TIMELINES = {"t": "seconds", "step": "seq", "stage": "seq"}


@dataclass(frozen=True, slots=True)
class Clock:
    """The timelines of a construction, at the start of each step and at the end of the last.

    Parameters
    ----------
    times : s; empty without a construction, and then `t` is the only timeline
    steps : numbers of the steps
    stages_per_step : 0 for no timeline `stage`
    """

    times: Reals
    steps: Integers
    stages_per_step: int = 0

    @classmethod
    def of(cls, drawing: Drawing | None, stages: bool) -> Clock:
        """Return the clock of a construction, or one of time only if there is none."""
        if drawing is None:
            return cls(np.zeros(0), np.zeros(0, np.int64))
        last = drawing.frames[-1]
        return cls(
            np.array([*(frame.time for frame in drawing.frames), last.time + last.duration]),
            np.array([*(frame.step for frame in drawing.frames), last.step + 1]),
            max(len(scheme.stages) for scheme in drawing.schemes.values()) if stages else 0,
        )

    def columns(self, rows: Integers, stage: int | Integers = 0) -> list[rr.TimeColumn]:
        """Return the time columns of rows that belong to the steps with these indices."""
        return [seconds(self.times[rows]), *self._counted(rows, stage)]

    def _counted(self, rows: Integers, stage: int | Integers = 0) -> list[rr.TimeColumn]:
        columns = [rr.TimeColumn("step", sequence=self.steps[rows])]
        if self.stages_per_step:
            stages = self.stages_per_step * self.steps[rows] + stage
            columns.append(rr.TimeColumn("stage", sequence=stages))
        return columns

    def counted(self) -> list[rr.TimeColumn]:
        """Return the time columns of all steps, without `t`."""
        return self._counted(np.arange(len(self.times)))

    def over(self, times: Reals) -> Iterator[tuple[Reals, list[rr.TimeColumn]]]:
        """Yield times with their time columns.

        First the times of the steps, on all timelines; then the other `times`, on `t` only.
        """
        if len(self.times):
            yield self.times, self.columns(np.arange(len(self.times)))
            nearest = np.searchsorted(self.times, times)
            beside = np.minimum(
                abs(times - self.times[np.minimum(nearest, len(self.times) - 1)]),
                abs(times - self.times[np.maximum(nearest - 1, 0)]),
            )
            times = times[beside > 1e-9]
        if len(times):
            yield times, [seconds(times)]

    def within(self, times: Reals) -> Iterator[tuple[npt.NDArray[np.bool_], list[rr.TimeColumn]]]:
        """Yield masks of the times inside and outside the construction, with their time columns.

        Those inside are on all timelines, at the step that contains them.
        """
        end = self.times[-1] * (1.0 + 1e-9) if len(self.times) else -np.inf
        inside = np.asarray(times <= end)
        if inside.any():
            step = np.searchsorted(self.times, times[inside] - 1e-9)
            yield (
                inside,
                [seconds(times[inside]), *self._counted(np.minimum(step, len(self.times) - 1))],
            )
        if not inside.all():
            yield ~inside, [seconds(times[~inside])]


def seconds(times: Reals) -> rr.TimeColumn:
    """Return times on the timeline `t`."""
    return rr.TimeColumn("t", duration=np.rint(times * 1e9).astype("timedelta64[ns]"))


def colours(values: Sequence[int]) -> npt.NDArray[np.uint32]:
    """Return colours 0xRRGGBBAA, one per instance."""
    return np.array(values, np.uint32)  # rerun takes a list of four as one RGBA colour


def _radii(sizes: Sequence[float]) -> npt.NDArray[np.float32]:
    return -0.5 * np.array(sizes, np.float32)  # negative: in screen points, not in metres of paper


def line_style(styles: Sequence[Style]) -> rr.LineStrips2D:
    """Return the style of each line."""
    return rr.LineStrips2D.from_fields(
        colors=colours([s.colour for s in styles]), radii=_radii([s.width for s in styles])
    )


def point_style(styles: Sequence[Style], labels: Sequence[str] | None = None) -> rr.Points2D:
    """Return the style of each point, and its label."""
    return rr.Points2D.from_fields(
        colors=colours([s.colour for s in styles]),
        radii=_radii([s.size for s in styles]),
        labels=labels,
        show_labels=None if labels is None else True,
    )


def lettering(texts: Sequence[sheet.Text], role: str) -> rr.Points2D:
    """Return texts without points."""
    return rr.Points2D(
        sheet.vertices(np.array([text.place for text in texts], complex)),
        colors=colours([style(role).colour]),
        radii=0.0,
        labels=[typeset(text.label) for text in texts],
        show_labels=True,
    )


def strips(z: npt.NDArray[np.complex128]) -> pa.Array:
    """Return polylines with equal numbers of vertices, shape (n, vertices), as one arrow array."""
    vertices = rr.encodings.Vec2DBatch(sheet.vertices(z).reshape(-1, 2)).as_arrow_array()
    offsets = np.arange(0, z.size + 1, z.shape[-1], dtype=np.int32)
    return pa.ListArray.from_arrays(offsets, vertices, type=_STRIPS)


def flat(x: npt.ArrayLike, y: npt.ArrayLike, z: float = 0.0) -> npt.NDArray[np.float32]:
    """Return vectors in the plane of the sheet, shape (n, 3)."""
    x, y = np.broadcast_arrays(np.asarray(x, np.float32), np.asarray(y, np.float32))
    return np.stack([x, y, np.full_like(x, z)], -1)
