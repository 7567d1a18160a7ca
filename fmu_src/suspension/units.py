"""Units of the public variables: SI throughout, with display units in which a value may be given.

The FMUs (unit definitions) and the scenes (`height = "5 cm"`) use the same table.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import pi

KGF = 9.80665  # N, standard gravity times 1 kg: the force unit of AP57


class UnitError(ValueError):
    """A quantity with an unknown unit, or a unit of another kind."""


@dataclass(frozen=True, slots=True)
class Unit:
    """An SI unit as a product of powers, and its display units.

    Parameters
    ----------
    exponents : powers of the base units, by FMI's names (kg, m, s, rad)
    display : name of another unit of the same kind -> its size in the SI unit
    """

    exponents: Mapping[str, int]
    display: Mapping[str, float]


UNITS: dict[str, Unit] = {
    "1": Unit({}, {"%": 1e-2}),
    "m": Unit({"m": 1}, {"mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048}),
    "m/s": Unit({"m": 1, "s": -1}, {"mm/s": 1e-3, "cm/s": 1e-2, "km/h": 1 / 3.6, "mph": 0.44704}),
    "m/s2": Unit({"m": 1, "s": -2}, {"cm/s2": 1e-2, "g": KGF, "mg": 1e-3 * KGF}),
    "rad": Unit({"rad": 1}, {"deg": pi / 180.0, "mrad": 1e-3}),
    "rad/s": Unit({"rad": 1, "s": -1}, {"deg/s": pi / 180.0}),
    "rad/s2": Unit({"rad": 1, "s": -2}, {"deg/s2": pi / 180.0}),
    "m3": Unit({"m": 3}, {"cm3": 1e-6, "mm3": 1e-9}),
    "Hz": Unit({"s": -1}, {"kHz": 1e3, "1/min": 1 / 60.0}),
    "s": Unit({"s": 1}, {"ms": 1e-3, "us": 1e-6, "min": 60.0}),
    "kg": Unit({"kg": 1}, {"g": 1e-3, "t": 1e3, "lb": 0.45359237, "kgf.s2/cm": 100 * KGF}),
    "kg.m2": Unit({"kg": 1, "m": 2}, {"g.m2": 1e-3, "t.m2": 1e3}),
    "N": Unit({"kg": 1, "m": 1, "s": -2}, {"kN": 1e3, "kgf": KGF, "lbf": 4.4482216152605}),
    "N/m": Unit(
        {"kg": 1, "s": -2},
        {"kN/m": 1e3, "N/mm": 1e3, "kgf/cm": 100 * KGF, "lbf/in": 4.4482216152605 / 0.0254},
    ),
    "N/m3": Unit({"kg": 1, "m": -2, "s": -2}, {"N/mm3": 1e9, "kgf/cm3": 1e6 * KGF}),
    "N.s/m": Unit(
        {"kg": 1, "s": -1},
        {
            "kN.s/m": 1e3,
            "N.s/mm": 1e3,
            "kgf.s/cm": 100 * KGF,
            "lbf.s/in": 4.4482216152605 / 0.0254,
        },
    ),
    "J": Unit({"kg": 1, "m": 2, "s": -2}, {"kJ": 1e3}),
}

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*)?$")
_SPELLINGS = str.maketrans({
    "*": ".", "·": ".", "⋅": ".", "²": "2", "³": "3", "^": None, "µ": "u", "μ": "u", "°": "deg",
    " ": None,
})  # fmt: skip


def spelled(unit: str) -> str:
    """Return a unit as it is spelled here: m/s^2 and m/s² are m/s2, N s/m is N.s/m."""
    return re.sub(r"(?<=\w)\s+(?=\w)", ".", unit.strip()).translate(_SPELLINGS)


def to_si(quantity: str, unit: str) -> float:
    """Turn a string such as `5 cm` into a number in the given SI unit.

    Parameters
    ----------
    quantity : a number followed by a unit of the same kind; SI if there is no unit
    unit : key of `UNITS`

    Raises
    ------
    UnitError : not a number, or a unit of another kind.
    """
    match = _QUANTITY.match(quantity)
    if match is None:
        what, example = ("number", "1.5") if unit == "1" else ("number with a unit", f"1.5 {unit}")
        raise UnitError(f"{quantity!r} is not a {what}; write for example {example!r}")
    number, name = float(match[1]), spelled(match[2] or unit)
    if name == unit:
        return number
    display = UNITS[unit].display
    if name in display:
        return number * display[name]
    if re.match(r",\d", name):
        raise UnitError(f"{quantity!r}: the decimal sign is a point, not a comma")
    raise UnitError(f"unit {name!r} does not fit here; allowed: {', '.join((unit, *display))}")


def unit_of(quantity: str) -> str:
    """Return the SI unit of a string such as `5 cm`, the first that fits; "" without a known unit."""
    match = _QUANTITY.match(quantity)
    kinds = kinds_of(spelled(match[2])) if match and match[2] else []
    return kinds[0] if kinds else ""


def kinds_of(unit: str) -> list[str]:
    """Return the SI units of which a unit, spelled as here, is one, or a display unit."""
    return [name for name, one in UNITS.items() if unit == name or unit in one.display]


def counted(count: int, what: str) -> str:
    """Return a number of things, e.g. 1 step or 62 steps."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def nearest(name: str, names: Iterable[str]) -> str:
    """Return a hint with the closest known name, whatever its case, to end a message with, or ""."""
    from difflib import get_close_matches  # noqa: PLC0415  (for mistakes only)

    known = {one.casefold(): one for one in names}
    close = get_close_matches(name.casefold(), known, n=1, cutoff=0.5)
    return f"; did you mean {known[close[0]]!r}?" if close else ""
