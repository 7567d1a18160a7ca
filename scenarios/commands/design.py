"""`phaseplane optimise` and `phaseplane fit`: parameters that are best, or that fit a measured signal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from ..design.job import Study, fit_parameters
from ..design.job import optimise as find_optimum
from ..results.plain import as_json
from .console import failed, json_option, output_option, progress_bar

_output = output_option("out/studies/FILE")


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@_output
@json_option
def optimise(file: Path, output: Path | None, as_data: bool) -> int:
    """Find the best parameters of a scene within bounds.

    FILE gives a scene, the measure to minimise or maximise, the ranges of the parameters, and bounds on
    other measures. Start an interrupted search again to continue it. Exit status 1 if no point keeps all
    bounds.
    """
    with progress_bar(file.stem) as progress:
        study = find_optimum(file, output, progress)
    infeasible = [] if study.summary["feasible"] else ["no point satisfies all bounds"]
    return _ended(file, study, as_data, infeasible)


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@_output
@json_option
def fit(file: Path, output: Path | None, as_data: bool) -> int:
    """Fit parameters of a scene to measured signals.

    FILE gives a scene, the ranges of the parameters, and the file of the signals with its columns and
    units. Start an interrupted fit again to continue it.
    """
    with progress_bar(file.stem) as progress:
        study = fit_parameters(file, output, progress)
    return _ended(file, study, as_data)


def _ended(file: Path, study: Study, as_data: bool, reasons: Sequence[str] = ()) -> int:
    click.echo(as_json(study.summary) if as_data else study.report)
    return failed(file.stem, [*reasons, *study.summary["problems"]])
