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
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from quarter_car_data import (
    BLOW_OFF_TABLE,
    COLUMNS,
    DEFAULTS,
    KGF,
    Array,
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
    "COLUMNS",
    "DEFAULTS",
    "KGF",
    "STORED",
    "Car",
    "Event",
    "Reference",
    "car_from",
    "largest_difference",
    "solve",
    "stored",
]

HERE = Path(__file__).resolve().parent

#: What is stored beside this file: parameters that differ from the defaults, s, number of instants.
STORED: dict[str, tuple[dict[str, Value], float, int]] = {
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
    ValueError : unknown parameter or road; times that do not ascend; a cubic spring; a table that
        misses the origin.
    """
    car, instants = car_from(parameters), np.asarray(times, dtype=float)
    if (
        instants.ndim != 1
        or instants.size == 0
        or not all(np.diff(instants, prepend=-1e-300) > 0.0)
    ):
        raise ValueError("times must ascend, and start at 0 or later")
    rows, events = propagate(car, instants)
    return _reference([instants, *rows.T.copy()], events)


def _reference(columns: Sequence[Array], events: list[Event]) -> Reference:
    times, x1, v1, a1, x2, v2, a2, contact = columns
    return Reference(times, x1, v1, a1, x2, v2, a2, contact, events)


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
    """Remake the stored files."""
    switches: dict[str, Any] = {}
    for name, (parameters, duration, count) in STORED.items():
        times = np.linspace(0.0, duration, count)
        exact = solve(parameters, times)
        text = io.StringIO()
        text.write(
            "# Quarter car of AP57 section 8 (M. Apetaur, L. Pust, Aplikace matematiky 2 (1957) "
            "81-104) in SI units, from rest;\n"
            f"# parameters that differ from it: {json.dumps(parameters)}\n"
            "# Made by exact piecewise linear propagation, restarted at every switch. "
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
        print(f"{name}: {len(exact.events)} events")
    _write(HERE / "ap57_events.json", json.dumps(switches, indent=1) + "\n")


if __name__ == "__main__":
    main()
