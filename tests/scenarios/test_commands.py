"""Commands that show, compare, explain and begin: what they say of good and of bad input."""

from __future__ import annotations

import json
import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from command_line import BARE, complaint, phaseplane, printed, reported, settings, written
from phaseplane.scenarios import draw
from phaseplane.scenarios.commands.guide import json_schema
from phaseplane.scenarios.design.files import FitFile, OptimumFile, SearchOfFit, SearchOfOptimum
from phaseplane.scenarios.results.folder import Place, Results, replace_folder, write_results
from phaseplane.scenarios.results.signals import KEYS
from phaseplane.scenarios.results.tables import write_table
from phaseplane.scenarios.scene.expectations import During, Reference
from phaseplane.scenarios.scene.fields import keys_of, schema_of
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.sections import RULES, Construction, Show
from phaseplane.scenarios.sweeps.plan import Range, SweepFile
from phaseplane.suspension.own_systems.file import _SECTIONS
from phaseplane.suspension.variables import MODELS
from pyarrow import parquet

from phaseplane import recording
from phaseplane.recording import Content


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    """Two tables that differ a little, a run's folder, and what is wrong with others in many ways."""
    time = np.linspace(0.0, 1.0, 101)
    for name, factor in (("a.csv", 1.0), ("b.parquet", 1.001)):
        columns = {"time": time, "x": factor * np.sin(9.0 * time), "y": np.cos(9.0 * time)}
        write_table(columns, {"units": {"x": "m"}}, tmp_path / name)
    write_table({"x": time}, {}, tmp_path / "no_time.csv")
    write_table({"time": time[::-1], "x": time}, {}, tmp_path / "back.csv")
    Path("twice.csv").write_text("time,x,x\n0,1,2\n")
    Path("ragged.csv").write_text("time,x\n0,1\n1\n")
    Path("units.csv").write_text("time,x\ns\n0,1\n")
    Path("time.csv").write_text("time\n0\n1\n")
    write_table({"time": time, "x": time}, {"measures": {"a": 1}}, tmp_path / "other.parquet")
    parquet.write_table(pyarrow.table({"time": [0.0], "x": ["a"]}), "words.parquet")
    for name, said in (("damaged", '"files": [], "measures": {"a": 1}'), ("no_files", '"a": 1')):
        Path(name).mkdir()
        Path(name, "summary.json").write_text(f'{{"phaseplane_results": 1, {said}}}')
        Path(name, "results.csv").write_text("time,x\n0,1\n")
    with replace_folder(Place(tmp_path / "out" / "kept")) as draft:
        write_results(Results({"time": time, "x": time}, {}), draft)
    return tmp_path


# -- show and compare ------------------------------------------------------------------------------


def test_show_tells_and_draws_what_is_in_a_table(tables: Path) -> None:
    told = reported("show b.parquet --figure b.svg")
    assert told["rows"] == 101
    assert told["columns"]["x"]["unit"] == "m"
    assert told["columns"]["y"]["first"] == 1.0
    assert told["files"] == ["b.svg"]
    drawn = (tables / "b.svg").read_text()
    assert "time [s]" in drawn
    only = printed("show a.csv --column y")
    assert [line.split()[0] for line in only.splitlines()] == ["101", "column", "y"]


def test_show_reports_a_run(fmu: Path, tables: Path) -> None:
    given = settings(f"fmu={fmu}", "show.table=r.mat")
    ran = printed("run ap57", *given, *BARE)
    shown = printed("show out/ap57")
    assert ran.splitlines()[:12] == shown.splitlines()[:12]
    assert "body_displacement" in shown
    by_itself = printed("show out/ap57/r.mat")  # which does not know of other files
    assert "30.662 ms" in by_itself
    assert "1001 rows" in by_itself
    assert "summary.json" not in by_itself
    inside = reported("show out/ap57/r.mat")["summary"]
    assert inside["hash"] == json.loads((tables / "out/ap57/summary.json").read_text())["hash"]
    assert set(inside["versions"]) >= {"python", "fmpy"}


def test_compare_tells_the_largest_differences_first(tables: Path) -> None:
    result = phaseplane("compare a.csv b.parquet --figure d.png --json")
    told = json.loads(result.stdout)
    assert result.exit_code == 1
    assert "x by 0.000999 of its peak" in result.stderr
    assert [d["name"] for d in told["differences"]] == ["x", "y"]
    assert told["differences"][1]["largest"] == 0.0
    assert (tables / "d.png").read_bytes().startswith(b"\x89PNG")
    equal = phaseplane("compare a.csv b.parquet --tolerance 1e-2")
    assert (equal.exit_code, equal.stdout.splitlines()[-1]) == (0, "equal (tolerance 0.01)")
    printed("compare a.csv b.parquet --column y")


def test_compare_counts_what_only_one_has(tables: Path) -> None:
    time = np.linspace(0.0, 0.5, 51)
    write_table({"time": time, "x": np.sin(9.0 * time)}, {}, tables / "part.csv")
    for pair in (("a.csv", "part.csv"), ("part.csv", "a.csv")):
        result = phaseplane("compare", *pair)
        assert result.exit_code == 1
        lines = result.stdout.splitlines()
        assert "compared: 1 column, 51 rows from 0 to 0.5 s" in lines
        assert "only a.csv has column y" in lines
        assert lines[-1] == "different"
        assert "a.csv has 101 rows from 0 to 1 s" in result.stderr
        assert "part.csv has 51 rows from 0 to 0.5 s" in result.stderr
        assert "--common" in result.stderr
        common = printed("compare", *pair, "--common", "--json")
        assert json.loads(common)["compared"] == {
            "columns": ["x"], "rows": 51, "from": 0.0, "to": 0.5
        }  # fmt: skip


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("show nowhere", "no such file or folder: nowhere"),
        ("show QuarterCar", "QuarterCar is a model"),
        ("show .", "is not a results folder"),
        ("show no_time.csv --figure f.png", "phaseplane: no_time.csv: no column time"),
        ("compare no_time.csv a.csv", "a TOML file with a table [measured]"),
        ("show back.csv --figure f.png", "back.csv: time must not go back"),
        ("show a.csv --column z", "no column 'z'"),
        ("show a.csv --plane x,z --save f.rrd", "no column 'z'"),
        ("show no_time.csv --save f.rrd", "no column time"),
        ("show a.csv --figure a.gif", "must end in .png"),
        ("show twice.csv", "cannot read twice.csv: 2 columns are called 'x'"),
        ("show ragged.csv", "line 3 has 1 cell, the heading 2\n"),
        ("show units.csv", "line 2 has 1 cell, the heading 2\n"),
        ("show time.csv --figure f.png", "time.csv has no column but time to draw"),
        ("show other.parquet", "other.parquet: the summary is damaged, or is not that of a run"),
        ("show words.parquet", "column 'x' does not contain numbers"),
        ("show damaged", "damaged: the summary is damaged, or is not that of a run"),
        ("replay damaged --save x.rrd", "damaged: the summary is damaged"),
        ("run ap57 -o no_files", "no_files contains no results of a run"),
        ("replay ap57 --save x.rrd --step 1e-9", "--step: construction.step = 1e-09 s gives"),
        ("compare a.csv a.csv --tolerance nan", "'--tolerance': nan must be a finite"),
        ("compare a.csv c.csv", "no such file or folder: c.csv"),
        ("compare kept a.csv", "did you mean out/kept?"),
        ("compare a.csv back.csv", "back.csv: time must not go back"),
        ("compare a.csv b.parquet --column xx", "did you mean 'x'?"),
        ("compare a.csv b.parquet --tolerance -1", "-1"),
        ("schema QuaterCar", "MODEL 'QuaterCar': must be one of OneDof, QuarterCar"),
        ("schema QuaterCar --json", ".py file; did you mean 'QuarterCar'?"),
        ("schema QuarterCar --sweep", "give only one of MODEL, --sweep"),
        ("schema --sweep --fit", "give only one of MODEL, --sweep"),
        ("schema speed_bump", "speed_bump is a scene: 'phaseplane run speed_bump' runs it"),
        ("run QuarterCar", "QuarterCar is a model: 'phaseplane new"),
        ("run four_post", "four_post is a sweep: 'phaseplane sweep four_post' runs it"),
        ("sweep ap57", "ap57 is a scene"),
        ("sweep speed_bunp", "no sweep 'speed_bunp'; 'phaseplane list' shows them all"),
        ("sweep ../speed_bump", "no sweep '../speed_bump'"),
        ("new a.csv", "already exists"),
        ("new no/such/folder.toml", "the folder no/such does not exist"),
        ("schema Nope", "Elastoplastic, Road, Equation, or the path"),  # what it explains
        ("schema Roda", "did you mean 'Road'?"),
        ("list Nope", "Road, Equation, or the path"),
        ("schema Road --json", "Elastoplastic, Equation, or the path"),  # of a scene
        ("new x.toml --model Bicycle", "MODEL 'Bicycle': must be one of OneDof"),
    ],
)
@pytest.mark.usefixtures("tables")
def test_bad_input_is_one_line(line: str, words: str) -> None:
    assert words in complaint(line)


def test_any_table_is_recorded_with_a_plane_of_two_columns(
    tables: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Content] = []
    plain = recording.record
    monkeypatch.setattr(recording, "record", lambda of, to: (shown.append(of), plain(of, to)))
    told = printed("show a.csv --plane x,y --save plane.rrd")
    assert told.splitlines()[-1] == "plane.rrd"
    assert Path("plane.rrd").stat().st_size > 1000
    (content,) = shown
    assert content.pairs == (("x", "y"),)
    assert set(content.histories) == {"time", "x", "y"}


def test_the_plane_of_a_road_is_recorded_by_the_name_of_its_column() -> None:
    table = {"time": np.array([0.0, 1.0]), "ground_elevation": np.array([0.0, 1.0]),
             "ground_velocity": np.array([1.0, 1.0])}  # fmt: skip
    pair = ("ground_elevation", "ground_velocity")
    content = draw.recording_content.of_table("a road", table, dict.fromkeys(table, ""), pair)
    content.check()
    assert content.pairs == (("road_elevation", "road_velocity"),)


# -- schema and new --------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [Show, Construction, During, Reference])
def test_every_key_of_a_scene_is_explained(kind: type) -> None:
    told = printed("schema")
    for name, said in schema_of(kind)["properties"].items():
        assert said["description"], name
        assert f"  {name}" in told


def test_the_keys_of_controllers_and_systems_are_explained() -> None:
    told, properties = phaseplane("schema").stdout, json_schema(None)["properties"]
    for key in ("period", "events", "constants"):
        assert f"  {key}" in told.partition("[controller]")[2].partition("[show]")[0]
        assert properties["controller"]["properties"][key]["description"]
    assert properties["controller"]["additionalProperties"] == {
        "type": "string",
        "description": "formula of outputs, t and constants, for any input of the model: "
        "actuator_force, ...",
    }
    # as the reader of such a file takes them
    for key in _SECTIONS:
        assert f"  {key} " in told.partition("[system]")[2]
        assert key in properties["system"]["properties"]


def test_the_road_is_explained_like_a_model() -> None:
    assert "  wheelbase [m] " in phaseplane("schema", "Road").stdout
    assert "  wheelbase  " in phaseplane("list", "Road").stdout
    assert re.search(r"  lift_off +true\n", phaseplane("list", "QuarterCar").stdout)
    assert "Equation" in phaseplane("schema").stdout.partition("  duration")[0]


def test_schema_says_which_detail_of_a_recording_true_is() -> None:
    assert "as with true, some steps stage by stage" in " ".join(printed("schema").split())


def test_schema_says_what_each_rule_of_a_step_is() -> None:
    told = " ".join(printed("schema").split())
    assert "how a step ends in Liénard's construction" in told
    for name, words in RULES.items():
        assert f"{name}: {words}" in told
    rule = json_schema("QuarterCar")["properties"]["construction"]["properties"]["rule"]
    assert {one["const"]: one["description"] for one in rule["oneOf"]} == RULES


def test_lienard_is_said_to_be_common_to_all_rules() -> None:
    told = phaseplane("replay van_der_pol --construction lienard --figure x.png")
    assert "--construction 'lienard': must be one of tangent, " in told.stderr
    assert "all of them are step rules of Liénard's construction" in told.stderr


@pytest.mark.parametrize(("kind", "tables"), [
    ("sweep", (SweepFile, Range)), ("optimise", (OptimumFile, SearchOfOptimum)),
    ("fit", (FitFile, SearchOfFit)),
])  # fmt: skip
def test_every_key_of_another_file_is_explained(kind: str, tables: tuple[type, ...]) -> None:
    told = printed("schema", f"--{kind}")
    for table in tables:
        for name, said in schema_of(table)["properties"].items():
            assert said["description"], name
            assert f"  {name}" in told or f"[{name}]" in told
    schema = reported("schema", f"--{kind}")
    assert set(schema["properties"]) == set(keys_of(tables[0]))
    assert f"--{kind}" in printed("schema")


@pytest.mark.parametrize("of", [["--fit"], []])
def test_the_schema_of_fits_and_of_references_explains_measured_signals(of: list[str]) -> None:
    told = printed("schema", *of)
    assert all(f"\n  {key} " in told for key in KEYS)


@pytest.mark.parametrize("model", MODELS)
def test_schema_tells_a_models_parameters_outputs_and_measures(model: str) -> None:
    told = printed("schema", model)
    keys = {line.split()[0] for line in told.splitlines() if line[:2] == "  " and line[2] != " "}
    for variable in MODELS[model]:
        assert variable.name in keys, variable.name
    properties = json_schema(model)["properties"]
    assert properties["parameters"]["properties"].keys() == {
        v.name for v in MODELS[model] if v.causality == "parameter"
    }
    assert reported("schema", model) == json.loads(json.dumps(json_schema(model)))


@pytest.mark.parametrize("model", MODELS)
def test_a_new_scene_is_valid_as_it_stands_and_with_all_its_comments_taken_up(model: str) -> None:
    printed("new mine.toml --model", model)
    text = Path("mine.toml").read_text()
    assert load_scene("mine.toml").fmu.model == model
    lines = [
        line.removeprefix("# ") if line.startswith("# ") and " = " in line else line
        for line in text.splitlines()
    ]
    Path("all.toml").write_text("\n".join(lines))
    scene = load_scene("all.toml")
    assert len(scene.parameters) >= 4
    for name, variable in scene.fmu.parameters().items():
        value = scene.all_parameters[name]
        start = variable.start
        assert value == (pytest.approx(start, rel=1e-5) if isinstance(start, float) else start)
    assert tomllib.loads(text)["fmu"] == model


def test_a_new_scene_names_its_model_from_its_own_folder() -> None:
    system = '[system]\nname = "Trolley"\ncoordinates = { slide = 2.0 }\nelements.spring = '
    written(system + "{ direction = { slide = 1 }, spring = { rate = 200.0 } }", "trolley.toml")
    Path("mine").mkdir()
    printed("new mine/car.toml --model trolley.toml")
    assert load_scene("mine/car.toml").fmu.model == "Trolley"


# -- files of other commands -----------------------------------------------------------------------

OF_COMMANDS = {
    "run": 'extends = "ap57"\n',
    "sweep": 'scene = "ap57"\nmeasures = ["lift_off_count"]\n[vary]\nspeed = [10, 20]\n',
    "optimise": 'scene = "ap57"\nminimise = "suspension_travel"\n[vary]\nspeed = { from = 1, to = 2 }\n',
    "fit": 'scene = "ap57"\n[vary]\nspeed = { from = 1, to = 2 }\n[measured]\nfile = "a.csv"\n',
}


@pytest.mark.parametrize("file", OF_COMMANDS)
@pytest.mark.parametrize("command", OF_COMMANDS)
def test_the_file_of_another_command_is_given_to_that_one(command: str, file: str) -> None:
    if file == command:
        return
    Path("it.toml").write_text(OF_COMMANDS[file])
    assert f"'phaseplane {file} it.toml' takes it" in complaint(command, "it.toml")
    assert os.listdir() == ["it.toml"]


def test_a_path_with_spaces_can_be_copied_from_a_message() -> None:
    written(OF_COMMANDS["sweep"], "my sweep.toml")
    assert "'phaseplane sweep \"my sweep.toml\"' takes it" in complaint("run", "my sweep.toml")
    assert "run it with 'phaseplane run \"my car.toml\"'" in printed("new", "my car.toml")
    printed("run ap57_obstacle --no-expect --set show.figures=[] -o", "my run")
    words = (
        "my run is a folder, not a scene file; 'phaseplane show \"my run\"' summarises the results"
    )
    assert words in complaint("run", "my run")
    Path("empty").mkdir()
    assert complaint("run", "empty").endswith("empty is a folder, not a scene file\n")
