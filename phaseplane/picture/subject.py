"""What a picture shows: a construction with its motions, and what is computed of it once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Drawing, Plane, Scheme
from phaseplane.constructions.storage import Frame, StoredFrames

from .frames import columns, motions_of
from .layers import Layer, layers_of
from .paper import Points, arcs, telling_vertices

_WOUND = 20.0  # times width and height together: about ten turns, or more smaller ones


@dataclass
class Subject:
    """A construction and its motions (by default its state points), which all pages of it share."""

    drawing: Drawing
    motions: list[Points] = field(default_factory=list)
    known: bool = True  # whether the motions are curves, and not only the range of those to come
    _few: list[tuple[Points, npt.NDArray[np.int64]]] = field(default_factory=list, init=False)
    _last: tuple[Frame, list[Layer]] | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        self.motions = self.motions or motions_of(self.drawing)

    @cached_property
    def ways(self) -> list[Points]:
        """The way from each state point to the next in each plane, shape (steps, vertices)."""
        known = [np.asarray(way, complex) for way in self.drawing.ways]
        return known or paths_of(self.drawing, self.motions)

    @cached_property
    def size(self) -> float:
        """The largest distance of a state point from the zero of the sheet, m of paper."""
        known = (abs(motion[np.isfinite(motion)]) for motion in self.motions)
        return max(float(away.max(initial=0.0)) for away in known)

    @cached_property
    def winds(self) -> bool:
        """Whether a motion is many times as long as it is large, so that its curve would be a blot."""
        curves = [z[np.isfinite(z)] for z in map(joined, self.ways)]
        return any(abs(np.diff(z)).sum() > _WOUND * abs(np.ptp(z.real) + np.ptp(z.imag))
                   for z in curves if z.size)  # fmt: skip

    def last_turns(self, steps: int) -> int:
        """Return the step from which on a motion up to a number of steps would not be a blot."""
        first = 0
        for way in self.ways:
            lengths = np.nan_to_num(abs(np.diff(way[:steps])).sum(axis=1))
            known = way[np.isfinite(way)]
            size = abs(np.ptp(known.real) + np.ptp(known.imag)) if known.size else 0.0
            left = np.cumsum(lengths[::-1]) <= _WOUND * size
            first = max(first, len(lengths) - int(left.sum()))
        return first

    def past(self, steps: int, close: float, most: int | None, first: int = 0) -> list[Points]:
        """Return the motion in all planes from one step to another: parts of curves thinned once.

        Thinned curves have at most so many vertices and differ by less than `close`, m of paper.
        """
        if most is None:
            return [joined(way[first:steps]) for way in self.ways]
        if not self._few:
            self._few += [(z, telling_vertices(z, close, most)) for z in map(joined, self.ways)]
        parts = [way.shape[1] - 1 for way in self.ways]
        return [
            z[np.append(kept[(kept >= first * part) & (kept < steps * part)], steps * part)]
            for part, (z, kept) in zip(parts, self._few, strict=True)
        ]

    def layers(self, frame: Frame) -> list[Layer]:
        """Return the layers of a step; pages that follow each other draw the same one several times."""
        if self._last is None or self._last[0] != frame:
            scheme = self.drawing.schemes[frame.scheme]
            self._last = frame, layers_of(scheme, StoredFrames([frame]))
        return self._last[1]


def paths_of(drawing: Drawing, motions: Sequence[Points]) -> list[Points]:
    """Return the way from each state point to the next, shape (steps, vertices): chords, or the arcs
    on which the rule has stepped.
    """
    ways = []
    for plane, motion in zip(drawing.planes, motions, strict=True):
        ends = np.stack([motion[:-1], motion[1:]], 1)
        schemes = drawing.frames.schemes[: len(ends)]
        centres = {key: centre_of(scheme, plane) for key, scheme in drawing.schemes.items()}
        if any(centres.values()) and len(ends):
            names = sorted({*centres.values()} - {""})
            of = columns(drawing.frames[: len(ends)], names)
            places = [names.index(centres[key]) if centres[key] else 0 for key in schemes]
            middle = of[np.arange(len(ends)), places]
            middle[[not centres[key] for key in schemes]] = np.inf
            swept = np.isfinite(middle) & (abs(middle - ends[:, 0]) < 1e3 * abs(np.ptp(ends)))
            curved = arcs(*(np.where(swept, z, 0) for z in (middle, ends[:, 0], ends[:, 1])))
            part = np.linspace(0.0, 1.0, curved.shape[1])
            straight = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * part
            # an arc that misses the next point is of a step that was cut short
            missed = ends[:, 1] - curved[:, -1]
            meets = abs(missed) < 0.02 * abs(ends[:, 1] - ends[:, 0])
            curved = curved + missed[:, None] * part
            ends = np.where((swept & meets)[:, None], curved, straight)
        ways.append(ends)
    return ways


def centre_of(scheme: Scheme, plane: Plane) -> str:
    """Return the centre of the arc on which a state point moves; empty if it moves on a line."""
    ends = (plane.state, f"{plane.state}'")
    return next((a.centre for a in scheme.arcs if (a.start, a.end) == ends), "")


def joined(way: Points) -> Points:
    """Return the ways of several steps as one polyline."""
    return np.append(way[:, :-1].ravel(), way[-1, -1])
