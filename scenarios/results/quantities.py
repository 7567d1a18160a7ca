"""Numbers as people read them: every measure with its unit and its instant, in one way everywhere."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, inf, log10
from typing import Any

# SI unit -> unit shown and how many of it make the SI unit.
_SHOWN_IN = {"m": ("mm", 1e3), "s": ("ms", 1e3)}
_NO_UNITS = ("", "1", "count")
_DIGITS, _DECIMALS = 4, 3  # significant and decimal ones, at least
_LONGEST = 1e9
_ROUNDING = 1e-10  # what is smaller is left over of forces that cancel
_LONG = 10.0  # s: instants from here on are told in seconds


def shown_in(unit: str) -> tuple[str, float]:
    """The unit in which values in an SI unit are shown, empty for none, and how many make the SI unit."""
    return ("", 1.0) if unit in _NO_UNITS else _SHOWN_IN.get(unit, (unit, 1.0))


def number(value: float) -> str:
    """A number with at least four significant digits and three decimals; rounding errors are 0."""
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
    """A measured value with the unit in which it is shown; several for a measure that lists some."""
    shown, factor = shown_in(unit)
    if value is None:
        return "nothing"
    if isinstance(value, list | tuple):
        return ", ".join(quantity(one, unit) for one in value) or "none"
    if not isinstance(value, float) or (unit == "count" and value.is_integer()):
        return f"{value:.0f}" if isinstance(value, float) else str(value)
    return f"{number(factor * value)} {shown}".rstrip()


def reading(measured: Mapping[str, Any], width: int = 0) -> str:
    """A measure of a summary: its value, to the right within a width, its unit and its instant."""
    number, _, unit = quantity(measured["value"], measured["unit"]).partition(" ")
    if isinstance(measured["value"], list | tuple):
        return f"{number} {unit}".rstrip()
    instant = measured["time"]
    when = "" if instant is None else f"{unit:<5} at {_instant(instant)}"
    return f"{number:>{width}} {when or unit}".rstrip()


def _instant(time: float) -> str:
    return f"{1e3 * time:>8.2f} ms" if time < _LONG else f"{time:>8.3f} s"
