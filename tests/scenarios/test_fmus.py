"""FMUs that are not of this project: what can be driven, and what is said of the rest."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZipFile

import pytest
from command_line import written
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.fmus import find_fmu

THREE = """<fmiModelDescription fmiVersion="3.0" modelName="V" instantiationToken="1">
<{kind} modelIdentifier="V"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Float64 name="x" valueReference="1" causality="output" start="2" initial="exact"/>
</ModelVariables>
<ModelStructure><Output valueReference="1"/></ModelStructure>
</fmiModelDescription>"""
TWO = """<fmiModelDescription fmiVersion="{version}" modelName="V" guid="1">{kind}
<ModelVariables><ScalarVariable name="x" valueReference="1" causality="output"><Real/>
</ScalarVariable></ModelVariables></fmiModelDescription>"""
ONLY = "; only FMUs of FMI 2.0 and 3.0 for co-simulation or model exchange can be run"


@pytest.mark.parametrize(
    ("description", "words"),
    [
        (THREE.format(kind="ScheduledExecution"), f"an FMI 3.0 FMU for scheduled execution{ONLY}"),
        (TWO.format(version="1.0", kind=""), f"an FMI 1.0 FMU{ONLY}"),
        (TWO.format(version="2.0", kind=""), f"an FMI 2.0 FMU{ONLY}"),
        ("<fmiModelDescription/>", "not a model description of any FMI version"),
        ("<html/>", "not a model description of any FMI version"),
        ("<html>", "modelDescription.xml: no element found"),
        (None, "it contains no modelDescription.xml"),
    ],
)
def test_what_another_fmu_is_is_said(tmp_path: Path, description: str | None, words: str) -> None:
    path = tmp_path / "other.fmu"
    with ZipFile(path, "w") as archive:
        archive.writestr("binaries/V.so", "")
        if description is not None:
            archive.writestr("modelDescription.xml", description)
    with pytest.raises(InputError) as caught:
        find_fmu(str(path))
    assert words in str(caught.value)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmi_3_is_read(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "other.fmu"
    with ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", THREE.format(kind=kind))
    fmu = find_fmu(str(path))
    assert fmu.model == "V"
    assert {name: v.start for name, v in fmu.outputs().items()} == {"x": 2.0}


@pytest.mark.parametrize("content", ["", "hello", "PK\x03\x04"])
def test_what_is_no_archive(content: str) -> None:
    with pytest.raises(InputError, match="not an FMU: it is not a zip archive"):
        find_fmu(written(content, "other.fmu"))
