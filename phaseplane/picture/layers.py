"""The parts of a construction as layers: what is drawn alike in one stage, over many frames at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from phaseplane.constructions.primitives import Arc, Drawing, Scheme, Stroke
from phaseplane.constructions.rules import REPEATED
from phaseplane.constructions.storage import Frame, StoredFrames

from .frames import table
from .paper import Points, arcs

Part = Literal["step", "repeated", "turn"]


@dataclass(frozen=True, slots=True)
class Layer:
    """Points, lines or arcs of one stage of a scheme, over the frames that follow it."""

    stage: int
    kind: Literal["points", "lines", "arcs"]
    roles: tuple[str, ...]  # of each item, as labels and names
    labels: tuple[str, ...]  # lines and arcs have none
    names: tuple[str, ...]  # of points, or of both ends
    vertices: Points  # shape (frames, items, vertices)

    def __len__(self) -> int:
        return len(self.roles)


def part_of(name: str) -> Part:
    """Return the part of a construction that a point or a line belongs to, by its name.

    It is the step itself, what the rule repeats of it, or the arm of the turn angles.
    """
    return "turn" if name.startswith(("W", "N")) else "repeated" if REPEATED in name else "step"


def is_main(name: str) -> bool:
    """Return whether a point belongs to the step itself."""
    return part_of(name) == "step"


def layers_of(drawing: Drawing, key: str, first: int = 0, last: int | None = None) -> list[Layer]:
    """Return the layers of a scheme over a range of frames, in the order of drawing.

    Raises
    ------
    ValueError : if a frame lacks a point of its scheme.
    """
    schemes = drawing.frames[first:last].schemes
    chosen = [i for i, scheme in enumerate(schemes, first) if scheme == key]
    return list(_layers(drawing.schemes[key], drawing.frames.at(chosen)))


def layers_at(drawing: Drawing, frame: Frame) -> list[Layer]:
    """Return the layers of one frame."""
    return list(_layers(drawing.schemes[frame.scheme], StoredFrames([frame])))


def _layers(scheme: Scheme, frames: StoredFrames) -> Iterator[Layer]:
    if not frames:
        return
    names = sorted(
        {mark.point for mark in scheme.marks}
        | {end for stroke in scheme.strokes for end in (stroke.start, stroke.end)}
        | {place for arc in scheme.arcs for place in (arc.centre, arc.start, arc.end)}
    )
    column = dict(zip(names, table(frames, names).T, strict=True))

    def of(several: Iterable[str]) -> Points:
        return np.stack([column[name] for name in several], 1)

    def ends(parts: Sequence[Stroke | Arc]) -> tuple[Points, Points]:
        return of(part.start for part in parts), of(part.end for part in parts)

    for stage in range(len(scheme.stages)):
        marks = [mark for mark in scheme.marks if mark.stage == stage]
        strokes = [stroke for stroke in scheme.strokes if stroke.stage == stage]
        swept = [arc for arc in scheme.arcs if arc.stage == stage]
        if marks:
            roles, labels, points = zip(*((m.role, m.label, m.point) for m in marks), strict=True)
            yield Layer(stage, "points", roles, labels, points, of(points)[..., None])
        if strokes:
            yield _between(stage, "lines", strokes, np.stack(ends(strokes), -1))
        if swept:
            vertices = arcs(of(arc.centre for arc in swept), *ends(swept))
            yield _between(stage, "arcs", swept, vertices)


def _between(
    stage: int, kind: Literal["lines", "arcs"], parts: Sequence[Stroke | Arc], vertices: Points
) -> Layer:
    roles, names = tuple(p.role for p in parts), tuple(p.start + p.end for p in parts)
    return Layer(stage, kind, roles, ("",) * len(parts), names, vertices)
