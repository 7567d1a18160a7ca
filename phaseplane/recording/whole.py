"""Everything that a recording holds, logged at once, whatever its sink."""

from __future__ import annotations

import numpy as np
import rerun as rr

from phaseplane.constructions.primitives import Axis

from . import sheet
from .columns import Clock
from .content import Content
from .histories import log_histories
from .motion import StatePlane, log_run, state_planes
from .replay import SHEET, log_axes, log_construction, log_words
from .side_view import log_vehicle
from .styles import legible


def log(recording: rr.RecordingStream, content: Content) -> None:
    """Log all that is to be shown, in whole columns.

    Raises
    ------
    ValueError : see `Content.check`; a frame that lacks a point which its scheme draws.
    """
    content.check()
    clock = Clock.of(content.drawing, stages=content.detail == "stages")
    recording.send_recording_name(legible(content.title))
    if content.shows("planes"):
        recording.log(SHEET, rr.Transform3D(scale=[1.0, -1.0, 1.0]), static=True)
    if content.constructed is not None:
        log_construction(recording, content.constructed, clock, complete=content.detail != "trail")
    else:
        log_state_axes(recording, state_planes(content), content)
    log_run(recording, content, clock)
    if content.drawing is not None and content.shows("words") and content.detail != "trail":
        log_words(recording, content.drawing, clock)
    log_vehicle(recording, content, clock)
    log_histories(recording, content, clock)


def log_state_axes(
    recording: rr.RecordingStream, planes: list[StatePlane], content: Content
) -> None:
    """The axes of planes that no construction has drawn."""
    if planes:
        trails = [_corners(plane, content) for plane in planes]
        log_axes(recording, [p.plane for p in planes], trails, state_box(planes, content))


def state_box(planes: list[StatePlane], content: Content) -> sheet.Bounds:
    """What a view of such planes shows."""
    box = sheet.Bounds.around(z for plane in planes for z in _corners(plane, content))
    return box.grown(0.12 * max(box.width, box.height))


def _corners(state_plane: StatePlane, content: Content) -> sheet.Complexes:
    """The ends of what moves in a plane, on its axes."""
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
