"""Tables from files and from sweeps."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ..progress import Progress, silent
from ..results.folder import read_results
from ..sweeps.job import run_sweep
from .table import Table


def read(path: str | os.PathLike[str]) -> Table:
    """Read a results folder or a table: CSV of any program, Parquet, HDF5 or MAT; columns are in SI.

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
    results = read_results(Path(path))
    units: Any = results.summary.get("units", {})
    return Table(results.columns, units, title=str(results.summary.get("title", "")))


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
    plan, runs, summary, _ = run_sweep(
        os.fspath(file),
        Path(folder) if folder else None,
        workers=workers,
        progress=progress or silent,
    )
    units = dict(zip(plan.keys, plan.units, strict=True))
    units |= {name: extent["unit"] for name, extent in summary["measures"].items()}
    columns = {name: runs[name].to_numpy() for name in runs.column_names}
    return Table(columns, units, index="run", title=plan.title or plan.name)
