"""`phaseplane show` and `phaseplane compare`: files of results."""

from __future__ import annotations

from pathlib import Path

import click

from phaseplane import recording

from .. import draw
from ..errors import InputError, check_recording
from ..look import FigureFile
from ..results.folder import OUTPUT, read_summary
from ..results.inspection import (
    contents,
    difference,
    first_difference,
    format_contents,
    format_difference,
    results_in,
    timed,
)
from ..results.plain import as_json
from ..scene.names import meant
from .console import DONE, FAILED, FiniteRange, complain, json_option, pair
from .viewing import figure_options, save_option

_columns = click.option(
    "--column", "columns", multiple=True, metavar="NAME", help="Use only this column. Repeatable."
)


@click.command()
@click.argument(
    "paths", metavar="RESULTS...", nargs=-1, required=True, type=click.Path(path_type=Path)
)
@_columns
@figure_options("all columns, or those chosen, over time")
@click.option(
    "--plane",
    type=pair,
    metavar="X,Y",
    help="Draw column Y over column X, such as a rate over its displacement.",
)
@save_option
@json_option
def show(
    *,
    paths: tuple[Path, ...],
    columns: tuple[str, ...],
    figure: FigureFile | None,
    plane: tuple[str, str] | None,
    save: Path | None,
    as_data: bool,
) -> None:
    """Summarise RESULTS: a run's folder or a table.

    A table may be a CSV file from any program: units below the heading, a decimal comma and comments are
    read. With several RESULTS, all of them are drawn; the first is summarised and recorded. The others
    may also be TOML files with a table [measured], as for `compare`.
    """
    _check_there(*paths)
    if len(paths) > 1 and figure is None:
        raise InputError(
            "several results are drawn over one another: give --figure F.png, too; 'phaseplane compare' "
            "lists two of them side by side"
        )
    check_recording(save)
    if plane and not (figure or save):
        raise InputError("--plane needs a file to write: --figure F.png or --save F.rrd")
    results = results_in(paths[0])
    data = contents(results, paths[0], columns, figure, plane, paths[1:])
    if save is not None:
        found, units = timed(results, paths[0], columns, plane)
        title = str(data["summary"].get("title") or paths[0].name)
        content = draw.recording_content.of_table(title, found, units, plane)
        recording.record(content, save)
        data["files"] = [*data.get("files", []), str(save)]
    click.echo(as_json(data) if as_data else format_contents(data, paths[0]))


@click.command()
@click.argument("ours", metavar="A", type=click.Path(path_type=Path))
@click.argument("other", metavar="B", type=click.Path(path_type=Path))
@click.option(
    "--tolerance",
    type=FiniteRange(min=0.0),
    default=1e-6,
    show_default=True,
    help="Largest difference, relative to the column's peak, that counts as equal.",
)
@_columns
@click.option(
    "--common",
    is_flag=True,
    help="Compare only the rows, times and columns that both have.",
)
@figure_options("the columns that differ most")
@json_option
def compare(
    *,
    ours: Path,
    other: Path,
    tolerance: float,
    columns: tuple[str, ...],
    common: bool,
    figure: FigureFile | None,
    as_data: bool,
) -> int:
    """Compare the results A and B column by column.

    B may also be a TOML file with a table [measured], such as that of a fit, which gives a file of
    measured signals with its columns, units, offsets and time shift.

    Rows, times and columns that only one of them has also count as differences. Exit status 1 if they
    differ.
    """
    _check_there(ours, other)
    data = difference(ours, other, tolerance, columns, figure, common=common)
    click.echo(as_json(data) if as_data else format_difference(data))
    if data["equal"]:
        return DONE
    complain(first_difference(data))
    return FAILED


def _check_there(*paths: Path) -> None:
    """Reject results that do not exist, suggesting similar names.

    Raises
    ------
    InputError : if one of the paths does not exist.
    """
    for path in paths:
        if not path.exists():
            kept = OUTPUT / path
            known = read_summary(kept) is not None
            hint = f"; did you mean {kept}?" if known else meant(str(path), "results")
            raise InputError(f"no such file or folder: {path}{hint}")
