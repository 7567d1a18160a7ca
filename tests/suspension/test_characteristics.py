"""Force laws: force, tangent, potential and corners agree with each other and with hand calculation."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from phaseplane.suspension import characteristics as law
from scipy.interpolate import PchipInterpolator

RATES = st.floats(1.0, 1e6)
LIMITS = st.floats(1.0, 1e5)
TABLES = (
    st.lists(st.tuples(st.integers(-20, 20), st.floats(-1e4, 1e4)), min_size=2, max_size=8)
    .map(lambda points: sorted(dict(points).items()))
    .filter(lambda points: len(points) > 1)
)
POINTS = (
    st.lists(st.tuples(st.integers(-90, 90), st.integers(-400, 400)), min_size=2, max_size=10)
    .map(lambda points: [(1e-3 * x, 25.0 * f) for x, f in sorted(dict(points).items())])
    .filter(lambda points: len(points) > 1)
)
LAWS = st.one_of(
    st.builds(law.linear, RATES),
    st.builds(law.cubic, RATES, st.floats(-1e6, 1e6)),
    st.builds(law.damper, RATES, RATES, LIMITS, LIMITS, st.floats(0.0, 1e3)),
    st.builds(law.bump_stop, st.floats(0.0, 0.1), RATES),
    st.builds(law.rebound_stop, st.floats(0.0, 0.1), RATES),
    TABLES.map(law.table),
    TABLES.map(law.monotone_table),
)


def scale(characteristic: law.Characteristic) -> float:
    return max(abs(characteristic.force(x)) for x in (-2.0, -0.1, 0.1, 2.0)) + 1.0


@given(LAWS, st.floats(-2.0, 2.0))
def test_tangent_is_the_slope_of_the_force(characteristic: law.Characteristic, x: float) -> None:
    h = 1e-6
    assume(all(abs(x - corner) >= 2 * h for corner in characteristic.corners))
    slope = (characteristic.force(x + h) - characteristic.force(x - h)) / (2 * h)
    assert slope == pytest.approx(characteristic.tangent(x), abs=1e-8 * scale(characteristic) / h)


@given(LAWS, st.floats(-2.0, 2.0))
def test_potential_is_the_work_of_the_force(characteristic: law.Characteristic, x: float) -> None:
    # Simpson's rule is exact for each cubic piece
    ends = sorted({0.0, x, *(c for c in characteristic.corners if min(0, x) < c < max(0, x))})
    work = 0.0
    for a, b in pairwise(ends):
        middle = characteristic.force(0.5 * (a + b))
        inside = 1e-12 * (b - a)
        work += (
            (b - a)
            / 6.0
            * (characteristic.force(a + inside) + 4.0 * middle + characteristic.force(b - inside))
        )
    work = work if x > 0 else -work
    assert characteristic.potential(x) == pytest.approx(work, abs=1e-9 * scale(characteristic))


@given(LAWS)
def test_force_is_continuous_at_every_corner(characteristic: law.Characteristic) -> None:
    for left, right in pairwise(characteristic.pieces):
        assert left.force(right.start) == pytest.approx(
            right.force(right.start), abs=1e-9 * scale(characteristic)
        )


@given(LAWS, LAWS, st.floats(-2.0, 2.0))
def test_two_laws_side_by_side_add(
    one: law.Characteristic, other: law.Characteristic, x: float
) -> None:
    both = one + other
    tolerance = 1e-9 * (scale(one) + scale(other))
    assert both.force(x) == pytest.approx(one.force(x) + other.force(x), abs=tolerance)
    assert both.potential(x) == pytest.approx(one.potential(x) + other.potential(x), abs=tolerance)


POWER, SATURATING = law.power(3.0, 2.0), law.saturating(3.0, 5.0)
OWN = law.function(math.sinh, math.cosh)


@pytest.mark.parametrize(
    ("one", "other"),
    [(POWER, POWER), (POWER, SATURATING), (OWN, POWER), (SATURATING, law.saturating(3.0, 4.0))],
)
def test_what_is_no_piece_together_is_two_elements(
    one: law.Characteristic, other: law.Characteristic
) -> None:
    with pytest.raises(ValueError, match="use two elements"):
        one + other


@pytest.mark.parametrize("one", [POWER, SATURATING, OWN])
def test_a_table_beside_a_curved_law_adds(one: law.Characteristic) -> None:
    table = law.table([(-1.0, -7.0), (0.0, 0.0), (2.0, 5.0)])
    for both in (one + table, table + one):
        for x in (-2.0, -0.4, 0.3, 3.0):
            assert both.force(x) == pytest.approx(one.force(x) + table.force(x), rel=1e-12)
            assert both.potential(x) == pytest.approx(one.potential(x) + table.potential(x))


def test_damper_blows_off_where_the_valve_opens() -> None:
    # the test case of the accuracy study: 1961.33 and 490.3325 N s/m, opening at 0.3 and 0.6 m/s
    damper = law.damper(1961.33, 490.3325, 588.399, 294.1995, 98.0665)
    assert damper.corners == pytest.approx((-0.6, 0.0, 0.3))
    assert damper.force(0.3) == pytest.approx(588.399)
    assert damper.force(1.3) == pytest.approx(588.399 + 98.0665)
    assert damper.force(-1.6) == pytest.approx(-294.1995 - 98.0665)
    assert damper.force(0.1) == pytest.approx(196.133)
    assert damper.force(-0.1) == pytest.approx(-49.03325)


def test_damper_without_limits_has_its_two_rates_everywhere() -> None:
    damper = law.damper(1961.33, 490.3325)
    assert damper.corners == (0.0,)
    assert damper.force(10.0) == pytest.approx(19613.3)
    assert damper.force(-10.0) == pytest.approx(-4903.325)


def test_stops_touch_only_beyond_their_gap() -> None:
    bump, rebound = law.bump_stop(0.05, 2e5), law.rebound_stop(0.04, 3e5)
    assert (bump.force(-0.05), bump.force(0.5)) == (0.0, 0.0)
    assert bump.force(-0.06) == pytest.approx(-2000.0)
    assert rebound.force(0.06) == pytest.approx(6000.0)
    assert rebound.force(-1.0) == 0.0


def test_a_corner_that_does_not_bend_is_no_corner() -> None:
    assert law.table([(-1.0, -5.0), (0.0, 0.0), (1.0, 5.0), (2.0, 20.0)]).corners == (1.0,)


def test_mirrored_table_gives_mirrored_force() -> None:
    points = [(-2.0, -7.0), (-0.5, -1.0), (0.0, 0.0), (1.0, 3.0)]
    mirrored = [(-x, -y) for x, y in reversed(points)]
    one, other = law.table(points), law.table(mirrored)
    for x in (-3.0, -1.0, -0.1, 0.7, 5.0):
        assert other.force(-x) == pytest.approx(-one.force(x))


@pytest.mark.parametrize(
    ("points", "complaint"),
    [([(0.0, 0.0)], "at least two points"), ([(0.0, 0.0), (0.0, 1.0)], "must ascend")],
)
def test_an_unusable_table_is_refused(points: list[tuple[float, float]], complaint: str) -> None:
    for make in (law.table, law.monotone_table):
        with pytest.raises(ValueError, match=complaint):
            make(points)


def test_a_monotone_table_wants_finite_numbers() -> None:
    with pytest.raises(ValueError, match="finite"):
        law.monotone_table([(0.0, 0.0), (1.0, float("nan"))])


@pytest.mark.slow
@given(POINTS)
def test_monotone_table_is_the_pchip_of_scipy(points: list[tuple[float, float]]) -> None:
    curve = law.monotone_table(points)
    x, f = np.array(points).T
    truth = PchipInterpolator(x, f)
    for at in np.linspace(x[0], x[-1], 31)[1:-1]:
        assert curve.force(at) == pytest.approx(float(truth(at)), abs=1e-12 * 1e4)
        if min(abs(x - at)) > 1e-9:
            steepest = np.abs(np.diff(f) / np.diff(x)).max() + 1.0
            assert curve.tangent(at) == pytest.approx(float(truth(at, 1)), abs=1e-11 * steepest)


@given(POINTS)
def test_monotone_table_rises_and_falls_only_where_its_points_do(
    points: list[tuple[float, float]],
) -> None:
    curve = law.monotone_table(points)
    for (x, f), (x_next, f_next) in pairwise(points):
        forces = [curve.force(at) for at in np.linspace(x, x_next, 40, endpoint=False)] + [f_next]
        rises = np.diff(forces) * (1.0 if f_next >= f else -1.0)
        assert rises.min() >= -1e-11 * 1e4
        assert forces[0] == pytest.approx(f, abs=1e-8)


@given(POINTS)
def test_monotone_table_goes_on_straight_and_never_kinks(points: list[tuple[float, float]]) -> None:
    curve = law.monotone_table(points)
    steepest = max(abs((g - f) / (y - x)) for (x, f), (y, g) in pairwise(points))
    rounding = 1e-11 * (3.0 * steepest + 1.0)
    for left, right in pairwise(curve.pieces):
        assert left.tangent(right.start) == pytest.approx(right.tangent(right.start), abs=rounding)
    for (x, f), beyond in ((points[0], -0.2), (points[-1], 0.2)):
        straight = f + beyond * curve.tangent(x)
        assert curve.force(x + beyond) == pytest.approx(straight, abs=rounding)
