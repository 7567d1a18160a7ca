"""The format of numbers in reports: every measure with its unit and its time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from math import floor, inf, isfinite, log10
from typing import Any

# SI unit -> (unit shown, how many of it make one SI unit).
_SHOWN_IN = {"m": ("mm", 1e3), "s": ("ms", 1e3)}
_NO_UNITS = ("", "1", "count")
_DIGITS, _DECIMALS = 4, 3  # fewest significant digits, and fewest decimals
_LONGEST = 1e9
_ROUNDING = 1e-12  # of the size of a quantity: smaller values are rounding errors of what cancels
_LONG = 10.0  # s: instants from here on are given in seconds


def shown_in(unit: str) -> tuple[str, float]:
    """Return the unit shown for an SI unit ("" for none), and how many of it make one SI unit."""
    return ("", 1.0) if unit in _NO_UNITS else _SHOWN_IN.get(unit, (unit, 1.0))


def with_unit(text: str, unit: str) -> str:
    """Return a number that has been written, with its unit if it has one."""
    return text if unit in _NO_UNITS else f"{text} {unit}"


def rounded(value: float, size: float) -> float:
    """Return a value of a quantity of this size, or 0 if it is zero but for rounding."""
    return 0.0 if abs(value) <= _ROUNDING * size < inf else value


def number(value: float, size: float = 0.0, decimals: int = _DECIMALS) -> str:
    """Return a number of a quantity of this size, with at least four digits and so many decimals."""
    if isinstance(value, int):
        return str(value)
    value = rounded(value, size)
    if not value:
        return "0"
    if not abs(value) < inf:
        return str(value)
    leading = floor(log10(abs(value)))
    if abs(value) >= _LONGEST or leading < -_DIGITS:
        return f"{value:.{_DIGITS - 1}e}"
    return f"{value:.{max(decimals, _DIGITS - 1 - leading)}f}"


def quantity(value: object, unit: str, size: float = 0.0) -> str:
    """Return a value, or a list of values, with the unit shown for an SI unit.

    Parameters
    ----------
    value : in the SI unit
    size : size of its quantity, in the SI unit; if 0 its own
    """
    shown, factor = shown_in(unit)
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        largest = max((size, *(abs(one) for one in value if isinstance(one, float))))
        return ", ".join(quantity(one, unit, largest) for one in value) or "none"
    if not isinstance(value, float) or (unit == "count" and value.is_integer()):
        return f"{value:.0f}" if isinstance(value, float) else str(value)
    return with_unit(number(factor * value, factor * size), shown)


def sizes(values: Iterable[tuple[str, str, object]]) -> dict[str, float]:
    """Return the size of the quantity of each measure, in its SI unit: the largest magnitude of its kind.

    Measures of one unit are of one kind; those without a unit are if the last words of their names
    agree. The motions from several starts are each by themselves. Values that are not a real number have
    no size.

    Parameters
    ----------
    values : names, SI units and values of the measures of one run
    """
    kinds: dict[str, tuple[str, str]] = {}
    largest: dict[tuple[str, str], float] = {}
    for name, unit, value in values:
        _, start, _ = re.split(r"(start\d+_|$)", name, maxsplit=1)
        kind = kinds[name] = (start, re.split(r"[._]", name)[-1] if unit in _NO_UNITS else unit)
        size = abs(value) if isinstance(value, float) and isfinite(value) else 0.0
        largest[kind] = max(largest.get(kind, 0.0), size)
    return {name: largest[kind] for name, kind in kinds.items()}


def reading(measured: Mapping[str, Any], size: float = 0.0, width: int = 0, units: int = 0) -> str:
    """Return a measure of a summary: its value right-aligned in `width`, its unit and its time.

    Parameters
    ----------
    size : size of its quantity, in the SI unit
    units : width of the longest unit, with which the times are aligned
    """
    number, _, unit = quantity(measured["value"], measured["unit"], size).partition(" ")
    if isinstance(measured["value"], list | tuple):
        return f"{number} {unit}".rstrip()
    instant = measured["time"]
    when = "" if instant is None else f"{unit:<{units}} at {_instant(instant)}"
    return f"{number:>{width}} {when or unit}".rstrip()


def span(time: float) -> str:
    """Return how long something lasts, in ms or, from a second on, in s."""
    return f"{1e3 * time:g} ms" if time < 1.0 else f"{time:g} s"


def _instant(time: float) -> str:
    return f"{number(1e3 * time, decimals=2):>8} ms" if time < _LONG else f"{time:>8.3f} s"
