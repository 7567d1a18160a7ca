"""The side view of a vehicle: the shapes of its parts at rest, and how columns of a run move them.

This module does not depend on rerun. Lengths are in metres, to scale; x points forwards, y upwards
from the level road.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from phaseplane.picture.paper import Reals

Polyline = list[complex]
Columns = Mapping[str, Reals]

_TYRE, _RIM = 0.32, 0.19  # radii
_PLATE = 0.1  # height of the strut's lower end above the wheel's centre
_STRUT = 0.5  # length of spring and damper at rest
FLOOR = _TYRE + _PLATE + _STRUT  # height of the body above the road
HULL = 0.28  # height of the body
_OVERHANG = 0.45
_COILS = 4
_BESIDE = -0.08  # position of the spring relative to the axle
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
    def centre(self) -> str:
        """The column of the displacement of the wheel's centre; without a tyre it follows the road."""
        return self.wheel or self.road

    @property
    def rest(self) -> float:
        """The height of the wheel's centre at rest; the tyre is drawn with its free radius."""
        return _TYRE - self.static_tyre_deflection

    @property
    def strut(self) -> float:
        """The distance from the plate at the wheel to the floor, at rest."""
        return FLOOR - self.rest - _PLATE


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
        return {name for axle in self.axles for name in (axle.body, axle.road, axle.centre)}

    @property
    def reach(self) -> tuple[float, float]:
        """The extent backwards and forwards, m."""
        positions = [axle.position for axle in self.axles]
        return min(positions) - _OVERHANG, max(positions) + _OVERHANG


@dataclass(frozen=True, slots=True)
class Place:
    """Where a part is at some times, how it is turned (rad, front up), and stretched upwards."""

    name: str
    x: npt.ArrayLike
    y: Reals
    pitch: Reals | None = None
    stretch: Reals | None = None


def shapes_of(vehicle: Vehicle) -> Iterator[tuple[str, str, list[Polyline]]]:
    """Yield the name, the part of a car for its hue, and the outline of what moves as one."""
    left, right = vehicle.reach
    corners = [complex(left, 0), complex(right, 0), complex(right, HULL), complex(left, HULL)]
    yield "body", "body", [[*corners, corners[0]]]
    zigzag = [
        0.045 * (-1) ** k + 1j * (0.1 + 0.8 * (k + 0.5) / (2 * _COILS)) for k in range(2 * _COILS)
    ]
    for axle in vehicle.axles:
        yield f"{axle.name}/strut", "suspension", _on_body(axle)
        yield f"{axle.name}/wheel", "wheel", _on_wheel(axle)
        yield f"{axle.name}/spring", "suspension", [[0j, 0.1j, *zigzag, 0.9j, 1j]]


def _on_body(axle: AxleView) -> list[Polyline]:
    """Return the parts fixed to the body over an axle, about its floor: damper rod and stops."""
    rod = [0.08 + 0j, 0.08 - 0.62j * _STRUT]
    piston = [0.055 - 0.62j * _STRUT, 0.105 - 0.62j * _STRUT]
    parts, ends = [rod, piston], []
    if axle.bump_gap is not None:
        ends.append(-1j * max(0.0, axle.strut - axle.bump_gap))
    if axle.rebound_gap is not None:
        ends.append(-1j * (axle.strut + min(axle.rebound_gap, 0.3)))
    for end in ends:
        parts += [[0j, end], [-0.03 + end, 0.03 + end]]
    return parts


def _on_wheel(axle: AxleView) -> list[Polyline]:
    """Return the parts fixed to a wheel, about its centre: tyre, rim, strut plate and cylinder."""
    plate, top = 1j * _PLATE, 1j * (_PLATE + 0.7 * _STRUT)
    cylinder = [0.045 + top, 0.045 + plate, 0.115 + plate, 0.115 + top]
    radii = _TYRE, _RIM if axle.wheel else _TYRE - 0.03
    tyre, rim = (list(radius * np.exp(2j * np.pi * np.arange(49) / 48)) for radius in radii)
    return [tyre, rim, [0j, plate], [-0.14 + plate, 0.14 + plate], cylinder]


def places_of(vehicle: Vehicle, at: Columns) -> Iterator[Place]:
    """Yield the places of the road and of all shapes at the times of some columns."""
    yield Place("road", -vehicle.speed * at["time"], np.zeros(len(at["time"])))
    front, rear = vehicle.axles[0], vehicle.axles[-1]
    ahead, behind = at[front.body], at[rear.body]
    height, pitch = FLOOR + ahead, np.zeros_like(ahead)
    wheelbase = front.position - rear.position
    if wheelbase:
        height = FLOOR + behind - rear.position / wheelbase * (ahead - behind)
        pitch = np.arctan2(ahead - behind, wheelbase)
    yield Place("body", 0.0, height, pitch=pitch)
    for axle in vehicle.axles:
        body, wheel = at[axle.body], at[axle.centre]
        yield Place(f"{axle.name}/strut", axle.position, FLOOR + body)
        yield Place(f"{axle.name}/wheel", axle.position, axle.rest + wheel)
        yield Place(
            f"{axle.name}/spring", axle.position + _BESIDE, axle.rest + wheel + _PLATE,
            stretch=axle.strut + body - wheel,
        )  # fmt: skip


def open_gap(
    axle: AxleView, at: Columns
) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.complex128]]:
    """Return when the gap between tyre and road is open, and then strokes in it.

    The strokes are vertical, shape (times when it is open, strokes, 2).
    """
    wheel, road = at[axle.centre], at[axle.road]
    is_open = wheel - road - axle.static_tyre_deflection > 0.0
    if axle.airborne in at:
        is_open &= at[axle.airborne] > 0.5
    x = 0.16 * np.linspace(-1.0, 1.0, _GAP_STROKES)
    top = wheel[is_open, None] + axle.rest - np.sqrt(_TYRE**2 - x**2)
    ends = np.stack([np.broadcast_to(road[is_open, None], top.shape), top], -1)
    return is_open, np.asarray(axle.position + x[None, :, None] + 1j * ends)


def road_profile(vehicle: Vehicle, histories: Columns) -> list[Polyline]:
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
