"""`phaseplane list`: the scenes, sweeps and models in the package, or the parameters of an FMU."""

from __future__ import annotations

import click
from phaseplane.suspension.models import ALL, FILES
from phaseplane.suspension.variables import Value, Variable

from ..results.plain import as_json
from ..results.quantities import with_unit
from ..scene.equation import EQUATION, SUMMARY
from ..scene.fmus import Fmu, fmu_named
from ..scene.layers import case_titles
from ..scene.names import sweep_titles
from .console import json_option


@click.command("list")
@click.argument("fmu", required=False)
@json_option
def list_cases(fmu: str | None, as_data: bool) -> None:
    """List built-in scenes, sweeps and models, or the parameters of FMU.

    FMU is a file or a model. Its parameters are grouped by the time at which they can be set: when a
    native FMU is packed, before a run, or during a run.
    """
    if fmu is not None:
        _list_parameters(fmu_named(fmu, sources=True), as_data)
        return
    models = {name: ALL[name].summary for name in FILES} | {EQUATION: SUMMARY}
    titles = {"scenes": case_titles(), "sweeps": sweep_titles(), "models": models}
    if as_data:
        click.echo(as_json(titles))
        return
    width = max(len(name) for named in titles.values() for name in named)
    for command, named in zip(("run", "sweep", "schema"), titles.values(), strict=True):
        click.echo(f"phaseplane {command}")
        for name, title in named.items():
            click.echo(f"  {name:<{width}}  {title}")


def _list_parameters(fmu: Fmu, as_data: bool) -> None:
    parameters = fmu.parameters().values()
    groups: dict[str, list[Variable]] = {
        "fixed when the FMU was packed": [v for v in parameters if v.name in fmu.fixed],
        "set before a run": [v for v in parameters if v.name not in fmu.fixed and not v.tunable],
        "also set during a run": [v for v in parameters if v.name not in fmu.fixed and v.tunable],
    }
    groups = {words: listed for words, listed in groups.items() if listed}
    if as_data:
        values = {words: {v.name: v.start for v in listed} for words, listed in groups.items()}
        click.echo(as_json(values))
        return
    width = max((len(v.name) for listed in groups.values() for v in listed), default=0)
    for words, listed in groups.items():
        click.echo(words)
        for v in listed:
            click.echo(f"  {v.name:<{width}}  {with_unit(_as_set(v.start), v.unit)}")


def _as_set(value: Value) -> str:
    """Return a value as `--set` takes it."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value) or "none"
