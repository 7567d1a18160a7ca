"""Numbers as people read them."""

from __future__ import annotations

import pytest
from phaseplane.scenarios.results.quantities import number, quantity, reading, sizes, span


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (16.152345, "16.152"), (-21.58, "-21.580"), (0.0, "0"), (3158.3847, "3158.385"),
        (0.15507574, "0.1551"), (0.0045205, "0.004521"), (-1.23456e-7, "-1.235e-07"),
        (4.5e12, "4.500e+12"), (-4.5e12, "-4.500e+12"), (-4.547e-12, "-4.547e-12"),
        (1e-15, "1.000e-15"), (float("nan"), "nan"), (float("inf"), "inf"), (float("-inf"), "-inf"),
        (7, "7"),
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
        ((None, 1.5), "Hz", "none, 1.500 Hz"),  # as JSON has what is not finite
    ],
)  # fmt: skip
def test_a_value_has_its_unit(value: object, unit: str, text: str) -> None:
    assert quantity(value, unit) == text


@pytest.mark.parametrize(
    ("time", "text"),
    [(1e-3, "1 ms"), (2.5e-7, "0.00025 ms"), (1.0, "1 s"), (9.5, "9.5 s"), (1e5, "100000 s")],
)
def test_long_spans_are_in_seconds(time: float, text: str) -> None:
    assert span(time) == text


def test_what_is_zero_but_for_rounding_reads_as_zero() -> None:
    """Relative to the largest of its kind: forces that cancel, not a motion that is small as a whole."""
    forces = [("peak.tyre_force", "N", 3200.0), ("peak.actuator_force", "N", -4.547e-12)]
    motion = [("peak.wheel_displacement", "m", 2e-15), ("peak.body_displacement", "m", -1e-15)]
    # without units as in an equation, whose accelerations may be of another size than its displacements
    bare = [
        ("peak.displacement", "1", 1e-7), ("peak.acceleration", "1", 1e9),
        ("rms.acceleration", "1", 2e-8), ("peak.start2_acceleration", "1", 2e-8),
        ("lift_off_count", "count", 3),
        ("natural_frequencies", "Hz", (3e-16, 1.5)), ("peak.velocity", "m/s", float("nan")),
    ]  # fmt: skip
    size = sizes([*forces, *motion, *bare])
    assert {
        name: quantity(value, unit, size[name]) for name, unit, value in [*forces, *motion, *bare]
    } == {
        "peak.tyre_force": "3200.000 N", "peak.actuator_force": "0 N",
        "peak.wheel_displacement": "2.000e-12 mm", "peak.body_displacement": "-1.000e-12 mm",
        "peak.displacement": "1.000e-07", "peak.acceleration": "1.000e+09",
        "rms.acceleration": "0", "peak.start2_acceleration": "2.000e-08", "lift_off_count": "3",
        "natural_frequencies": "0 Hz, 1.500 Hz", "peak.velocity": "nan m/s",
    }  # fmt: skip


def test_a_reading_has_its_instant() -> None:
    peak = {"value": -0.02158, "unit": "m", "time": 0.03}
    assert reading(peak) == "-21.580 mm at    30.00 ms"
    assert reading(peak, width=10, units=5) == "   -21.580 mm    at    30.00 ms"
    assert reading({**peak, "time": None}) == "-21.580 mm"
    assert reading({**peak, "time": 2.5e-7}) == "-21.580 mm at 0.0002500 ms"
