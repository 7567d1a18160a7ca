"""Results are there before anything of them is drawn; what is drawn is added picture by picture."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from errno import ENOENT, ENOSPC
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import pytest
from click.testing import Result
from command_line import complaint, phaseplane, settings
from hosting import HANGS, started
from phaseplane.scenarios.commands import console
from phaseplane.scenarios.draw import pictures
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.folder import Place, read_results, replace_folder, write_results

from phaseplane.picture.files import replace_file

exercise, modelling, replay = (
    import_module(f"phaseplane.scenarios.commands.{name}")
    for name in ("exercise", "modelling", "replay")
)
FIGURES = 'show.figures=["time_histories", "phase_planes"]'
PICTURES = ["time_histories.png", "phase_planes.png"]
RESULTS = ["results.csv", "summary.json"]
FOLDER = Path("out", "ap57")


@pytest.fixture
def run(fmu: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """`phaseplane run ap57` with two figures, each drawn by the function given."""

    def go(draw: Callable[[str, Path], object] | None = None, *more: str) -> Result:
        with monkeypatch.context() as patch:
            if draw is not None:
                patch.setattr(pictures, "draw", lambda name, path, **_: draw(name, path))
            bare = settings(f"fmu={fmu}", "show.recording=false", FIGURES)
            return phaseplane("run ap57", *bare, *more)

    return go


def summary() -> dict[str, Any]:
    found: dict[str, Any] = json.loads((FOLDER / "summary.json").read_text("utf-8"))
    return found


def names() -> list[str]:
    assert [path.name for path in FOLDER.parent.iterdir()] == ["ap57"]
    return sorted(path.name for path in FOLDER.iterdir())


def test_results_stand_before_the_first_picture_is_drawn(run: Callable[..., Result]) -> None:
    seen = []

    def draw(name: str, path: Path) -> None:
        there = {each.name for each in FOLDER.iterdir()}
        seen.append((name, there, summary()["undrawn"], len(read_results(FOLDER).columns["time"])))
        path.write_bytes(name.encode())

    assert run(draw).exit_code == 0
    assert seen == [
        ("time_histories", {*RESULTS}, PICTURES, 1001),
        ("phase_planes", {*RESULTS, PICTURES[0]}, PICTURES[1:], 1001),
    ]
    assert names() == summary()["files"] == sorted([*RESULTS, *PICTURES])
    assert summary()["undrawn"] == []


@pytest.mark.slow
def test_an_interrupt_while_drawing_keeps_what_is_complete(run: Callable[..., Result]) -> None:
    def draw(name: str, path: Path) -> None:
        path.write_bytes(b"half a picture")
        if name == "phase_planes":
            raise KeyboardInterrupt

    result = run(draw)
    assert result.exit_code == console.INTERRUPTED
    assert result.stderr.split("\n", 1)[1].splitlines() == [  # click ends the line of ^C
        "phaseplane: interrupted while drawing phase_planes.png; the results and earlier pictures are "
        f"in {FOLDER}"
    ]
    assert names() == summary()["files"] == sorted([*RESULTS, PICTURES[0]])
    assert summary()["undrawn"] == PICTURES[1:]
    assert run().exit_code == 0  # it is replaced as any other
    assert names() == sorted([*RESULTS, *PICTURES])


def test_a_picture_that_fails_costs_itself_alone(run: Callable[..., Result]) -> None:
    def draw(name: str, path: Path) -> None:
        path.write_bytes(b"picture")
        if name == "time_histories":
            raise ValueError("no ink")

    assert run(draw).exit_code == console.FAILED
    assert names() == sorted([*RESULTS, PICTURES[1]])
    assert summary()["problems"] == ["time_histories.png was not drawn: no ink"]
    assert summary()["undrawn"] == PICTURES[:1]


def test_a_drawing_library_that_cannot_be_imported_costs_the_pictures_alone(
    run: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(**_: object) -> None:
        raise ImportError("libfreetype.so.6: cannot open shared object file")

    monkeypatch.setattr("phaseplane.figures.Look", broken)
    told = "was not drawn: libfreetype.so.6: cannot open shared object file"
    result = run()
    assert result.exit_code == console.FAILED
    assert result.stderr == f"phaseplane: ap57: {PICTURES[0]} {told} (and 1 more)\n"
    assert names() == RESULTS
    assert summary()["problems"] == [f"{name} {told}" for name in PICTURES]


def test_a_full_disk_leaves_whole_files_and_says_what_is_missing(
    run: Callable[..., Result],
) -> None:
    """As on a full disk: from the second picture on, no file may grow beyond 1 kB."""
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def draw(name: str, path: Path) -> None:
        if name == "phase_planes":
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
        path.write_bytes(b"picture")  # it fits, but not the summary that lists it

    try:
        result = run(draw)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert result.exit_code == console.FAILED
    assert result.stderr == (
        f"phaseplane: the results are in {FOLDER}, but the entries drawn, problems could not be added to "
        "their summary.json: File too large\n"
    )
    assert names() == summary()["files"] == sorted([*RESULTS, PICTURES[0]])
    assert summary()["undrawn"] == PICTURES[1:]


def test_the_hidden_folder_in_which_a_picture_is_drawn_is_not_told(tmp_path: Path) -> None:
    """Under whatever name it is reported."""
    problems: list[str] = []
    with (
        pictures.draws_or_tells("plane.png", problems),
        replace_file(tmp_path / ".ap57.49bd53df.png") as path,
    ):
        raise OSError(ENOSPC, "No space left on device", str(path))
    assert problems == ["plane.png was not drawn: No space left on device"]


def test_a_file_that_a_full_disk_cannot_take_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: object, path: Path) -> None:
        with replace_file(path) as draft:
            raise OSError(ENOSPC, "No space left on device", str(draft))

    monkeypatch.setattr("phaseplane.recording.record", full)
    Path("rows.csv").write_text("time,displacement\n0,0\n1,1\n", encoding="ascii")
    told = complaint("show rows.csv --save rows.rrd", status=console.FAILED)
    assert told == "phaseplane: cannot write rows.rrd: No space left on device\n"


def test_the_file_that_a_library_lacks_is_named() -> None:
    problems: list[str] = []
    with pictures.draws_or_tells("plane.png", problems):
        raise FileNotFoundError(ENOENT, "No such file or directory", "matplotlibrc")
    (problem,) = problems
    assert problem.endswith("No such file or directory: 'matplotlibrc'")


BROKEN = {  # what a package does that cannot be loaded, and what is told of it
    "raise OSError('no libfoo')": "no libfoo",
    "raise AttributeError('no such ufunc')": "no such ufunc",
    "": "No module named 'rerun.",  # an installation that was cut short
}


def without_rerun(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """`phaseplane` in a process in which rerun is this code, which cannot be loaded."""
    package = Path("broken", "rerun").absolute()
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(code, encoding="ascii")
    return subprocess.run(
        [sys.executable, "-P", "-m", "phaseplane", *arguments],
        env={**os.environ, "PYTHONPATH": str(package.parent)},
        capture_output=True, text=True, check=False, timeout=HANGS,
    )  # fmt: skip


@pytest.mark.parametrize("code", BROKEN)
def test_a_run_does_without_a_rerun_that_cannot_be_loaded(code: str, fmu: Path) -> None:
    bare = settings(f"fmu={fmu}", "show.recording=false", "show.figures=[]")
    done = without_rerun(code, "run", "ap57", *bare, "--save", "ap57.rrd")
    why = f"rerun cannot be loaded ({BROKEN[code]}"
    assert done.stderr.startswith(f"phaseplane: ap57: ap57.rrd was not written: {why}")
    assert done.stderr.endswith("); try `pip install --force-reinstall rerun-sdk`\n")
    assert done.stderr.count("\n") == 1
    assert done.returncode == console.FAILED
    assert names() == RESULTS


@pytest.mark.parametrize(
    ("command", "place"),
    [
        ("replay ap57 --save ap57.rrd", ""),
        ("show rows.csv --save ap57.rrd", ""),
        ("run ap57 --set show.figures=[]", "ap57: construction.rrd was not drawn: "),
    ],
)
def test_commands_say_in_one_line_that_rerun_cannot_be_loaded(
    command: str, place: str, fmu: Path
) -> None:
    Path("rows.csv").write_text("time,displacement\n0,0\n1,1\n", encoding="ascii")
    bare = settings(f"fmu={fmu}") if command.startswith("run") else []
    done = without_rerun("raise ImportError('no libfoo')", *command.split(), *bare)
    why = "rerun cannot be loaded (no libfoo); try `pip install --force-reinstall rerun-sdk`"
    assert done.stderr == f"phaseplane: {place}{why}\n"
    assert done.returncode == console.FAILED


@pytest.mark.slow
def test_nothing_is_added_to_the_results_of_another_run(run: Callable[..., Result]) -> None:
    def draw(name: str, path: Path) -> None:
        path.write_bytes(b"picture")
        results = read_results(FOLDER)
        with replace_folder(Place(FOLDER)) as draft:
            write_results(
                type(results)(results.columns, {**results.summary, "title": "other"}), draft
            )

    assert run().exit_code == 0
    result = run(draw, "-o", str(FOLDER))
    assert result.exit_code == console.FAILED
    assert "contains other results by now" in result.stderr
    assert names() == RESULTS
    assert summary()["title"] == "other"


@pytest.mark.slow
def test_an_interrupted_process_says_so_and_ends_with_its_status(fmu: Path) -> None:
    code = (
        "from time import sleep\n"
        "from phaseplane.scenarios.draw import pictures\n"
        "def draw(name, path, **_):\n"
        "    print(name, flush=True)\n"
        "    while True:\n"
        "        sleep(0.01)\n"  # `signal.pause` misses what comes just before it
        "pictures.draw = draw\n"
        "from phaseplane.scenarios.cli import main\n"
        "main()"
    )
    arguments = ["run", "ap57", *settings(f"fmu={fmu}", FIGURES)]
    command = [sys.executable, "-P", "-c", code, *arguments]
    with started(command, {}, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "time_histories\n"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=HANGS)
    assert process.returncode == console.INTERRUPTED
    assert said.lstrip().startswith("phaseplane: interrupted while drawing time_histories.png")
    assert names() == RESULTS


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_what_takes_long_is_named_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(console, "_SHOW_BAR_AFTER", 0.01)
    with console.progress_bar("drawing phase_planes.png"):
        while "drawing phase_planes.png" not in terminal.getvalue():
            pass
    assert terminal.getvalue().endswith("\r\033[K")  # and nothing is left of it


@pytest.mark.parametrize(
    ("module", "line", "label"),
    [
        (modelling, "portrait van_der_pol", "portrait of van_der_pol"),
        (modelling, "modes ap57", "modes of ap57"),
        (modelling, "ladder ap57", "ladder of ap57"),
        (replay, "replay ap57 --save planes.rrd", "construction of ap57"),
        (exercise, "exercise van_der_pol", "exercise of van_der_pol"),
    ],
)
def test_commands_that_may_take_long_tell_the_time(
    module: ModuleType, line: str, label: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some portraits take half a minute, without a sign that they are under way."""

    def shown(told: str) -> NoReturn:
        raise InputError(f"now comes {told}")

    monkeypatch.setattr(module, "progress_bar", shown)
    assert complaint(line) == f"phaseplane: now comes {label}\n"


def test_what_tells_its_parts_has_a_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(console, "_SHOW_BAR_AFTER", 0.01)
    with console.progress_bar("ap57") as show:
        assert show is not None
        while "%" not in terminal.getvalue():
            show(0.5)
    assert "50%" in terminal.getvalue()


def test_elsewhere_nothing_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with console.progress_bar("ap57") as show:
        show(0.5)
    assert sys.stderr.getvalue() == ""  # type: ignore[attr-defined]
