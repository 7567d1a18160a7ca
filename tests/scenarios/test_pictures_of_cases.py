"""The pictures of every case that comes along, asserted from their description."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from itertools import combinations, pairwise, product
from textwrap import wrap

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from phaseplane.scenarios.draw.constructions import draw_construction, draw_scene
from phaseplane.scenarios.draw.planes import CONSTRUCTED
from phaseplane.scenarios.draw.recording_content import of_scene, readings
from phaseplane.scenarios.errors import DrawingError, InputError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import case_names

from phaseplane.constructions import RULES
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.two_planes import STUCK
from phaseplane.figures.canvas import new_page
from phaseplane.figures.planes import step_page
from phaseplane.figures.style import PLAIN
from phaseplane.picture.curves import curve_through
from phaseplane.picture.frames import motions_of, table
from phaseplane.picture.letters import NEAR, Room, text_box
from phaseplane.picture.page import PLATE, Arrow, Lines, Page
from phaseplane.picture.paper import SEEN, Box, around, segments_of
from phaseplane.picture.step import mark_events, write_letters
from phaseplane.picture.story import MOST, arms_page, story_of, told_steps
from phaseplane.picture.subject import read_off
from phaseplane.picture.text import control_text, end_text, step_head, step_text
from phaseplane.picture.views import frame_at, gathered, motion_points, telling_frame, view_of
from phaseplane.recording import Content
from phaseplane.recording.canvas import legible
from phaseplane.recording.histories import panels_of
from phaseplane.recording.lanes import lanes_of
from phaseplane.recording.layout import blueprint
from phaseplane.recording.motion import pages_of, state_planes
from phaseplane.recording.recorder import Recorder
from phaseplane.recording.steps import free_letters

LONGEST = 1.0  # s of each case
SYSTEMS_OF_ONES_OWN = {"double_pendulum", "full_car"}
REFUSED = {"light_wheel": "try 1.4e-05 s"}
DRAWN = sorted({*case_names()} - SYSTEMS_OF_ONES_OWN - {*REFUSED})
# of the sheet, wide and narrow, in windows of 1366 x 768 and 2560 x 1440
PANES = ((860, 670), (1610, 1340)), ((600, 670), (1125, 1340))


@cache
def drawing_of(name: str, longest: float = LONGEST, rule: str | None = None) -> Drawing:
    """The construction of a case, or of its first second."""
    scene = load_scene(name, [f"construction.rule={rule}"] if rule else [], expect=False)
    time = min(scene.construction_time, longest)
    settings = asdict(scene.construction)
    return draw_construction(scene.fmu.model, scene.all_parameters, settings, time)


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
    ticks = list(story_of(stays, arms_page(drawing), {}))
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
    note = control_text(drawing, recorder.quantities)
    steps = [step_text(drawing, f, recorder.quantities, note) for f in drawing.frames[:200]]
    for text in [tick.text for tick in recorder.ticks] + steps:
        assert text_height(text) <= room, text
    for tick in recorder.ticks:
        bold = re.search(r"^- \*\*.*", tick.text, re.MULTILINE)
        if bold and "successor" in bold[0]:
            assert " = " in bold[0].rpartition("**")[2]


@pytest.mark.parametrize("name", ["ap57", "half_car_pitch", "half_car_rigid_tyres"])
def test_every_turn_angle_is_named(name: str) -> None:
    """Also those of two axles, which are nearly equal."""
    drawing = drawing_of(name)
    written = ", ".join(text.text for text in arms_page(drawing).texts)
    for plane in drawing.planes:
        assert typeset(f"dtau{plane.number}") in written


@pytest.mark.parametrize("name", ["ap57", "van_der_pol", "h83_example40"])
def test_a_replay_has_a_chart_of_the_displacements_of_its_planes(name: str) -> None:
    """But no motion of a run in its planes, which would hide the trail."""
    drawing = drawing_of(name)
    columns = readings(drawing)
    shown = Content(name, drawing, columns)
    of_planes = {plane.name for plane in drawing.planes}
    drawn = [set(panel.drawn) for panel in panels_of(shown)]
    assert any(of_planes <= names for names in drawn)
    assert state_planes(shown) == []


@pytest.mark.parametrize(
    ("name", "lanes"),
    [
        ("ap57", {"wheel": ("lift_off", "touchdown")}),
        ("half_car_pitch", {f"{axle} wheel": (f"{axle}_lift_off", f"{axle}_touchdown")
                            for axle in ("front", "rear")}),
        ("h83_example40", {"spring": ("yielding", "unloading")}),
        ("leaf_spring", {"dry friction": ("sticking",)}),
    ],
)  # fmt: skip
def test_a_replay_has_lanes_that_change_with_its_events(
    name: str, lanes: dict[str, tuple[str, ...]]
) -> None:
    drawing = drawing_of(name)
    shown = Content(name, drawing, readings(drawing))
    times = np.asarray(shown.histories["time"])
    found = {name: {*times[1:][np.diff(lane.active)]} for name, lane in lanes_of(shown).items()}
    assert found.keys() == lanes.keys()
    for lane, events in lanes.items():
        assert {frame.time for frame in drawing.frames if frame.event in events} <= found[lane]


def test_lanes_below_steps_are_those_of_the_construction_beside_a_run() -> None:
    """A run has no column of dry friction."""
    drawing = drawing_of("leaf_spring")
    times = np.array([0.0, drawing.frames[-1].time])
    lanes = lanes_of(Content("run", drawing, {"time": times, "airborne": np.zeros(2)}))
    assert lanes.keys() == {"dry friction"}
    drawn = lanes["dry friction"].drawn
    assert drawn is not None
    assert drawn[: len(drawing.frames)].tolist() == [
        scheme.endswith(STUCK) for scheme in drawing.frames.schemes
    ]


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
    first = next(story_of(stays, arms_page(drawing), {})).text
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


def test_the_chart_is_of_the_motion_that_is_drawn() -> None:
    """Not of the pendulum that goes round and round, beside which it would be lost."""
    drawing = drawing_of("h83_example23")
    histories = readings(drawing)
    histories["start4_displacement"] = 10.0 + histories["displacement"]
    units = dict.fromkeys(("displacement", "start4_displacement"), "rad")
    recorder = Recorder(
        rr.RecordingStream("chart"), Content("example 23", drawing, histories, units)
    )
    assert recorder.chart is not None
    assert recorder.chart.names == ("displacement",)


@pytest.mark.parametrize("name", ["h83_example23", "h83_example25", "h83_example27"])
def test_no_start_is_taken_for_that_of_the_motion(name: str) -> None:
    stays, *_ = pages_of(Content(name, drawing_of(name)))
    (motion,) = stays.subject.motions
    named = [text for text in stays.texts if text.role == "trail" and text.point is not None]
    assert named
    for text in named:
        assert abs(text.centre - text.point) < abs(text.centre - motion[0]), text.text


@pytest.mark.parametrize("name", ["ap57", "h83_example40", "van_der_pol"])
def test_the_turn_angles_fit_their_pane_with_type_of_its_size(name: str) -> None:
    """The pane is 120 pixels high in a window of 1366x768, with a bar of 25; 1 em is 16.75 pixels.

    The viewer's plates are 23 pixels high, and there 3 pixels below their places.
    """
    page = arms_page(drawing_of(name))
    assert 2.0 * page.view.half.imag / page.em <= (120.0 - 25.0) / 16.75 + 0.05
    lowest = min(text.centre.imag for text in page.texts) - (3.0 + 0.5 * 23.0) / 16.75 * page.em
    assert lowest >= page.view.corners[0].imag


def test_steps_are_told_of_the_whole_motion() -> None:
    """Also if the road is so high at first that all that follows is small beside it."""
    drawing = drawing_of("crest_jump", 3.0)
    thirds = {3 * step // len(drawing.frames) for step in told_steps(drawing)}
    assert thirds == {0, 1, 2}


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


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_the_arm_of_the_turn_angles_is_for_the_normals_of_most_steps(name: str) -> None:
    """At an impact against a stiff stop a foot is 26 m away, and only there."""
    drawing = drawing_of(name)
    arms = arms_page(drawing)
    feet = table(drawing.frames, [f"N{plane.number}" for plane in drawing.planes])
    normals = (feet - table(drawing.frames, ["W"])).real.max(axis=1)
    length = 2.0 * arms.view.half.real
    assert np.quantile(normals, 0.98) < length < 5.0 * np.quantile(normals, 0.995)


@pytest.mark.slow
def test_events_of_a_kind_that_are_close_together_share_a_letter() -> None:
    """A car that jumps leaves the road six times at about the same place of its plane."""
    stays, *_ = pages_of(Content("crest_jump", drawing_of("crest_jump", 3.0)))
    mark_events(stays)
    for one, other in combinations((t for t in stays.texts if t.role == "event"), 2):
        assert one.point is not None
        assert other.point is not None
        assert one.text != other.text or abs(one.point - other.point) >= 3.0 * stays.em


@pytest.mark.slow
@pytest.mark.parametrize(("name", "told"), [("stiff_stop", True), ("ap57", False)])
def test_it_is_said_if_a_body_from_its_forces_differs(name: str, told: bool) -> None:
    drawing = drawing_of(name, 10.0)
    quantities = read_off(drawing)
    *_, last = story_of(pages_of(Content(name, drawing))[0], arms_page(drawing), quantities)
    note = control_text(drawing, quantities)
    beside = step_text(drawing, drawing.frames[5], quantities, note)
    for text in (last.text, beside, end_text(drawing, quantities)):
        assert ("The body from its forces differs by up to " in text) is told


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


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_the_turn_angles_leave_the_sheet_to_the_planes(name: str) -> None:
    """They are below the motion, not on it, and the planes take up most of the height."""
    drawing = drawing_of(name)
    moved, steps = gathered(drawing, drawing.frames[:1])
    view = view_of(moved, steps, turn=True)
    arms = np.array([z for c in moved.curves if c.role == "construction" for z in c.vertices])
    motion = np.concatenate(motions_of(drawing))
    assert arms.imag.max() < motion.imag.min()
    planes = motion_points(drawing)
    assert np.ptp(planes.imag) > 0.4 * 2.0 * view.half.imag


@pytest.mark.slow
def test_four_planes_can_be_seen_side_by_side() -> None:
    """On the sheet they are one below the other, each as high as a sixth of a wide pane."""
    shown = Content("half car", drawing_of("half_car_pitch", 0.05))
    sheet = blueprint(Recorder(rr.RecordingStream("planes"), shown)).root_container.contents[0]
    _, grid = sheet.contents
    assert [view.name for view in grid.contents] == [
        "y₁₁, front suspension deflection", "y₁₂, front wheel displacement",
        "y₂₁, rear suspension deflection", "y₂₂, rear wheel displacement",
    ]  # fmt: skip


@pytest.mark.slow
def test_the_names_of_a_chart_have_room_beside_four_planes() -> None:
    """Nearly with type of its size, of which 1 em is 16.75 pixels in a window of 1366 pixels."""
    drawing = drawing_of("half_car_pitch", 0.05)
    recorder = Recorder(
        rr.RecordingStream("chart"), Content("half car", drawing, readings(drawing))
    )
    columns = blueprint(recorder).root_container
    (width,) = (
        share
        for share, column in zip(columns.column_shares, columns.contents, strict=True)
        for part in getattr(column, "contents", ())
        if isinstance(part, rrb.Tabs) and part.contents[0].name == "over time"
    )
    stays = recorder.chart.stays
    pixels = width / sum(columns.column_shares) * 1366.0
    assert 0.85 * 2.0 * stays.view.half.real / stays.em * 16.75 <= pixels


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


def distance(point: complex, strip: Sequence[complex]) -> float:
    """How far a point is from a polyline."""
    a, b = np.array(strip[:-1]), np.array(strip[1:])
    way = b - a
    part = np.clip(((point - a) * way.conjugate()).real / np.maximum(abs(way) ** 2, 1e-300), 0, 1)
    return float(abs(point - (a + part * way)).min())


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
    first = next(story_of(pages_of(Content(name, drawing))[0], arms_page(drawing), {}))
    assert f"the axes of the phase {planes} and" in first.text


def test_a_sheet_has_the_views_of_its_scene() -> None:
    scene = load_scene("ap57", ["show.views=['planes', 'words']"], expect=False)
    shown = of_scene(scene, drawing_of("ap57"))
    assert shown.vehicle is None
    assert shown.constructed is not None


def test_a_half_car_that_stands_for_a_pendulum_is_told_as_a_half_car() -> None:
    """Its axes and stages name suspensions and roads, so the title and the side view must, too."""
    scene = load_scene("h83_example28", [], expect=False)
    shown = of_scene(scene, drawing_of("h83_example28"))
    assert shown.vehicle is not None
    ticks = Recorder(rr.RecordingStream("half car"), shown).ticks
    assert ticks[0].text.startswith("# Half car on waves with the equations of a double pendulum")
