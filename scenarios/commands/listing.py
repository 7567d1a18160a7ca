"""`phaseplane list`: the scenes and sweeps in the package."""

from __future__ import annotations

import click

from ..results.plain import as_json
from ..scene.layers import case_titles
from ..sweeps.shipped import sweep_titles
from .console import json_option


@click.command("list")
@json_option
def list_cases(as_data: bool) -> None:
    """List the scenes and sweeps in the package."""
    titles = {"scenes": case_titles(), "sweeps": sweep_titles()}
    if as_data:
        click.echo(as_json(titles))
        return
    width = max(len(name) for named in titles.values() for name in named)
    for command, named in zip(("run", "sweep"), titles.values(), strict=True):
        click.echo(f"phaseplane {command}")
        for name, title in named.items():
            click.echo(f"  {name:<{width}}  {title}")
