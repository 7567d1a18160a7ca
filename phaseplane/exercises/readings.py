"""A student's readings: the state points of a construction, read off the sheet."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from math import isfinite

from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.steps import States
from phaseplane.equations.typeset import read
from phaseplane.exercises.protocol import display, displayed, point_of


@dataclass(frozen=True, slots=True)
class Reading:
    """The reading of one point.

    Parameters
    ----------
    number : of the point, from 0
    states : the state points on the sheet, m of paper, one for each plane
    feet : the feet D of their normals, if they were read
    """

    number: int
    states: States
    feet: States | None = None


def columns(planes: Sequence[Plane]) -> list[str]:
    """Return the columns of readings: the number of the point, its coordinates and its D, by plane.

    Values are on the axes of the plane, displacements in m in cm.
    """
    named = [
        (plane, name)
        for plane in planes
        for name in (plane.displacement.label, f"{plane.displacement.label}_bar")
    ]
    named += [(plane, plane.foot) for plane in planes]
    units = (display(plane.displacement)[1] for plane, _ in named)
    heads = zip(named, units, strict=True)
    return ["point", *(f"{name} [{unit}]" if unit else name for (_, name), unit in heads)]


def blank_readings(drawing: Drawing, steps: int) -> str:
    """Return a CSV to fill in, with the start point."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns(drawing.planes))
    first = drawing.frames[0]
    states = [first.points[plane.state] for plane in drawing.planes]
    start = [f"{value:.6g}" for value in displayed(drawing.planes, states)]
    blank = [""] * len(drawing.planes)
    writer.writerow(["0", *start, *blank])
    for number in range(1, steps + 1):
        writer.writerow([str(number), *[""] * (3 * len(drawing.planes))])
    return out.getvalue()


def is_filled_in(text: str) -> bool:
    """Return whether a table of readings has any beyond its start point."""
    rows = (re.split("[,;\t]", line) for line in text.splitlines()[2:])
    return any(cell.strip() for row in rows for cell in row[1:])


def read_readings(text: str, planes: Sequence[Plane]) -> list[Reading]:
    """Read a CSV of readings: with commas, semicolons or tabs, and decimal points or (in quotes) commas.

    Powers of ten may be written as on the sheet: 9.61·10⁻¹⁰. Rows that are not filled in are left out
    at the end.

    Raises
    ------
    ValueError : if columns are missing or in other units, a value is not a number, or points do not
        follow each other.
    """
    lines = [line for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    if not lines:
        raise ValueError("no readings")
    delimiter = next((mark for mark in ";\t" if mark in lines[0]), ",")
    rows = list(csv.reader(lines, delimiter=delimiter))
    wanted = columns(planes)
    units = dict(map(_name_and_unit, wanted))
    head = []
    for given in rows[0]:
        name, unit = _name_and_unit(given)
        if unit and unit != units.get(name, unit):
            right = f"in {units[name]}" if units[name] else "without a unit"
            raise ValueError(f"column {given!r}: must be {right}")
        head.append(name)
    needed = [*units][: 1 + 2 * len(planes)]
    missing = [name for name in needed if name not in head]
    if missing:
        raise ValueError(f"no column {missing[0]!r}; the table needs {', '.join(wanted)}")
    found: list[Reading] = []
    for line, row in enumerate(rows[1:], 2):
        if any(row[len(head) :]):
            raise ValueError(
                f"line {line}: {len(row)} values for {len(head)} columns; numbers with decimal commas "
                "need semicolons between the columns"
            )
        cells = dict(zip(head, [cell.strip() for cell in row], strict=False))
        values = [cells.get(name, "") for name in needed[1:]]
        if not any(values):
            continue
        number = _number(cells.get("point", ""), line, "point")
        if number != len(found):
            raise ValueError(
                f"line {line}: point {number:g} follows point {len(found) - 1}; points must be "
                "complete and in order, from 0"
            )
        numbers = [
            _number(value, line, name) for name, value in zip(needed[1:], values, strict=True)
        ]
        states = tuple(map(point_of, planes, numbers[::2], numbers[1::2]))
        feet_read = [cells.get(plane.foot, "") for plane in planes]
        feet = None
        if any(feet_read):
            feet = tuple(
                point_of(plane, _number(value, line, plane.foot))
                for plane, value in zip(planes, feet_read, strict=True)
            )
        found.append(Reading(len(found), states, feet))
    if len(found) < 2:
        raise ValueError("only point 0 is filled in; at least the points 0 and 1 are needed")
    return found


def _name_and_unit(head: str) -> tuple[str, str]:
    name, _, unit = head.partition("[")
    return name.strip(), unit.strip(" ]")


def _number(text: str, line: int, name: str) -> float:
    try:
        value = read(text.replace(",", "."))
    except ValueError:
        raise ValueError(f"line {line}: {name} = {text!r} is not a number") from None
    if not isfinite(value):
        raise ValueError(f"line {line}: {name} = {text!r} must be finite")
    return value
