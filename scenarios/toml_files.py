"""The content of TOML files of any kind."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Mapping
from math import inf, nan
from pathlib import Path
from typing import Any

from phaseplane.suspension.units import to_si

from .errors import InputError, blaming, read_text


def read_content(path: Path, name: str = "") -> dict[str, Any]:
    """Return the content of a TOML file.

    Parameters
    ----------
    name : its name in messages, if that is not its path

    Raises
    ------
    InputError : if it cannot be read.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the path of a .toml file")
    text, place = read_text(path, name), f"cannot read {name or path}"
    try:
        with blaming(f"{place}: not TOML"):
            return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{place}: nested too deeply") from None


def real(value: object) -> float:
    """Return a number, infinite if it is an integer that is too large; not a number if it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return nan
    try:
        return float(value)
    except OverflowError:
        return inf


def in_si(value: object, unit: str) -> float:
    """Return a number in SI, or a string with a unit; not a number if it is neither.

    Raises
    ------
    ValueError : a string that is no number, or of a unit that does not fit.
    """
    return to_si(value, unit) if isinstance(value, str) else real(value)


def dotted(
    table: Mapping[str, Any], ends: Collection[str], prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield the dotted keys of nested tables, and their values.

    Parameters
    ----------
    ends : keys of tables that are values themselves
    """
    for key, value in table.items():
        if isinstance(value, dict) and value and not value.keys() & set(ends):
            yield from dotted(value, ends, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
