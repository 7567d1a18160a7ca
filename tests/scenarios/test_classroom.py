"""The page and the notebook for the class: what they ask and answer, and the page in a browser."""

from __future__ import annotations

import json
import os
import re
import runpy
import shutil
import subprocess
import sys
import threading
from base64 import b64decode
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import notebooks
import pytest
from browsers import FREE, browser
from hosting import HANGS, in_python
from matplotlib.figure import Figure
from phaseplane.scenarios.draw.classroom import OWN, answered
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene

from phaseplane.exercises import sheet_data

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "classroom"
PYODIDE = "314.0.7"


def asked(what: str, scene: str = OWN, **fields: str) -> Any:
    return json.loads(answered(json.dumps({"what": what, "scene": scene, **fields})))


@pytest.mark.slow
def test_every_scene_of_the_page_can_be_drawn_and_run() -> None:
    told = asked("catalogue")
    assert {OWN, "ap57", "van_der_pol", "h83_example23"} <= told["scenes"].keys()
    assert "leaf_spring" in told["scenes"]  # sticks in two planes
    assert "light_wheel" not in told["scenes"]  # of 1 g: its steps would be microseconds
    for name in (
        OWN,
        "ap57",
        "h83_example25",
        "h83_example28",
        "h83_example40",
        "kerb",
        "stiff_stop",
    ):
        fields = asked("scene", name)
        assert fields["rule"] in told["rules"]
        sheet = asked("sheet", name, **fields)
        assert "error" not in sheet, (name, sheet)
        assert sheet["steps"]
        assert "NaN" not in json.dumps(sheet)  # which is no JSON, and no place on a sheet
        assert not re.search(r"e-[12]\d", json.dumps(sheet["protocol"])), name  # nor is rounding
        run = asked("run", name, **fields)
        assert "error" not in run, (name, run)
        assert all(len(column) == len(run["time"]) for column in run["columns"].values())


@pytest.mark.parametrize("name", ["ap57", "van_der_pol", "h83_example23"])
def test_the_page_draws_what_the_command_draws(name: str) -> None:
    fields = asked("scene", name)
    scene = load_scene(name)
    settings = {
        "rule": scene.construction.rule, "step": scene.construction.step, "plane_distance": 0.25,
        "plane_scales": scene.construction.plane_scales, "starts": scene.construction.starts,
    }  # fmt: skip
    drawing = draw_construction(
        scene.fmu.model, scene.all_parameters, settings, float(fields["duration"])
    )
    assert asked("sheet", name, **fields) == json.loads(json.dumps(sheet_data(drawing)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"equation": "x + kk*v"}, "'kk' is not known"),
        ({"equation": "2v + x"}, "not a formula; did you mean '2*v + x'?"),
        ({"equation": "x(v - 1)"}, "did you mean 'x*(v - 1)'?"),
        ({"equation": "2(x + 1)"}, "did you mean '2*(x + 1)'?"),
        ({"equation": "3 sin(x) + x^"}, "write one such as '(x^2 - 1)*v + x'"),
        ({"settings": "displacement_start = 'a'"}, "is not a number"),
        ({"settings": "nonsense"}, "write key=value"),
        ({"settings": "mu = 3"}, "Equation has no parameter 'mu'"),
        ({"step": "0"}, "step = '0': must be a time above 0"),
        ({"step": "0.001", "duration": "12"}, "12000 steps; this page draws at most 400"),
        ({"rule": "best"}, "rule 'best' is unknown"),
        ({"step": "3"}, "at most a right angle is allowed"),
        ({"equation": "-v^2 - exp(x)*9"}, ""),
    ],
)
def test_what_the_page_cannot_draw_it_says_in_a_line(change: dict[str, str], message: str) -> None:
    told = asked("sheet", **{**asked("scene"), **change})
    assert message in told["error"]
    assert "\n" not in told["error"]


@pytest.mark.slow
def test_the_page_needs_the_standard_library_alone() -> None:
    """A browser has no numpy, click and the like for it."""
    program = """
import sys
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] not in sys.stdlib_module_names | {"phaseplane", "lazy_loader"}:
            if not name.startswith(("_", "suspension_kernel")):
                raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Refused())
import json
from phaseplane.scenarios.draw.classroom import answered
for name in ("own", "ap57", "h83_example28"):
    fields = json.loads(answered(json.dumps({"what": "scene", "scene": name})))
    for what in ("sheet", "run"):
        told = json.loads(answered(json.dumps({"what": what, "scene": name, **fields})))
        assert "error" not in told, told
"""
    in_python(program)


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom() -> None:
    scope, shown = notebooks.run(PAGE / "dry_friction.ipynb")
    assert isinstance(next(filter(None, reversed(shown))), Figure)
    assert "turned in the wrong direction" in scope["marks"].marks[-1].said


# In a browser.


class _Quiet(SimpleHTTPRequestHandler):
    extensions_map = {  # noqa: RUF012
        **SimpleHTTPRequestHandler.extensions_map, ".mjs": "text/javascript", ".wasm": "application/wasm",
    }  # fmt: skip

    def log_message(self, *_args: object) -> None:
        """Say nothing."""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page, made as its builder says."""
    if shutil.which("npm") is None:
        pytest.skip("no npm, from which Pyodide comes")
    folder = tmp_path_factory.mktemp("classroom")
    got = subprocess.run(
        ["npm", "pack", f"pyodide@{PYODIDE}"], cwd=folder, capture_output=True, check=False
    )
    if got.returncode:
        pytest.skip(f"Pyodide cannot be fetched: {got.stderr.decode()[-200:]}")
    shutil.unpack_archive(folder / f"pyodide-{PYODIDE}.tgz", folder)
    source = folder / "source"
    shutil.copytree(
        ROOT, source, ignore=shutil.ignore_patterns(".*", "build", "artefacts", "*.egg-info")
    )
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w",
         str(folder / "dist"), str(source)],
        check=True, env={**os.environ, "PHASEPLANE_PURE": "1"},
    )  # fmt: skip
    make = runpy.run_path(str(PAGE / "make.py"))["make"]
    (wheel,) = (folder / "dist").glob("*.whl")
    make(folder / "site", folder / "package", wheel)
    return folder / "site"


@pytest.fixture(scope="module")
def page(site: Path) -> Iterator[Any]:
    """A browser that has the page open, served from this machine."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        with browser("headless=new") as opened:
            opened.get(f"http://127.0.0.1:{server.server_port}/index.html")
            yield opened
    finally:
        server.shutdown()
        server.server_close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_the_page_in_a_browser(page: Any) -> None:
    from selenium.webdriver.common.by import By  # noqa: PLC0415
    from selenium.webdriver.common.keys import Keys  # noqa: PLC0415
    from selenium.webdriver.support.ui import Select, WebDriverWait  # noqa: PLC0415

    wait = WebDriverWait(page, HANGS)

    def told(name: str) -> str | None:
        found: str | None = page.execute_script(f"return document.documentElement.dataset.{name}")
        return found

    def find(selector: str) -> Any:
        return page.find_element(By.CSS_SELECTOR, selector)

    assert told("first") is not None  # a sheet is there before Python is
    assert "stage 1 of" in find(".now").text
    wait.until(lambda _: told("ready"))
    bottom = (
        "return document.querySelector('#player svg').getBoundingClientRect().bottom - innerHeight"
    )
    assert page.execute_script(bottom) <= 0  # the form and the whole sheet in one window
    written = [text.text for text in page.find_elements(By.CSS_SELECTOR, ".paper text")]
    assert "\N{MINUS SIGN}2" in written
    assert not any("-" in text for text in written)
    Select(find("select[name=scene]")).select_by_value("ap57")
    wait.until(lambda _: (told("shown") or "").startswith("Quarter car"))
    body = find("body")
    for key in (
        Keys.ARROW_DOWN,
        Keys.ARROW_DOWN,
        Keys.ARROW_RIGHT,
        Keys.ARROW_RIGHT,
        Keys.ARROW_LEFT,
    ):
        body.send_keys(key)
    assert "Step 2" in find(".now").text
    assert "stage 2 of" in find(".now").text
    assert find("tr.here")

    def free() -> bool:
        """Whether no text on the sheet covers another."""
        return bool(page.execute_script(FREE))

    body.send_keys(Keys.END)
    assert free()

    def pages() -> int:
        printed = page.execute_cdp_cmd("Page.printToPDF", {})["data"]
        return b64decode(printed).count(b"/Type /Page\n")

    body.send_keys(Keys.END)
    assert pages() <= 4  # the sheet and its points
    page.execute_script("document.querySelector('table').classList.add('whole')")
    assert pages() > 10  # the protocol, on demand
    find("#solve").click()
    wait.until(lambda _: page.find_elements(By.CSS_SELECTOR, "#run polyline"))
    equation = find("input[name=equation]")
    Select(find("select[name=scene]")).select_by_value(OWN)
    wait.until(lambda _: "sign(ẋ)" in (told("shown") or ""))
    equation.clear()
    equation.send_keys("x + kk*v")
    find("button[type=submit]").click()
    wait.until(lambda _: "'kk' is not known" in find("#state").text)
    # on a phone
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True},
    )
    wide = page.execute_script("return document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0
    page.refresh()
    wait.until(lambda _: told("first"))
    smallest = page.execute_script(
        "return Math.min(...[...document.querySelectorAll('.paper text')].map(text => "
        "text.getAttribute('font-size') * text.ownerSVGElement.getScreenCTM().a))"
    )
    assert smallest > 8.0  # pixels
    for name in ("van_der_pol", "ap57", "h83_example25"):
        title = told("shown")
        wait.until(lambda _: told("ready"))
        Select(find("select[name=scene]")).select_by_value(name)
        wait.until(
            lambda _, title=title, name=name: name == "van_der_pol" or told("shown") != title
        )
        find("body").send_keys(Keys.END)
        assert free(), name
    errors = [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"]
    assert errors == []
