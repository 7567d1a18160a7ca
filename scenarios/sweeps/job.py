"""A sweep from its file to its folder."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from phaseplane import figures

from ..errors import one_line
from ..measures import catalogue
from ..results.folder import check_replaceable, replaced_whole, write_summary
from .plan import Plan, load_plan
from .report import check_table, summary_of, write_rows
from .running import Row, sweep

OUTPUT = Path("out")
_PICTURE = "sweep.png"


def run_sweep(
    file: str | Path,
    folder: Path | None = None,
    *,
    through: str = "process",
    workers: int | None = None,
    dask: str = "",
    table: str = "runs.csv",
    progress: Callable[[float], None] | None = None,
) -> tuple[Plan, dict[str, Any], Path]:
    """Make the runs of a sweep file and leave rows, picture and summary in a folder.

    Parameters
    ----------
    file : the sweep, by its file or the name of one that comes with the package
    folder : None for `out/<file>`; replaced whole
    through, workers, dask, progress : see `running.sweep`
    table : name of the table of rows, ending in .csv or .parquet

    Returns
    -------
    The plan, the summary as it was written, and the folder.

    Raises
    ------
    InputError : a file that cannot be read, or a folder that must not be replaced.
    RunError : the runs could not begin.
    """
    check_table(table)
    plan = load_plan(file)
    folder = folder or OUTPUT / plan.name
    check_replaceable(folder)
    journal = folder.with_name(f".{folder.name}.journal")
    rows, told = sweep(
        plan, journal, through=through, workers=workers, dask=dask, progress=progress
    )
    with replaced_whole(folder) as draft:
        write_rows(plan, rows, draft / table)
        problems = _drawn(plan, rows, draft / _PICTURE)
        summary = summary_of(plan, rows, {**told, "table": table, "problems": problems})
        summary["files"] = write_summary(summary, draft)
    journal.unlink(missing_ok=True)
    return plan, summary, folder


def _drawn(plan: Plan, rows: list[Row], path: Path) -> list[str]:
    """Draw the sweep; a line for what could not be drawn."""

    def numbers(values: Iterable[object]) -> list[float]:
        return [float(x) if isinstance(x, int | float) else float("nan") for x in values]

    varied = {
        key: (unit, numbers(plan.points[row.run][k] for row in rows))
        for k, (key, unit) in enumerate(zip(plan.keys, plan.units, strict=True))
    }
    varied = {key: column for key, column in varied.items() if np.isfinite(column[1]).all()}
    known = catalogue(plan.scene.fmu.outputs())
    measured = {
        name: (known[name].unit, numbers(row.values[k] for row in rows))
        for k, name in enumerate(plan.measures)
    }
    measured = {n: m for n, m in measured.items() if np.isfinite(m[1]).any()}
    if not varied or not measured:
        return []
    try:
        figures.save(figures.sweep(varied, measured, title=plan.title or plan.name), path)
    except Exception as error:  # a picture that fails must not cost the rows
        return [one_line(f"{path.name} was not drawn: {error}")]
    return []
