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

GRAVITY = 9.80665
STIFFNESS, RATIO, HEIGHT = 1e8, 0.1, 0.1
OMEGA = sqrt(STIFFNESS)


def ball(contact: str) -> System:
    """One kilogram that drops onto a hard, lightly damped floor; at rest the force is its weight."""
    floor = Element(
        "floor",
        (1.0,),
        law.linear(STIFFNESS),
        law.linear(2.0 * RATIO * OMEGA),
        limit=GRAVITY,
        contact=contact,
    )
    return System(("x",), ((1.0,),), (floor,), {}, (), (HEIGHT,))


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
    paths = []
    for options in ({}, {"method": method, "step": 0.02}):
        integrator = Integrator(build("QuarterCar", car), **options)
        path = []
        for t in times:
            assert integrator.advance(t) == 0
            integrator.sample(t)
            path.append(list(integrator.sample_q))
        paths.append(np.array(path))
    true, coarse = paths
    assert (np.abs(coarse - true).max(axis=0) < 0.25 * np.abs(true).max(axis=0)).all()
