"""The model description of a native FMU for FMI 2.0, and the parts shared with FMI 3.0."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.models import ALL
from phaseplane.suspension.variables import Value, Variable, variables

from ..model_description import (
    CHOSEN,
    in_words,
    model_structure,
    range_and_unit,
    unit_definitions,
    written,
)
from .model import Translation

_CATEGORIES = {
    "logEvents": "Times of lift-off, touchdown and contact with end stops.",
    "logStatusDiscard": "Steps that failed.",
    "logStatusError": "Calls and values that were refused.",
    "logAll": "All messages.",
}
_EXPERIMENT = {"startTime": "0.0", "stopTime": "1.0", "tolerance": "1e-06", "stepSize": "0.001"}
_TYPES = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
_MAKERS = {"author": "The phaseplane developers", "license": "MIT",
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
    root = begun(model, {"fmiVersion": "2.0", "guid": token}, about)
    kind = SubElement(
        root, "CoSimulation", modelIdentifier=model, canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true", canSerializeFMUstate="true",
        canNotUseMemoryManagementFunctions="true", maxOutputDerivativeOrder="1",
        providesDirectionalDerivative="true",
    )  # fmt: skip
    SubElement(SubElement(kind, "SourceFiles"), "File", name="all.c")
    root.append(unit_definitions(declared))
    append_categories(root)
    held = SubElement(root, "ModelVariables")
    for k, variable in enumerate(declared):
        value = start.get(variable.name, variable.start)
        _variable(held, k, variable, value, variable.name in in_c.fixed)
    root.append(model_structure(declared))
    return written(root)


def begun(model: str, given: Mapping[str, str], about: Mapping[str, str]) -> Element:
    """Return the root of a description, with the attributes given and those of both versions of FMI."""
    told = {k: v for k, v in about.items() if v and k != "guid"}
    names = {"modelName": model, "description": ALL[model].summary}
    return Element(
        "fmiModelDescription",
        {**given, **names, "variableNamingConvention": "structured", **_MAKERS, **told},
    )


def append_categories(root: Element) -> None:
    """Append the categories of log messages and the default experiment."""
    categories = SubElement(root, "LogCategories")
    for name, text in _CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(root, "DefaultExperiment", _EXPERIMENT)


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
    detail = {} if isinstance(start, str | bool) else range_and_unit(variable)
    if variable.causality != "output":
        text = str(start).lower() if isinstance(start, bool) else repr(start)
        detail["start"] = start if isinstance(start, str) else text
    if isinstance(start, int) and not isinstance(start, bool):
        return {k: str(int(float(v))) for k, v in detail.items() if k in ("min", "max", "start")}
    return detail
