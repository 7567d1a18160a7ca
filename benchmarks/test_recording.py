"""Speed and size of recordings, and the cost of a viewer for a run, as interleaved ratios.

pytest -s -m slow benchmarks/test_recording.py
"""

from __future__ import annotations

import os
import resource
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median
from subprocess import DEVNULL, Popen
from time import perf_counter, process_time, sleep

import pytest
import rerun as rr
from phaseplane.scenarios.draw.live import show_live
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate.runner import run
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient
from worked_example import ap57

from phaseplane.constructions import construct_motion, delta
from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.layers import layers_of
from phaseplane.picture.readings import Readings
from phaseplane.recording import DETAILS, Content, new_recording, record, serving
from phaseplane.recording.canvas import xy
from phaseplane.recording.server import free_port, viewer_program

pytestmark = pytest.mark.slow


def construction(steps: int) -> Drawing:
    return construct_motion(ap57(), delta, step=0.0025, steps=steps)


def encoded(content: Content) -> Path:
    """Write a recording, where the next one replaces it."""
    path = Path(tempfile.gettempdir()) / "recorded.rrd"
    record(content, path)
    return path


def peak_memory() -> float:
    """The most memory that this process has ever had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def log_one_by_one(drawing: Drawing) -> int:
    """Log the same construction with a `log` call per entity and step, with static styles."""
    recording = new_recording(Content("one by one", drawing))
    memory, readings = recording.memory_recording(), Readings(drawing)
    for frame in drawing.frames:
        recording.set_time("t", duration=frame.time)
        recording.set_time("step", sequence=frame.step)
        _log_frame(recording, readings, frame)
    size = len(memory.drain_as_bytes())
    recording.disconnect()
    return size


def _log_frame(recording: rr.RecordingStream, readings: Readings, frame: Frame) -> None:
    drawing = readings.drawing
    for plane in drawing.planes:
        segment = [frame.points[plane.state], frame.points[plane.state + "'"]]
        recording.log(f"/sheet/trail/{plane.name}", rr.LineStrips2D([xy(segment)]))
    alone = StoredFrames([frame])
    recording.log("/words", rr.TextDocument(*readings.step_texts(alone)))
    for layer in layers_of(drawing.schemes[frame.scheme], alone):
        path = f"/sheet/steps/{frame.scheme}/{layer.stage + 1}/{layer.kind}"
        if layer.kind == "points":
            recording.log(path, rr.Points2D(xy(layer.vertices[0, :, 0])))
        else:
            recording.log(path, rr.LineStrips2D(xy(layer.vertices[0])))


def timed(work: Callable[[], object]) -> float:
    """Return the processor time of all threads, which other processes affect little, s."""
    begun = process_time()
    work()
    return process_time() - begun


def test_whole_columns_against_one_log_call_for_each_entity() -> None:
    few, many = construction(200), construction(10_000)
    encoded(Content("warm", few))
    ratios = []
    print("\nframes/s one by one and in whole columns")
    for _ in range(5):
        one_by_one = len(few.frames) / timed(lambda: log_one_by_one(few))
        whole = len(many.frames) / timed(lambda: encoded(Content("whole", many)))
        ratios.append(whole / one_by_one)
        print(f"{one_by_one:9.0f} {whole:9.0f}: {ratios[-1]:.0f} times")
    assert median(ratios) >= 20


def test_recording_takes_no_more_memory_for_more_steps() -> None:
    many = construction(40_000)
    encoded(Content("few", construction(10_000)))
    before = peak_memory()
    rate = len(many.frames) / timed(lambda: encoded(Content("many", many)))
    more = peak_memory() - before
    print(f"\n{rate:.0f} frames/s; 30 000 steps more took {more:.0f} MB more")
    assert more < 40.0


def test_what_each_level_of_detail_costs() -> None:
    drawing = construction(400)
    print("\ndetail    entities     bytes        ms")
    costs = []
    for detail in DETAILS:
        content = Content("a level", drawing, detail=detail)
        took = min(timed(lambda content=content: encoded(content)) for _ in range(5))
        made = encoded(content)
        costs.append((entities(made), made.stat().st_size, took))
        print(f"{detail:8} {costs[-1][0]:9} {costs[-1][1]:9} {1e3 * took:9.1f}")
    assert costs == sorted(costs)


def entities(made: Path) -> int:
    return len({chunk.entity_path for chunk in RrdReader(made).stream()})


def test_a_frame_costs_at_most_two_kilobytes() -> None:
    one, three = (encoded(Content("sizes", construction(n))).stat().st_size for n in (1000, 3000))
    each = (three - one) / 2000
    print(f"\n{each:.0f} bytes per frame, {one - 1000 * each:.0f} bytes once")
    assert each <= 2000


@pytest.mark.parametrize(("steps", "most"), [(10_000, 8.0), (100_000, 25.0)])
def test_a_frame_of_a_long_recording_costs_the_viewer_little(
    steps: int, most: float, tmp_path: Path
) -> None:
    """The processor time of a frame, ms, without that of the rasteriser in software."""
    path = tmp_path / "long.rrd"
    step = 0.0025 if steps < 20_000 else 0.0005
    record(Content("long", construct_motion(ap57(), delta, step=step, steps=steps)), path)
    port, frames = free_port("127.0.0.1", 0), 60
    command = [viewer_program(), "--headless", "--bind", "127.0.0.1", "--port", str(port)]
    with Popen(
        [*command, "--window-size", "1366x768"], stdout=DEVNULL, stderr=DEVNULL,
        env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path), "RERUN_APP_ONLY": "true"},
    ) as process:  # fmt: skip
        try:
            viewer = connected(f"rerun+http://127.0.0.1:{port}/proxy")
            begun = perf_counter()
            viewer.open(str(path))
            viewer.set_time("step", sequence=steps // 2, play_state="paused")
            viewer.save_screenshot(str(tmp_path / "picture.png"))
            print(f"\n{steps} steps: open and drawn after {perf_counter() - begun:.2f} s")
            sleep(3.0)  # until what is around the cursor is loaded
            before = busy(process.pid)
            viewer.capture_profile_trace(str(tmp_path / "trace.puffin"), num_frames=frames)
            cost = (busy(process.pid) - before) / frames
        finally:
            process.kill()
    print(f"{cost:.1f} ms a frame")
    assert cost <= most


def connected(url: str) -> ViewerClient:
    """Return the viewer at an address as soon as it answers."""
    while True:
        try:
            viewer = ViewerClient(url)
            viewer.get_state()
        except (RuntimeError, ConnectionError):
            sleep(0.2)
        else:
            return viewer


def busy(process: int) -> float:
    """Return the processor time of the threads of a viewer, except those that rasterise, ms."""
    threads = Path(f"/proc/{process}/task").iterdir()
    return sum(
        1e-6 * int((thread / "schedstat").read_text().split()[0])
        for thread in threads
        if not (thread / "comm").read_text().startswith("llvmpipe")
    )


@pytest.mark.parametrize("realtime", [True, False])
def test_what_a_viewer_costs_a_run(realtime: bool) -> None:
    """A run of about five seconds, in real time or as fast as possible."""
    settings = ["show.figures=[]", "show.recording=stages", "show.outputs=all"]
    settings += ["duration=5"] if realtime else ["duration=10", "show.output_interval=0.05 ms"]
    scene = load_scene("ap57", settings)
    alone, watched = [], []
    with serving() as server:
        for _ in range(3):
            alone.append(run(scene, realtime=realtime).summary["run_time"])
            with show_live(scene, None, server.url) as live:
                assert live is not None
                sleep(1.0)
                results = run(scene, watch=live.watch, realtime=realtime)
                assert live.complete(results, None) == ([], [])
                assert live.live.rows_drawn > 100
            watched.append(results.summary["run_time"])
    print(f"\nalone {min(alone):.2f} s, watched {min(watched):.2f} s")
    assert min(watched) <= 1.10 * min(alone)
