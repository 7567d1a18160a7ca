"""The registry of models: a file in the folder is a model, for all that the package does."""

from __future__ import annotations

import ast
import json
import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import settings
from hosting import in_python
from phaseplane.suspension import models
from phaseplane.suspension.models import ALL, FILES, build, checked_parameters
from phaseplane.suspension.systems import System
from phaseplane.suspension.variable import Value, number
from phaseplane.vehicle_fmus import content

from phaseplane import scenarios

ALL_DEFAULTS = checked_parameters("QuarterCar", {})
FOLDER = Path(models.__file__).parent

ADDED = '''
"""A mass on a spring.

m x'' + c x = 0
"""

from ..characteristics import linear
from ..declared import SOLVER_PARAMETERS, initial
from ..model import Model
from ..outputs import SOLVER_OUTPUTS, motion
from ..systems import Element, System
from ..variable import number, parameter


def system(p):
    return System(
        coordinates=("body",),
        mass=((number(p, "mass"),),),
        elements=(Element("spring", (1.0,), linear(number(p, "spring.rate"))),),
        scales=(1.0,),
    )


MODEL = Model(
    summary="Mass on a spring",
    variables=(
        parameter("mass", 2.0, "mass", "kg", positive=True),
        parameter("spring.rate", 8.0, "spring rate", "N/m", positive=True),
        *initial({"body": "the mass"}),
        *SOLVER_PARAMETERS,
        *motion("body", "the mass"),
        *SOLVER_OUTPUTS,
    ),
    system=system,
    rank=9,
    page="<p>A mass on a spring: m x'' + c x = 0.</p>",
    picture='<circle cx="128" cy="128" r="40"/>',
)
'''
SCENE = """
fmu = "MassOnSpring"
duration = "3 s"
parameters.initial.body_displacement = "1 cm"
show = { output_interval = "10 ms", outputs = ["body_displacement"], measures = ["peak.body_velocity"] }
"""
# the package with one file more, in place of the one that is installed
PROGRAM = """
import json, sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import phaseplane

folder = Path(sys.argv[1])
spec = spec_from_file_location(
    "phaseplane.suspension", folder / "__init__.py", submodule_search_locations=[str(folder)]
)
phaseplane.suspension = sys.modules["phaseplane.suspension"] = module_from_spec(spec)
spec.loader.exec_module(phaseplane.suspension)
from phaseplane.scenarios.cli import main
from phaseplane.scenarios.commands.guide import guide

print(guide("MassOnSpring"))
for command in (["build", "MassOnSpring", "-o", "fmus"], ["run", "scene.toml", "-o", "out"]):
    try:
        main(command)
    except SystemExit as end:
        assert not end.code, command
"""


@pytest.mark.slow
def test_a_model_that_is_added_as_a_file_is_listed_packed_and_run(tmp_path: Path) -> None:
    package = Path(shutil.copytree(FOLDER.parent, tmp_path / "package"))
    (package / "models" / "mass_on_spring.py").write_text(ADDED)
    shutil.copy(FOLDER / "one_dof.png", package / "models" / "mass_on_spring.png")
    (tmp_path / "scene.toml").write_text(SCENE)
    assert "MassOnSpring: parameters" in in_python(PROGRAM, package, cwd=tmp_path)
    assert (tmp_path / "fmus" / "MassOnSpring.fmu").is_file()
    time, x = np.loadtxt(tmp_path / "out" / "results.csv", delimiter=",", skiprows=1).T
    np.testing.assert_allclose(x, 0.01 * np.cos(2.0 * time), atol=1e-7)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["measures"]["peak.body_velocity"]["value"] == pytest.approx(-0.02, rel=1e-5)


def test_every_model_has_its_files() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} - {"__init__"} == set(FILES.values())
    assert {path.stem for path in FOLDER.glob("*.png")} == set(FILES.values())
    for name in FILES:
        assert content.picture_file(name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", FILES)
def test_the_page_of_a_model_names_every_mass_and_every_force_on_it(name: str) -> None:
    named = {
        v.name.replace("rear", "front")  # "rear likewise"
        for v in ALL[name].variables
        if (v.causality, v.unit) in {("parameter", "kg"), ("input", "N")}
        or v.name.endswith("force.table")
    }
    assert not {each for each in named if not re.search(rf"\b{each}\b", ALL[name].page)}


@pytest.mark.slow
def test_no_other_file_of_models_and_fmus_depends_on_a_models_name() -> None:
    """What depends on one would have to be changed for the next."""
    sources = [*FOLDER.parent.rglob("*.py"), *content.SLAVES.parent.rglob("*.py")]
    named = {
        f"{path.name}: {node.value}"
        for path in sources
        if path.parent != FOLDER
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in FILES
    }
    # the road that drives vehicles, and the picture of systems of one's own
    assert named == {"systems.py: Road", "content.py: HalfCar"}


def test_a_system_is_built_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[float] = []
    model = ALL["QuarterCar"]
    assert model.system is not None

    def counted(p: Mapping[str, Value]) -> System:
        made.append(number(p, "spring.rate"))
        return model.system(p)

    monkeypatch.setitem(ALL, "QuarterCar", replace(model, system=counted))
    parameters = {"spring.rate": 12345.678}
    assert build("QuarterCar", parameters) is build("QuarterCar", dict(parameters))
    assert build("QuarterCar", {"spring.rate": "12345.679 N/m"}).elements
    assert made == [12345.678, 12345.679]


_COUNTED = """
import json, sys
from dataclasses import replace
from phaseplane.suspension.models import ALL
from phaseplane.suspension.variable import Variable
from phaseplane.scenarios.cli import main

checked, built = [], []
check, model = Variable.checked, ALL["QuarterCar"]

def counted(variable, value):
    if variable.name == "damper.rebound_rate":
        checked.append(value)
    return check(variable, value)

def system(parameters):
    built.append(parameters["damper.rebound_rate"])
    return model.system(parameters)

Variable.checked = counted
ALL["QuarterCar"] = replace(model, system=system)
for _ in range(2):  # the first run may pack the FMU, which makes the default system
    checked.clear()
    try:
        main(["run", "ap57", *sys.argv[1:]])
    except SystemExit:
        pass
print(json.dumps([checked, built]))
"""


@pytest.mark.slow
def test_a_run_checks_a_value_where_it_enters_and_builds_its_system_once(tmp_path: Path) -> None:
    """It enters twice, the scene and the FMU; FMU, measures, planes and energies share a system."""
    given = settings("damper.rebound_rate=1900", "show.figures=[]")
    said = in_python(_COUNTED, "--no-expect", *given, cwd=tmp_path)
    checked, built = json.loads(said.splitlines()[-1])
    assert checked == [1900, 1900.0]
    assert built.count(1900.0) == 1
    assert set(built) <= {1900.0, ALL_DEFAULTS["damper.rebound_rate"]}


def test_the_name_of_a_parameter_stands_whole_where_it_is_used() -> None:
    """So that a search for it finds declaration and use."""
    folders = (FOLDER.parent, Path(scenarios.__file__).parent)
    files = (path for folder in folders for path in folder.rglob("*.py"))
    sources = "\n".join(path.read_text(encoding="utf-8") for path in files)
    names = {
        v.name.removeprefix("front.").removeprefix("rear.")
        for model in ALL.values()
        for v in model.variables
        if v.causality == "parameter" and not v.name.startswith("initial.")
    }
    once = {name for name in names if len(re.findall(rf'["}}]{re.escape(name)}"', sources)) < 2}
    assert once == set()
