"""The parts of a construction as layers: what is drawn alike in one stage, over many frames at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from phaseplane.constructions.primitives import Arc, Scheme, Stroke
from phaseplane.constructions.rules import REPEATED
from phaseplane.constructions.storage import StoredFrames

from .frames import table
from .paper import Points, arcs

Kind = Literal["points", "lines", "arcs"]
Part = Literal["step", "repeated", "turn"]


@dataclass(frozen=True, slots=True)
class Layer:
    """Points, lines or arcs of one stage of a scheme, over the frames that follow it."""

    stage: int
    kind: Kind
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


def layers_of(scheme: Scheme, frames: StoredFrames) -> list[Layer]:
    """Return the layers of frames that follow a scheme, in the order of drawing.

    Raises
    ------
    ValueError : if a frame lacks a point of its scheme.
    """
    names = sorted(
        {mark.point for mark in scheme.marks}
        | {end for stroke in scheme.strokes for end in (stroke.start, stroke.end)}
        | {place for arc in scheme.arcs for place in (arc.centre, arc.start, arc.end)}
    )
    column = dict(zip(names, table(frames, names).T, strict=True))

    def of(several: Iterable[str]) -> Points:
        return np.stack([column[name] for name in several], 1)

    layers = []
    for stage in range(len(scheme.stages)):
        marks = [mark for mark in scheme.marks if mark.stage == stage]
        strokes = [stroke for stroke in scheme.strokes if stroke.stage == stage]
        swept = [arc for arc in scheme.arcs if arc.stage == stage]
        if marks:
            roles, labels, points = zip(*((m.role, m.label, m.point) for m in marks), strict=True)
            layers.append(Layer(stage, "points", roles, labels, points, of(points)[..., None]))
        both: list[Sequence[Stroke | Arc]] = [strokes, swept]
        for parts in filter(None, both):
            ends = of(part.start for part in parts), of(part.end for part in parts)
            roles = tuple(part.role for part in parts)
            joined = tuple(part.start + part.end for part in parts)
            kind: Kind = "lines" if parts is strokes else "arcs"
            vertices = (
                np.stack(ends, -1) if parts is strokes else arcs(of(a.centre for a in swept), *ends)
            )
            layers.append(Layer(stage, kind, roles, ("",) * len(parts), joined, vertices))
    return layers
