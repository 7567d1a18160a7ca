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
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import System
from phaseplane.suspension.variable import Variable
from phaseplane.suspension.variables import outputs, variables
from stepped import displaced

# length, time and mass in the unit of each variable
DIMENSIONS = {
    "": (0, 0, 0), "1": (0, 0, 0), "m": (1, 0, 0), "s": (0, 1, 0), "kg": (0, 0, 1),
    "m/s": (1, -1, 0), "m/s2": (1, -2, 0), "N": (1, -2, 1), "N/m": (0, -2, 1), "N/m3": (-2, -2, 1),
    "N.s/m": (0, -1, 1), "Hz": (0, -1, 0), "m3": (3, 0, 0), "J": (2, -2, 1),
    "rad": (0, 0, 0), "rad/s": (0, -1, 0), "rad/s2": (0, -2, 0),
}  # fmt: skip
VEHICLES = ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"]


def motion(system: System, times: np.ndarray, **options: Any) -> np.ndarray:
    return displaced(Integrator(system, start=times[0], **options), times)


def results(model: str, parameters: dict[str, Any], times: np.ndarray) -> np.ndarray:
    """All outputs, one row for each instant."""
    session, rows = Session(model, parameters, float(times[0])), []
    for t in times:
        session.advance(float(t))
        rows.append([float(session.value(name)) for name in outputs(model)])
    return np.array(rows)


def size_of(v: Variable, units: tuple[float, float, float]) -> float:
    """How many of the smaller units make one unit of a variable."""
    return float(np.prod(np.power(units, DIMENSIONS[v.unit])))


def in_other_units(
    model: str, parameters: dict[str, Any], units: tuple[float, float, float]
) -> dict[str, Any]:
    """The same car, its numbers in units that are so many times smaller."""
    sizes = {v.name: size_of(v, units) for v in variables(model)}
    return {name: value * sizes[name] if isinstance(value, float) else value
            for name, value in parameters.items()}  # fmt: skip


POWERS = st.integers(-8, 8).map(lambda k: 2.0**k)


@settings(max_examples=20)
@given(st.sampled_from(VEHICLES), st.integers(0, 9), POWERS, POWERS, POWERS, st.booleans())
def test_results_in_other_units_scale_to_the_bit(
    model: str, number: int, length: float, time: float, mass: float, fixed: bool
) -> None:
    """Units of length, time and mass smaller by powers of two, everything acting, in all outputs.

    Steps chosen from the tolerance know no unit of length or mass.
    """
    declared = {v.name: v.start for v in variables(model) if v.causality == "parameter"}
    p = declared | make_drawn.stored(model)[number]["parameters"]
    units = (length, time if fixed else 1.0, mass)
    if fixed:
        p["solver.step"] = 2.0**-8
    times = np.linspace(0.0, 0.25, 6)
    one = results(model, p, times)
    scaled = results(model, in_other_units(model, p, units), times * units[1])
    sizes = [size_of(v, units) for v in outputs(model).values()]
    never = one == -1.0  # the time of the last lift-off before the first
    assert np.array_equal(np.where(never, one, one * sizes), scaled)


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
