"""Dry friction on a road that moves, starts and turns: sticking follows it, slipping has the right side.

Against closed forms; every motion by the compiled and the uncompiled kernel.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Any

import numpy as np
import pytest
from kernels import motion
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from stepped import mass_on

MASS, FRICTION = 2.0, 3.0
NOTHING = law.linear(0.0)
EVERY_METHOD: list[dict[str, Any]] = [
    {"tolerance": 1e-9},
    {"tolerance": 1e-3},
    {"step": 0.01, "order": 8},
    {"method": "equilibrium", "step": 1e-3},
    {"method": "mean", "step": 1e-3},
    {"method": "tangent", "step": 1e-3},
    {"method": "wilson", "step": 1e-3},
]


def dragged(road: Signal, damper: law.Characteristic = NOTHING) -> System:
    """A mass that rubs on a road, perhaps beside a damper."""
    element = Element("slide", (1.0,), damper=damper, road="road", friction=FRICTION)
    return System(("x",), ((MASS,),), (element,), {"road": road}, (), (0.05,))


@pytest.mark.parametrize("options", EVERY_METHOD)
def test_a_road_that_starts_drags_the_mass_up_to_its_speed(options: dict[str, Any]) -> None:
    """F t^2 / 2m until F t / m is the road's speed; then they go together."""
    speed, starts = 0.6, 0.1
    road = roads.table([(0.0, 0.0), (starts, 0.0), (10.0, speed * (10.0 - starts))])
    together = starts + speed * MASS / FRICTION
    times = [0.05, 0.2, together, 0.7, 2.0]
    found = motion(dragged(road), times, **options)

    def place(t: float) -> float:
        s = min(max(t - starts, 0.0), together - starts)
        return FRICTION * s * s / (2.0 * MASS) + speed * max(t - together, 0.0)

    assert found.displacements[:, 0] == pytest.approx([place(t) for t in times], abs=1e-9)
    assert found.instants() == pytest.approx([starts, together], abs=1e-9)


@pytest.mark.parametrize("options", EVERY_METHOD)
def test_a_road_that_turns_while_the_mass_slips_drags_it_back(options: dict[str, Any]) -> None:
    """Friction changes sides at once, and does not stick on the way."""
    speed, turns = 1.0, 0.2
    road = roads.table([(0.0, 0.0), (turns, speed * turns), (10.0, speed * (turns - 9.8))])
    rate = FRICTION / MASS
    back = turns + (speed + rate * turns) / rate
    times = [0.1, turns, 0.5, back, 2.0]
    found = motion(dragged(road), times, **options)

    def place(t: float) -> float:
        if t <= turns:
            return rate * t * t / 2.0
        s = min(t, back) - turns
        gone = rate * turns * turns / 2.0 + rate * turns * s - rate * s * s / 2.0
        return gone - speed * max(t - back, 0.0)

    assert found.displacements[:, 0] == pytest.approx([place(t) for t in times], abs=1e-9)
    slips = [(s.before, s.after) for s in found.switches]
    assert slips[-2:] == [(-1, 1), (1, 0)]


@pytest.mark.sampled
@pytest.mark.parametrize("options", EVERY_METHOD)
@pytest.mark.parametrize("saturated", [False, True])
def test_what_sticks_follows_a_curved_road(options: dict[str, Any], saturated: bool) -> None:
    """The road's sine to the tolerance, its rate to rounding, and not one switch."""
    height, omega = 0.02, 8.0
    assert height * omega**2 * MASS < FRICTION
    # from rest: no jump of its rate
    road = Signal((Segment(-inf, coefficients=(height, 0.0, 0.0, 0.0), amplitude=-height,
                           phase=(0.0, omega, 0.0)),), height)  # fmt: skip
    damper = law.saturating(40.0, 25.0) if saturated else NOTHING
    times = np.linspace(0.0, 2.0, 41).tolist()
    found = motion(dragged(road, damper), times, **options)
    wanted = [height * (1.0 - np.cos(omega * t)) for t in times]
    allowed = max(options.get("tolerance", 0.0), 2e-5) * 2.0 * height
    if options.get("tolerance") == 1e-9:
        allowed = 2e-9 * height
    assert found.displacements[:, 0] == pytest.approx(wanted, abs=allowed)
    assert found.switches == []


@pytest.mark.sampled
@pytest.mark.parametrize("options", EVERY_METHOD)
@pytest.mark.parametrize("per_slip", [0.3, 3.0, 40.0])
@pytest.mark.parametrize("cubic", [0.0, 1e-9])
def test_a_slip_much_shorter_than_a_step_ends(
    options: dict[str, Any], per_slip: float, cubic: float
) -> None:
    """A load that exceeds the friction for a moment: F e - c s^2 over F.

    It slips from s1 = -sqrt(F e / c) to -2 s1 and goes 9 c s1^4 / 4 m; a spring too soft to matter
    makes the force curved or not. Long steps see that slip wrongly, but must not be caught by it.
    """
    excess, peak = 1e-4, 0.5
    step = options.get("step", 0.01)
    half = step / per_slip / 3.0
    curvature = FRICTION * excess / half**2
    before = sqrt(1.5 * FRICTION / curvature)
    force = Signal(
        (
            Segment(-inf),
            Segment(peak - before, peak, (FRICTION * (1.0 + excess), 0.0, -curvature, 0.0)),
            Segment(peak + before),
        ),
        FRICTION,
    )
    spring = law.cubic(1e-9, cubic)
    slide = Element("slide", (1.0,), spring, friction=FRICTION)
    system = mass_on(slide, mass=MASS, force=force, scale=1e-3)
    found = motion(system, [peak - 2.0 * half, 1.0], **options)
    gone = 9.0 * curvature * half**4 / (4.0 * MASS)
    right = options.get("tolerance") == 1e-9
    allowed = 1e-6 * gone if right else 0.5 * gone + FRICTION * excess / MASS * step**2
    assert found.displacements[0, 0] == pytest.approx(0.0, abs=1e-15)
    assert found.displacements[1, 0] == pytest.approx(gone, abs=allowed)
    assert 2 <= len(found.switches) <= 40
    if right:
        assert found.instants() == pytest.approx([peak - half, peak + 2.0 * half], abs=1e-9)


@pytest.mark.sampled
@pytest.mark.parametrize("options", EVERY_METHOD)
def test_a_load_that_moves_nothing_is_no_trouble_for_a_curved_spring(
    options: dict[str, Any],
) -> None:
    """All that is left to iterate on is the rounding of forces that cancel."""
    force = Signal((Segment(-inf, amplitude=0.99 * FRICTION, phase=(0.0, 30.0, 0.0)),), FRICTION)
    slide = Element("slide", (1.0,), law.cubic(800.0, 1e5), friction=FRICTION)
    system = mass_on(slide, mass=MASS, force=force, scale=1e-3)
    found = motion(system, [0.5, 3.0], **options)
    assert abs(found.displacements).max() < 1e-15
    assert found.switches == []
