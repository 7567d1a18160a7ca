"""`phaseplane schema`: the keys of scenes, sweeps and studies, from what they are checked against."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from textwrap import fill
from typing import Any

import click
from phaseplane.suspension.variables import MODELS, SOURCES, Variable

from ..design.files import MEASURED, FitFile, OptimumFile
from ..errors import InputError
from ..measures import catalogue
from ..results.plain import as_json
from ..scene.controller import KEYS as OF_CONTROLLER
from ..scene.equation import EQUATION
from ..scene.expectations import During, Reference
from ..scene.fields import schema_of
from ..scene.fmus import described, fmu_named
from ..scene.names import SWEEPS
from ..scene.sections import Construction, Show
from ..sweeps.plan import Range, SweepFile
from .console import json_option

_TOP = {
    "extends": ("", "the built-in scene or scene file on which this one is based"),
    "title": ("", "name of the run in reports and pictures"),
    "source": ("", "source of its numbers"),
    "fmu": (
        "",
        f"{', '.join((*MODELS, EQUATION))}, or the path of an .fmu file, or of a system's .toml or .py "
        "file",
    ),
    "duration": ("s", "time to simulate"),
}
_SECTIONS: dict[str, tuple[str, type]] = {
    "show": ("what to compute, read and write; nothing else is", Show),
    "construction": ("settings of the graphical construction", Construction),
    "[expect.during]": ("bounds on an output within an interval of time; repeatable", During),
    "expect.reference": ("a table of results that the run must agree with", Reference),
}
_CONTROLLER = "what sets inputs of the model during the run"
_FORMULA = "formula of outputs, t and constants, for any input of the model: actuator_force, ..."
_SYSTEM = "a system of your own, in the same file instead of fmu"
_TEXTS = ("name", "about", "source")
_OF_SYSTEM = {
    "name": "name of the model",
    "about": "what it is, for its page",
    "source": "source of its numbers",
    "parameters": "name = value with a unit, or { value = ..., about = ..., min = ..., max = ... }",
    "coordinates": "name = mass or moment of inertia, or { mass = ..., about = ..., angle = true }",
    "couplings": "off-diagonal entries of the mass matrix: first.second = ...",
    "wheels": "wheels with suspension and tyre: axle, body, load, and delay or level",
    "elements": "springs, dampers and friction along a direction: direction, spring, damper, ...",
    "loads": "forces along a direction, inputs of the model: direction, table, sine",
}
FILES: dict[str, tuple[str, type]] = {
    "sweep": ("A sweep runs a scene many times", SweepFile),
    "optimise": ("An optimisation finds the best parameters of a scene", OptimumFile),
    "fit": ("A fit finds the parameters with which a scene gives measured signals", FitFile),
}
"""What files other than scenes are, and their tables."""
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
        click.echo(file_guide(kind) if kind else guide(model))


def guide(model: str | None) -> str:
    """Return the keys of a scene, or the parameters, outputs and measures of a model, as text.

    Raises
    ------
    InputError : if there is no such model.
    """
    return "\n".join(_of_scenes() if model is None else _of_model(model))


def file_guide(kind: str) -> str:
    """Return the keys of a file of one of the kinds in `FILES`, as text."""
    about, table = FILES[kind]
    said = schema_of(table)["properties"]
    parts = [(f"[{key}]  {one['description']}", one) for key, one in said.items()]
    inner = [(head, one["properties"]) for head, one in parts if "properties" in one]
    if kind == "sweep":
        inner.append(("A range in [vary]", schema_of(Range)["properties"]))
    lines = [f"{about}. It is a TOML file.", ""]
    lines += _keys({key: one for key, one in said.items() if "properties" not in one})
    for head, keys in inner:
        lines += ["", head, *_keys(keys)]
    if kind == "sweep":
        example = (SWEEPS / f"{_EXAMPLE}.toml").read_text(encoding="utf-8")
        lines += ["", "For example:", "", *example.splitlines()]
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
    known = catalogue(fmu.outputs())
    sections = {name: _section(name) for name in _SECTIONS}
    bounds = {"type": ["integer", "object", "array"], "properties": {"min": {}, "max": {}}}
    properties: dict[str, Any] = {
        key: {"description": about, "type": ["number", "string"] if unit == "s" else "string"}
        for key, (unit, about) in _TOP.items()
    }
    properties["parameters"] = {
        "type": "object",
        "properties": {v.name: _schema_of(v) for v in fmu.parameters().values()},
    }
    properties["expect"] = {
        "type": "object",
        "properties": {
            "during": {"type": "array", "items": sections.pop("[expect.during]")},
            "reference": sections.pop("expect.reference"),
            **{n: {**bounds, "description": m.about, "unit": m.unit} for n, m in known.items()},
        },
    }
    properties["controller"] = {
        "type": "object",
        "description": _CONTROLLER,
        "properties": OF_CONTROLLER,
        "additionalProperties": {"type": "string", "description": _FORMULA},
    }
    properties["system"] = {
        "type": "object",
        "description": _SYSTEM,
        "properties": {
            key: {"description": about, "type": "string" if key in _TEXTS else "object"}
            for key, about in _OF_SYSTEM.items()
        },
        "required": ["name", "coordinates"],
    }
    return {
        "$schema": _DIALECT,
        "title": f"A scene that runs {fmu.model}",
        "type": "object",
        "properties": properties | sections,
    }


def _section(name: str) -> dict[str, Any]:
    """Return the JSON Schema of a section; a reference may be measured signals."""
    schema = schema_of(_SECTIONS[name][1])
    if _SECTIONS[name][1] is Reference:
        own = schema["properties"]
        own["columns"] |= {"type": ["array", "object"]}
        own["columns"]["description"] += "; or the heading of each output"
        own |= {key: said for key, said in MEASURED["properties"].items() if key not in own}
    return schema


def _of_scenes() -> Iterator[str]:
    yield "A scene is a TOML file. Values are numbers in SI, or strings with a unit: 0.05 or '5 cm'."
    yield ""
    yield from (_key(key, unit, about) for key, (unit, about) in _TOP.items())
    yield ""
    yield "[parameters]  parameters that differ from the FMU's defaults, by name"
    yield '  a table may be read from a CSV file with a header line: road.table = { file = "road.csv",'
    yield '  columns = ["distance", "profile"], units = ["m", "mm"], delimiter = ";" }'
    yield ""
    yield f"[controller]  {_CONTROLLER}"
    yield from _keys({**OF_CONTROLLER, "INPUT": {"description": _FORMULA}})
    for name, (about, _) in _SECTIONS.items():
        yield ""
        yield f"[{name}]  {about}"
        yield from _keys(_section(name)["properties"])
    yield ""
    yield "[expect]  bounds on measures: name = { min = ..., max = ... }, or a list of these, one"
    yield "  for each value, as for natural_frequencies"
    yield ""
    yield f"[system]  {_SYSTEM}"
    yield from _keys({key: {"description": about} for key, about in _OF_SYSTEM.items()})
    yield ""
    models = ", ".join((*MODELS, EQUATION, *SOURCES))
    yield fill(f"phaseplane schema MODEL lists the variables and measures of {models};", 100)
    yield "phaseplane schema --sweep, --optimise and --fit explain the keys of other files."


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


def _of_model(name: str) -> Iterator[str]:
    fmu = described(name)
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
    for measure in catalogue(outputs).values():
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
    if variable.name.endswith("table"):  # may be read from a file
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
