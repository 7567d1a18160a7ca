"""A vehicle on its road as an SSP 1.0 system: the FMU `Road` connected with the vehicle's inputs."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from phaseplane.suspension.models import declared_parameters, inputs
from phaseplane.suspension.units import UNITS
from phaseplane.suspension.variables import MODELS, Value, Variable, variables

from .model_description import written

ROAD = "Road"

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
_TYPES = {float: "Real", bool: "Boolean", int: "Integer"}
_STEP = "0.001"  # s

# outputs of the road -> inputs of the vehicle: with one axle, and of a half car
_CONNECTIONS = (
    {"front_elevation": "road_elevation", "front_velocity": "road_velocity"},
    {
        f"{axle}_{quantity}": f"{axle}_road_{quantity}"
        for axle in ("front", "rear")
        for quantity in ("elevation", "velocity")
    },
)


def connections(model: str) -> dict[str, str]:
    """Return the vehicle's input for each output of the road; empty for a model without a road."""
    known = set(inputs(model)) if model in MODELS else set()
    return next((pairs for pairs in _CONNECTIONS if known.issuperset(pairs.values())), {})


def shared_out(
    model: str, parameters: Mapping[str, Value]
) -> tuple[dict[str, Value], dict[str, Value]]:
    """Split the parameters of a vehicle into start values of the road's FMU and of the vehicle's.

    Parameters
    ----------
    model : a vehicle
    parameters : all its parameters, checked
    """
    known = declared_parameters(ROAD)
    road = {name: value for name, value in parameters.items() if name in known}
    if road["road.shape"] == "input":
        del road["road.shape"]
    if "cg_to_front" in parameters:
        road["wheelbase"] = float(parameters["cg_to_front"]) + float(parameters["cg_to_rear"])
    declared = declared_parameters(model)
    changed = {n: v for n, v in parameters.items() if v != declared[n].start and n not in known}
    return road, {**changed, "road.shape": "input"}


def description(model: str, stop_time: float) -> bytes:
    """Return SystemStructure.ssd: both components with their outputs, and their connections.

    Start values are in the FMUs, because not every tool reads them from here. Unconnected inputs are
    left out: FMPy's reader would connect them with the last output it connected. The default experiment
    ends at `stop_time`, s.
    """
    links = connections(model)
    ElementTree.register_namespace("ssd", _SSD)
    ElementTree.register_namespace("ssc", _SSC)
    ElementTree.register_namespace("oms", _OMS)
    root = Element(f"{{{_SSD}}}SystemStructureDescription", name=f"{model}OnRoad", version="1.0")
    system = _in(root, "System", name=f"{model}OnRoad")
    elements = _in(system, "Elements")
    for name, source in (("road", ROAD), ("vehicle", model)):
        component = _in(
            elements, "Component", name=name, type="application/x-fmu-sharedlibrary",
            source=f"resources/{source}.fmu",
        )  # fmt: skip
        connectors = _in(component, "Connectors")
        for variable in variables(source):
            if variable.causality == "output" or variable.name in links.values():
                _connector(connectors, variable)
    connected = _in(system, "Connections")
    for output, inlet in links.items():
        _in(connected, "Connection", startElement="road", startConnector=output,
            endElement="vehicle", endConnector=inlet)  # fmt: skip
    _openmodelica(system)
    _units(root, model)
    _in(root, "DefaultExperiment", startTime="0", stopTime=repr(stop_time))
    return written(root)


def _in(parent: Element, tag: str, **attributes: str) -> Element:
    return SubElement(parent, f"{{{_SSD}}}{tag}", attributes)


def _connector(connectors: Element, variable: Variable) -> None:
    connector = _in(connectors, "Connector", name=variable.name, kind=variable.causality)
    kind = SubElement(connector, f"{{{_SSC}}}{_TYPES[type(variable.start)]}")
    if variable.unit:
        kind.set("unit", variable.unit)


def _units(root: Element, model: str) -> None:
    units = _in(root, "Units")
    for name in sorted({v.unit for v in (*variables(ROAD), *variables(model)) if v.unit}):
        exponents = {base: str(power) for base, power in UNITS[name].exponents.items()}
        SubElement(
            SubElement(units, f"{{{_SSC}}}Unit", name=name), f"{{{_SSC}}}BaseUnit", exponents
        )


def _openmodelica(system: Element) -> None:
    """Add the master algorithm, without which OMSimulator does not read a system."""
    annotation = SubElement(
        _in(system, "Annotations"), f"{{{_SSC}}}Annotation", type="org.openmodelica"
    )
    information = SubElement(
        SubElement(annotation, f"{{{_OMS}}}Annotations"), f"{{{_OMS}}}SimulationInformation"
    )
    SubElement(
        information, f"{{{_OMS}}}FixedStepMaster", description="oms-ma", stepSize=_STEP,
        absoluteTolerance="1e-4", relativeTolerance="1e-4",
    )  # fmt: skip
