"""Parts of the model description that pythonfmu does not write: units, ranges, dependencies.

They follow from the tables of variables and units, so this module is not packed into the FMU.
"""

from __future__ import annotations

from collections.abc import Mapping
from sys import float_info
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.units import UNITS
from phaseplane.suspension.variables import Value, Variable, variables

CHOSEN = "; chosen when the FMU was packed"
"""How the description ends of a parameter that keeps the value with which a native FMU was packed."""


def completed(
    description: bytes, model: str, about: Mapping[str, str], start: Mapping[str, Value]
) -> Element:
    """Return the complete model description of an FMU (FMI 2.0.4, section 2.2).

    Parameters
    ----------
    description : modelDescription.xml as pythonfmu writes it
    model : `QuarterCar`
    about : attributes of the root; an empty one is removed
    start : parameters whose start values are not the defaults
    """
    root = ElementTree.fromstring(description)
    for name, text in about.items():
        root.attrib.pop(name, None)
        if text:
            root.set(name, text)
    declared = variables(model)
    # the schema requires this order: CoSimulation, UnitDefinitions, LogCategories, ...
    position = list(root).index(_child(root, "CoSimulation")) + 1
    root.insert(position, unit_definitions(declared))
    for element, variable in zip(_child(root, "ModelVariables"), declared, strict=True):
        _complete_variable(element, variable, start.get(variable.name, variable.start))
    root.remove(_child(root, "ModelStructure"))
    root.append(model_structure(declared))
    return root


def in_words(variable: Variable) -> str:
    """Return the description of a variable, with its allowed values."""
    if variable.choices:
        return f"{variable.description}; one of: {', '.join(variable.choices)}"
    if variable.positive:
        return f"{variable.description}; greater than 0"
    return variable.description


def _child(parent: Element, tag: str) -> Element:
    child = parent.find(tag)
    if child is None:
        raise ValueError(f"pythonfmu's model description has no {tag}")
    return child


def written(root: Element) -> bytes:
    """Return a document as indented XML."""
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True))


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


def _complete_variable(element: Element, variable: Variable, start: Value) -> None:
    element.set("description", in_words(variable))
    kind = element[0]
    if "start" in kind.attrib and isinstance(start, float):
        kind.set("start", repr(start))  # all digits: pythonfmu writes 16
    for name, text in range_and_unit(variable).items():
        kind.set(name, text)


def range_and_unit(variable: Variable) -> dict[str, str]:
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


def model_structure(declared: tuple[Variable, ...]) -> Element:
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
