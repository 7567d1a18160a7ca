"""Geometry on the sheet: boxes, arcs and tables of points.

Points are complex numbers in metres of paper: x to the right, y upwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.storage import StoredFrames

Points = npt.NDArray[np.complex128]
Lengths = npt.NDArray[np.floating]
Strip = Sequence[complex] | Points
NOTHING: Points = np.zeros((0, 2), complex)  # no segments
SEEN = 2e-4  # distance of two points that are seen apart, m of paper


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle: its centre and half its width and height."""

    centre: complex
    half: complex

    @property
    def corners(self) -> tuple[complex, complex]:
        """The lower left and the upper right corner."""
        return self.centre - self.half, self.centre + self.half

    @property
    def size(self) -> float:
        """The larger of width and height."""
        return 2.0 * max(self.half.real, self.half.imag)

    def overlap(self, other: Box) -> float:
        """Return the area common to both."""
        apart = self.centre - other.centre
        reach = self.half + other.half
        across, up = reach.real - abs(apart.real), reach.imag - abs(apart.imag)
        return across * up if across > 0.0 and up > 0.0 else 0.0

    def gap(self, other: Box) -> float:
        """Return the distance to another box; 0 if they touch."""
        apart, reach = self.centre - other.centre, self.half + other.half
        across, up = abs(apart.real) - reach.real, abs(apart.imag) - reach.imag
        return abs(complex(max(0.0, across), max(0.0, up)))

    def holds(self, point: complex) -> bool:
        """Return whether a point is inside."""
        apart = point - self.centre
        return abs(apart.real) <= self.half.real and abs(apart.imag) <= self.half.imag

    def contains(self, other: Box) -> bool:
        """Return whether another box is wholly inside."""
        return Box(self.centre, self.half - other.half).holds(other.centre)

    def grown(self, margin: float) -> Box:
        """Return the box with a margin on every side."""
        return Box(self.centre, self.half + margin * (1 + 1j))

    def nearest(self, point: complex) -> complex:
        """Return the point of the box that is nearest to a point."""
        apart, half = point - self.centre, self.half
        x = max(-half.real, min(half.real, apart.real))
        y = max(-half.imag, min(half.imag, apart.imag))
        return self.centre + complex(x, y)


@dataclass(frozen=True, slots=True)
class Boxes:
    """Rectangles by their centres and half-sizes, arrays of any shapes that numpy broadcasts."""

    centres: Points
    halves: Points

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> Boxes:
        """Return boxes as one-dimensional arrays."""
        row = np.array([(box.centre, box.half) for box in boxes], complex).reshape(-1, 2)
        return cls(row[:, 0], row[:, 1])

    def overlap(self, other: Boxes) -> Lengths:
        """Return the areas common to each box and another."""
        apart, reach = self.centres - other.centres, self.halves + other.halves
        across = np.maximum(0.0, reach.real - abs(apart.real))
        return across * np.maximum(0.0, reach.imag - abs(apart.imag))

    def within(self, view: Box) -> npt.NDArray[np.bool_]:
        """Return whether each box is wholly in a view."""
        apart, room = self.centres - view.centre, view.half - self.halves
        return (abs(apart.real) <= room.real) & (abs(apart.imag) <= room.imag)

    def inside(self, starts: Points, ends: Points) -> Lengths:
        """Return the length of each segment inside each box."""
        ways, begins = ends - starts, starts - self.centres
        low: Lengths = np.zeros(())
        high: Lengths = np.ones(())
        # a segment (nearly) parallel to a side gives infinities: unbounded inside, empty outside
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            for step, position, half in (
                (ways.real, begins.real, self.halves.real),
                (ways.imag, begins.imag, self.halves.imag),
            ):
                one, other = (-half - position) / step, (half - position) / step
                low = np.maximum(low, np.fmin(one, other))
                high = np.minimum(high, np.fmax(one, other))
            return abs(ways) * np.maximum(0.0, high - low)


def corners(points: Points) -> Points:
    """Return the lower left and the upper right corner of the range of each row of points."""
    x, y = points.real, points.imag
    ends = x.min(axis=-1) + 1j * y.min(axis=-1), x.max(axis=-1) + 1j * y.max(axis=-1)
    return np.stack(ends, axis=-1)


def bounds(points: Points, margin: float = 0.05) -> tuple[Points, Points]:
    """Return centres and half-sizes of the smallest boxes around each row, shape (..., points)."""
    low, high = np.moveaxis(corners(points), -1, 0)
    size = high - low
    border = margin * np.maximum(size.real, size.imag)
    return (low + high) / 2, size / 2 + np.where(border > 0.0, border, 0.01) * (1 + 1j)


def around(points: Iterable[complex] | Points, margin: float = 0.05) -> Box:
    """Return the smallest box around all finite points, with a margin as a part of its larger side."""
    z = np.asarray(points if isinstance(points, np.ndarray) else list(points), complex)
    centre, half = bounds(z[np.isfinite(z)], margin)
    return Box(complex(centre), complex(half))


def segments_of(strips: Iterable[Strip]) -> Points:
    """Return the ends of the segments of all polylines, shape (segments, 2)."""
    each = (np.asarray(strip, complex) for strip in strips)
    ends = (np.stack((points[:-1], points[1:]), axis=1) for points in each)
    return np.concatenate([NOTHING, *ends])


def arcs(
    centre: npt.ArrayLike, start: npt.ArrayLike, end: npt.ArrayLike, *, finest: float = 0.1
) -> Points:
    """Return polylines along the shorter arcs about `centre` from `start` to the rays through `end`.

    The points have the same shape; the vertices, equally many for all arcs, are an additional last
    dimension.

    Parameters
    ----------
    finest : largest turn between two vertices, rad; by default chords differ from arcs by 0.1 %
    """
    centre, start, end = (np.asarray(z, complex) for z in (centre, start, end))
    radius = start - centre
    with np.errstate(invalid="ignore"):
        turn = np.angle((end - centre) * radius.conj())
    largest = np.max(np.abs(turn), initial=0.0, where=np.isfinite(turn))
    fraction = np.linspace(0.0, 1.0, ceil(largest / finest) + 2)
    return centre[..., None] + radius[..., None] * np.exp(1j * turn[..., None] * fraction)


def telling_vertices(points: Points, close: float, most: int) -> npt.NDArray[np.int64]:
    """Return the numbers of at most so many vertices of a polyline whose curve is nearly the same.

    Every other vertex is dropped if it lies within a distance of the chord of its neighbours, as long as
    there are any such; the distance grows until no more than `most` are left.
    """
    kept = np.arange(len(points))
    while True:
        start, middle, end = (points[kept[i : len(kept) - 2 + i : 2]] for i in range(3))
        chord, apart = end - start, middle - start
        with np.errstate(all="ignore"):
            along = np.clip(np.nan_to_num((apart / chord).real), 0.0, 1.0)
        away = abs(apart - along * chord)
        near = ~(away >= close) | np.isinf(away)
        if near.any():
            kept = np.delete(kept, 1 + 2 * np.flatnonzero(near))
        elif len(kept) <= most:
            return kept
        else:
            close *= 2.0


def table(frames: StoredFrames, names: Sequence[str]) -> Points:
    """Return the named points of the frames, shape (frames, names).

    Raises
    ------
    ValueError : if a frame lacks a point.
    """
    points = columns(frames, names)
    for row, column in np.argwhere(np.isnan(points)):
        frame = frames[int(row)]
        if names[column] not in frame.points:
            raise ValueError(
                f"step {frame.step} of the construction has no point {names[column]!r}"
            )
    return points


def columns(frames: StoredFrames, names: Sequence[str]) -> Points:
    """Return the named points of the frames, shape (frames, names); nan where there is none."""
    return _columns(frames, "points", names, complex)


def readings(frames: StoredFrames, names: Sequence[str]) -> Lengths:
    """Return the named readings of the frames, shape (frames, names); nan where there is none."""
    return _columns(frames, "readings", names, float)


def read_over(
    drawing: Drawing, names: Sequence[str], first: int = 0, last: int | None = None
) -> tuple[Lengths, Lengths]:
    """Return the times of a range of steps and their readings, shape (times, names).

    After the last step of a construction, its end follows if it is known.
    """
    several = [drawing.frames[first:last]]
    if drawing.end is not None and first + len(several[0]) == len(drawing.frames):
        several.append(StoredFrames([drawing.end]))
    times, read = zip(*((of.times, readings(of, names)) for of in several), strict=True)
    return np.concatenate(times), np.concatenate(read)


def _columns(
    frames: StoredFrames, part: Literal["points", "readings"], names: Sequence[str], kind: type
) -> npt.NDArray[Any]:
    store, chosen = frames.store, np.asarray(frames.chosen, np.int64)
    numbers, rows = (np.frombuffer(of, np.int64)[chosen] for of in (store.numbers, store.rows))
    found: npt.NDArray[Any] = np.full((len(chosen), len(names)), np.nan, kind)
    for number in np.unique(numbers):
        known = {name: i for i, name in enumerate(getattr(store.layouts[number], part))}
        present = np.array([i for i, name in enumerate(names) if name in known], np.int64)
        values: npt.NDArray[Any] = np.frombuffer(getattr(store.tables[number], part), kind)
        mine = np.flatnonzero(numbers == number)
        columns = np.array([known[names[i]] for i in present.tolist()], np.int64)
        found[np.ix_(mine, present)] = values[rows[mine, None] * len(known) + columns]
    return found


def vertices(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return complex points as pairs x, y, in an additional last dimension."""
    z = np.ascontiguousarray(points, complex)
    return z.view(float).reshape(*z.shape, 2)
