"""Measured signals from files with other names and units.

file = "rig.csv"
time = "t"
columns = { body_acceleration = "acc_z" }
units = { t = "ms", acc_z = "g" }
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.measurement_files import Wanted, headings, read_columns
from phaseplane.suspension.units import nearest

from ..errors import InputError, blaming, read_errors, refuse_unknown_keys, shown
from ..toml_files import in_si
from .tables import read_table

if TYPE_CHECKING:
    from ..columns import Column

KEYS = {
    "file": ("string", "CSV file, or a table of results"),
    "time": ("string", 'heading of the times; "time" if left out'),
    "columns": ("object", "heading of each output; left out, the headings are the outputs' names"),
    "units": ("object", "unit of each heading; left out, that in the row below it, or SI"),
    "delimiter": ("string", 'between the cells of a row; "," if left out'),
    "decimal": ("string", 'decimal sign; "." if left out'),
    "offset": ("object", "added to the columns of outputs, in SI or with a unit"),
    "time_shift": (["number", "string"], "added to the times, in s or with a unit"),
}
"""What describes measured signals: the type of each key in JSON, and its meaning."""
MEASURED: dict[str, Any] = {
    "type": "object",
    "properties": {
        key: {"description": about, "type": kind} for key, (kind, about) in KEYS.items()
    },
    "required": ["file"],
    "additionalProperties": False,
}
"""The JSON Schema of these keys."""


def read_signals(
    said: Mapping[str, Any], folder: Path, known: Mapping[str, str]
) -> dict[str, Column]:
    """Return `time` and measured columns by the names of the outputs they are of, in SI.

    Parameters
    ----------
    said : by the keys of `KEYS`
    folder : the folder that the file's path is relative to
    known : the SI units of the outputs by name

    Raises
    ------
    InputError : if a key is not valid, or the file cannot be read.
    """
    refuse_unknown_keys(said, KEYS)
    if not isinstance(said.get("file"), str) or not said["file"]:
        raise InputError(f"file = {shown(said.get('file'))}: must be the path of a file")
    tables = {}
    for key in ("columns", "units", "offset"):
        tables[key] = said.get(key, {})
        if not isinstance(tables[key], Mapping):
            raise InputError(f"{key} = {shown(tables[key])}: must be a table")
        for name, value in tables[key].items():
            if key != "offset" and not isinstance(value, str):
                raise InputError(f"{key}.{name} = {shown(value)}: must be a string")
    path = folder / said["file"]
    delimiter, decimal = said.get("delimiter", ","), said.get("decimal", ".")
    heading = str(said.get("time", "time"))
    shift = _si("time_shift", said.get("time_shift", 0.0), "s")
    if path.suffix != ".csv":
        return _from_table(path, heading, tables, shift, known)
    with read_errors(path):
        columns = tables["columns"] or _outputs_among(headings(path, delimiter), heading, known)
        _refuse_no_outputs(columns, known)
        units, offsets = tables["units"], tables["offset"]
        _refuse_others("units", units, (heading, *columns.values()))
        _refuse_others("offset", offsets, columns)
        wanted = [
            Wanted(heading, ("s",), str(units.get(heading, "")), shift),
            *(
                Wanted(column, (known[name],), str(units.get(column, "")),
                       _si(f"offset.{name}", offsets.get(name, 0.0), known[name]))
                for name, column in columns.items()
            ),
        ]  # fmt: skip
        found = read_columns(path, wanted, delimiter=delimiter, decimal=decimal)
    return dict(zip(("time", *columns), map(np.array, found), strict=True))


def signals_in(
    path: Path, content: Mapping[str, Any], known: Mapping[str, str]
) -> dict[str, Column]:
    """Return the signals that the table [measured] of a TOML file describes, as `read_signals`.

    Parameters
    ----------
    path, content : of the TOML file
    known : the SI units of the outputs by name
    """
    measured = content.get("measured")
    if not isinstance(measured, Mapping):
        raise InputError(f"{path}: measured is missing; give a table with {', '.join(KEYS)}")
    with blaming(f"{path}: measured", InputError):
        return read_signals(measured, path.parent, known)


def _from_table(
    path: Path, heading: str, tables: Mapping[str, Mapping[str, Any]], shift: float,
    known: Mapping[str, str],
) -> dict[str, Column]:  # fmt: skip
    """Return the columns of a table of results, whose units are SI."""
    found, _ = read_table(path)
    columns = tables["columns"] or _outputs_among(found, heading, known)
    _refuse_no_outputs(columns, known)
    for column in (heading, *columns.values()):
        if column not in found:
            there = ", ".join(map(shown, found))
            raise InputError(
                f"{path} has no column {shown(column)}; its columns are {there}{nearest(column, found)}"
            )
    _refuse_others("units", tables["units"], ())
    _refuse_others("offset", tables["offset"], columns)
    return {
        "time": found[heading].astype(float) + shift,
        **{
            name: found[column].astype(float)
            + _si(f"offset.{name}", tables["offset"].get(name, 0.0), known[name])
            for name, column in columns.items()
        },
    }


def _outputs_among(names: Iterable[str], heading: str, known: Collection[str]) -> dict[str, str]:
    """Return the headings that are the names of outputs, apart from that of the times."""
    return {name: name for name in names if name in known and name != heading}


def _refuse_no_outputs(columns: Collection[str], known: Collection[str]) -> None:
    """Reject columns of no output, or none at all."""
    for name in columns:
        if name not in known:
            raise InputError(f"columns: no output {shown(name)}{nearest(name, known)}")
    if not columns:
        raise InputError("columns is missing, and no heading is the name of an output")


def _refuse_others(key: str, given: Mapping[str, Any], known: Collection[str]) -> None:
    """Reject a unit or offset for a column that is not read."""
    for name in given:
        if name not in known:
            allowed = f"there are {', '.join(known)}" if known else "the units of this table are SI"
            raise InputError(
                f"{key}.{name}: is not among what is read{nearest(name, known)}; {allowed}"
            )


def _si(key: str, value: object, unit: str) -> float:
    with blaming(f"{key} = {shown(value)}"):
        number = in_si(value, unit)
        if not isfinite(number):
            raise ValueError("must be a finite number in SI or a string with a unit")
    return number
