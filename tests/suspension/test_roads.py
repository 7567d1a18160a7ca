"""Roads: values, derivatives and joints against the formulas of AP57 and against differences."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from suspension import roads

ROADS = st.sampled_from(
    [
        roads.bump(0.05, 1.0, 20.0),
        roads.bump(-0.03, 0.4, 5.0, start=0.1),
        roads.obstacle(0.05, 1.0, 20.0, start=0.02),
        roads.sine(0.02, 3.0, 12.0),
        roads.table([(0.0, 0.0), (1.0, 0.05), (3.0, -0.01)], speed=10.0, start=0.05),
        roads.Signal(
            (roads.Segment(-float("inf"), 0.0, (0.01, 0.1, -0.2, 0.3), 0.04, (0.3, 20.0, 15.0)),)
        ),
    ]
)


@given(ROADS, st.floats(-0.05, 0.6))
def test_derivatives_are_those_of_the_value(road: roads.Signal, t: float) -> None:
    h = 1e-5
    if any(abs(t - joint) < 2 * h for joint in road.joints):
        return
    below, here, above = (road.derivatives(t + k * h) for k in (-1, 0, 1))
    for order in range(3):
        slope = (above[order] - below[order]) / (2 * h)
        assert slope == pytest.approx(here[order + 1], rel=1e-4, abs=1e-4 * 130.0**order)


def test_bump_is_one_minus_cosine() -> None:
    road = roads.bump(0.05, 1.0, 20.0)  # AP57 section 8: 2.5 (1 - cos 40 pi t) cm for 0.05 s
    for t in (0.0, 0.01, 0.025, 0.04):
        assert road.value(t) == pytest.approx(0.025 * (1 - cos(40 * pi * t)), abs=1e-17)
        assert road.rate(t) == pytest.approx(pi * sin(40 * pi * t), abs=1e-14)
    assert road.joints == pytest.approx((0.0, 0.05))
    assert road.value(0.06) == road.value(-1.0) == 0.0


def test_bump_starts_exactly_level_and_at_rest() -> None:
    # zero to the bit, so that a car at rest on its damper's corner stays there until the bump
    assert roads.bump(0.05, 1.0, 20.0, start=0.1).derivatives(0.1)[:2] == (0.0, 0.0)


def test_obstacle_has_three_pieces_of_constant_acceleration() -> None:
    height, duration = 0.05, 0.05
    z = 16.0 * height / duration**2  # AP57 eq. 9
    road = roads.obstacle(height, 1.0, 20.0)
    for t, sign in ((0.005, 1), (0.02, -1), (0.03, -1), (0.045, 1)):
        assert road.acceleration(t) == pytest.approx(sign * z)
    assert road.value(duration / 2) == pytest.approx(height)
    assert road.value(duration / 8) == pytest.approx(8 * height / duration**2 * (duration / 8) ** 2)


@given(ROADS)
def test_elevation_is_continuous_at_joints(road: roads.Signal) -> None:
    for left, right in pairwise(road.segments):
        assert left.derivatives(right.start)[0] == pytest.approx(
            right.derivatives(right.start)[0], abs=1e-15
        )


def test_bump_and_obstacle_join_with_equal_slope() -> None:
    for road in (roads.bump(0.05, 1.0, 20.0), roads.obstacle(0.05, 1.0, 20.0)):
        for left, right in pairwise(road.segments):
            assert left.derivatives(right.start)[1] == pytest.approx(
                right.derivatives(right.start)[1], abs=1e-12
            )


@given(ROADS, st.floats(0.0, 0.5), st.floats(0.0, 1.0))
def test_the_rear_axle_meets_the_same_road_later(
    road: roads.Signal, t: float, delay: float
) -> None:
    if any(abs(t - joint) < 1e-9 for joint in road.joints):
        return
    assert road.delayed(delay).derivatives(t + delay) == pytest.approx(
        road.derivatives(t), rel=1e-7, abs=1e-6
    )


def test_table_holds_its_ends_and_goes_straight_between() -> None:
    road = roads.table([(0.0, 0.01), (2.0, 0.05)], speed=10.0, start=1.0)
    assert road.value(0.0) == 0.01
    assert road.value(1.1) == pytest.approx(0.03)
    assert road.value(9.0) == 0.05
    assert road.rate(1.1) == pytest.approx(0.2)


@pytest.mark.parametrize("points", [[], [(0.0, 0.0), (0.0, 1.0)], [(1.0, 0.0), (0.5, 1.0)]])
def test_an_unusable_table_is_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="table"):
        roads.table(points)
