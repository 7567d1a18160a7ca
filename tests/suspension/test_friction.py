"""Dry friction that sticks and slips: closed forms, an independent reference, energy, several at once."""

from __future__ import annotations

from math import cos, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, Load, System
from stepped import at, mass_on, read_at

MASS, RATE, FRICTION = 2.0, 800.0, 1.0
OMEGA = sqrt(RATE / MASS)


def slider(friction: float = FRICTION, force: roads.Signal | None = None) -> System:
    """A mass on a spring that rubs."""
    leaf = Element("leaf", (1.0,), characteristics.linear(RATE), friction=friction)
    return mass_on(leaf, mass=MASS, force=force or 0.0, scale=1e-2)


@pytest.mark.parametrize(
    "options",
    [
        {"tolerance": 1e-9},
        {"method": "equilibrium", "step": 1e-4},
        {"method": "exact", "tolerance": 1e-9},
    ],
)
def test_coulomb_decay(options: dict[str, object]) -> None:
    """The amplitude falls by 4 F / k a period, on straight lines, and then it sticks for good."""
    integrator = Integrator(slider(), **options)
    start = 0.0213
    integrator.set_state([start], [0.0])
    loss = 2 * FRICTION / RATE  # in half a period
    swings = 9  # until the spring pulls with less than the friction
    for k in range(swings + 1):
        expected = (-1) ** k * (start - k * loss)
        assert at(integrator, k * pi / OMEGA)[0] == pytest.approx(expected, abs=1e-8)
    last = (-1) ** swings * (start - swings * loss)
    assert abs(last) < FRICTION / RATE
    assert at(integrator, 100.0)[0] == pytest.approx(last, abs=1e-8)
    lost = 0.5 * RATE * (start**2 - last**2)
    assert lost == pytest.approx(
        FRICTION * sum(2 * start - (2 * k + 1) * loss for k in range(swings))
    )
    assert abs(integrator.energy_residual()) < 1e-6 * lost


def test_a_force_below_the_friction_moves_nothing_at_all() -> None:
    force = roads.Signal(
        (roads.Segment(-np.inf, 0.0, amplitude=0.99, phase=(0.0, 30.0, 0.0)),), 1.0
    )
    integrator = Integrator(slider(force=force))
    for t in (0.1, 1.0, 10.0):
        assert abs(at(integrator, t)[0]) < 1e-15  # rounding, where the spring gives 1 mm
    assert integrator.log == []


def test_it_breaks_loose_when_the_force_reaches_the_friction() -> None:
    ramp = roads.table([(0.0, 0.0), (1.0, 2.0)])
    integrator = Integrator(slider(force=ramp), tolerance=1e-10)
    assert abs(at(integrator, 0.5)[0]) < 1e-15
    late = 0.6 - FRICTION / 2.0
    # m x'' + k x = 2 (t - 0.5)
    exact = 2.0 / RATE * (late - np.sin(OMEGA * late) / OMEGA)
    assert at(integrator, 0.6)[0] == pytest.approx(exact, abs=1e-11)
    t, _, kind, before, after = integrator.log[0]
    assert (KINDS[kind], before, after) == ("friction", 0, 1)
    assert t == pytest.approx(0.5, abs=1e-12)


def test_two_that_stick_at_once_move_as_one_body() -> None:
    """Two masses stuck together and one of them to a moving road: rigid motion with the road."""
    system = System(
        ("a", "b"),
        ((1.0, 0.0), (0.0, 3.0)),
        (
            Element("between", (1.0, -1.0), friction=1e6),
            Element("floor", (0.0, 1.0), friction=1e6, road="road"),
        ),
        {"road": roads.sine(0.02, 1.0, 1.0)},
        scales=(0.01, 0.01),
    )
    integrator = Integrator(system, tolerance=1e-10)
    speed = 0.01 * 2 * pi
    integrator.set_state([0.0, 0.0], [speed, speed])
    for t in (0.1, 0.37, 1.2):
        assert at(integrator, t)[0] == pytest.approx(0.01 * np.sin(2 * pi * t), abs=1e-9)
        assert integrator.sample_q[1] == pytest.approx(integrator.sample_q[0], abs=1e-14)
    assert abs(integrator.energy_residual()) < 1e-8


def test_no_friction_is_no_friction() -> None:
    integrator = Integrator(slider(friction=0.0), tolerance=1e-10)
    integrator.set_state([0.01], [0.0])
    assert at(integrator, 1.0)[0] == pytest.approx(0.01 * cos(OMEGA), abs=1e-11)
    assert integrator.log == []


@pytest.mark.parametrize("mass", [1e-6, 1e-3, 1e3, 1e6])
def test_any_mass_ratio_sticks_and_slips_alike(mass: float) -> None:
    """Scaled by the mass, the motion is the same: no regularisation sets a scale of its own."""
    factor = mass / MASS
    leaf = Element("leaf", (1.0,), characteristics.linear(factor * RATE), friction=factor)
    system = mass_on(leaf, mass=mass, scale=1e-2)
    integrator, plain = Integrator(system), Integrator(slider())
    for one in (integrator, plain):
        one.set_state([0.0213], [0.0])
    for t in (0.1, 0.5, 3.0):
        assert at(integrator, t)[0] == pytest.approx(at(plain, t)[0], rel=1e-9)


@settings(max_examples=40, derandomize=True)
@given(
    st.floats(0.01, 5.0), st.floats(-0.05, 0.05), st.floats(-1.0, 1.0),
    st.lists(st.floats(-8.0, 8.0), min_size=1, max_size=6),
)  # fmt: skip
def test_the_ledger_closes_and_memory_is_exact(
    friction: float, displacement: float, velocity: float, loads: list[float]
) -> None:
    force = roads.table([(0.2 * k, f) for k, f in enumerate([0.0, *loads])])
    integrator = Integrator(slider(friction, force), tolerance=1e-8)
    integrator.set_state([displacement], [velocity])
    assert integrator.advance(0.7) == 0
    kept = integrator.snapshot()
    assert integrator.advance(2.0) == 0
    ahead = integrator.snapshot()
    integrator.restore(kept)
    assert integrator.advance(2.0) == 0
    assert integrator.snapshot() == ahead
    energy = RATE * displacement**2 + MASS * velocity**2 + sum(f * f for f in loads) / RATE + 1e-6
    assert abs(integrator.energy_residual()) < 1e-5 * energy


def test_contradicting_friction_is_refused() -> None:
    twice = Element("leaf", (1.0,), characteristics.linear(1.0), friction=1.0)
    with pytest.raises(ValueError, match="combine those along one direction"):
        Integrator(System(("x",), ((1.0,),), (twice, twice), scales=(1.0,)))
    with pytest.raises(ValueError, match="at least 0"):
        Element("leaf", (1.0,), friction=-1.0)


@pytest.mark.parametrize("shape", ["bump", "obstacle", "sine", "ramp", "step"])
@pytest.mark.parametrize("model", ["OneDof", "HalfCarRigidTyres"])
def test_what_cannot_hold_slips_from_the_start(model: str, shape: str) -> None:
    """The road accelerates, or the spring pulls, by more than friction can hold: it is what it is."""
    axles = ("front", "rear") if model == "HalfCarRigidTyres" else ("",)
    given: dict[str, object] = {"road.shape": shape}
    for axle in axles:
        given[f"{axle}.friction".lstrip(".")] = 100.0
        if shape == "step":
            given[f"initial.{axle}_body_displacement".replace("._", ".")] = -0.05
    session = Session(model, given)
    name = f"{axles[0]}_friction_force".lstrip("_")
    force = session.value(name)
    session.advance(1e-12)
    assert abs(force) == 100.0
    assert session.value(name) == force


def test_the_order_of_inputs_does_not_matter_at_the_start() -> None:
    """What slips from the start slips the way that all signals together push it."""
    pushed = System(
        ("x",),
        ((MASS,),),
        (
            Element("leaf", (1.0,), characteristics.linear(RATE), friction=FRICTION),
            Element("mount", (1.0,), characteristics.linear(RATE), road="road"),
        ),
        {"load": roads.constant(), "road": roads.constant()},
        (Load((1.0,), "load"),),
        (1e-2,),
    )
    value = {"load": -2.0, "road": 10.0 / RATE}  # N, m: alone the load slips down, both together up
    begun = []
    for order in (("load", "road"), ("road", "load")):
        integrator = Integrator(pushed, tolerance=1e-8)
        for name in order:
            signal = list(pushed.signals).index(name)
            integrator.set_signal(signal, [value[name], 0.0, 0.0, 0.0], jumps=False)
        begun.append(integrator.snapshot())
        read_at(integrator, 1e-9)
        up = (value["load"] + RATE * value["road"] - FRICTION) / MASS
        assert float(integrator.sample_a[0]) == pytest.approx(up)
    assert begun[0] == begun[1]
