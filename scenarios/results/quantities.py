"""The format of numbers in reports: every measure with its unit and its time."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, inf, log10
from typing import Any

# SI unit -> (unit shown, how many of it make one SI unit).
_SHOWN_IN = {"m": ("mm", 1e3), "s": ("ms", 1e3)}
_NO_UNITS = ("", "1", "count")
_DIGITS, _DECIMALS = 4, 3  # fewest significant digits, and fewest decimals
_LONGEST = 1e9
_ROUNDING = 1e-10  # smaller values are rounding errors of forces that cancel
_LONG = 10.0  # s: times from here on are given in seconds


def shown_in(unit: str) -> tuple[str, float]:
    """Return the unit shown for an SI unit ("" for none), and how many of it make one SI unit."""
    return ("", 1.0) if unit in _NO_UNITS else _SHOWN_IN.get(unit, (unit, 1.0))


def with_unit(text: str, unit: str) -> str:
    """Return a number that has been written, with its unit if it has one."""
    return text if unit in _NO_UNITS else f"{text} {unit}"


def number(value: float) -> str:
    """Return a number with at least four significant digits and three decimals; rounding errors as 0."""
    if isinstance(value, int):
        return str(value)
    size = abs(value)
    if size < _ROUNDING:
        return f"{0.0:.{_DECIMALS}f}"
    if not size < inf:
        return str(value)
    leading = floor(log10(size))
    if size >= _LONGEST or leading < -_DIGITS:
        return f"{value:.{_DIGITS - 1}e}"
    return f"{value:.{max(_DECIMALS, _DIGITS - 1 - leading)}f}"


def quantity(value: object, unit: str) -> str:
    """Return a value, or a list of values, with the unit shown for an SI unit."""
    shown, factor = shown_in(unit)
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        return ", ".join(quantity(one, unit) for one in value) or "none"
    if not isinstance(value, float) or (unit == "count" and value.is_integer()):
        return f"{value:.0f}" if isinstance(value, float) else str(value)
    return with_unit(number(factor * value), shown)


def reading(measured: Mapping[str, Any], width: int = 0, units: int = 0) -> str:
    """Return a measure of a summary: its value right-aligned in `width`, its unit and its time.

    The times are aligned where `units` is the width of the longest unit.
    """
    number, _, unit = quantity(measured["value"], measured["unit"]).partition(" ")
    if isinstance(measured["value"], list | tuple):
        return f"{number} {unit}".rstrip()
    instant = measured["time"]
    when = "" if instant is None else f"{unit:<{units}} at {_instant(instant)}"
    return f"{number:>{width}} {when or unit}".rstrip()


def _instant(time: float) -> str:
    return f"{1e3 * time:>8.2f} ms" if time < _LONG else f"{time:>8.3f} s"
