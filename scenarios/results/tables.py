"""Tables of columns and their metadata in files; the file's ending sets the format.

Numbers are read back to the bit. CSV is written in FMPy's format, without metadata, which a results
folder has in its summary; it is also read as measuring programs write it: see
`suspension.measurement_files`.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Mapping
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.measurement_files import encoding_of, read_table_of_units
from phaseplane.suspension.units import nearest

from ..errors import InputError

if TYPE_CHECKING:
    from ..columns import Column, Columns

    Table = tuple[dict[str, Column], dict[str, Any]]

_NUMERIC = re.compile(r"[-+]?(\d|\.\d|nan|inf)", re.IGNORECASE)
_AT_ONCE = 1000  # rows of a CSV
_METADATA = "phaseplane"  # the name of the metadata in a file


def write_table(columns: Columns, metadata: Mapping[str, Any], path: Path) -> None:
    """Write columns of equal length and their metadata (plain data; left out of a CSV)."""
    _FORMS[path.suffix][0](columns, json.dumps(metadata, ensure_ascii=False), path)


def read_table(path: Path) -> Table:
    """Read columns and metadata, which is {} if the file has none.

    Raises
    ------
    InputError : if the ending is not known, or the file cannot be read.
    """
    check_ending(path)
    try:
        path.open("rb").close()  # some libraries do not say why they cannot open a file
        columns, text = _FORMS[path.suffix][1](path)
        if not columns or not all(len(column) for column in columns.values()):
            raise ValueError("no rows")
        _check_columns(columns)
        metadata = json.loads(text) if text else {}
    except ImportError:
        raise
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    except Exception as error:  # any error that a damaged file causes in its library
        raise InputError(f"cannot read {path}: {error}") from None
    return columns, metadata if isinstance(metadata, dict) else {}


def _check_columns(columns: Columns) -> None:
    """Reject columns that are not numbers, or have different lengths."""
    rows = {len(column) for column in columns.values()}
    for name, column in columns.items():
        if column.ndim != 1 or column.dtype.kind not in "biuf":
            raise ValueError(f"column {name!r} does not contain numbers")
    if len(rows) > 1:
        raise ValueError(f"columns of different lengths: {', '.join(map(str, sorted(rows)))} rows")


def check_ending(path: Path) -> None:
    """Reject a file ending of no known format, or of one whose library is not installed.

    Raises
    ------
    InputError : if the ending is not known, or its library is missing.
    """
    if path.suffix not in _FORMS:
        raise InputError(f"{path}: must end in {', '.join(_FORMS)}{nearest(path.suffix, _FORMS)}")
    if path.suffix == ".h5":
        try:
            import h5py  # noqa: F401, PLC0415
        except ImportError:
            raise InputError(f"{path}: HDF5 needs h5py: pip install 'phaseplane[hdf5]'") from None


def _numbers(column: Column) -> Column:
    return column.astype(int) if column.dtype == bool else column


def _write_csv(columns: Columns, _metadata: str, path: Path) -> None:
    numbers = [_numbers(column) for column in columns.values()]
    rows = max(map(len, numbers), default=0)
    with path.open("w", encoding="utf-8", newline="\n") as table:
        csv.writer(table, quoting=csv.QUOTE_ALL, lineterminator="\n").writerow(columns)
        # as Python's numbers they take four times the memory
        for first in range(0, rows, _AT_ONCE):
            part = (column[first : first + _AT_ONCE].tolist() for column in numbers)
            table.writelines(",".join(map(repr, row)) + "\n" for row in zip(*part, strict=True))


def _read_csv(path: Path) -> tuple[dict[str, Column], str]:
    with path.open(encoding=encoding_of(path), newline="") as table:
        lines = table.readlines()
    names = [name.strip() for name in next(csv.reader(lines[:1]), [])]
    rows = lines[1:]
    if rows and (len(names) == 1 or _is_foreign(lines[0], rows[0])):
        columns, units = read_table_of_units(lines)
        found = {name: np.array(column) for name, column in columns.items()}
        return found, json.dumps({"units": units})
    if not names or not rows:
        return {}, ""
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{names.count(name)} columns are called {name!r}")
    try:
        values = np.loadtxt(rows, delimiter=",", ndmin=2)
    except ValueError:
        read_table_of_units(lines)  # tells the line
        raise
    if values.shape[1] != len(names):
        raise ValueError(f"{len(names)} names in the header, but {values.shape[1]} columns")
    return dict(zip(names, values.T.copy(), strict=True)), ""


def _is_foreign(heading: str, row: str) -> bool:
    """Whether a CSV begins with a comment, or a row of units follows its heading."""
    cells = [cell.strip().strip('"') for cell in row.split(",")]
    return heading.startswith("#") or any(cell and not _NUMERIC.match(cell) for cell in cells)


def _write_parquet(columns: Columns, metadata: str, path: Path) -> None:
    import pyarrow  # noqa: PLC0415  (heavy)
    from pyarrow import parquet  # noqa: PLC0415

    table = pyarrow.table({name: pyarrow.array(column) for name, column in columns.items()})
    parquet.write_table(table.replace_schema_metadata({_METADATA: metadata}), path)


def _read_parquet(path: Path) -> tuple[dict[str, Column], str]:
    from pyarrow import parquet  # noqa: PLC0415  (heavy)

    table = parquet.read_table(path)
    metadata = (table.schema.metadata or {}).get(_METADATA.encode(), b"").decode()
    return {name: table[name].to_numpy() for name in table.column_names}, metadata


def _write_hdf5(columns: Columns, metadata: str, path: Path) -> None:
    import h5py  # noqa: PLC0415  (heavy)

    with h5py.File(path, "w", track_order=True) as file:  # else columns are read by alphabet
        file.attrs[_METADATA] = metadata
        for name, column in columns.items():
            file.create_dataset(name, data=column, compression="gzip")


def _read_hdf5(path: Path) -> tuple[dict[str, Column], str]:
    import h5py  # noqa: PLC0415  (heavy)

    with h5py.File(path, "r") as file:
        columns = {name: data[...] for name, data in file.items()}
        return columns, str(file.attrs.get(_METADATA, ""))


def _write_mat(columns: Columns, metadata: str, path: Path) -> None:
    from scipy.io import savemat  # noqa: PLC0415  (heavy)

    # MATLAB names have at most 63 of A-Z, a-z, 0-9 and _; the full names are stored too
    names: dict[str, str] = {}
    for name in columns:
        short = re.sub(r"(?a)\W|^(?=[\d_])", "x", name)[:63]
        numbered = (f"{short[:50]}_{k}" for k in count(2))
        names[next(x for x in chain([short], numbered) if x not in {*names, _METADATA})] = name
    content: dict[str, Any] = {
        short: _numbers(columns[name]).reshape(-1, 1) for short, name in names.items()
    }
    content[_METADATA] = json.dumps({"names": names, "metadata": metadata})
    savemat(path, content, long_field_names=True, do_compression=True)


def _read_mat(path: Path) -> tuple[dict[str, Column], str]:
    from scipy.io import loadmat  # noqa: PLC0415  (heavy)

    content = loadmat(path)
    kept = json.loads(str(content[_METADATA][0])) if _METADATA in content else {}
    names = kept.get("names", {})
    columns = {
        names.get(short, short): value.ravel()
        for short, value in content.items()
        if not short.startswith("__") and short != _METADATA
    }
    return columns, kept.get("metadata", "")


_Write = Callable[["Columns", str, Path], None]
_Read = Callable[[Path], "tuple[dict[str, Column], str]"]
_FORMS: dict[str, tuple[_Write, _Read]] = {
    ".csv": (_write_csv, _read_csv),
    ".parquet": (_write_parquet, _read_parquet),
    ".h5": (_write_hdf5, _read_hdf5),
    ".mat": (_write_mat, _read_mat),
}
ENDINGS = tuple(_FORMS)
