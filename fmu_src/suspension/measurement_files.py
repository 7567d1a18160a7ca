"""Columns of CSV files as written by measuring programs: units, decimal comma, comments."""

from __future__ import annotations

import csv
from codecs import BOM_UTF16_BE, BOM_UTF16_LE, getincrementaldecoder
from collections.abc import Iterator, Sequence
from math import inf, isfinite
from os import SEEK_END, PathLike
from pathlib import Path
from typing import NamedTuple

from .units import UNITS, UnitError, counted, kinds_of, nearest, spelled, to_si

_COMMENT = "#"
_PART = 1 << 20  # bytes read at once


class Wanted(NamedTuple):
    """A column to read.

    Parameters
    ----------
    heading : its heading in the file
    kinds : the SI units that are allowed for it
    unit : its unit in the file; "" for the one in the row below the heading, or in brackets at the end of
        the heading, or else SI
    offset : added to the values, in SI
    """

    heading: str
    kinds: tuple[str, ...]
    unit: str = ""
    offset: float = 0.0


def read_columns(
    path: str | PathLike[str],
    wanted: Sequence[Wanted],
    *,
    delimiter: str = ",",
    decimal: str = ".",
) -> list[list[float]]:
    """Read columns of a CSV file with a heading, in SI units; the first must ascend from row to row.

    Lines that begin with # are skipped. The row below the heading may give the units, if not those of all
    columns, or the headings themselves, such as `force [kN]`.

    Parameters
    ----------
    path : of the file; see `encoding_of`
    wanted : the columns
    delimiter : separator of the columns
    decimal : "." or ",", but not the delimiter

    Raises
    ------
    ValueError : a missing column, an unknown unit, a cell that is not a finite number, a first column
        that does not ascend, or no rows; the message names file and line.
    OSError : the file cannot be read.
    """
    name = Path(path).name
    _check_delimiter(delimiter)
    if decimal not in (".", ",") or decimal == delimiter:
        raise ValueError(
            f"decimal = {decimal!r}: must be '.' or ',', and not the delimiter {delimiter!r}"
        )
    columns: list[list[float]] = [[] for _ in wanted]
    with open(path, encoding=encoding_of(path), newline="") as file:
        try:
            rows = _numbered(csv.reader(file, delimiter=delimiter))
            _, heading = next(rows, (0, []))
            places = [_column(name, heading, column.heading) for column in wanted]
            scales: list[float] = []
            for line, row in rows:
                cells = [row[place] if place < len(row) else "" for place in places]
                units = [_bare(cell) for cell in cells]
                if not scales:
                    above = _are_units(units)
                    beside = units if above else [""] * len(units)
                    scales = [
                        _size(column.unit or unit or _in_heading(column), column.kinds)
                        for column, unit in zip(wanted, beside, strict=True)
                    ]
                    if above:
                        continue
                values = [
                    _number(f"{name}, line {line}", column.heading, cell, decimal) * scale
                    + column.offset
                    for column, cell, scale in zip(wanted, cells, scales, strict=True)
                ]
                if columns[0] and not columns[0][-1] < values[0]:
                    raise ValueError(
                        f"{name}, line {line}: {wanted[0].heading!r} must ascend from row to row"
                    )
                for column, value in zip(columns, values, strict=True):
                    column.append(value)
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{name} is not a CSV file: {error}") from None
    if not columns[0]:
        raise ValueError(f"{name} has no rows below its heading")
    return columns


def read_points(
    path: str | PathLike[str],
    position: str,
    value: str,
    position_unit: str = "",
    value_unit: str = "",
    delimiter: str = ",",
    decimal: str = ".",
    offsets: tuple[float, float] = (0.0, 0.0),
) -> list[tuple[float, float]]:
    """Read two columns of a CSV file in SI units: points for a `table` or `spline`.

    Parameters
    ----------
    path : of the file; see `encoding_of`
    position, value : headings of the two columns
    position_unit : of the first, a length, time or speed (`m`, `mm`, `s`, `m/s`, ...)
    value_unit : of the second, a length, force or number (`m`, `mm`, `N`, `kN`, `1`, ...)
    delimiter, decimal : as for `read_columns`
    offsets : added to positions and values, in SI

    Returns
    -------
    (m, s or m/s; m, N or 1) pairs, positions ascending

    Raises
    ------
    ValueError, OSError : as `read_columns`.
    """
    wanted = (
        Wanted(position, ("m", "s", "m/s"), position_unit, offsets[0]),
        Wanted(value, ("m", "N", "1"), value_unit, offsets[1]),
    )
    positions, values = read_columns(path, wanted, delimiter=delimiter, decimal=decimal)
    return list(zip(positions, values, strict=True))


def read_table_of_units(
    lines: Sequence[str],
) -> tuple[dict[str, list[float]], dict[str, str]]:
    """Return all columns of a CSV text in SI units, and those units, where a row of units tells them.

    The delimiter is that of the heading; if it is no comma, a comma in a number is a decimal sign.

    Raises
    ------
    ValueError : a row with more or fewer cells than the heading, a cell that is not a number, an unknown
        unit, or two columns of one name.
    """
    first = next((line for line in lines if line.strip() and not line.startswith(_COMMENT)), "")
    delimiter = max(";\t,", key=first.count)
    decimal = "." if delimiter == "," else ","
    rows = _numbered(csv.reader(lines, delimiter=delimiter))
    _, heading = next(rows, (0, []))
    for name in heading:
        if heading.count(name) > 1:
            raise ValueError(f"{heading.count(name)} columns are called {name!r}")
    columns: dict[str, list[float]] = {name: [] for name in heading}
    kinds, scales = dict.fromkeys(heading, ""), [1.0] * len(heading)
    for number, (line, row) in enumerate(rows):
        if len(row) != len(heading):
            raise ValueError(
                f"line {line} has {counted(len(row), 'cell')}, the heading {len(heading)}"
            )
        units = [_bare(cell) for cell in row]
        if number == 0 and _are_units(units):
            units = ["" if unit in ("-", "1") else unit for unit in units]
            kinds = {n: _kind(unit) for n, unit in zip(heading, units, strict=True)}
            scales = [_size(u, (_kind(u),)) if u else 1.0 for u in units]
            continue
        for name, cell, scale in zip(heading, row, scales, strict=True):
            columns[name].append(_number(f"line {line}", name, cell, decimal) * scale)
    return columns, kinds


def _kind(unit: str) -> str:
    """Return the SI unit of a unit, "" of none; that of accelerations for g."""
    kinds = kinds_of(unit) or [""]
    return "m/s2" if "m/s2" in kinds else kinds[0]


def encoding_of(path: str | PathLike[str]) -> str:
    """Return the encoding of a text file: UTF-8, UTF-16, or else Latin-1.

    Spreadsheets write all three. UTF-16 has a mark, or a zero byte in its first letter, which none of the
    others has; in Latin-1 every byte is a letter, such as that of m/s².

    Raises
    ------
    OSError : the file cannot be read.
    """
    decoder = getincrementaldecoder("utf-8")()
    with open(path, "rb") as file:  # in parts, as results may be large
        first = file.read(2)
        if file.seek(0, SEEK_END) % 2 == 0:
            if first in (BOM_UTF16_LE, BOM_UTF16_BE):
                return "utf-16"
            if b"\0" in first:
                return "utf-16-be" if first[0] == 0 else "utf-16-le"
        file.seek(0)
        try:
            while part := file.read(_PART):
                decoder.decode(part)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return "latin-1"
    return "utf-8-sig"


def headings(path: str | PathLike[str], delimiter: str = ",") -> list[str]:
    """Return the headings of a CSV file.

    Raises
    ------
    ValueError : the delimiter is not one character.
    OSError : the file cannot be read.
    """
    _check_delimiter(delimiter)
    with open(path, encoding=encoding_of(path), newline="") as file:
        return next(_numbered(csv.reader(file, delimiter=delimiter)), (0, []))[1]


def _check_delimiter(delimiter: str) -> None:
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        raise ValueError(f"delimiter = {delimiter!r}: must be one character; a tab is \\t")


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, with a decimal point or comma."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _numbered(rows: Iterator[list[str]]) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are neither empty nor comments, stripped, with the number of their line."""
    for line, row in enumerate(rows, 1):
        cells = [cell.strip() for cell in row]
        if any(cells) and not cells[0].startswith(_COMMENT):
            yield line, cells


def _bare(cell: str) -> str:
    """Return a unit without brackets."""
    return spelled(cell.strip("[]()"))


def _in_heading(column: Wanted) -> str:
    """Return the unit in brackets at the end of a heading, or else SI; round ones may hold words."""
    unit = _bare(column.heading[max(column.heading.rfind("["), column.heading.rfind("(")) :])
    if column.heading.endswith("]") or (column.heading.endswith(")") and _is_unit(unit)):
        return unit
    return column.kinds[0]


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a row gives units; the cell of a number or of one unit may be empty, 1 or -."""
    named = [cell for cell in cells if cell not in ("", "1", "-")]
    if not named:
        return "-" in cells and "1" not in cells  # by itself, a 1 is a number
    return all(map(_is_unit, named))


def _is_unit(text: str) -> bool:
    return text == "-" or (text != "1" and bool(kinds_of(text)))


def _size(unit: str, kinds: tuple[str, ...]) -> float:
    """Return the size of a unit in the SI unit of its kind."""
    if unit == "-":
        return 1.0
    for kind in kinds:
        try:
            return to_si(f"1 {unit}", kind)
        except UnitError:
            continue
    allowed = ", ".join(name for kind in kinds for name in (kind, *UNITS[kind].display))
    raise ValueError(f"unit {unit!r} does not fit here; allowed: {allowed}")


def _column(file: str, heading: Sequence[str], name: str) -> int:
    found = [place for place, cell in enumerate(heading) if cell == name]
    if len(found) == 1:
        return found[0]
    if found:
        raise ValueError(f"{file}: {len(found)} columns are called {name!r}")
    if not heading:
        raise ValueError(f"{file} is empty")
    columns = ", ".join(map(repr, heading))
    between = next((sign for sign in ",;\t" if len(heading) == 1 and sign in heading[0]), "")
    hint = f"; give delimiter = {between!r}" if between else nearest(name, heading)
    raise ValueError(f"{file} has no column {name!r}; its columns are {columns}{hint}")


def _number(where: str, column: str, cell: str, decimal: str) -> float:
    try:
        number = float(cell.replace(",", ".") if decimal == "," else cell)
    except ValueError:
        number = inf
    if not isfinite(number):
        hint = "; is the decimal sign a comma?" if "," in cell and decimal == "." else ""
        raise ValueError(
            f"{where}: {column!r} must be a finite number such as -1.5, {cell!r} found{hint}"
        )
    return number
