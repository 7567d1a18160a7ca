"""Roads: values, derivatives and joints against the formulas of AP57 and against differences."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin, sqrt
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from phaseplane.suspension import roads
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.signal import chirp, welch

MEASURED = [(0.0, 0.0), (0.7, 0.02), (1.0, 0.05), (1.9, 0.01), (3.0, -0.01)]
SMOOTH = [
    roads.bump(0.05, 1.0, 20.0),
    roads.bump(-0.03, 0.4, 5.0, start=0.1),
    roads.obstacle(0.05, 1.0, 20.0, start=0.02),
    roads.sine(0.02, 3.0, 12.0),
    roads.sweep(0.02, 1.0, 12.0, 0.4, start=0.05),
    roads.wave_length_sweep(0.02, 1.0, 4.0, 5.0, 12.0),
    roads.ramp(-0.1, 0.5, 8.0, start=0.03),
    roads.plank(0.04, 1.0, 9.0, 0.1, up_length=0.2, down_length=0.3),
    roads.pothole(0.04, 1.0, 9.0, 0.1, 0.5, 0.5),
    roads.table([(0.0, 0.0), (1.0, 0.05), (3.0, -0.01)], speed=10.0, start=0.05),
    roads.spline(MEASURED, speed=8.0, start=0.05),
    roads.spline(MEASURED, speed=8.0, ends="level"),
    roads.random_profile("C", 5.0, 10.0, 3, band=(0.05, 1.0)),
    roads.sequence(
        [
            roads.bump(0.05, 1.0, 20.0),
            roads.ramp(0.03, 0.5, 20.0),
            roads.obstacle(-0.04, 1.0, 20.0),
        ],
        [2.0, 0.0],
        20.0,
        0.02,
    ),
    roads.Signal(
        (roads.Segment(-float("inf"), 0.0, (0.01, 0.1, -0.2, 0.3), 0.04, (0.3, 20.0, 15.0)),)
    ),
]
ABRUPT = [
    roads.step(0.05, start=0.2),
    roads.plank(0.03, 1.0, 5.0, start=0.1),
    roads.pothole(0.03, 1.0, 5.0, start=0.1, up_length=0.4),
]
ROADS = st.sampled_from([*SMOOTH, *ABRUPT])
PARTS = st.sampled_from([road for road in (*SMOOTH, *ABRUPT) if road.segments[-1].level])


@given(ROADS, st.floats(-0.05, 0.6))
def test_derivatives_are_those_of_the_value(road: roads.Signal, t: float) -> None:
    h = 1e-5
    assume(all(abs(t - joint) >= 2 * h for joint in road.joints))
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


@pytest.mark.parametrize("road", [*SMOOTH, *ABRUPT])
def test_elevation_is_continuous_but_for_the_declared_jumps(road: roads.Signal) -> None:
    heights = dict(road.jumps)
    assert set(heights) <= set(road.joints)
    for left, right in pairwise(road.segments):
        t = right.start
        rise = right.derivatives(t)[0] - left.derivatives(t)[0]
        assert rise == pytest.approx(heights.get(t, 0.0), abs=2e-15)


@pytest.mark.parametrize("road", SMOOTH)
def test_rounding_is_not_taken_for_a_jump(road: roads.Signal) -> None:
    for delay in (0.0, 0.1, 1234.5, 1e6):
        assert road.delayed(delay).jumps == ()


def test_a_jump_far_below_the_elevation_is_still_one() -> None:
    (first, *rest) = roads.bump(0.05, 1.0, 20.0).segments
    raised = rest[-1]._replace(coefficients=(1e-12, 0.0, 0.0, 0.0))
    ((t, height),) = roads.Signal((first, *rest[:-1], raised)).jumps
    assert (t, height) == pytest.approx((0.05, 1e-12), rel=1e-4)


def test_a_road_that_takes_beyond_all_time_has_joints() -> None:
    """At a speed at which the square of its time is no number."""
    assert roads.bump(0.05, 1.0, 1e-300).jumps == ()


@given(st.sampled_from(ABRUPT), st.floats(0.0, 100.0))
def test_a_delay_shifts_the_jumps(road: roads.Signal, delay: float) -> None:
    expected = [(t + delay, height) for t, height in road.jumps]
    assert expected
    assert np.array(road.delayed(delay).jumps) == pytest.approx(np.array(expected), abs=1e-12)


@pytest.mark.parametrize("road", [*SMOOTH, *ABRUPT])
def test_integral_is_that_of_the_value(road: roads.Signal) -> None:
    ends = [-0.1, *(t for t in road.joints if -0.1 < t < 0.6), 0.6]
    area = sum(quad(road.value, a, b, epsabs=1e-13)[0] for a, b in pairwise(ends))
    assert road.integral(-0.1, 0.6) == pytest.approx(area, abs=1e-12)
    assert road.integral(0.6, -0.1) == -road.integral(-0.1, 0.6)


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
    assume(all(abs(t - joint) >= 1e-9 for joint in road.joints))
    assert road.delayed(delay).derivatives(t + delay) == pytest.approx(
        road.derivatives(t), rel=1e-7, abs=1e-6
    )


def test_table_holds_its_ends_and_goes_straight_between() -> None:
    road = roads.table([(0.0, 0.01), (2.0, 0.05)], speed=10.0, start=1.0)
    assert road.value(0.0) == 0.01
    assert road.value(1.1) == pytest.approx(0.03)
    assert road.value(9.0) == 0.05
    assert road.rate(1.1) == pytest.approx(0.2)


@pytest.mark.parametrize(
    "points",
    [
        [],
        [(0.0, 0.0), (0.0, 1.0)],
        [(1.0, 0.0), (0.5, 1.0)],
        [(0.0, 0.0), (1.0, float("nan"))],
        [(0.0, 0.0), (float("inf"), 1.0)],
    ],
)
def test_an_unusable_table_is_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="table"):
        roads.table(points)
    with pytest.raises(ValueError, match="spline"):
        roads.spline(points)


def test_sweep_is_a_linear_chirp() -> None:
    road = roads.sweep(0.04, 2.0, 30.0, 1.5, start=0.2)
    t = np.linspace(0.0, 1.499, 200)
    expected = 0.02 * chirp(t, 2.0, 1.5, 30.0, phi=-90)
    assert [road.value(0.2 + one) for one in t] == pytest.approx(expected, abs=1e-12)
    assert road.value(0.1) == 0.0
    assert road.value(5.0) == pytest.approx(0.02 * sin(2 * pi * 16.0 * 1.5), abs=1e-12)


def test_sweep_by_wave_length_shows_these_waves_at_its_ends() -> None:
    # a sine has (rate / amplitude)^2 + ... = omega^2: read the local frequency off value and rate
    road = roads.wave_length_sweep(0.04, 5.0, 0.5, 60.0, 15.0, start=1.0)
    for t, length in ((1.0, 5.0), (5.0 - 1e-9, 0.5)):
        value, rate = road.value(t), road.rate(t)
        omega = abs(rate) / sqrt(0.02**2 - value**2)
        assert omega == pytest.approx(2 * pi * 15.0 / length, rel=1e-6)
    assert road.joints == pytest.approx((1.0, 5.0))


def test_ramp_and_step_lead_to_the_new_level() -> None:
    curb = roads.ramp(0.12, 0.3, 6.0, start=1.0)
    assert [curb.value(t) for t in (0.9, 1.025, 1.05, 9.0)] == pytest.approx([0, 0.06, 0.12, 0.12])
    assert curb.jumps == ()
    jump = roads.step(-0.12, start=1.0)
    assert jump.jumps == ((1.0, -0.12),)
    assert jump == roads.ramp(-0.12, 0.0, 6.0, start=1.0)
    assert (jump.value(0.999), jump.value(1.0)) == (0.0, -0.12)


def test_plank_and_pothole_are_mirror_images() -> None:
    plank = roads.plank(0.05, 2.0, 10.0, 1.0, up_length=0.5, down_length=1.0)
    pothole = roads.pothole(0.05, 2.0, 10.0, 1.0, down_length=0.5, up_length=1.0)
    assert plank.joints == pytest.approx((1.0, 1.05, 1.1, 1.2))
    for t, height in ((1.025, 0.025), (1.07, 0.05), (1.15, 0.025), (1.3, 0.0)):
        assert plank.value(t) == pytest.approx(height)
        assert pothole.value(t) == -plank.value(t)
    assert roads.plank(0.05, 2.0, 10.0, 1.0).jumps == ((1.0, 0.05), (1.2, -0.05))


@given(st.floats(0.05, 0.95), st.floats(0.01, 10.0))
def test_ramps_that_meet_leave_no_sliver_between_them(share: float, length: float) -> None:
    up = share * length
    road = roads.plank(0.05, length, 3.0, 0.1, up, length - up)
    assert all(b - a > 1e-13 for a, b in pairwise(road.joints))
    assert max(road.value(t) for t in road.joints) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda: roads.bump(0.05, 1.0, 0.0), "speed must be positive"),
        (lambda: roads.bump(0.05, -1.0, 10.0), "length of road must be positive"),
        (lambda: roads.obstacle(0.05, 0.0, 10.0), "length of road must be positive"),
        (lambda: roads.sine(0.05, 1.0, float("nan")), "speed must be positive"),
        (lambda: roads.sweep(0.05, -1.0, 2.0, 3.0), "frequency must not be negative"),
        (lambda: roads.sweep(0.05, 1.0, 2.0, 0.0), "duration of a sweep must be positive"),
        (lambda: roads.ramp(0.05, -0.1, 2.0), "length of road must not be negative"),
        (lambda: roads.plank(0.05, 1.0, 2.0, 0.0, 0.6, 0.6), "do not fit on 1 m"),
        (lambda: roads.plank(0.05, 1.0, 2.0, 0.0, -0.1), "must not be negative"),
        (lambda: roads.spline([(0.0, 0.0)], ends="open"), "'natural' or 'level'"),  # type: ignore
        (lambda: roads.sequence([]), "at least one road"),
        (lambda: roads.sequence([roads.step(0.1)] * 3, [1.0]), "2 gaps between them, 1 given"),
        (lambda: roads.sequence([roads.step(0.1)] * 2, -1.0), "must not be negative"),
        (lambda: roads.sequence([roads.step(0.1), roads.constant()]), "road 2 of the sequence"),
        (lambda: roads.sequence([roads.sine(1, 1, 1), roads.step(0.1)]), "road 1 of the sequence"),
        (lambda: roads.class_roughness("I"), "A, B, C"),
        (lambda: roads.random_profile("c", 10.0, 1.0, 1), "road classes are"),
        (lambda: roads.random_profile(-1.0, 10.0, 1.0, 1), "must be positive"),
        (lambda: roads.random_profile("C", 10.0, 1.0, -1), "not negative, -1 given"),
        (lambda: roads.random_profile("C", 10.0, 1.0, 1, band=(2.0, 1.0)), "ascending positive"),
        (lambda: roads.random_profile("C", 10.0, 1.0, 1, band=(1.0, 1.001)), "no harmonic"),
        (lambda: roads.random_profile("C", 10.0, 1.0, 1, spacing=0.1), "at most 0.0625 m"),
        (lambda: roads.random_profile("C", 10.0, 1.0, 1, fade=6.0), "at most half the length"),
        (lambda: roads.random_profile("C", 1e6, 1.0, 1), "wider spacing"),
    ],
)
def test_bad_input_is_refused(make, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        make()


@given(
    st.lists(st.tuples(PARTS, st.sampled_from([0.0, 1e-3, 0.5, 20.0])), min_size=1, max_size=5),
    st.sampled_from([1.0, 12.5]),
    st.floats(-1.0, 10.0),
)
def test_a_sequence_keeps_order_and_shapes(
    chain: list[tuple[roads.Signal, float]], speed: float, start: float
) -> None:
    parts, gaps = [part for part, _ in chain], [gap for _, gap in chain[1:]]
    road = roads.sequence(parts, gaps, speed, start)
    assert all(a < b for a, b in pairwise(road.joints))
    begin, level, jumps = start, 0.0, []
    for i, part in enumerate(parts):
        first, last = part.joints[0], part.joints[-1]
        rise = level - part.value(first - 1.0)
        if i:
            begin += gaps[i - 1] / speed
            if gaps[i - 1]:
                assert road.value(begin - 0.5 * gaps[i - 1] / speed) == pytest.approx(level)
        elif begin > start:
            assert road.value(begin - 1.0) == level
        for a, b in pairwise(part.joints):
            t = 0.5 * (a + b)
            assert road.value(t - first + begin) == pytest.approx(part.value(t) + rise, abs=1e-9)
        jumps += [(t - first + begin, height) for t, height in part.jumps]
        begin, level = begin + last - first, part.value(last) + rise
    assert road.value(begin + 1.0) == pytest.approx(level, abs=1e-12)
    # a jump down and one up at the same instant are none
    heights = {}
    for t, height in jumps:
        heights[round(t, 9)] = heights.get(round(t, 9), 0.0) + height
    expected = [(t, height) for t, height in sorted(heights.items()) if abs(height) > 1e-9]
    assert len(road.jumps) == len(expected)
    for (t, height), (t_expected, height_expected) in zip(road.jumps, expected, strict=True):
        assert (t, height) == pytest.approx((t_expected, height_expected), abs=2e-9)


def test_the_last_road_of_a_sequence_may_go_on_for_ever() -> None:
    road = roads.sequence([roads.ramp(0.1, 1.0, 5.0), roads.sine(0.02, 2.0, 5.0)], 3.0, 5.0, 1.0)
    assert road.joints == pytest.approx((1.0, 1.2, 1.8))
    assert road.value(1.9) == pytest.approx(0.1 + 0.01 * sin(2 * pi * 2.5 * 0.1))


POINTS = (
    st.lists(st.tuples(st.integers(-50, 50), st.integers(-99, 99)), min_size=2, max_size=12)
    .map(lambda points: [(0.1 * x, 1e-3 * z) for x, z in sorted(dict(points).items())])
    .filter(lambda points: len(points) > 2)
)


@pytest.mark.slow
@given(POINTS, st.sampled_from([("natural", "natural"), ("level", "clamped")]))
def test_spline_is_that_of_scipy(points: list[tuple[float, float]], ends: tuple[str, str]) -> None:
    speed, start = 2.0, 0.7
    road = roads.spline(points, speed, start, ends=ends[0])  # type: ignore[arg-type]
    x, z = np.array(points).T
    truth = CubicSpline(x, z, bc_type=ends[1])
    for position in np.linspace(x[0] + 1e-6, x[-1] - 1e-6, 23):
        found = road.derivatives(start + position / speed)[:3]
        expected = [truth(position, order) * speed**order for order in range(3)]
        largest = np.abs(truth.c).max() + 0.1
        assert found == pytest.approx(expected, abs=1e-9 * largest * 50)
    assert road.value(start + x[0] / speed - 1.0) == z[0]
    assert road.value(start + x[-1] / speed + 1.0) == z[-1]


@given(POINTS)
def test_spline_bends_without_a_break(points: list[tuple[float, float]]) -> None:
    road = roads.spline(points)
    scale = max(abs(road.acceleration(t)) for t in road.joints) + 1.0
    for left, right in pairwise(road.segments[1:-1]):
        before, after = left.derivatives(right.start)[:3], right.derivatives(right.start)[:3]
        assert before == pytest.approx(after, abs=1e-11 * scale)


def written(folder: Path, text: str) -> Path:
    path = folder / "road.csv"
    path.write_text(text, encoding="utf-8-sig")
    return path


def test_points_are_read_in_si_units(tmp_path: Path) -> None:
    path = written(tmp_path, "run; distance ;profile\n1;0;-5\n\n1;0.25;12.5\n1;1e0;0\n")
    points = roads.read_points(path, "distance", "profile", "km", "mm", delimiter=";")
    assert np.array(points) == pytest.approx(np.array([(0, -0.005), (250, 0.0125), (1000, 0)]))
    assert roads.table(points, 25.0).value(5.0) == pytest.approx(-0.005 + 0.0175 / 2)


def test_a_force_table_is_read_alike(tmp_path: Path) -> None:
    path = written(tmp_path, "t,F\n0,0\n100,2\n")
    points = roads.read_points(path, "t", "F", "ms", "kN")
    assert roads.table(points).value(0.05) == pytest.approx(1000.0)


@pytest.mark.parametrize(
    ("text", "units", "complaint"),
    [
        ("x,z\n0,1\n", ("m", "kg"), "unit 'kg' does not fit here; allowed: m, mm"),
        ("x,z\n0,1\n", ("N", "m"), "unit 'N' does not fit here; allowed: m, .* s, ms"),
        ("", ("m", "m"), "is empty"),
        ("X,z\n0,1\n", ("m", "m"), "road.csv has no column 'x'.*columns are 'X', 'z'"),
        ("x,z,x\n0,1,2\n", ("m", "m"), "2 columns are called 'x'"),
        ("x,z\n", ("m", "m"), "no rows"),
        ("x,z\n0,1\n1,two\n", ("m", "m"), "road.csv, line 3: 'z' must be a finite .* 'two' found"),
        ("x,z\n0,1\n1\n", ("m", "m"), "line 3: 'z' must be a finite number"),
        ("x,z\n0,inf\n", ("m", "m"), "line 2: 'z' must be a finite number"),
        ("x,z\n0,1\n0,2\n", ("m", "m"), "line 3: 'x' must ascend"),
    ],
)
def test_an_unusable_file_is_refused(
    tmp_path: Path, text: str, units: tuple[str, str], complaint: str
) -> None:
    with pytest.raises(ValueError, match=complaint):
        roads.read_points(written(tmp_path, text), "x", "z", *units)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "road.csv"
    path.write_bytes(b"x,z\n0,\xff\xfe\n")
    with pytest.raises(ValueError, match="line 2: 'z' must be a finite number"):
        roads.read_points(path, "x", "z", "m", "m")


def test_random_profile_is_the_sum_of_its_harmonics() -> None:
    # 100 samples 0.1 m apart lie in a period of 128: dn = 1/12.8 cycles/m
    density, dn = 64e-6, 1 / 12.8
    road = roads.random_profile("B", 10.0, 4.0, 11, 0.5, (0.2, 2.0), spacing=0.1, fade=1.0)
    random = Random(11)
    waves = [(k * dn, 2 * pi * random.random()) for k in range(3, 26)]
    for x in (1.0, 2.3, 7.7, 9.0):
        z = sum(
            sqrt(2 * density * (n / 0.1) ** -2 * dn) * cos(2 * pi * n * x + p) for n, p in waves
        )
        assert road.value(0.5 + x / 4.0) == pytest.approx(z, abs=1e-15)


def test_random_profile_comes_and_goes_smoothly() -> None:
    road = roads.random_profile("E", 20.0, 10.0, 5, start=1.0, band=(0.05, 1.0))
    assert road.joints[0] == 1.0
    assert road.joints[-1] == pytest.approx(3.0)
    slope = max(abs(road.rate(t)) for t in road.joints)
    for end in (road.joints[0], road.joints[-1] - 1e-12):
        assert road.value(end) == pytest.approx(0.0, abs=1e-12)
        assert road.rate(end) == pytest.approx(0.0, abs=1e-9 * slope)


def test_random_profile_belongs_to_its_seed_and_class() -> None:
    def make(seed: int, roughness: str | float = "C") -> roads.Signal:
        return roads.random_profile(roughness, 20.0, 10.0, seed, band=(0.05, 1.0))

    assert make(1) == make(1, 256e-6)
    t = [0.3, 0.9, 1.5]
    here = np.array([make(1).value(one) for one in t])
    assert np.array([make(1, "D").value(one) for one in t]) == pytest.approx(2.0 * here, rel=1e-12)
    assert np.abs([make(2).value(one) for one in t] - here).max() > 1e-4


def octave_ratios(road_class: str, line: str, seeds: range) -> np.ndarray:
    """Welch's estimate over the class's line, mean over each octave from 0.04 to 2.56 cycles/m."""
    density = {"A": 16e-6, "B": 64e-6, "C": 256e-6, "D": 1024e-6, "E": 4096e-6}[line]
    length, distance = 400.0, 0.1
    x = np.arange(0.1 * length, 0.9 * length, distance)
    estimates = []
    for seed in seeds:
        road = roads.random_profile(road_class, length, 1.0, seed, band=(0.01, 2.83))
        z = np.array([road.value(one) for one in x])
        n, estimate = welch(z, 1.0 / distance, nperseg=1024, detrend="linear")
        estimates.append(estimate)
    with np.errstate(divide="ignore"):
        ratio = np.mean(estimates, axis=0) / (density * (n / 0.1) ** -2.0)
    octaves = 0.04 * 2.0 ** np.arange(7)
    return np.array([ratio[(n >= a) & (n < b)].mean() for a, b in pairwise(octaves)])


@pytest.mark.slow
@pytest.mark.parametrize(("road_class", "seeds"), [("A", range(8)), ("C", range(100, 108))])
def test_spectral_density_lies_on_the_line_of_the_class(road_class: str, seeds: range) -> None:
    # classes are a factor of 4 apart and so 2 from their limits: an octave may be 30 % off, all 10 %
    ratios = octave_ratios(road_class, road_class, seeds)
    assert ratios == pytest.approx(np.ones(6), rel=0.3)
    assert ratios.mean() == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("line", ["B", "D"])
def test_spectral_density_is_off_the_lines_of_other_classes(line: str) -> None:
    ratios = octave_ratios("C", line, range(2))
    assert np.all((ratios < 0.5) | (ratios > 2.0))
