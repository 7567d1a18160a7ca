"""What is told of every case that comes along: which steps, and in which words."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product, zip_longest
from textwrap import wrap

import pytest
import rerun as rr
from drawn_cases import DRAWN, drawing_of
from phaseplane.scenarios.draw.constructions import draw_scene
from phaseplane.scenarios.draw.recording_content import of_scene, readings
from phaseplane.scenarios.scene.loading import load_scene

from phaseplane.constructions import RULES
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.readings import Readings
from phaseplane.picture.story import arms_page, story_of, told_steps
from phaseplane.picture.text import step_head
from phaseplane.recording import Content
from phaseplane.recording.layout import blueprint
from phaseplane.recording.motion import pages_of
from phaseplane.recording.recorder import Recorder


def text_height(text: str) -> float:
    """The height of Markdown in the viewer's text pane of a window of 1366 pixels, in pixels.

    As seen in the viewer: a row of text is 15 pixels high and a row of a table 23; a list begins with
    a blank row.
    """
    height, listed = 0.0, False
    for line in text.split("\n"):
        plain = re.sub(r"\*\*|\\", "", line)
        if line.startswith("|"):
            height += 0 if line.startswith("|---") else 23
        elif line.startswith("# "):
            height += 25 * len(wrap(plain, 44))
        elif line.startswith("- "):
            height += 15 * len(wrap(plain[2:], 75)) + (0 if listed else 15)
            listed = True
        else:
            height += 15 * max(1, len(wrap(plain, 82)))
    return height + (8 if "|" in text else 0)


def table_width(text: str) -> float:
    """The width of a table in the viewer with its frame and the pane's, in pixels.

    As seen there: a letter takes up 5.8 pixels, a character of a number 6.9, and a column 8 more.
    """
    rows = [line.strip("| ").split(" | ") for line in text.split("\n") if line.startswith("| ")]
    columns = list(zip_longest(*rows, fillvalue=""))
    names = max((5.8 * len(name) for name in columns[0]), default=0.0) if columns else 0.0
    return 38.0 + names + sum(8.0 + 6.9 * max(map(len, cells)) for cells in columns[1:])


@pytest.mark.parametrize("name", ["ap57", "half_car_pitch"])
def test_a_table_of_readings_is_at_most_as_wide_as_its_pane(name: str) -> None:
    """The drift, in the last column, was cut off where four planes leave less room for the text."""
    drawing = drawing_of(name)
    shown = Content(name, drawing, readings(drawing))
    recorder = Recorder(rr.RecordingStream("layout"), shown)
    width = blueprint(recorder).root_container.column_shares[1]
    drifts = {f"{plane.name}_drift": 1.386e-6 for plane in drawing.planes}
    frames = [replace(f, readings={**f.readings, **drifts}) for f in drawing.frames[::20]]
    drifting = Readings(replace(drawing, frames=StoredFrames(frames)))
    for frame in frames:
        text = drifting.table(frame.readings)
        assert "drift, cm" in text
        assert table_width(text) <= width, text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rule"),
    [*((name, None) for name in DRAWN), *product(["ap57", "half_car_pitch", "leaf_spring"], RULES)],
)
def test_the_text_fits_its_pane(name: str, rule: str | None) -> None:
    """The present line of a protocol and what was measured in it are seen without scrolling."""
    drawing = drawing_of(name, rule=rule)
    shown = Content(name, drawing, readings(drawing))
    recorder = Recorder(rr.RecordingStream("layout"), shown)
    column = blueprint(recorder).root_container.contents[1]
    shares = getattr(column, "row_shares", None) or [1.0]
    room = (768.0 - 65.0) * shares[0] / sum(shares) - 53.0
    steps = recorder.readings.step_texts(drawing.frames[:200])
    for text in [tick.text for tick in recorder.ticks] + steps:
        assert text_height(text) <= room, text
    for tick in recorder.ticks:
        bold = re.search(r"^- \*\*.*", tick.text, re.MULTILINE)
        if bold and "successor" in bold[0]:
            assert " = " in bold[0].rpartition("**")[2]


def test_no_step_is_told_whose_points_lie_on_one_another() -> None:
    """Also in a short motion, which begins at rest."""
    drawing = drawing_of("h83_example40")
    (plane,) = drawing.planes
    size = [abs(f.points[plane.state] - plane.displacement.origin) for f in drawing.frames]
    assert min(size[step] for step in told_steps(drawing)) > 0.2 * max(size)


@pytest.mark.parametrize("scene", ["crest_jump", "end_stop_impact", "leaf_spring"])
def test_no_step_is_told_that_is_too_short_to_be_seen(scene: str) -> None:
    """Lift-off may be just before the end of a step, which leaves a step of a hundredth of a ms."""
    drawing = drawing_of(scene)
    durations = [frame.duration for frame in drawing.frames]
    assert min(durations[step] for step in told_steps(drawing)) > 0.1 * max(durations)


def test_the_starts_on_the_sheet_are_explained_in_words() -> None:
    """The axis up shows the velocity divided by the angular frequency, so that the point is not at 6."""
    drawing = drawing_of("h83_example23", 6.0)
    stays, *_ = pages_of(Content("example 23", drawing))
    assert "(−3, 6)" in [text.text for text in stays.texts]
    first = next(story_of(stays, arms_page(drawing))).text
    assert "the velocity, not divided by Ω, at which it begins, in rad and rad/s." in first


def test_steps_are_told_with_and_without_what_an_event_begins() -> None:
    """The leaf spring sticks in its first step, but slips most of the time."""
    drawing = drawing_of("leaf_spring")
    schemes = {drawing.frames[step].scheme for step in told_steps(drawing)}
    assert schemes == {"contact", "contact_sticking"}
    sticks = next(frame for frame in drawing.frames if frame.scheme == "contact_sticking")
    assert ", contact, sticking**: t = " in step_head(drawing, sticks)


def test_a_frame_that_yields_is_told_where_it_yields() -> None:
    drawing = drawing_of("h83_example40")
    assert "yielding_up" in {drawing.frames[step].scheme for step in told_steps(drawing)}


def test_steps_are_told_of_the_whole_motion() -> None:
    """Also if the road is so high at first that all that follows is small beside it."""
    drawing = drawing_of("crest_jump", 3.0)
    thirds = {3 * step // len(drawing.frames) for step in told_steps(drawing)}
    assert thirds == {0, 1, 2}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "told"), [("stiff_stop", True), ("ap57", False)])
def test_it_is_said_if_a_body_from_its_forces_differs(name: str, told: bool) -> None:
    drawing = drawing_of(name, 10.0)
    read = Readings(drawing)
    *_, last = story_of(pages_of(Content(name, drawing))[0], arms_page(drawing))
    (beside,) = read.step_texts(drawing.frames[5:6])
    for text in (last.text, beside, read.end_text()):
        assert ("The body from its forces differs by up to " in text) is told


@pytest.mark.parametrize("name", ["groundhook", "skyhook", "woken_by_lift_off"])
def test_the_title_of_a_sheet_says_in_its_pane_what_is_left_out(name: str) -> None:
    """The tab has room for 120 characters in a window of 1366 pixels."""
    scene = load_scene(name, ["duration=0.05"], expect=False)
    shown = of_scene(scene, draw_scene(scene))
    assert shown.manner.endswith("without the controller")
    assert len(f"{shown.title}: {shown.manner}") <= 120


@pytest.mark.parametrize(("name", "planes"), [("ap57", "planes"), ("van_der_pol", "plane")])
def test_an_introduction_counts_the_planes(name: str, planes: str) -> None:
    drawing = drawing_of(name)
    first = next(story_of(pages_of(Content(name, drawing))[0], arms_page(drawing)))
    assert f"the axes of the phase {planes} and" in first.text


def test_a_half_car_that_stands_for_a_pendulum_is_told_as_a_half_car() -> None:
    """Its axes and stages name suspensions and roads, so the title and the side view must, too."""
    scene = load_scene("h83_example28", [], expect=False)
    shown = of_scene(scene, drawing_of("h83_example28"))
    assert shown.vehicle is not None
    ticks = Recorder(rr.RecordingStream("half car"), shown).ticks
    assert ticks[0].text.startswith("# Half car on waves with the equations of a double pendulum")
