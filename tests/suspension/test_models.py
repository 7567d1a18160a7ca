"""The systems against each other, against their equations written out, and one made by a user."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.batch import outputs_over_time, run_many
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.two_axles import axle_masses
from phaseplane.suspension.variables import ParameterError
from stepped import read_at

TIMES = [0.005 * k for k in range(121)]
TIGHT = {"solver.tolerance": 1e-11}

FRONT = {
    "spring.rate": 17e3, "spring.cubic": 8e5, "damper.rebound_rate": 1900.0, "damper.bump_rate": 600.0,
    "damper.rebound_limit": 500.0, "damper.bump_limit": 300.0, "damper.limit_slope": 150.0,
    "bump_stop.gap": 0.03, "bump_stop.stiffness": 1.5e5, "rebound_stop.gap": 0.025,
    "rebound_stop.stiffness": 1e5,
}  # fmt: skip
BODY = {"sprung_mass": 620.0, "cg_to_front": 1.1, "cg_to_rear": 1.5}


def of_axle(axle: str, *parts: dict[str, float]) -> dict[str, float]:
    return {f"{axle}.{name}": value for part in parts for name, value in part.items()}


def axle_run(model: str, parameters: dict[str, object], outputs: list[str]) -> dict[str, list]:
    return simulate(model, {**parameters, **TIGHT}, TIMES, outputs)


# -- equations written out -------------------------------------------------------------------------


lengths, velocities = st.floats(0.1, 5.0), st.floats(-10.0, 10.0)


@given(st.floats(1.0, 1e5), lengths, lengths, lengths, velocities, velocities)
def test_axle_masses_carry_the_kinetic_energy_of_the_body(
    mass: float, gyration: float, a: float, b: float, v1: float, v2: float
) -> None:
    m1, m2, m3 = axle_masses(mass, gyration, a, b)
    heave, pitch = (b * v1 + a * v2) / (a + b), (v1 - v2) / (a + b)
    kinetic = 0.5 * mass * (heave**2 + gyration**2 * pitch**2)
    terms = 0.5 * (m1 * v1**2 + m2 * v2**2) + abs(m3 * v1 * v2)
    assert 0.5 * (m1 * v1**2 + m2 * v2**2) + m3 * v1 * v2 == pytest.approx(
        kinetic, abs=1e-12 * terms + 1e-300
    )


@pytest.mark.parametrize("model", ["HalfCar", "HalfCarRigidTyres"])
def test_the_body_obeys_newton_and_euler_at_its_centre_of_gravity(model: str) -> None:
    session = Session(model, {**BODY, "pitch_radius_of_gyration": 1.4, **of_axle("front", FRONT)})
    session.set_input("body_force", -400.0)
    for t in np.linspace(0.0, 0.4, 21):
        session.advance(float(t))
        front, rear = (
            sum(
                float(session.value(f"{axle}_{name}_force"))
                for name in ("spring", "damper", "bump_stop", "rebound_stop")
            )
            for axle in ("front", "rear")
        )
        vertical = 620.0 * float(session.value("body_acceleration"))
        ends = [float(session.value(f"{axle}_body_displacement")) for axle in ("front", "rear")]
        bounce = (1.5 * ends[0] + 1.1 * ends[1]) / 2.6
        assert session.value("body_displacement") == pytest.approx(bounce, abs=1e-15)
        assert session.value("pitch_angle") == pytest.approx((ends[0] - ends[1]) / 2.6, abs=1e-15)
        moment = 620.0 * 1.4**2 * float(session.value("pitch_acceleration"))
        assert vertical == pytest.approx(-400.0 - front - rear, abs=1e-8)
        assert moment == pytest.approx(1.5 * rear - 1.1 * front, abs=1e-8)


# -- a system of a user's own ----------------------------------------------------------------------


def full_car(left: roads.Signal, right: roads.Signal) -> System:
    """Two half cars of the default parameters side by side: heave, pitch, roll, four wheels."""
    half = build("HalfCar", {})
    kept = {element.name: element for element in half.elements}
    inertia = (2 * 60 * 9.80665, 2 * 60 * 9.80665 * 1.25**2, 500.0, *4 * (3 * 9.80665,))
    elements, signals = [], {}
    for k, (x, y) in enumerate([(1.25, 0.7), (1.25, -0.7), (-1.25, 0.7), (-1.25, -0.7)]):
        axle = "front" if x > 0.0 else "rear"
        on_wheel = tuple(float(i == k) for i in range(4))
        strut = (1.0, x, y, *(-w for w in on_wheel))
        road = (left if y > 0.0 else right).delayed((1.25 - x) / 20.0)
        elements += [
            Element(f"spring_{k}", strut, spring=kept[f"{axle}_spring"].spring),
            Element(f"damper_{k}", strut, damper=kept[f"{axle}_damper"].damper),
            replace(kept[f"{axle}_tyre"], name=f"tyre_{k}", direction=(0.0, 0.0, 0.0, *on_wheel),
                    road=f"road_{k}"),
        ]  # fmt: skip
        signals[f"road_{k}"] = road
    return System(
        ("heave", "pitch", "roll", "front_left", "front_right", "rear_left", "rear_right"),
        tuple(tuple(m * (i == j) for j in range(7)) for i, m in enumerate(inertia)),
        tuple(elements),
        signals,
        scales=7 * (0.05,),
    )


def test_a_full_car_with_both_sides_alike_is_a_half_car() -> None:
    road = roads.bump(0.05, 1.0, 20.0)
    car = Integrator(full_car(road, road), tolerance=1e-11)
    names = ["body_displacement", "pitch_angle", "front_wheel_displacement",
             "rear_wheel_displacement", "front_lift_off_count"]  # fmt: skip
    half = axle_run("HalfCar", {}, names)
    for k, t in enumerate(TIMES[1:], 1):
        read_at(car, t)
        heave, pitch, roll, *wheels = car.sample_q
        expected = [float(half[name][k]) for name in names[:4]]
        assert [heave, pitch, wheels[0], wheels[2]] == pytest.approx(expected, abs=1e-10)
        assert wheels[0] == pytest.approx(wheels[1], abs=1e-12)
        assert roll == pytest.approx(0.0, abs=1e-12)
    assert half["front_lift_off_count"][-1] == 1


def test_a_full_car_rolls_over_a_bump_on_one_side_and_its_energy_balances() -> None:
    road = roads.bump(0.05, 1.0, 20.0)
    car, mirrored = (
        Integrator(full_car(*sides), tolerance=1e-9)
        for sides in ((road, roads.constant()), (roads.constant(), road))
    )
    largest = 0.0
    for t in TIMES[1:]:
        for one in (car, mirrored):
            read_at(one, t)
        assert car.sample_q[0] == pytest.approx(mirrored.sample_q[0], abs=1e-9)
        assert car.sample_q[2] == pytest.approx(-mirrored.sample_q[2], abs=1e-9)
        largest = max(largest, abs(car.sample_q[2]))
        assert abs(car.energy_residual()) < 1e-7 * 0.5 * 15000 * 9.80665 * 0.05**2
    assert largest > 1e-3


@pytest.mark.parametrize("shape", ["bump", "plank", "random", "sine"])
def test_a_road_is_read_beside_a_mass_at_rest(shape: str) -> None:
    """At joints, too, where an elevation that jumps has its new value."""
    session = Session("Road", {"road.shape": shape, "wheelbase": 2.0})
    signals = session.system.signals
    for time in (0.0, 0.0125, 0.05, 0.1, 0.12, 0.15, 0.6):
        session.advance(time)
        for axle, road in signals.items():
            assert session.value(f"{axle}_elevation") == road.value(time)
            assert session.value(f"{axle}_velocity") == road.rate(time)
    assert list(session.integrator.sample_q) == [0.0]


def test_a_road_that_moves_nothing_does_not_shorten_steps() -> None:
    session = Session("Road", {"road.shape": "sine", "road.length": 0.2, "speed": 40.0})
    session.advance(1.0)  # 200 waves
    assert session.integrator.step_count < 20


@pytest.mark.parametrize(
    "start",
    [
        lambda: outputs_over_time("Road"),
        lambda: run_many("Road", [{}], [0.0, 1.0], []),
    ],
)
def test_a_road_alone_is_not_run(start: Callable[[], object]) -> None:
    with pytest.raises(
        ParameterError, match="Road cannot be run by itself; models that can are One"
    ):
        start()
