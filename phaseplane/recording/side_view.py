"""The side view of the vehicle on its road: shapes that are logged once, and their motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.paper import Box
from phaseplane.picture.styles import RED, Hue, hue_of

from . import vehicle as shapes
from .columns import UPRIGHT, Clock, Reals, colours, flat, radii, rgba, seconds, strips, xy
from .content import Content
from .motion import thinned
from .vehicle import AxleView, Polyline, Vehicle

VEHICLE = "/vehicle"
_MOST_ROWS = 2000
_MARGIN = 0.15
_WIDTH = 2.0  # of lines


def vehicle_of(content: Content) -> Vehicle | None:
    """Return the vehicle if it is shown and the columns of its motion are present."""
    vehicle = content.vehicle if content.shows("vehicle") else None
    return vehicle if vehicle and vehicle.columns <= content.histories.keys() else None


def view_box(vehicle: Vehicle, content: Content) -> Box:
    """Return the bounds of a view of the vehicle and of all its motion."""
    left, right = vehicle.reach
    reach = np.concatenate([[0.0], *map(content.column, vehicle.columns)])
    reach = reach[np.isfinite(reach)]
    bottom, top = -0.2 + float(reach.min()), shapes.FLOOR + 0.45 + float(reach.max())
    middle = complex(left + right, bottom + top) / 2.0
    return Box(middle, complex(right - left + 2.0 * _MARGIN, top - bottom) / 2.0)


def send_vehicle(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the positions of the vehicle's parts at every time."""
    vehicle = vehicle_of(content)
    if vehicle is None or not len(content.times):
        return
    for times, columns in clock.over(thinned(content.histories, _MOST_ROWS)["time"]):
        at = {n: np.interp(times, content.times, content.column(n)) for n in content.histories}
        send_positions(recording, vehicle, at, columns)


def log_vehicle(recording: rr.RecordingStream, content: Content) -> None:
    """Log the shapes of the vehicle's parts, and the road as far as it is known."""
    vehicle = vehicle_of(content)
    if vehicle is None:
        return
    recording.log(VEHICLE, UPRIGHT, static=True)
    _log_part(recording, "body", shapes.hull(vehicle), hue_of("body"))
    for axle in vehicle.axles:
        _log_part(recording, f"{axle.name}/strut", shapes.on_body(axle), hue_of("suspension"))
        _log_part(recording, f"{axle.name}/wheel", shapes.on_wheel(axle), hue_of("wheel"))
        _log_part(recording, f"{axle.name}/spring", [shapes.coils()], hue_of("suspension"))
        recording.log(f"{VEHICLE}/{axle.name}/gap", _style(RED), static=True)
    if content.live:  # at rest until the first row
        at_rest = dict.fromkeys(content.histories, np.zeros(1))
        send_positions(recording, vehicle, at_rest, [seconds(np.zeros(1))])
    if vehicle.road or len(content.times):
        histories = {name: content.column(name) for name in content.histories}
        _log_part(recording, "road", shapes.road_profile(vehicle, histories), hue_of("road"))


def _log_part(
    recording: rr.RecordingStream, name: str, outline: Sequence[Polyline], hue: Hue
) -> None:
    shape = rr.LineStrips2D([xy(strip) for strip in outline])
    recording.log(f"{VEHICLE}/{name}", shape, _style(hue), static=True)


def _style(hue: Hue) -> rr.LineStrips2D:
    return rr.LineStrips2D.from_fields(colors=colours([rgba(hue)]), radii=radii([_WIDTH]))


def send_positions(
    recording: rr.RecordingStream, vehicle: Vehicle, at: Mapping[str, Reals],
    columns: list[rr.TimeColumn],
) -> None:  # fmt: skip
    """Log the positions of the parts at some times: `columns`, and those of the run at them."""

    def place(name: str, x: npt.ArrayLike, y: npt.ArrayLike, **more: npt.ArrayLike) -> None:
        moved = rr.Transform3D.columns(translation=flat(x, y), **more)  # type: ignore[arg-type]
        recording.send_columns(f"{VEHICLE}/{name}", columns, moved)

    place("road", -vehicle.speed * at["time"], np.zeros(len(at["time"])))
    height, pitch = shapes.body_over(vehicle, at)
    none = np.zeros_like(pitch)
    turned = np.stack([none, none, np.sin(pitch / 2), np.cos(pitch / 2)], -1)
    place("body", 0.0, height, quaternion=turned)
    for axle in vehicle.axles:
        body, wheel = at[axle.body], shapes.wheel_over(axle, at)
        place(f"{axle.name}/strut", axle.position, shapes.FLOOR + body)
        place(f"{axle.name}/wheel", axle.position, shapes.rest_height(axle) + wheel)
        foot, length = shapes.spring_at(axle, body, wheel)
        scale = flat(np.ones_like(length), length, 1.0)
        place(f"{axle.name}/spring", axle.position + shapes.SPRING_BESIDE, foot, scale=scale)
        _send_gap(recording, axle, at, columns)


def _send_gap(
    recording: rr.RecordingStream, axle: AxleView, at: Mapping[str, Reals],
    columns: list[rr.TimeColumn],
) -> None:  # fmt: skip
    """Log the gap between road and tyre, shaded while it is open; an empty row clears it."""
    if not axle.wheel:
        return
    gap = shapes.gap_at(axle, at)
    strokes = shapes.gap_strokes(axle, shapes.wheel_over(axle, at), at[axle.road])
    open_rows = gap > 0.0
    lines = rr.LineStrips2D.columns(strips=strips(strokes[open_rows].reshape(-1, 2)))
    parts = lines.partition(strokes.shape[1] * open_rows)
    recording.send_columns(f"{VEHICLE}/{axle.name}/gap", columns, parts)
