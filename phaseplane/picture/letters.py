"""Placement of letters beside their points, without overlap."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import product
from math import pi

import numpy as np
import numpy.typing as npt

from .paper import Box, Points, Reals, corners, segments_of

NEAR = 2.0  # farthest distance of a letter from its point without a leader, in em
PLATE = 0.25  # width of the viewer's plate around a text, em

_WIDTH, _HEIGHT = 0.58, 1.15  # of one character, in em
_RINGS = np.array([0.8, 1.1, 1.5, NEAR - 0.1, 2.8, 3.8, 5.0, 7.0, 10.0])  # gaps to the point, in em
_ANGLES = 16
_SQUARE, _WALL = 0.25, 1000  # em; what a text takes up counts as so many squares of a curve
_MOST_CLOSE = 300  # lines about a letter that are looked at
_GAPS = np.repeat(_RINGS, _ANGLES)
_DIRECTIONS = np.tile(np.exp(1j * (np.arange(_ANGLES) + 0.5) * 2 * pi / _ANGLES), len(_RINGS))

# directions from a point, the best ones first: between values of the axes of small planes there is often
# but one place
_WAYS = np.exp(0.125j * pi * np.array([2, 6, -2, -6, 4, -4, 0, 8, 1, 3, 5, 7, -1, -3, -5, -7]))
_LEAST_COVERED = 2  # squares of a motion behind a plate that are not missed


def text_box(centre: complex, text: str, em: float) -> Box:
    """Return the box of a text, of one or more lines, with its centre and size of type."""
    rows = re.sub(r"[${}^_\\]|\\[a-z]+", "", text).split("\n")
    widest = max(1, *map(len, rows))
    return Box(centre, complex(0.5 * _WIDTH * widest + 0.15, 0.5 * _HEIGHT * len(rows)) * em)


def away(half: complex, ways: Points) -> Reals:
    """Return how far the centres of boxes are from a point that they touch, in some directions."""
    across, up = np.maximum(abs(ways.real), 1e-9), np.maximum(abs(ways.imag), 1e-9)
    return np.minimum(half.real / across, half.imag / up)


class Room:
    """The room for letters in a view, in squares that boxes of texts or curves take up or leave free."""

    def __init__(
        self, view: Box, em: float, texts: Iterable[Box], curves: Iterable[Points]
    ) -> None:
        self.em, self._side = em, _SQUARE * em
        self._low = view.corners[0] - self._side * (1 + 1j)
        size = view.corners[1] - self._low
        self._shape = int(size.real / self._side) + 2, int(size.imag / self._side) + 2
        taken = np.full(self._shape, _WALL, np.int32)  # nothing is out of view
        taken[1:-1, 1:-1] = 0
        for curve in curves:
            start, end = segments_of([curve[np.isfinite(curve)]]).T
            count = (abs(end - start) / self._side).clip(0, sum(self._shape)).astype(np.int64) + 2
            part = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
            z = np.repeat(start, count) + part * np.repeat((end - start) / (count - 1), count)
            x, y = self._square(z)
            taken[x, y] = np.maximum(taken[x, y], 1)
        for box in texts:
            (x, u), (y, v) = self._square(np.array(box.corners))
            taken[x : u + 1, y : v + 1] = _WALL
        self._sums = np.pad(taken.cumsum(0).cumsum(1), ((1, 0), (1, 0)))

    def _square(self, z: Points) -> list[npt.NDArray[np.int64]]:
        parts = (z - self._low).real, (z - self._low).imag
        return [
            (part / self._side).clip(0, most - 1).astype(np.int64)
            for part, most in zip(parts, self._shape, strict=True)
        ]

    def covered(self, boxes: Box) -> npt.NDArray[np.int64]:
        """Return how many squares with parts of curves boxes touch; many where there is a text."""
        sums, ((x, y), (u, v)) = self._sums, map(self._square, boxes.corners)
        return sums[u + 1, v + 1] - sums[x, v + 1] - sums[u + 1, y] + sums[x, y]


def place(
    points: Points,
    texts: Sequence[str],
    em: float,
    view: Box,
    segments: Points,
    taken: Sequence[Box] = (),
    others: Sequence[complex] = (),
) -> tuple[Points, Reals, npt.NDArray[np.bool_]]:
    """Place letters of a size of type `em` beside their points, in view.

    Letters with the closest neighbours are placed first. Each takes the best of 144 positions about its
    point: close to it, not over texts that are there (in the boxes `taken`), points (also those of
    `others`) or segments, and nearer to it than to others. Where no place is free within `NEAR`, one
    farther away is taken.

    Returns
    -------
    Their centres, their distances from the points, em, and whether they are in view and free of other
    texts.
    """
    halves = np.array([text_box(0j, text, em).half for text in texts], complex)
    fixed, every = Box.of(taken), np.append(points, np.asarray(others, complex))
    count = len(texts)
    centres, gaps, free = np.zeros(count, complex), np.zeros(count), np.ones(count, bool)
    near = (abs(points[:, None] - points) < 2.5 * em).sum(axis=1)
    order = np.argsort(-near, kind="stable")
    for done, i in enumerate(order):
        at, size = complex(points[i]), halves[i]
        # the gap is that between the point and the nearest edge of the letter
        ways = (away(complex(size), _DIRECTIONS) + (_GAPS - 0.5) * em) * _DIRECTIONS
        mine, before = Box((at + ways)[:, None], size), order[:done]
        over = mine.overlap(Box(centres[before], halves[before])).sum(axis=1)
        over = over + mine.overlap(fixed).sum(axis=1)
        inside = view.contains(Box(mine.centre[:, 0], size))
        cost = (
            0.7 * _GAPS
            + 100.0 * (over > 0.0)
            + 40.0 * (over / em) / em
            + 4.0 * (mine.overlap(Box(every, 0.15 * em * (1 + 1j))) > 0.0).sum(axis=1)
            + 5.0 * (abs(every - mine.centre) < abs(ways)[:, None]).sum(axis=1)
            + 200.0 * ~inside
            + 6.0 * (_GAPS > NEAR)
        )
        best = int(cost.argmin())
        if len(segments):
            about = Box(at, _RINGS[-1] * em * (1 + 1j) + 2.0 * size)
            close = segments[_may_meet(about, segments)]
            close = close[:: max(1, len(close) // _MOST_CLOSE)]
            crossed = mine.inside(close[:, 0], close[:, 1]).sum(axis=1)  # length of lines in each
            best = int((cost + 1.5 * crossed / em).argmin())
        centres[i], gaps[i] = mine.centre[best, 0], _GAPS[best]
        free[i] = inside[best] and over[best] == 0.0
    return centres, gaps, free


def _may_meet(box: Box, segments: Points) -> npt.NDArray[np.bool_]:
    """Return which segments may have a part in a box."""
    (low, high), reach = corners(segments - box.centre).T, box.half
    begins = (low.real <= reach.real) & (low.imag <= reach.imag)
    return np.asarray(begins & (high.real >= -reach.real) & (high.imag >= -reach.imag), bool)


def free_letters(
    points: Points, texts: Sequence[str], room: Room
) -> tuple[Points, npt.NDArray[np.bool_]]:
    """Return the places of letters, each as near to its point as it is legible, and which are legible.

    That is in view, not covered by another letter or a text on the page, and where the viewer's plate
    behind it covers nothing of the motion to speak of. All have the shape (steps, letters).
    """
    halves = np.array([text_box(0j, text, room.em).half for text in texts])
    plates = halves + PLATE * room.em * (1 + 1j)
    known = np.isfinite(points)
    centres, free = np.where(known, points, 0.0), np.zeros(points.shape, bool)
    for (i, half), gap in product(enumerate(halves), _RINGS[_RINGS < NEAR]):
        left = np.flatnonzero(known[:, i] & ~free[:, i])
        places = points[left, i, None] + (away(half, _WAYS) + gap * room.em) * _WAYS
        mine, others = Box(places[..., None], half), free[left, None, :]
        over = (mine.overlap(Box(centres[left, None, :], halves)) > 0.0) & others
        clear = ~over.any(axis=-1) & (room.covered(Box(places, plates[i])) <= _LEAST_COVERED)
        best = clear.argmax(axis=1)
        found = np.flatnonzero(clear.any(axis=1))
        centres[left[found], i] = places[found, best[found]]
        free[left[found], i] = True
    return centres, free
