"""What a native FMU declares, what its library shows, and what is in the archive."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from phaseplane.suspension.variables import MODELS, variables
from structures import STRUCTURES

Packer = Callable[..., Path]


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_all_variables_of_the_model_are_there(fmi: int, native_fmu: Packer) -> None:
    """Energies, too."""
    declared = read_model_description(str(native_fmu("QuarterCar", fmi=fmi))).modelVariables
    found = {v.name for v in declared if v.name != "time" and v.type != "Clock"}
    assert found == {v.name for v in variables("QuarterCar")}
    assert {"kinetic_energy", "stored_energy", "dissipated_energy"} <= found


@pytest.mark.slow
@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic"])
def test_fmpy_has_no_complaint(model: str, native_fmu: Packer) -> None:
    assert validate_fmu(str(native_fmu(model, *STRUCTURES[model].settings.items()))) == []


def test_the_library_shows_the_functions_of_fmi_alone(
    native_fmu: Packer, functions_shown: Callable[[Path], list[str]]
) -> None:
    shown = functions_shown(native_fmu("QuarterCar"))
    assert len(shown) == 34
    assert all(name.startswith("fmi2") for name in shown)


@pytest.mark.slow
def test_what_is_fixed_is_declared_so(native_fmu: Packer) -> None:
    fmu = native_fmu("QuarterCar", ("friction", 50.0))
    found = {v.name: v for v in read_model_description(str(fmu)).modelVariables}
    assert found["friction"].start == "50.0"
    for without in ("bump_stop.stiffness", "damper.rebound_limit"):
        assert found[without].variability == "fixed"
        assert "chosen when the FMU was packed" in found[without].description
    assert found["friction"].variability == "tunable"
    assert found["spring.table"].variability == "fixed"
    assert found["tyre.stiffness"].variability == "tunable"
    for k, ours in enumerate(MODELS["QuarterCar"]):
        v = found[ours.name]
        assert (v.valueReference, v.causality) == (k, ours.causality)


def test_the_archive_has_all_that_it_is_made_of(native_fmu: Packer, tmp_path: Path) -> None:
    with zipfile.ZipFile(native_fmu("QuarterCar")) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path)
    page = (tmp_path / "documentation/index.html").read_text("utf-8")
    chosen = page[
        page.index("chosen when this FMU was packed") : page.index("fixed before the run")
    ]
    assert "<td>road.shape</td>" in chosen
    assert "<td>sprung_mass</td>" not in chosen
    assert {"sources/all.c", "sources/model.c", "sources/core.c", "sources/fmi2Functions.h",
            "documentation/index.html", "documentation/licenses/fmi_headers.txt", "model.png",
            "modelDescription.xml"} <= names  # fmt: skip
    licence = (tmp_path / "documentation/licenses/fmi_headers.txt").read_text()
    assert "Modelica Association" in licence
    assert "Redistributions in binary form" in licence
    text = (tmp_path / "sources/model.c").read_text()
    assert "static int Integrator__step(Integrator *self, double latest) {" in text
    assert "/* Add M^-1 times the impulses to v. */" in text
