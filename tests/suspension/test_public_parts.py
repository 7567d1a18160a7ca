"""Public parameters of springs, dampers, tyres, friction, roads and start, and the yielding model."""

from __future__ import annotations

import math

import numpy as np
import pytest
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variables import ROAD_SHAPES, ParameterError

TIMES = [0.01 * k for k in range(61)]


def element(name: str, model: str = "QuarterCar", **parameters: object):
    system = build(model, {key.replace("__", "."): value for key, value in parameters.items()})
    number = system.element(name)
    return None if number is None else system.elements[number]


def test_force_and_acceleration_keep_the_equation_of_motion_while_yielding() -> None:
    outputs = ["acceleration", "velocity", "spring_force", "damper_force", "applied_force"]
    found = simulate("Elastoplastic", {"hardening": 800.0}, [0.013 * k for k in range(60)], outputs)
    a, v, spring, damper, force = (np.array(found[name]) for name in outputs)
    assert damper == pytest.approx(200.0 * v, abs=1e-12)
    assert 100.0 * a == pytest.approx(force - spring - damper, abs=1e-10)
    assert np.abs(spring).max() > 6.05  # it has hardened


def test_force_from_outside_adds_to_the_table() -> None:
    still = {"force.table": "", "yield_force": 1e3}
    session = Session("Elastoplastic", still)
    session.set_input("force", 50.0)
    session.advance(30.0)
    assert session.value("displacement") == pytest.approx(50.0 / 5000.0, rel=1e-6)
    assert session.value("applied_force") == 50.0


def test_start_of_the_yielding_model() -> None:
    start = {
        "initial.displacement": 0.004,
        "initial.velocity": -0.02,
        "initial.permanent_set": 3e-3,
    }
    session = Session("Elastoplastic", start)
    assert session.value("displacement") == 0.004
    assert session.value("velocity") == -0.02
    assert session.value("spring_force") == pytest.approx(5.0)
    with pytest.raises(ParameterError, match="must be below"):
        Session("Elastoplastic", {"hardening": 5000.0})


def test_friction_output_balances_the_body() -> None:
    names = ["spring", "damper", "friction"]
    outputs = ["body_acceleration", *(f"{name}_force" for name in names)]
    found = simulate("QuarterCar", {"friction": 300.0, "road.height": 0.02}, TIMES, outputs)
    forces = np.array([found[f"{name}_force"] for name in names])
    mass = element("spring") and 30 * 9.80665
    assert mass * np.array(found["body_acceleration"]) == pytest.approx(-forces.sum(0), abs=1e-9)
    stuck = np.abs(forces[2]) < 299.0
    assert 5 < stuck.sum() < 55
    assert np.abs(forces[2]).max() == 300.0


def test_a_suspension_on_the_road_feels_it():
    """All its elements deflect by the body's displacement minus that of the ground."""
    stop = {"bump_stop.stiffness": 1e5, "bump_stop.gap": 0.01}
    names = [
        "suspension_deflection",
        "suspension_deflection_rate",
        "damper_force",
        "bump_stop_force",
    ]
    found = simulate("OneDof", stop, TIMES, names)
    deflection, rate, damper, bump = (np.array(found[name]) for name in names)
    assert damper == pytest.approx(np.where(rate > 0.0, 200.0, 50.0) * 9.80665 * rate, abs=1e-9)
    assert bump == pytest.approx(1e5 * np.minimum(deflection + 0.01, 0.0), abs=1e-9)
    assert bump.min() < -1e3


def test_preload_finds_the_static_deflection() -> None:
    """A progressive spring under 3 kN: from rest it has the slope of its curve there, and no force."""
    spring = element("spring", spring__preload=3000.0, spring__rate=2e4, spring__cubic=1e6).spring
    static = next(x.real for x in np.roots([1e6, 0.0, 2e4, 3000.0]) if abs(x.imag) < 1e-12)
    assert spring.force(0.0) == pytest.approx(0.0, abs=1e-9)
    assert spring.tangent(0.0) == pytest.approx(2e4 + 3e6 * static**2, rel=1e-9)
    assert spring.force(0.05) == pytest.approx(
        2e4 * (static + 0.05) + 1e6 * (static + 0.05) ** 3 + 3000.0, rel=1e-9
    )
    softening = {"spring__preload": 2000.0, "spring__rate": 2e4, "spring__cubic": -1e5}
    roots = np.sort(np.roots([-1e5, 0.0, 2e4, 2000.0]))  # it falls again beyond 0.258 m
    carried = roots[np.abs(roots).argmin()]
    assert element("spring", **softening).spring.tangent(0.0) == pytest.approx(
        2e4 - 3e5 * carried**2
    )
    table = {"spring__table": "-0.2:-5000, -0.1:-2000, 0:0", "spring__preload": 2600.0}
    spring = element("spring", **table).spring
    assert [spring.force(x) for x in (-0.05, 0.0, 0.02, 0.12, 0.22)] == pytest.approx(
        [-1500.0, 0.0, 600.0, 2600.0, 4600.0]
    )
    with pytest.raises(ParameterError, match="never reaches"):
        build("QuarterCar", {"spring.table": "-0.1:-500, -0.05:-500, 0:0", "spring.preload": 600.0})


def test_tables_joined_smoothly() -> None:
    table = "-0.1:-3000, -0.05:-800, 0:0, 0.1:900"
    smooth = element("spring", spring__table=table, spring__interpolation="monotone").spring
    straight = element("spring", spring__table=table).spring
    assert smooth.tangent(-0.05 + 1e-9) == pytest.approx(smooth.tangent(-0.05 - 1e-9), rel=1e-6)
    assert smooth.force(-0.05) == pytest.approx(straight.force(-0.05))


def test_damper_that_saturates_and_depends_on_deflection() -> None:
    damper = element(
        "damper", damper__saturation_force=700.0, damper__rebound_rate=2e3, damper__bump_rate=5e2,
        damper__deflection_table="-0.03:3, 0.01:1",
    )  # fmt: skip
    assert damper.damper.force(-0.4) == pytest.approx(-700.0 * math.tanh(5e2 * 0.4 / 700.0))
    assert damper.damper.force(0.4) == pytest.approx(700.0 * math.tanh(2e3 * 0.4 / 700.0))
    assert [damper.modulation.force(x) for x in (-1.0, -0.01, 1.0)] == [3.0, 2.0, 1.0]


def test_tyre_by_a_table_leaves_the_road_where_its_force_is_the_load() -> None:
    tyre = element("tyre", tyre__table="-0.1:-30000, 0:0, 0.05:8000")
    assert tyre.free_length == pytest.approx(tyre.limit / 160e3)
    found = simulate(
        "QuarterCar", {"tyre.table": "-0.1:-30000, 0:0, 0.05:8000"}, TIMES,
        ["contact_force", "airborne", "energy_residual"],
    )  # fmt: skip
    assert min(found["contact_force"]) == 0.0
    assert [f == 0.0 for f in found["contact_force"]] == found["airborne"]
    assert any(found["airborne"])
    assert max(map(abs, found["energy_residual"])) < 1e-3


def test_a_tyre_may_be_damped_by_a_table() -> None:
    """As phi of AP57 eq. 1, which need not be linear; see `test_every_kind` for its motion."""
    tyre = element("tyre", tyre__damping_table="-1:-900, -0.1:-250, 0:0, 1:400", payload=80.0)
    rates = (-2.0, -1.0, -0.05, 0.0, 0.5, 2.0)
    wanted = [-900.0 - 6500.0 / 9.0, -900.0, -125.0, 0.0, 200.0, 800.0]
    assert [tyre.damper.force(w) for w in rates] == pytest.approx(wanted)
    assert tyre.spring.tangent(0.0) == pytest.approx(147_099.75)


@pytest.mark.parametrize(
    ("parameters", "complaint"),
    [
        ({"tyre.table": "-0.1:-3e4, 0:0, 0.1:0"}, "must rise"),
        ({"tyre.table": "-0.1:-3e4, 0.1:1e4"}, "through 0:0"),
        ({"tyre.damping_table": "-1:-300, 1:400"}, "through 0:0"),
        ({"tyre.damping_table": "-1:-300, 0:0, 1:-40"}, "adds energy"),
        ({"damper.deflection_table": "0:-1, 0.1:1"}, "must not be negative"),
        ({"damper.deflection_table": "0.1:1, 0:1"}, "must ascend"),
        ({"damper.saturation_force": 100.0, "damper.bump_rate": 0.0}, "must be greater than 0"),
        ({"spring.interpolation": "cubic"}, "one of linear, monotone"),
        ({"road.seed": 1.5}, "whole number"),
        ({"road.class": "K"}, "one of A, B"),
        ({"road.shape": "table"}, "road.table is empty"),
        ({"road.shape": "plank", "road.ramp_length": 0.6}, "do not fit"),
        ({"road.shape": "random", "road.profile_length": 0.1}, "take a wider band"),
    ],
)
def test_bad_values_are_named(parameters: dict[str, object], complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint) as caught:
        Session("QuarterCar", parameters)
    assert any(name.split(".")[0] in str(caught.value) for name in parameters)


@pytest.mark.parametrize("gyration", [1e-9, 1e9])
@pytest.mark.parametrize("model", ["HalfCar", "HalfCarRigidTyres"])
def test_a_body_that_is_one_mass_to_rounding_is_refused(model: str, gyration: float) -> None:
    with pytest.raises(ParameterError, match=r"pitch_radius_of_gyration = .* order of 1.25 m"):
        Session(model, {"pitch_radius_of_gyration": gyration})
    for kept in (1e-4, 1e4):
        Session(model, {"pitch_radius_of_gyration": kept}).advance(0.05)


@pytest.mark.parametrize("shape", [s for s in ROAD_SHAPES if s != "input"])
def test_every_road_can_be_driven(shape: str) -> None:
    parameters = {
        "road.shape": shape, "road.table": "0:0, 0.5:0.02, 1:0", "road.profile_length": 20.0,
        "road.sequence": "bump 0.02 1, gap 1, step 0.01",
        "road.duration": 0.4, "road.start": 0.05, "solver.tolerance": 1e-5,
    }  # fmt: skip
    found = simulate("QuarterCar", parameters, TIMES, ["ground_elevation", "energy_residual"])
    moved = max(map(abs, found["ground_elevation"]))
    assert found["ground_elevation"][0] == 0.0
    assert moved == 0.0 if shape == "flat" else 1e-4 < moved < 0.06
    assert abs(found["energy_residual"][-1]) < 1e-2


def test_a_road_that_starts_elsewhere_is_stood_on() -> None:
    """Table, input and stand-still agree: at 8 cm all is as at 0, only higher."""
    high = {"road.shape": "table", "road.table": "0:0.08, 4:0.08, 5:0.11, 6:0.08"}
    low = {"road.shape": "table", "road.table": "0:0, 4:0, 5:0.03, 6:0"}
    names = ["body_displacement", "wheel_displacement", "contact_force"]
    above, below = (simulate("QuarterCar", p, TIMES, names) for p in (high, low))
    # a tyre of 147 kN/m makes 15 mN of a millionth of the largest displacement
    for name, rise, within in zip(names, (0.08, 0.08, 0.0), (1e-6, 1e-6, 0.015), strict=True):
        assert np.array(above[name]) - rise == pytest.approx(np.array(below[name]), abs=within)
    session = Session("QuarterCar", {"road.shape": "input"})
    session.set_input("road_elevation", 0.08)
    session.advance(0.0)
    assert session.value("body_displacement") == pytest.approx(0.08, rel=1e-12)
    session.advance(0.5)
    assert session.value("body_displacement") == pytest.approx(0.08, rel=1e-12)


def test_the_last_word_on_the_road_at_the_start_counts() -> None:
    session = Session("QuarterCar", {"road.shape": "input"})
    for elevation in (0.08, 0.0):
        session.set_input("road_elevation", elevation)
        session.advance(0.0)
        assert session.value("body_displacement") == pytest.approx(elevation, abs=1e-15)
    session.advance(0.1)
    assert session.value("body_displacement") == 0.0
    assert not session.value("airborne")


def test_a_kerb_at_the_start_is_still_to_be_climbed() -> None:
    step = {"road.shape": "step", "road.height": 0.02}
    found = simulate("QuarterCar", step, [0.0, 3.0], ["body_displacement"])
    assert found["body_displacement"] == pytest.approx([0.0, 0.02], abs=1e-4)


def test_a_start_is_given_from_equilibrium() -> None:
    given = {"initial.front_body_displacement": 0.01, "initial.rear_wheel_velocity": -0.3}
    session = Session("HalfCar", {"road.shape": "flat", **given})
    assert session.value("front_body_displacement") == 0.01
    assert session.value("rear_wheel_velocity") == -0.3
    assert session.value("front_spring_force") == pytest.approx(0.01 * 1500 * 9.80665)


@pytest.mark.parametrize("shape", ["plank", "pothole"])
@pytest.mark.parametrize("model", ["QuarterCar", "OneDof"])
def test_a_kerb_is_the_limit_of_ever_shorter_ramps(model: str, shape: str) -> None:
    """To first order in the ramp: tyres do not pull, and dampers act as they do at high rates."""
    parameters = {
        "road.shape": shape, "road.height": 0.03, "road.start": 0.03, "solver.tolerance": 1e-8,
        "damper.rebound_limit": 400.0, "damper.limit_slope": 50.0,
    }  # fmt: skip
    kerb, *ramps = (
        np.array(
            simulate(model, {**parameters, "road.ramp_length": ramp}, TIMES, ["body_displacement"])[
                "body_displacement"
            ]
        )
        for ramp in (0.0, 1e-2, 1e-3, 1e-4)
    )
    errors = [np.abs(ramp - kerb).max() / np.abs(kerb).max() for ramp in ramps]
    assert errors[0] < 0.02
    assert errors[1:] == pytest.approx([0.1 * errors[0], 0.01 * errors[0]], rel=0.1)
