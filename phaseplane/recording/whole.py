"""A whole recording, logged at once to any sink."""

from __future__ import annotations

import numpy as np
import rerun as rr

from phaseplane.constructions.primitives import Axis

from . import sheet
from .columns import Clock
from .content import Content
from .histories import log_series, panels, send_histories
from .motion import StatePlane, log_plane, send_run, state_planes
from .replay import SHEET, log_axes, log_construction, log_words
from .side_view import log_vehicle, send_vehicle
from .styles import legible


def log(recording: rr.RecordingStream, content: Content) -> None:
    """Log the whole content, in whole columns.

    Raises
    ------
    ValueError : see `Content.check`; also if a frame lacks a point of its scheme.
    """
    begin(recording, content)
    send(recording, content, Clock.of(content.drawing, stages=content.detail == "stages"))


def begin(recording: rr.RecordingStream, content: Content, *, construction: bool = True) -> None:
    """Log everything known before a run: shapes, styles, and the whole construction."""
    content.check()
    clock = Clock.of(content.drawing, stages=content.detail == "stages")
    recording.send_recording_name(legible(content.title))
    if content.shows("planes"):
        recording.log(SHEET, rr.Transform3D(scale=[1.0, -1.0, 1.0]), static=True)
    if construction and content.constructed is not None:
        log_construction(recording, content.constructed, content, clock)
    log_state_planes(recording, content)
    worded = content.shows("words") and content.detail != "trail"
    if construction and content.drawing is not None and worded:
        log_words(recording, content.drawing, clock)
    log_vehicle(recording, content)
    for panel in panels(content):
        log_series(recording, panel)


def send(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the motion given by the columns of a run, or by some of their rows."""
    send_run(recording, content, clock)
    send_vehicle(recording, content, clock)
    send_histories(recording, content, clock)


def log_state_planes(recording: rr.RecordingStream, content: Content) -> None:
    """Log the positions of the columns' planes, and their axes unless a construction has drawn them."""
    planes = state_planes(content)
    for plane in planes:
        log_plane(recording, plane)
    if planes and content.constructed is None:
        trails = [_corners(plane, content) for plane in planes]
        log_axes(recording, [p.plane for p in planes], trails, state_box(planes, content))


def state_box(planes: list[StatePlane], content: Content) -> sheet.Bounds:
    """Return the bounds of a view of such planes."""
    box = sheet.Bounds.around(np.concatenate([_corners(plane, content) for plane in planes]))
    return box.grown(0.2 * max(box.width, box.height))


def _corners(state_plane: StatePlane, content: Content) -> sheet.Complexes:
    """Return the ends of the motion in a plane, on its axes."""
    plane = state_plane.plane
    ends = [plane.displacement.origin]
    for axis, name in (
        (plane.displacement, state_plane.displacement),
        (plane.scaled_velocity, state_plane.rate),
    ):
        ends += _ends(axis, np.asarray(content.histories.get(name, ()), float))
    return np.array(ends)


def _ends(axis: Axis, values: np.ndarray) -> list[complex]:
    finite = values[np.isfinite(values)]
    if not finite.size:
        return [axis.at(-0.1 / axis.scale), axis.at(0.1 / axis.scale)]
    return [axis.at(float(finite.min())), axis.at(float(finite.max()))]
