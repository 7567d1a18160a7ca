"""The model description of an FMU for FMI 2.0, and the parts that it shares with that for FMI 3.0.

It follows from the tables of variables and units.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from sys import float_info
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.models import ALL
from phaseplane.suspension.units import UNITS
from phaseplane.suspension.variables import Value, Variable, variables

_CATEGORIES = {
    "logEvents": "Times of lift-off, touchdown and contact with end stops.",
    "logStatusWarning": "What has no effect, costs accuracy or takes longer.",
    "logStatusError": "Calls and values that were refused.",
}
_DISCARDED = {"logStatusDiscard": "Steps that failed."}
_FAILED = {"logStatusError": "Calls and values that were refused, and steps that failed."}
STOP_TIME = 1.0
"""Stop time, s, of the default experiment of an FMU that is not packed from a scene."""
_EXPERIMENT = {"tolerance": "1e-06", "stepSize": "0.001"}
_TYPES = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
_MAKERS = {"author": "The phaseplane developers", "license": "MIT",
           "copyright": "(c) 2026 The phaseplane developers"}  # fmt: skip
_CAN = dict.fromkeys(
    ("canHandleVariableCommunicationStepSize", "canGetAndSetFMUstate", "canSerializeFMUstate",
     "canNotUseMemoryManagementFunctions"), "true"
)  # fmt: skip
_CAN_IN_C = {"maxOutputDerivativeOrder": "1", "providesDirectionalDerivative": "true"}
CHOSEN = "; chosen when the FMU was packed"
"""How the description ends of a parameter that keeps the value with which a native FMU was packed."""


def description(
    model: str,
    start: Mapping[str, Value],
    about: Mapping[str, str],
    token: str = "",
    *,
    stop_time: float = STOP_TIME,
    fixed: Collection[str] = (),
    native: bool = False,
) -> Element:
    """Return the model description (FMI 2.0.4, section 2.2).

    Parameters
    ----------
    model : `QuarterCar`
    start : parameters whose start values are not the defaults
    about : version of the model, tool and date; empty ones are left out
    token : the GUID
    stop_time : of the default experiment, s
    fixed : names of the parameters that keep the values with which the FMU is packed
    native : whether the FMU has sources in C and needs no Python
    """
    declared = variables(model)
    root = begun(model, {"fmiVersion": "2.0", "guid": token}, about)
    more = _CAN_IN_C if native else {"needsExecutionTool": "true"}
    kind = SubElement(root, "CoSimulation", {"modelIdentifier": model, **_CAN, **more})
    if native:
        SubElement(SubElement(kind, "SourceFiles"), "File", name="all.c")
    root.append(unit_definitions(declared))
    append_categories(root, stop_time, discards=True)
    held = SubElement(root, "ModelVariables")
    for k, variable in enumerate(declared):
        said = role(k, variable, variable.name in fixed, isinstance(variable.start, float))
        detail = values(variable, start.get(variable.name, variable.start))
        SubElement(SubElement(held, "ScalarVariable", said), _TYPES[type(variable.start)], detail)
    root.append(_structure(declared))
    return root


def begun(model: str, given: Mapping[str, str], about: Mapping[str, str]) -> Element:
    """Return the root of a description, with the attributes given and those of both versions of FMI."""
    told = {k: v for k, v in about.items() if v}
    names = {"modelName": model, "description": ALL[model].summary}
    return Element(
        "fmiModelDescription",
        {**given, **names, "variableNamingConvention": "structured", **_MAKERS, **told},
    )


def append_categories(root: Element, stop_time: float, *, discards: bool) -> None:
    """Append the categories of log messages and the default experiment.

    Parameters
    ----------
    stop_time : of the default experiment, s
    discards : whether steps that failed are discarded, rather than errors
    """
    categories = SubElement(root, "LogCategories")
    for name, text in (_CATEGORIES | (_DISCARDED if discards else _FAILED)).items():
        SubElement(categories, "Category", name=name, description=text)
    times = {"startTime": "0.0", "stopTime": repr(stop_time)}
    SubElement(root, "DefaultExperiment", {**times, **_EXPERIMENT})


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
    detail = {} if isinstance(start, str | bool) else _range_and_unit(variable)
    if variable.causality != "output":
        text = str(start).lower() if isinstance(start, bool) else repr(start)
        detail["start"] = start if isinstance(start, str) else text
    if isinstance(start, int) and not isinstance(start, bool):
        return {k: str(int(float(v))) for k, v in detail.items() if k in ("min", "max", "start")}
    return detail


def in_words(variable: Variable) -> str:
    """Return the description of a variable, with its allowed values."""
    if variable.choices:
        return f"{variable.description}; one of: {', '.join(variable.choices)}"
    if variable.positive:
        return f"{variable.description}; greater than 0"
    return variable.description


def _range_and_unit(variable: Variable) -> dict[str, str]:
    """Return the attributes of a variable's range and unit."""
    attributes = {
        "unit": variable.unit or None,
        "displayUnit": variable.display or None,
        # bounds are inclusive: the least number with all digits that is greater than 0
        "min": float_info.min if variable.positive else variable.minimum,
        "max": variable.maximum,
        "nominal": variable.nominal,
    }
    return {name: str(value) for name, value in attributes.items() if value is not None}


def unit_definitions(declared: tuple[Variable, ...]) -> Element:
    """Return the units of variables, with their base units and display units."""
    definitions = Element("UnitDefinitions")
    for name in sorted({variable.unit for variable in declared if variable.unit}):
        unit = SubElement(definitions, "Unit", name=name)
        SubElement(unit, "BaseUnit", {k: str(n) for k, n in UNITS[name].exponents.items()})
        for display, size in UNITS[name].display.items():
            # FMI multiplies the SI value by the factor; the table has the size of the unit
            SubElement(unit, "DisplayUnit", name=display, factor=repr(1.0 / size))
    return definitions


def _structure(declared: tuple[Variable, ...]) -> Element:
    """Return the outputs and the unknowns of initialisation.

    During a run an output belongs to the last step, which inputs set afterwards do not affect: no
    output depends on an input, and there are no algebraic loops. At the start outputs follow inputs
    and parameters; no list of dependencies is given there, which means all of them.
    """
    structure = Element("ModelStructure")
    places = [k for k, v in enumerate(declared) if v.causality == "output"]
    outputs, initial = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    for k in places:
        SubElement(outputs, "Unknown", index=str(k + 1), dependencies="")
        SubElement(initial, "Unknown", index=str(k + 1))
    return structure


def written(root: Element) -> bytes:
    """Return a document as indented XML."""
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True))
