"""Measures taken from columns whose figures are known."""

from __future__ import annotations

import numpy as np

from scenarios.measures import BOOKKEEPING, measure_units, measured
from suspension.variables import MODELS

COLUMNS = {
    "time": np.array([0.0, 0.1, 0.2, 0.3, 0.4]),
    "body_displacement": np.array([0.0, 2.0, -3.0, 1.0, 3.0]),
    "contact_force": np.array([5.0, 4.0, 0.0, 0.0, 6.0]),
    "last_lift_off": np.array([-1.0, 0.05, 0.05, 0.27, 0.27]),
    "last_touchdown": np.array([-1.0, -1.0, 0.15, 0.15, 0.35]),
    "lift_off_count": np.array([0, 1, 1, 3, 3], dtype=np.int32),
    "airborne_time": np.array([0.0, 0.05, 0.1, 0.12, 0.2]),
    "energy_residual": np.array([0.0, 1e-6, -4e-6, 2e-6, 0.0]),
    "step_count": np.array([0, 3, 6, 9, 12], dtype=np.int32),
    "airborne": np.array([False, True, False, True, False]),
}


def test_measures() -> None:
    found = measured(COLUMNS)
    peak = found.peaks["body_displacement"]
    assert (peak.value, peak.time) == (-3.0, 0.2)  # the first of two of the same magnitude, signed
    assert found.lift_offs == (0.05, 0.27)
    assert found.touchdowns == (0.15, 0.35)
    assert found.lift_off_count == 3  # one of them lay within a row and was not seen
    assert found.airborne_time == 0.2
    assert found.smallest_contact_force is not None
    assert found.smallest_contact_force.time == 0.2
    assert found.value("energy_residual") == -4e-6
    assert found.value("first_touchdown") == 0.15
    assert found.value("peak.contact_force") == 6.0
    assert set(found.peaks) == {"body_displacement", "contact_force"}


def test_what_was_not_read_is_not_measured() -> None:
    found = measured({"time": COLUMNS["time"], "x": COLUMNS["body_displacement"]})
    assert found.lift_offs == ()
    for name in ("first_lift_off", "lift_off_count", "airborne_time", "smallest_contact_force"):
        assert found.value(name) is None


def test_a_lift_off_at_time_zero_counts() -> None:
    assert measured({"time": np.zeros(1), "last_lift_off": np.zeros(1)}).lift_offs == (0.0,)


def test_every_measure_that_can_be_bounded_has_a_value() -> None:
    """What the schema offers, `Measures.value` knows."""
    outputs = {v.name: v for v in MODELS["QuarterCar"] if v.causality == "output"}
    assert set(BOOKKEEPING) <= set(outputs)
    found = measured(COLUMNS)
    peaks = {f"peak.{name}" for name in found.peaks}
    for name in measure_units(outputs):
        assert (found.value(name) is None) == (name.startswith("peak.") and name not in peaks), name
