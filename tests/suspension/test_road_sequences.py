"""Roads one after the other, as the public parameters write them."""

from __future__ import annotations

import pytest
from phaseplane.suspension import roads
from phaseplane.suspension.models import build
from phaseplane.suspension.parts import road_from
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import ParameterError, checked_parameters


def road(text: str, **more: object) -> roads.Signal:
    given = {"road.shape": "sequence", "road.sequence": text, "speed": 10.0, **more}
    return road_from(checked_parameters("QuarterCar", given))


def test_a_sequence_is_that_of_its_parts() -> None:
    found = road("bump 0.05 1, gap 3, plank 0.03 0.5 0.1, step -0.02, gap 1, gap 0.5, sine 0.01 2")
    parts = [
        roads.bump(0.05, 1.0, 10.0), roads.plank(0.03, 0.5, 10.0, 0.0, 0.1, 0.1),
        roads.step(-0.02), roads.sine(0.01, 2.0, 10.0),
    ]  # fmt: skip
    expected = roads.sequence(parts, [3.0, 0.0, 1.5], 10.0)
    assert found == expected
    assert found.joints == pytest.approx((0.0, 0.1, 0.4, 0.41, 0.44, 0.45, 0.6))
    # by hand: the middle of the bump, the top of the plank, the lower level after it
    assert found.value(0.05) == pytest.approx(0.05)
    assert found.value(0.42) == pytest.approx(0.03)
    assert found.value(0.55) == pytest.approx(-0.02)


def test_a_gap_before_the_first_part_and_the_start_delay_it() -> None:
    assert road("gap 2, bump 0.05 1", **{"road.start": 0.5}).joints == pytest.approx((0.7, 0.8))
    assert road(" gap 2 ,  ramp 0.05 1, gap 4").joints == pytest.approx((0.2, 0.3))


def test_the_rear_axle_follows_on_the_same_sequence() -> None:
    p = {"road.shape": "sequence", "road.sequence": "bump 0.05 1, gap 2, pothole 0.04 1 0.2"}
    system = build("HalfCar", p | {"speed": 10.0, "cg_to_front": 1.0, "cg_to_rear": 1.5})
    front, rear = system.signals["front_road"], system.signals["rear_road"]
    for t in (0.05, 0.33, 0.36, 0.5):
        assert rear.value(t + 0.25) == pytest.approx(front.value(t), abs=1e-15)


def test_two_obstacles_far_apart_do_the_same_twice() -> None:
    times = [0.0, 0.1, 20.1]  # at rest again in between
    p = {"road.shape": "sequence", "road.sequence": "bump 0.03 1, gap 199, bump 0.03 1"}
    found = simulate("QuarterCar", p | {"speed": 10.0}, times, ["wheel_displacement"])
    _, first, second = found["wheel_displacement"]
    assert second == pytest.approx(first, abs=1e-8)
    assert abs(float(first)) > 1e-3


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "'' is unknown"),
        ("bmup 1 2", "'bmup 1 2' is unknown; .* gap with numbers in m.*; did you mean 'bump'"),
        ("bump 0.05", "'bump 0.05' must be bump with 2 finite numbers in m"),
        ("bump 0.05 one", "'bump 0.05 one' must be bump with 2 finite numbers"),
        ("bump nan 1", "'bump nan 1' must be bump with 2 finite numbers"),
        ("bump 0.05 1, gap inf, step 0.1", "'gap inf' must be gap with 1 finite number in m"),
        ("step 1 2", "'step 1 2' must be step with 1 finite number in m"),
        ("plank 1", "plank with 2 or 3 finite numbers"),
        ("bump 0.05 -1", "'bump 0.05 -1': a length of road must be positive"),
        ("plank 0.05 1 0.6", "do not fit on 1 m"),
        ("gap 1", "at least one road"),
        ("step 6e8, step 6e8", r"road.sequence: is 1.2e\+09 m high; at most 1e\+09 m are allowed"),
        ("bump 0.05 1, gap -1, bump 0.05 1", "must not be negative"),
        ("sine 0.05 1, bump 0.05 1", "road 1 of the sequence has no beginning or end"),
    ],
)
def test_what_is_no_sequence_is_refused(text: str, complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        road(text)
