"""The sheet of a picture: ticks, arcs, curves, the arm of the turn angles, and where texts stand."""

from __future__ import annotations

import cmath
from dataclasses import asdict, replace
from itertools import combinations
from math import pi

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene
from worked_example import ap57

from phaseplane import exercises
from phaseplane.constructions import Axis, Drawing, EquationPlane, construct_motion, delta
from phaseplane.constructions.letters import typeset
from phaseplane.figures.planes import step_lines, step_page
from phaseplane.figures.style import PLAIN, Look
from phaseplane.picture.axes import graduation_of
from phaseplane.picture.frames import table
from phaseplane.picture.letters import PLATE
from phaseplane.picture.page import Arrow, Lines
from phaseplane.picture.paper import Box, arcs, around, segments_of, telling_vertices
from phaseplane.picture.quantities import display_unit
from phaseplane.picture.step import write_letters
from phaseplane.picture.story import arms_page, story_of
from phaseplane.picture.views import gathered
from phaseplane.recording import Content
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
        around_it = Box(np.array(plate.centre), np.array(plate.half))
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


def test_axes_of_planes_below_each_other_do_not_meet() -> None:
    """Where the values that follow the motions of both planes would: after a kerb."""
    page = pages_of(Content("up a kerb", made_of("kerb", 0.25)))[0]
    upper, lower = (a for a in page.of(Arrow) if a.start.real == a.tip.real)
    assert upper.start.imag > lower.tip.imag + 0.3 * page.em
    for axis, plane, motion in zip((upper, lower), page.drawing.planes, page.subject.motions,
                                   strict=True):  # fmt: skip
        assert axis.start.imag <= motion.imag.min()
        assert axis.tip.imag >= motion.imag.max()
        assert axis.start.real == plane.scaled_velocity.origin.real


def test_an_axis_passes_the_middle_between_planes_where_the_other_leaves_room() -> None:
    """After a plank: else the greatest value of the lower plane would be missing."""
    page = pages_of(Content("over a plank", made_of("plank", 0.4)))[0]
    upper, lower = (a for a in page.of(Arrow) if a.start.real == a.tip.real)
    above, below = page.subject.motions
    middle = (above.imag.min() + below.imag.max()) / 2.0
    assert middle < lower.tip.imag < upper.start.imag
    axis = page.drawing.planes[1].scaled_velocity
    ticks = [np.mean(strip) for lines in page.of(Lines) if lines.role == "axis"
             for strip in lines.strips]  # fmt: skip
    assert any(abs(z.real - axis.origin.real) < 1e-9 and z.imag > below.imag.max() for z in ticks)


@pytest.mark.slow
def test_the_name_of_an_upright_axis_stands_nearest_to_it_on_a_tiny_sheet() -> None:
    """As in a storyboard in a column, where the names of two axes stood the wrong way round."""
    made = made_of("half_car_rigid_tyres", 4.0)
    page = step_page(made, made.frames[32], Look(width=0.0425))
    axes = [Box((a.start + a.tip) / 2.0, (a.tip - a.start) / 2.0)
            for a in page.of(Arrow) if a.start.real == a.tip.real]  # fmt: skip
    for plane, own in zip(made.planes, axes, strict=True):
        short = typeset(plane.scaled_velocity.label).partition(" =")[0]
        (name,) = (text.box(page.em) for text in page.texts if text.text.startswith(short))
        assert own.gap(name) == min(axis.gap(name) for axis in axes)


def test_the_name_of_an_axis_leaves_the_motion_free_on_a_narrow_sheet() -> None:
    """Of a frame that yields: its state moves up and right from the axis, where the name would stand."""
    made = made_of("h83_example40", 0.8)
    page = step_page(made, made.frames[5], Look(width=0.085))
    (motion,) = page.subject.motions
    names = [text.box(page.em) for text in page.texts if text.kind == "name"]
    assert len(names) == 2
    ways = np.stack([motion[:-1], motion[1:]])
    for name in names:
        assert not name.inside(*ways).any()


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


@pytest.mark.parametrize("exercise", [False, True])
def test_auxiliary_curves_end_above_the_turn_angles_of_a_sheet(*, exercise: bool) -> None:
    """And reach as far as they are used."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=10)
    shown = exercises.gathered(made) if exercise else gathered(made, made.frames)[0]
    arms = [z.imag for c in shown.curves if c.role == "construction" for z in c.vertices]
    curves = [c.vertices for c in shown.curves if c.role == "auxiliary"]
    assert max(arms) < min(z.imag for vertices in curves for z in vertices)
    used = table(made.frames, ["A1", "A2"])
    for curve, points in zip(curves, used.T, strict=True):
        heights = [z.imag for z in curve]
        assert min(heights) <= points.imag.min() <= points.imag.max() <= max(heights)
        across = np.interp(points.imag, heights, [z.real for z in curve])
        assert across == pytest.approx(points.real, abs=1e-9)


def test_only_turn_angles_are_on_their_arm_which_fills_its_view() -> None:
    """Also where the planes are so close that their arm is near the motion."""
    made = construct_motion(replace(ap57(), plane_distance=0.03), delta, step=0.0025, steps=20)
    arms = arms_page(made)
    on_arm = [z for c in made.curves if c.role in ("axis", "construction") for z in c.vertices]
    around_arm = around(on_arm, 0.01)
    assert around_arm.half.real > 0.6 * arms.view.half.real
    drawn = [t.arms for t in story_of(pages_of(Content("c", made))[0], arms)]
    ends = [z for page in drawn for lines in page.of(Lines) for s in lines.strips for z in s]
    assert len(ends) > 20
    assert all(around_arm.holds(complex(z)) for z in ends)


@pytest.mark.slow
def test_a_plane_at_rest_is_lettered_at_its_state_point_only() -> None:
    drawn = construct_motion(ap57(), delta, step=0.0025, duration=0.025)
    lettered = []
    for frame in (drawn.frames[0], drawn.frames[8]):
        page = step_page(drawn, frame, PLAIN)
        write_letters(page, frame)
        lettered.append({text.text for text in page.texts if text.kind == "letter"})
    assert lettered[0] & {"P₁", "P₂", "Q₁", "Q₂", "A₁", "A₂", "O₁", "O₂"} == {"P₁", "P₂"}
    assert lettered[1] >= {"P₁", "P₂", "Q₁", "Q₂", "A₁", "A₂", "O₁", "O₂"}
