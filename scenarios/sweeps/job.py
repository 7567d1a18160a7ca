"""Run a sweep file and write its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.variables import Value

from phaseplane import figures

from ..draw.pictures import draws_or_tells
from ..measures import has_sign
from ..progress import Progress, silent
from ..results.folder import Place, replace_folder, write_summary
from ..results.quantities import shown_in
from .plan import Plan, load_plan
from .report import check_table, summary_of, table_of, write_rows
from .running import Row, journal_key, sweep

if TYPE_CHECKING:
    import pyarrow

    from phaseplane.figures.style import Figure

_PICTURE = "sweep.png"


def run_sweep(
    file: str | Path,
    folder: Path | None = None,
    *,
    through: str = "process",
    workers: int | None = None,
    dask: str = "",
    table: str = "runs.csv",
    progress: Progress = silent,
) -> tuple[Plan, pyarrow.Table, dict[str, Any], Path]:
    """Make the runs of a sweep file and write table, picture and summary to a folder.

    Parameters
    ----------
    file : a sweep file, or the name of a sweep in the package
    folder : folder to write to, replaced as a whole; `out/sweeps/<file>` if None
    through, workers, dask, progress : see `running.sweep`
    table : name of the table of runs, ending in .csv or .parquet

    Returns
    -------
    The plan, the table of runs, the summary as written, and the folder.

    Raises
    ------
    InputError : if the file cannot be read, or the folder must not be replaced.
    RunError : if the runs could not start.
    """
    check_table(table)
    plan = load_plan(file)
    place = Place.chosen(folder, f"sweeps/{plan.name}", "sweep", plan.file)
    folder = place.folder
    # the journal's name depends on the sweep and on how it is run, so that rows are never mixed
    journal = folder.with_name(f".{folder.name}.{journal_key(plan, through)}.journal")
    rows, facts = sweep(
        plan, journal, through=through, workers=workers, dask=dask, progress=progress
    )
    with replace_folder(place) as draft:
        made = table_of(plan, rows)
        write_rows(made, draft / table)
        problems = _drawn(plan, rows, draft / _PICTURE)
        summary = summary_of(plan, rows, {**facts, "table": table, "problems": problems})
        summary["origin"] = place.origin
        summary["files"] = write_summary(summary, draft)
    journal.unlink(missing_ok=True)
    return plan, made, summary, folder


def _drawn(plan: Plan, rows: list[Row], path: Path) -> list[str]:
    """Draw the sweep; return the problems, a line each."""
    if all(value is None for row in rows for value in row.values):
        return []
    points = [plan.points[row.run] for row in rows]
    measured = {name: [row.values[k] for row in rows] for k, name in enumerate(plan.measures)}
    problems: list[str] = []
    with draws_or_tells(path.name, problems):
        figures.save(picture_of(plan, points, measured), path)
    return problems


def picture_of(
    plan: Plan,
    points: Sequence[Sequence[Value]],
    measured: Mapping[str, Sequence[float | int | None]],
) -> Figure:
    """Return the picture of runs of a plan, of a peak with its magnitude.

    Parameters
    ----------
    points : the values of the keys in each run
    measured : each measure to draw, of each run
    """
    varied = {
        key: (unit, _drawable(values, size))
        for key, (unit, size), values in zip(
            plan.keys, plan.shown, zip(*points, strict=True), strict=True
        )
    }
    known = plan.scene.fmu.measures()
    taken = {}
    for name, found in measured.items():
        in_si = known[name].unit_of_one
        unit, factor = shown_in(in_si)
        values = factor * np.array(found, float)  # None becomes not a number
        signed = has_sign(name)
        size = (abs(values) if signed else values).tolist()
        taken[f"magnitude of {name}" if signed else name] = (unit or in_si, size)
    return figures.sweep(varied, taken, title=plan.title or plan.name)


def _drawable(values: Sequence[Value], size: float) -> list[float] | list[str]:
    """Return the values of a key as numbers in the unit shown, or as texts."""
    if any(isinstance(value, str | bool) for value in values):
        return [str(value).lower() if isinstance(value, bool) else str(value) for value in values]
    return [float(value) / size for value in values]
