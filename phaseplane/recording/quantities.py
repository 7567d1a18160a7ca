"""The quantities of variables, and the units in which they are shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity and its display unit.

    Parameters
    ----------
    name : of the quantity
    unit : in which it is shown
    factor : number of display units in the SI unit
    si : the SI unit
    endings : endings of the names of its variables
    """

    name: str
    unit: str
    factor: float
    si: str
    endings: tuple[str, ...]


_DEGREES = 57.29577951308232
QUANTITIES = (
    Quantity(
        "displacement", "cm", 100.0, "m", ("displacement", "deflection", "elevation", "drift")
    ),
    Quantity("velocity", "m/s", 1.0, "m/s", ("velocity", "_rate")),
    Quantity("acceleration", "m/s\N{SUPERSCRIPT TWO}", 1.0, "m/s2", ("acceleration",)),
    Quantity("force", "N", 1.0, "N", ("force",)),
    Quantity("energy", "J", 1.0, "J", ("energy",)),
    Quantity("angle", "\N{DEGREE SIGN}", _DEGREES, "rad", ("angle",)),
)


def quantity_of(name: str, units: Mapping[str, str] | None = None) -> Quantity | None:
    """Return the quantity of a variable by its SI unit, else by the end of its name; None if unknown."""
    if units is not None and name in units:
        return next((quantity for quantity in QUANTITIES if quantity.si == units[name]), None)
    return _by_ending(name)


@cache
def _by_ending(name: str) -> Quantity | None:
    return next((quantity for quantity in QUANTITIES if name.endswith(quantity.endings)), None)


def in_words(name: str) -> str:
    """Return a variable's name in words."""
    return name.replace("_", " ")


def rate_of(displacement: str) -> str:
    """Return the FMUs' name of the rate of change of a displacement."""
    for ending, rate in (("displacement", "velocity"), ("_angle", "_rate")):
        if displacement.endswith(ending):
            return displacement.removesuffix(ending) + rate
    return f"{displacement}_rate"
