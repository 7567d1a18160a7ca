"""The sheets of every case that comes along, asserted from their description."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from inspect import unwrap
from itertools import combinations, pairwise, product

import numpy as np
import pytest
import rerun as rr
from drawn_cases import DRAWN, PANES, REFUSED, SYSTEMS_OF_ONES_OWN, drawing_of
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.draw.planes import CONSTRUCTED
from phaseplane.scenarios.draw.recording_content import readings
from phaseplane.scenarios.errors import DrawingError, InputError
from phaseplane.scenarios.scene.loading import load_scene

from phaseplane.constructions.letters import typeset
from phaseplane.figures.canvas import new_page
from phaseplane.figures.planes import step_lines, step_page
from phaseplane.figures.single_steps import figure2
from phaseplane.figures.style import PLAIN
from phaseplane.picture.curves import curve_through
from phaseplane.picture.frames import table
from phaseplane.picture.letters import NEAR, PLATE, Room, free_letters, text_box
from phaseplane.picture.page import Arrow, Lines, Page
from phaseplane.picture.paper import SEEN, Box, around, segments_of
from phaseplane.picture.step import mark_events, write_letters
from phaseplane.picture.story import MOST, arms_page, story_of
from phaseplane.picture.views import frame_at, telling_frame
from phaseplane.recording import Content
from phaseplane.recording.canvas import legible
from phaseplane.recording.motion import pages_of
from phaseplane.recording.recorder import Recorder


def test_what_cannot_be_drawn_is_refused_in_words() -> None:
    for name in SYSTEMS_OF_ONES_OWN:
        assert load_scene(name, [], expect=False).fmu.model not in CONSTRUCTED
    for name, words in REFUSED.items():
        with pytest.raises((DrawingError, InputError, ArithmeticError), match=words):
            drawing_of(name)


def check_letters(page: Page, stays: Page | None = None) -> None:
    """No text lies on another, and no letter without a leader is far from its point."""
    texts = [*(stays.texts if stays is not None else ()), *page.texts]
    for one, other in combinations(texts, 2):
        assert one.box(page.em).overlap(other.box(page.em)) < 1e-12, (one.text, other.text)
    for text in page.texts:
        if text.kind == "letter" and not text.led:
            assert text.point is not None
            gap = abs(text.box(page.em).nearest(text.point) - text.point)
            assert gap <= NEAR * text.size * page.em * 1.001, text.text


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_letters_are_legible_and_the_sheet_fills_its_pane(name: str) -> None:
    drawing = drawing_of(name)
    page = step_page(drawing, frame_at(drawing, None), PLAIN)
    mark_events(page)
    write_letters(page, frame_at(drawing, None))
    check_letters(page)

    stays, *_ = pages_of(Content(name, drawing))
    ticks = list(story_of(stays, arms_page(drawing)))
    assert len(ticks) <= MOST + 2
    if len(drawing.frames) > 40:
        assert len(ticks) >= 36
    for tick in ticks:
        check_letters(tick.page, stays)
        assert "?" not in legible(tick.text)  # a character that the viewer cannot show
    others = [np.array(c.vertices) for c in drawing.curves if c.role == "trail"]
    motion = np.concatenate(stays.subject.motions + others)
    curves = complex(np.ptp(motion.real), np.ptp(motion.imag))
    between = [
        (max(0.0, *(lower - b).imag) - min(0.0, *(upper - a).imag)) / (a - b).imag
        for (a, upper), (b, lower) in pairwise(
            (p.displacement.origin, m)
            for p, m in zip(drawing.planes, stays.subject.motions, strict=True)
        )
        if (a - b).imag > 0.0101  # the least distance
    ]
    assert max(between, default=1.0) > 0.38  # planes do not stand in much empty paper
    for width, height in PANES[len(drawing.planes) > 2]:
        scale = min(width / stays.view.half.real, height / stays.view.half.imag) / 2.0
        assert scale * max(curves.real, curves.imag) >= 0.45 * min(width, height)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["high_bump_at_speed", "iso8608_c"])
def test_both_axes_of_a_plane_are_in_one_unit(name: str) -> None:
    drawing = drawing_of(name)
    stays, *_ = pages_of(Content(name, drawing))
    names = [text.text.replace("\n", " ") for text in stays.texts if text.kind == "name"]
    for plane in drawing.planes:
        unit, _ = stays.units[plane.name]
        for axis in (plane.displacement, plane.scaled_velocity):
            assert any(name.endswith(f"{typeset(axis.label)} [{unit}]") for name in names), names


def test_a_motion_that_goes_round_leaves_room_for_the_construction() -> None:
    """Example 23 has a start from which the pendulum turns over six times, to 40 rad."""
    drawing = drawing_of("h83_example23", 6.0)
    stays, *_ = pages_of(Content("example 23", drawing))
    (motion,) = stays.subject.motions
    assert np.ptp(motion.imag) > 0.3 * 2.0 * stays.view.half.imag
    axis = drawing.planes[0].displacement
    values = [t.text for t in stays.texts if t.role == "value" and t.centre.imag < axis.origin.imag]
    assert "1" in values or "2" in values


@pytest.mark.parametrize("name", ["h83_example23", "h83_example25", "h83_example27"])
def test_no_start_is_taken_for_that_of_the_motion(name: str) -> None:
    stays, *_ = pages_of(Content(name, drawing_of(name)))
    (motion,) = stays.subject.motions
    named = [text for text in stays.texts if text.role == "trail" and text.point is not None]
    assert named
    for text in named:
        assert abs(text.centre - text.point) < abs(text.centre - motion[0]), text.text


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_no_line_strikes_the_name_of_an_axis(name: str) -> None:
    """Neither an axis nor one of the lines I to IV, all of which are horizontal or upright.

    No auxiliary curve does, either.
    The names of those lines, which may stand close to another one, are clear of axes.
    """
    drawing = drawing_of(name)
    lines = [(c.vertices[0], c.vertices[-1]) for c in drawing.curves if c.role == "line"]
    pages = step_page(drawing, frame_at(drawing, None), PLAIN), *pages_of(Content(name, drawing))
    for page in pages:
        axes = [(arrow.start, arrow.tip) for arrow in page.of(Arrow) if arrow.role == "axis"]
        for text in page.texts:
            if text.kind == "name" or text.role == "line":
                box = text.box(page.em)
                ends = np.array([*(lines if text.kind == "name" else ()), *axes]) - box.centre
                beside = (ends.real < -box.half.real).all(1) | (ends.real > box.half.real).all(1)
                above = (ends.imag < -box.half.imag).all(1) | (ends.imag > box.half.imag).all(1)
                assert (beside | above).all(), text.text
            if text.kind == "name":
                for curve in (c for c in drawing.curves if c.role == "auxiliary"):
                    starts, ends = segments_of([curve.vertices]).T
                    assert not Box(*np.array([box.centre, box.half])).inside(starts, ends).any()


def test_no_line_of_figure_2_strikes_its_texts() -> None:
    """With a bump stop P is far up, level with where the values of the curves would be."""
    stop = ["bump_stop.gap=3 cm", "bump_stop.stiffness=500 kN/m", "construction.step=5 ms"]
    road = ["road.shape=bump", "road.height=12 cm", "road.length=2 m", "speed=40 km/h"]
    scene = load_scene("OneDof", [*stop, *road, "duration=1.5"])
    settings = asdict(scene.construction)
    drawing = draw_construction("OneDof", scene.all_parameters, settings, scene.duration)
    page, _ = unwrap(figure2)(drawing, look=PLAIN)
    dimensions = [(arrow.start, arrow.tip) for arrow in page.of(Arrow) if arrow.both]
    assert len(dimensions) == 1
    step = step_lines(page, frame_at(drawing, None))
    for text in (text for text in page.texts if text.kind == "name" or text.role == "auxiliary"):
        box = text.box(page.em)
        for segments in (np.array(dimensions), step):
            struck = Box(np.array(box.centre), np.array(box.half)).inside(*segments.T)
            assert not struck.any(), text.text


@pytest.mark.slow
def test_a_construction_with_a_stiff_stop_follows_its_run() -> None:
    """It has no travel beyond its stops: 40 mm in bump and 60 mm in rebound, where the stop gives way."""
    drawing = drawing_of("stiff_stop")
    travel = [frame.readings["suspension_deflection"] for frame in drawing.frames]
    assert -0.041 < min(travel) < max(travel) < 0.1


@pytest.mark.slow
def test_the_name_of_an_axis_keeps_clear_of_the_motion() -> None:
    drawing = drawing_of("end_stop_impact", 2.0)
    page, *_ = pages_of(Content("end_stop_impact", drawing, readings(drawing)))
    for text, motion in product((t for t in page.texts if t.kind == "name"), page.subject.motions):
        box = text.box(page.em)
        assert not any(box.holds(z) for z in motion), text.text


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_values_do_not_cover_the_state_points_and_names_are_near_their_axes(name: str) -> None:
    """The viewer draws a plate behind each text, a quarter of an em wider, over all points."""
    drawing = drawing_of(name)
    page, *_ = pages_of(Content(name, drawing))
    starts, ends = segments_of(page.subject.motions).T
    axes = [around((a.start, a.tip), 1e-6) for a in page.of(Arrow) if a.role == "axis"]
    values = [text for text in page.texts if text.kind == "value"]
    assert len(values) >= 3 * len(drawing.planes)
    for text in values:
        plate = text.box(page.em).grown(0.25 * page.em)
        inside = Box(np.array(plate.centre), np.array(plate.half)).inside(starts, ends)
        assert not inside.any(), text.text
    for text in (text for text in page.texts if text.kind == "name"):
        assert min(text.box(page.em).gap(axis) for axis in axes) < 3.5 * page.em, text.text


@pytest.mark.parametrize("name", ["h83_example23", "h83_example25", "h83_example27"])
def test_other_starts_leave_the_sheet_to_the_construction(name: str) -> None:
    """Also where one of them goes the other way: the own curve takes up half of the smaller side."""
    drawing = drawing_of(name)
    stays, *_ = pages_of(Content(name, drawing))
    (motion,), half = stays.subject.motions, stays.view.half
    (width, height), _ = PANES[0]
    scale = width / (2.0 * half.real)
    assert scale * max(np.ptp(motion.real), np.ptp(motion.imag)) > 0.5 * height


def test_the_levels_of_curves_are_those_of_the_construction() -> None:
    """Not of a pendulum that goes round and round: a few curves are in view, with their values."""
    stays, *_ = pages_of(Content("example 23", drawing_of("h83_example23", 6.0)))
    named = [text.text for text in stays.texts if text.role == "auxiliary"]
    assert {"−2 rad", "0 rad", "2 rad"} <= {*named}


@pytest.mark.slow
def test_events_of_a_kind_that_are_close_together_share_a_letter() -> None:
    """A car that jumps leaves the road six times at about the same place of its plane."""
    stays, *_ = pages_of(Content("crest_jump", drawing_of("crest_jump", 3.0)))
    mark_events(stays)
    for one, other in combinations((t for t in stays.texts if t.role == "event"), 2):
        assert one.point is not None
        assert other.point is not None
        assert one.text != other.text or abs(one.point - other.point) >= 3.0 * stays.em


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_planes_do_not_overlap(name: str) -> None:
    drawing = drawing_of(name)
    page = new_page(drawing, pages_of(Content(name, drawing))[0].view, PLAIN)
    spans = [(m.imag.min(), m.imag.max()) for m in page.subject.motions]
    for (low, high), (other_low, other_high) in combinations(spans, 2):
        assert high <= other_low or other_high <= low


@pytest.mark.parametrize("name", ["iso8608_a", "leaf_spring", "passenger_car"])
def test_small_motions_are_not_lost_on_the_sheet(name: str) -> None:
    """Each curve takes up a tenth of the height, however large the paper of 1957 was."""
    drawing = drawing_of(name)
    stays, *_ = pages_of(Content(name, drawing))
    for motion in stays.subject.motions:
        assert np.ptp(motion.imag) >= 0.1 * 2.0 * stays.view.half.imag


def test_a_letter_of_a_moving_step_stands_where_no_other_is() -> None:
    """Near its point; there is none where it would be out of view, or on lines everywhere."""
    stays, *_ = pages_of(Content("ap57", drawing_of("ap57")))
    here, em = complex(stays.view.centre), stays.em
    z = np.array([[here, here, here + 1e3], [here, here + 1.5 * em, 1j * np.inf]])
    centres, free = free_letters(z, ["A", "B", "C"], Room(stays.view, em, [], []))
    assert free.tolist() == [[True, True, False]] * 2
    assert (abs(centres[free] - z[free]) < 3.0 * em).all()
    boxes = [[text_box(c, "A", em) for c in row[:2]] for row in centres]
    assert not any(one.overlap(other) for one, other in boxes)
    hatched = here + np.arange(-9.0, 9.0, 0.5) * em
    strokes = [np.array([x - 9j * em, x + 9j * em]) for x in hatched]
    assert not free_letters(z, ["A", "B", "C"], Room(stays.view, em, [], strokes))[1].any()


@pytest.mark.parametrize(
    ("name", "least"),
    [
        ("ap57", 0.95),
        *(
            pytest.param(*of, marks=pytest.mark.slow)
            for of in (("half_car_pitch", 0.9), ("iso8608_c", 0.0))
        ),
    ],
)
def test_letters_of_steps_do_not_cover_the_motion(name: str, least: float) -> None:
    """The viewer draws a plate behind each; where the motion is everywhere there is no letter."""
    drawing = drawing_of(name)
    recorder = Recorder(rr.RecordingStream("letters"), Content(name, drawing, detail="steps"))
    names = [plane.state for plane in drawing.planes]
    points = table(drawing.frames, names)
    centres, free = free_letters(points, names, recorder.room)
    assert free.mean() > least
    page = recorder.lettered
    starts, ends = segments_of(recorder.pages[0].subject.motions).T
    for i, plate in enumerate(text_box(0j, n, page.em).grown(PLATE * page.em) for n in names):
        places = Box(centres[free[:, i], i][::9, None], np.array(plate.half))
        assert (places.inside(starts, ends).sum(axis=1) < 0.75 * page.em).all()


def distance(point: complex, strip: Sequence[complex]) -> float:
    """How far a point is from a polyline."""
    a, b = np.array(strip[:-1]), np.array(strip[1:])
    way = b - a
    part = np.clip(((point - a) * way.conjugate()).real / np.maximum(abs(way) ** 2, 1e-300), 0, 1)
    return float(abs(point - (a + part * way)).min())


@pytest.mark.parametrize("name", ["crest_jump", "h83_example23", "speed_bump", "ap57"])
def test_every_auxiliary_point_is_on_a_curve_that_is_drawn(name: str) -> None:
    """On one of the fixed curves, or on its own for the y of P, which lies between them."""
    drawing = drawing_of(name)
    fixed = [c.vertices for c in drawing.curves if c.role == "auxiliary"]
    own = 0
    for frame in list(drawing.frames)[:: max(1, len(drawing.frames) // 40)]:
        for plane in drawing.planes:
            point = frame.points.get(f"A{plane.number}")
            if point is None:
                continue
            through = curve_through(drawing, plane, point)
            own += len(through)
            gaps = [distance(point, strip) for strip in (*fixed, *through)]
            assert min(gaps) < 2e-3 * max(abs(strip[-1] - strip[0]) for strip in fixed)
    assert bool(own) == (name != "ap57")


def test_the_auxiliary_point_of_a_lettered_step_is_on_a_curve_of_its_figure() -> None:
    drawing = drawing_of("h83_example23")
    page = step_page(drawing, telling_frame(drawing), PLAIN)
    curves = [s for lines in page.of(Lines) if lines.role == "auxiliary" for s in lines.strips]
    assert min(distance(telling_frame(drawing).points["A"], s) for s in curves) < SEEN
