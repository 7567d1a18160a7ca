"""The keys of a scene file, each with its type and its meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from phaseplane.suspension.variables import MODELS

from ..results.signals import MEASURED
from .controller import SCHEMA as CONTROLLER
from .equation import EQUATION
from .expectations import During, Reference
from .fields import SECONDS, TABLE, TEXT, Kind, entry, instance_of, schema_of, table_of
from .sections import Construction, Show

_MODEL = Kind(
    instance_of(str, "a model's name or the path of an .fmu, .toml or .py file"), TEXT.schema
)
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
_TEXTS = ("name", "about", "source")  # the others are tables
_SYSTEM = {
    "type": "object",
    "properties": {
        key: {"description": about, "type": "string" if key in _TEXTS else "object"}
        for key, about in _OF_SYSTEM.items()
    },
    "required": ["name", "coordinates"],
}
_SHOW, _CONSTRUCTION = table_of(Show, "show"), table_of(Construction, "construction")


def _expectations() -> dict[str, Any]:
    """Return the schema of [expect] without the measures; a reference may be measured signals."""
    reference = schema_of(Reference)
    own = reference["properties"]
    own["columns"] |= {"type": ["array", "object"]}
    own["columns"]["description"] += "; or the heading of each output"
    reference["properties"] = {**own, **MEASURED["properties"], **own}
    reference["description"] = "a table of results that the run must agree with"
    during = {
        "type": "array",
        "description": "bounds on an output within an interval of time; repeatable",
        "items": schema_of(During),
    }
    return {"type": "object", "properties": {"during": during, "reference": reference}}


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneFile:
    """A scene file; parameters, controller and expectations are read once its model is known."""

    extends: str = entry(TEXT, "the built-in scene or scene file on which this one is based", "")
    title: str = entry(TEXT, "name of the run in reports and pictures", "")
    source: str = entry(TEXT, "source of its numbers", "")
    fmu: str = entry(
        _MODEL,
        f"{', '.join((*MODELS, EQUATION))}, or the path of an .fmu file, or of a system's .toml or .py "
        "file",
        "",
    )
    duration: float | None = entry(SECONDS, "time to simulate", None)
    parameters: Mapping[str, Any] | None = entry(
        TABLE,
        "parameters that differ from the FMU's defaults, by name; a table may be read from a CSV file "
        'with a header line: road.table = { file = "road.csv", columns = ["distance", "profile"], '
        'units = ["m", "mm"], delimiter = ";" }',
        None,
    )
    controller: Mapping[str, Any] | None = entry(
        Kind(TABLE.read, CONTROLLER), "what sets inputs of the model during the run", None
    )
    show: Show | None = entry(  # noqa: RUF009
        _SHOW, "what to compute, read and write; nothing else is", None
    )
    construction: Construction | None = entry(  # noqa: RUF009
        _CONSTRUCTION, "settings of the graphical construction", None
    )
    expect: Mapping[str, Any] | None = entry(
        Kind(TABLE.read, _expectations()),
        "bounds on measures: name = { min = ..., max = ... }, or a list of these, one for each value, as "
        "for natural_frequencies",
        None,
    )
    system: Mapping[str, Any] | None = entry(
        Kind(TABLE.read, _SYSTEM), "a system of your own, in the same file instead of fmu", None
    )
