"""Tables of scenes that stand in files: roads, forces and characteristics measured elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from command_line import printed, reported, written
from fmpy.util import read_csv
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension.parts import road_from
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
def scene() -> str:
    Path("measured").mkdir()
    written("run,distance,profile\n1,0,0\n1,0.5,30\n1,1,0\n", "measured/road.csv")
    return written(SCENE)


def test_a_road_comes_from_its_file(scene: str) -> None:
    parameters = load_scene(scene).parameters
    assert parameters["road.table"] == "0.0:0.0, 0.5:0.03, 1.0:0.0"
    road = road_from(checked_parameters("QuarterCar", parameters))
    assert road.value(0.025) == pytest.approx(0.015)


def test_the_path_counts_from_the_scene_that_names_it(scene: str) -> None:
    Path("elsewhere").mkdir()
    text = f'extends = "../{scene}"\n[parameters]\nroad.shape = "spline"\n'
    other = written(text, "elsewhere/other.toml")
    assert load_scene(other).parameters["road.table"].startswith("0.0:0.0, 0.5:0.03")
    # a text laid over the file takes its place, and the other way round
    plain = load_scene(other, ["road.table=0:0, 1:0.01"])
    assert plain.parameters["road.table"] == "0:0, 1:0.01"


@pytest.mark.slow
def test_a_run_over_a_measured_road(scene: str) -> None:
    summary = reported("run", scene)
    assert summary["parameters"]["road.table"] == "0.0:0.0, 0.5:0.03, 1.0:0.0"
    rows = read_csv("out/scene/results.csv")
    assert rows["ground_elevation"][25] == pytest.approx(0.015, abs=1e-12)  # at 25 ms


@pytest.mark.parametrize(
    ("model", "name", "heading", "units", "text"),
    [
        ("Elastoplastic", "force.table", "t,F", ["ms", "kN"], "0.0:0.0, 0.1:2000.0"),
        ("OneDof", "body_force.table", "t,F", ["s", "N"], "0.0:0.0, 100.0:2.0"),
        ("QuarterCar", "damper.table", "v,F", ["mm/s", "N"], "0.0:0.0, 0.1:2.0"),
        ("HalfCar", "front.spring.table", "y,F", ["cm", "N"], "0.0:0.0, 1.0:2.0"),
        ("OneDof", "damper.deflection_table", "y,f", ["m", "%"], "0.0:0.0, 100.0:0.02"),
        ("HalfCar", "rear.tyre.damping_table", "v,F", ["mm/s", "N"], "0.0:0.0, 0.1:2.0"),
    ],
)
def test_forces_and_characteristics_stand_in_files_alike(
    model: str, name: str, heading: str, units: list[str], text: str
) -> None:
    written(f"{heading}\n0,0\n100,2\n", "table.csv")
    path = written(
        f'fmu = "{model}"\nduration = 1.0\n[parameters]\n{name}.file = "table.csv"\n'
        f"{name}.columns = {heading.split(',')}\n{name}.units = {units}\n"
    )
    assert load_scene(path).parameters[name] == text


def test_the_columns_of_a_file_with_two_need_no_names() -> None:
    written("speed,F\n-100,-2\n100,2\n", "table.csv")
    path = written(
        'fmu = "OneDof"\nduration = 1.0\n[parameters]\n'
        'damper.table = { file = "table.csv", units = ["mm/s", "N"] }\n'
    )
    assert load_scene(path).parameters["damper.table"] == "-0.1:-2.0, 0.1:2.0"
    written("v,F,T\n-100,-2,20\n", "table.csv")
    with pytest.raises(
        InputError, match=r"columns is missing; give the names of two columns of 'v', 'F', 'T'$"
    ):
        load_scene(path)
    written("v;F\n-100;-2\n", "table.csv")
    with pytest.raises(InputError, match=r"two columns of 'v;F', or delimiter = ';'"):
        load_scene(path)
    written("# nothing yet\n", "table.csv")
    with pytest.raises(InputError, match=r"table.csv is empty"):
        load_scene(path)
    written("-100,-2\n100,2\n", "table.csv")  # its first point was lost
    with pytest.raises(InputError, match=r"has no heading, as its first row is -100, -2; write"):
        load_scene(path)


def test_the_schema_and_the_guide_know_of_files() -> None:
    assert 'road.table = { file = "road.csv",' in " ".join(printed("schema").split())
    schema = reported("schema QuarterCar")
    known = schema["properties"]["parameters"]["properties"]
    assert known["road.table"]["type"] == ["string", "object"]
    assert known["road.shape"]["type"] == known["solver.beyond_stable"]["type"] == "string"


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
        ('columns = ["distance", "profile"], ', 'delimiter = "", ', "must be one character"),
        ('["m", "mm"]', '["m", "mm"], delimiter = 3', "delimiter = 3: must be one character"),
        ('["m", "mm"]', '["m", "mm"], decimal = 3', "decimal = 3: must be '.' or ','"),
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
    scene: str, old: str, new: str, complaint: str
) -> None:
    assert old in SCENE
    written(SCENE.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_scene(scene)
    assert str(caught.value).startswith(scene)
    assert re.search(complaint, str(caught.value)), caught.value
