"""The side view of the vehicle on its road: shapes that are logged once, and their motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import rerun as rr

from .columns import Clock, Reals, flat, line_style, seconds, strips
from .content import Content
from .motion import thinned
from .sheet import Bounds, vertices
from .styles import style
from .vehicle import (
    FLOOR,
    SPRING_BESIDE,
    AxleView,
    Polyline,
    Vehicle,
    body_over,
    coils,
    gap_at,
    gap_strokes,
    hull,
    on_body,
    on_wheel,
    rest_height,
    road_profile,
    spring_at,
    wheel_over,
)

VEHICLE = "/vehicle"
_MOST_ROWS = 2000
_MARGIN = 0.15


def vehicle_of(content: Content) -> Vehicle | None:
    """Return the vehicle if it is shown and the columns of its motion are present."""
    vehicle = content.vehicle
    shown = content.shows("vehicle") and vehicle is not None
    return vehicle if shown and vehicle and vehicle.columns <= content.histories.keys() else None


def view_box(vehicle: Vehicle) -> Bounds:
    """Return the bounds of a view of the vehicle."""
    left, right = vehicle.reach
    return Bounds(left - _MARGIN, right + _MARGIN, -0.2, FLOOR + 0.45)


def send_vehicle(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the positions of the vehicle's parts at every time."""
    vehicle = vehicle_of(content)
    if vehicle is None or not len(content.histories["time"]):  # type: ignore[arg-type]
        return
    histories = {name: np.asarray(column, float) for name, column in content.histories.items()}
    few = thinned(histories, _MOST_ROWS)
    for times, columns in clock.over(few["time"]):
        at = {name: np.interp(times, histories["time"], histories[name]) for name in few}
        send_positions(recording, vehicle, at, columns)


def log_vehicle(recording: rr.RecordingStream, content: Content) -> None:
    """Log the shapes of the vehicle's parts, and the road as far as it is known."""
    vehicle = vehicle_of(content)
    if vehicle is None:
        return
    recording.log(VEHICLE, rr.Transform3D(scale=[1.0, -1.0, 1.0]), static=True)
    _log_part(recording, "body", hull(vehicle), "body")
    for axle in vehicle.axles:
        _log_part(recording, f"{axle.name}/strut", on_body(axle), "damper")
        _log_part(recording, f"{axle.name}/wheel", on_wheel(axle), "wheel")
        _log_part(recording, f"{axle.name}/spring", [coils()], "spring")
        recording.log(f"{VEHICLE}/{axle.name}/gap", line_style([style("gap")]), static=True)
    if content.live:  # at rest until the first row
        at_rest = dict.fromkeys(content.histories, np.zeros(1))
        send_positions(recording, vehicle, at_rest, [seconds(np.zeros(1))])
    histories = {name: np.asarray(column, float) for name, column in content.histories.items()}
    if vehicle.road or len(histories["time"]):
        _log_part(recording, "road", road_profile(vehicle, histories), "road")


def _log_part(
    recording: rr.RecordingStream, name: str, outline: Sequence[Polyline], role: str
) -> None:
    recording.log(
        f"{VEHICLE}/{name}",
        rr.LineStrips2D([vertices(np.array(strip)) for strip in outline]),
        line_style([style(role)]),
        static=True,
    )


def send_positions(
    recording: rr.RecordingStream,
    vehicle: Vehicle,
    at: Mapping[str, Reals],
    columns: list[rr.TimeColumn],
) -> None:
    """Log the positions of the parts at some times.

    Parameters
    ----------
    at : `time` and the columns of the vehicle at these times
    columns : the time columns
    """

    def place(name: str, x: npt.ArrayLike, y: npt.ArrayLike, **more: npt.ArrayLike) -> None:
        recording.send_columns(
            f"{VEHICLE}/{name}",
            columns,
            rr.Transform3D.columns(translation=flat(x, y), **more),  # type: ignore[arg-type]
        )

    place("road", -vehicle.speed * at["time"], np.zeros(len(at["time"])))
    height, pitch = body_over(vehicle, at)
    place(
        "body",
        0.0,
        height,
        quaternion=np.stack(
            [np.zeros_like(pitch), np.zeros_like(pitch), np.sin(pitch / 2), np.cos(pitch / 2)], -1
        ),
    )
    for axle in vehicle.axles:
        body, wheel = at[axle.body], wheel_over(axle, at)
        place(f"{axle.name}/strut", axle.position, FLOOR + body)
        place(f"{axle.name}/wheel", axle.position, rest_height(axle) + wheel)
        foot, length = spring_at(axle, body, wheel)
        place(
            f"{axle.name}/spring",
            axle.position + SPRING_BESIDE,
            foot,
            scale=flat(np.ones_like(length), length, 1.0),
        )
        _send_gap(recording, axle, at, columns)


def _send_gap(
    recording: rr.RecordingStream,
    axle: AxleView,
    at: Mapping[str, Reals],
    columns: list[rr.TimeColumn],
) -> None:
    """Log the gap between road and tyre, shaded while it is open; an empty row clears it."""
    if not axle.wheel:
        return
    gap = gap_at(axle, at)
    strokes = gap_strokes(axle, wheel_over(axle, at), at[axle.road])
    open_rows = gap > 0.0
    recording.send_columns(
        f"{VEHICLE}/{axle.name}/gap",
        columns,
        rr.LineStrips2D.columns(strips=strips(strokes[open_rows].reshape(-1, 2))).partition(
            strokes.shape[1] * open_rows
        ),
    )
