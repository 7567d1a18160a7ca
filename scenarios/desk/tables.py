"""Tables from files and from sweeps."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..progress import Progress, silent
from ..results.folder import read_results, read_summary
from ..sweeps.job import run_sweep
from ..sweeps.report import read_rows
from .table import Table

if TYPE_CHECKING:
    import pyarrow


def read(path: str | os.PathLike[str]) -> Table:
    """Read the results of a run or a sweep, or a table of any program; columns are in SI.

    Parameters
    ----------
    path : a results folder or the table in it; or a CSV, Parquet, HDF5 or MAT file

    Raises
    ------
    InputError : if it is no results folder and no table; the message says what is wrong where.

    Examples
    --------
    >>> import phaseplane, tempfile
    >>> folder = phaseplane.run("ap57", duration=0.1).write(tempfile.mkdtemp() + "/bump")
    >>> phaseplane.read(folder).units["body_velocity"]
    'm/s'
    """
    path = Path(path)
    for folder in (path, path.parent):
        summary = read_summary(folder) or {}
        if summary.get("origin", {}).get("kind") == "sweep":
            table = folder / summary["table"]
            if path in (folder, table):
                return _of_sweep(read_rows(table), summary)
    results = read_results(path)
    return Table(results.columns, results.units, title=str(results.summary.get("title", "")))


def sweep(
    file: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Table:
    """Make the runs of a sweep file, write their folder, and return its table.

    Parameters
    ----------
    file : a sweep file, or the name of a sweep in the package
    folder : folder to write to, replaced as a whole; `out/sweeps/<file>` if None
    workers : number of processes; one per core if None
    progress : called with the fraction done, 0 to 1

    Returns
    -------
    A row for each run: its number, the values varied, the measures, `ok`, and the `reason` of a failure.

    Raises
    ------
    InputError : if the file is not valid, or the folder must not be replaced.
    RunError : if the runs could not start.
    """
    _, runs, summary, _ = run_sweep(
        os.fspath(file),
        Path(folder) if folder else None,
        workers=workers,
        progress=progress or silent,
    )
    return _of_sweep(runs, summary)


def _of_sweep(runs: pyarrow.Table, summary: Mapping[str, Any]) -> Table:
    measured = {name: extent["unit"] for name, extent in summary["measures"].items()}
    columns = {name: runs[name].to_numpy() for name in runs.column_names}
    title = summary["title"] or summary["sweep"]
    return Table(columns, {**summary["units"], **measured}, index="run", title=title)
