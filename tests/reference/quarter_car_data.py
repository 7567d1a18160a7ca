"""The quarter car of the references as data: numbers, switched laws, road, and what comes out.

AP57 = M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) 81-104; its section 8 gives the default
parameters (1 kgf = 9.80665 N).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, inf, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Value = float | bool | str
Parameters = Mapping[str, Value]

KGF = 9.80665

#: AP57 section 8 in SI units.
DEFAULTS: dict[str, Value] = {
    "sprung_mass": 30.0 * KGF,
    "unsprung_mass": 3.0 * KGF,
    "spring.rate": 1500.0 * KGF,
    "spring.cubic": 0.0,
    "spring.table": "",
    "damper.rebound_rate": 200.0 * KGF,
    "damper.bump_rate": 50.0 * KGF,
    "damper.rebound_limit": 0.0,
    "damper.bump_limit": 0.0,
    "damper.limit_slope": 0.0,
    "damper.table": "",
    "tyre.stiffness": 15000.0 * KGF,
    "tyre.damping": 100.0 * KGF,
    "bump_stop.gap": 0.08,
    "bump_stop.stiffness": 0.0,
    "rebound_stop.gap": 0.08,
    "rebound_stop.stiffness": 0.0,
    "lift_off": True,
    "contact": "gap",
    "gravity": 9.80665,
    "road.shape": "bump",
    "road.height": 0.05,
    "road.length": 1.0,
    "road.start": 0.0,
    "road.table": "",
    "speed": 20.0,
}

#: AP57 section 8 with a damper whose slope falls to a fifth beyond +0.30 m/s and -0.60 m/s.
BLOW_OFF_TABLE = ", ".join(
    f"{rate}:{force!r}"
    for rate, force in (
        (-1.6, -(0.6 + 1.0 / 5.0) * 50.0 * KGF),
        (-0.6, -0.6 * 50.0 * KGF),
        (0.0, 0.0),
        (0.3, 0.3 * 200.0 * KGF),
        (1.3, (0.3 + 1.0 / 5.0) * 200.0 * KGF),
    )
)


# --- what comes out ---------------------------------------------------------------------------


class Event(NamedTuple):
    """An element changes branch: instant in s, name of the element, branch left, branch entered."""

    time: float
    element: str
    before: str
    after: str


@dataclass(frozen=True)
class Reference:
    """A solution at the wanted instants, SI units, displacements from static equilibrium.

    `contact_force` is the force of the road on the tyre; with lift-off it is never negative.
    """

    times: Array
    body_displacement: Array
    body_velocity: Array
    body_acceleration: Array
    wheel_displacement: Array
    wheel_velocity: Array
    wheel_acceleration: Array
    contact_force: Array
    events: list[Event]

    @property
    def peak(self) -> float:
        """Largest displacement of either mass, m."""
        return float(max(abs(self.body_displacement).max(), abs(self.wheel_displacement).max()))

    def instants(self, element: str, after: str) -> list[float]:
        """When `element` entered its branch `after`, s."""
        return [e.time for e in self.events if (e.element, e.after) == (element, after)]


def largest_difference(one: Reference, other: Reference) -> float:
    """Largest difference of the two displacements at the common instants, relative to the peak."""
    differences = (
        abs(getattr(one, name) - getattr(other, name)).max()
        for name in ("body_displacement", "wheel_displacement")
    )
    return float(max(differences)) / one.peak


# --- the car as data --------------------------------------------------------------------------


class RoadPiece(NamedTuple):
    """From `start` on, xi''' = -omega^2 xi', with the road's state at `start`."""

    start: float
    name: str
    elevation: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    omega: float = 0.0

    def at(self, t: float) -> tuple[float, float, float]:
        """Elevation, velocity and acceleration at t, in closed form."""
        if self.velocity == 0.0 == self.acceleration:
            return self.elevation, 0.0, 0.0
        s, w = t - self.start, self.omega
        if w == 0.0:
            return (
                self.elevation + s * (self.velocity + 0.5 * s * self.acceleration),
                self.velocity + s * self.acceleration,
                self.acceleration,
            )
        c, d = cos(w * s), sin(w * s)
        half = sin(0.5 * w * s)
        return (
            self.elevation + self.acceleration / w**2 * 2.0 * half**2 + self.velocity / w * d,
            self.acceleration / w * d + self.velocity * c,
            self.acceleration * c - self.velocity * w * d,
        )


@dataclass(frozen=True)
class Law:
    """Force of one element, piece by piece: c0 + c1 u, u the `argument` it depends on.

    Branch i lies between corners[i - 1] and corners[i]. For the tyre u is what its contact force
    would be; branch 0 is flight, branch 1 contact, and its forces stand in the equations of motion.
    Its contact by gap, the deflection beyond the free length, is `TyreAcrossGap`.
    """

    element: str
    argument: str  # "deflection", "rate" or "contact"
    corners: tuple[float, ...]
    branches: tuple[str, ...]
    coefficients: tuple[tuple[float, float], ...]

    def at(self, arguments: Mapping[str, float]) -> int:
        """The branch at a state; on a corner the upper one."""
        return int(np.searchsorted(self.corners, arguments[self.argument], side="right"))

    def exits(self, branch: int) -> list[tuple[str, float, float, int]]:
        """How a branch is left: argument, side (1 downwards), bound, and the branch entered."""
        found = []
        if branch > 0:
            found.append((self.argument, 1.0, self.corners[branch - 1], branch - 1))
        if branch < len(self.corners):
            found.append((self.argument, -1.0, self.corners[branch], branch + 1))
        return found


@dataclass(frozen=True)
class TyreAcrossGap(Law):
    """The tyre that has no force across a gap: in flight above the road, or while it extends slowly.

    Branch 0 is flight with a gap below, branch 1 flight at less than the free length, where spring and
    damper together would pull, branch 2 contact.
    """

    def at(self, arguments: Mapping[str, float]) -> int:
        if arguments["gap"] > 0.0:
            return 0
        return 2 if arguments["contact"] > 0.0 else 1

    def exits(self, branch: int) -> list[tuple[str, float, float, int]]:
        if branch == 0:
            return [("gap", 1.0, 0.0, 2)]
        if branch == 1:
            return [("gap", -1.0, 0.0, 0), ("contact", -1.0, 0.0, 2)]
        return [("contact", 1.0, 0.0, 1)]


@dataclass(frozen=True)
class Car:
    """Numbers of the equations of motion, and the switched elements."""

    body: float
    wheel: float
    tyre_stiffness: float
    tyre_damping: float
    weight: float
    suspension: tuple[Law, ...]
    tyre: Law
    road: tuple[RoadPiece, ...]

    @property
    def laws(self) -> tuple[Law, ...]:
        return (*self.suspension, self.tyre)


def _polyline(
    element: str,
    argument: str,
    corners: Sequence[tuple[float, float]],
    slopes: Sequence[float],
    branches: Sequence[str],
) -> Law:
    """Straight pieces through corners and origin; a corner that does not bend is no switch."""
    kept: list[tuple[float, float]] = []
    names, rates = [branches[0]], [slopes[0]]
    for corner, slope, name in zip(corners, slopes[1:], branches[1:], strict=True):
        if slope == rates[-1]:
            names[-1] = f"{names[-1]}/{name}".strip("/")
            continue
        kept.append(corner)
        names.append(name)
        rates.append(slope)
    edges = (-inf, *(x for x, _ in kept), inf)
    lines = []
    for i, slope in enumerate(rates):
        x, f = (kept or corners)[max(i - 1, 0)]
        intercept = f - slope * x
        if edges[i] <= 0.0 <= edges[i + 1]:
            if abs(intercept) > 1e-9 * abs(f):
                raise ValueError(f"{element}: the force at 0 is {intercept} N and must be 0")
            intercept = 0.0  # to the last bit, or rest would not be rest
        lines.append((intercept, slope))
    return Law(element, argument, edges[1:-1], tuple(names), tuple(lines))


def _pairs(text: str) -> list[tuple[float, float]]:
    return [(float(x), float(f)) for x, f in (pair.split(":") for pair in text.split(","))]


def _table(element: str, argument: str, text: str) -> Law:
    """A measured characteristic; beyond its ends the outer slopes go on."""
    points = _pairs(text)
    slopes = [(g - f) / (b - a) for (a, f), (b, g) in pairwise(points)]
    names = [f"piece {i}" for i in range(len(slopes))]
    # the outer slope before the first point is that of the first piece: no corner there
    return _polyline(element, argument, points[:-1], [slopes[0], *slopes], ["", *names])


def _damper(p: dict[str, Any]) -> Law:
    """Rebound and bump rate, and blow-off: beyond the limit force the slope is the limit slope."""
    corners, slopes = [(0.0, 0.0)], [p["damper.bump_rate"], p["damper.rebound_rate"]]
    names = ["bump", "rebound"]
    if p["damper.bump_limit"] > 0.0 and p["damper.bump_rate"] > 0.0:
        limit = -p["damper.bump_limit"]
        corners.insert(0, (limit / p["damper.bump_rate"], limit))
        slopes.insert(0, p["damper.limit_slope"])
        names.insert(0, "bump blow-off")
    if p["damper.rebound_limit"] > 0.0 and p["damper.rebound_rate"] > 0.0:
        limit = p["damper.rebound_limit"]
        corners.append((limit / p["damper.rebound_rate"], limit))
        slopes.append(p["damper.limit_slope"])
        names.append("rebound blow-off")
    return _polyline("damper", "rate", corners, slopes, names)


def _stop(name: str, at: float, stiffness: float) -> Law:
    below, above = ("engaged", "free") if at <= 0.0 and name == "bump_stop" else ("free", "engaged")
    slopes = [stiffness if branch == "engaged" else 0.0 for branch in (below, above)]
    return _polyline(name, "deflection", [(at, 0.0)], slopes, [below, above])


def _road(p: dict[str, Any]) -> tuple[RoadPiece, ...]:
    start, height = p["road.start"], p["road.height"]
    duration = p["road.length"] / p["speed"]
    turn = 2.0 * pi / duration
    level = RoadPiece(-inf, "level")
    shape = p["road.shape"]
    if shape == "flat":
        return (level,)
    if shape == "bump":  # (height / 2)(1 - cos(2 pi t / T))
        hump = RoadPiece(start, "bump", acceleration=0.5 * height * turn**2, omega=turn)
        return (level, hump, level._replace(start=start + duration))
    if shape == "obstacle":  # AP57 eqs. 9 and 10: |xi''| = 16 height / T^2, signs +, -, +
        z = 16.0 * height / duration**2
        half, steepest, quarter = 0.5 * height, 0.25 * z * duration, 0.25 * duration
        return (
            level,
            RoadPiece(start, "rise", 0.0, 0.0, z),
            RoadPiece(start + quarter, "crest", half, steepest, -z),
            RoadPiece(start + 3.0 * quarter, "fall", half, -steepest, z),
            level._replace(start=start + duration),
        )
    if shape == "sine":
        return (level, RoadPiece(start, "sine", velocity=0.5 * height * turn, omega=turn))
    if shape == "table":
        points = [(start + x / p["speed"], z) for x, z in _pairs(p["road.table"])]
        slopes = [(b - a) / (u - t) for (t, a), (u, b) in pairwise(points)]
        return (
            RoadPiece(-inf, "before", points[0][1]),
            *(
                RoadPiece(t, f"piece {i}", z, slope)
                for i, ((t, z), slope) in enumerate(zip(points, [*slopes, 0.0], strict=True))
            ),
        )
    raise ValueError(f"road.shape = {shape!r}: flat, bump, obstacle, sine and table are known")


def car_from(parameters: Parameters) -> Car:
    """The car with the given parameters, the others as in AP57 section 8.

    Parameters
    ----------
    parameters : by public name, SI; `solver.` parameters mean nothing here and are passed over

    Raises
    ------
    ValueError : an unknown name or road; a cubic spring.
    """
    wanted = {name: v for name, v in parameters.items() if not name.startswith("solver.")}
    if unknown := sorted(set(wanted) - set(DEFAULTS)):
        raise ValueError(f"unknown parameters {unknown}; known are {sorted(DEFAULTS)}")
    p: dict[str, Any] = {**DEFAULTS, **wanted}
    if p["spring.cubic"]:
        raise ValueError("a cubic spring has no exact propagation; use vehicle_reference")
    spring = (
        _table("spring", "deflection", p["spring.table"])
        if p["spring.table"]
        else Law("spring", "deflection", (), ("",), ((0.0, p["spring.rate"]),))
    )
    damper = _table("damper", "rate", p["damper.table"]) if p["damper.table"] else _damper(p)
    weight = (p["sprung_mass"] + p["unsprung_mass"]) * p["gravity"]
    may_leave = bool(p["lift_off"]) and weight > 0.0
    return Car(
        body=p["sprung_mass"],
        wheel=p["unsprung_mass"],
        tyre_stiffness=p["tyre.stiffness"],
        tyre_damping=p["tyre.damping"],
        weight=weight,
        suspension=(
            spring,
            damper,
            _stop("bump_stop", -p["bump_stop.gap"], p["bump_stop.stiffness"]),
            _stop("rebound_stop", p["rebound_stop.gap"], p["rebound_stop.stiffness"]),
        ),
        tyre=_tyre(str(p["contact"]) if may_leave else ""),
        road=_road(p),
    )


def _tyre(rule: str) -> Law:
    """The tyre by its rule of contact, which is empty where it is held to the road."""
    nothing = (0.0, 0.0)
    if rule == "gap":
        return TyreAcrossGap("tyre", "contact", (), ("flight", "flight", "contact"), 3 * (nothing,))
    if rule == "force":
        return Law("tyre", "contact", (0.0,), ("flight", "contact"), 2 * (nothing,))
    if rule:
        raise ValueError(f"contact = {rule!r}: gap and force are known")
    return Law("tyre", "contact", (), ("contact",), (nothing,))


def stretches(car: Car, end: float) -> Iterable[tuple[float, float, RoadPiece]]:
    """Start, end and piece of each stretch of road within [0, end]."""
    joints = [*(piece.start for piece in car.road[1:]), inf]
    for piece, joint in zip(car.road, joints, strict=True):
        start, stop = max(piece.start, 0.0), min(joint, end)
        if joint > 0.0 and start <= end:
            yield start, stop, piece


def road_events(car: Car, end: float) -> list[Event]:
    return [
        Event(piece.start, "road", previous.name, piece.name)
        for previous, piece in pairwise(car.road)
        if 0.0 < piece.start <= end
    ]


def switch(t: float, law: Law, before: int, after: int) -> list[Event]:
    """The event of a branch entered; none between two that bear one name."""
    names = law.branches[before], law.branches[after]
    return [Event(t, law.element, *names)] if names[0] != names[1] else []


def contact_jump(car: Car, t: float, before: list[int], after: list[int]) -> list[Event]:
    """At a joint only the contact force can jump, and only where the road's velocity does."""
    return switch(t, car.tyre, before[-1], after[-1]) if before else []


def refuse_endless_switching(events: Sequence[Event], t: float) -> None:
    if [event.time for event in events[-9:]] == [t] * 9:
        raise RuntimeError(f"switches follow one another without end at {t} s")


def longest_step(car: Car) -> float:
    """A step in which no argument turns twice: small against the fastest mode and the road, s."""
    stiffness = car.tyre_stiffness + sum(
        max(abs(c1) for _, c1 in law.coefficients)
        for law in car.suspension
        if law.argument == "deflection"
    )
    damping = car.tyre_damping + sum(
        max(abs(c1) for _, c1 in law.coefficients)
        for law in car.suspension
        if law.argument == "rate"
    )
    mobility = 1.0 / car.body + 1.0 / car.wheel
    fastest = max(
        sqrt(stiffness * mobility), damping * mobility, *(piece.omega for piece in car.road)
    )
    return min(1e-3, 0.1 / fastest)
