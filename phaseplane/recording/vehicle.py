"""The side view of a vehicle: the shapes of its parts at rest, and the columns that move them.

This module does not depend on rerun. Lengths are in metres, to scale; x points forwards, y upwards
from the level road.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Reals = npt.NDArray[np.float64]
Polyline = list[complex]

TYRE_RADIUS = 0.32
_RIM = 0.19
_PLATE = 0.1  # height of the strut's lower end above the wheel's centre
_STRUT = 0.5  # length of spring and damper at rest
FLOOR = TYRE_RADIUS + _PLATE + _STRUT  # height of the body above the road
_HULL = 0.28  # height of the body
_OVERHANG = 0.45
_COILS = 6
_GAP_STROKES = 11
_ROAD_MARKS = 0.1  # distance of the strokes under the road
_MOST_ROAD = 4000  # points


@dataclass(frozen=True, slots=True)
class AxleView:
    """One axle.

    Parameters
    ----------
    name : of its entities
    position : forwards from the middle of the vehicle, m
    body, road : columns of the body's displacement above it and the road's elevation below it, m
    wheel : column of the wheel's displacement, m; empty if it follows the road without a tyre
    airborne : column of whether the wheel is off the road; empty if it cannot lift off
    static_tyre_deflection : m
    bump_gap, rebound_gap : m; None without a stop
    """

    name: str
    position: float
    body: str
    road: str
    wheel: str = ""
    airborne: str = ""
    static_tyre_deflection: float = 0.0
    bump_gap: float | None = None
    rebound_gap: float | None = None

    @property
    def columns(self) -> set[str]:
        """The columns it needs."""
        return {self.body, self.road, self.wheel} - {""}


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle on its road.

    Parameters
    ----------
    axles : from front to rear
    speed : of travel, m/s
    road : times at which the front axle passes points of the road, s, and their elevations, m;
        default: taken from the columns
    """

    axles: tuple[AxleView, ...]
    speed: float
    road: tuple[tuple[float, float], ...] = ()

    @property
    def columns(self) -> set[str]:
        """The columns it needs."""
        return {name for axle in self.axles for name in axle.columns}

    @property
    def reach(self) -> tuple[float, float]:
        """The extent backwards and forwards, m."""
        positions = [axle.position for axle in self.axles]
        return min(positions) - _OVERHANG, max(positions) + _OVERHANG


def hull(vehicle: Vehicle) -> list[Polyline]:
    """Return the body, about the middle of the vehicle at the height of its floor."""
    left, right = vehicle.reach
    corners = [complex(left, 0), complex(right, 0), complex(right, _HULL), complex(left, _HULL)]
    return [[*corners, corners[0]]]


def on_body(axle: AxleView) -> list[Polyline]:
    """Return the parts fixed to the body over an axle, about its floor: damper rod and stops."""
    rod = [0.08 + 0j, 0.08 - 0.62j * _STRUT]
    piston = [0.055 - 0.62j * _STRUT, 0.105 - 0.62j * _STRUT]
    parts, length, ends = [rod, piston], strut_length(axle), []
    if axle.bump_gap is not None:
        ends.append(-1j * max(0.0, length - axle.bump_gap))
    if axle.rebound_gap is not None:
        ends.append(-1j * (length + min(axle.rebound_gap, 0.3)))
    for end in ends:
        parts += [[0j, end], [-0.03 + end, 0.03 + end]]
    return parts


def on_wheel(axle: AxleView) -> list[Polyline]:
    """Return the parts fixed to a wheel, about its centre: tyre, rim, strut plate and cylinder."""
    plate, top = 1j * _PLATE, 1j * (_PLATE + 0.7 * _STRUT)
    cylinder = [0.045 + top, 0.045 + plate, 0.115 + plate, 0.115 + top]
    rim = _circle(_RIM if axle.wheel else TYRE_RADIUS - 0.03)
    return [_circle(TYRE_RADIUS), rim, [0j, plate], [-0.14 + plate, 0.14 + plate], cylinder]


def _circle(radius: float) -> Polyline:
    return list(radius * np.exp(2j * np.pi * np.arange(49) / 48))


def coils() -> Polyline:
    """Return a spring of length 1, upwards from 0."""
    zigzag = [
        0.045 * (-1) ** k + 1j * (0.1 + 0.8 * (k + 0.5) / (2 * _COILS)) for k in range(2 * _COILS)
    ]
    return [0j, 0.1j, *zigzag, 0.9j, 1j]


def spring_at(axle: AxleView, body: Reals, wheel: Reals) -> tuple[Reals, Reals]:
    """Return the height of a spring's lower end, and its length."""
    return rest_height(axle) + wheel + _PLATE, strut_length(axle) + body - wheel


SPRING_BESIDE = -0.08  # position of the spring relative to the axle, m


def rest_height(axle: AxleView) -> float:
    """Return the height of a wheel's centre at rest; the tyre is drawn with its free radius."""
    return TYRE_RADIUS - axle.static_tyre_deflection


def strut_length(axle: AxleView) -> float:
    """Return the distance from the plate at a wheel to the floor, at rest."""
    return FLOOR - rest_height(axle) - _PLATE


def body_over(vehicle: Vehicle, histories: Mapping[str, Reals]) -> tuple[Reals, Reals]:
    """Return the height of the floor in the middle of the vehicle, and the pitch, rad, front up."""
    front, rear = vehicle.axles[0], vehicle.axles[-1]
    ahead, behind = histories[front.body], histories[rear.body]
    wheelbase = front.position - rear.position
    if wheelbase == 0.0:
        return FLOOR + ahead, np.zeros_like(ahead)
    share = -rear.position / wheelbase
    return FLOOR + behind + share * (ahead - behind), np.arctan2(ahead - behind, wheelbase)


def wheel_over(axle: AxleView, histories: Mapping[str, Reals]) -> Reals:
    """Return the displacement of a wheel's centre; without a tyre it follows the road."""
    return histories[axle.wheel or axle.road]


def gap_at(axle: AxleView, histories: Mapping[str, Reals]) -> Reals:
    """Return the gap between tyre and road while the wheel is off the road, else 0, m."""
    gap = wheel_over(axle, histories) - histories[axle.road] - axle.static_tyre_deflection
    flies = histories[axle.airborne] > 0.5 if axle.airborne in histories else gap > 0.0
    return np.where(flies & (gap > 0.0), gap, 0.0)


def gap_strokes(axle: AxleView, wheel: Reals, road: Reals) -> npt.NDArray[np.complex128]:
    """Return vertical strokes between road and tyre, shape (times, strokes, 2)."""
    x = 0.16 * np.linspace(-1.0, 1.0, _GAP_STROKES)
    tyre = rest_height(axle) - np.sqrt(TYRE_RADIUS**2 - x**2)
    top = wheel[:, None] + tyre
    ends = np.stack([np.broadcast_to(road[:, None], top.shape), top], -1)
    return np.asarray(axle.position + x[None, :, None] + 1j * ends)


def road_profile(vehicle: Vehicle, histories: Mapping[str, Reals]) -> list[Polyline]:
    """Return the road's surface, and strokes below it that make the speed visible.

    The vehicle's middle starts at x = 0 of these ground coordinates.
    """
    front = vehicle.axles[0]
    times, y = (
        np.array(vehicle.road).T if vehicle.road else (histories["time"], histories[front.road])
    )
    every = max(1, len(times) // _MOST_ROAD)
    x, y = vehicle.speed * times[::every] + front.position, y[::every]
    left, right = x[0] - 4.0 - (front.position - vehicle.axles[-1].position), x[-1] + 4.0
    x, y = np.concatenate([[left], x, [right]]), np.concatenate([[y[0]], y, [y[-1]]])
    apart = max(_ROAD_MARKS, (right - left) / _MOST_ROAD)
    marks = np.arange(left, right, apart)
    at = np.interp(marks, x, y)
    return [
        list(x + 1j * y),
        *([complex(m, h), complex(m - 0.04, h - 0.05)] for m, h in zip(marks, at, strict=True)),
    ]
