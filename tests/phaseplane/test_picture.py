"""The description of a picture: ticks, arcs, letters, words and styles, without any canvas."""

from __future__ import annotations

import cmath
from dataclasses import asdict, replace
from itertools import combinations, permutations, product
from math import pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene
from recorded import (
    CONTACT_SCHEME,
    PLANES,
    Recorded,
    content,
    drawing,
    frame,
)
from worked_example import ap57

from phaseplane.constructions import (
    Axis,
    Curve,
    Drawing,
    EquationPlane,
    Mark,
    compare_with_motion,
    construct_motion,
    delta,
)
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.sheet import Event
from phaseplane.figures.planes import step_lines, step_page
from phaseplane.figures.style import PLAIN
from phaseplane.picture import subject
from phaseplane.picture.axes import graduation_of
from phaseplane.picture.items import Arrow, Dots, Lines, Text
from phaseplane.picture.letters import NEAR, place, text_box
from phaseplane.picture.page import PLATE
from phaseplane.picture.paper import (
    Box,
    Boxes,
    arcs,
    around,
    readings,
    segments_of,
    telling_vertices,
)
from phaseplane.picture.quantities import QUANTITIES, display_unit, quantity_of, unit_text
from phaseplane.picture.story import arms_page, story_of, told_steps
from phaseplane.picture.styles import (
    INK,
    MOVING_POINT,
    PAPER,
    PARTS,
    ROLES,
    Hue,
    hue_of,
    part_of,
    style_of,
)
from phaseplane.picture.text import (
    LETTER_OF_EVENT,
    end_text,
    event_text,
    level_text,
    markdown,
    measured,
    number,
    protocol,
    readings_table,
)
from phaseplane.recording import Content, record
from phaseplane.recording.columns import legible, rgba
from phaseplane.recording.motion import pages_of


@pytest.mark.slow
@given(
    low=st.floats(-100.0, 0.0),
    span=st.floats(1e-3, 100.0),
    part=st.floats(0.02, 0.5),
    unit=st.sampled_from(["m", "rad"]),
    scale=st.floats(0.01, 100.0),
    direction=st.sampled_from([1 + 0j, -1 + 0j, 1j]),
)
def test_ticks_stand_where_their_label_says(
    *, low: float, span: float, part: float, unit: str, scale: float, direction: complex
) -> None:
    axis = Axis("y", unit, 0.1 - 0.2j, direction, scale)
    reach = max(low + span, 0.0) - min(low, 0.0)
    least = part * reach * scale
    motion = np.array([axis.at(low), axis.at(low + span)])
    graduation = graduation_of(axis, motion, least)
    assert (graduation.unit, graduation.factor) in {
        display_unit(unit, reach * (1.0 + e)) for e in (-1e-9, 0.0, 1e-9)
    }
    steps = np.diff(sorted([*graduation.values, 0.0])) * graduation.factor
    if len(steps):
        assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-3)
        assert f"{steps[0]:.1e}"[:3] in ("1.0", "2.0", "5.0")
        assert 0.999 * least <= steps[0] / graduation.factor * scale
        assert min([*graduation.values, 0.0]) >= min(low, 0.0) - steps[0] / graduation.factor
        assert max([*graduation.values, 0.0]) <= max(low + span, 0.0) + steps[0] / graduation.factor


angles = st.floats(-pi + 1e-3, pi - 1e-3)


@given(radius=st.floats(1e-3, 10.0), start=angles, turn=angles, far=st.floats(0.1, 10.0))
def test_arcs_are_the_shorter_ones(radius: float, start: float, turn: float, far: float) -> None:
    centre = np.array([[0.3 - 0.7j]])
    begin = centre + radius * np.exp(1j * start)
    end = centre + far * np.exp(1j * (start + turn))
    polyline = arcs(centre, begin, end)[0, 0]
    spokes = polyline - centre[0, 0]
    assert abs(spokes) == pytest.approx(np.full(len(spokes), radius))
    assert polyline[0] == pytest.approx(begin[0, 0])
    assert cmath.phase(spokes[-1] / (end - centre)[0, 0]) == pytest.approx(0.0, abs=1e-9)
    assert np.sum(np.angle(spokes[1:] / spokes[:-1])) == pytest.approx(turn)
    assert np.max(abs(np.angle(spokes[1:] / spokes[:-1]))) <= 0.1


@given(
    places=st.lists(st.complex_numbers(max_magnitude=0.9), min_size=1, max_size=12),
    clusters=st.booleans(),
)
def test_letters_do_not_overlap_stay_in_view_and_are_near_or_led(
    *, places: list[complex], clusters: bool
) -> None:
    points = np.array(places) * (1e-3 if clusters else 1.0)
    texts = [f"A{i}" for i in range(len(places))]
    em, view = 0.04, Box(0j, 1 + 1j)
    made = place(points, texts, em, view, np.zeros((0, 2), complex))
    boxes = [text_box(c, t, em) for c, t in zip(made.centres, texts, strict=True)]
    shown = [box for box, free in zip(boxes, made.free, strict=True) if free]
    assert all(one.overlap(other) == 0.0 for one, other in combinations(shown, 2))
    assert made.free.all()
    assert all(view.contains(box) for box in boxes)
    for point, box, led in zip(points, boxes, made.led, strict=True):
        assert led or abs(box.nearest(point) - point) <= NEAR * em


@given(angle=st.floats(0.0, 2.0 * pi), distance=st.floats(0.2, 3.0))
def test_a_letter_is_nearer_to_its_point_than_to_others(angle: float, distance: float) -> None:
    em, other = 0.04, 0.04 * cmath.rect(distance, angle)
    made = place(np.zeros(1, complex), ["P"], em, Box(0j, 1 + 1j), np.zeros((0, 2)), others=[other])
    assert abs(made.centres[0]) < abs(made.centres[0] - other)


def test_letters_of_a_stage_are_nearer_to_their_points_than_to_others() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, duration=0.1)
    stays = pages_of(Content("quarter car", made))[0]
    stays.unled = NEAR
    ticks = [tick.page for tick in story_of(stays, arms_page(made), {})]
    letters = [[t for t in page.of(Text) if t.kind == "letter" and not t.led] for page in ticks]
    nearer = [
        abs(one.centre - other.point) > abs(one.centre - one.point) - 1e-9
        for several in letters
        for one, other in permutations(several, 2)
        if one.point is not None and other.point is not None
    ]
    assert nearer.count(False) < 0.013 * len(nearer)


def test_a_story_in_order() -> None:
    stays = pages_of(content())[0]
    ticks = list(story_of(stays, arms_page(drawing()), {}))
    assert not ticks[0].page.items  # the empty sheet
    assert [tick.step for tick in ticks] == sorted(tick.step for tick in ticks)
    assert {25, 40} <= set(told_steps(drawing()))  # lift-off and touchdown
    assert "The wheel leaves the road (U)." in [t.caption.partition(": ")[2] for t in ticks]
    assert told_steps(drawing(), (3, 7, 1000)) == [3, 7]
    before = 0.0
    for tick in ticks:
        assert tick.time >= before
        before = tick.time


def test_a_lift_off_that_cannot_be_seen_on_the_sheet_is_not_told() -> None:
    at_rest = {name: frame(0).points["D1"] * 0.0 for name in ("P1", "P1'", "D1")}
    at_rest |= dict.fromkeys(("P2", "P2'", "D2"), PLANES[1].displacement.origin)
    frames = list(drawing().frames)
    frames[2] = replace(frame(2), points=at_rest, event="lift_off")
    frames[4] = replace(frame(4), points=at_rest, event="touchdown")
    told = told_steps(replace(drawing(), frames=tuple(frames)))
    assert {25, 40} <= set(told)
    assert not {2, 4} & set(told)


def test_the_present_stage_has_an_arrow_and_is_in_the_units_of_the_axes() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    stays = pages_of(Content("quarter car", made))[0]
    ticks = list(story_of(stays, arms_page(made), {}, (12,)))
    stages = made.schemes["contact"].stages
    told = [tick.text.split("\n\n") for tick in ticks if tick.step == 12]
    assert len(told) == len(stages)
    for i, (stage, (_, listed)) in enumerate(zip(stages, told, strict=True)):
        assert listed.split("\n")[i].startswith(f"- **→ {i + 1}: {markdown(typeset(stage))}**")
    unit, factor = stays.units["wheel_displacement"]
    value = factor * made.frames[12].readings["wheel_displacement"]
    assert f"y₂ = {value:.4g} {unit}" in told[0][1]


@pytest.mark.parametrize(("share", "follows"), [(1.0, True), (0.0, False)])
def test_a_story_tells_at_its_end_whether_the_construction_follows_the_run(
    share: float, follows: bool
) -> None:
    """A run with a share of the motion: all of it, or none."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    of_body = ("suspension_deflection", "suspension_deflection_rate")
    names = (*of_body, "wheel_displacement", "wheel_velocity")
    run = share * readings(made.frames, names).T
    compared = compare_with_motion(made, list(made.frames.times), *run.tolist())
    stays = pages_of(Content("quarter car", compared))[0]
    *_, last = story_of(stays, arms_page(compared), {}, (12,))
    assert "Largest drift from the run: y₁ " in last.text
    assert ("has left the run" in last.text) is not follows


def test_what_is_laid_off_says_which_way_and_mean_excitations_are_told() -> None:
    """On the road by its mean height; in flight by the weight, against the axis of the wheel."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    units = {plane.name: ("cm", 100.0) for plane in made.planes}
    for frame_ in made.frames:
        scheme = made.schemes[frame_.scheme]
        told = [measured(made, frame_, stage, units) for stage in range(len(scheme.stages))]
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


def test_the_empty_sheet_tells_scales_and_frequencies() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    first = next(story_of(pages_of(Content("quarter car", made))[0], arms_page(made), {}))
    one, two = (f"{plane.angular_frequency:.4g}" for plane in made.planes)
    scales = "Scales: y₁ 1 : 1 (a), y₂ 2.5 : 1 (b)"
    assert f"{scales}; Ω₁ = {one} rad/s, Ω₂ = {two} rad/s." in first.text


def test_a_story_tells_the_jump_of_a_road_and_no_rest() -> None:
    made = draw_construction(
        "QuarterCar",
        load_scene("kerb").all_parameters,
        asdict(load_scene("kerb").construction),
        1.5,
    )
    told = told_steps(made)
    assert any("jolt" in made.frames.events.get(i, "") for i in told)
    size = [abs(f.points["P2'"] - f.points["P2"]) for f in made.frames]
    quiet = [i for i in told if i not in made.frames.events and size[i] < 0.001 * max(size)]
    assert len(quiet) <= 1


def test_arrows_at_the_rim_come_with_their_letters() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=20)
    stays = pages_of(Content("quarter car", made))[0]
    step = next(f.step for f in made.frames if not stays.view.holds(f.points["D1"]))
    ticks = [t for t in story_of(stays, arms_page(made), {}, (step,)) if t.step == step]
    for tick in ticks:
        named = {text.point for text in tick.page.texts if text.text.startswith("D")}
        arrows = {a.start for a in tick.page.of(Arrow) if a.role == "normal"}
        assert arrows <= named
    assert not ticks[0].page.of(Arrow)  # the feet are not drawn yet
    assert any(a.role == "normal" for a in ticks[-1].page.of(Arrow))
    value = 100.0 * made.planes[0].displacement.read(made.frames[step].points["D1"])
    led = {text.text for text in ticks[-1].page.texts}
    assert f"D₁ at {value:.3g} cm".replace("-", "\N{MINUS SIGN}") in led


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


@pytest.mark.parametrize("name", ["permanent_set", "displacement", "wheel_displacement"])
@pytest.mark.parametrize("number", range(4))
def test_a_column_has_the_same_hue_in_the_chart_and_in_the_plots(name: str, number: int) -> None:
    role = part_of(name) or list(PARTS)[number]
    assert style_of(role).hue == hue_of(name, number)


def test_a_story_computes_the_ways_of_its_motion_once(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[object] = []
    ways = subject.paths_of
    monkeypatch.setattr(subject, "paths_of", lambda *of: (computed.append(1), ways(*of))[1])
    stays = pages_of(content())[0]
    ticks = list(story_of(stays, stays.following(), {}))
    assert len(ticks) > 20
    assert len(computed) == 1


def test_what_is_long_past_is_faint_in_a_story() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=500)
    stays = pages_of(Content("quarter car", made))[0]
    *_, last = story_of(stays, arms_page(made), {}, (12, 490))
    past, recent = (i for i in last.page.items if isinstance(i, Lines) and i.role == "trail")
    assert past.weight < 0.5 * recent.weight
    assert past.strength < 0.6 * recent.strength
    assert [strip[-1] for strip in past.strips] == [strip[0] for strip in recent.strips]


def test_a_long_motion_stays_smooth_in_a_story() -> None:
    spring = EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0)
    made = construct_motion(spring, delta, step=0.5, steps=1000)
    stays = pages_of(Content("spring", made))[0]
    *_, last = story_of(stays, arms_page(made), {}, (5,))
    radius = abs(stays.subject.motions[0][0])
    past, recent = (s for i in last.page.of(Lines) if i.role == "trail" for s in i.strips)
    for strip in (past, recent):
        assert max(abs(radius - abs(np.add(strip[1:], strip[:-1]) / 2.0))) < 0.02 * stays.em
    assert len(past) + len(recent) < 12_000


@pytest.mark.slow
@given(st.lists(st.complex_numbers(max_magnitude=1e3), min_size=2, max_size=200), st.integers(2, 9))
@example([2e-313, 0j, 0j], 2)
def test_a_thinned_curve_has_few_vertices_and_both_ends(points: list[complex], most: int) -> None:
    kept = telling_vertices(np.array(points), 1e-3, most)
    assert len(kept) <= most
    assert (kept[0], kept[-1]) == (0, len(points) - 1)
    assert (np.diff(kept) > 0).all()


def test_a_thinned_curve_keeps_its_corners() -> None:
    square = np.concatenate([1j**k * (1 - 1j + 2j * np.linspace(0, 1, 50)) for k in range(4)])
    kept = square[telling_vertices(square, 1e-6, 1000)]
    assert all(abs(kept - 1j**k * (1 + 1j)).min() < 1e-9 for k in range(4))
    assert len(kept) < 20


def test_the_letters_of_a_stage_leave_its_moving_points_free() -> None:
    ticks = list(story_of(stays := pages_of(content())[0], arms_page(drawing()), {}))
    for tick in ticks:
        rings = [
            z for dots in tick.page.of(Dots) if dots.role == MOVING_POINT[0] for z in dots.points
        ]
        for text, ring in product(tick.page.texts, rings):
            assert abs(text.box(stays.em).nearest(ring) - ring) > 0.5 * stays.em, text.text


@pytest.mark.parametrize(
    ("words", "letters"),
    [("cuts line I", "A₁* B₂ C₁ C₂ Q₁ Q₂ D₁ D₂"), ("turned about Dₘ", "Dₘ₁ Dₘ₂ P₁ P₂ P₁′ P₂′")],
)
def test_a_stage_letters_the_points_from_which_it_is_drawn(words: str, letters: str) -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=62)
    stays = pages_of(Content("quarter car", made))[0]
    ticks = story_of(stays, arms_page(made), {}, (7,))
    (tick,) = (tick for tick in ticks if words in tick.caption)
    assert set(letters.split()) <= {text.text for text in tick.page.texts}


def test_letters_far_from_their_points_are_led_on_a_screen() -> None:
    """In a window twice as large, with type of the same size, they are twice as far away."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=62)
    stays = pages_of(Content("quarter car", made))[0]
    for tick in story_of(stays, arms_page(made), {}):
        for text in (t for t in tick.page.texts if t.kind == "letter" and not t.led):
            assert text.point is not None
            gap = abs(text.box(stays.em).nearest(text.point) - text.point)
            assert gap < 0.4 * stays.em, text.text


@pytest.mark.parametrize("run", [0.1, 0.5])
def test_the_end_of_a_construction_says_whether_its_run_goes_on(run: float) -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=40)
    told = end_text(made, {}, run)
    assert told.startswith("**The construction ends** at t = 0.10000 s")
    assert ("; the run goes on to 0.5 s, in violet." in told) is (run > 0.1)


def test_rounding_is_measured_as_zero() -> None:
    made = construct_motion(
        EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0, initial_velocity=1e-16),
        delta, step=0.1, steps=1,
    )  # fmt: skip
    told = protocol(made, made.frames[0], 0, {"displacement": ("", 1.0)})
    assert "QP = 0 cm: ẋ = 0 1/s" in told


@pytest.mark.parametrize(("kind", "letter"), LETTER_OF_EVENT.items())
def test_the_sentence_of_an_event_names_its_letter(kind: str, letter: str) -> None:
    assert event_text(Event(kind, kind, "", ())).endswith(f"({letter}).")


def test_there_is_no_negative_zero() -> None:
    assert number(-0.0) == "0"


@pytest.mark.parametrize(
    ("value", "text"), [(11_512.3, "11510"), (-2.0061e-05, "\u22120.00002006"), (3.0e7, "30000000")]
)
def test_numbers_are_printed_without_exponents(value: float, text: str) -> None:
    assert number(value, 4) == text
    (force,) = (q for q in QUANTITIES if q.name == "force")
    assert f"| {text} " in readings_table({"contact_force": value}, {"contact_force": force})


def test_the_end_of_a_motion_stands_out_from_its_trail() -> None:
    made = drawing()
    *_, last = story_of(pages_of(content())[0], arms_page(made), {})
    ends = [motion[-1] for motion in last.page.subject.motions]
    discs = {dots.role: list(dots.points) for dots in last.page.of(Dots)}
    assert [discs.get(role) for role in MOVING_POINT] == [ends] * len(MOVING_POINT)


def made_of(case: str, duration: float) -> Drawing:
    """Return the first part of the construction of a case."""
    scene = load_scene(case)
    return draw_construction(
        scene.fmu.model, scene.all_parameters, asdict(scene.construction), duration
    )


@pytest.mark.parametrize(
    ("case", "duration", "step"), [("half_car_pitch", 0.25, 61), ("speed_bump_20", 0.2, 20)]
)
def test_texts_of_a_sheet_can_be_told_to_belong_where_they_stand(
    case: str, duration: float, step: int
) -> None:
    made = made_of(case, duration)
    page = step_page(made, made.frames[step], PLAIN)
    lines = {curve.label: curve for curve in made.curves if curve.role == "line"}
    named = {text.text: text.centre.imag for text in page.texts if text.role == "line"}
    assert set(named) == set(map(typeset, lines))
    levels = {typeset(label): curve.vertices[0].imag for label, curve in lines.items()}
    levels |= {f"axis {plane.number}": plane.displacement.origin.imag for plane in made.planes}
    for name, height in named.items():
        assert min(levels, key=lambda of: abs(levels[of] - height)) == name
    steps = step_lines(page, made.frames[step])
    fixed = segments_of(c.vertices for c in made.curves if c.role in ("auxiliary", "line"))
    for text in page.texts:
        plate = text.box(page.em).grown(PLATE * page.em)
        around_it = Boxes(np.array(plate.centre), np.array(plate.half))
        if text.kind == "name":
            assert around_it.inside(*steps.T).sum() == 0.0
        if text.role == "auxiliary" or text.kind == "name":
            assert around_it.inside(*fixed.T).sum() < 0.01 * page.em  # their ends may touch it
        others = [other.box(page.em) for other in page.texts if other is not text]
        assert not any(plate.overlap(other) for other in others)


@pytest.mark.parametrize("start", [0.98, 1.14])
def test_a_y_axis_has_values_on_both_sides_of_a_motion_that_covers_it(start: float) -> None:
    """As on a random road; the others have no place there, nor has a value just beyond."""
    swing = EquationPlane(lambda v, x, t: x + 0.01 * v, True, initial_displacement=start)
    made = construct_motion(swing, delta, step=0.1, steps=1000)
    page = pages_of(Content("c", made))[0]
    (motion,) = page.subject.motions
    values = [t.centre.real for t in page.texts if t.kind == "value" and abs(t.centre.imag) < 0.01]
    assert min(values) < motion.real.min()
    assert max(values) > motion.real.max()


def test_turn_angles_are_named_and_their_arm_has_a_unit() -> None:
    four = made_of("half_car_pitch", 0.02)
    two, flat = (construct_motion(ap57(), delta, step=h, steps=10) for h in (0.0025, 0.00025))
    pair = ["Δτ₁", "Δτ₂"]
    for made, wanted in ((two, pair), (flat, pair), (four, ["Δτ₁₁, Δτ₂₁", "Δτ₁₂, Δτ₂₂"])):
        page = arms_page(made)
        assert [text.text for text in page.texts if "τ" in text.text] == wanted
        assert sum(text.text.endswith(" cm") for text in page.texts) == 1
        assert page.view.half.real / page.em <= 7.0  # half of a pane of 230 pixels
        boxes = [text.box(page.em) for text in page.texts]
        assert all(one.overlap(other) == 0.0 for one, other in combinations(boxes, 2))
        assert all(page.view.contains(box) for box in boxes)


def test_only_turn_angles_are_on_their_arm_which_fills_its_view() -> None:
    """Also where the planes are so close that their arm is near the motion."""
    made = construct_motion(replace(ap57(), plane_distance=0.03), delta, step=0.0025, steps=20)
    arms = arms_page(made)
    on_arm = [z for c in made.curves if c.role in ("axis", "construction") for z in c.vertices]
    around_arm = around(on_arm, 0.01)
    assert around_arm.half.real > 0.6 * arms.view.half.real
    drawn = [t.arms for t in story_of(pages_of(Content("c", made))[0], arms, {})]
    ends = [z for page in drawn for lines in page.of(Lines) for s in lines.strips for z in s]
    assert len(ends) > 20
    assert all(around_arm.holds(complex(z)) for z in ends)


def test_rounding_is_read_off_as_zero() -> None:
    read = {"wheel_displacement": -0.0, "wheel_velocity": 4.2e-21, "wheel_acceleration": -1.5e-16}
    table = readings_table(read, dict.fromkeys(read))
    assert table.splitlines()[-1] == "| wheel | 0 | 0 | 0 |"


def test_a_drift_is_read_off_in_its_unit() -> None:
    names = [f"wheel_{part}" for part in ("displacement", "velocity", "acceleration")]
    read = dict.fromkeys((*names, "wheel_displacement_drift"), 0.01)
    head, _, row = readings_table(read, {name: quantity_of(name) for name in read}).splitlines()
    assert head == "| read off the sheet | cm | m/s | m/s² | drift, cm |"
    assert row == "| wheel | 1 | 0.01 | 0.01 | 1 |"


@given(strength=st.floats(0.1, 0.9), hue=st.sampled_from(list(PARTS.values())))
def test_weak_lines_stand_out_less_on_any_ground(*, strength: float, hue: Hue) -> None:
    weak = rgba(hue, strength)
    assert weak & 255 == 255  # the viewer does not blend lines with their ground
    shade = f"#{weak >> 8:06x}"
    for ground in (PAPER.light, PAPER.dark):
        assert contrast(shade, ground) < 1.1 * contrast(hue.on("either"), ground)
    red, green, blue = (int(shade[i : i + 2], 16) for i in (1, 3, 5))
    full = [int(hue.on("either")[i : i + 2], 16) for i in (1, 3, 5)]
    assert np.ptp([red, green, blue]) < np.ptp(full)


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
    record(Content(strange, odd, times), tmp_path / "f.rrd")
    texts = [text for text in Recorded(tmp_path / "f.rrd").words() if "a?b" in text]
    assert len(texts) >= 5
    assert all(text == legible(text) for text in Recorded(tmp_path / "f.rrd").words())


def test_what_the_viewer_can_show_is_kept() -> None:
    kept = "x\N{SUBSCRIPT TWO} \N{GREEK CAPITAL LETTER OMEGA} \N{MINUS SIGN}1 A1*'\n"
    assert legible(kept) == kept
    assert legible("\u03be\N{COMBINING DIAERESIS}/\u03a9") == "\u03be\N{DOUBLE PRIME}/\u03a9"
    assert legible("y\N{COMBINING MACRON}") == "\N{LATIN SMALL LETTER Y WITH MACRON}"


def luminance(colour: str) -> float:
    """The relative luminance of a colour #rrggbb, from 0 (black) to 1 (white)."""
    red, green, blue = (
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        for c in (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    """The contrast of two colours, from 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


HUES = {**{r: s.hue for r, s in ROLES.items() if r not in ("halo", "here")}, **PARTS}


@pytest.mark.parametrize("name", HUES)
def test_hues_stand_out_on_their_ground(name: str) -> None:
    hue: Hue = HUES[name]
    assert contrast(hue.light, PAPER.light) >= 4.5
    assert contrast(hue.dark, PAPER.dark) >= 4.5
    assert min(contrast(hue.on("either"), g) for g in (PAPER.light, PAPER.dark)) >= 4.0
    assert INK.on("light") == INK.light


def test_the_moving_point_stands_out_on_any_ground() -> None:
    halo, here, state = (style_of(role) for role in MOVING_POINT)
    assert halo.size > here.size > 1.3 * state.size
    for ground in (PAPER.light, PAPER.dark):
        assert max(contrast(disc.hue.on("either"), ground) for disc in (halo, here)) >= 12.0
    assert contrast(state.hue.on("either"), here.hue.on("either")) >= 4.0


def test_the_ring_does_not_hide_the_step() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    stays = pages_of(Content("quarter car", made))[0]
    told = [t.page for t in story_of(stays, arms_page(made), {}, (12,)) if t.step == 12]
    ringed = [any(dots.role == "halo" for dots in page.of(Dots)) for page in told]
    assert ringed == [True] * (len(told) - 1) + [False]
