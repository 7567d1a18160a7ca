"""Exact propagation of piecewise linear quarter cars, from switch to switch.

State, road and a one form an autonomous linear system, carried on by its matrix exponential; switches
are roots of the exact solution.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from quarter_car_data import (
    Array,
    Car,
    Event,
    contact_jump,
    longest_step,
    refuse_endless_switching,
    road_events,
    stretches,
    switch,
)
from scipy.linalg import expm
from scipy.optimize import brentq

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
        "gap": x2 - xi - car.weight / car.tyre_stiffness * one,
    }


def _exact_matrix(car: Car, branch: Sequence[int], omega: float) -> Array:
    """z' = A z for one branch of every law, with the road's own equation xi''' = -omega^2 xi'."""
    form, one = _exact_forms(car), ONE[CONSTANT]
    force = np.zeros(8)
    for law, b in zip(car.suspension, branch, strict=False):
        c0, c1 = law.coefficients[b]
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
        for argument, side, corner, after in law.exits(b):
            rows.append(side * (form[argument] - corner * one))
            beyond.append((i, after))
    return np.array(rows).reshape(-1, 8) * UNIT, beyond


def _exact_branch(car: Car, z: Array, omega: float) -> list[int]:
    """The branch of every law at z; on a corner the first derivative other than zero decides."""
    form = _exact_forms(car)
    arguments = {name: float(row * UNIT @ z) for name, row in form.items()}
    branch = [law.at(arguments) for law in car.laws]
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


def propagate(car: Car, times: Array) -> tuple[Array, list[Event]]:
    """Go on by matrix exponentials from switch to switch."""
    end, h = float(times[-1]), longest_step(car)
    events = road_events(car, end)
    rows = np.empty((len(times), 7))
    z = np.zeros(8)
    z[CONSTANT] = 1.0
    branch: list[int] = []
    for start, stop, piece in stretches(car, end):
        t = start
        z[ROAD] = np.array(piece.at(t)) / UNIT[ROAD]
        previous, branch = branch, _exact_branch(car, z, piece.omega)
        events += contact_jump(car, t, previous, branch)
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
            refuse_endless_switching(events, t)
            for instant, k in exits:
                if instant == min(exits)[0]:
                    i, after = beyond[k]
                    events += switch(t, car.laws[i], branch[i], after)
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
