"""What people see: every recording drawn by the viewer itself and by a browser.

The pictures are kept in `artefacts/`.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.compute as pc
import pytest
from browsers import browser
from hosting import wait_until
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.commands.viewing import recordings_in
from phaseplane.scenarios.scene.names import case_names
from phaseplane.suspension.variables import MODELS
from PIL import Image
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from phaseplane.picture.styles import Hue, hue_of, style_of
from phaseplane.recording import serving
from phaseplane.recording.server import free_port, viewer_program

ARTEFACTS = Path(__file__).parents[2] / "artefacts"
SIZE = (1600, 1000)
NORMAL, AUXILIARY = style_of("normal").hue, style_of("auxiliary").hue

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::ResourceWarning"),  # of the viewer's own client
]


def drivers() -> list[Path]:
    return [
        *Path("/usr/share/vulkan/icd.d").glob("*.json"),
        *Path("/etc/vulkan/icd.d").glob("*.json"),
    ]


@dataclass(frozen=True)
class Viewer:
    """A viewer and its process."""

    client: ViewerClient
    process: subprocess.Popen[bytes]

    def until(self, what: str, holds: Callable[[], object]) -> None:
        """Wait until a condition, named in words, holds; errors count as not yet."""
        wait_until(what, lambda: tried(holds), self.process)

    def open(self, recording: Path) -> None:
        """Open a recording alone, and wait until all of it is there."""
        self.client.close("all")
        (opened,) = self.client.open(str(recording)).store_ids
        self.until(f"{recording} is shown", lambda: self._state.active_recording == opened)
        wanted = ends_in(recording)

        def is_loaded() -> bool:
            (there,) = (r.timelines for r in self._state.recordings if r.store_id == opened)
            return wanted.items() <= {t.name: t.end for t in there}.items()

        self.until(f"{recording} is loaded up to {wanted}", is_loaded)

    @property
    def _state(self) -> Any:
        return self.client.get_state()

    def draw(self, picture: Path, *hues: Hue) -> None:
        """Keep a picture in which there are these colours."""
        for hue in hues:
            self.until(f"{picture.stem} has {hue}", partial(self._shows, picture, hue))

    def _shows(self, picture: Path, hue: Hue) -> bool:
        self.client.save_screenshot(str(picture))
        return pixels(picture, hue) > 20


def tried(action: Callable[[], Any]) -> Any:
    """What an action returns, or None after an error of the viewer."""
    with suppress(RuntimeError, ConnectionError):
        return action()
    return None


def ends_in(recording: Path) -> dict[str, int]:
    """The last instant of every timeline in a file, as the viewer tells it."""
    ends: dict[str, int] = {}
    for chunk in RrdReader(recording).stream():
        batch = chunk.to_record_batch()
        for field, column in zip(batch.schema, batch.columns, strict=True):
            if (field.metadata or {}).get(b"rerun:kind") == b"index":
                last = pc.max(column.cast("int64")).as_py()
                ends[field.name] = max(ends.get(field.name, last), last)
    return ends


@pytest.fixture(scope="module")
def viewer(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    """A viewer without a screen."""
    if not drivers():
        pytest.skip("no Vulkan driver: install mesa-vulkan-drivers and libvulkan1")
    port = free_port("127.0.0.1", 0)
    process = subprocess.Popen(
        [viewer_program(), "--headless", "--bind", "127.0.0.1", "--port", str(port),
         "--window-size", "{}x{}".format(*SIZE)],
        env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path_factory.mktemp("runtime")),
             "RERUN_APP_ONLY": "true"},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    url = f"rerun+http://127.0.0.1:{port}/proxy"
    try:
        wait_until(
            "the viewer answers", lambda: tried(lambda: ViewerClient(url).get_state()), process
        )
        yield Viewer(ViewerClient(url), process)
    finally:
        process.kill()
        process.wait()


def pixels(picture: Path, hue: Hue) -> int:
    """How many pixels of a picture have the colour of a role, nearly."""
    image = np.asarray(Image.open(picture).convert("RGB")).astype(int)
    colour = np.array([int(hue.on("either")[i : i + 2], 16) for i in (1, 3, 5)])
    return int(np.sum(np.max(abs(image - colour), axis=2) < 12))


def scene_of(model: str, folder: Path) -> str:
    path = folder / f"{model}.toml"
    extra = (
        'force.table = "0:0, 0.2:5, 0.4:8, 0.6:7, 1.0:3, 1.6:0"' if model == "Elastoplastic" else ""
    )
    path.write_text(f'fmu = "{model}"\nduration = "2 s"\n[parameters]\n{extra}\n')
    return str(path)


@pytest.mark.parametrize("name", [*case_names(), *MODELS])
def test_the_viewer_draws_it(name: str, viewer: Viewer, tmp_path: Path) -> None:
    reference = scene_of(name, tmp_path) if name in MODELS else name
    settings = ["show.recording=stages", "show.figures=[]"]
    summary, folder = run_scene(reference, settings, tmp_path / "out")
    assert "construction.rrd" in summary["files"], summary["problems"]
    viewer.open(folder / "construction.rrd")
    ends = ends_in(folder / "construction.rrd")
    ARTEFACTS.mkdir(exist_ok=True)
    instants: list[tuple[str, dict[str, Any]]] = [("t", {"duration": 1e-9 * ends["t"] / 4})]
    staged = ends.get("stage", 0)
    stages = {*((5, 24, 57) if name == "ap57" else ()), staged // 2}
    instants += [("stage", {"sequence": k}) for k in sorted(stages) if 0 < k < staged]
    for timeline, at in instants:
        viewer.client.set_time(timeline, play_state="paused", **at)
        time.sleep(0.5)
        wanted = [style_of("axis").hue, style_of("trail").hue]
        if "speed" in summary["parameters"]:  # the suspensions of four wheels are plotted in a tab
            wanted += [hue_of(part) for part in ("road", "suspension")[: 1 + (name != "full_car")]]
        viewer.draw(ARTEFACTS / f"{name}-{timeline}{next(iter(at.values())):g}.png", *wanted)
    views = viewer.client.get_state().views
    assert len(views) >= 3
    assert [(v.name, r.summary, r.details) for v in views for r in v.reports] == []


def test_ten_thousand_steps_open_and_scrub(viewer: Viewer, tmp_path: Path) -> None:
    settings = ["construction.step=0.1 ms", "construction.duration=1 s", "show.figures=[]"]
    _, folder = run_scene("ap57", settings, tmp_path / "out")
    viewer.open(folder / "construction.rrd")
    ARTEFACTS.mkdir(exist_ok=True)
    for step in (9999, 300, 5000):
        viewer.client.set_time("step", sequence=step, play_state="paused")
        viewer.draw(ARTEFACTS / f"long-step{step}.png", NORMAL)


def test_all_recordings_of_a_folder_are_on_one_page(viewer: Viewer, tmp_path: Path) -> None:
    for name in ("ap57", "ap57_figure13"):
        run_scene(name, ["show.figures=[]", "show.recording=trail"], tmp_path / name)
    viewer.client.close("all")
    with serving(recordings_in(tmp_path)) as server:
        viewer.client.open(server.url)

        def recordings() -> Any:
            return viewer.client.get_state().recordings

        viewer.until("two are there", lambda: sum(bool(r.timelines) for r in recordings()) == 2)
        names = sorted(str(r.store_id).split(":")[1] for r in recordings())
    # each with the beginning of its id, as recordings of one name would share a layout
    assert [name.rpartition(" ")[0] for name in names] == [
        "Quarter car over a 5 cm bump with wheel lift-off",
        "The construction of AP57 s figure 13 the wheel stays on the road",
    ]


def test_a_browser_shows_the_planes_on_the_page(tmp_path: Path) -> None:
    _, folder = run_scene("ap57", ["show.figures=[]"], tmp_path / "out")
    quiet = (
        "headless", "disable-quic", "no-first-run", "disable-sync", "disable-background-networking",
        "disable-component-update", "enable-unsafe-swiftshader",
    )  # fmt: skip
    with (
        tempfile.TemporaryDirectory() as profile,
        serving([folder / "construction.rrd"]) as server,
        browser(*quiet, f"user-data-dir={profile}", size=SIZE) as opened,
    ):
        opened.get(server.page)
        ARTEFACTS.mkdir(exist_ok=True)
        picture = ARTEFACTS / "page.png"

        def drawn() -> bool:
            opened.save_screenshot(str(picture))
            return min(pixels(picture, hue) for hue in (AUXILIARY, hue_of("wheel"))) > 20

        wait_until("the page shows both planes", drawn, server.process)
