"""`phaseplane schema`: explain the keys of scenes and sweeps."""

from __future__ import annotations

import click

from ..errors import InputError
from ..results.plain import as_json
from .console import json_option
from .guide import guide, json_schema, sweep_guide, sweep_schema


@click.command()
@click.argument("model", required=False)
@click.option("--sweep", is_flag=True, help="Explain the keys of a sweep file instead.")
@json_option
def schema(model: str | None, sweep: bool, as_data: bool) -> None:
    """Explain the keys of a scene, or the variables of MODEL.

    The variables are its parameters, outputs and measures. With --json, print a JSON Schema that
    editors can check scene files against.
    """
    if sweep and model:
        raise InputError("schema: give a MODEL or --sweep, not both")
    if as_data:
        click.echo(as_json(sweep_schema() if sweep else json_schema(model)))
    else:
        click.echo(sweep_guide() if sweep else guide(model))
