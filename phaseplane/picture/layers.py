"""The parts of a construction as layers: what is drawn alike in one stage, over many frames at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from phaseplane.constructions.primitives import Arc, Drawing, Mark, Scheme, Stroke
from phaseplane.constructions.rules import REPEATED
from phaseplane.constructions.storage import Frame, StoredFrames

from .paper import Points, arcs, table

TURN_POINTS = ("W", "N")


@dataclass(frozen=True, slots=True)
class Layer:
    """Points, lines or arcs of one stage of a scheme, over the frames that follow it.

    Parameters
    ----------
    scheme, stage : in which it is drawn
    kind : points have one vertex, lines two, arcs as many as the longest of them needs
    roles, labels, names : of each item; lines and arcs have no labels, and the names of both ends
    frames : indices of the frames
    vertices : shape (frames, items, vertices)
    """

    scheme: str
    stage: int
    kind: Literal["points", "lines", "arcs"]
    roles: tuple[str, ...]
    labels: tuple[str, ...]
    names: tuple[str, ...]
    frames: tuple[int, ...]
    vertices: Points

    def __len__(self) -> int:
        return len(self.roles)

    def is_main(self, item: int) -> bool:
        """Return whether an item belongs to the step itself, not to a repetition or a turn angle."""
        return is_main(self.names[item])


def is_main(name: str) -> bool:
    """Return whether a point belongs to the step itself, not to a repetition or the turn angles."""
    return REPEATED not in name and not name.startswith(TURN_POINTS)


def layers_of(drawing: Drawing, key: str, first: int = 0, last: int | None = None) -> list[Layer]:
    """Return the layers of a scheme over a range of frames, in the order of drawing.

    Raises
    ------
    ValueError : if a frame lacks a point of its scheme.
    """
    schemes = drawing.frames[first:last].schemes
    chosen = [i for i, scheme in enumerate(schemes, first) if scheme == key]
    return list(_layers(drawing.schemes[key], key, drawing.frames.at(chosen), chosen))


def layers_at(drawing: Drawing, frame: Frame) -> list[Layer]:
    """Return the layers of one frame."""
    one = StoredFrames([frame])
    return list(_layers(drawing.schemes[frame.scheme], frame.scheme, one, [frame.step]))


def _layers(
    scheme: Scheme, key: str, frames: StoredFrames, chosen: Sequence[int]
) -> Iterator[Layer]:
    if not frames:
        return
    names = sorted(_named(scheme))
    column = dict(zip(names, table(frames, names).T, strict=True))

    def of(several: Sequence[str]) -> Points:
        return np.stack([column[name] for name in several], 1)

    for stage in range(len(scheme.stages)):
        marks: list[Mark] = [mark for mark in scheme.marks if mark.stage == stage]
        strokes: list[Stroke] = [stroke for stroke in scheme.strokes if stroke.stage == stage]
        swept: list[Arc] = [arc for arc in scheme.arcs if arc.stage == stage]
        if marks:
            yield Layer(
                key, stage, "points", tuple(m.role for m in marks), tuple(m.label for m in marks),
                tuple(m.point for m in marks), tuple(chosen),
                of([mark.point for mark in marks])[..., None],
            )  # fmt: skip
        if strokes:
            ends = of([name for stroke in strokes for name in (stroke.start, stroke.end)])
            yield Layer(
                key, stage, "lines", tuple(s.role for s in strokes), ("",) * len(strokes),
                tuple(s.start + s.end for s in strokes), tuple(chosen),
                ends.reshape(len(frames), -1, 2),
            )  # fmt: skip
        if swept:
            yield Layer(
                key, stage, "arcs", tuple(a.role for a in swept), ("",) * len(swept),
                tuple(a.start + a.end for a in swept), tuple(chosen),
                arcs(*(of([getattr(a, part) for a in swept]) for part in ("centre", "start", "end"))),
            )  # fmt: skip


def _named(scheme: Scheme) -> set[str]:
    """Return the points in a scheme."""
    return {
        *(mark.point for mark in scheme.marks),
        *(end for stroke in scheme.strokes for end in (stroke.start, stroke.end)),
        *(place for arc in scheme.arcs for place in (arc.centre, arc.start, arc.end)),
    }
