"""A reference for the half car with tyres, sharing no code with the package it is held against.

    M1 x1'' + M3 x2'' + S1 = 0,   M3 x1'' + M2 x2'' + S2 = 0               (AP57 eqs. 1, 33, 34)
    m_i w_i'' - S_i + T_i = 0,    S_i = F_i(x_i - w_i) + Phi_i(x_i' - w_i') + stops
    T_i = c (w_i - xi_i) + k (w_i' - xi_i') on the road, the static axle load in flight (eqs. 26, 29)

Every element keeps its branch until its switch (damper corner, end stop, contact), which ends a run
of scipy's DOP853 as a terminal event; the next run starts there. So do the ends of the bump. The
direction of an event is that in which the branch is left, so that none repeats at its own instant.

Source: AP57 = M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) 81-104.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
GRAVITY = 9.80665


@dataclass(frozen=True)
class Axle:
    """One axle in SI units; damper slopes from far bump to far rebound, with the corners between."""

    wheel: float
    tyre: tuple[float, float]  # stiffness, damping
    spring: tuple[float, float]  # rate, cubic
    slopes: tuple[float, float, float, float]
    corners: tuple[float, float, float]
    stops: tuple[float, float, float, float]  # bump gap and stiffness, rebound gap and stiffness


@dataclass(frozen=True)
class Car:
    """The whole half car on a 1 - cos bump that its front wheel reaches at t = 0."""

    mass: float
    gyration: float
    to_front: float
    to_rear: float
    axles: tuple[Axle, Axle]
    speed: float
    height: float
    length: float


def _bump(car: Car, delay: float, late: Callable[[], float]) -> Callable[[float], tuple]:
    """Elevation and velocity of a bump; `late` says in which stretch of time we are."""
    rate = 2.0 * pi * car.speed / car.length

    def road(t: float) -> tuple[float, float]:
        if not delay < late() < delay + car.length / car.speed:
            return 0.0, 0.0
        angle = rate * (t - delay)
        return 0.5 * car.height * (1.0 - cos(angle)), 0.5 * car.height * rate * sin(angle)

    return road


def solve(car: Car, times: Array) -> tuple[Array, list[tuple[float, str]]]:
    """Displacements (front body, rear body, front wheel, rear wheel) at the given instants.

    Returns
    -------
    Array of shape (4, len(times)), m; and every loss of contact and return, as (instant, what).
    """
    base = car.to_front + car.to_rear
    a, b, rho2 = car.to_front, car.to_rear, car.gyration**2
    body = (car.mass / base**2) * np.array(
        [[rho2 + b * b, a * b - rho2], [a * b - rho2, rho2 + a * a]]
    )
    inverse = np.linalg.inv(body)
    loads = [(car.mass * part / base + axle.wheel) * GRAVITY
             for part, axle in zip((b, a), car.axles, strict=True)]  # fmt: skip
    middle = [0.0]
    roads = [_bump(car, delay, lambda: middle[0]) for delay in (0.0, base / car.speed)]
    # per axle: damper piece 0 to 3; bump stop met, rebound stop met, in flight: 0 or 1
    branch = [[2, 0, 0, 0], [2, 0, 0, 0]]

    def damper(axle: Axle, piece: int, rate: float) -> float:
        low, zero, high = axle.corners
        far_bump, bump, rebound, far_rebound = axle.slopes
        return (
            bump * low + far_bump * (rate - low),
            bump * (rate - zero),
            rebound * (rate - zero),
            rebound * high + far_rebound * (rate - high),
        )[piece]

    def tyre(i: int, t: float, s: Array) -> float:
        elevation, velocity = roads[i](t)
        stiffness, damping = car.axles[i].tyre
        return stiffness * (s[2 + i] - elevation) + damping * (s[6 + i] - velocity)

    def derivative(t: float, s: Array) -> Array:
        strut, wheels = [], []
        for i, axle in enumerate(car.axles):
            y, rate = s[i] - s[2 + i], s[4 + i] - s[6 + i]
            piece, bump, rebound, flight = branch[i]
            force = axle.spring[0] * y + axle.spring[1] * y**3 + damper(axle, piece, rate)
            force += bump * axle.stops[1] * (y + axle.stops[0])
            force += rebound * axle.stops[3] * (y - axle.stops[2])
            strut.append(force)
            wheels.append((force - (loads[i] if flight else tyre(i, t, s))) / axle.wheel)
        return np.concatenate((s[4:], -inverse @ strut, wheels))

    def events() -> list[tuple[Callable[[float, Array], float], int, int, int]]:
        """What may end the present branches: function, direction, and the branch then entered."""
        found = []
        for i, axle in enumerate(car.axles):
            piece, bump, rebound, flight = branch[i]

            def rate_at(corner: float, i: int = i) -> Callable[[float, Array], float]:
                return lambda t, s: s[4 + i] - s[6 + i] - corner

            def deflection_at(corner: float, i: int = i) -> Callable[[float, Array], float]:
                return lambda t, s: s[i] - s[2 + i] - corner

            if piece < 3:
                found.append((rate_at(axle.corners[piece]), 1, i, 0, piece + 1))
            if piece > 0:
                found.append((rate_at(axle.corners[piece - 1]), -1, i, 0, piece - 1))
            found.append((deflection_at(-axle.stops[0]), 1 if bump else -1, i, 1, 1 - bump))
            found.append((deflection_at(axle.stops[2]), -1 if rebound else 1, i, 2, 1 - rebound))
            contact = lambda t, s, i=i: tyre(i, t, s) - loads[i]  # noqa: E731
            found.append((contact, -1 if flight else 1, i, 3, 1 - flight))
        return found

    passing = car.length / car.speed
    joints = sorted({0.0, passing, base / car.speed, base / car.speed + passing, times[-1]})
    states, contacts, t, state = np.zeros((4, len(times))), [], 0.0, np.zeros(8)
    while t < times[-1]:
        end = min(joint for joint in joints if joint > t)
        middle[0] = 0.5 * (t + end)
        possible = events()
        watched = []
        for function, direction, *_ in possible:
            watch = lambda t, s, f=function: f(t, s)  # noqa: E731
            watch.terminal, watch.direction = True, direction  # type: ignore[attr-defined]
            watched.append(watch)
        run = solve_ivp(
            derivative, (t, end), state, "DOP853", events=watched, dense_output=True,
            rtol=1e-12, atol=1e-14, max_step=1e-3,
        )  # fmt: skip
        inside = (times >= t) & (times <= run.t[-1])
        if inside.any():
            states[:, inside] = run.sol(times[inside])[:4]
        t, state = run.t[-1], run.y[:, -1]
        for (_, _, i, kind, new), instants in zip(possible, run.t_events, strict=True):
            if len(instants):
                branch[i][kind] = new
                if kind == 3:
                    side = ("front", "rear")[i]
                    contacts.append((t, f"{side} {'lift-off' if new else 'touchdown'}"))
    return states, contacts
