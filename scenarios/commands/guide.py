"""`phaseplane schema`: the keys of scenes, sweeps and studies, from what they are checked against."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from textwrap import fill
from typing import Any

import click
from phaseplane.suspension.variable import is_table
from phaseplane.suspension.variables import MODELS, SOURCES, Variable

from ..design.files import FitFile, OptimumFile
from ..errors import InputError
from ..results.plain import as_json
from ..scene.equation import EQUATION
from ..scene.fields import schema_of
from ..scene.file import SceneFile
from ..scene.fmus import fmu_named
from ..scene.names import SWEEPS
from ..sweeps.plan import Range, SweepFile
from .console import json_option

FILES: dict[str, tuple[str, type]] = {
    "": ("A scene runs a model and says what is shown of the run", SceneFile),
    "sweep": ("A sweep runs a scene many times", SweepFile),
    "optimise": ("An optimisation finds the best parameters of a scene", OptimumFile),
    "fit": ("A fit finds the parameters with which a scene gives measured signals", FitFile),
}
"""What files are, by the option that explains them, and their tables."""
_VALUES = "Values are numbers in SI, or strings with a unit: 0.05 or '5 cm'."
_EXAMPLE = "speed_bump"  # a sweep that comes with the package
_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_TYPES = {float: "number", bool: "boolean", int: "integer", str: "string"}


@click.command()
@click.argument("model", required=False)
@click.option("--sweep", is_flag=True, help="Explain a sweep file instead.")
@click.option("--optimise", is_flag=True, help="Explain a file of optimise instead.")
@click.option("--fit", is_flag=True, help="Explain a file of fit instead.")
@json_option
def schema(model: str | None, as_data: bool, **files: bool) -> None:
    """Explain the keys of a scene, or the variables of MODEL.

    The variables are its parameters, outputs and measures. With --json, print a JSON Schema that
    editors can check files against.
    """
    kind, *more = [*(kind for kind, wanted in files.items() if wanted), ""]
    if any(more) or (kind and model):
        raise InputError("schema: give only one of MODEL, --sweep, --optimise and --fit")
    if as_data:
        click.echo(as_json(file_schema(kind) if kind else json_schema(model)))
    else:
        click.echo(file_guide(kind) if model is None else guide(model))


def file_guide(kind: str) -> str:
    """Return the keys of a file of one of the kinds in `FILES`, as text."""
    about, table = FILES[kind]
    lines = [fill(f"{about}. It is a TOML file. {_VALUES}", 100), "", *_explained(schema_of(table))]
    if kind == "sweep":
        example = (SWEEPS / f"{_EXAMPLE}.toml").read_text(encoding="utf-8")
        lines += ["", "A range in [vary]", *_keys(schema_of(Range)["properties"])]
        lines += ["", "For example:", "", *example.splitlines()]
    elif not kind:
        models = ", ".join((*MODELS, *SOURCES, EQUATION))
        lines += [
            "",
            fill(f"phaseplane schema MODEL lists the variables and measures of {models};", 100),
        ]
        lines.append(
            "phaseplane schema --sweep, --optimise and --fit explain the keys of other files."
        )
    return "\n".join(lines)


def file_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a file of one of the kinds in `FILES`."""
    about, table = FILES[kind]
    return {"$schema": _DIALECT, "title": about, **schema_of(table)}


def json_schema(model: str | None) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a scene file for a model.

    Parameters
    ----------
    model : the model whose parameters and measures it includes; QuarterCar if None

    Raises
    ------
    InputError : if there is no such model.
    """
    fmu = fmu_named(model or "QuarterCar")
    schema = {**file_schema(""), "title": f"A scene that runs {fmu.model}"}
    keys = schema["properties"]
    keys["parameters"]["properties"] = {v.name: _schema_of(v) for v in fmu.parameters().values()}
    bounds = {"type": ["integer", "object", "array"], "properties": {"min": {}, "max": {}}}
    keys["expect"]["properties"] = keys["expect"]["properties"] | {
        name: {**bounds, "description": measure.about, "unit": measure.unit}
        for name, measure in fmu.measures().items()
    }
    return schema


def _explained(schema: Mapping[str, Any], inside: str = "") -> Iterator[str]:
    """Explain the keys of a table, then those of the tables in it."""
    tables = {}
    for key, said in schema["properties"].items():
        if "properties" in (inner := said.get("items", said)):
            tables[key] = said, inner
        else:
            yield from _keys({key: said})
    if "description" in (others := schema.get("additionalProperties") or {}):
        yield from _keys({"INPUT": others})
    for key, (said, inner) in tables.items():
        name = f"[{inside}{key}]"
        yield ""
        yield fill(f"{name if inner is said else f'[{name}]'}  {said['description']}", 100,
                   subsequent_indent="  ")  # fmt: skip
        yield from _explained(inner, f"{inside}{key}.")


def _keys(properties: Mapping[str, Any]) -> Iterator[str]:
    """Explain the keys of a table, from its schema."""
    for key, said in properties.items():
        allowed = said.get("enum") or said.get("items", {}).get("enum") or ()
        words = f"{said['description']}{': ' if allowed else ''}{_text(allowed)}"
        yield _key(key, said.get("unit", ""), words + _default(said.get("default")))
        for meant in said.get("oneOf", ()):
            yield fill(
                f"{meant['const'] + ':':<26} {meant['description']}", 100,
                initial_indent=" " * 4, subsequent_indent=" " * 31, break_on_hyphens=False,
            )  # fmt: skip


def guide(model: str) -> str:
    """Return the parameters, outputs and measures of a model, as text.

    Raises
    ------
    InputError : if there is no such model.
    """
    return "\n".join(_of_model(model))


def _of_model(name: str) -> Iterator[str]:
    fmu = fmu_named(name, sources=True)
    outputs = fmu.outputs()
    inputs = {v.name: v for v in fmu.variables if v.causality == "input"}
    for heading, declared in (
        ("parameters", fmu.parameters()), ("inputs", inputs), ("outputs", outputs)
    ):  # fmt: skip
        if not declared:
            continue
        yield f"{fmu.model}: {heading}"
        for v in declared.values():
            start = _default(v.start) if heading == "parameters" else ""
            words = f"{v.description}{': ' + ', '.join(v.choices) if v.choices else ''}{start}"
            yield _key(v.name, v.unit, words)
        yield ""
    if name in SOURCES:
        yield f"{name} drives other FMUs; a scene cannot run it alone."
        return
    yield f"{fmu.model}: measures"
    yield _key("peak.X", "", "signed value of largest magnitude of any output X over the run")
    yield _key("rms.X", "", "root mean square of any output X over the run")
    yield _key("amplitude.X", "", "half the range of any output X over the second half of the run")
    for measure in fmu.measures().values():
        if not measure.name.startswith(("peak.", "rms.", "amplitude.")):
            source = f" ({measure.source})" if measure.source else ""
            yield _key(measure.name, measure.unit, measure.about + source)


def _key(name: str, unit: str, words: str) -> str:
    head = f"  {name} [{unit}]" if unit not in ("", "1") else f"  {name}"
    gap = " " * 29
    about = fill(words, 100, initial_indent=gap, subsequent_indent=gap, break_on_hyphens=False)
    return f"{head}\n{about}" if len(head) >= len(gap) else head + about[len(head) :]


def _default(value: object) -> str:
    """Return the default in brackets, or "" where it is empty."""
    return "" if value in (None, "", [], ()) else f" (default {_text(value)})"


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return ", ".join(map(_text, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _schema_of(variable: Variable) -> Mapping[str, Any]:
    kind = _TYPES[type(variable.start)]
    said: dict[str, Any] = {"description": variable.description, "default": variable.start}
    said["type"] = ["number", "string"] if kind == "number" and variable.unit else kind
    if is_table(variable.name):  # may be read from a file
        said["type"] = ["string", "object"]
    if variable.unit:
        said["unit"] = variable.unit
    if variable.choices:
        said["enum"] = list(variable.choices)
    if variable.positive:
        said["exclusiveMinimum"] = 0.0
    elif variable.minimum is not None:
        said["minimum"] = variable.minimum
    if variable.maximum is not None:
        said["maximum"] = variable.maximum
    return said
