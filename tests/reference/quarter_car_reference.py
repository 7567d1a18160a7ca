"""A reference for the quarter car, sharing no code with the package it is held against.

    M x1'' + S = 0,   m x2'' - S + T = 0                                  (AP57 eqs. 14, 29)
    S = F(y) + Phi(y'),   y = x1 - x2
    T = c2 (x2 - xi) + k2 (x2' - xi') in contact, (M + m) g in flight     (AP57 eqs. 26 to 32)

Contact ends where N = (M + m) g - T falls to zero. With `contact` = gap it begins where x2 - xi falls
below x2st = (M + m) g / c2 or, while it is below, where N would become positive; with `force` where N
would become positive, across a gap as well (eq. 28 for both ends).

Between two switches (contact, damper corner, end stop, corner of a table, joint of the road) the
right-hand side is linear. Every element keeps its branch until its switch, which is a root of the exact
solution by matrix exponentials (`quarter_car_exact`). Cars with a cubic spring: see `vehicle_reference`.

Sources: AP57 = M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) 81-104; its section 8 gives the
default parameters (1 kgf = 9.80665 N).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from quarter_car_data import (
    BLOW_OFF_TABLE,
    DEFAULTS,
    KGF,
    Car,
    Event,
    Parameters,
    Reference,
    Value,
    car_from,
    largest_difference,
)
from quarter_car_exact import propagate

__all__ = [
    "BLOW_OFF_TABLE",
    "CASES",
    "DEFAULTS",
    "KGF",
    "Car",
    "Event",
    "Reference",
    "car_from",
    "largest_difference",
    "solve",
    "solved",
]

#: The worked example and its relatives: parameters that differ from it, s, number of instants.
CASES: dict[str, tuple[dict[str, Value], float, int]] = {
    "ap57_lift_off": ({}, 1.0, 201),
    "ap57_contact_by_force": ({"contact": "force"}, 1.0, 201),
    "ap57_no_lift_off": ({"lift_off": False}, 1.0, 201),
    "ap57_blow_off": ({"damper.table": BLOW_OFF_TABLE}, 2.0, 401),
}


def solve(parameters: Parameters, times: ArrayLike) -> Reference:
    """The quarter car from rest in static equilibrium at t = 0.

    Parameters
    ----------
    parameters : by public name, SI units; those not given are AP57 section 8
    times : (n,) ascending instants, s, none negative; where the road's velocity jumps, values are
        those just after

    Raises
    ------
    ValueError : unknown parameter or road; a cubic spring; a table that misses the origin.
    """
    car, instants = car_from(parameters), np.asarray(times, dtype=float)
    rows, events = propagate(car, instants)
    return Reference(instants, *rows.T.copy(), events)


@cache
def solved(name: str) -> Reference:
    """The motion of one of `CASES`."""
    parameters, duration, count = CASES[name]
    return solve(parameters, np.linspace(0.0, duration, count))
