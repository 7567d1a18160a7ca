"""`phaseplane schema`: explain the keys of scenes, sweeps and studies."""

from __future__ import annotations

import click

from ..errors import InputError
from ..results.plain import as_json
from .console import json_option
from .guide import file_guide, file_schema, guide, json_schema


@click.command()
@click.argument("model", required=False)
@click.option("--sweep", "kind", flag_value="sweep", help="Explain a sweep file instead.")
@click.option(
    "--optimise", "kind", flag_value="optimise", help="Explain a file of optimise instead."
)
@click.option("--fit", "kind", flag_value="fit", help="Explain a file of fit instead.")
@json_option
def schema(model: str | None, kind: str | None, as_data: bool) -> None:
    """Explain the keys of a scene, or the variables of MODEL.

    The variables are its parameters, outputs and measures. With --json, print a JSON Schema that
    editors can check files against.
    """
    if kind and model:
        raise InputError(f"schema: give a MODEL or --{kind}, not both")
    if as_data:
        click.echo(as_json(file_schema(kind) if kind else json_schema(model)))
    else:
        click.echo(file_guide(kind) if kind else guide(model))
