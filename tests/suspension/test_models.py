"""The systems against each other, against their equations written out, and one made by a user."""

from __future__ import annotations

import doctest
from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension import roads, systems
from phaseplane.suspension.batch import outputs_over_time, run_many
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import Element, System, axle_masses, build
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variables import ParameterError, variables
from scipy.integrate import solve_ivp

TIMES = [0.005 * k for k in range(121)]
TIGHT = {"solver.tolerance": 1e-11}

FRONT = {
    "spring.rate": 17e3, "spring.cubic": 8e5, "damper.rebound_rate": 1900.0, "damper.bump_rate": 600.0,
    "damper.rebound_limit": 500.0, "damper.bump_limit": 300.0, "damper.limit_slope": 150.0,
    "bump_stop.gap": 0.03, "bump_stop.stiffness": 1.5e5, "rebound_stop.gap": 0.025,
    "rebound_stop.stiffness": 1e5,
}  # fmt: skip
REAR = {**FRONT, "spring.rate": 21e3, "damper.rebound_rate": 2300.0, "rebound_stop.gap": 0.035}
FRONT_WHEEL = {"unsprung_mass": 33.0, "tyre.stiffness": 160e3, "tyre.damping": 400.0}
REAR_WHEEL = {"unsprung_mass": 41.0, "tyre.stiffness": 190e3, "tyre.damping": 250.0}
BODY = {"sprung_mass": 620.0, "cg_to_front": 1.1, "cg_to_rear": 1.5}
DECOUPLED = {**BODY, "pitch_radius_of_gyration": sqrt(1.1 * 1.5)}


def of_axle(axle: str, *parts: dict[str, float]) -> dict[str, float]:
    return {f"{axle}.{name}": value for part in parts for name, value in part.items()}


def axle_run(model: str, parameters: dict[str, object], outputs: list[str]) -> dict[str, list]:
    return simulate(model, {**parameters, **TIGHT}, TIMES, outputs)


def largest_difference(a: dict[str, list], b: dict[str, list], names: dict[str, str]) -> float:
    """Largest difference of outputs of a and b, relative to the peak of each; names of a -> of b."""
    return max(
        float(np.max(np.abs(np.subtract(a[x], b[y]))) / np.max(np.abs(b[y])))
        for x, y in names.items()
    )


# -- equations written out -------------------------------------------------------------------------


@pytest.mark.parametrize("gyration", [0.9, 1.7])
def test_the_half_car_on_rigid_tyres_obeys_its_equations(gyration: float) -> None:
    """AP57 eqs. 33, 34 with M3 of either sign, as an ordinary initial value problem."""
    a, b, mass, speed, height, length = 1.1, 1.5, 620.0, 20.0, 0.05, 1.0
    base, passing, lag = a + b, length / speed, (a + b) / speed
    m1 = (gyration**2 + b**2) * mass / base**2
    m2 = (gyration**2 + a**2) * mass / base**2
    m3 = (a * b - gyration**2) * mass / base**2
    c1, g1, k1, c2, g2, k2 = 17e3, 8e5, 1300.0, 21e3, -2e5, 1700.0

    def road(t: float, on: bool) -> tuple[float, float]:
        w = 2.0 * pi / passing
        return (0.5 * height * (1.0 - cos(w * t)), 0.5 * height * w * sin(w * t)) if on else (0, 0)

    def motion(on_front: bool, on_rear: bool) -> Callable[[float, np.ndarray], list[float]]:
        def derivative(t: float, s: np.ndarray) -> list[float]:
            x1, x2, v1, v2 = s
            (xi1, rate1), (xi2, rate2) = road(t, on_front), road(t - lag, on_rear)
            s1 = c1 * (x1 - xi1) + g1 * (x1 - xi1) ** 3 + k1 * (v1 - rate1)
            s2 = c2 * (x2 - xi2) + g2 * (x2 - xi2) ** 3 + k2 * (v2 - rate2)
            det = m1 * m2 - m3 * m3
            return [v1, v2, (m3 * s2 - m2 * s1) / det, (m3 * s1 - m1 * s2) / det]

        return derivative

    assert passing < lag
    state, times, expected = np.zeros(4), np.array(TIMES), np.zeros((2, len(TIMES)))
    joints = (0.0, passing, lag, lag + passing, TIMES[-1])
    for k, on in enumerate([(True, False), (False, False), (False, True), (False, False)]):
        span = joints[k : k + 2]
        run = solve_ivp(
            motion(*on), span, state, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True
        )
        inside = (times >= span[0]) & (times <= span[1])
        expected[:, inside] = run.sol(times[inside])[:2]
        state = run.y[:, -1]
    own = {
        **BODY, "pitch_radius_of_gyration": gyration, "front.spring.rate": c1,
        "front.spring.cubic": g1, "front.damper.rebound_rate": k1, "front.damper.bump_rate": k1,
        "rear.spring.rate": c2, "rear.spring.cubic": g2, "rear.damper.rebound_rate": k2,
        "rear.damper.bump_rate": k2,
    }  # fmt: skip
    names = ["front_body_displacement", "rear_body_displacement"]
    got = axle_run("HalfCarRigidTyres", own, [*names, "body_displacement", "pitch_angle"])
    peak = np.max(np.abs(expected))
    assert np.max(np.abs(np.array([got[name] for name in names]) - expected)) < 1e-9 * peak
    bounce, pitch = (b * expected[0] + a * expected[1]) / base, (expected[0] - expected[1]) / base
    assert got["body_displacement"] == pytest.approx(bounce, abs=1e-9 * peak)
    assert got["pitch_angle"] == pytest.approx(pitch, abs=1e-9 * peak)


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


@pytest.mark.parametrize("model", ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"])
def test_a_force_on_the_body_acts_alike_from_a_table_and_from_outside(model: str) -> None:
    level = {"road.shape": "flat", "solver.tolerance": 1e-9}
    table = Session(model, level | {"body_force.table": "0:0, 1:900"})
    outside = Session(model, level)
    for k in range(1, 401):
        outside.set_input("body_force", 900.0 * 1e-3 * (k - 1))
        outside.advance(1e-3 * k)
    table.advance(0.4)
    name = "body_displacement"
    assert abs(float(table.value(name))) > 1e-3
    assert outside.value(name) == pytest.approx(table.value(name), rel=1e-4)
    # both together
    table.set_input("body_force", -360.0)
    table.advance(0.401)
    assert table.value("body_acceleration") < outside.value("body_acceleration") - 0.1


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
        moment = 620.0 * 1.4**2 * float(session.value("pitch_acceleration"))
        assert vertical == pytest.approx(-400.0 - front - rear, abs=1e-8)
        assert moment == pytest.approx(1.5 * rear - 1.1 * front, abs=1e-8)


# -- from outside ----------------------------------------------------------------------------------


def test_a_half_car_takes_both_roads_from_outside() -> None:
    inside = simulate("HalfCar", {}, TIMES, ["front_wheel_displacement", "rear_wheel_displacement"])
    road = roads.bump(0.05, 1.0, 20.0)
    later = road.delayed(2.5 / 20.0)
    session = Session("HalfCar", {"road.shape": "input"})
    worst = 0.0
    for k in range(1, 1201):
        t = 5e-4 * (k - 1)
        for axle, its in (("front", road), ("rear", later)):
            session.set_input(f"{axle}_road_elevation", its.value(t))
            session.set_input(f"{axle}_road_velocity", its.rate(t))
        session.advance(5e-4 * k)
        if k % 10 == 0:
            for name in ("front_wheel_displacement", "rear_wheel_displacement"):
                worst = max(worst, abs(float(session.value(name)) - float(inside[name][k // 10])))
    assert worst < 2e-3 * 0.05
    assert session.value("front_lift_off_count") == session.value("rear_lift_off_count") == 1


@pytest.mark.parametrize("instant", [0.045, 0.17])
def test_rollback_of_a_half_car_continues_to_the_bit(instant: float) -> None:
    """At 0.045 s the front wheel is in the air, at 0.17 s the rear one."""
    session, other = Session("HalfCar", {}), Session("HalfCar", {})
    names = [v.name for v in variables("HalfCar") if v.causality == "output"]
    session.advance(instant)
    assert session.value("front_airborne") is not session.value("rear_airborne")
    kept = session.snapshot()
    session.advance(0.3)
    ahead = [session.value(name) for name in names]
    other.restore(kept)
    other.advance(0.3)
    assert [other.value(name) for name in names] == ahead
    assert (other.value("front_lift_off_count"), other.value("rear_lift_off_count")) == (1, 1)


# -- a system of a user's own ----------------------------------------------------------------------


def test_the_example_of_a_full_car_runs() -> None:
    found = doctest.testmod(systems)
    assert found.attempted > 10
    assert found.failed == 0


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
        assert car.advance(t) == 0
        car.sample(t)
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
            assert one.advance(t) == 0
            one.sample(t)
        assert car.sample_q[0] == pytest.approx(mirrored.sample_q[0], abs=1e-9)
        assert car.sample_q[2] == pytest.approx(-mirrored.sample_q[2], abs=1e-9)
        largest = max(largest, abs(car.sample_q[2]))
        assert abs(car.residual_at(t)) < 1e-7 * 0.5 * 15000 * 9.80665 * 0.05**2
    assert largest > 1e-3


@settings(max_examples=25)
@given(
    st.sampled_from(["OneDof", "HalfCarRigidTyres", "HalfCar"]),
    st.floats(0.3, 3.0),
    st.floats(0.3, 3.0),
    st.floats(-0.1, 0.1),
)
def test_the_energy_balance_closes(model: str, mass: float, rate: float, height: float) -> None:
    axles = ("",) if model == "OneDof" else ("front.", "rear.")
    own: dict[str, object] = {f"{axle}spring.rate": 15e3 * rate for axle in axles}
    own |= {"sprung_mass": 300.0 * mass * len(axles), "road.height": height}
    session = Session(model, {**own, "solver.tolerance": 1e-9})
    stored = 0.5 * (15e4 if model == "HalfCar" else 15e3 * rate) * height**2
    for t in (0.03, 0.15, 0.5):
        session.advance(t)
        assert abs(float(session.value("energy_residual"))) <= 1e-6 * stored + 1e-15


@pytest.mark.parametrize(
    "start",
    [
        lambda: build("Road", {}),
        lambda: Session("Road", {}),
        lambda: simulate("Road", {}, [0.0, 1.0], ["ok"]),
        lambda: outputs_over_time("Road"),
        lambda: run_many("Road", [{}], [0.0, 1.0], []),
    ],
)
def test_a_road_alone_is_not_run(start: Callable[[], object]) -> None:
    with pytest.raises(
        ParameterError, match="Road is not a system that can be run; systems are One"
    ):
        start()
