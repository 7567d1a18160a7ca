"""Letters of a picture: placed in view, apart from each other, near their points or led to them."""

from __future__ import annotations

import cmath
from itertools import combinations, permutations, product
from math import pi

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from recorded import drawing, sheet_and_story
from worked_example import ap57

from phaseplane.constructions import construct_motion, delta
from phaseplane.picture.letters import NEAR, place, text_box
from phaseplane.picture.page import Dots, Text
from phaseplane.picture.paper import Box
from phaseplane.picture.story import arms_page, story_of
from phaseplane.picture.styles import MOVING_POINT
from phaseplane.recording import Content
from phaseplane.recording.motion import pages_of


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
    centres, gaps, free = place(points, texts, em, view, np.zeros((0, 2), complex))
    boxes = [text_box(c, t, em) for c, t in zip(centres, texts, strict=True)]
    assert all(one.overlap(other) == 0.0 for one, other in combinations(boxes, 2))
    assert free.all()
    assert all(view.contains(box) for box in boxes)
    for point, box, gap in zip(points, boxes, gaps, strict=True):
        assert gap > NEAR or abs(box.nearest(point) - point) <= NEAR * em


def test_a_letter_that_has_no_place_in_view_is_not_free() -> None:
    """Storyboards in the width of a column had letters beyond their edge, cut off."""
    em, view = 0.04, Box(0j, 0.3 + 0.05j)
    nothing, there = np.zeros((0, 2), complex), [Box(0j, 0.3 + 0.05j)]
    centres, _, free = place(np.array([0.28 + 0.01j]), ["A1*"], em, view, nothing, there)
    assert not view.contains(text_box(centres[0], "A1*", em))
    assert not free.any()


@given(angle=st.floats(0.0, 2.0 * pi), distance=st.floats(0.2, 3.0))
def test_a_letter_is_nearer_to_its_point_than_to_others(angle: float, distance: float) -> None:
    em, other = 0.04, 0.04 * cmath.rect(distance, angle)
    view, nothing = Box(0j, 1 + 1j), np.zeros((0, 2))
    (centre,), *_ = place(np.zeros(1, complex), ["P"], em, view, nothing, others=[other])
    assert abs(centre) < abs(centre - other)


def test_letters_of_a_stage_are_nearer_to_their_points_than_to_others() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, duration=0.1)
    stays = pages_of(Content("quarter car", made))[0]
    stays.unled = NEAR
    ticks = [tick.page for tick in story_of(stays, arms_page(made))]
    letters = [[t for t in page.of(Text) if t.kind == "letter" and not t.led] for page in ticks]
    nearer = [
        abs(one.centre - other.point) > abs(one.centre - one.point) - 1e-9
        for several in letters
        for one, other in permutations(several, 2)
        if one.point is not None and other.point is not None
    ]
    assert nearer.count(False) < 0.013 * len(nearer)


def test_the_letters_of_a_stage_leave_its_moving_points_free() -> None:
    stays, ticks = sheet_and_story(drawing())
    for tick in ticks:
        rings = [
            z for dots in tick.page.of(Dots) if dots.role == MOVING_POINT[0] for z in dots.points
        ]
        for text, ring in product(tick.page.texts, rings):
            assert abs(text.box(stays.em).nearest(ring) - ring) > 0.5 * stays.em, text.text


def test_letters_far_from_their_points_are_led_on_a_screen() -> None:
    """In a window twice as large, with type of the same size, they are twice as far away."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=62)
    stays, ticks = sheet_and_story(made)
    for tick in ticks:
        for text in (t for t in tick.page.texts if t.kind == "letter" and not t.led):
            assert text.point is not None
            gap = abs(text.box(stays.em).nearest(text.point) - text.point)
            assert gap < 0.4 * stays.em, text.text
