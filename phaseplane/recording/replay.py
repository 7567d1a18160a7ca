"""Logging of a construction: the sheet once, then the steps in whole columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr

from phaseplane.constructions.primitives import (
    Arc,
    Curve,
    Drawing,
    Mark,
    Plane,
    Scheme,
    Stroke,
)
from phaseplane.constructions.sheet import events_of

from . import sheet
from .columns import Clock, Integers, lettering, line_style, point_style, strips
from .content import Content
from .styles import legible, style
from .words import event_texts, stage_texts, step_text

SHEET = "/sheet"
EVENTS = f"{SHEET}/events"
_MOST_NAMED, _MOST_LETTERED = 6, 24  # most events with full names and with letters
WORDS, STAGES = "/words/step", "/words/stages"


def log_construction(
    recording: rr.RecordingStream, drawing: Drawing, content: Content, clock: Clock
) -> None:
    """Log the planes, the motion in them and, if the detail asks for it, the drawing of each step.

    Raises
    ------
    ValueError : if a frame lacks a point of its scheme.
    """
    box = content.box
    log_axes(recording, drawing.planes, content.trails, box)
    _log_curves(recording, drawing, box)
    for plane, trail in zip(drawing.planes, content.trails, strict=True):
        _log_trail(recording, plane, trail, clock)
    _log_events(recording, drawing, clock)
    for key in drawing.schemes if content.detail != "trail" else ():
        _log_scheme(recording, drawing, key, clock, box)


def trail_path(plane: Plane) -> str:
    """Return the path of the motion in a plane."""
    return f"{SHEET}/trail/{plane.name}"


def log_axes(
    recording: rr.RecordingStream,
    planes: Sequence[Plane],
    trails: Sequence[sheet.Complexes],
    box: sheet.Bounds,
) -> None:
    """Log the axes of planes over the range of the motion in them."""
    for plane, trail in zip(planes, trails, strict=True):
        strips, texts = sheet.axes(plane, planes, trail, box)
        recording.log(
            f"{SHEET}/axes/{plane.name}",
            rr.LineStrips2D([sheet.vertices(np.array(strip)) for strip in strips]),
            line_style([style("axis")]),
            lettering(texts, "axis"),
            static=True,
        )


def _log_curves(recording: rr.RecordingStream, drawing: Drawing, box: sheet.Bounds) -> None:
    """Log the fixed curves, one entity for each role, with labels at their ends."""
    by_role: dict[str, list[Curve]] = {}
    for curve in drawing.curves:
        by_role.setdefault(curve.role, []).append(curve)
    for role, curves in by_role.items():
        recording.log(
            f"{SHEET}/curves/{role}",
            rr.LineStrips2D([sheet.vertices(np.array(curve.vertices)) for curve in curves]),
            line_style([style(role)]),
            lettering(sheet.curve_names(curves, box), role),
            static=True,
        )


def _log_trail(
    recording: rr.RecordingStream, plane: Plane, z: sheet.Complexes, clock: Clock
) -> None:
    """Log one short segment for each step; the view shows all of them up to the cursor."""
    rows = np.arange(1, len(z))
    path = trail_path(plane)
    recording.log(path, line_style([style("trail")]), point_style([style("trail")]), static=True)
    recording.send_columns(
        path,
        clock.columns(rows),
        [
            *rr.LineStrips2D.columns(strips=strips(np.stack([z[:-1], z[1:]], 1))),
            *rr.Points2D.columns(positions=sheet.vertices(z[1:])),
        ],
    )


def _log_events(recording: rr.RecordingStream, drawing: Drawing, clock: Clock) -> None:
    """Log marks in the planes of each event."""
    found = {i: events_of(frame, drawing.planes) for i, frame in enumerate(drawing.frames)}
    found = {i: events for i, events in found.items() if events}
    if not found:
        return
    z = [
        drawing.frames[i].points[plane.state]
        for i, events in found.items()
        for event in events
        for plane in event.planes
    ]
    length = 1 if len(found) > _MOST_NAMED else None  # U or V alone
    labels = [
        legible(event_texts(event)[0])[:length] if len(found) <= _MOST_LETTERED else ""
        for events in found.values()
        for event in events
        for _ in event.planes
    ]
    recording.log(EVENTS, point_style([style("event")]), static=True)
    recording.send_columns(
        EVENTS,
        clock.columns(np.array(list(found))),
        rr.Points2D.columns(positions=sheet.vertices(np.array(z)), labels=labels).partition(
            [sum(len(event.planes) for event in events) for events in found.values()]
        ),
    )


def log_words(recording: rr.RecordingStream, drawing: Drawing, clock: Clock) -> None:
    """Log the description of every step, its readings, and its stages."""
    rows = np.arange(len(drawing.frames))
    for path in (WORDS, STAGES):
        style_only = rr.TextDocument.from_fields(media_type=rr.MediaType.MARKDOWN)
        recording.log(path, style_only, static=True)
    recording.send_columns(
        WORDS,
        clock.columns(rows),
        rr.TextDocument.columns(text=[step_text(drawing, frame) for frame in drawing.frames]),
    )
    texts = {key: stage_texts(scheme) for key, scheme in drawing.schemes.items()}
    schemes = [frame.scheme for frame in drawing.frames]
    new = np.array([i for i, key in enumerate(schemes) if i == 0 or key != schemes[i - 1]])
    recording.send_columns(
        STAGES,
        Clock(clock.times, clock.steps).columns(new),
        rr.TextDocument.columns(text=[texts[schemes[i]][0] for i in new]),
    )
    if clock.stages_per_step:
        first = dict(zip(texts, np.cumsum([0, *map(len, texts.values())]), strict=False))
        counts = np.array([len(texts[key]) - 1 for key in schemes])
        stage = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        chosen = np.repeat([first[key] + 1 for key in schemes], counts) + stage
        said = [text for several in texts.values() for text in several]
        stages = clock.stages_per_step * np.repeat(clock.steps[rows], counts) + stage
        recording.send_columns(
            STAGES,
            [rr.TimeColumn("stage", sequence=stages)],
            rr.TextDocument.columns(text=pa.array([said[i] for i in chosen])),
        )


def _log_scheme(
    recording: rr.RecordingStream, drawing: Drawing, key: str, clock: Clock, box: sheet.Bounds
) -> None:
    """Log the construction of all steps with the same scheme, one entity per stage.

    An entity appears at its stage, and an empty row clears it where the next step begins.
    """
    steps = np.array([i for i, f in enumerate(drawing.frames) if f.scheme == key], np.int64)
    if not steps.size:
        return
    frames = [drawing.frames[i] for i in steps]
    after = np.setdiff1d(steps + 1, [*steps, len(drawing.frames)])
    scheme = drawing.schemes[key]
    letters = sheet.letters(scheme, frames, box)
    names = sorted(_named(scheme))
    table = dict(zip(names, sheet.points(frames, names).T, strict=True)) if names else {}
    for stage in range(len(scheme.stages)):
        rows, offsets, drawn = _rows(steps, after, stage if clock.stages_per_step else 0)
        for name, statics, columns in _primitives(scheme, stage, table, drawn, letters):
            path = f"{SHEET}/construction/{key}/{stage + 1}{name}"
            recording.log(path, *statics, static=True)
            recording.send_columns(path, clock.columns(rows, offsets), columns)


def _named(scheme: Scheme) -> set[str]:
    """Return the points in a scheme."""
    return {
        *(mark.point for mark in scheme.marks),
        *(end for stroke in scheme.strokes for end in (stroke.start, stroke.end)),
        *(place for arc in scheme.arcs for place in (arc.centre, arc.start, arc.end)),
    }


def _rows(steps: Integers, after: Integers, stage: int) -> tuple[Integers, Integers, Integers]:
    """Return, for every row of an entity, the index of its step, its stage, and whether it draws."""
    blank = np.union1d(steps, after) if stage else after
    rows = np.concatenate([blank, steps])
    drawn = np.repeat([0, 1], [len(blank), len(steps)])
    order = np.lexsort([drawn, rows])
    return rows[order], (stage * drawn)[order], drawn[order]


def _primitives(
    scheme: Scheme,
    stage: int,
    table: Mapping[str, sheet.Complexes],
    drawn: Integers,
    letters: Mapping[Mark, str],
) -> Iterator[tuple[str, list[Any], list[Any]]]:
    """Return the parts of a stage: suffix of its path, static components, and columns."""

    def of(names: Sequence[str]) -> sheet.Complexes:
        return np.stack([table[name] for name in names], 1)

    marks: list[Mark] = [mark for mark in scheme.marks if mark.stage == stage]
    strokes: list[Stroke] = [stroke for stroke in scheme.strokes if stroke.stage == stage]
    arcs: list[Arc] = [arc for arc in scheme.arcs if arc.stage == stage]
    statics: list[Any] = []
    columns: list[Any] = []
    if marks:
        z = of([mark.point for mark in marks])
        statics.append(point_style([style(m.role) for m in marks], [letters[m] for m in marks]))
        columns += rr.Points2D.columns(positions=sheet.vertices(z.ravel())).partition(
            len(marks) * drawn
        )
    if strokes:
        z = of([name for stroke in strokes for name in (stroke.start, stroke.end)])
        statics.append(line_style([style(stroke.role) for stroke in strokes]))
        columns += rr.LineStrips2D.columns(strips=strips(z.reshape(-1, 2))).partition(
            len(strokes) * drawn
        )
    if columns:
        yield "", statics, columns
    if arcs:  # a separate entity, because arcs have more vertices than strokes
        z = sheet.arcs(
            *(of([getattr(a, part) for a in arcs]) for part in ("centre", "start", "end"))
        )
        yield (
            "/arcs",
            [line_style([style(arc.role) for arc in arcs])],
            [
                *rr.LineStrips2D.columns(strips=strips(z.reshape(-1, z.shape[-1]))).partition(
                    len(arcs) * drawn
                )
            ],
        )
