"""Bounces that become ever shorter, and switches that follow one another while no time passes."""

from __future__ import annotations

from itertools import pairwise
from math import atan2, exp, pi, sqrt

import numpy as np
import pytest
from kernels import motion
from phaseplane.suspension import characteristics as law
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from stepped import displaced, mass_on

GRAVITY = 9.80665
STIFFNESS, RATIO, HEIGHT = 1e8, 0.1, 0.1
OMEGA = sqrt(STIFFNESS)


def ball(contact: str) -> System:
    """One kilogram that drops onto a hard, lightly damped floor; at rest the force is its weight."""
    laws = law.linear(STIFFNESS), law.linear(2.0 * RATIO * OMEGA)
    floor = Element("floor", (1.0,), *laws, limit=GRAVITY, contact=contact)
    return mass_on(floor, scale=HEIGHT)


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("options", [{}, {"tolerance": 1e-9}, {"method": "exact"}])
def test_a_ball_bounces_ever_lower_and_comes_to_rest(
    options: dict[str, object], contact: str
) -> None:
    """Without its weight a contact turns the velocity round and leaves exp(-zeta t) of it.

    By force, the force at both ends of the contact is 0, and the damped oscillation gives its factor
    for half a turn to every quantity. By gap, contact begins at the surface, with a force by the damper
    alone, and ends sooner: after the turn in which the acceleration of x = sin t exp(-zeta t) falls to
    zero (T. Schwager, T. Poeschel, Granular Matter 9, 2007). The bounces last as long as the weight
    does not matter: until the floor gives way by the static deflection.
    """
    found = motion(ball(contact), np.linspace(0.0, 1.2, 5), [HEIGHT], [0.0], **options)
    times = [0.0, *(s.time for s in found.switches)]
    flights = [b - a for a, b in zip(times[0::2], times[1::2], strict=False)]
    turned = sqrt(1.0 - RATIO**2)
    turn = pi if contact == "force" else pi - atan2(2.0 * RATIO * turned, 1.0 - 2.0 * RATIO**2)
    expected = exp(-RATIO / turned * turn)
    assert flights[1] == pytest.approx(2.0 * flights[0] * expected, rel=2e-3)
    for first, second in pairwise(flights[1:11]):
        assert second == pytest.approx(first * expected, rel=1e-2)
    slowest = GRAVITY / OMEGA
    bounces = np.log(sqrt(2.0 * GRAVITY * HEIGHT) / slowest) / -np.log(expected)
    assert len(flights) == pytest.approx(bounces, abs=4)
    assert found.switches[-1].after == 0
    assert abs(found.displacements[-1, 0]) < 1e-9
    assert abs(found.velocities[-1, 0]) < 1e-9


@pytest.mark.parametrize("method", ["equilibrium", "mean"])
@pytest.mark.parametrize(
    ("gap", "stiffness", "other_gap", "height"),
    [(0.016, 1e7, 0.013, 0.13), (0.019, 5e6, 0.025, 0.18)],
)
def test_switches_without_time_between_do_not_end_a_run(
    method: str, gap: float, stiffness: float, other_gap: float, height: float
) -> None:
    """Steps far too coarse for stops so hard move on a cubic that the searched septic is far from.

    There an element leaves its branch at once, and the next one too. The run goes on, as right as
    its steps are.
    """
    car = {
        "bump_stop.gap": gap,
        "bump_stop.stiffness": stiffness,
        "rebound_stop.gap": other_gap,
        "rebound_stop.stiffness": 5e7,
        "road.height": height,
        "friction": 400.0,
    }
    times = np.linspace(0.0, 2.0, 201)
    true, coarse = (
        displaced(Integrator(build("QuarterCar", car), **options), times)
        for options in ({}, {"method": method, "step": 0.02})
    )
    assert (np.abs(coarse - true).max(axis=0) < 0.25 * np.abs(true).max(axis=0)).all()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-8])
def test_an_axle_that_rests_on_a_corner_of_its_tyre_leaves_it_once(tolerance: float) -> None:
    """While the other axle moves, it departs by less than an attempt may be wrong.

    In the branch of each side an attempt then led to the other side, for ever.
    """
    car = {
        "sprung_mass": 991.8, "road.shape": "spline", "speed": 10.34, "contact": "force",
        "road.table": "0.0:0.0, 0.6486:-0.04802, 1.025:-0.004272, 1.715:0.01015, 2.541:-0.03271",
        "cg_to_front": 1.051, "cg_to_rear": 1.694, "pitch_radius_of_gyration": 1.563,
        "front.spring.rate": 30410.0, "front.damper.bump_rate": 0.0,
        "front.damper.rebound_rate": 0.0, "front.unsprung_mass": 67.95,
        "front.spring.table": "-0.1404:-8872.0, 0.0:0.0, 0.02068:843.3, 0.04677:2234.0, 0.08002:2764.0",
        "front.spring.interpolation": "linear", "front.tyre.stiffness": 380600.0,
        "front.bump_stop.gap": 0.01819, "front.bump_stop.stiffness": 631000.0,
        "front.tyre.damping": 1801.0, "rear.spring.rate": 23560.0, "rear.spring.cubic": 26690.0,
        "rear.spring.preload": 3725.0, "rear.damper.bump_rate": 0.0,
        "rear.damper.rebound_rate": 0.0, "rear.unsprung_mass": 43.9,
        "rear.tyre.stiffness": 191500.0, "rear.tyre.damping": 80.26,
        "rear.tyre.table": "-0.02862:-3328.0, -0.02718:-2749.0, 0.0:0.0, 0.005545:2005.0, "
        "0.01199:4449.0, 0.0316:12170.0", "rear.tyre.interpolation": "linear",
    }  # fmt: skip
    integrator = Integrator(build("HalfCar", car), tolerance=tolerance)
    assert integrator.advance(0.1) == 0
    assert integrator.step_count < 200


def test_steps_that_end_at_once_without_a_switch_are_passed_over() -> None:
    """At the start on a random road, those of a calculation by hand were 1e-35 s long, for ever."""
    car = {
        "road.shape": "random", "speed": 7.446, "road.class": "C", "road.seed": 624,
        "road.profile_length": 40.0, "lift_off": False, "spring.rate": 12930.0,
        "damper.bump_rate": 163.6, "damper.rebound_rate": 522.0, "damper.saturation_force": 491.5,
        "tyre.stiffness": 133300.0, "tyre.damping": 0.0, "tyre.interpolation": "monotone",
        "tyre.table": "-0.03895:-2120.0, -0.03293:-1561.0, 0.0:0.0, 0.02312:3091.0",
        "sprung_mass": 283.0, "unsprung_mass": 49.36,
        "spring.table": "-0.1483:-1007, -0.09192:-760.3, 0:0, 0.01912:351.5, 0.07315:616.5",
    }  # fmt: skip
    integrator = Integrator(build("QuarterCar", car), "tangent", 1e-3)
    assert integrator.advance(0.1) == 0
    assert integrator.step_count < 400
