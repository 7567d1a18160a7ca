"""The quantities of variables, and the units in which they are shown, the same on every canvas."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity and its display unit."""

    name: str
    unit: str  # in which it is shown
    factor: float  # number of these in the SI unit
    si: str
    endings: tuple[str, ...] = ()  # of the names of its variables


_DEGREES = 57.29577951308232
CENTIMETRES = Quantity(
    "displacement", "cm", 100.0, "m", ("displacement", "deflection", "elevation", "drift", "_set")
)
QUANTITIES = (
    CENTIMETRES,
    Quantity("velocity", "m/s", 1.0, "m/s", ("velocity", "_rate")),
    Quantity("acceleration", "m/s²", 1.0, "m/s2", ("acceleration",)),
    Quantity("angle", "°", _DEGREES, "rad", ("angle",)),
    Quantity("angular velocity", "rad/s", 1.0, "rad/s"),
    Quantity("angular acceleration", "rad/s²", 1.0, "rad/s2"),
    Quantity("force", "N", 1.0, "N", ("force",)),
    Quantity("energy", "J", 1.0, "J", ("energy",)),
)
RADIANS = Quantity("angle", "rad", 1.0, "rad")
_LENGTHS = ((2.0, "m", 1.0), (0.01, "cm", 100.0), (0.0, "mm", 1000.0))


def display_unit(unit: str, span: float) -> tuple[str, float]:
    """Return the unit in which values over this span are shown, and its number in one `unit`."""
    if unit != "m":
        return unit_text(unit), 1.0
    return next((name, factor) for least, name, factor in _LENGTHS if span >= least)


def unit_of_columns(unit: str, columns: Iterable[npt.ArrayLike]) -> tuple[str, float]:
    """Return the unit in which columns are shown together, and its number in one `unit`."""
    import numpy as np  # noqa: PLC0415  (the page of exercises needs the standard library alone)

    values = np.concatenate([np.zeros(0), *(np.asarray(column, float) for column in columns)])
    values = values[np.isfinite(values)]
    return display_unit(unit, float(np.ptp(values)) if values.size else 0.0)


def in_range(quantity: Quantity, columns: Iterable[npt.ArrayLike]) -> Quantity:
    """Return a quantity in the unit in which columns are shown together, if it is a length."""
    if quantity.si != "m":
        return quantity
    unit, factor = unit_of_columns("m", columns)
    return replace(quantity, unit=unit, factor=factor)


@cache
def unit_text(unit: str) -> str:
    """Return a unit as it is printed: m/s2 becomes m/s², kgf.s2/cm becomes kgf·s²/cm."""
    raised = re.sub(
        r"(?<=[A-Za-z])\^?(-?\d)",
        lambda m: m[1].translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")),
        unit,
    )
    return raised.replace(".", "·").replace("*", "·")


def quantity_of(name: str, units: Mapping[str, str] | None = None) -> Quantity | None:
    """Return the quantity of a variable by its unit, else by the end of its name; None if unknown.

    A unit that is not among those of the table is a quantity of its own.
    """
    if units is not None and name in units:
        unit = units[name]
        known = next((quantity for quantity in QUANTITIES if quantity.si == unit), None)
        named = unit not in ("", "1")
        return known or (Quantity(unit_text(unit), unit_text(unit), 1.0, unit) if named else None)
    return by_ending(name)


@cache
def by_ending(name: str) -> Quantity | None:
    """Return the quantity of a variable by the end of its name."""
    return next((quantity for quantity in QUANTITIES if name.endswith(quantity.endings)), None)


def rate_unit(unit: str, order: int) -> str:
    """Return the unit of a derivative of a quantity with this unit, as it is printed."""
    return f"{unit or 1}/s{'²' if order == 2 else ''}" if order else unit


def rate_of(displacement: str) -> str:
    """Return the FMUs' name of the rate of change of a displacement."""
    for ending, rate in (("displacement", "velocity"), ("_angle", "_rate")):
        if displacement.endswith(ending):
            return displacement.removesuffix(ending) + rate
    return f"{displacement}_rate"
