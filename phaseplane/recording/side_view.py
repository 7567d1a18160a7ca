"""The side view of the vehicle on its road: shapes that are logged once, and their motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.paper import Box
from phaseplane.picture.styles import RED, Hue, hue_of

from .canvas import UPRIGHT, colours, radii, rgba, strips, xy
from .clock import Clock, seconds
from .content import Content
from .motion import sampled
from .vehicle import (
    FLOOR,
    HULL,
    Columns,
    Polyline,
    Vehicle,
    open_gap,
    places_of,
    road_profile,
    shapes_of,
)

VEHICLE = "/vehicle"
_MOST_ROWS = 2000
_MARGIN = 0.15
_WIDTH = 1.2  # of lines, so thin that springs and dampers are seen in a small window, too


def vehicle_of(content: Content) -> Vehicle | None:
    """Return the vehicle if it is shown and the columns of its motion are present."""
    vehicle = content.vehicle if content.shows("vehicle") else None
    return vehicle if vehicle and vehicle.columns <= content.histories.keys() else None


def view_box(vehicle: Vehicle, content: Content) -> Box:
    """Return the bounds of a view of the vehicle and of all its motion."""
    left, right = vehicle.reach
    reach = np.concatenate([[0.0], *map(content.column, vehicle.columns)])
    reach = reach[np.isfinite(reach)]
    bottom, top = -_MARGIN + float(reach.min()), FLOOR + HULL + float(reach.max())
    top += 0.5 * _MARGIN
    middle = complex(left + right, bottom + top) / 2.0
    return Box(middle, complex(right - left + 2.0 * _MARGIN, top - bottom) / 2.0)


def log_vehicle(recording: rr.RecordingStream, content: Content) -> None:
    """Log the shapes of the vehicle's parts, and the road as far as it is known."""
    vehicle = vehicle_of(content)
    if vehicle is None:
        return
    recording.log(VEHICLE, UPRIGHT, static=True)
    for name, part, outline in shapes_of(vehicle):
        _log(recording, name, outline, hue_of(part))
    for axle in vehicle.axles:
        recording.log(f"{VEHICLE}/{axle.name}/gap", _style(RED), static=True)
    if content.live:  # at rest until the first row
        at_rest = dict.fromkeys(content.histories, np.zeros(1))
        _send(recording, vehicle, at_rest, [seconds(np.zeros(1))])
    if vehicle.road or len(content.times):
        histories = {name: content.column(name) for name in content.histories}
        _log(recording, "road", road_profile(vehicle, histories), hue_of("road"))


def _log(recording: rr.RecordingStream, name: str, outline: Sequence[Polyline], hue: Hue) -> None:
    shape = rr.LineStrips2D([xy(strip) for strip in outline])
    recording.log(f"{VEHICLE}/{name}", shape, _style(hue), static=True)


def _style(hue: Hue) -> rr.LineStrips2D:
    return rr.LineStrips2D.from_fields(colors=colours([rgba(hue)]), radii=radii([_WIDTH]))


def send_vehicle(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the places of the vehicle's parts at every time."""
    vehicle = vehicle_of(content)
    if vehicle is None or not len(content.times):
        return
    for times, columns in clock.over(content.times[sampled(len(content.times), _MOST_ROWS)]):
        at = {n: np.interp(times, content.times, content.column(n)) for n in content.histories}
        _send(recording, vehicle, at, columns)


def _send(
    recording: rr.RecordingStream, vehicle: Vehicle, at: Columns, times: list[rr.TimeColumn]
) -> None:
    for place in places_of(vehicle, at):
        more: dict[str, Any] = {}
        if place.pitch is not None:
            none = np.zeros_like(place.pitch)
            turn = none, none, np.sin(place.pitch / 2), np.cos(place.pitch / 2)
            more["quaternion"] = np.stack(turn, -1)
        if place.stretch is not None:
            more["scale"] = _vectors(1.0, place.stretch, 1.0)
        moved = rr.Transform3D.columns(translation=_vectors(place.x, place.y), **more)
        recording.send_columns(f"{VEHICLE}/{place.name}", times, moved)
    for axle in (axle for axle in vehicle.axles if axle.wheel):
        is_open, strokes = open_gap(axle, at)  # an empty row clears it
        lines = rr.LineStrips2D.columns(strips=strips(strokes.reshape(-1, 2)))
        parts = lines.partition(strokes.shape[1] * is_open)
        recording.send_columns(f"{VEHICLE}/{axle.name}/gap", times, parts)


def _vectors(x: npt.ArrayLike, y: npt.ArrayLike, z: float = 0.0) -> npt.NDArray[np.float32]:
    """Return vectors in the plane of the sheet, shape (n, 3)."""
    return np.stack(np.broadcast_arrays(x, y, z), -1).astype(np.float32)
