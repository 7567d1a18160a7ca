"""A reference for the four vehicles, sharing no code with the package they are held against.

One axle is the car of AP57 eqs. 2 to 11 (on the road itself) or 12 to 32 (on a wheel); two axles are
that of eqs. 33 to 39 or, on wheels, of eq. 1:

    M x'' = -S, or M1 x1'' + M3 x2'' = -S1,  M3 x1'' + M2 x2'' = -S2
    S_i = F_i(y_i) + Phi_i(y_i') + stops,    y_i = x_i - w_i on wheels, x_i - xi_i without
    m_i w_i'' = S_i - T_i,    T_i = c (w_i - xi_i) + k (w_i' - xi_i') on the road,
                              T_i = the static axle load in flight

Contact ends where T_i reaches the static load; it begins where T_i falls below it again (`contact` is
`force`) or, with `gap`, where besides c (w_i - xi_i) does, so that nothing acts across a gap.

Every element keeps its branch (damper piece, stop, contact) until its switch; see `switched`. What
each damper and tyre dissipates and what each road brings in is integrated along with the motion.

Source: AP57 = M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) 81-104.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from switched import Array, Switch, integrate

MODELS = {"OneDof": (1, False), "QuarterCar": (1, True),
          "HalfCarRigidTyres": (2, False), "HalfCar": (2, True)}  # fmt: skip
DAMPER, BUMP_STOP, REBOUND_STOP, CONTACT = range(4)
BRANCHES = (
    ("bump blow-off", "bump", "rebound", "rebound blow-off"),
    ("left", "met"),
    ("left", "met"),
    ("touchdown", "lift-off"),
)
ELEMENTS = ("damper", "bump_stop", "rebound_stop", "tyre")
KGF = 9.80665  # N
FAR = 1e9  # N; the limit of a damper that never blows off

#: AP57 section 8 in SI units.
AP57: dict[str, Any] = {
    "sprung_mass": 30.0 * KGF, "unsprung_mass": 3.0 * KGF, "gravity": 9.80665,
    "spring.rate": 1500.0 * KGF, "spring.cubic": 0.0,
    "damper.rebound_rate": 200.0 * KGF, "damper.bump_rate": 50.0 * KGF,
    "damper.rebound_limit": 0.0, "damper.bump_limit": 0.0, "damper.limit_slope": 0.0,
    "tyre.stiffness": 15000.0 * KGF, "tyre.damping": 100.0 * KGF,
    "bump_stop.gap": 0.08, "bump_stop.stiffness": 0.0,
    "rebound_stop.gap": 0.08, "rebound_stop.stiffness": 0.0,
    "road.shape": "bump", "road.height": 0.05, "road.length": 1.0, "speed": 20.0,
}  # fmt: skip
#: Its damper, whose slope falls to a fifth beyond +0.30 m/s and -0.60 m/s.
BLOW_OFF = ", ".join(
    f"{rate}:{force * KGF!r}"
    for rate, force in ((-1.6, -40.0), (-0.6, -30.0), (0.0, 0.0), (0.3, 60.0), (1.3, 100.0))
)
#: The worked example and its relatives: parameters that differ from it, s, number of instants.
CASES: dict[str, tuple[dict[str, Any], float, int]] = {
    "ap57_lift_off": ({}, 1.0, 201),
    "ap57_contact_by_force": ({"contact": "force"}, 1.0, 201),
    "ap57_no_lift_off": ({"lift_off": False}, 1.0, 201),
    "ap57_blow_off": ({"damper.table": BLOW_OFF}, 2.0, 401),
}

Road = tuple[list[float], list[Callable[[Any], tuple[Any, Any]]]]


def _road(p: Mapping[str, Any], late: float) -> Road:
    """Joints of a road, and on each stretch between them (one more) elevation and velocity."""
    height, passing = p["road.height"], p["road.length"] / p["speed"]
    late += p.get("road.start", 0.0)
    turn, half = 2.0 * np.pi / passing, 0.5 * height

    def level(t: Any) -> tuple[Any, Any]:
        return 0.0 * t, 0.0 * t

    def hump(t: Any) -> tuple[Any, Any]:
        return half * (1.0 - np.cos(turn * (t - late))), half * turn * np.sin(turn * (t - late))

    def wave(t: Any) -> tuple[Any, Any]:
        return half * np.sin(turn * (t - late)), half * turn * np.cos(turn * (t - late))

    def parabola(origin: float, top: float, bend: float) -> Callable[[Any], tuple[Any, Any]]:
        return lambda t: (top + 0.5 * bend * (t - origin) ** 2, bend * (t - origin))

    z = 16.0 * height / passing**2  # AP57 eq. 9
    shapes: dict[str, tuple[list[float], list[Callable[[Any], tuple[Any, Any]]]]] = {
        "bump": ([0.0, 1.0], [level, hump, level]),
        "sine": ([0.0], [level, wave]),
        "obstacle": (
            [0.0, 0.25, 0.75, 1.0],
            [level, parabola(late, 0.0, z), parabola(late + 0.5 * passing, height, -z),
             parabola(late + passing, 0.0, z), level],
        ),
    }  # fmt: skip
    shares, pieces = shapes[p["road.shape"]]
    return [late + share * passing for share in shares], pieces


@dataclass(frozen=True)
class Axle:
    """Numbers of one axle; the damper's pieces are lines, the corners between them ascending."""

    spring: tuple[float, float]  # rate, cubic
    lines: tuple[tuple[float, float], ...]  # intercept and slope
    corners: tuple[float, ...]
    stops: tuple[tuple[float, float], ...]  # place and stiffness, bump and rebound
    wheel: float  # mass, kg; 0 without
    tyre: tuple[float, float]  # stiffness, damping
    load: float  # at rest, N
    road: Road


def _damper(p: Mapping[str, Any], of: str) -> tuple[Any, Any]:
    """Lines and corners of a damper, from its table of five points or its rates and limits (0: none)."""
    if table := p.get(f"{of}damper.table"):
        points = [tuple(map(float, point.split(":"))) for point in table.split(",")]
        slopes = [(g - f) / (b - a) for (a, f), (b, g) in pairwise(points)]
        lines = [(f - c * a, c) for (a, f), c in zip(points, slopes, strict=False)]
        return tuple(lines), tuple(a for a, _ in points[1:-1])
    bump, rebound, slope = (p[f"{of}damper.{name}"]
                            for name in ("bump_rate", "rebound_rate", "limit_slope"))  # fmt: skip
    low = -(p[f"{of}damper.bump_limit"] or FAR) / bump
    high = (p[f"{of}damper.rebound_limit"] or FAR) / rebound
    ends = (low * (bump - slope), slope), (high * (rebound - slope), slope)
    return (ends[0], (0.0, bump), (0.0, rebound), ends[1]), (low, 0.0, high)


def _axle(p: Mapping[str, Any], of: str, share: float, late: float, wheels: bool) -> Axle:
    """One axle from the public parameters; `share` of the body's mass rests on it."""
    wheel = p[f"{of}unsprung_mass"] if wheels else 0.0
    return Axle(
        (p[f"{of}spring.rate"], p[f"{of}spring.cubic"]),
        *_damper(p, of),
        ((-p[f"{of}bump_stop.gap"], p[f"{of}bump_stop.stiffness"]),
         (p[f"{of}rebound_stop.gap"], p[f"{of}rebound_stop.stiffness"])),
        wheel,
        (p[f"{of}tyre.stiffness"], p[f"{of}tyre.damping"]) if wheels else (0.0, 0.0),
        (share + wheel) * p["gravity"] if wheels else 0.0,
        _road(p, late),
    )  # fmt: skip


class Vehicle:
    """The switched equations of motion of one model; the state is x, w, x', w', works.

    The works are, axle by axle, what the damper and the tyre dissipate and what the road brings in.
    """

    def __init__(self, model: str, p: Mapping[str, Any]) -> None:
        axles, self.wheels = MODELS[model]
        self.by_gap = p.get("contact") != "force"
        self.may_leave = p.get("lift_off", True)
        mass = p["sprung_mass"]
        if axles == 1:
            self.mobility = ((1.0 / mass,),)
            self.axles = [_axle(p, "", mass, 0.0, self.wheels)]
        else:
            a, b, rho2 = p["cg_to_front"], p["cg_to_rear"], p["pitch_radius_of_gyration"] ** 2
            base = a + b
            m1, m2, m3 = (
                part * mass / base**2 for part in (rho2 + b * b, rho2 + a * a, a * b - rho2)
            )
            det = m1 * m2 - m3 * m3
            self.mobility = ((m2 / det, -m3 / det), (-m3 / det, m1 / det))
            self.axles = [
                _axle(p, "front.", mass * b / base, 0.0, self.wheels),
                _axle(p, "rear.", mass * a / base, base / p["speed"], self.wheels),
            ]
        self.names = [""] if axles == 1 else ["front ", "rear "]
        self.n = axles * (2 if self.wheels else 1)
        self.branch = [[2, 0, 0, 0] for _ in self.axles]
        self.mass = p["sprung_mass"]

    @property
    def joints(self) -> list[float]:
        return [t for axle in self.axles for t in axle.road[0]]

    def stretch(self, start: float, end: float) -> None:
        middle = 0.5 * (start + end)
        self.road = [
            axle.road[1][int(np.searchsorted(axle.road[0], middle))] for axle in self.axles
        ]

    def _struts(self, t: Any, s: Any) -> list[tuple[Any, Any, Any, Any]]:
        """For each axle deflection and rate of the strut, and of the tyre (zero without)."""
        found, count = [], len(self.axles)
        for i, road in enumerate(self.road):
            xi, rate = road(t)
            x, v = s[i], s[self.n + i]
            if self.wheels:
                w, vw = s[count + i], s[self.n + count + i]
                found.append((x - w, v - vw, w - xi, vw - rate))
            else:
                found.append((x - xi, v - rate, 0.0, 0.0))
        return found

    def derivative(self, t: float, state: Array) -> list[float]:
        s = state.tolist()
        strut, wheels, works = [], [], []
        for i, (axle, (y, rate, z, z_rate)) in enumerate(
            zip(self.axles, self._struts(t, s), strict=True)
        ):
            piece, bump, rebound, flight = self.branch[i]
            intercept, slope = axle.lines[piece]
            damper = intercept + slope * rate
            force = axle.spring[0] * y + axle.spring[1] * y**3 + damper
            for met, (place, stiffness) in zip((bump, rebound), axle.stops, strict=True):
                force += met * stiffness * (y - place)
            stiffness, damping = axle.tyre
            tyre = axle.load if flight else stiffness * z + damping * z_rate
            strut.append(force)
            if self.wheels:
                wheels.append((force - tyre) / axle.wheel)
            lost = 0.0 if flight else damping * z_rate**2
            pulled = tyre if self.wheels else force
            works += [damper * rate, lost, -pulled * float(self.road[i](t)[1])]
        bodies = [-sum(m * f for m, f in zip(row, strut, strict=True)) for row in self.mobility]
        return [*s[self.n : 2 * self.n], *bodies, *wheels, *works]

    def rooms(self, t: Array, states: Array) -> list[Array]:
        found = []
        for i, (axle, (y, rate, z, z_rate)) in enumerate(
            zip(self.axles, self._struts(t, states), strict=True)
        ):
            piece, bump, rebound, flight = self.branch[i]
            never = np.full(len(t), np.inf)
            found += [
                rate - axle.corners[piece - 1] if piece > 0 else never,
                axle.corners[piece] - rate if piece < 3 else never,
                (axle.stops[0][0] - y) * (1 if bump else -1),
                (y - axle.stops[1][0]) * (1 if rebound else -1),
            ]
            if self.wheels:
                tyre = axle.tyre[0] * z + axle.tyre[1] * z_rate - axle.load
                if self.by_gap and flight:
                    tyre = np.maximum(tyre, axle.tyre[0] * z - axle.load)
                found.append((tyre if flight else -tyre) if self.may_leave else never)
        return found

    def enter(self, exit_: int, t: float, state: Array) -> tuple[str, str]:
        i, k = divmod(exit_, 5 if self.wheels else 4)
        kind = max(0, k - 1)
        branch = self.branch[i]
        branch[kind] = branch[kind] + (1 if k else -1) if kind == DAMPER else 1 - branch[kind]
        return f"{self.names[i]}{ELEMENTS[kind]}", BRANCHES[kind][branch[kind]]


@dataclass(frozen=True)
class Solution:
    """Displacements (m), velocities (m/s), accelerations (m/s2): bodies before wheels, front before rear.

    `works` are at the last instant, J: for each axle dissipated by damper and tyre, brought in by road.
    """

    times: Array
    displacements: NDArray[np.float64]  # (instants, coordinates)
    velocities: NDArray[np.float64]
    accelerations: NDArray[np.float64]
    works: NDArray[np.float64]  # (axles, 3)
    switches: list[Switch]

    @property
    def peak(self) -> float:
        """Largest displacement, m."""
        return float(np.abs(self.displacements).max())

    @property
    def motion(self) -> dict[str, Array]:
        """Displacements and velocities of a quarter car by the names of the package."""
        names = [
            f"{of}_{what}" for what in ("displacement", "velocity") for of in ("body", "wheel")
        ]
        return dict(zip(names, (*self.displacements.T, *self.velocities.T), strict=True))

    def instants(self, element: str, branch: str) -> list[float]:
        """When `element` entered its branch, s."""
        return [s.time for s in self.switches if (s.element, s.branch) == (element, branch)]


def solve(model: str, parameters: Mapping[str, Any], times: Array) -> Solution:
    """A vehicle from rest at times[0] = 0 on the road its parameters describe.

    Parameters
    ----------
    model : key of `MODELS`
    parameters : all that the equations need, by public name, SI units; `road.shape` is `bump`,
        `obstacle` or `sine`, and begins at `road.start` (0 if left out) under the first axle
    times : ascending, s
    """
    vehicle, times = Vehicle(model, parameters), np.asarray(times, dtype=float)
    n = vehicle.n
    rows, rates, switches = integrate(
        vehicle, [0.0] * (2 * n + 3 * len(vehicle.axles)), times, vehicle.joints
    )
    works = rows[-1, 2 * n :].reshape(-1, 3)
    return Solution(times, rows[:, :n], rows[:, n : 2 * n], rates[:, n : 2 * n], works, switches)


def quarter_car(parameters: Mapping[str, Any], times: Array) -> Solution:
    """The quarter car of AP57 section 8 with some parameters changed."""
    return solve("QuarterCar", AP57 | dict(parameters), times)


@cache
def solved(name: str) -> Solution:
    """The motion of one of `CASES`."""
    parameters, duration, count = CASES[name]
    return quarter_car(parameters, np.linspace(0.0, duration, count))
