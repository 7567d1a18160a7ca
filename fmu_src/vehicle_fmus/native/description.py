"""The model description of a native FMU for FMI 2.0, and the parts shared with FMI 3.0."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.models import ALL
from phaseplane.suspension.variables import Value, Variable, variables

from ..model_description import CHOSEN, in_words, model_structure, unit_definitions, written
from .model import Translation

CATEGORIES = {
    "logEvents": "Times of lift-off, touchdown and contact with end stops.",
    "logStatusDiscard": "Steps that failed.",
    "logStatusError": "Calls and values that were refused.",
    "logAll": "All messages.",
}
EXPERIMENT = {"startTime": "0.0", "stopTime": "1.0", "tolerance": "1e-06", "stepSize": "0.001"}
_TYPES = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
SPEAKING = {"author": "The phaseplane developers", "license": "MIT",
            "copyright": "(c) 2026 The phaseplane developers"}  # fmt: skip


def description(
    model: str,
    start: Mapping[str, Value],
    in_c: Translation,
    about: Mapping[str, str],
    token: str,
) -> bytes:
    """Return modelDescription.xml.

    Parameters
    ----------
    model : `QuarterCar`
    start : parameters whose start values are not the defaults
    in_c : the model in C, which tells what is fixed and what is left out
    about : version of the model, tool and date; empty ones are left out
    token : the GUID
    """
    declared = variables(model)
    given = {k: v for k, v in about.items() if v and k != "guid"}
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0", "modelName": model, "guid": token, "description": ALL[model].summary,
            "variableNamingConvention": "structured", **SPEAKING, **given,
        },
    )  # fmt: skip
    kind = SubElement(
        root, "CoSimulation", modelIdentifier=model, canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true", canSerializeFMUstate="true",
        canNotUseMemoryManagementFunctions="true", maxOutputDerivativeOrder="1",
        providesDirectionalDerivative="true",
    )  # fmt: skip
    SubElement(SubElement(kind, "SourceFiles"), "File", name="all.c")
    root.append(unit_definitions(declared))
    categories = SubElement(root, "LogCategories")
    for name, text in CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    held = SubElement(root, "ModelVariables")
    for k, variable in enumerate(declared):
        value = start.get(variable.name, variable.start)
        _variable(held, k, variable, value, variable.name in in_c.fixed)
    root.append(model_structure(declared))
    return written(root)


def _variable(held: Element, k: int, variable: Variable, start: Value, fixed: bool) -> None:
    """Append one variable."""
    common = role(k, variable, fixed, isinstance(variable.start, float))
    detail = values(variable, start)
    SubElement(SubElement(held, "ScalarVariable", common), _TYPES[type(variable.start)], detail)


def role(k: int, variable: Variable, fixed: bool, continuous: bool) -> dict[str, str]:
    """Return the attributes that define the role of a variable.

    Parameters
    ----------
    k : its value reference
    fixed : whether it keeps the value with which the FMU was packed
    continuous : whether an output changes between switches, too
    """
    words = in_words(variable)
    if fixed:
        words += CHOSEN
    common = {
        "name": variable.name,
        "valueReference": str(k),
        "description": words,
        "causality": variable.causality,
    }
    if variable.causality == "parameter":
        common["variability"] = "tunable" if variable.tunable and not fixed else "fixed"
        common["initial"] = "exact"
    elif variable.causality == "input":
        common["variability"] = "continuous"
    else:
        common["variability"] = "continuous" if continuous else "discrete"
        common["initial"] = "calculated"
    return common


def values(variable: Variable, start: Value) -> dict[str, str]:
    """Return the attributes of a variable that belong to its type: start value, range and unit."""
    detail = {
        name: str(value)
        for name, value in {
            "unit": variable.unit or None,
            "displayUnit": variable.display or None,
            "min": 0.0 if variable.positive else variable.minimum,
            "max": variable.maximum,
            "nominal": variable.nominal,
        }.items()
        if value is not None and not isinstance(start, str | bool)
    }
    if variable.causality != "output" and not isinstance(start, str):
        detail["start"] = str(start).lower() if isinstance(start, bool) else repr(start)
    if isinstance(start, int) and not isinstance(start, bool):
        detail = {k: str(int(float(v))) for k, v in detail.items() if k in ("min", "max", "start")}
    if isinstance(start, str) and variable.causality != "output":
        detail["start"] = start
    return detail
