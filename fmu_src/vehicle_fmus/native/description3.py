"""The descriptions of a native FMU for FMI 3.0: the model, its build, its terminals and its icon."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.models import inputs, outputs
from phaseplane.suspension.variables import Value, Variable, variables

from ..model_description import append_categories, begun, role, unit_definitions, values, written
from .model import Translation

_TYPES = {float: "Float64", int: "Int32", bool: "Boolean", str: "String"}
_CLOCKS = {
    "lift_off_event": "ticks when the {wheel} leaves the road",
    "touchdown_event": "ticks when the {wheel} meets the road again",
}
_OF_ROAD = ("elevation", "velocity")
_OF_BODY = ("displacement", "velocity")


def description(
    model: str,
    start: Mapping[str, Value],
    in_c: Translation,
    about: Mapping[str, str],
    token: str,
    stop_time: float,
) -> Element:
    """Return the model description; `in_c` tells what is fixed and what changes continuously.

    The default experiment ends at `stop_time`, s.

    Value references are those of FMI 2.0; after them follow the time and the clocks of the tyres.
    """
    declared = variables(model)
    root = begun(model, {"fmiVersion": "3.0", "instantiationToken": token}, about)
    SubElement(
        root, "CoSimulation", modelIdentifier=model, canGetAndSetFMUState="true",
        canSerializeFMUState="true", canHandleVariableCommunicationStepSize="true",
        maxOutputDerivativeOrder="1", providesIntermediateUpdate="true",
        mightReturnEarlyFromDoStep="true", canReturnEarlyAfterIntermediateUpdate="true",
        hasEventMode="true", providesDirectionalDerivatives="true",
    )  # fmt: skip
    root.append(unit_definitions(declared))
    append_categories(root, stop_time, discards=False)
    held, structure = SubElement(root, "ModelVariables"), SubElement(root, "ModelStructure")
    for k, variable in enumerate(declared):
        value = start.get(variable.name, variable.start)
        fixed, continuous = variable.name in in_c.fixed, variable.name in in_c.continuous
        _variable(held, role(k, variable, fixed, continuous), variable, value)
    SubElement(
        held, "Float64", name="time", valueReference=str(len(declared)), causality="independent",
        variability="continuous", unit="s", description="time",
    )  # fmt: skip
    clocks = list(enumerate(_clocks(in_c.tyres), len(declared) + 1))
    for k, (name, text) in clocks:
        SubElement(
            held, "Clock", name=name, valueReference=str(k), causality="output",
            intervalVariability="triggered", description=text,
        )  # fmt: skip
    places = [k for k, v in enumerate(declared) if v.causality == "output"]
    places += [k for k, _ in clocks]
    for k in places:  # as in FMI 2.0, see `model_description`
        SubElement(structure, "Output", valueReference=str(k), dependencies="")
    for k in places:
        SubElement(structure, "InitialUnknown", valueReference=str(k))
    return root


def _variable(held: Element, common: dict[str, str], variable: Variable, start: Value) -> None:
    detail = values(variable, start)
    text = detail.pop("start", None) if isinstance(start, str) else None
    if common["variability"] == "continuous" and variable.causality == "output":
        common["intermediateUpdate"] = "true"
    element = SubElement(held, _TYPES[type(variable.start)], {**common, **detail})
    if text is not None:
        SubElement(element, "Start", value=text)


def _clocks(tyres: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield names and descriptions of the clocks, in the order of their value references."""
    for prefix in tyres:
        wheel = f"{prefix.replace('_', ' ')}wheel"
        for name, text in _CLOCKS.items():
            yield f"{prefix}{name}", text.format(wheel=wheel)


def build_description(model: str, flags: str) -> bytes:
    """Return sources/buildDescription.xml."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model)
    files = SubElement(configuration, "SourceFileSet", language="C99", compilerOptions=flags)
    SubElement(files, "SourceFile", name="all.c")
    return written(root)


def terminals(model: str) -> bytes:
    """Return terminalsAndIcons.xml: the road under each axle, and each force with what it moves."""
    names = (*inputs(model), *outputs(model))
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(picture, "CoordinateSystem", {**corners, "suggestedScalingFactorTo_mm": "0.1"})
    SubElement(picture, "Icon", corners)
    found = dict(_terminals(inputs(model)))
    held = SubElement(root, "Terminals") if found else None
    for terminal, members in found.items():
        element = SubElement(held, "Terminal", name=terminal, matchingRule="plug")  # type: ignore[arg-type]
        for member, variable in members.items():
            if variable in names:
                SubElement(
                    element, "TerminalMemberVariable", variableName=variable, memberName=member,
                    variableKind="signal",
                )  # fmt: skip
    return written(root)


def _terminals(inputs: Sequence[str]) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the name of every terminal, and the variable of each of its members."""
    for name in inputs:
        if name.endswith("road_elevation"):
            axle = name.removesuffix("road_elevation")
            road = {what: f"{axle}road_{what}" for what in _OF_ROAD}
            yield f"{axle}road", {**road, "contact_force": f"{axle}contact_force"}
        elif name == "body_force":
            motion = {what: f"body_{what}" for what in _OF_BODY}
            yield "body", {"force": name, **motion}
        elif name.endswith("actuator_force"):
            axle = name.removesuffix("actuator_force")
            deflection = "suspension_deflection"
            yield (
                f"{axle}actuator",
                {
                    "force": name,
                    "deflection": f"{axle}{deflection}",
                    "rate": f"{axle}{deflection}_rate",
                },
            )
