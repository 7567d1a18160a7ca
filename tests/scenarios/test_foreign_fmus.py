"""An FMU of others, from its description to its recording."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import pytest
from command_line import reported, settings
from phaseplane.scenarios.scene.fmus import find_fmu
from phaseplane.scenarios.scene.loading import load_scene
from rerun.chunk import RrdReader

OUTPUTS = {
    "wheel_displacement": "h", "wheel_velocity": "w", "contact_force": "F",
    "suspension_deflection": "s",  # another length: units alone do not say what w is the rate of
}  # fmt: skip


@pytest.fixture(scope="module")
def foreign(fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The quarter car as others might describe it: own names, units by declared types, w = dh/dt."""
    path = tmp_path_factory.mktemp("foreign") / "Rig.fmu"
    with zipfile.ZipFile(fmu) as packed, zipfile.ZipFile(path, "w") as made:
        for name in packed.namelist():
            content = packed.read(name)
            if name == "modelDescription.xml":
                content = _described(ET.fromstring(content))
            made.writestr(name, content)
    return path


def _described(root: ET.Element) -> bytes:
    variables = root.find("ModelVariables")
    types = ET.Element("TypeDefinitions")
    assert variables is not None
    root.insert(list(root).index(variables), types)
    places = {}
    for place, scalar in enumerate(list(variables), 1):
        name = OUTPUTS.get(scalar.attrib["name"])
        if name is None:
            if scalar.attrib["causality"] == "output":
                scalar.attrib["causality"] = "local"
            continue
        places[name] = place
        scalar.attrib["name"] = name
        (real,) = scalar.findall("Real")
        ET.SubElement(
            ET.SubElement(types, "SimpleType", name=f"of_{name}"), "Real", unit=real.attrib["unit"]
        )
        real.attrib = {"declaredType": f"of_{name}"}
        if name == "w":
            real.attrib["derivative"] = str(places["h"])
    structure = root.find("ModelStructure")
    assert structure is not None
    for outputs in structure.findall("Outputs"):
        for unknown in list(outputs):
            if int(unknown.attrib["index"]) not in places.values():
                outputs.remove(unknown)
    return ET.tostring(root)


def test_its_units_and_rates_are_read(foreign: Path) -> None:
    found = find_fmu(str(foreign))
    assert not found.is_ours
    assert {name: v.unit for name, v in found.outputs().items()} == {
        "h": "m", "w": "m/s", "F": "N", "s": "m",
    }  # fmt: skip
    assert found.rates == (("h", "w"),)
    assert "rms.F" in found.measures()
    assert not {"natural_frequencies", "magnification", "lift_off_count"} & found.measures().keys()


def test_its_planes_are_those_of_its_rates_unless_others_are_given(foreign: Path) -> None:
    assert load_scene(str(foreign)).shown.planes == (("h", "w"),)
    for given, planes in (("show.outputs=['h']", ()), ("show.planes=['s,F']", (("s", "F"),))):
        assert load_scene(str(foreign), [given]).shown.planes == planes


@pytest.mark.slow
def test_its_recording_has_every_output_and_the_plane(
    foreign: Path,
) -> None:
    told = reported("run", foreign, "--save", "rig.rrd", *settings("duration=0.2 s"))
    assert told["saved"] == "rig.rrd"
    entities = {chunk.entity_path for chunk in RrdReader("rig.rrd").stream()}
    assert entities >= {
        "/histories/displacement/h", "/histories/displacement/s", "/histories/velocity/w",
        "/histories/force/F", "/sheet/trail/h/recent",
    }  # fmt: skip


@pytest.mark.slow
def test_planes_are_drawn_and_recorded(foreign: Path) -> None:
    planes = ["--plane", "h,w", "--plane", "s,F"]
    assert reported("run", foreign, *planes, *settings("duration=0.2 s"))["files"] == [
        "construction.rrd", "plane.png", "plane_2.png", "results.csv", "summary.json",
    ]  # fmt: skip
