"""The pages of an exercise in a browser: a sheet to click on, and a protocol to go through."""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browsers import FREE, browser
from hosting import wait_until
from phaseplane.scenarios.draw.exercises import Exercise, exercise, marked, write_sheets
from phaseplane.scenarios.scene.loading import load_scene

pytestmark = pytest.mark.slow

STEPS = 6
WINDOWS = {"desk": (1300, 900), "phone": (390, 844)}
PLACE = """
const [x, y] = arguments, svg = document.querySelector("svg");
const at = new DOMPoint(x, -y).matrixTransform(svg.getScreenCTM());
return [at.x, at.y, document.elementFromPoint(at.x, at.y).closest("svg") === svg];
"""
SETTINGS = {"ap57": [], "van_der_pol": ["construction.step=0.2 s"], "half_car_pitch": []}


@pytest.fixture(scope="module")
def page() -> Iterator[Any]:
    with browser("headless=new") as opened:
        yield opened


def open_in(page: Any, window: str, made: Exercise, file: Path) -> None:
    """Open one of the pages of an exercise, which are written beside each other; it is not too wide."""
    write_sheets(made, file.parent)
    width, height = WINDOWS[window]
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": window == "phone"},
    )
    page.get(file.as_uri())
    wide = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
    assert page.execute_script(wide) <= 0


def texts(page: Any, selector: str) -> list[str]:
    """The texts of all elements, also of those that are scrolled out of view."""
    script = "return [...document.querySelectorAll(arguments[0])].map(one => one.textContent)"
    found: list[str] = page.execute_script(script, selector)
    return found


@pytest.fixture(scope="module", params=SETTINGS)
def made(request: pytest.FixtureRequest) -> Exercise:
    scene = load_scene(request.param, SETTINGS[request.param], expect=False)
    return exercise(scene, STEPS, "A3" if request.param == "half_car_pitch" else "A4")


@pytest.mark.parametrize("window", WINDOWS)
def test_points_that_are_clicked_are_saved_as_readings_and_marked(
    page: Any, made: Exercise, window: str, tmp_path: Path
) -> None:
    from selenium.webdriver.common.actions.action_builder import ActionBuilder  # noqa: PLC0415
    from selenium.webdriver.common.by import By  # noqa: PLC0415
    from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

    open_in(page, window, made, tmp_path / "sheet.html")
    assert page.execute_script(FREE)

    def click(z: complex) -> None:
        x, y, clear = page.execute_script(PLACE, 100.0 * z.real, 100.0 * z.imag)
        assert clear  # nothing lies on the sheet
        mouse = ActionBuilder(page, duration=0)
        mouse.pointer_action.move_to_location(round(x), round(y))
        mouse.pointer_action.click()
        mouse.perform()

    planes, instants = made.drawing.planes, list(made.drawing.instants)
    click(planes[0].displacement.origin)  # by mistake
    page.find_element(By.CSS_SELECTOR, "body").send_keys(Keys.BACKSPACE)
    for frame in instants[1:]:
        for plane in planes:
            click(frame.points[plane.state])
    assert texts(page, ".words") == ["All points are complete: save the readings."]
    click(planes[0].displacement.origin)  # there is no further point
    assert texts(page, "tbody td:first-child") == [str(i) for i in range(len(instants))]
    page.execute_cdp_cmd(
        "Browser.setDownloadBehavior",
        {"behavior": "allow", "downloadPath": str(tmp_path / "saved")},
    )
    page.find_element(By.XPATH, "//button[text()='Save readings']").click()
    saved = tmp_path / "saved" / "readings.csv"
    # it is first an empty file
    wait_until("readings are saved", lambda: saved.exists() and saved.stat().st_size)
    marks = marked(made, saved.read_text(), 1.5e-3)
    assert marks["right"] == made.steps, [one["said"] for one in marks["marks"]]
    assert not marks["missing"]


@pytest.mark.parametrize("window", WINDOWS)
def test_a_protocol_goes_through_all_stages_without_a_letter_on_another(
    page: Any, made: Exercise, window: str, tmp_path: Path
) -> None:
    from selenium.webdriver.common.by import By  # noqa: PLC0415
    from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

    open_in(page, window, made, tmp_path / "protocol.html")
    schemes = made.drawing.schemes
    stages = [
        (frame.step, k, len(schemes[frame.scheme].stages))
        for frame in made.drawing.frames
        for k in range(len(schemes[frame.scheme].stages))
    ]
    body = page.find_element(By.CSS_SELECTOR, "body")
    for step, stage, count in stages:
        (now,) = texts(page, ".now")
        assert now.startswith(f"Step {step}, t = ")
        assert f"stage {stage + 1} of {count}" in now
        assert page.execute_script(FREE), now
        body.send_keys(Keys.ARROW_RIGHT)
    seen = """
    const box = document.querySelector(".table").getBoundingClientRect();
    return [...document.querySelectorAll("tr.here")].map(row => row.getBoundingClientRect())
        .every(row => row.bottom > box.top && row.top < box.bottom);
    """
    assert page.execute_script(seen)
    body.send_keys(Keys.HOME)
    assert f"stage 1 of {stages[0][2]}" in texts(page, ".now")[0]
    # shows where its point is found
    page.find_elements(By.CSS_SELECTOR, "tbody tr")[-1].click()
    assert texts(page, ".now")[0].startswith(f"Step {stages[-1][0]},")
    assert not [e for e in page.get_log("browser") if e["level"] == "SEVERE"]

    printed = b64decode(page.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert printed.count(b"/Type /Page\n") <= 3  # the sheet and its points
