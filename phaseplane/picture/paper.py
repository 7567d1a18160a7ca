"""Geometry on the sheet: boxes, polylines and arcs.

Points are complex numbers in metres of paper: x to the right, y upwards.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.complex128]
Reals = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Strip = Sequence[complex] | Points
NOTHING: Points = np.zeros((0, 2), complex)  # no segments
SEEN = 2e-4  # distance of two points that are seen apart, m of paper


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle by its centre and half its width and height; or many of them, as arrays."""

    centre: Any  # complex, or an array
    half: Any

    @classmethod
    def of(cls, boxes: Sequence[Box]) -> Box:
        """Return single boxes as one-dimensional arrays."""
        return cls(*np.array([(b.centre, b.half) for b in boxes], complex).reshape(-1, 2).T)

    @property
    def corners(self) -> tuple[Any, Any]:
        """The lower left and the upper right corner."""
        return self.centre - self.half, self.centre + self.half

    @property
    def size(self) -> float:
        """The larger of width and height."""
        return 2.0 * max(self.half.real, self.half.imag)

    def overlap(self, other: Box) -> Any:
        """Return the area common to both."""
        apart, reach = self.centre - other.centre, self.half + other.half
        across = np.maximum(0.0, reach.real - abs(apart.real))
        return across * np.maximum(0.0, reach.imag - abs(apart.imag))

    def gap(self, other: Box) -> float:
        """Return the distance to another box; 0 if they touch."""
        apart, reach = self.centre - other.centre, self.half + other.half
        across, up = abs(apart.real) - reach.real, abs(apart.imag) - reach.imag
        return abs(complex(max(0.0, across), max(0.0, up)))

    def holds(self, point: Any) -> Any:
        """Return whether a point is inside."""
        apart = point - self.centre
        return (abs(apart.real) <= self.half.real) & (abs(apart.imag) <= self.half.imag)

    def contains(self, other: Box) -> Any:
        """Return whether another box is wholly inside."""
        return Box(self.centre, self.half - other.half).holds(other.centre)

    def grown(self, margin: float) -> Box:
        """Return the box with a margin on every side."""
        return Box(self.centre, self.half + margin * (1 + 1j))

    def widened(self, least: float) -> Box:
        """Return the box with at least a width that is this part of its height."""
        across = max(self.half.real, least * self.half.imag)
        return Box(self.centre, complex(across, self.half.imag))

    def nearest(self, point: complex) -> complex:
        """Return the point of the box that is nearest to a point."""
        apart, half = point - self.centre, self.half
        x = max(-half.real, min(half.real, apart.real))
        y = max(-half.imag, min(half.imag, apart.imag))
        return complex(self.centre + complex(x, y))

    def inside(self, starts: Points, ends: Points) -> Reals:
        """Return the length of each segment inside each box."""
        ways, begins, half = ends - starts, starts - self.centre, np.asarray(self.half)
        low: Reals = np.zeros(())
        high: Reals = np.ones(())
        # a segment (nearly) parallel to a side gives infinities: unbounded inside, empty outside
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            for step, position, reach in (
                (ways.real, begins.real, half.real),
                (ways.imag, begins.imag, half.imag),
            ):
                one, other = (-reach - position) / step, (reach - position) / step
                low = np.maximum(low, np.fmin(one, other))
                high = np.minimum(high, np.fmax(one, other))
            return np.asarray(abs(ways) * np.maximum(0.0, high - low), float)


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


def vertices(points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return complex points as pairs x, y, in an additional last dimension."""
    z = np.ascontiguousarray(points, complex)
    return z.view(float).reshape(*z.shape, 2)
