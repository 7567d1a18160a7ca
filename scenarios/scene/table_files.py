"""Table parameters read from CSV files: measured roads, forces and characteristics.

    road.table = { file = "road.csv", columns = ["distance", "profile"], units = ["m", "mm"] }

The file's points become the text value of the parameter, so that a packed FMU needs no file.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from phaseplane.suspension.measurement_files import Wanted, headings, is_number, read_columns
from phaseplane.suspension.units import nearest, to_si
from phaseplane.suspension.variable import is_table

from ..errors import InputError, blaming, read_errors, refuse_unknown_keys, shown

KEYS = ("file", "columns", "units", "delimiter", "decimal", "offset")
# The SI units of the two columns of a table.
_UNITS = {
    "road.table": ("m", "m"),
    "force.table": ("s", "N"),
    "body_force.table": ("s", "N"),
    "spring.table": ("m", "N"),
    "bump_stop.table": ("m", "N"),
    "rebound_stop.table": ("m", "N"),
    "damper.table": ("m/s", "N"),
    "damper.deflection_table": ("m", "1"),
    "tyre.table": ("m", "N"),
    "tyre.damping_table": ("m/s", "N"),
}


_EXAMPLES = {"columns": '["x", "z"]', "units": '["mm", "kN"]', "offset": '["0", "30 N"]'}


def with_files(
    given: Mapping[str, Any], declared: Collection[str], folders: Mapping[str, Path]
) -> tuple[dict[str, Any], set[str]]:
    """Return the parameters with tables read from their files, and the names of those tables.

    Parameters
    ----------
    given : the scene's parameters by name; for a table in a file `NAME.file`, `NAME.columns`, ...
    declared : names of the FMU's parameters
    folders : the folder that paths are relative to, by dotted key of the scene

    Raises
    ------
    InputError : if a table cannot be read; the message begins with the parameter's name.
    """
    plain: dict[str, Any] = {}
    files: dict[str, dict[str, Any]] = {}
    for key, value in given.items():
        name, _, last = key.rpartition(".")
        if key not in declared and name in declared and last in KEYS and not is_table(name):
            tables = [each for each in declared if is_table(each)]
            raise InputError(
                f"{name}: is not a table and has no {last}; tables are {', '.join(tables)}"
                + nearest(f"{name.rpartition('.')[0]}.table", tables)
            )
        if key not in declared and name in declared and is_table(name):
            files.setdefault(name, {})[last] = value
        else:
            plain[key] = value
    for name, said in files.items():
        with blaming(name, InputError):
            plain[name] = _read(name, said, folders.get(f"parameters.{name}.file", Path()))
    return plain, set(files)


def _read(name: str, said: Mapping[str, Any], folder: Path) -> str:
    """Return the text of a table parameter from a CSV file with a header line.

    Parameters
    ----------
    name : name of the parameter, such as `road.table` or `front.spring.table`
    said : `file`, `columns` (two names; those of a file with two columns if left out), `units` (two;
        those of the row below the heading, or SI, if left out), `delimiter` (a comma), `decimal` (a
        point), `offset` (two, which are added)
    folder : the folder that the file's path is relative to
    """
    refuse_unknown_keys(said, KEYS)
    kinds = next((units for end, units in _UNITS.items() if f".{name}".endswith(f".{end}")), None)
    if kinds is None:
        raise InputError(f"only {', '.join(_UNITS)} can be read from a file")
    file = said.get("file")
    if not isinstance(file, str) or not file:
        raise InputError(f"file = {shown(file)}: must be the path of a CSV file")
    delimiter, decimal = said.get("delimiter", ","), said.get("decimal", ".")
    pairs = {
        "columns": said["columns"] if "columns" in said else _both(folder / file, delimiter),
        "units": said.get("units", ["", ""]),
        "offset": said.get("offset", ["0", "0"]),
    }
    if isinstance(pairs["offset"], list):
        pairs["offset"] = [str(x) if type(x) in (int, float) else x for x in pairs["offset"]]
    for key, pair in pairs.items():
        if not (
            isinstance(pair, list) and len(pair) == 2 and all(isinstance(x, str) for x in pair)
        ):
            raise InputError(
                f"{key} = {shown(pair)}: must be two, of the first and the second column, such as "
                f"{_EXAMPLES[key]}"
            )
    wanted = []
    for column, unit, offset, kind in zip(*pairs.values(), kinds, strict=True):
        _si("units", f"1 {unit}", kind)
        wanted.append(Wanted(column, (kind,), unit, _si("offset", offset, kind)))
    with read_errors(folder / file):
        columns = read_columns(folder / file, wanted, delimiter=delimiter, decimal=decimal)
    return ", ".join(f"{x!r}:{y!r}" for x, y in zip(*columns, strict=True))


def _si(key: str, value: str, unit: str) -> float:
    with blaming(key):
        return to_si(value, unit)


def _both(path: Path, delimiter: str) -> list[str]:
    """Return the headings of a file with two columns.

    Raises
    ------
    InputError : if it has another number of columns, or cannot be read.
    """
    with read_errors(path):
        found = headings(path, delimiter)
    if not found:
        raise InputError(f"{path.name} is empty")
    if all(map(is_number, found)):
        raise InputError(
            f"{path.name} has no heading, as its first row is {', '.join(found)}; write one above it"
        )
    if len(found) != 2:
        other = next((mark for mark in ";\t" if len(found) == 1 and mark in found[0]), "")
        raise InputError(
            f"columns is missing; give the names of two columns of {', '.join(map(shown, found))}"
            f"{f', or delimiter = {other!r}' if other else ''}"
        )
    return list(found)
