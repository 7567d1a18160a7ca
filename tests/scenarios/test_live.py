"""Runs that are shown while they go on, pages that show recordings, FMUs run as they are."""

from __future__ import annotations

import re
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace
from urllib.request import urlopen

import pytest
from command_line import BARE, complaint, phaseplane, printed
from fmpy.util import read_csv
from hosting import HANGS, PROGRAM, children, is_running, started, wait_until
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.draw.live import LiveRun
from phaseplane.scenarios.draw.recording_content import default_pairs, vehicle
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import case_names
from phaseplane.scenarios.simulate.runner import run
from phaseplane.scenarios.simulate.stepping import Rows
from rerun.chunk import RrdReader

from phaseplane.recording import Content, live, serving

DEFLECTION = "suspension_deflection"
PAIR = f"{DEFLECTION},{DEFLECTION}_rate"


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine may be slow to show a run."""
    monkeypatch.setattr(live, "_PATIENCE", HANGS)


def entities(path: Path) -> set[str]:
    return {chunk.entity_path for chunk in RrdReader(path).stream() if not chunk.is_static}


@pytest.mark.slow
def test_a_run_is_the_same_whether_it_is_watched_or_not() -> None:
    with serving() as server:
        printed("run ap57", *BARE, "--connect", server.url)
    printed("run ap57", *BARE, "-o", "alone")
    assert Path("out/ap57/results.csv").read_bytes() == Path("alone/results.csv").read_bytes()


def test_a_run_is_announced_to_the_viewer_once() -> None:
    """`watch` is called after every step of the run, so that it must cost next to nothing."""

    class Announced(list[list[float]]):
        count = 0

        @property
        def names(self) -> list[str]:
            self.count += 1
            return ["time"]

    rows = Announced()
    shown = live.Live(Content("a run", histories={"time": [], "x": []}))
    for _ in range(5):
        LiveRun(None, shown).watch(rows)  # type: ignore[arg-type]
    shown.__exit__(None, None, None)
    assert rows.count == 1


@pytest.mark.slow
@pytest.mark.parametrize("saved", [(), ("--save", "live.rrd")])
def test_a_viewer_that_is_not_there_costs_the_drawing_only(saved: tuple[str, ...]) -> None:
    url = "rerun+http://127.0.0.1:1/proxy"
    result = phaseplane("run ap57", *BARE, "--connect", url, *saved)
    assert result.exit_code == 0
    assert (
        result.stderr == f"phaseplane: warning: the run was not shown: no viewer listens at {url}\n"
    )
    assert len(read_csv("out/ap57/results.csv")) == 1001
    assert not saved or "/histories/force/contact_force" in entities(Path("live.rrd"))


@pytest.mark.slow
@pytest.mark.parametrize("saved", [(), ("--save", "live.rrd")])
def test_a_viewer_that_is_killed_costs_the_drawing_only(
    saved: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether the run is recorded, too, or not: one line, and what was asked for is there."""
    with serving() as server:
        watch = LiveRun.watch

        def killed_at_half(self: LiveRun, rows: Rows) -> None:
            watch(self, rows)
            if len(rows) == 501:
                server.process.kill()
                server.process.wait()

        monkeypatch.setattr(LiveRun, "watch", killed_at_half)
        result = phaseplane("run ap57", *BARE, "--connect", server.url, *saved)
    assert result.exit_code == 0
    gone = f"the run was not shown: the viewer at {server.url} no longer answers"
    assert result.stderr == f"phaseplane: warning: {gone}\n"
    assert len(read_csv("out/ap57/results.csv")) == 1001
    if saved:
        assert {"/vehicle/axle/wheel", "/histories/force/contact_force"} <= entities(
            Path("live.rrd")
        )
        assert list(Path().glob("*.part.rrd")) == []


@pytest.mark.slow
def test_a_run_recorded_while_it_goes_on() -> None:
    """Its file tells what that of the finished run tells, such as the drift of the construction."""
    printed("run ap57 --set show.figures=[] --save live.rrd")
    assert list(Path().glob("*.part.rrd")) == []
    assert entities(Path("live.rrd")) == entities(Path("out/ap57/construction.rrd"))
    live, finished = (
        [
            words
            for chunk in RrdReader(path).stream() if chunk.entity_path == "/words"
            for words in chunk.to_record_batch().to_pydict().get("TextDocument:text", ())
        ]
        for path in (Path("live.rrd"), Path("out/ap57/construction.rrd"))
    )  # fmt: skip
    assert live == finished


@pytest.mark.slow
def test_an_interrupted_run_leaves_what_it_has_drawn() -> None:
    arguments = ["run", "ap57", *BARE, "--save", "live.rrd", "--realtime", "--set", "duration=4000"]
    part = Path("live.part.rrd")
    with started([*PROGRAM, *arguments], {}, stderr=subprocess.PIPE) as running:
        wait_until(
            "much is drawn", lambda: part.exists() and part.stat().st_size > 200_000, running
        )
        running.send_signal(signal.SIGINT)
        _, said = running.communicate(timeout=HANGS)
    assert running.returncode == 130
    assert said.strip().startswith("phaseplane: interrupted at ")
    assert "/vehicle/axle/wheel" in entities(part)
    assert not Path("live.rrd").exists()


def test_a_page_for_other_machines_is_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    @contextmanager
    def page(_files: object, address: str) -> Iterator[SimpleNamespace]:
        yield SimpleNamespace(page=f"http://{address}:1/", wait=lambda: None)

    monkeypatch.setattr("phaseplane.recording.serving", page)
    Path("f.rrd").touch()
    for address, warned in (("127.0.0.1", False), ("0.0.0.0", True)):
        result = phaseplane("serve . --address", address)
        assert result.exit_code == 0
        assert ("lets other machines see" in result.stderr) == warned


@pytest.mark.slow
def test_a_run_that_waits_for_the_clock() -> None:
    settings = ["show.figures=[]", "show.recording=false", "duration=0.6"]
    begun = perf_counter()
    summary, _ = run_scene("ap57", settings, realtime=True)
    assert summary["run_time"] >= 0.6
    assert perf_counter() - begun >= 0.6
    assert summary["rows"] == 601


@pytest.mark.parametrize("scene", ["double_pendulum", "van_der_pol", "skyhook"])
def test_a_run_in_this_process_is_watched_in_its_time_too(scene: str) -> None:
    """It takes a few milliseconds, so its rows are shown as if it went on."""
    seen: list[int] = []
    begun = perf_counter()
    made = run(
        load_scene(scene, ["duration=0.3"]),
        watch=lambda rows: seen.append(len(rows)),
        realtime=True,
    )
    assert perf_counter() - begun >= 0.3
    assert seen == list(range(1, len(made.columns["time"]) + 1))


@pytest.mark.slow
def test_any_fmu_with_a_plane_of_its_own() -> None:
    printed("build OneDof -o .")
    printed("run OneDof.fmu --plane", PAIR, "--set", "show.views=['planes']")
    path = Path("out/OneDof/construction.rrd")
    assert entities(path) == {
        f"/sheet/trail/{DEFLECTION}/{part}" for part in ("recent", "past", "here")
    }
    for plane, message in (("a,b", "no output 'a'"), ("a", "give two columns, such as x,y")):
        assert message in complaint("run OneDof.fmu --plane", plane)


@pytest.mark.parametrize("name", case_names())
def test_every_case_has_a_recording_with_its_vehicle(name: str) -> None:
    scene = load_scene(name)
    shown = vehicle(scene.fmu.model, scene.all_parameters, scene.duration)
    pairs = default_pairs({n: v.unit for n, v in scene.fmu.outputs().items()})
    assert pairs
    beside = any(name.startswith("front_left_") for name in scene.fmu.outputs())
    assert (shown is not None) == ("road.shape" in scene.all_parameters and not beside)
    if shown:
        outputs = {name.replace("ground_", "road_") for name in scene.fmu.outputs()}
        assert shown.columns <= outputs


def test_the_drawn_tyre_is_compressed_as_its_table_says() -> None:
    """A table replaces the stiffness: a tyre twice as stiff under load is half as deep."""
    parameters = load_scene("ap57").all_parameters
    stiffness = float(parameters["tyre.stiffness"])
    tables = (f"-1:{-k * stiffness}, 0:0, 1:{k * stiffness}" for k in (1, 2))
    (given,), (single,), (double,) = (
        shown.axles
        for table in ("", *tables)
        if (shown := vehicle("QuarterCar", {**parameters, "tyre.table": table}, 1.0))
    )
    assert single.static_tyre_deflection == pytest.approx(given.static_tyre_deflection, rel=1e-12)
    assert double.static_tyre_deflection == pytest.approx(
        0.5 * given.static_tyre_deflection, rel=1e-12
    )


@pytest.mark.slow
def test_a_folder_on_a_page_until_it_is_interrupted(tmp_path: Path) -> None:
    printed("replay ap57 --save f.rrd")
    with started([*PROGRAM, "serve", tmp_path], {}, stderr=subprocess.PIPE) as serving:
        assert serving.stderr
        page = serving.stderr.readline().strip()
        assert re.match(r"http://127\.0\.0\.1:\d+/\?url=rerun%2Bhttp", page)
        with urlopen(page) as answer:
            assert answer.status == 200
        (server,) = children(serving)
        serving.send_signal(signal.SIGINT)
        _, rest = serving.communicate(timeout=HANGS)
    assert serving.returncode == 0
    assert "Traceback" not in rest
    assert not is_running(server)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("serve . --address 0.0.0.0", "viewing.warn"),
        ("run ap57 --serve", "run.report"),
        ("replay ap57 --serve", "replay.format_missed"),
    ],
)
def test_serving_ends_well_when_it_is_interrupted_before_it_waits(
    line: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The address is known by then, and all that was asked for is done."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    server = SimpleNamespace(page="http://127.0.0.1:1/", url="")
    monkeypatch.setattr("phaseplane.recording.serving", lambda *_: nullcontext(server))
    monkeypatch.setattr(f"phaseplane.scenarios.commands.{said}", interrupt)
    Path("f.rrd").touch()
    assert phaseplane(line, *(BARE if line.startswith("run") else ())).exit_code == 0


@pytest.mark.parametrize(
    ("units", "pairs"),
    [
        ({"h": "m", "v": "m/s", "e": ""}, [("h", "v")]),
        ({"x": "", "der(x)": "", "y": "", "y_dot": ""}, [("x", "der(x)"), ("y", "y_dot")]),
        ({"x1": "m", "x2": "m", "v": "m/s"}, []),
        ({"phi": "rad", "omega": "rad/s"}, [("phi", "omega")]),
    ],
)
def test_planes_of_any_fmu_are_guessed(units: dict[str, str], pairs: list[tuple[str, str]]) -> None:
    assert default_pairs(units) == pairs
