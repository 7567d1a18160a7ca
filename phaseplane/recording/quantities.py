"""What the name of a variable says of its quantity, and the unit it is shown in."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that is shown.

    Parameters
    ----------
    name : of the quantity
    unit : in which it is shown
    factor : how many of that unit make the SI unit
    endings : how the names of its variables end
    """

    name: str
    unit: str
    factor: float
    endings: tuple[str, ...]


QUANTITIES = (
    Quantity("displacement", "cm", 100.0, ("_displacement", "_deflection", "_elevation", "_drift")),
    Quantity("velocity", "m/s", 1.0, ("_velocity", "_rate")),
    Quantity("acceleration", "m/s\N{SUPERSCRIPT TWO}", 1.0, ("_acceleration",)),
    Quantity("force", "N", 1.0, ("_force",)),
)


def quantity_of(name: str) -> Quantity | None:
    """The quantity of a variable; nothing where its name does not say."""
    return next((quantity for quantity in QUANTITIES if name.endswith(quantity.endings)), None)


def in_words(name: str) -> str:
    """A variable's name as it is written."""
    return name.replace("_", " ")
