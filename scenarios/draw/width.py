"""The width of a printed picture."""

from __future__ import annotations

import re

from ..errors import InputError

_METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "pt": 0.0254 / 72.0}
_WIDTH = re.compile(r"(\d+(?:\.\d+)?) ?(mm|cm|m|in|pt)")
_NARROWEST, _WIDEST = 0.04, 1.0  # m


def width_from(given: str | float, where: str) -> float:
    """Return a width in m, given in m or as a string with a unit, by the option that messages begin with.

    Raises
    ------
    InputError : if it is not a width, or too small or too large for a picture.
    """
    width = 0.0
    if isinstance(given, str):
        if found := _WIDTH.fullmatch(given.strip()):
            width = float(found[1]) * _METRES[found[2]]
    else:
        width = given
    if not _NARROWEST <= width <= _WIDEST:
        raise InputError(f"{where} {given}: must be from 40 mm to 1 m, such as 85mm or '6 in'")
    return width
