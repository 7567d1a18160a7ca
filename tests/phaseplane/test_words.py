"""Words and numbers of a picture: what a stage lays off and reads, typeset and in its unit."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
import rerun as rr
from recorded import CONTACT_SCHEME, PLANES, drawing, frame, read_back, sheet_and_story
from worked_example import ap57

from phaseplane.constructions import Curve, EquationPlane, Mark, construct_motion, delta
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.sheet import Event
from phaseplane.constructions.storage import StoredFrames
from phaseplane.equations import Formula
from phaseplane.equations.typeset import number
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Box
from phaseplane.picture.protocol import measured, protocol
from phaseplane.picture.quantities import unit_text
from phaseplane.picture.readings import Readings
from phaseplane.picture.subject import Subject
from phaseplane.picture.text import (
    LETTER_OF_EVENT,
    event_text,
    level_text,
    marks_text,
    step_head,
)
from phaseplane.recording import Content
from phaseplane.recording.canvas import legible
from phaseplane.recording.recorder import Recorder


def read_once(readings: dict[str, float]) -> Readings:
    """The readings of a motion of one step."""
    only = replace(frame(0), readings=readings, mode="contact")
    return Readings(replace(drawing(1), frames=(only,)))


def page_of(made: Drawing) -> Page:
    """An empty page of a construction, on which its lengths are measured."""
    return Page(Subject(made), Box(0j, 1 + 1j), 0.01)


def test_what_is_laid_off_says_which_way_and_mean_excitations_are_told() -> None:
    """On the road by its mean height; in flight by the weight, against the axis of the wheel."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    page = page_of(made)
    for frame_ in made.frames:
        scheme = made.schemes[frame_.scheme]
        told = [measured(page, frame_, stage) for stage in range(len(scheme.stages))]
        lengths = [
            word for words in told for word in words if " along y" in word or " against y" in word
        ]
        strokes = [stroke for stroke in scheme.strokes if stroke.role == "excitation"]
        assert len(lengths) == len(strokes) > 0
        for stroke, words in zip(strokes, lengths, strict=True):
            plane = next(p for p in made.planes if p.number in stroke.start)
            way = frame_.points[stroke.end] - frame_.points[stroke.start]
            along = (way * plane.displacement.direction.conjugate()).real >= 0.0
            assert f"{'along' if along else 'against'} y{'₁₂'[int(plane.number) - 1]}" in words
        assert sum("mean ÿ" in word for words in told for word in words) == 2


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("by xi''/Omega2^2 over the step: H2.", "by ξ̈/Ω₂² over the step: H₂."),
        ("D1P1 and D2P2", "D₁P₁ and D₂P₂"),
        ("b x2st", "b x₂ₛₜ"),
        ("II1", "II₁"),
        ("B2C2 cuts line III in G11", "B₂C₂ cuts line III in G₁₁"),
        ("rule delta, step 2.5 ms", "rule delta, step 2.5 ms"),
    ],
)
def test_sentences_are_typeset(text: str, wanted: str) -> None:
    assert typeset(text) == wanted


@pytest.mark.parametrize(
    ("step", "time"),
    [(0.0025, "0.10000"), (3e-6, "0.1000000"), (1e-9, "0.1000000000"), (0.0, "0.100000000000")],
)
def test_a_time_has_the_decimals_that_its_step_needs(step: float, time: str) -> None:
    made, one = drawing(), replace(frame(0), time=0.1, duration=step)
    assert f": t = {time} s, lasts " in step_head(made, one)
    ends = replace(made, frames=StoredFrames([replace(one, time=0.1 - step)]))
    assert f" at t = {time} s" in Readings(ends).end_text()


@pytest.mark.parametrize("run", [0.1, 0.5])
def test_the_end_of_a_construction_says_whether_its_run_goes_on(run: float) -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=40)
    told = Readings(made).end_text(run)
    assert told.startswith("**The construction ends** at t = 0.10000 s")
    assert ("; the run goes on to 0.5 s, in violet." in told) is (run > 0.1)


def test_rounding_is_measured_as_zero() -> None:
    made = construct_motion(
        EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0, initial_velocity=1e-16),
        delta, step=0.1, steps=1,
    )  # fmt: skip
    told = protocol(page_of(made), made.frames[0], 0)
    assert "QP = 0 cm: ẋ = 0 1/s" in told


@pytest.mark.parametrize(("kind", "letter"), LETTER_OF_EVENT.items())
def test_the_sentence_of_an_event_names_its_letter(kind: str, letter: str) -> None:
    assert event_text(Event(kind, kind, "", ())).endswith(f"({letter}).")


def test_the_end_of_a_story_says_what_its_red_points_are() -> None:
    """Where there are many they have no letters."""
    made = drawing()
    _, ticks = sheet_and_story(made)
    assert "Red points: lift-off U (1), touchdown V (1)." in ticks[-1].text
    frames = [replace(frame, event="sticking") for frame in made.frames[1:31]]
    often = replace(made, frames=StoredFrames([made.frames[0], *frames]))
    assert marks_text(often) == "dry friction begins to hold F (30)"
    assert marks_text(replace(made, frames=StoredFrames(made.frames[:20]))) == ""


def test_there_is_no_negative_zero() -> None:
    assert number(-0.0) == "0"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (11_512.3, "11510"), (-2.0061e-05, "\u22120.00002006"), (3.0e7, "30000000"),
        (-2.0061e-11, "\u22122.006\u00b710\u207b\u00b9\u00b9"), (5.0e12, "5\u00b710\u00b9\u00b2"),
    ],
)  # fmt: skip
def test_numbers_are_printed_in_full_or_with_a_power_of_ten(value: float, text: str) -> None:
    assert number(value, 4) == text
    read = {"contact_force": value}
    assert f"| {text} |" in read_once(read).table(read)


@pytest.mark.parametrize("pace", [1e-5, 1e6])
def test_no_number_of_a_slow_or_a_quick_motion_has_an_exponent(pace: float) -> None:
    formula = Formula("w^2*x + 1e-9*v", {"w": pace})
    law = EquationPlane(
        formula.switching, formula.autonomous, pace, scale=1e-6, initial_displacement=1e4, unit="kg",
        words=formula.words,
    )  # fmt: skip
    made = construct_motion(law, delta, step=0.1 / pace, steps=20)
    told = [told for tick in sheet_and_story(made)[1] for told in (tick.text, tick.caption)]
    told += [made.title, *Readings(made).step_texts(made.frames)]
    assert re.findall(r"\S*\de[+-]?\d\S*", " ".join(told)) == []


def test_rounding_is_read_off_as_zero() -> None:
    read = {"wheel_displacement": -0.0, "wheel_velocity": 4.2e-21, "wheel_acceleration": -1.5e-16}
    moved = read_once(dict.fromkeys(read, 1e-3))
    table = moved.table(read)
    assert table.splitlines()[-1] == "| wheel | 0 | 0 | 0 |"


@pytest.mark.parametrize("paper", [0.05, 1e-17])
@pytest.mark.parametrize("size", [1.0, 1e-15, 1e-100])
def test_a_motion_of_any_size_is_read_as_what_it_is_on_any_paper(size: float, paper: float) -> None:
    """The stages told zeros beside a table that did not."""
    law = EquationPlane(
        lambda v, x, t: x, True, scale=paper / size, initial_displacement=2.0 * size
    )
    made = construct_motion(law, delta, step=0.1, steps=20)
    first = " ".join(Readings(made).step_texts(made.frames[:1]))
    assert f"| {number(2.0 * size)} | 0 | {number(-2.0 * size)} |" in first
    recorder = Recorder(rr.RecordingStream("size"), Content("of any size", made, staged=(0,)))
    told = [tick.text for tick in recorder.ticks]
    length = f"OQ = {number(200.0 * paper)} cm: x = {number(2.0 * size)}; QP = 0 cm: ẋ = 0 1/s"
    assert any(length in text for text in told)


def test_a_drift_is_read_off_in_its_unit() -> None:
    names = [f"wheel_{part}" for part in ("displacement", "velocity", "acceleration")]
    read = dict.fromkeys((*names, "wheel_displacement_drift"), 0.01)
    head, _, row = read_once(read).table(read).splitlines()
    assert head == "| read off the sheet | cm | m/s | m/s² | drift, cm |"
    assert row == "| wheel | 1 | 0.01 | 0.01 | 1 |"


def test_curves_that_coincide_have_one_label() -> None:
    assert level_text("x = 2 and x = -2", "", 1.0) == "±2"
    assert level_text("y1 = 0.2 cm", "mm", 1000.0) == "2 mm"


def test_units_are_printed() -> None:
    assert unit_text("m/s2") == "m/s²"
    assert unit_text("kgf.s2/cm") == "kgf·s²/cm"
    assert unit_text("rad/s^2") == "rad/s²"


def test_no_text_holds_a_character_that_ends_the_viewer(tmp_path: Path) -> None:
    strange = "a\N{BRAILLE PATTERN BLANK}b"
    plane = replace(PLANES[0], displacement=replace(PLANES[0].displacement, label=strange))
    scheme = replace(
        CONTACT_SCHEME, stages=(strange,) * 3, marks=(Mark("state", "P1", 0, strange),)
    )
    odd = replace(
        drawing(25),
        title=strange,
        planes=(plane,),
        curves=(Curve("line", (0j, 1 + 0j), strange),),
        schemes={"contact": scheme},
        frames=(replace(frame(0), readings={strange: 1.0}, event=strange), frame(1)),
    )
    times = {"time": [0.0, 1.0], f"{strange}_displacement": [0.0, 1.0]}
    texts = list(read_back(Content(strange, odd, times), tmp_path).words())
    assert sum("a?b" in text for text in texts) >= 5
    assert all(text == legible(text) for text in texts)


def test_what_the_viewer_can_show_is_kept() -> None:
    kept = "x\N{SUBSCRIPT TWO} \N{GREEK CAPITAL LETTER OMEGA} \N{MINUS SIGN}1 A1*'\n"
    assert legible(kept) == kept
    for raised_or_index in (
        "3.2\u00b710\u207b\u00b9\u2074 m\u207b\u00b9",
        "D\u2098\u2081",
        "x\u2082\u209b\u209c",
    ):
        assert legible(raised_or_index) == raised_or_index
    assert legible("\u03be\N{COMBINING DIAERESIS}/\u03a9") == "\u03be\N{DOUBLE PRIME}/\u03a9"
    assert legible("y\N{COMBINING MACRON}") == "\N{LATIN SMALL LETTER Y WITH MACRON}"
