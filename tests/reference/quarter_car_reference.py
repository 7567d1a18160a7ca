"""Two references for the quarter car, sharing no code with the package they are held against.

    M x1'' + S = 0,   m x2'' - S + T = 0                                  (AP57 eqs. 14, 29)
    S = F(y) + Phi(y'),   y = x1 - x2
    T = c2 (x2 - xi) + k2 (x2' - xi') in contact, (M + m) g in flight     (AP57 eqs. 26 to 32)

Between two switches (contact, damper corner, end stop, corner of a table, joint of the road) the
right-hand side is smooth. Both references keep the branch of every element until its switch, locate
the switch to rounding and start afresh from there:

- `exact`: piecewise linear cars. State, road and a one form an autonomous linear system, carried on
  by its matrix exponential; switches are roots of the exact solution.
- `integrated`: any car. The equations of motion as they stand, by scipy's DOP853 with its own
  events, at a relative tolerance of 1e-13.

Run as a program, it remakes the stored files beside it:

    python tests/reference/quarter_car_reference.py

Sources: AP57 = M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) 81-104; its section 8 gives the
default parameters (1 kgf = 9.80665 N).
"""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, inf, pi, sin, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

Array = NDArray[np.float64]
Value = float | bool | str
Parameters = Mapping[str, Value]

KGF = 9.80665
HERE = Path(__file__).resolve().parent

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

#: What is stored beside this file: parameters that differ from the defaults, s, number of instants.
STORED: dict[str, tuple[dict[str, Value], float, int]] = {
    "ap57_lift_off": ({}, 1.0, 201),
    "ap57_no_lift_off": ({"lift_off": False}, 1.0, 201),
    "ap57_blow_off": ({"damper.table": BLOW_OFF_TABLE}, 2.0, 401),
}


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


COLUMNS = tuple(name for name in Reference.__annotations__ if name != "events")


def largest_difference(one: Reference, other: Reference) -> float:
    """Largest difference of the two displacements at the common instants, relative to the peak."""
    if not np.array_equal(one.times, other.times):
        raise ValueError("references compare at the same instants only")
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
    """Force of one element, piece by piece: c0 + c1 u + c3 u^3, u the `argument` it depends on.

    Branch i lies between corners[i - 1] and corners[i]. For the tyre u is what its contact force
    would be; branch 0 is flight, branch 1 contact, and its forces stand in the equations of motion.
    """

    element: str
    argument: str  # "deflection", "rate" or "contact"
    corners: tuple[float, ...]
    branches: tuple[str, ...]
    coefficients: tuple[tuple[float, float, float], ...]

    def force(self, branch: int, u: float) -> float:
        c0, c1, c3 = self.coefficients[branch]
        return c0 + u * (c1 + u * u * c3)


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
        lines.append((intercept, slope, 0.0))
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
    ValueError : an unknown name or road.
    """
    wanted = {name: v for name, v in parameters.items() if not name.startswith("solver.")}
    if unknown := sorted(set(wanted) - set(DEFAULTS)):
        raise ValueError(f"unknown parameters {unknown}; known are {sorted(DEFAULTS)}")
    p: dict[str, Any] = {**DEFAULTS, **wanted}
    spring = (
        _table("spring", "deflection", p["spring.table"])
        if p["spring.table"]
        else Law("spring", "deflection", (), ("",), ((0.0, p["spring.rate"], p["spring.cubic"]),))
    )
    damper = _table("damper", "rate", p["damper.table"]) if p["damper.table"] else _damper(p)
    weight = (p["sprung_mass"] + p["unsprung_mass"]) * p["gravity"]
    may_leave = bool(p["lift_off"]) and weight > 0.0
    nothing = (0.0, 0.0, 0.0)
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
        tyre=Law(
            "tyre",
            "contact",
            (0.0,) if may_leave else (),
            ("flight", "contact") if may_leave else ("contact",),
            (nothing, nothing) if may_leave else (nothing,),
        ),
        road=_road(p),
    )


def solve(parameters: Parameters, times: ArrayLike, method: str = "") -> Reference:
    """The quarter car from rest in static equilibrium at t = 0.

    Parameters
    ----------
    parameters : by public name, SI units; those not given are AP57 section 8
    times : (n,) ascending instants, s, none negative; where the road's velocity jumps, values are
        those just after
    method : "exact" (piecewise linear cars), "integrated" (any), or empty: exact where possible

    Raises
    ------
    ValueError : unknown parameter, road or method; times that do not ascend; a cubic spring with
        "exact"; a table that misses the origin.
    """
    car, instants = car_from(parameters), np.asarray(times, dtype=float)
    if (
        instants.ndim != 1
        or instants.size == 0
        or not all(np.diff(instants, prepend=-1e-300) > 0.0)
    ):
        raise ValueError("times must ascend, and start at 0 or later")
    curved = any(c3 != 0.0 for law in car.laws for _, _, c3 in law.coefficients)
    if method not in ("", "exact", "integrated"):
        raise ValueError(f"method {method!r}: 'exact' and 'integrated' are known")
    if curved and method == "exact":
        raise ValueError("a cubic spring has no exact propagation; use 'integrated'")
    march = _integrated if curved or method == "integrated" else _exact
    rows, events = march(car, instants)
    return _reference([instants, *rows.T.copy()], events)


def _reference(columns: Sequence[Array], events: list[Event]) -> Reference:
    times, x1, v1, a1, x2, v2, a2, contact = columns
    return Reference(times, x1, v1, a1, x2, v2, a2, contact, events)


def _stretches(car: Car, end: float) -> Iterable[tuple[float, float, RoadPiece]]:
    """Start, end and piece of each stretch of road within [0, end]."""
    joints = [*(piece.start for piece in car.road[1:]), inf]
    for piece, joint in zip(car.road, joints, strict=True):
        start, stop = max(piece.start, 0.0), min(joint, end)
        if joint > 0.0 and start <= end:
            yield start, stop, piece


def _road_events(car: Car, end: float) -> list[Event]:
    return [
        Event(piece.start, "road", previous.name, piece.name)
        for previous, piece in pairwise(car.road)
        if 0.0 < piece.start <= end
    ]


def _switch(t: float, law: Law, before: int, after: int) -> Event:
    return Event(t, law.element, law.branches[before], law.branches[after])


def _contact_jump(car: Car, t: float, before: list[int], after: list[int]) -> list[Event]:
    """At a joint only the contact force can jump, and only where the road's velocity does."""
    changed = before and before[-1] != after[-1]
    return [_switch(t, car.tyre, before[-1], after[-1])] if changed else []


def _refuse_endless_switching(events: Sequence[Event], t: float) -> None:
    if [event.time for event in events[-9:]] == [t] * 9:
        raise RuntimeError(f"switches follow one another without end at {t} s")


def _longest_step(car: Car) -> float:
    """A step in which no argument turns twice: small against the fastest mode and the road, s."""
    stiffness = car.tyre_stiffness + sum(
        max(abs(c1) for _, c1, _ in law.coefficients)
        for law in car.suspension
        if law.argument == "deflection"
    )
    damping = car.tyre_damping + sum(
        max(abs(c1) for _, c1, _ in law.coefficients)
        for law in car.suspension
        if law.argument == "rate"
    )
    mobility = 1.0 / car.body + 1.0 / car.wheel
    fastest = max(
        sqrt(stiffness * mobility), damping * mobility, *(piece.omega for piece in car.road)
    )
    return min(1e-3, 0.1 / fastest)


# --- reference 1: exact propagation -----------------------------------------------------------

# z = (x1, x1', x2, x2', xi, xi', xi'', 1), each in units of UNIT: rates are measured by a typical
# frequency, or the exponential would lose digits between metres and metres per second.
UNIT = np.array([1.0, 1e2, 1.0, 1e2, 1.0, 1e2, 1e4, 1.0])
ONE = np.eye(8)
STATE, ROAD, CONSTANT = slice(0, 4), slice(4, 7), 7


def _exact_forms(car: Car) -> dict[str, Array]:
    """The arguments of the laws as linear forms of z."""
    x1, v1, x2, v2, xi, xi_rate, _, one = ONE
    bracket = car.tyre_stiffness * (x2 - xi) + car.tyre_damping * (v2 - xi_rate)
    return {
        "deflection": x1 - x2,
        "rate": v1 - v2,
        "contact": car.weight * one - bracket,
    }


def _exact_matrix(car: Car, branch: Sequence[int], omega: float) -> Array:
    """z' = A z for one branch of every law, with the road's own equation xi''' = -omega^2 xi'."""
    form, one = _exact_forms(car), ONE[CONSTANT]
    force = np.zeros(8)
    for law, b in zip(car.suspension, branch, strict=False):
        c0, c1, _ = law.coefficients[b]
        force += c0 * one + c1 * form[law.argument]
    in_contact = car.tyre.branches[branch[-1]] == "contact"
    tyre = car.weight * one - form["contact"] if in_contact else car.weight * one
    A = np.zeros((8, 8))
    A[0, 1] = A[2, 3] = A[4, 5] = A[5, 6] = 1.0
    A[6, 5] = -(omega**2)
    A[1] = -force / car.body
    A[3] = (force - tyre) / car.wheel
    return A * UNIT / UNIT[:, None]


def _exact_limits(car: Car, branch: Sequence[int]) -> tuple[Array, list[tuple[int, int]]]:
    """Rows whose product with z is the room left in a branch, with (law, branch entered) at 0."""
    form, one = _exact_forms(car), ONE[CONSTANT]
    rows, beyond = [], []
    for i, (law, b) in enumerate(zip(car.laws, branch, strict=True)):
        if b > 0:
            rows.append(form[law.argument] - law.corners[b - 1] * one)
            beyond.append((i, b - 1))
        if b < len(law.corners):
            rows.append(law.corners[b] * one - form[law.argument])
            beyond.append((i, b + 1))
    return np.array(rows).reshape(-1, 8) * UNIT, beyond


def _exact_branch(car: Car, z: Array, omega: float) -> list[int]:
    """The branch of every law at z; on a corner the first derivative other than zero decides."""
    form = _exact_forms(car)
    branch = [
        int(np.searchsorted(law.corners, form[law.argument] * UNIT @ z, side="right"))
        for law in car.laws
    ]
    A = _exact_matrix(car, branch, omega)
    for i, law in enumerate(car.laws):
        for j, corner in enumerate(law.corners):
            row = (form[law.argument] - corner * ONE[CONSTANT]) * UNIT
            if abs(row @ z) > 1e-13 * (abs(row) @ abs(z)):
                continue
            for _ in range(8):
                row = row @ A
                if abs(row @ z) > 1e-12 * (abs(row) @ abs(z)):
                    branch[i] = j + int(row @ z > 0.0)
                    break
    return branch


def _earliest_exit(A: Array, z: Array, limit: Array, h: float) -> float:
    """First instant in [0, h] at which the room limit @ z(s) falls below zero, or infinity.

    The room turns at most once within h. At 0 it may be zero to rounding if it is about to grow.
    """

    def room(s: float) -> float:
        return float(limit @ expm(A * s) @ z)

    def rate(s: float) -> float:
        return float(limit @ A @ expm(A * s) @ z)

    start, end = 0.0, h
    if room(h) >= 0.0:
        if not rate(0.0) < 0.0 < rate(h):
            return inf
        end = brentq(rate, 0.0, h, xtol=1e-18)  # a dip between two ends that show nothing
        if room(end) >= 0.0:
            return inf
    elif rate(0.0) > 0.0:
        start = brentq(rate, 0.0, h, xtol=1e-18)
    if room(start) <= 0.0:
        return start
    return float(brentq(room, start, end, xtol=1e-18))


def _exact(car: Car, times: Array) -> tuple[Array, list[Event]]:
    """March with matrix exponentials from switch to switch."""
    end, h = float(times[-1]), _longest_step(car)
    events = _road_events(car, end)
    rows = np.empty((len(times), 7))
    z = np.zeros(8)
    z[CONSTANT] = 1.0
    branch: list[int] = []
    for start, stop, piece in _stretches(car, end):
        t = start
        z[ROAD] = np.array(piece.at(t)) / UNIT[ROAD]
        previous, branch = branch, _exact_branch(car, z, piece.omega)
        events += _contact_jump(car, t, previous, branch)
        while True:  # one turn for each branch
            A = _exact_matrix(car, branch, piece.omega)
            limits, beyond = _exact_limits(car, branch)
            rates, step = limits @ A, expm(A * h)
            exits: list[tuple[float, int]] = []
            while t < stop and not exits:
                tau = min(h, stop - t)
                z_next = step @ z if tau == h else expm(A * tau) @ z
                suspects = (limits @ z_next < 0.0) | ((rates @ z < 0.0) & (rates @ z_next > 0.0))
                for row in map(int, np.flatnonzero(suspects)):
                    if (instant := _earliest_exit(A, z, limits[row], tau)) < inf:
                        exits.append((instant, row))
                if exits:
                    tau = min(exits)[0]
                    z_next = expm(A * tau) @ z
                # land on the joint itself, not on a sum of steps
                t_next = stop if not exits and tau == stop - t else t + tau
                first, last = np.searchsorted(times, [t, t_next])
                for j in range(int(first), int(last)):
                    rows[j] = _exact_outputs(car, branch, A, expm(A * (times[j] - t)) @ z)
                t, z = t_next, z_next
            if not exits:
                break
            _refuse_endless_switching(events, t)
            for instant, k in exits:
                if instant == min(exits)[0]:
                    i, after = beyond[k]
                    events.append(_switch(t, car.laws[i], branch[i], after))
                    branch[i] = after
    if times[-1] == t:
        rows[-1] = _exact_outputs(car, branch, A, z)
    return rows, sorted(events)


def _exact_outputs(car: Car, branch: Sequence[int], A: Array, z: Array) -> list[float]:
    x1, v1, x2, v2 = (UNIT * z)[STATE]
    _, a1, _, a2 = (UNIT * (A @ z))[STATE]
    in_contact = car.tyre.branches[branch[-1]] == "contact"
    contact = float(_exact_forms(car)["contact"] * UNIT @ z) if in_contact else 0.0
    return [x1, v1, a1, x2, v2, a2, contact]


# --- reference 2: the equations of motion as they stand, by DOP853 ------------------------------


def _arguments(car: Car, t: float, state: Array, piece: RoadPiece) -> dict[str, float]:
    x1, v1, x2, v2 = (float(value) for value in state)
    xi, xi_rate, _ = piece.at(t)
    return {
        "deflection": x1 - x2,
        "rate": v1 - v2,
        "contact": car.weight - car.tyre_stiffness * (x2 - xi) - car.tyre_damping * (v2 - xi_rate),
    }


def _motion(
    car: Car, branch: Sequence[int], piece: RoadPiece
) -> Callable[[float, Array], list[float]]:
    """Right-hand side for one branch of every law, smooth beyond its corners."""
    laws = list(zip(car.suspension, branch[:-1], strict=True))
    in_contact = car.tyre.branches[branch[-1]] == "contact"

    def derivative(t: float, state: Array) -> list[float]:
        u = _arguments(car, t, state, piece)
        force = sum(law.force(b, u[law.argument]) for law, b in laws)
        tyre = car.weight - u["contact"] if in_contact else car.weight
        return [state[1], -force / car.body, state[3], (force - tyre) / car.wheel]

    return derivative


def _dop853(
    car: Car,
    branch: Sequence[int],
    piece: RoadPiece,
    span: tuple[float, float],
    state: Array,
    *,
    exits: Sequence[Callable[[float, Array], float]] = (),
) -> Any:
    # So short a step makes the dense output, of one order less, as good as the steps themselves.
    solution = solve_ivp(
        _motion(car, branch, piece),
        span,
        state,
        method="DOP853",
        dense_output=True,
        events=list(exits) or None,
        rtol=1e-13,
        atol=1e-15,
        max_step=0.5 * _longest_step(car),
    )
    if not solution.success:
        raise RuntimeError(f"DOP853 stopped at {solution.t[-1]} s: {solution.message}")
    return solution


def _exits(
    car: Car, branch: Sequence[int], piece: RoadPiece
) -> tuple[list[Callable[[float, Array], float]], list[tuple[int, int]]]:
    """Terminal events of scipy: the room left in each branch falls through zero."""
    functions: list[Callable[[float, Array], float]] = []
    beyond: list[tuple[int, int]] = []

    def add(argument: str, sign: float, corner: float) -> None:
        def room(t: float, state: Array) -> float:
            return sign * (_arguments(car, t, state, piece)[argument] - corner)

        room.terminal, room.direction = True, -1.0  # type: ignore[attr-defined]
        functions.append(room)

    for i, (law, b) in enumerate(zip(car.laws, branch, strict=True)):
        if b > 0:
            add(law.argument, 1.0, law.corners[b - 1])
            beyond.append((i, b - 1))
        if b < len(law.corners):
            add(law.argument, -1.0, law.corners[b])
            beyond.append((i, b + 1))
    return functions, beyond


def _integrated_branch(car: Car, t: float, state: Array, piece: RoadPiece) -> list[int]:
    """The branch of every law; for one on a corner, the side on which it is a moment later."""
    u = _arguments(car, t, state, piece)
    branch = [int(np.searchsorted(law.corners, u[law.argument], side="right")) for law in car.laws]
    scale = {"deflection": 1e-15, "rate": 1e-14, "contact": 1e-13 * (1.0 + car.weight)}
    later: dict[str, float] = {}
    for i, law in enumerate(car.laws):
        for j, corner in enumerate(law.corners):
            if abs(u[law.argument] - corner) <= scale[law.argument]:
                if not later:
                    moment = t + 1e-5
                    after = _dop853(car, branch, piece, (t, moment), state).y[:, -1]
                    later = _arguments(car, moment, after, piece)
                branch[i] = j + int(later[law.argument] >= corner)
    return branch


def _integrated(car: Car, times: Array) -> tuple[Array, list[Event]]:
    """March with DOP853 from switch to switch."""
    end = float(times[-1])
    events = _road_events(car, end)
    rows = np.empty((len(times), 7))
    state = np.zeros(4)
    branch: list[int] = []

    def store(
        stretch: slice, branch: Sequence[int], piece: RoadPiece, at: Callable[..., Array]
    ) -> None:
        motion, in_contact = _motion(car, branch, piece), car.tyre.branches[branch[-1]] == "contact"
        for i in range(stretch.start, stretch.stop):
            s = at(times[i])
            _, a1, _, a2 = motion(times[i], s)
            contact = _arguments(car, times[i], s, piece)["contact"] if in_contact else 0.0
            rows[i] = [s[0], s[1], a1, s[2], s[3], a2, contact]

    for start, stop, piece in _stretches(car, end):
        t = start
        previous, branch = branch, _integrated_branch(car, t, state, piece)
        events += _contact_jump(car, t, previous, branch)
        while t < stop:
            motion = _motion(car, branch, piece)
            resting = not any(motion(t, state)) and piece.velocity == 0.0 == piece.acceleration
            if resting:  # on a corner and not moving: scipy would find events for ever
                left, right = np.searchsorted(times, [t, stop])
                store(slice(left, right), branch, piece, lambda _, s=state: s)
                t = stop
                break
            _refuse_endless_switching(events, t)
            functions, beyond = _exits(car, branch, piece)
            solution = _dop853(car, branch, piece, (t, stop), state, exits=functions)
            reached = float(solution.t[-1])
            left, right = np.searchsorted(times, [t, reached])
            store(slice(left, right), branch, piece, solution.sol)
            state = solution.y[:, -1]
            for k, found in enumerate(solution.t_events or ()):
                if len(found) and found[-1] == reached:
                    i, after = beyond[k]
                    events.append(_switch(reached, car.laws[i], branch[i], after))
                    branch[i] = after
            t = reached
    if times[-1] == t:
        store(slice(len(times) - 1, len(times)), branch, piece, lambda _: state)
    return rows, sorted(events)


# --- stored files -----------------------------------------------------------------------------


def stored(name: str) -> Reference:
    """The reference stored under that name, with its events.

    Parameters
    ----------
    name : one of `STORED`
    """
    lines = (HERE / f"{name}.csv").read_text(encoding="ascii").splitlines()
    table = list(csv.reader(line for line in lines if not line.startswith("#")))
    if tuple(table[0]) != COLUMNS:
        raise ValueError(f"{name}.csv has the columns {table[0]}, not {list(COLUMNS)}")
    columns = np.array(table[1:], dtype=float).T
    events = json.loads((HERE / "ap57_events.json").read_text(encoding="ascii"))[name]["events"]
    return _reference(list(columns), [Event(**event) for event in events])


def _write(path: Path, text: str) -> None:
    """Whole or not at all."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="ascii") as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def main() -> None:
    """Remake the stored files and say how well the two references agree."""
    switches: dict[str, Any] = {}
    for name, (parameters, duration, count) in STORED.items():
        times = np.linspace(0.0, duration, count)
        exact, integrated = (solve(parameters, times, m) for m in ("exact", "integrated"))
        difference = largest_difference(exact, integrated)
        text = io.StringIO()
        text.write(
            "# Quarter car of AP57 section 8 (M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) "
            "81-104) in SI units, from rest;\n"
            f"# parameters that differ from it: {json.dumps(parameters)}\n"
            "# Made by exact piecewise linear propagation, restarted at every switch; DOP853 at "
            "rtol 1e-13 agrees\n"
            f"# within {difference:.0e} of the peak. "
            "Remake with: python tests/reference/quarter_car_reference.py\n"
        )
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(COLUMNS)
        values = zip(*(getattr(exact, column).tolist() for column in COLUMNS), strict=True)
        writer.writerows([repr(value) for value in row] for row in values)
        _write(HERE / f"{name}.csv", text.getvalue())
        switches[name] = {
            "parameters": parameters,
            "events": [event._asdict() for event in exact.events],
        }
        print(f"{name}: {len(exact.events)} events, agreement {difference:.1e} of the peak")
    _write(HERE / "ap57_events.json", json.dumps(switches, indent=1) + "\n")


if __name__ == "__main__":
    main()
