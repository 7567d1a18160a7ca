"""The command line: what it leaves, what it says, and with which status it ends."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from errno import ENOSPC
from importlib import import_module
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any
from zipfile import ZipFile

import pytest
from click import Command, Context
from command_line import BARE, complaint, phaseplane, printed, reported, settings, written
from fmpy import read_model_description
from fmpy.util import read_csv
from hosting import HANGS, PROGRAM, started, wait_until
from phaseplane.scenarios import commands
from phaseplane.scenarios.cli import COMMANDS, main
from phaseplane.scenarios.draw.pictures import RULES_SHOWN
from phaseplane.scenarios.results.folder import read_results
from phaseplane.scenarios.scene.schema import Scene
from phaseplane.scenarios.scene.sections import CONSTRUCTION_FIGURES, RULES
from phaseplane.scenarios.simulate.driver import Drive, OpenFmu
from phaseplane.suspension.models import FILES

HISTORIES = ("show.figures=['time_histories']", "show.recording=false")
DIVERGING = ("spring.cubic=-1e9", "road.height=0.3")


def ap57_of(fmu: Path, *given: str) -> tuple[str, ...]:
    """To run ap57 through this FMU, with some keys set."""
    return "run", "ap57", *settings(f"fmu={fmu}", *given)


def in_a_process(*arguments: str, encoding: str = "utf-8", **more: Any) -> CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONIOENCODING": encoding},
        capture_output=True, encoding=encoding, timeout=HANGS, check=False, **more,
    )  # fmt: skip


# -- the list of commands ------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_the_list_of_commands_says_what_each_says_of_itself(name: str) -> None:
    command = main.get_command(Context(main), name)
    assert command is not None
    assert command.name == name
    assert (command.help or "").partition("\n\n")[0].replace("\n", " ") == COMMANDS[name].help
    assert len(COMMANDS[name].help) < 68  # on one line of a terminal of 80 columns


@pytest.mark.parametrize("name", COMMANDS)
def test_help_says_what_options_take_and_no_range_without_bounds(name: str) -> None:
    told = printed(name, "--help")
    assert " TEXT" not in told
    assert "None" not in told


def test_every_command_of_the_package_is_listed() -> None:
    listed = {entry.place for entry in COMMANDS.values()}
    assert listed == {
        f"{module.stem}.{attribute}"
        for module in Path(commands.__path__[0]).glob("*.py")
        for attribute, value in vars(import_module(f"{commands.__name__}.{module.stem}")).items()
        if isinstance(value, Command)
    }


# -- the main job --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ap57(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The results folder of `run ap57` as a user runs it, and what was said."""
    folder = tmp_path_factory.mktemp("ap57")
    done = in_a_process("-m", "phaseplane", "run", "ap57", cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "out" / "ap57", done.stdout


def test_run_leaves_results_pictures_and_recording(ap57: tuple[Path, str]) -> None:
    folder, _ = ap57
    assert sorted(path.name for path in folder.iterdir()) == [
        "construction.rrd", "phase_planes.png", "results.csv", "summary.json", "time_histories.png",
    ]  # fmt: skip
    assert [path.name for path in folder.parent.iterdir()] == ["ap57"]
    assert (folder / "phase_planes.png").read_bytes().startswith(b"\x89PNG")
    table = read_csv(folder / "results.csv")
    assert len(table) == 1001
    assert table["body_displacement"].min() == pytest.approx(-0.0206, abs=1e-4)
    assert set(table["airborne"]) == {0.0, 1.0}


def test_run_tells_the_figures_that_matter(ap57: tuple[Path, str]) -> None:
    folder, said = ap57
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    peak = summary["measures"]["peak.wheel_displacement"]
    wanted = [
        "Apetaur", "QuarterCar", "bump 50 mm high, 1 m long, at 20 m/s", "extrapolated",
        f"{1e3 * peak['value']:.3f} mm", "30.662 ms", "71.953 ms", "41.290 ms",
        "smallest force 0 N at 30.66 ms",
        f"{summary['measures']['step_count']['value']} steps", "4 of 4 hold", "QuarterCar, packed",
        *(f"out/ap57/{name}" for name in summary["files"]),
    ]  # fmt: skip
    assert [words for words in wanted if words not in said] == []
    assert said.isascii() or "Půst" in said
    assert max(map(len, said.splitlines())) <= 100


def test_run_again_replaces_the_folder(fmu: Path) -> None:
    run = (*ap57_of(fmu, "show.recording=false"), "-o", "here")
    printed(*run, *settings("show.figures=['time_histories']"))
    assert Path("here", "time_histories.png").exists()
    printed(*run, *settings("show.figures=[]"))
    assert sorted(os.listdir("here")) == ["results.csv", "summary.json"]
    assert os.listdir() == ["here"]


def test_json_is_the_summary_as_written(fmu: Path) -> None:
    summary = reported("run ap57_figure13", *settings(f"fmu={fmu}"), *BARE)
    assert summary == json.loads(Path("out/ap57_figure13/summary.json").read_text("utf-8"))
    assert summary["measures"]["lift_off_count"]["value"] == 0


@pytest.mark.slow
def test_figure_13_is_drawn(fmu: Path) -> None:
    drawn = settings(f"fmu={fmu}", "show.figures=['construction_sheet']")
    printed("run ap57_figure13", *drawn)
    assert Path("out/ap57_figure13/construction_sheet.png").stat().st_size > 10_000


# -- failures ------------------------------------------------------------------------------------


def test_an_expectation_that_fails(fmu: Path) -> None:
    result = phaseplane(*ap57_of(fmu, "expect.lift_off_count=2"), *BARE)
    assert result.exit_code == 1
    assert result.stderr == "phaseplane: ap57: lift_off_count = 1, expected 2\n"
    assert "3 of 4 hold" in result.stdout
    assert Path("out/ap57/results.csv").exists()


def test_what_a_scene_expects_is_checked_when_it_is_changed(fmu: Path) -> None:
    changed = (*ap57_of(fmu, "road.height=1 cm"), *BARE)
    result = phaseplane(*changed)
    assert result.exit_code == 1
    assert "lift_off_count = 0, expected 1" in result.stdout
    assert "nothing checked" not in result.stdout
    unchecked = printed(*changed, "--no-expect")
    assert "not checked: lift_off_count, first_lift_off" in unchecked
    own = printed(*changed, "--no-expect", *settings("expect.lift_off_count=0"))
    assert "1 of 1 hold" in own


def test_what_has_no_effect_is_said_once(fmu: Path) -> None:
    result = phaseplane(*ap57_of(fmu, "road.class=F"), *BARE, "--json")
    assert result.exit_code == 0
    words = "road.class has no effect on the motion: road.shape is bump"
    assert result.stderr == f"phaseplane: warning: {words}\n"
    assert json.loads(result.stdout)["warnings"] == [words]
    assert f"warning: {words}" in printed("show out/ap57")


def test_a_diverging_run(fmu: Path) -> None:
    said = complaint(*ap57_of(fmu, *HISTORIES, *DIVERGING), status=1)
    assert "stopped after 0.018 s of 1 s" in said
    assert "diverged at 0.018" in said
    assert len(read_csv("out/ap57/results.csv")) == 19
    assert Path("out/ap57/time_histories.png").exists()


@pytest.mark.parametrize(
    ("settings", "problem", "rows"),
    [
        (
            (*DIVERGING, "show.figures=[]"),
            "the construction cannot be drawn: the construction d",
            19,
        ),
        (
            ("construction.step=1 s",),
            "the construction cannot be drawn: step = 1 s would turn",
            1001,
        ),
    ],
)
def test_a_construction_that_cannot_be_drawn_costs_only_itself(
    fmu: Path, settings: tuple[str, ...], problem: str, rows: int
) -> None:
    result = phaseplane(*ap57_of(fmu, *settings), "--json")
    assert result.exit_code == 1
    summary = json.loads(result.stdout)
    assert summary["problems"][0].startswith(problem)
    assert (summary["rows"], summary["drawn"]) == (rows, None)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("run", "Missing argument 'SCENE'; see 'phaseplane run --help'\n"),
        ("compare a b --columns x", "(Did you mean one of: '--column', '--common'?)\n"),
        ("planes", "No such command 'planes'; see 'phaseplane --help'\n"),
        ("rum ap57", "did you mean 'run'?"),
        ("run ap75", "did you mean 'ap57'?"),
        ("ladder quarter_car", "did you mean 'QuarterCar'?"),
        ("ladder half-car-pitch", "did you mean 'half_car_pitch'?"),
        ("run gone.toml", "no scene file gone.toml"),
        ("run bad.toml", "not TOML"),
        ("run ap57 --sett x=1", "No such option '--sett'. Did you mean '--set'?"),
        ("run ap57 --quiet", "No such option '--quiet'; see 'phaseplane run --help'\n"),
        ("run ap57 --set sprung_mass=-3", "sprung_mass = -3: must be greater than 0"),
        ("run ap57 --set speed=inf", "speed = inf: must be finite and greater than 0"),
        ("run ap57 --set 'speed=3 kg'", "'kg' does not fit"),
        ("run ap57 --set spead=3", "did you mean 'speed'?"),
        ("run ap57 -o full", "full contains no results of a run"),
        ("run ap57 -o bad.toml", "bad.toml is a file"),
        ("run ap57 -o .", "current folder"),
        ("build", "Missing option '-o'"),
        ("build Quartercar -o x", ".toml or .py file; did you mean 'QuarterCar'?"),
        ("build -o bad.toml/x", "cannot write"),
        ("build --native -o full Quartercar", "did you mean 'QuarterCar'"),
        ("build --native -o full QuarterCar --platforms win", "platform 'win' is unknown"),
        ("build --native -o full QuarterCar --set road.hight=3", "did you mean 'road.height'"),
        ("build --native -o full QuarterCar --set friction", "must be name=value"),
        (
            "build --native -o full QuarterCar --set friction=-1",
            "friction = -1: must be at least 0",
        ),
        ("build --native -o full QuarterCar --set lift_off=perhaps", "must be true or false"),
        ("build --native -o full ap57 --set road.hight=3", "did you mean 'road.height'"),
        ("optimise full", "full is a folder; give a study's file, such as study.toml"),
        ("sweep full", "full is a folder; give the path of a .toml file"),
        ("fit ap57", "no such file: ap57; ap57 is a scene"),
        (
            "list QuarterCar extra",
            "unexpected extra argument (extra); see 'phaseplane list --help'",
        ),
        ("list extra", "model 'extra': must be one of"),
        ("replay ap57", "--save F.rrd, --figure F.png"),
        ("replay ap57 --save x.txt", "must end in .rrd"),
        ("replay ap57 --figure x.jpg", "must end in .png"),
        ("replay ap57 --figure x.gif --kind figure7", "only phase_planes can be animated"),
        ("replay ap57 --figure x.gif --at-step 3", "leave --at-step out"),
        ("replay ap57 --save x.rrd --at-step 3", "--at-step is for a figure; give --figure F.png"),
        (
            "replay ap57 --save x.rrd --kind storyboard",
            "--kind is for a figure; give --figure F.png",
        ),
        ("run ap57 --serve --connect rerun+http://127.0.0.1:1/proxy", "give one of them"),
        ("run ap57 --address 0.0.0.0", "give --serve, too"),
        ("replay ap57 --figure x.png --kind figure77", "did you mean 'figure7'?"),
        ("replay ap57 --figure x.png --kind x", "'x': must be one of phase_planes"),
        ("replay ap57 --figure x.png --kind figure12", "half_car_rigid_tyres"),
        ("replay ap57 --figure no/x.png", "no folder no"),
        ("replay ap57 --figure folder.png", "folder.png is a folder"),
        ("replay ap75 --save x.rrd", "or of a results folder"),
        ("replay full --save x.rrd", "is not a results folder"),
        (f"show {300 * 'x'}", "x: File name too long"),
        (f"build OneDof -o {300 * 'x'}", "x: File name too long"),
        ("replay ap57 --save x.rrd --construction detla", "--construction 'detla': must be one of"),
        ("replay ap57 --save x.rrd --construction detla", "'delta'?"),
        ("replay ap57 --save x.rrd --step fast", "--step 'fast': 'fast' is not a number"),
        ("run ap57 --plane body_displacment,x", "--plane: QuarterCar has no output"),
        ("run ap57 --plane x", "'--plane': x: give two columns, such as x,y"),
        ("replay ap57 --save x.rrd --step '1 s'", "at most a right angle"),
        ("replay ap57 --save x.rrd --over gone.csv", "cannot read gone.csv"),
        ("replay ap57 --save x.rrd --over bad.toml", "must end in"),
        ("replay gone.csv --save x.rrd", "replay SCENE --over gone.csv"),
        ("replay gone.mat --save x.rrd", "replay SCENE --over gone.mat"),
        ("serve missing", "no folder missing"),
        ("serve full", "no recording (.rrd) in full"),
        ("replay ap57 --connect here", "here is not the address of a viewer"),
        ("run ap57 --connect here", "here is not the address of a viewer"),
        ("run none.fmu", "none.fmu: fmu = 'none.fmu': no such file\n"),
        ("run ap57 --save live.txt", "must end in .rrd"),
        ("run ap57 -o folder.png --save folder.png/x.rrd", "x.rrd: is within folder.png"),
        ("stability lift_of", "did you mean 'lift_off'"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(line: str, words: str) -> None:
    written("fmu = QuarterCar\n", "bad.toml")
    Path("folder.png").mkdir()
    Path("full").mkdir()
    Path("full", "diary.txt").touch()
    assert words.lower() in complaint(line).lower()
    assert sorted(os.listdir()) == ["bad.toml", "folder.png", "full"]
    assert os.listdir("full") == ["diary.txt"]


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        ("commands.run.run_scene", "interrupted"),
        ("draw.constructions.draw_scene",
         "interrupted while the construction was drawn, before the run"),
    ],
)  # fmt: skip
def test_what_is_interrupted_before_the_run_leaves_nothing(
    stage: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(f"phaseplane.scenarios.{stage}", interrupt)
    result = phaseplane("run ap57")
    assert result.exit_code == 130
    assert result.stderr.strip().startswith(f"phaseplane: {words}")
    assert os.listdir() == []


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_keeps_what_it_has_computed(
    number: signal.Signals, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = OpenFmu.drive

    def interrupted_at_half(self: OpenFmu, scene: Scene, *args: Any, **how: Any) -> Drive:
        def progress(part: float) -> None:
            if part >= 0.5 and not how["interrupted"]():
                os.kill(os.getpid(), number)

        return drive(self, scene, *args, **{**how, "progress": progress})

    monkeypatch.setattr(OpenFmu, "drive", interrupted_at_half)
    # with the pictures and the recording of the scene
    result = phaseplane("run ap57")
    assert result.exit_code == status
    said = "phaseplane: interrupted at 0.5 s of 1 s; the results until then are in out/ap57\n"
    assert result.stderr.lstrip() == (said if number == signal.SIGINT else "")
    assert sorted(os.listdir("out/ap57")) == ["results.csv", "summary.json"]
    kept = read_results(Path("out/ap57"))
    assert kept.stopped == {"time": 0.5, "reason": "interrupted"}
    assert len(kept.columns["time"]) == 501


@pytest.mark.parametrize("name", ["stdout", "stderr"])
def test_a_closed_output_is_no_error(name: str) -> None:
    """As under a service without a terminal."""
    code = (
        f"import sys; sys.{name} = None\nfrom phaseplane.scenarios.cli import main\n"
        "main(['run', 'ap57_obstacle', '--set', 'show.figures=[]', '--set', 'show.recording=false'])"
    )
    ended = in_a_process("-c", code)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert (ended.stdout == "") == (name == "stdout")


def test_a_closed_pipe_is_no_error() -> None:
    with subprocess.Popen(
        [sys.executable, "-c",
         "import sys; sys.stdin.readline()\nfrom phaseplane.scenarios.cli import main; main(['list'])"],
        text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdin and process.stdout and process.stderr  # noqa: PT018
        process.stdout.close()
        process.stdin.write("go\n")
        process.stdin.close()
        assert process.stderr.read() == ""
        assert process.wait(HANGS) == 141


def test_output_that_cannot_be_encoded() -> None:
    done = in_a_process("-m", "phaseplane", "run", "ap57\N{SNOWMAN}", encoding="latin-1")
    assert done.returncode == 2
    assert done.stderr.startswith("phaseplane: no scene 'ap57?'")
    assert len(done.stderr.splitlines()) == 1


def in_the_c_locale(*arguments: str) -> CompletedProcess[str]:
    """In a folder and with a file that have other letters; Python's UTF-8 mode is forbidden."""
    if sys.platform != "linux":
        pytest.skip("not on this platform: names of files are in UTF-8 in every locale")
    folder = Path("žlutý")
    folder.mkdir(exist_ok=True)
    return subprocess.run(
        [*PROGRAM, *arguments],
        env={**os.environ, "LC_ALL": "C", "PYTHONUTF8": "0"},
        capture_output=True, encoding="utf-8", timeout=HANGS, check=False, cwd=folder,
    )  # fmt: skip


def test_names_of_files_have_all_letters_in_the_c_locale() -> None:
    done = in_the_c_locale("run", "kůň.toml")
    assert done.stderr.startswith("phaseplane: no scene file kůň.toml")


@pytest.mark.slow
def test_all_files_are_written_in_the_c_locale() -> None:
    tables = settings('show.table="results.parquet"', 'show.figures=["time_histories"]')
    done = in_the_c_locale("run", "ap57", "-o", "výsledky", "--save", "běh.rrd", *tables)
    assert done.returncode == 0, done.stderr
    names = {"construction.rrd", "results.parquet", "summary.json", "time_histories.png"}
    assert {path.name for path in Path("žlutý", "výsledky").iterdir()} == names
    assert Path("žlutý", "běh.rrd").exists()


@pytest.mark.slow
def test_a_backend_of_matplotlib_that_does_not_exist_is_no_error() -> None:
    """No command opens a window; the import of matplotlib would fail."""
    done = subprocess.run(
        [*PROGRAM, "portrait", "van_der_pol", "--figure", "portrait.svg"],
        env={**os.environ, "MPLBACKEND": "nonsense"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert Path("portrait.svg").is_file()


# -- the other commands --------------------------------------------------------------------------


def test_list() -> None:
    lines = printed("list").splitlines()
    assert lines[0] == "phaseplane run"
    assert lines[1].split(maxsplit=1) == [
        "ap57",
        "Quarter car over a 5 cm bump, with wheel lift-off",
    ]
    listed = reported("list")
    assert set(listed["scenes"]) >= {"ap57", "ap57_figure13"}
    assert set(listed["sweeps"]) >= {"speed_bump", "four_post"}
    assert list(listed["models"]) == [*FILES, "Equation"]


@pytest.mark.slow
def test_build_packs_what_runs() -> None:
    files = printed("build -o fmus").splitlines()
    assert {str(Path("fmus", f"{model}.fmu")) for model in FILES} <= set(files)
    assert all(Path(file).stat().st_size for file in files)
    kinds = {Path(file).suffix for file in reported("build OneDof -o fmus --ssp")["files"]}
    assert kinds == {".fmu", ".csv", ".opt", ".txt", ".ssp"}
    told = printed(*ap57_of(Path("fmus/QuarterCar.fmu")), *BARE)
    assert f"from {Path('fmus', 'QuarterCar.fmu')}" in told
    for given, words in (
        ('spring.table="0:1, 1:2"', "must pass through 0:0"),
        ("unsprung_mass=-3", "unsprung_mass = -3: must be greater than 0"),
    ):  # a packed model of ours checks what it is given as the model itself does
        assert words in complaint(*ap57_of(Path("fmus/QuarterCar.fmu"), given))


def test_a_full_disk_is_no_bad_input_and_leaves_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: object) -> None:
        raise OSError(ENOSPC, "No space left on device")

    monkeypatch.setattr("phaseplane.vehicle_fmus.build._packed", lambda *_: b"")
    monkeypatch.setattr("phaseplane.vehicle_fmus.archives.write_all", full)
    told = complaint("build OneDof -o new/fmus", status=1)
    assert told == "phaseplane: cannot write new/fmus: No space left on device\n"
    assert not Path("new").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="not on this platform: no SIGTERM")
def test_what_is_terminated_leaves_nothing_behind(tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    arguments = ["run", "ap57", *BARE, *settings("duration=4000 s"), "--realtime"]
    with started([*PROGRAM, *arguments], {"TMPDIR": str(scratch)}) as running:
        wait_until("it has made its folder", lambda: list(scratch.glob("phaseplane-*")), running)
        running.terminate()
        assert running.wait(HANGS) == 143
    assert not list(scratch.iterdir())


def test_a_packed_scene_says_what_it_leaves_out() -> None:
    done = phaseplane("build skyhook -o fmus")
    assert done.exit_code == 0, done.stderr
    assert "skyhook: the FMU is packed without the scene's controller" in done.stderr
    assert "connect one with actuator_force" in done.stderr
    assert all(Path(file).exists() for file in done.stdout.split())


@pytest.mark.parametrize("options", [
    "", *(pytest.param(o, marks=pytest.mark.slow) for o in ("--native", "--native --fmi 3", "--ssp"))
])  # fmt: skip
def test_the_default_experiment_of_a_packed_scene_ends_with_it(options: str) -> None:
    """It ended after 1 s: a host that asks for no other time drove 20 m of a road of 400 m."""
    Path("scene.toml").write_text('extends = "ap57"\nduration = "2.5 s"\n')
    assert phaseplane(f"build scene.toml -o fmus {options}").exit_code == 0
    experiment = read_model_description("fmus/scene.fmu").defaultExperiment
    assert float(experiment.stopTime) == 2.5
    if options == "--ssp":
        with ZipFile("fmus/scene.ssp") as archive:
            assert b'stopTime="2.5"' in archive.read("SystemStructure.ssd")
            for part in ("QuarterCar", "Road"):
                with archive.open(f"resources/{part}.fmu") as packed:
                    experiment = read_model_description(packed).defaultExperiment
                assert float(experiment.stopTime) == 2.5


def test_scenes_of_the_same_name_do_not_replace_each_other_in_a_folder() -> None:
    for folder in ("one", "two"):
        Path(folder).mkdir()
        Path(folder, "scene.toml").write_text('extends = "ap57"\n')
    said = complaint("build one/scene.toml two/scene.toml -o fmus")
    assert "one/scene.toml and two/scene.toml: both would be packed as scene.fmu" in said
    assert not Path("fmus").exists()


def test_replay_a_scene() -> None:
    told = reported("replay ap57 --construction tangent --step '5 ms' --save x.rrd --figure x.svg")
    assert "tangent" in told["title"]
    assert told["steps"] == 30 + 2  # 0.15 s, and a step divided at lift-off and at touchdown
    assert Path("x.rrd").stat().st_size > 10_000
    assert "<svg" in Path("x.svg").read_text(encoding="utf-8")


def test_a_replay_takes_the_rule_that_the_figure_shows() -> None:
    line = "replay ap57_figure13 --figure a.svg --kind figure4b"
    told = reported(line)
    assert "rule osculating circle, step 2.5 ms" in told["title"]
    assert told["files"] == ["a.svg"]
    said = complaint(line, "--construction", "delta")
    assert "figure 4b needs the rule osculating_circle" in said
    assert set(RULES_SHOWN) <= set(CONSTRUCTION_FIGURES)
    assert set(RULES_SHOWN.values()) <= set(RULES)


@pytest.mark.slow
def test_a_moving_picture() -> None:
    short = ("--set", "construction.duration=10 ms", "--dark")
    printed("replay ap57 --figure a.gif", *short)
    assert Path("a.gif").read_bytes().startswith(b"GIF89a")


def test_replay_lies_over_results(ap57: tuple[Path, str]) -> None:
    """Its state points are the run's own: with 2 ms every second row, and those of the switches."""
    folder, _ = ap57
    told = reported("replay", str(folder), "--step", "2 ms", "--save", "over.rrd")
    assert told["steps"] == 75 + 1  # of the 0.15 s of the scene's construction
    assert told["drift"]["wheel_displacement"] < 2e-4
    assert Path("over.rrd").exists()
    refused = phaseplane("replay", str(folder), "--save", "over.rrd", "--set", "speed=3")
    assert refused.exit_code == 2
    assert "only construction.*" in refused.stderr


def test_replay_needs_the_motion(ap57: tuple[Path, str]) -> None:
    shutil.copytree(ap57[0], "copy")
    table = Path("copy/results.csv")
    table.write_text(table.read_text().replace('"wheel_velocity"', '"other"'))
    result = phaseplane("replay copy --save x.rrd")
    assert result.exit_code == 2
    assert "no column wheel_velocity; add it to show.outputs" in result.stderr


def test_help_without_a_command() -> None:
    assert printed() == printed("--help")
    assert "Exit status" in printed()


def test_version() -> None:
    assert printed("--version").startswith("phaseplane")
