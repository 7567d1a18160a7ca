"""The construction of every step on the timelines `t` and `step`, in whole columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np
import rerun as rr

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.layers import Layer, is_main, layers_of
from phaseplane.picture.letters import Room, free_letters
from phaseplane.picture.paper import Integers

from . import canvas
from .clock import Clock

SHEET, ARMS, CHART, WORDS = "/sheet", "/arms", "/chart", "/words"
SLICE = 4096  # steps that are encoded at once
_REPEATED = 0.4  # opacity of what a rule repeats

# path of an entity up to the scheme, and beyond it; its style, its columns, how many items each step has
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
    schemes = np.array([*drawing.frames.schemes, ""])[first : last + 1]
    for key in drawing.schemes:
        drawn = np.append(schemes[:-1] == key, False)
        if not drawn.any():
            continue
        left = np.append(False, drawn[:-1]) & (schemes != key)
        rows = np.flatnonzero(drawn | left)
        columns = clock.columns(first + rows)
        frames = drawing.frames.at((first + np.flatnonzero(drawn)).tolist())
        layers = layers_of(drawing.schemes[key], frames)
        for root, name, style, column, items in chain(_parts(layers), _letters(layers, room)):
            counts = np.zeros(len(rows), np.int64)
            counts[drawn[rows]] = items
            path = f"{root}/steps/{key}/{name}"
            canvas.send(recording, path, style, columns, column.partition(counts))


def _parts(layers: Sequence[Layer]) -> Iterator[Part]:
    """Yield the lines, arcs and points of steps."""
    lines = [layer for layer in layers if layer.kind == "lines"]
    if lines:
        roles = [role for layer in lines for role in layer.roles]
        strengths = [1.0 if is_main(name) else _REPEATED for layer in lines for name in layer.names]
        z = np.concatenate([layer.vertices for layer in lines], 1)
        column = rr.LineStrips2D.columns(strips=canvas.strips(z.reshape(-1, 2)))
        yield SHEET, "lines", canvas.line_style(roles, strengths), column, len(roles)
    for layer in (layer for layer in layers if layer.kind == "arcs"):
        root = ARMS if layer.names[0].startswith("N") else SHEET
        z = layer.vertices.reshape(-1, layer.vertices.shape[-1])
        column = rr.LineStrips2D.columns(strips=canvas.strips(z))
        yield root, f"arcs{layer.stage + 1}", canvas.line_style(layer.roles), column, len(layer)
    points = [layer for layer in layers if layer.kind == "points"]
    if points:
        roles = [role for layer in points for role in layer.roles]
        z = np.concatenate([layer.vertices[..., 0] for layer in points], 1)
        column = rr.Points2D.columns(positions=canvas.xy(z.ravel()))
        yield SHEET, "points", canvas.point_style(roles), column, len(roles)


def _letters(layers: Sequence[Layer], room: Room) -> Iterator[Part]:
    """Yield the letters of P and D, wherever they do not lie on another one."""
    kept = [
        (role, typeset(layer.labels[i]), layer.vertices[:, i, 0])
        for layer in layers
        for i, role in enumerate(layer.roles)
        if layer.kind == "points" and role in ("state", "normal")
        and layer.labels[i] and is_main(layer.names[i])
    ]  # fmt: skip
    if not kept:
        return
    of_role, texts, points = zip(*kept, strict=True)
    centres, free = free_letters(np.stack(points, 1), texts, room)
    for role in ("state", "normal"):
        chosen = [i for i, of in enumerate(of_role) if of == role]
        if not chosen:
            continue
        places, seen = centres[:, chosen] + canvas.LINE_UP * 1j * room.em, free[:, chosen]
        words = np.array([canvas.legible(texts[i]) for i in chosen], object)
        labels = np.broadcast_to(words, seen.shape)[seen].tolist()
        letters = rr.Points2D.columns(positions=canvas.xy(places[seen]), labels=labels)
        style = rr.Points2D.from_fields(
            colors=canvas.shades([role]), radii=[0.0], show_labels=True,
            draw_order=canvas.LETTERS_FIRST,
        )  # fmt: skip
        yield SHEET, f"letters/{role}", style, letters, seen.sum(axis=1)
