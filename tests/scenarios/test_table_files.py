"""Tables of scenes that stand in files: roads, forces and characteristics measured elsewhere."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from command_line import phaseplane
from phaseplane.scenarios.errors import SceneError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension.models import road_from
from phaseplane.suspension.variables import checked_parameters

SCENE = """
fmu = "QuarterCar"
duration = "0.3 s"

[parameters]
speed = 10
road.shape = "table"
road.table = { file = "measured/road.csv", columns = ["distance", "profile"], units = ["m", "mm"] }
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "measured").mkdir()
    (tmp_path / "measured" / "road.csv").write_text(
        "run,distance,profile\n1,0,0\n1,0.5,30\n1,1,0\n"
    )
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


def test_a_road_comes_from_its_file(scene: Path) -> None:
    parameters = load_scene(str(scene)).parameters
    assert parameters["road.table"] == "0.0:0.0, 0.5:0.03, 1.0:0.0"
    road = road_from(checked_parameters("QuarterCar", parameters))
    assert road.value(0.025) == pytest.approx(0.015)


def test_the_path_counts_from_the_scene_that_names_it(scene: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    other = elsewhere / "other.toml"
    other.write_text(f'extends = "{scene}"\n[parameters]\nroad.shape = "spline"\n')
    assert load_scene(str(other)).parameters["road.table"].startswith("0.0:0.0, 0.5:0.03")
    # a text laid over the file takes its place, and the other way round
    plain = load_scene(str(other), ["road.table=0:0, 1:0.01"])
    assert plain.parameters["road.table"] == "0:0, 1:0.01"


@pytest.mark.slow
def test_a_run_over_a_measured_road(scene: Path, tmp_path: Path) -> None:
    found = phaseplane("run", str(scene), "-o", str(tmp_path / "out"), "--json")
    assert found.exit_code == 0, found.output
    summary = json.loads(found.stdout)
    assert summary["parameters"]["road.table"] == "0.0:0.0, 0.5:0.03, 1.0:0.0"
    rows = (tmp_path / "out" / "results.csv").read_text().splitlines()
    place = rows[0].replace('"', "").split(",").index("ground_elevation")
    assert float(rows[26].split(",")[place]) == pytest.approx(0.015, abs=1e-12)  # at 25 ms


@pytest.mark.parametrize(
    ("model", "name", "heading", "units", "text"),
    [
        ("Elastoplastic", "force.table", "t,F", ["ms", "kN"], "0.0:0.0, 0.1:2000.0"),
        ("OneDof", "body_force.table", "t,F", ["s", "N"], "0.0:0.0, 100.0:2.0"),
        ("QuarterCar", "damper.table", "v,F", ["mm/s", "N"], "0.0:0.0, 0.1:2.0"),
        ("HalfCar", "front.spring.table", "y,F", ["cm", "N"], "0.0:0.0, 1.0:2.0"),
        ("OneDof", "damper.deflection_table", "y,f", ["m", "%"], "0.0:0.0, 100.0:0.02"),
    ],
)
def test_forces_and_characteristics_stand_in_files_alike(
    tmp_path: Path, model: str, name: str, heading: str, units: list[str], text: str
) -> None:
    (tmp_path / "table.csv").write_text(f"{heading}\n0,0\n100,2\n")
    path = tmp_path / "scene.toml"
    path.write_text(
        f'fmu = "{model}"\nduration = 1.0\n[parameters]\n{name}.file = "table.csv"\n'
        f"{name}.columns = {heading.split(',')}\n{name}.units = {units}\n"
    )
    assert load_scene(str(path)).parameters[name] == text


def test_the_columns_of_a_file_with_two_need_no_names(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("speed,F\n-100,-2\n100,2\n")
    path = tmp_path / "scene.toml"
    path.write_text(
        'fmu = "OneDof"\nduration = 1.0\n[parameters]\n'
        'damper.table = { file = "table.csv", units = ["mm/s", "N"] }\n'
    )
    assert load_scene(str(path)).parameters["damper.table"] == "-0.1:-2.0, 0.1:2.0"
    (tmp_path / "table.csv").write_text("v,F,T\n-100,-2,20\n")
    with pytest.raises(
        SceneError, match=r"columns is missing; give the names of two columns of 'v'"
    ):
        load_scene(str(path))
    (tmp_path / "table.csv").write_text("v;F\n-100;-2\n")
    with pytest.raises(SceneError, match=r"two columns of 'v;F', or delimiter = ';'"):
        load_scene(str(path))
    (tmp_path / "table.csv").write_text("# nothing yet\n")
    with pytest.raises(SceneError, match=r"table.csv is empty"):
        load_scene(str(path))


def test_the_schema_and_the_guide_know_of_files() -> None:
    told = phaseplane("schema").stdout
    assert 'road.table = { file = "road.csv",' in told
    schema = json.loads(phaseplane("schema", "QuarterCar", "--json").stdout)
    known = schema["properties"]["parameters"]["properties"]
    assert known["road.table"]["type"] == ["string", "object"]
    assert known["road.shape"]["type"] == "string"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("road.csv", "rode.csv", "road.table: cannot read .*rode.csv: No such file"),
        (
            "profile",
            "profil",
            "road.csv has no column 'profil'; its columns are .*; did you mean 'profile'",
        ),
        (
            '["m", "mm"]',
            '["m", "mm"], delimiter = ";"',
            "no column 'distance'; its columns are .*; give delimiter = ','",
        ),
        ('"mm"', '"N"', "road.table: units: .*N"),
        ("units", "unit", "unknown key 'unit'; allowed: file, columns, .*; did you mean 'units'"),
        ('"table"', '"bump"', "road.table.file is given, but road.shape is bump"),
        ('road.shape = "table"', "", "road.shape is left at its default"),
        (
            '["distance", "profile"]',
            '"profile"',
            "columns = .*: must be two, of the first and the second column",
        ),
        ('"measured/road.csv"', "3", "file = 3: must be the path"),
        ('["m", "mm"]', '["m", "mm"], delimiter = ";;"', "must be one character"),
        (
            "road.table =",
            "sprung_mass =",
            r"sprung_mass: is not a table and has no file; tables are",
        ),
        (
            '["m", "mm"]',
            '["m", "mm"], offset = "3 mm"',
            "offset = '3 mm': must be two, of the first",
        ),
        ('["m", "mm"]', '["m", "mm"], offset = ["0", "3 N"]', "road.table: offset: .*N"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_key(
    scene: Path, old: str, new: str, complaint: str
) -> None:
    assert old in SCENE
    scene.write_text(SCENE.replace(old, new, 1))
    with pytest.raises(SceneError) as caught:
        load_scene(str(scene))
    assert str(caught.value).startswith(str(scene))
    assert re.search(complaint, str(caught.value)), caught.value
