"""What helps to write scenes: their keys, and a template."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import InputError
from ..results.folder import as_json
from .console import json_option
from .guide import guide, json_schema, sweep_guide, sweep_schema
from .template import write_template


@click.command()
@click.argument("model", required=False)
@click.option("--sweep", is_flag=True, help="Tell what a sweep file may say.")
@json_option
def schema(model: str | None, sweep: bool, as_data: bool) -> None:
    """Explain the keys of a scene, or the variables of MODEL.

    The variables are its parameters, outputs and measures. As JSON it is a JSON Schema, by which
    editors can check scene files.
    """
    if sweep and model:
        raise InputError("schema: give a MODEL or --sweep, not both")
    if as_data:
        click.echo(as_json(sweep_schema() if sweep else json_schema(model)))
    else:
        click.echo(sweep_guide() if sweep else guide(model))


@click.command()
@click.argument("path", metavar="FILE.toml", type=click.Path(path_type=Path))
@click.option("--model", default="QuarterCar", show_default=True, help="The FMU of the scene.")
def new(path: Path, model: str) -> None:
    """Write a scene to begin with, its choices explained."""
    write_template(path, model)
    click.echo(f"{path}: run it with 'phaseplane run {path}'")
