"""The construction of every step on the timelines `t` and `step`, in whole columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain, product
from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.layers import Layer, is_main, layers_of
from phaseplane.picture.letters import NEAR, Room, away, text_box
from phaseplane.picture.page import PLATE
from phaseplane.picture.paper import Boxes, Points

from .columns import (
    LETTERS_FIRST,
    LINE_UP,
    Clock,
    Integers,
    legible,
    line_style,
    point_style,
    send,
    shades,
    strips,
    xy,
)

SHEET, ARMS, CHART = "/sheet", "/arms", "/chart"
WORDS = "/words"
SLICE = 4096  # steps that are encoded at once
_REPEATED = 0.4  # opacity of what a rule repeats
# gaps between a letter and its point, em, and directions from it, the best ones first
_GAPS = (0.8, 1.3, NEAR - 0.1)
_WAYS = np.exp(0.25j * np.pi * np.array([1, 3, -1, -3, 2, -2, 0, 4]))
_LEAST_COVERED = 2  # squares of a motion behind a plate that are not missed

# root and name of an entity, its style, its columns, and how many items each step has
Part = tuple[str, str, rr.AsComponents, Any, int | Integers]


def send_steps(
    recording: rr.RecordingStream, drawing: Drawing, room: Room, clock: Clock, first: int, last: int
) -> None:
    """Log the construction of a range of steps, whose letters have this room.

    An empty row clears a scheme where a step of another one begins, and at the end of the motion.

    Raises
    ------
    ValueError : if a frame lacks a point of its scheme.
    """
    schemes = drawing.frames[first : last + 1].schemes
    for key in drawing.schemes:
        drawn = np.array([i for i in range(last - first) if schemes[i] == key], np.int64)
        left = [i + 1 for i in drawn if i + 1 < len(schemes) and schemes[i + 1] != key]
        if last == len(drawing.frames) and schemes[-1] == key:
            left.append(last - first)
        if not drawn.size:
            continue
        rows = first + np.concatenate([left, drawn]).astype(np.int64)
        shown = np.repeat([0, 1], [len(left), len(drawn)])
        order = np.argsort(rows, kind="stable")
        columns, shown = clock.columns(rows[order]), shown[order]
        layers = layers_of(drawing, key, first, last)
        for root, name, style, column, items in chain(_parts(layers), _letters(layers, room)):
            counts = np.zeros(len(shown), np.int64)
            counts[shown > 0] = items
            path = f"{root}/steps/{key}/{name}"
            send(recording, path, style, columns, column.partition(counts))


def _parts(layers: Sequence[Layer]) -> Iterator[Part]:
    """Yield the lines, arcs and points of steps."""
    lines = [layer for layer in layers if layer.kind == "lines"]
    if lines:
        roles = [role for layer in lines for role in layer.roles]
        names = [name for layer in lines for name in layer.names]
        strengths = [1.0 if is_main(name) else _REPEATED for name in names]
        z = np.concatenate([layer.vertices for layer in lines], 1)
        column = rr.LineStrips2D.columns(strips=strips(z.reshape(-1, 2)))
        yield SHEET, "lines", line_style(roles, strengths), column, len(roles)
    for layer in (layer for layer in layers if layer.kind == "arcs"):
        of_turn = layer.names[0].startswith("N")
        z = layer.vertices.reshape(-1, layer.vertices.shape[-1])
        column = rr.LineStrips2D.columns(strips=strips(z))
        root, name = ARMS if of_turn else SHEET, f"arcs{layer.stage + 1}"
        yield root, name, line_style(list(layer.roles)), column, len(layer)
    points = [layer for layer in layers if layer.kind == "points"]
    if points:
        roles = [role for layer in points for role in layer.roles]
        z = np.concatenate([layer.vertices[..., 0] for layer in points], 1)
        column = rr.Points2D.columns(positions=xy(z.ravel()))
        yield SHEET, "points", point_style(roles, 1.2), column, len(roles)


def _letters(layers: Sequence[Layer], room: Room) -> Iterator[Part]:
    """Yield the letters of P and D, wherever they do not lie on another one."""
    kept = [
        (layer, i)
        for layer in layers
        if layer.kind == "points"
        for i, role in enumerate(layer.roles)
        if role in ("state", "normal") and layer.labels[i] and is_main(layer.names[i])
    ]
    if not kept:
        return
    texts = [typeset(layer.labels[i]) for layer, i in kept]
    points = np.stack([layer.vertices[:, i, 0] for layer, i in kept], 1)
    centres, free = free_letters(points, texts, room)
    for role in ("state", "normal"):
        chosen = [i for i, (layer, k) in enumerate(kept) if layer.roles[k] == role]
        if not chosen:
            continue
        places, seen = centres[:, chosen] + LINE_UP * 1j * room.em, free[:, chosen]
        labels = np.broadcast_to(np.array([legible(texts[i]) for i in chosen], object), seen.shape)
        letters = rr.Points2D.columns(positions=xy(places[seen]), labels=labels[seen].tolist())
        style = rr.Points2D.from_fields(
            colors=shades([role]), radii=[0.0], show_labels=True, draw_order=LETTERS_FIRST
        )
        yield SHEET, f"letters/{role}", style, letters, seen.sum(axis=1)


def free_letters(
    points: Points, texts: Sequence[str], room: Room
) -> tuple[Points, npt.NDArray[np.bool_]]:
    """Return the places of letters, each as near to its point as it is legible.

    That is in view, not covered by another letter or a text on the page, and where the viewer's plate
    behind it covers nothing of the motion to speak of.

    Parameters
    ----------
    points : shape (steps, letters)

    Returns
    -------
    the places, and which letters are legible, shapes as points
    """
    halves = np.array([text_box(0j, text, room.em).half for text in texts])
    plates = halves + PLATE * room.em * (1 + 1j)
    known = np.isfinite(points)
    centres, free = np.where(known, points, 0.0), np.zeros(points.shape, bool)
    for (i, half), gap in product(enumerate(halves), _GAPS):
        left = np.flatnonzero(known[:, i] & ~free[:, i])
        places = points[left, i, None] + (away(half, _WAYS) + gap * room.em) * _WAYS
        mine, others = Boxes(places[..., None], half), free[left, None, :]
        over = (mine.overlap(Boxes(centres[left, None, :], halves)) > 0.0) & others
        clear = ~over.any(axis=-1) & (room.covered(Boxes(places, plates[i])) <= _LEAST_COVERED)
        best = clear.argmax(axis=1)
        found = np.flatnonzero(clear.any(axis=1))
        centres[left[found], i] = places[found, best[found]]
        free[left[found], i] = True
    return centres, free
