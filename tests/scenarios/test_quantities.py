"""Numbers as people read them."""

from __future__ import annotations

import pytest
from phaseplane.scenarios.results.quantities import number, quantity, reading


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (16.152345, "16.152"), (-21.58, "-21.580"), (0.0, "0.000"), (3158.3847, "3158.385"),
        (0.15507574, "0.1551"), (0.0045205, "0.004521"), (-1.23456e-7, "-1.235e-07"),
        (4.5e12, "4.500e+12"), (-4.547e-12, "0.000"),
        (float("nan"), "nan"), (float("inf"), "inf"), (7, "7"),
    ],
)  # fmt: skip
def test_four_digits_and_three_decimals_at_least(value: float, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.090179652, "m", "90.180 mm"), (2.3310365, "m/s2", "2.331 m/s2"), (3, "count", "3"),
        (2.0, "count", "2"), (0.0349, "s", "34.900 ms"), (0.155, "1", "0.1550"),
        (None, "m", "none"), ((1.5, 12.0), "Hz", "1.500 Hz, 12.000 Hz"), ((), "s", "none"),
    ],
)  # fmt: skip
def test_a_value_has_its_unit(value: object, unit: str, text: str) -> None:
    assert quantity(value, unit) == text


def test_a_reading_has_its_instant() -> None:
    peak = {"value": -0.02158, "unit": "m", "time": 0.03}
    assert reading(peak) == "-21.580 mm at    30.00 ms"
    assert reading(peak, 10, 5) == "   -21.580 mm    at    30.00 ms"
    assert reading({**peak, "time": None}) == "-21.580 mm"
