"""`phaseplane sweep`: vary parameters and scene keys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..results.plain import as_json
from ..sweeps.job import run_sweep
from ..sweeps.report import format_sweep
from ..sweeps.running import MOST_WORKERS
from .console import failed, json_option, output_option, progress_bar, warn


@click.command()
@click.argument("file", metavar="SWEEP")
@output_option("out/sweeps/SWEEP")
@click.option(
    "--through",
    type=click.Choice(["process", "fmu"]),
    default="process",
    show_default=True,
    help="Run the model in-process, or through its FMU.",
)
@click.option(
    "--workers",
    type=click.IntRange(1, MOST_WORKERS),
    help="Number of processes. [default: one per core]",
)
@click.option("--dask", metavar="ADDRESS", default="", help="Run on this Dask cluster.")
@click.option(
    "--table",
    metavar="NAME",
    default="runs.csv",
    show_default=True,
    help="Table of the runs; its ending, .csv or .parquet, sets the format.",
)
@json_option
def sweep(*, file: str, output: Path | None, as_data: bool, **how: Any) -> int:
    """Run a scene many times with varied parameters.

    SWEEP is a sweep of the package (see `list`) or a file that gives a grid, a list or a random
    sample of parameters (see `schema --sweep`). Start an interrupted sweep again to continue it.
    """
    with progress_bar(Path(file).stem) as progress:
        plan, runs, summary, folder = run_sweep(file, output, progress=progress, **how)
    warn(summary["warnings"])
    click.echo(as_json(summary) if as_data else format_sweep(plan, runs, summary, folder))
    failures, reasons = summary["failures"], list(summary["problems"])
    if failures:
        number = f"{len(failures)} of {summary['runs']} runs failed"
        reasons.insert(0, f"{number}: {failures[0]['reason']}")
    return failed(plan.name, reasons)
