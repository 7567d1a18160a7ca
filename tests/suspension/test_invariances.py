"""What must not matter: units, front and rear, when a run begins; the campaign has more of that."""

from __future__ import annotations

import re
from dataclasses import replace
from math import sqrt
from typing import Any

import make_drawn
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import variables
from stepped import displaced

# length, time and mass in the unit of each parameter
DIMENSIONS = {
    "": (0, 0, 0), "1": (0, 0, 0), "m": (1, 0, 0), "s": (0, 1, 0), "kg": (0, 0, 1),
    "m/s": (1, -1, 0), "m/s2": (1, -2, 0), "N": (1, -2, 1), "N/m": (0, -2, 1), "N/m3": (-2, -2, 1),
    "N.s/m": (0, -1, 1), "Hz": (0, -1, 0), "m3": (3, 0, 0),
}  # fmt: skip
VEHICLES = ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"]


def motion(system: System, times: np.ndarray, **options: Any) -> np.ndarray:
    return displaced(Integrator(system, start=times[0], **options), times)


def in_other_units(
    model: str, parameters: dict[str, Any], units: tuple[float, float, float]
) -> dict[str, Any]:
    """The same car, its numbers in units that are so many times smaller."""
    unit_of = {v.name: v.unit for v in variables(model)}
    return {
        name: value * np.prod(np.power(units, DIMENSIONS[unit_of[name]]))
        if isinstance(value, float) else value
        for name, value in parameters.items()
    }  # fmt: skip


POWERS = st.integers(-8, 8).map(lambda k: 2.0**k)


@settings(max_examples=20)
@given(st.sampled_from(VEHICLES), st.integers(0, 9), POWERS, POWERS, POWERS)
def test_results_in_other_units_scale_to_the_bit(
    model: str, number: int, length: float, time: float, mass: float
) -> None:
    """Units of length, time and mass smaller by powers of two, everything acting."""
    declared = {v.name: v.start for v in variables(model) if v.causality == "parameter"}
    del declared["solver.tolerance"], declared["solver.step"]
    p = declared | make_drawn.stored(model)[number]["parameters"]
    times = np.linspace(0.0, 0.25, 6)
    one = motion(build(model, p), times, step=2.0**-8)
    other = in_other_units(model, p, (length, time, mass))
    scaled = motion(build(model, other), times * time, step=2.0**-8 * time)
    assert np.array_equal(one * length, scaled)
    # steps chosen from the tolerance know no unit of length or mass
    other = in_other_units(model, p, (length, 1.0, mass))
    one, scaled = motion(build(model, p), times), motion(build(model, other), times)
    assert np.array_equal(one * length, scaled)


@pytest.mark.parametrize("model", ["HalfCarRigidTyres", "HalfCar"])
@pytest.mark.parametrize("number", range(5))
def test_front_and_rear_exchanged_gives_the_same_car_backwards(model: str, number: int) -> None:
    p = make_drawn.stored(model)[number]["parameters"]
    ends = {"front.": "rear.", "rear.": "front.", "to_front": "to_rear", "to_rear": "to_front"}
    turned = {re.sub("|".join(ends), lambda m: ends[m[0]], name): x for name, x in p.items()}
    one, other = build(model, p), build(model, turned)
    swapped = {"front_road": one.signals["rear_road"], "rear_road": one.signals["front_road"]}
    other = replace(other, signals={**other.signals, **swapped})
    times = np.linspace(0.0, 0.5, 11)
    mirror = [1, 0, 3, 2][: len(one.coordinates)]
    there, back = (motion(system, times, tolerance=1e-10) for system in (one, other))
    assert np.abs(there - back[:, mirror]).max() < 1e-9 * np.abs(there).max()


@pytest.mark.parametrize("model", VEHICLES)
def test_it_does_not_matter_when_a_run_begins(model: str) -> None:
    """Starting a quarter of a second earlier, before a road that is level until then."""
    p = make_drawn.stored(model)[1]["parameters"]
    times = np.linspace(0.0, 0.5, 11)
    now = motion(build(model, p), times, tolerance=1e-9)
    later = motion(
        build(model, p | {"road.start": 0.25}), np.array([0.0, *(times + 0.25)]), tolerance=1e-9
    )
    assert np.abs(later[1:] - now).max() < 1e-8 * np.abs(now).max()


@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_a_stiff_tyre_on_a_light_wheel_becomes_a_rigid_one_at_first_order(damping: float) -> None:
    """Wheel mass m e, tyre stiffness c2 / e: the displacement of the body tends to OneDof as e."""
    times = np.linspace(0.0, 0.6, 61)
    ends = {"sprung_mass": 300.0, "damper.bump_rate": 1500.0, "damper.rebound_rate": 1500.0}
    limit = motion(build("OneDof", ends), times, tolerance=1e-10)[:, 0]
    sizes = 2.0 ** -np.arange(4.0, 8.0)
    errors = []
    for e in sizes:
        tyre = {"unsprung_mass": 30.0 * e, "tyre.stiffness": 150e3 / e,
                "tyre.damping": damping * sqrt(30.0 * 150e3), "lift_off": False}  # fmt: skip
        car = motion(build("QuarterCar", ends | tyre), times, tolerance=1e-8)
        errors.append(np.abs(car[:, 0] - limit).max())
    assert np.polyfit(np.log(sizes), np.log(errors), 1)[0] == pytest.approx(1.0, abs=0.05)
