"""Files of results shown and compared."""

from __future__ import annotations

from pathlib import Path

import click

from ..results.folder import as_json
from ..results.inspection import contents, contents_in_words, difference, difference_in_words
from .console import DONE, FAILED, complain, figure_option, json_option

_columns = click.option(
    "--column", "columns", multiple=True, metavar="NAME", help="Only this column. Repeatable."
)


@click.command()
@click.argument("what", metavar="RESULTS", type=click.Path(path_type=Path))
@_columns
@figure_option("the columns over time")
@json_option
def show(what: Path, columns: tuple[str, ...], figure: Path | None, as_data: bool) -> None:
    """Show what is in RESULTS: the folder of a run, or a table."""
    told = contents(what, columns, figure)
    click.echo(as_json(told) if as_data else contents_in_words(told, what))


@click.command()
@click.argument("ours", metavar="A", type=click.Path(path_type=Path))
@click.argument("other", metavar="B", type=click.Path(path_type=Path))
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0),
    default=1e-6,
    show_default=True,
    help="Largest difference, over the peak of the column, that counts as equal.",
)
@_columns
@figure_option("the columns that differ most")
@json_option
def compare(
    *,
    ours: Path,
    other: Path,
    tolerance: float,
    columns: tuple[str, ...],
    figure: Path | None,
    as_data: bool,
) -> int:
    """Compare the results A and B column by column.

    Exit status 1 if they differ.
    """
    told = difference(ours, other, tolerance, columns, figure)
    click.echo(as_json(told) if as_data else difference_in_words(told))
    if told["equal"]:
        return DONE
    worst = told["differences"][0]
    complain(
        f"{ours} and {other} differ: {worst['name']} by {worst['relative']:.3g} of its peak, "
        f"allowed: {tolerance:g}"
    )
    return FAILED
