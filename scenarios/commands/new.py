"""`phaseplane new`: write a scene to start from."""

from __future__ import annotations

from pathlib import Path

import click

from .template import write_template


@click.command()
@click.argument("path", metavar="FILE.toml", type=click.Path(path_type=Path))
@click.option("--model", default="QuarterCar", show_default=True, help="Model of the scene.")
def new(path: Path, model: str) -> None:
    """Write a commented scene to start from."""
    write_template(path, model)
    click.echo(f"{path}: run it with 'phaseplane run {path}'")
