"""What is logged: the sheet once, then every step of the construction in whole columns.

Every row carries all timelines it can be seen on, so each is stored once: `t` (time of the motion),
`step`, and `stage`, which runs through the stages of one step before it goes on to the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.primitives import (
    Arc,
    Curve,
    Drawing,
    Frame,
    Mark,
    Plane,
    Scheme,
    Stroke,
)

from . import sheet
from .histories import Panel, panels
from .styles import SERIES_COLOURS, Style, legible, style, typeset
from .words import step_texts

Detail = Literal["trail", "steps", "stages"]
DETAILS: tuple[Detail, ...] = get_args(Detail)

SHEET = "/sheet"
EVENTS = f"{SHEET}/events"
WORDS = "/words"
HISTORIES = "/histories"
EVENT_LABELS = {"lift_off": "U lift-off", "touchdown": "V touchdown"}

Integers = npt.NDArray[np.int64]


def log(
    recording: rr.RecordingStream,
    drawing: Drawing,
    histories: Mapping[str, npt.ArrayLike] | None = None,
    *,
    detail: Detail = "stages",
) -> None:
    """Log the replay of a construction to a recording, whatever its sink.

    Parameters
    ----------
    drawing : what is replayed
    histories : `time` (s) and columns of the same length over it, in SI; those whose names end as
        `quantities.QUANTITIES` says are plotted, the others are left out
    detail : `trail`: the planes and the motion in them; `steps`: and the complete construction of
        every step; `stages`: and on the timeline `stage` drawn in its order

    Raises
    ------
    ValueError : no frames, a point or scheme that a frame needs and lacks, histories of unequal
        length or without `time`, an unknown detail.
    """
    check(drawing, detail)
    clock = _Clock.of(drawing, stages=detail == "stages")
    box = sheet.bounds(drawing)
    recording.send_recording_name(legible(drawing.title))
    recording.log(SHEET, rr.Transform3D(scale=[1.0, -1.0, 1.0]), static=True)
    _log_axes(recording, drawing, box)
    _log_curves(recording, drawing, box)
    _log_trails(recording, drawing, clock)
    _log_events(recording, drawing, clock)
    if detail != "trail":
        _log_words(recording, drawing, clock)
        for key in drawing.schemes:
            _log_scheme(recording, drawing, key, clock, box)
    for panel in panels(histories):
        _log_panel(recording, panel, clock)


def check(drawing: Drawing, detail: str) -> None:
    """Refuse what cannot be recorded."""
    if detail not in DETAILS:
        raise ValueError(f"detail {detail!r} is not known; there are {', '.join(DETAILS)}")
    if not drawing.frames:
        raise ValueError(f"the drawing {drawing.title!r} has no steps: nothing to record")
    for frame in drawing.frames:
        if frame.scheme not in drawing.schemes:
            raise ValueError(
                f"step {frame.step} follows the scheme {frame.scheme!r}; "
                f"the drawing has {', '.join(drawing.schemes)}"
            )


def trail_path(plane: Plane) -> str:
    """Where the motion in a plane is logged."""
    return f"{SHEET}/trail/{plane.name}"


@dataclass(frozen=True, slots=True)
class _Clock:
    """The timelines: for each step, and for the end of the last one, its time and its number."""

    times: npt.NDArray[np.float64]
    steps: Integers
    stages_per_step: int

    @classmethod
    def of(cls, drawing: Drawing, stages: bool) -> _Clock:
        last = drawing.frames[-1]
        return cls(
            np.array([*(frame.time for frame in drawing.frames), last.time + last.duration]),
            np.array([*(frame.step for frame in drawing.frames), last.step + 1]),
            max(len(scheme.stages) for scheme in drawing.schemes.values()) if stages else 0,
        )

    def columns(self, rows: Integers, stage: int | Integers = 0) -> list[rr.TimeColumn]:
        """The time columns of the rows that belong to the steps with these indices."""
        columns = [_seconds(self.times[rows]), rr.TimeColumn("step", sequence=self.steps[rows])]
        if self.stages_per_step:
            stages = self.stages_per_step * self.steps[rows] + stage
            columns.append(rr.TimeColumn("stage", sequence=stages))
        return columns


def _seconds(times: npt.NDArray[np.float64]) -> rr.TimeColumn:
    return rr.TimeColumn("t", duration=np.rint(times * 1e9).astype("timedelta64[ns]"))


def _colours(colours: Sequence[int]) -> npt.NDArray[np.uint32]:
    return np.array(colours, np.uint32)  # four of them in a list would be taken as one RGBA


def _radii(sizes: Sequence[float]) -> npt.NDArray[np.float32]:
    return -0.5 * np.array(sizes, np.float32)  # negative: in screen points, not in metres of paper


def _line_style(styles: Sequence[Style]) -> rr.LineStrips2D:
    return rr.LineStrips2D.from_fields(
        colors=_colours([s.colour for s in styles]), radii=_radii([s.width for s in styles])
    )


def _point_style(styles: Sequence[Style], labels: Sequence[str] | None = None) -> rr.Points2D:
    return rr.Points2D.from_fields(
        colors=_colours([s.colour for s in styles]),
        radii=_radii([s.size for s in styles]),
        labels=labels,
        show_labels=None if labels is None else True,
    )


def _lettering(texts: Sequence[sheet.Text], role: str) -> rr.Points2D:
    """Texts without points."""
    return rr.Points2D(
        sheet.vertices(np.array([text.place for text in texts], complex)),
        colors=_colours([style(role).colour]),
        radii=0.0,
        labels=[typeset(text.label) for text in texts],
        show_labels=True,
    )


def _log_axes(recording: rr.RecordingStream, drawing: Drawing, box: sheet.Bounds) -> None:
    for plane in drawing.planes:
        strips, texts = sheet.axes(drawing, plane, box)
        recording.log(
            f"{SHEET}/axes/{plane.name}",
            rr.LineStrips2D([sheet.vertices(np.array(strip)) for strip in strips]),
            _line_style([style("axis")]),
            _lettering(texts, "axis"),
            static=True,
        )


def _log_curves(recording: rr.RecordingStream, drawing: Drawing, box: sheet.Bounds) -> None:
    """The curves that stay, one entity for each role; a label stands at the end of its curve."""
    by_role: dict[str, list[Curve]] = {}
    for curve in drawing.curves:
        by_role.setdefault(curve.role, []).append(curve)
    for role, curves in by_role.items():
        recording.log(
            f"{SHEET}/curves/{role}",
            rr.LineStrips2D([sheet.vertices(np.array(curve.vertices)) for curve in curves]),
            _line_style([style(role)]),
            _lettering(sheet.curve_names(curves, box), role),
            static=True,
        )


def _log_trails(recording: rr.RecordingStream, drawing: Drawing, clock: _Clock) -> None:
    """One short segment for each step; the view shows all of them up to the cursor."""
    for plane in drawing.planes:
        z = sheet.trail(drawing, plane)
        rows = np.arange(1, len(z))
        path = trail_path(plane)
        recording.log(
            path, _line_style([style("trail")]), _point_style([style("trail")]), static=True
        )
        recording.send_columns(
            path,
            clock.columns(rows),
            [
                *rr.LineStrips2D.columns(strips=sheet.vertices(np.stack([z[:-1], z[1:]], 1))),
                *rr.Points2D.columns(positions=sheet.vertices(z[1:])),
            ],
        )


def _log_events(recording: rr.RecordingStream, drawing: Drawing, clock: _Clock) -> None:
    rows = np.array([i for i, frame in enumerate(drawing.frames) if frame.event])
    if not rows.size:
        return
    frames = [drawing.frames[i] for i in rows]
    planes = len(drawing.planes)
    z = sheet.points(frames, [plane.state for plane in drawing.planes])
    labels = [legible(EVENT_LABELS.get(f.event, f.event)) for f in frames for _ in drawing.planes]
    recording.log(EVENTS, _point_style([style("event")]), static=True)
    recording.send_columns(
        EVENTS,
        clock.columns(rows),
        rr.Points2D.columns(positions=sheet.vertices(z.ravel()), labels=labels).partition(
            [planes] * len(frames)
        ),
    )


def _log_words(recording: rr.RecordingStream, drawing: Drawing, clock: _Clock) -> None:
    texts = [step_texts(drawing, frame) for frame in drawing.frames]
    rows = np.arange(len(texts))
    recording.log(WORDS, rr.TextDocument.from_fields(media_type=rr.MediaType.MARKDOWN), static=True)
    recording.send_columns(
        WORDS,
        _Clock(clock.times, clock.steps, 0).columns(rows),
        rr.TextDocument.columns(text=[text.complete for text in texts]),
    )
    if clock.stages_per_step:
        counts = [len(text.stages) for text in texts]
        stage = np.concatenate([np.arange(count) for count in counts])
        of_step = np.repeat(clock.steps[rows], counts)
        recording.send_columns(
            WORDS,
            [rr.TimeColumn("stage", sequence=clock.stages_per_step * of_step + stage)],
            rr.TextDocument.columns(text=[words for text in texts for words in text.stages]),
        )


def _log_scheme(
    recording: rr.RecordingStream, drawing: Drawing, key: str, clock: _Clock, box: sheet.Bounds
) -> None:
    """The construction of all steps that follow one scheme: one entity for each stage.

    An entity appears at its stage, and an empty row takes it away where the next step begins.
    """
    steps = np.array([i for i, f in enumerate(drawing.frames) if f.scheme == key], np.int64)
    if not steps.size:
        return
    frames = [drawing.frames[i] for i in steps]
    after = np.setdiff1d(steps + 1, [*steps, len(drawing.frames)])
    scheme = drawing.schemes[key]
    letters = sheet.letters(scheme, frames, box)
    for stage in range(len(scheme.stages)):
        rows, offsets, drawn = _rows(steps, after, stage if clock.stages_per_step else 0)
        for name, statics, columns in _primitives(scheme, stage, frames, drawn, letters):
            path = f"{SHEET}/construction/{key}/{stage + 1}{name}"
            recording.log(path, *statics, static=True)
            recording.send_columns(path, clock.columns(rows, offsets), columns)


def _rows(steps: Integers, after: Integers, stage: int) -> tuple[Integers, Integers, Integers]:
    """Of every row of an entity: the index of its step, its stage, and whether it draws."""
    blank = np.union1d(steps, after) if stage else after
    rows = np.concatenate([blank, steps])
    drawn = np.repeat([0, 1], [len(blank), len(steps)])
    order = np.lexsort([drawn, rows])
    return rows[order], (stage * drawn)[order], drawn[order]


def _primitives(
    scheme: Scheme,
    stage: int,
    frames: Sequence[Frame],
    drawn: Integers,
    letters: Mapping[Mark, str],
) -> Iterator[tuple[str, list[Any], list[Any]]]:
    """What a stage draws: suffix of its path, what is static, and the columns."""

    def table(names: Sequence[str]) -> sheet.Complexes:
        return sheet.points(frames, names)

    marks: list[Mark] = [mark for mark in scheme.marks if mark.stage == stage]
    strokes: list[Stroke] = [stroke for stroke in scheme.strokes if stroke.stage == stage]
    arcs: list[Arc] = [arc for arc in scheme.arcs if arc.stage == stage]
    statics: list[Any] = []
    columns: list[Any] = []
    if marks:
        z = table([mark.point for mark in marks])
        statics.append(_point_style([style(m.role) for m in marks], [letters[m] for m in marks]))
        columns += rr.Points2D.columns(positions=sheet.vertices(z.ravel())).partition(
            len(marks) * drawn
        )
    if strokes:
        z = table([name for stroke in strokes for name in (stroke.start, stroke.end)])
        statics.append(_line_style([style(stroke.role) for stroke in strokes]))
        columns += rr.LineStrips2D.columns(strips=sheet.vertices(z.reshape(-1, 2))).partition(
            len(strokes) * drawn
        )
    if columns:
        yield "", statics, columns
    if arcs:  # of another number of vertices than strokes: apart, so that both stay one array
        z = sheet.arcs(
            *(table([getattr(a, part) for a in arcs]) for part in ("centre", "start", "end"))
        )
        yield (
            "/arcs",
            [_line_style([style(arc.role) for arc in arcs])],
            [
                *rr.LineStrips2D.columns(
                    strips=sheet.vertices(z.reshape(-1, z.shape[-1]))
                ).partition(len(arcs) * drawn)
            ],
        )


def _log_panel(recording: rr.RecordingStream, panel: Panel, clock: _Clock) -> None:
    """Curves over `t` as they were given; over `step` and `stage` at the steps."""
    path = f"{HISTORIES}/{panel.quantity.name}"
    colours = _colours([SERIES_COLOURS[i % len(SERIES_COLOURS)] for i in range(len(panel.names))])
    recording.log(path, rr.SeriesLines(names=panel.labels, colors=colours, widths=1.5), static=True)
    recording.send_columns(path, [_seconds(panel.times)], rr.Scalars.columns(scalars=panel.values))
    at_steps = np.column_stack(
        [
            np.interp(clock.times, panel.times, column, left=np.nan, right=np.nan)
            for column in panel.values.T
        ]
    )
    _, *counted = clock.columns(np.arange(len(clock.times)))
    recording.send_columns(path, counted, rr.Scalars.columns(scalars=at_steps))
