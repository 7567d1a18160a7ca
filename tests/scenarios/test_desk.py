"""The public names, and a run as one object."""

import doctest
import re
import subprocess
import sys
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from command_line import complaint, printed, written
from hosting import in_python
from phaseplane.scenarios.desk import run as module
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.report import report
from phaseplane.suspension import engine
from phaseplane.suspension.session import simulate
from small_sweep import sweep_file

import phaseplane

QUICK = {"duration": 0.2, "speed": 25}


@pytest.fixture(scope="module")
def bump():
    return phaseplane.run("ap57", **QUICK)


def test_every_public_name_is_found_and_documented():
    names = [name for name in dir(phaseplane) if not name.startswith("_")]
    assert {"run", "Run", "Table", "constructions", "suspension"} <= set(names)
    for name in names:
        assert (getattr(phaseplane, name).__doc__ or "").strip(), name


def test_public_names_are_imported_only_when_they_are_used():
    program = (
        "import sys, phaseplane; dir(phaseplane); "
        "print(sorted(m for m in sys.modules if m.startswith('phaseplane.') or m == 'numpy'))"
    )
    assert in_python(program).strip() == "[]"


def test_columns_are_those_of_the_model(bump):
    names = ["body_displacement", "contact_force", "airborne"]
    own = simulate("QuarterCar", bump.scene.start_values, bump.time.tolist(), names)
    for name in names:
        np.testing.assert_array_equal(bump[name], own[name])
    assert bump["airborne"].dtype == bool
    assert bump.units["contact_force"] == "N"
    assert next(iter(bump)) == "time"


@pytest.mark.parametrize("scene", ["ap57", "van_der_pol"])
def test_the_fmu_gives_the_same_bits(scene):
    ours, theirs = (phaseplane.run(scene, duration=0.2, through=how) for how in ("process", "fmu"))
    assert list(ours) == list(theirs)
    for name, column in ours.items():
        assert column.dtype == theirs[name].dtype
        np.testing.assert_array_equal(column, theirs[name])
    assert ours.measures == theirs.measures


def test_measures_do_not_depend_on_the_rows(bump):
    coarse = phaseplane.run("ap57", **QUICK, output_interval=0.05)
    assert len(coarse.time) == 5
    for name in ("peak.body_acceleration", "smallest_contact_force", "lift_offs"):
        assert coarse.measures[name] == bump.measures[name]


def test_free_vibration_has_its_closed_form():
    mass, rate, start = 100.0, 4e3, 0.01
    free = phaseplane.run(
        "OneDof", duration=1.0, sprung_mass=mass, spring={"rate": rate},
        damper={"rebound_rate": 0.0, "bump_rate": 0.0}, initial={"body_displacement": start},
        road={"shape": "flat"}, solver={"tolerance": 1e-10}, measures=["natural_frequencies"],
    )  # fmt: skip
    omega = sqrt(rate / mass)
    exact = start * np.cos(omega * free.time)
    np.testing.assert_allclose(free["body_displacement"], exact, atol=1e-9)
    assert free.measures["natural_frequencies"][0] == pytest.approx(omega / (2 * pi))
    assert free.at(0.5)["body_displacement"] == pytest.approx(start * np.cos(0.5 * omega), abs=1e-8)


def test_events_are_those_that_the_measures_count(bump):
    contact = [event for event in bump.events if event.kind == "contact"]
    assert [event.after for event in contact] == [1, 0]
    times = [event.time for event in contact]
    assert times == [bump.measures["lift_offs"][0], bump.measures["touchdowns"][0]]


def test_arrays_and_pairs_are_tables():
    points = [(-1.0, -500.0), (0.0, 0.0), (1.0, 2000.0)]
    text = ", ".join(f"{x}:{y}" for x, y in points)
    runs = [
        phaseplane.run("ap57", {"damper.table": table}, **QUICK)
        for table in (text, points, np.array(points))
    ]
    for run in runs[1:]:
        np.testing.assert_array_equal(run["body_velocity"], runs[0]["body_velocity"])


def test_starts_are_lists_of_numbers_and_no_table():
    given = {"fmu": "Equation", "duration": 0.5, "parameters": {"equation": "x"}}
    for starts in ([[1.0, 0.0], [0.0, 2.0]], np.array([[1.0, 0.0], [0.0, 2.0]])):
        run = phaseplane.run({**given, "construction": {"starts": starts}})
        assert run["start3_velocity"][0] == 2.0
        again = phaseplane.run(given, {"construction.starts": starts})
        np.testing.assert_array_equal(again["start2_displacement"], run["start2_displacement"])


def test_a_number_may_be_an_array_without_dimensions(bump):
    same = phaseplane.run("ap57", **{**QUICK, "speed": np.array(25.0)})
    np.testing.assert_array_equal(same["body_velocity"], bump["body_velocity"])


def test_a_scene_can_be_a_mapping_that_extends_another(bump):
    changed = {"parameters": {"speed": 25.0}, "duration": "0.2 s", "show": None}
    same = phaseplane.run({"extends": "ap57", **changed})
    np.testing.assert_array_equal(same["body_velocity"], bump["body_velocity"])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: phaseplane.run("ap57", sped=3), r"run\(\): .*did you mean 'speed'"),
        (lambda: phaseplane.run("QuarterCar"), "'duration' is missing"),
        (lambda: phaseplane.run({"fmx": 1}), "did you mean 'fmu'"),
        (lambda: phaseplane.run({"controllers": {"period": 1.0}}), "did you mean 'controller'"),
        (
            lambda: phaseplane.run({"duration": 1, "system": {"name": "Rig"}}),
            r"system: a system of your own is described in a file; .* give its path as fmu",
        ),
        (lambda: phaseplane.run({"fmu": {"name": "Rig"}}), "fmu: must be a single value"),
        (lambda: phaseplane.run("ap57", "speed=3"), r"changes = 'speed=3': give a mapping .* list"),
        (lambda: phaseplane.run("ap57", None), r"changes = None: give a mapping"),
        (lambda: phaseplane.run("ap57", [3]), r"changes = \[3\]: give a mapping"),
        (lambda: phaseplane.run({"extends": "ap75"}), "did you mean 'ap57'"),
        (lambda: phaseplane.run("ap57", {"damper.table": np.ones(3)}), r"shape \(3,\)"),
        (lambda: phaseplane.run("ap57", **QUICK).figure("histories"), "no picture 'histories'"),
        (lambda: phaseplane.run("ap57", through="dll"), "through = 'dll': allowed: process, fmu"),
        (lambda: phaseplane.run(3), "scene = 3: give a name, a path or a mapping"),
        (lambda: phaseplane.run("ap57", **QUICK).plot(width=-1), "width -1: must be from 40 mm"),
        (
            lambda: phaseplane.show("ap57", speed=3),
            "unknown key 'speed'; allowed: .*dark",
        ),
        (lambda: phaseplane.read(300 * "x"), "cannot read x+: File name too long"),
        (lambda: phaseplane.sweep("speed_bump", workers=-3), "workers = -3: must be 1 to 1000"),
    ],
)
def test_bad_input_is_refused_in_words(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_a_missing_column_suggests_its_neighbour(bump):
    with pytest.raises(KeyError, match="did you mean 'body_velocity'"):
        bump["body_velocit"]


def test_a_failed_run_keeps_what_it_has():
    run = phaseplane.run("Equation", equation="-x^3", duration=5.0, displacement_start=1.0)
    assert run.failure
    assert 0.0 < run.time[-1] < 5.0
    assert not run.holds


@pytest.mark.slow
def test_a_run_is_written_as_the_command_writes_it(bump, tmp_path):
    folder = bump.write(tmp_path / "out")
    read = phaseplane.scenarios.results.folder.read_results(folder)
    np.testing.assert_array_equal(read.columns["body_velocity"], bump["body_velocity"])
    assert phaseplane.read(folder / "results.csv").units == phaseplane.read(folder).units
    (tmp_path / "results.csv").write_bytes((folder / "results.csv").read_bytes())
    assert phaseplane.read(tmp_path / "results.csv").units["body_velocity"] == ""
    (folder / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="no run wrote"):
        bump.write(folder)


def test_what_was_written_of_a_scene_without_a_file_is_replaced_on_demand_only():
    phaseplane.run("QuarterCar", duration=0.1).write("out/scene")
    written('fmu = "QuarterCar"\nduration = 0.1')
    words = (
        "contains the results of a scene without a file, which those of scene.toml do not replace"
    )
    assert words in complaint("run scene.toml")


def test_results_do_not_replace_the_reference_that_they_are_compared_with():
    folder = phaseplane.run("QuarterCar", duration=0.1).write("out/scene")
    table = (folder / "results.csv").read_bytes()
    reference = f'reference = {{ file = "{folder}/results.csv" }}'
    written(f'fmu = "QuarterCar"\nduration = 0.1\nparameters.speed = 9\n[expect]\n{reference}')
    words = "scene: reference.file = out/scene/results.csv: is within out/scene"
    assert words in complaint("run scene.toml -o out/scene")
    with pytest.raises(InputError, match=words):
        phaseplane.run("scene.toml").write(folder)
    assert (folder / "results.csv").read_bytes() == table


def test_arrow_shares_the_memory(bump):
    table = bump.to_arrow()
    column = table["body_velocity"].chunk(0)
    assert column.buffers()[1].address == bump["body_velocity"].ctypes.data
    assert table.schema.field("body_velocity").metadata == {b"unit": b"m/s"}
    assert table["airborne"].type == pyarrow.bool_()


def test_pandas_shares_the_memory(bump):
    pytest.importorskip("pandas")
    frame = bump.to_pandas()
    assert np.shares_memory(frame["body_velocity"].to_numpy(), bump["body_velocity"])
    assert frame.index.name == "time"
    assert frame.attrs["units"]["body_velocity"] == "m/s"


@pytest.mark.slow
def test_xarray_shares_the_memory(bump):
    pytest.importorskip("xarray")
    data = bump.to_xarray()
    assert np.shares_memory(data["body_velocity"].to_numpy(), bump["body_velocity"])
    assert data["body_velocity"].attrs == {"units": "m/s"}


@pytest.mark.slow
def test_pictures_are_shown_and_saved(bump, tmp_path):
    for k, picture in enumerate((
        bump.figure(), bump.figure("phase_planes"), bump.plot("contact_force"),
        bump.plane("suspension_deflection", "suspension_deflection_rate"),
    )):  # fmt: skip
        assert picture._repr_png_().startswith(b"\x89PNG")
        assert picture.save(tmp_path / f"{k}.svg").stat().st_size > 1000


def test_a_picture_is_as_wide_as_asked(bump):
    plane = bump.plane("suspension_deflection", "suspension_deflection_rate", width="85 mm")
    for picture in (bump.plot("contact_force", width="85mm"), plane):
        assert picture.figure.get_figwidth() == pytest.approx(8.5 / 2.54)


def test_the_report_names_what_ran(bump):
    assert "in this process" in bump.report()
    assert ("uncompiled" in bump.report()) is not engine.compiled
    for through_fmu in ({"build_time": 0.2}, {"fmu": "fmus/QuarterCar.fmu"}):
        assert " with FMPy" in report(
            {**bump.summary, "drawn": None, "problems": [], **through_fmu}, Path()
        )
    assert "lift-off" in bump._repr_html_()


def test_a_report_has_peaks_contact_and_other_measures_each_once():
    measures = ["suspension_travel", "lift_off_count", "peak.body_displacement", "energy_residual",
                "smallest_contact_force", "step_count"]  # fmt: skip
    text = phaseplane.run("ap57", measures=measures).report()
    names = re.findall(r"^(\S.*?)  +\S", text, re.MULTILINE)
    assert names == [
        "model", "road", "solver", "duration",
        "body displacement", "lift-off", "contact", "energy", "suspension travel", "run", "expected",
    ]  # fmt: skip
    assert re.search("^lift-off +1 time$", text, re.MULTILINE)


def test_the_columns_of_a_report_are_aligned():
    """Beside long names of wheels and long units, too."""
    text = phaseplane.run("full_car").report()
    (model,) = re.findall("^model +", text, re.MULTILINE)
    lift_offs = re.findall("^.* lift-off +(?=\\d|none)", text, re.MULTILINE)
    assert {len(name) for name in lift_offs} == {len(model)}
    measures = ["peak.body_acceleration", "peak.pitch_acceleration", "peak.body_displacement"]
    pitching = phaseplane.run("half_car_pitch", measures=measures, expect=False).report()
    assert len({len(peak) for peak in re.findall("^.* +at(?= )", pitching, re.MULTILINE)}) == 1
    assert "rad/s2 at" in pitching


def test_examples():
    assert doctest.testmod(module).failed == 0


@pytest.mark.slow
def test_other_fmus_run_themselves(fmu):
    run = phaseplane.run(fmu, duration=0.1)
    assert run.scene.fmu.path == fmu.resolve()
    assert len(run.time) == 101


@pytest.mark.slow
def test_tables_are_read_with_their_units(bump, tmp_path):
    table = phaseplane.read(bump.write(tmp_path / "out"))
    assert table.units == bump.units
    np.testing.assert_array_equal(table["contact_force"], bump["contact_force"])
    rig = phaseplane.read(written("t;a\n[ms];[g]\n10;0,5\n", "rig.csv"))
    assert (rig.units, rig["a"][0]) == ({"t": "s", "a": "m/s2"}, 0.5 * 9.80665)


@pytest.mark.slow
def test_a_script_can_sweep_in_several_processes():
    """Its main module has no guard, so the processes must not run it again."""
    sweep_file('scene = "ap57"\nmeasures = ["smallest_contact_force"]\n[vary]\nspeed = [2, 3]\n')
    written(
        'import phaseplane\nprint(phaseplane.sweep("sweep.toml", workers=2)["speed"].tolist())\n',
        "script.py",
    )
    done = subprocess.run(
        [sys.executable, "-P", "script.py"], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("[2.0, 3.0]\n", "")


@pytest.mark.parametrize("name", ["runs.csv", "runs.parquet"])
def test_a_sweep_is_a_table_and_is_read_as_one(name):
    """Real numbers are real, whatever their values; one that is never known is not a number."""
    measures = '["peak.body_acceleration", "first_lift_off"]'
    sweep_file(f'scene = "ap57_figure13"\nmeasures = {measures}\n[vary]\nspeed = [15, 25]\n')
    table = phaseplane.sweep("sweep.toml", workers=1)
    printed("sweep sweep.toml -o there --workers 1 --table", name)
    for path in ("there", f"there/{name}"):
        again = phaseplane.read(path)
        assert (again.units, again.index, again.title) == (table.units, "run", table.title)
        for column, values in table.items():
            assert again[column].dtype == values.dtype
            np.testing.assert_array_equal(again[column], values)
    assert table["speed"].tolist() == [15, 25]
    assert table.units["peak.body_acceleration"] == "m/s2"
    assert table["speed"].dtype == table["first_lift_off"].dtype == float
    assert np.isnan(table["first_lift_off"]).all()
    measured = ["peak.body_acceleration"]
    alone = phaseplane.run("ap57_figure13", speed=25, measures=measured, expect=False)
    expected = alone.measures["peak.body_acceleration"]
    assert table["peak.body_acceleration"][1] == pytest.approx(expected, rel=1e-12)
    assert table["reason"].tolist() == ["", ""]


@pytest.mark.parametrize("name", ["pandas", "xarray"])
def test_a_library_that_is_missing_is_named_with_its_extra(name, monkeypatch):
    monkeypatch.setitem(sys.modules, name, None)
    table = phaseplane.Table({"time": np.arange(3.0)}, {"time": "s"})
    with pytest.raises(ImportError, match=rf"pip install 'phaseplane\[{name}\]'"):
        getattr(table, f"to_{name}")()
