"""Sweeps: what a file may say, rows against runs by hand, failures, the FMU, folders."""

from __future__ import annotations

import json
import os
from math import inf, nan
from pathlib import Path

import pytest
from command_line import complaint, phaseplane, printed, written
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.names import SWEEPS, sweep_titles
from phaseplane.scenarios.sweeps import running
from phaseplane.scenarios.sweeps.job import picture_of
from phaseplane.scenarios.sweeps.plan import load_plan
from phaseplane.scenarios.sweeps.report import format_sweep, summary_of, table_of
from phaseplane.scenarios.sweeps.running import Row, run_chunk, sweep
from phaseplane.suspension import engine
from phaseplane.suspension.models import build
from phaseplane.suspension.session import simulate
from small_sweep import GRID, HEAD, SCENE, rows, sweep_file
from transfer import transfer

from phaseplane import figures

pytestmark = pytest.mark.usefixtures("scene_of_a_sweep")


# -- plans -----------------------------------------------------------------------------------------


def test_a_grid_has_every_combination_and_a_list_goes_side_by_side() -> None:
    plan = load_plan(sweep_file())
    assert plan.keys == ("speed", "road.height")
    assert plan.units == ("m/s", "m")
    assert plan.points == tuple((v, h) for v in (10.0, 15.0, 20.0) for h in (0.02, 0.05))
    listed = GRID.replace("[vary]", 'method = "list"\n[vary]').replace('"2 cm",', '"2 cm", 0.03,')
    assert load_plan(sweep_file(listed)).points == ((10.0, 0.02), (15.0, 0.03), (20.0, 0.05))


@pytest.mark.parametrize("method", ["latin_hypercube", "sobol"])
def test_a_sample_fills_the_box_and_follows_its_seed(method: str) -> None:
    text = f"""
    scene = "scene.toml"
    method = "{method}"
    runs = 32
    seed = 4
    measures = ["lift_off_count"]
    [vary]
    speed = {{ from = 10, to = 20 }}
    "damper.bump_rate" = {{ from = "1 kN.s/m", to = 500 }}
    """
    plan = load_plan(sweep_file(text))
    assert len(set(plan.points)) == 32
    for k, (low, high) in enumerate(((10.0, 20.0), (500.0, 1000.0))):
        values = sorted(float(point[k]) for point in plan.points)
        assert low <= values[0] < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < values[-1] <= high
        # stratified: one value in each of 32 equal parts
        assert sorted({int(32 * (v - low) / (high - low)) for v in values}) == list(range(32))
    assert load_plan(sweep_file(text)).points == plan.points
    assert load_plan(sweep_file(text.replace("seed = 4", "seed = 5"))).points != plan.points


@pytest.mark.parametrize("method", ["latin_hypercube", "sobol"])
def test_a_sample_of_whole_numbers_takes_each_as_often(method: str) -> None:
    plan = load_plan(sweep_file(f"""
    scene = "scene.toml"
    method = "{method}"
    runs = 32
    measures = ["lift_off_count"]
    [vary]
    "road.seed" = {{ from = 1, to = 4 }}
    """))  # fmt: skip
    assert sorted(point[0] for point in plan.points) == sorted(8 * [1, 2, 3, 4])
    assert all(isinstance(point[0], int) for point in plan.points)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('scene = "scene.toml"', "", "'scene' is missing; the file needs scene, measures, vary"),
        ("scene.toml", "nowhere.toml", "no scene file"),
        ("scene.toml", "ap75", "did you mean 'ap57'?"),
        ("measures =", "measure =", "unknown key 'measure'; allowed: scene, title"),
        ("lift_off_count", "lift_of_count", "did you mean 'lift_off_count'?"),
        ("lift_off_count", "lift_off_count.max", "measures: no measure 'lift_off_count.max'"),
        ("speed =", "spead =", "did you mean 'speed'?"),
        ("count = 3", "counts = 3", "did you mean 'count'?"),
        (", count = 3", "", "needs count"),
        ("count = 3", "count = 600000", "1200000 runs; at most 1000000 are allowed"),
        (", to = 20.0", "", "'vary.speed.to' is missing; [vary.speed] needs from, to"),
        (
            '{ from = "36 km/h", to = 20.0, count = 3 }',
            "3",
            "speed = 3: must be a list of values, or",
        ),
        ('["2 cm", 0.05]', "[[1]]", "[1]: a value must be a number, a string, true or false"),
        ('"road.height"', "parameters.speed", "'speed' is given twice"),
        ('"road.height" = ["2 cm", 0.05]', "parameters.duration = [1]", "no parameter 'duration'"),
        ('"road.height"', "extends", "extends: only a scene's file can name its base"),
        ('"road.height"', '"expect.lift_off_count"', "a sweep checks no expectations"),
        ('"road.height"', '"construction.step"', "construction.step: no measure depends on it"),
        ('"road.height"', '"show.dark"', "show.dark: no measure depends on it"),
        ('"36 km/h"', "1" + "0" * 400, "must be a finite number in SI or a string with a unit"),
        ('"road.height" = ["2 cm", 0.05]', "duration = [1, 0]", "must be greater than 0 s"),
        ('"road.height" = ["2 cm", 0.05]', 'fmu = ["QuarterCr"]', "did you mean 'QuarterCar'?"),
        ('"road.height"', '"duraton"', "did you mean 'duration'?"),
        ("count = 3", "count = 1", "greater than or equal to 2"),
        ('["2 cm", 0.05]', "[]", "the list is empty"),
        ('["2 cm", 0.05]', '["2 kg"]', "'kg' does not fit"),
        ('"36 km/h"', "-1", "must be greater than 0"),
        (
            '"road.height" = ["2 cm", 0.05]',
            'road.shape = ["flat", "input"]',
            "vary.road.shape: road.shape = 'input': a scene gives no inputs; use road.table",
        ),
        (
            "[vary]",
            'method = "sobol"\n[vary]',
            "runs is missing, the number of runs of method sobol",
        ),
        ("[vary]", 'method = "sobol"\nruns = 5\n[vary]', "power of two"),
        ("[vary]", 'method = "latin_hypercube"\nruns = 5\n[vary]', "needs a range"),
        ("[vary]", 'method = "griddle"\n[vary]', "did you mean 'grid'?"),
        ("[vary]", 'method = "list"\n[vary]', "the same number of values"),
        ("[vary]", "[vary", "not TOML"),
        ("[vary]", "runs = 4\n[vary]", "runs: for the methods latin_hypercube and sobol only"),
    ],
)
def test_what_a_sweep_file_may_not_say(old: str, new: str, words: str) -> None:
    assert old in GRID
    with pytest.raises(InputError) as caught:
        load_plan(sweep_file(GRID.replace(old, new)))
    assert words in str(caught.value)
    assert str(caught.value).startswith("sweep.toml: ") or "cannot read" in str(caught.value)
    assert str(caught.value).isprintable()


def test_no_key_is_proposed_that_cannot_be_varied() -> None:
    with pytest.raises(InputError, match=r"no parameter or scene key 'titel'$"):
        load_plan(sweep_file(GRID.replace('"road.height"', "titel")))


@pytest.mark.parametrize("name", sweep_titles())
def test_a_sweep_that_comes_along_is_found_by_name(name: str) -> None:
    plan = load_plan(name)
    assert (plan.name, plan.title) == (name, sweep_titles()[name])
    assert plan.title
    assert len(plan.points) > 10


@pytest.mark.slow
def test_a_stepped_sine_follows_the_transfer_function(tmp_path: Path) -> None:
    """The amplitudes of a linear car on the rig are those of its linearised system."""
    linear = "\n".join(
        f"{name} = {value}"
        for name, value in {
            "damper.rebound_limit": 0.0, "damper.bump_limit": 0.0, "damper.rebound_rate": 1500.0,
            "damper.bump_rate": 1500.0, "road.height": 0.002,
        }.items()
    )  # fmt: skip
    (tmp_path / "linear.toml").write_text(f'extends = "four_post_sine"\n[parameters]\n{linear}\n')
    text = (SWEEPS / "four_post.toml").read_text().replace("four_post_sine", "linear.toml")
    plan = load_plan(sweep_file(text.replace("count = 79", "count = 14")))
    found, _ = sweep(plan, tmp_path / "journal", workers=1)
    system = build(plan.scene.fmu.model, plan.scene.all_parameters)
    gain = abs(transfer(system, [float(point[0]) for point in plan.points]))
    for row, (body, wheel) in zip(found, gain, strict=True):
        assert row.values[0] == pytest.approx(1e-3 * body, rel=5e-3)
        assert row.values[1] == pytest.approx(1e-3 * wheel, rel=5e-3)


def test_values_are_shown_in_the_unit_in_which_they_were_given() -> None:
    plan = load_plan(sweep_file(GRID.replace("to = 20.0", 'to = "72 km/h"')))
    assert plan.shown == (("km/h", pytest.approx(1 / 3.6)), ("m", 1.0))  # not all in cm
    assert load_plan(sweep_file()).shown[0] == ("m/s", 1.0)
    timed = HEAD + '[vary]\nduration = ["100 ms", "200 ms"]\n'
    plan = load_plan(sweep_file(timed))
    assert plan.points == ((0.1,), (0.2,))
    assert plan.shown == (("ms", 1e-3),)
    assert plan.units == ("s",)


def test_a_sweep_is_told_with_units_and_peaks_by_their_magnitude() -> None:
    text = GRID.replace("to = 20.0", 'to = "72 km/h"').replace('["2 cm", 0.05]', '["2 cm", "5 cm"]')
    text = text.replace("peak.body_displacement", "peak.suspension_deflection")
    result = phaseplane("sweep", sweep_file(text), "--workers", "1")
    found = [float(row["peak.suspension_deflection"]) for row in rows()]
    assert min(found) < 0.0
    largest = max(found, key=abs)
    (line,) = (one for one in result.stdout.splitlines() if one.startswith("peak."))
    assert f"{1e3 * largest:.3f} mm  speed = 36 km/h, road.height = 5 cm" in line
    told = json.loads(Path("out/sweeps/sweep/summary.json").read_text())["measures"]
    assert told["peak.suspension_deflection"]["max"] == largest
    assert told["peak.suspension_deflection"]["unit"] == "m"


def test_a_sweep_tells_what_all_runs_share_and_what_runs_lack() -> None:
    """The first of equal runs was named as if it alone had the value; what none has was left out."""
    measures = '"smallest_contact_force", "lift_off_count", "first_lift_off", "first_touchdown"'
    text = GRID.replace('"peak.body_displacement", "lift_off_count"', measures)
    told = printed("sweep", sweep_file(text), "--workers", "1", "--json")
    counts = [int(row["lift_off_count"]) for row in rows()]
    assert json.loads(told)["lacking"]["first_lift_off"] == counts.count(0) > 0
    assert f"first_lift_off has no value in {counts.count(0)} of 6 runs" in printed(
        "sweep", "sweep.toml", "--workers", "1"
    )
    text = text.replace("to = 20.0", "to = 10.0").replace('["2 cm", 0.05]', "[0.001, 0.002]")
    told = printed("sweep", sweep_file(text), "--workers", "1")
    (line,) = (one for one in told.splitlines() if one.startswith("lift_off_count"))
    assert line.split() == ["lift_off_count", "0", *["all", "runs"], "0", *["all", "runs"]]
    assert "first_lift_off has no value in any of 6 runs" in told


# -- runs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compiled", [True, False])
def test_a_sweep_says_that_it_runs_uncompiled(
    compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "compiled", compiled)
    told = printed("sweep", sweep_file(), "--workers", "1")
    assert ("uncompiled and therefore" in told) != compiled
    assert json.loads(Path("out/sweeps/sweep/summary.json").read_text())["uncompiled"] != compiled


@pytest.mark.slow
def test_rows_are_what_runs_by_hand_give() -> None:
    printed("sweep", sweep_file(), "--workers", "2")
    found = rows()
    assert [row["run"] for row in found] == [str(k) for k in range(6)]
    times = [0.005 * k for k in range(41)]
    for row in found:
        given = {"speed": float(row["speed"]), "road.height": float(row["road.height"])}
        columns = simulate("QuarterCar", given, times, ["body_displacement", "lift_off_count"])
        peak = max(columns["body_displacement"], key=abs)  # type: ignore[arg-type]
        assert float(row["peak.body_displacement"]) == peak
        assert int(row["lift_off_count"]) == columns["lift_off_count"][-1]
        assert (row["ok"], row["reason"]) == ("true", "")
    assert sorted(os.listdir("out/sweeps/sweep")) == ["runs.csv", "summary.json", "sweep.png"]
    assert os.listdir("out/sweeps") == ["sweep"]  # and no journal


def test_runs_in_one_call_and_runs_that_are_stepped_give_the_same_rows(tmp_path: Path) -> None:
    """The energy balance needs steps from row to row; what else is measured must not notice."""
    names = (
        "peak.contact_force", "rms.body_acceleration", "suspension_travel", "airborne_time",
        "lift_offs", "step_count", "dynamic_load_coefficient", "lowest_natural_frequency",
    )  # fmt: skip
    found = []
    for k, measures in enumerate((names, (*names, "energy_residual"))):
        text = GRID.replace('"peak.body_displacement", "lift_off_count"', str(list(measures))[1:-1])
        rows, _ = sweep(load_plan(sweep_file(text)), tmp_path / f"journal{k}", workers=1)
        assert not any(row.reason for row in rows)
        found.append([row.values[: len(names)] for row in rows])
    assert found[0] == found[1]
    assert {values[names.index("lift_offs")] for values in found[0]} == {0, 1}


def test_a_measure_with_several_values_is_counted_or_refused() -> None:
    """The number of natural frequencies is not one of them."""
    text = GRID.replace('"lift_off_count"', '"lift_offs"')
    told = phaseplane("sweep", sweep_file(text), "--workers", "1", "--json")
    extent = json.loads(told.stdout)["measures"]["lift_offs"]
    assert (extent["unit"], extent["max"]) == ("count", 1)
    sweep_file(GRID.replace('"lift_off_count"', '"natural_frequencies"'))
    words = (
        "measures: natural_frequencies has several values; of each run one is needed: lowest_nat"
    )
    with pytest.raises(InputError, match=words):
        load_plan("sweep.toml")


def test_keys_of_the_scene_may_be_varied_too() -> None:
    text = HEAD + "[vary]\nduration = [0.1, 0.2]\nlift_off = [true, false]\n"
    printed("sweep", sweep_file(text), "--workers", "1")
    found = rows()
    assert [(row["duration"], row["lift_off"]) for row in found] == [
        ("0.1", "true"), ("0.1", "false"), ("0.2", "true"), ("0.2", "false"),
    ]  # fmt: skip
    assert [row["lift_off_count"] for row in found] == ["1", "0", "1", "0"]


def test_nested_tables_are_varied_as_they_are_given_to_a_scene() -> None:
    nested = """
    parameters.damper.rebound_rate = [1000, 2000]
    road = { height = { from = "1 cm", to = "3 cm", count = 2 }, seed = { from = 1, to = 4, count = 3 } }
    """
    plan = load_plan(sweep_file(f"{GRID.partition('[vary]')[0]}[vary]\n{nested}"))
    assert plan.keys == ("damper.rebound_rate", "road.height", "road.seed")
    assert plan.points[:3] == tuple((1000.0, 0.01, seed) for seed in (1, 2, 4))
    assert len(plan.points) == 12


def test_what_is_varied_without_effect_is_said_once() -> None:
    idle = "damper.rebound_rate = [500, 1000, 2000]"
    table = 'damper.table = "-1:-1000, 0:0, 1:1000"'
    sweep_file(SCENE + f"[parameters]\n{table}\n", "scene.toml")
    sweep_file(HEAD + f"[vary]\n{idle}\n")
    result = phaseplane("sweep sweep.toml --workers 1")
    words = "damper.rebound_rate has no effect on the motion: damper.table is given"
    assert result.stderr == f"phaseplane: warning: {words}\n"
    assert result.exit_code == 0
    # where something varied as well makes it act in some runs, there is nothing to say
    sweep_file(HEAD + f'[vary]\n{idle}\n"damper.table" = ["", "0:0, 1:1"]\n')
    assert load_plan("sweep.toml").warnings == []


def test_a_run_that_fails_is_a_row_with_its_reason() -> None:
    text = GRID.replace(
        '"road.height" = ["2 cm", 0.05]', '"spring.table" = ["", "-1:-5, 0:0, 1:5", "1:2, 0:0"]'
    )
    result = phaseplane("sweep", sweep_file(text), "--json", "--workers", "1")
    assert result.exit_code == 1
    assert "3 of 9 runs failed: spring.table" in result.stderr
    failed = [row for row in rows() if row["ok"] == "false"]
    assert [row["spring.table"] for row in failed] == ["1:2, 0:0"] * 3
    assert all("ascend" in row["reason"] or "spring.table" in row["reason"] for row in failed)
    assert failed[0]["peak.body_displacement"] == ""
    assert len(json.loads(result.stdout)["failures"]) == 3


@pytest.mark.parametrize(("equation", "start", "words"), [
    ("-x*x*x", 1.0, "no step is short enough"), ("x", 1e200, "rms.displacement is not a number"),
])  # fmt: skip
def test_of_runs_that_fail_one_by_one_no_measure_counts(
    equation: str, start: float, words: str
) -> None:
    Path("scene.toml").write_text(
        f'fmu = "Equation"\nduration = 3\nparameters.equation = "{equation}"'
    )
    text = 'scene = "scene.toml"\nmeasures = ["rms.displacement"]\n[vary]\ndisplacement_start = '
    result = phaseplane("sweep", sweep_file(f"{text}[0.1, {start}]"), "--json", "--workers", "1")
    assert [row["ok"] for row in rows()] == ["true", "false"]
    assert words in rows()[1]["reason"]
    assert rows()[1]["rms.displacement"] == ""
    assert json.loads(result.stdout)["measures"]["rms.displacement"]["run_of_max"] == 0


@pytest.mark.parametrize(
    ("ours", "theirs", "apart"),
    [
        ((2.0, None), (2.0, None), 0.0),
        ((2.0, 1), (1.5, 1), 0.25),
        ((-2.0, 0.0), (1.0, 0.0), 1.5),
        ((2.0, None), (2.0, 0.1), inf),
    ],
)
def test_the_disagreement_is_relative_and_infinite_where_only_one_knows_a_measure(
    ours: tuple, theirs: tuple, apart: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "run_chunk", lambda *_: [Row(0, ours)])
    assert running._disagreement(load_plan(sweep_file()), [Row(0, theirs)]) == apart


@pytest.mark.slow
def test_the_fmu_agrees_with_the_process(fmu: Path) -> None:
    result = printed("sweep", sweep_file(), "--through", "fmu", "--workers", "1", "--json")
    assert json.loads(result)["disagreement"] == 0.0
    through_fmu = rows()
    printed("sweep", sweep_file(), "--workers", "1")
    assert rows() == through_fmu
    Path("scene.toml").write_text(SCENE.replace('"QuarterCar"', f'"{fmu}"'))
    refused = phaseplane("sweep", sweep_file())
    assert (refused.exit_code, "--through fmu" in refused.stderr) == (2, True)


@pytest.mark.parametrize(("scene", "words"), [
    ("double_pendulum", "a user-defined system"), ("skyhook", "a scene with a controller"),
    ("van_der_pol", "an equation"),
])  # fmt: skip
def test_what_has_no_fmu_is_not_swept_through_one(scene: str, words: str) -> None:
    text = f'scene = "{scene}"\nmeasures = ["step_count"]\n[vary]\nduration = [0.1, 0.2]\n'
    text = text.replace("step_count", "rms.displacement") if scene == "van_der_pol" else text
    assert f"{words} runs in-process: leave out --through fmu" in complaint(
        "sweep", sweep_file(text), "--through", "fmu"
    )


@pytest.mark.slow
def test_parquet_and_refusals(monkeypatch: pytest.MonkeyPatch) -> None:
    from pyarrow import parquet  # noqa: PLC0415

    monkeypatch.setattr(running, "_PATIENCE", 0.3)
    printed("sweep", sweep_file(), "--workers", "1", "--table", "rows.parquet")
    assert parquet.read_table("out/sweeps/sweep/rows.parquet").num_rows == 6
    Path("out/sweeps/sweep/diary.txt").touch()
    for arguments, words in (
        (["--table", "rows.xlsx"], "ends in .csv or .parquet"),
        (["--workers", 10**23], "not in the range 1<=x<=1000"),
        ([], "diary.txt, which no run wrote"),
        (["-o", "x", "--dask", "tcp://127.0.0.1:1"], "no Dask scheduler"),
    ):
        result = phaseplane("sweep", sweep_file(), *arguments)
        assert result.exit_code in (1, 2)
        assert words in result.stderr
        assert len(result.stderr.splitlines()) == 1
    assert not list(Path().glob(".x*"))  # no journal of what has not begun


def test_a_picture_has_values_in_their_units_and_words_as_they_are_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawn: list[tuple] = []
    monkeypatch.setattr(figures, "sweep", lambda *of, **more: drawn.append((*of, more)))
    varied = '[vary]\nlift_off = [true, false]\nspeed = ["36 km/h", "72 km/h"]\n'
    plan = load_plan(sweep_file(f"{HEAD}{varied}"))
    picture_of(plan, plan.points, {"peak.body_displacement": [-0.001, None, 0.002, -0.003]})
    ((keys, measured, more),) = drawn
    assert keys == {
        "lift_off": ("", ["true", "true", "false", "false"]),
        "speed": ("km/h", pytest.approx([36.0, 72.0, 36.0, 72.0])),
    }
    assert measured == {
        "magnitude of peak.body_displacement":
            ("mm", pytest.approx([1.0, nan, 2.0, 3.0], nan_ok=True)),
    }  # fmt: skip
    assert more == {"title": "sweep"}


def test_a_picture_that_cannot_be_drawn_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("phaseplane.figures.save", full)
    result = phaseplane("sweep", sweep_file(), "--workers", "1")
    told = "sweep.png was not drawn: no space left"
    assert (result.exit_code, result.stderr) == (1, f"phaseplane: sweep: {told}\n")  # as of a run
    assert told in result.stdout.splitlines()
    assert sorted(os.listdir("out/sweeps/sweep")) == ["runs.csv", "summary.json"]


# -- folders ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_sweep_and_a_run_of_one_name_keep_their_folders() -> None:
    Path("car.toml").write_text(SCENE)
    Path("sub").mkdir()
    sweep_file(GRID.replace("scene.toml", "../scene.toml"), "sub/car.toml")
    printed("sweep sub/car.toml --workers 1")
    printed("run car.toml")
    assert len(rows("out/sweeps/car")) == 6
    assert Path("out/car/results.csv").exists()
    assert "out/sweeps/car contains the results of 'phaseplane sweep'" in complaint(
        "show out/sweeps/car"
    )
    for arguments, words in (
        (("run", "car.toml", "-o", "out/sweeps/car"), "'phaseplane sweep', which 'phaseplane run'"),
        (("sweep", "sub/car.toml", "-o", "out/car"), "'phaseplane run', which 'phaseplane sweep'"),
    ):
        assert words in complaint(*arguments)
    assert len(rows("out/sweeps/car")) == 6
    assert Path("out/car/results.csv").exists()


@pytest.mark.slow
def test_files_of_one_name_in_two_folders_do_not_replace_each_others_results() -> None:
    for name in ("a", "b"):
        Path(name).mkdir()
        Path(name, "car.toml").write_text(SCENE)
        sweep_file(GRID, f"{name}/sweep.toml")
    for command, file, folder in (
        ("run", "car.toml", "out/car"), ("sweep", "sweep.toml", "out/sweeps/sweep"),
    ):  # fmt: skip
        for again in range(2):
            assert phaseplane(command, f"a/{file}").exit_code == 0, again
        before = Path(folder, "summary.json").read_bytes()
        refused = phaseplane(command, f"b/{file}")
        assert refused.exit_code == 2
        told = f"{folder} contains the results of a/{file}, which those of b/{file} do not replace"
        assert told in refused.stderr
        assert Path(folder, "summary.json").read_bytes() == before
        printed(command, f"b/{file}", "-o", folder)
    os.mkdir("moved")
    for name in ("b", "out"):
        os.rename(name, f"moved/{name}")
    os.chdir("moved")
    printed("run b/car.toml")  # still the same file


@pytest.mark.slow
def test_equations_are_swept_too() -> None:
    text = """
    scene = "van_der_pol"
    measures = ["peak.displacement"]
    [vary]
    displacement_start = [0.5, 3.0]
    """
    printed("sweep", sweep_file(text), "--workers", "1")
    small, large = (float(row["peak.displacement"]) for row in rows())
    assert abs(small) == pytest.approx(2.009, abs=2e-3)  # the limit cycle
    assert large == 3.0
    assert "leave out --through fmu" in complaint("sweep sweep.toml --through fmu")


def test_a_model_without_a_measure_fails_its_run_in_words() -> None:
    """The sweep broke off with a KeyError."""
    scene = written("fmu = 'QuarterCar'\nduration = 0.1\n")
    head = f"scene = '{scene}'\nmeasures = ['peak.wheel_displacement']\n"
    plan = load_plan(written(f"{head}vary.fmu = ['QuarterCar', 'OneDof']\n", "s.toml"))
    first, second = run_chunk(plan, [0, 1], "process")
    assert first.reason == ""
    assert second.reason.startswith("OneDof: no measure 'peak.wheel_displacement'")


def test_runs_that_fail_are_not_among_all_runs() -> None:
    plan = load_plan(sweep_file(GRID))
    values = tuple(0.1 for _ in plan.measures)
    rows = [Row(0, values, ""), Row(1, values, ""), Row(2, (None,) * len(values), "diverged")]
    summary = summary_of(plan, rows, {
        "made": 3, "seconds": 1.0, "uncompiled": False, "problems": [], "files": [],
    })  # fmt: skip
    told = format_sweep(plan, table_of(plan, rows), summary, Path("out"))
    assert told.count("all runs with a value") == 2 * len(values)
    assert "interruption" not in told
    told = format_sweep(plan, table_of(plan, rows), {**summary, "made": 1}, Path("out"))
    assert "; 2 from before the interruption" in told


def test_a_run_that_is_small_as_a_whole_is_told() -> None:
    """Zero is what is a rounding error in its own run; next to a larger run all of it read as 0."""
    scene = written("fmu = 'QuarterCar'\nduration = 0.3\nparameters.road.shape = 'bump'\n")
    head = f"scene = '{scene}'\nmeasures = ['peak.wheel_displacement']\n"
    sweep = written(f"{head}[vary]\n'road.height' = [2e-15, 0.05]\n", "s.toml")
    told = printed("sweep", sweep, "--workers", "1")
    (line,) = (one for one in told.splitlines() if one.startswith("peak.wheel"))
    assert "e-12 mm" in line
