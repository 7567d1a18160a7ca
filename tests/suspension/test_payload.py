"""Payload, progressive stops, scaled dampers and actuators."""

import pytest
from phaseplane.suspension.equilibrium import static_equilibrium
from phaseplane.suspension.models import build
from phaseplane.suspension.parts import format_payload
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variables import ParameterError, checked_parameters

G = 9.80665
TIMES = [0.01 * k for k in range(101)]
CAR = {"sprung_mass": 300.0, "spring.rate": 20e3, "tyre.stiffness": 200e3, "spring.cubic": 1e6}


@pytest.mark.parametrize(
    ("payload", "g", "cubic"), [(50.0, G, 1e6), (200.0, 1.62, 1e6), (100.0, G, -1e5)]
)
def test_a_payload_is_a_mass_and_a_new_rest(payload, g, cubic):
    """Against the unloaded car with the weight as a force, from its own equilibrium."""
    given = {**CAR, "gravity": g, "spring.cubic": cubic}
    loaded = build("QuarterCar", {**given, "payload": payload})
    plain = build("QuarterCar", given)
    assert loaded.mass[0][0] == plain.mass[0][0] + payload
    wheel = -payload * g / CAR["tyre.stiffness"]
    spring = plain.elements[0].spring
    sink = -spring.argument(-payload * g)
    assert spring.force(-sink) == pytest.approx(-payload * g)
    for x in (-0.03, 0.0, 0.02):
        moved = spring.force(x - sink) - spring.force(-sink)
        assert loaded.elements[0].spring.force(x) == pytest.approx(moved, abs=1e-9)
    assert loaded.axles[0].static_load == pytest.approx(plain.axles[0].static_load + payload * g)
    assert static_equilibrium(loaded) == (0.0, 0.0)
    words = format_payload(checked_parameters("QuarterCar", {**given, "payload": payload}))
    assert f"{1e3 * (sink - wheel):.4g} mm" in words


@pytest.mark.parametrize("cubic", [0.0, 1e6])
def test_a_payload_without_gravity_lowers_nothing(cubic):
    given = {**CAR, "gravity": 0.0, "payload": 50.0, "spring.cubic": cubic}
    words = format_payload(checked_parameters("QuarterCar", given))
    assert words == "payload of 50 kg lowers the body by 0 mm, 0 mm of it in the suspension"


def test_a_tyre_given_by_a_table_is_pressed_along_it():
    given = {"tyre.table": "-0.02:-4000, -0.01:-3000, 0:0, 0.01:5000"}
    tyre = build("QuarterCar", {**CAR, **given, "payload": 3500.0 / G}).elements[-1].spring
    assert [tyre.force(x) for x in (-0.005, 0.015, 0.025)] == pytest.approx(
        [-500.0, 3500.0, 8500.0]
    )
    assert tyre.force(0.0) == 0.0
    level = {"tyre.table": "-0.02:-4000, -0.01:-3990, 0:0", "tyre.interpolation": "monotone"}
    with pytest.raises(ParameterError, match=r"payload = 500: the tyre never reaches 4903\.32 N"):
        build("QuarterCar", {**level, "payload": 500.0})


def test_stops_keep_their_distance_from_the_design_position():
    payload = {"payload": 20e3 * 0.02 / G}  # sinks by 20 mm
    stops = {"bump_stop.gap": 0.06, "bump_stop.stiffness": 1e6, "rebound_stop.gap": 0.08,
             "rebound_stop.stiffness": 1e6, "spring.cubic": 0.0}  # fmt: skip
    on_road = {"spring.rate": 20e3, **stops, **payload}
    for loaded in (build("QuarterCar", {**CAR, **stops, **payload}), build("OneDof", on_road)):
        by_name = {element.name: element.spring for element in loaded.elements}
        assert by_name["bump_stop"].corners == pytest.approx((-0.04,))
        assert by_name["rebound_stop"].corners == pytest.approx((0.10,))
    given = checked_parameters("QuarterCar", {**CAR, **stops, **payload})
    assert format_payload(given).endswith("; bump stop 40 mm away; rebound stop 100 mm away")


def test_a_payload_may_rest_on_the_bump_stop():
    given = {**CAR, "spring.cubic": 0.0, "bump_stop.gap": 0.01, "bump_stop.stiffness": 180e3}
    loaded = build("QuarterCar", {**given, "payload": (20e3 * 0.02 + 180e3 * 0.01) / G})
    assert static_equilibrium(loaded) == (0.0, 0.0)
    stop = next(e.spring for e in loaded.elements if e.name == "bump_stop")
    assert stop.corners == pytest.approx((0.01,))  # the stop is left 10 mm above
    words = format_payload(checked_parameters("QuarterCar", {**given, "payload": 400.0}))
    sink = (400.0 * G + 180e3 * 0.01) / 200e3
    assert words.endswith(f"bump stop compressed by {1e3 * (sink - 0.01):.4g} mm")


def test_payloads_of_a_half_car_lie_over_its_axles():
    car = build("HalfCar", {"front.payload": 30.0, "rear.payload": 10.0})
    plain = build("HalfCar", {})
    assert [car.mass[i][i] - plain.mass[i][i] for i in range(2)] == [30.0, 10.0]
    assert car.mass[0][1] == plain.mass[0][1]
    assert car.axles[1].static_load - plain.axles[1].static_load == pytest.approx(10.0 * G)


def test_a_table_through_the_same_points_is_the_same_stop():
    stop = {"bump_stop.gap": 0.02, "rebound_stop.gap": 0.01}
    linear = {"bump_stop.stiffness": 2e5, "rebound_stop.stiffness": 1e5}
    tables = {
        "bump_stop.table": "0:0, 0.1:20000",
        "rebound_stop.table": "0:0, 0.01:1000, 0.1:10000",
    }
    ours, theirs = (
        simulate("QuarterCar", {**stop, **given}, TIMES, ["body_displacement", "bump_stop_force"])
        for given in (linear, tables)
    )
    assert min(ours["bump_stop_force"]) < 0.0
    assert ours["body_displacement"] == pytest.approx(theirs["body_displacement"], abs=1e-12)


@pytest.mark.parametrize(
    ("table", "words"),
    [("0.01:0, 0.02:10", "begin with 0:0"), ("0:0, 0.01:5, 0.02:5", "must rise"),
     ("0:0, 0.02:5, 0.01:6", "ascend"), ("0:0, 0:5", "ascend"),
     ("stiff", "pairs of finite numbers")],
)  # fmt: skip
def test_a_stop_that_is_no_stop_is_refused(table, words):
    with pytest.raises(ParameterError, match=rf"bump_stop.table.*{words}"):
        build("QuarterCar", {"bump_stop.table": table})


@pytest.mark.parametrize(
    "damper",
    [{}, {"damper.rebound_limit": 800.0}, {"damper.table": "-1:-500, 0:0, 0.2:600, 1:1500"},
     {"damper.saturation_force": 900.0}],
    ids=["rates", "blow-off", "table", "saturation"],
)  # fmt: skip
def test_a_scaled_damper_has_every_force_scaled(damper):
    plain, scaled = (
        next(
            e.damper for e in build("QuarterCar", {**damper, **more}).elements if e.name == "damper"
        )
        for more in ({}, {"damper.scale": 1.5})
    )
    for rate in (-2.0, -0.3, 0.0, 0.1, 1.0):
        assert scaled.force(rate) == pytest.approx(1.5 * plain.force(rate))


@pytest.mark.parametrize("model", ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"])
def test_an_actuator_lifts_the_body_and_presses_the_wheel(model):
    """Inner forces leave the ground's force alone; the body rises by force over rate."""
    axle = "front_" if "Half" in model else ""
    rate = {f"{axle[:-1]}.spring.rate" if axle else "spring.rate": 20e3}
    session = Session(model, {"road.shape": "flat", **rate})
    for k in range(3):
        session.advance(k * 1e-3)
        session.set_input(f"{axle}actuator_force", 300.0)
    session.advance(30.0)
    assert session.value(f"{axle}suspension_deflection") == pytest.approx(300.0 / 20e3, rel=1e-6)
    if "RigidTyres" not in model and model != "OneDof":
        start = Session(model, {"road.shape": "flat"}).value(f"{axle}contact_force")
        assert session.value(f"{axle}contact_force") == pytest.approx(start, rel=1e-6)
    assert abs(session.value("energy_residual")) < 1e-6
