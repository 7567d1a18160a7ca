"""The construction of the half car with tyres in four planes, lift-off on each axle."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import log2

import numpy as np
import pytest
import vehicle_reference as reference
from drawn_axles import AXLES
from hypothesis import given
from hypothesis import strategies as st
from on_figures import strips
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import cubic, damper, linear
from phaseplane.suspension.two_axles import axle_masses
from recorded import check_schemes

from phaseplane import figures
from phaseplane.constructions import RULES, AxleData, HalfCarPlanes, Strut, Window, construct_motion

G = 9.80665
TO_FRONT, TO_REAR, MASS, SPEED = 1.2, 1.4, 600.0, 20.0


def loads(front: float, rear: float) -> tuple[float, float]:
    base = TO_FRONT + TO_REAR
    return (MASS * TO_REAR / base + front) * G, (MASS * TO_FRONT / base + rear) * G


def car(gyration: float = 1.1, height: float = 0.06, **changes) -> HalfCarPlanes:
    front, rear = loads(28.0, 32.0)
    road = roads.bump(height, 1.2, SPEED)
    m1, m2, m3 = axle_masses(MASS, gyration, TO_FRONT, TO_REAR)
    data = {
        "front": AxleData(28.0, linear(14000.0), damper(1800.0, 600.0), 150e3, 800.0, front, road),
        "rear": AxleData(
            32.0, cubic(17000.0, 2e6), damper(1500.0, 500.0), 170e3, 700.0, rear,
            road.delayed((TO_FRONT + TO_REAR) / SPEED),
        ),
    }  # fmt: skip
    return HalfCarPlanes(m1, m2, m3, **(data | changes))


def referred(gyration: float, height: float, times: np.ndarray) -> reference.Solution:
    """The same car by equations of their own; neither blow-off nor stops ever act."""
    never = {"damper.bump_limit": 1e9, "damper.rebound_limit": 1e9, "damper.limit_slope": 0.0,
             "bump_stop.gap": 9.0, "bump_stop.stiffness": 0.0,
             "rebound_stop.gap": 9.0, "rebound_stop.stiffness": 0.0}  # fmt: skip
    axles = {
        "front": {"unsprung_mass": 28.0, "spring.rate": 14000.0, "spring.cubic": 0.0,
                  "damper.rebound_rate": 1800.0, "damper.bump_rate": 600.0,
                  "tyre.stiffness": 150e3, "tyre.damping": 800.0},
        "rear": {"unsprung_mass": 32.0, "spring.rate": 17000.0, "spring.cubic": 2e6,
                 "damper.rebound_rate": 1500.0, "damper.bump_rate": 500.0,
                 "tyre.stiffness": 170e3, "tyre.damping": 700.0},
    }  # fmt: skip
    parameters = {
        "sprung_mass": MASS, "pitch_radius_of_gyration": gyration, "cg_to_front": TO_FRONT,
        "cg_to_rear": TO_REAR, "gravity": G, "speed": SPEED, "road.shape": "bump",
        "road.height": height, "road.length": 1.2,
    }  # fmt: skip
    for axle, own in axles.items():
        parameters |= {f"{axle}.{name}": value for name, value in {**never, **own}.items()}
    return reference.solve("HalfCar", parameters, times)


cars = st.builds(
    HalfCarPlanes,
    front_mass=st.floats(100.0, 1000.0),
    rear_mass=st.floats(100.0, 1000.0),
    coupling_mass=st.floats(-95.0, 95.0),
    front=AXLES,
    rear=AXLES,
    plane_scales=st.tuples(st.floats(0.3, 3.0), st.floats(0.3, 3.0)),
    plane_distance=st.floats(0.05, 1.0),
)
modes = st.sampled_from(["contact", "front_flight", "rear_flight", "flight"])


@pytest.mark.slow
@given(cars, modes, st.builds(Window, st.floats(0.0, 0.2), st.floats(1e-4, 0.01)))
def test_projection_gives_the_feet_of_the_formulas(one, mode, window):
    """The feet of all normals against -y''/Omega^2 from AP57 eq. 1 solved for the accelerations."""
    points = one.points(mode, one.initial, window)
    flies = {"contact": (0, 0), "front_flight": (1, 0), "rear_flight": (0, 1), "flight": (1, 1)}
    strut, tyre = [], []
    for data, air in zip((one.front, one.rear), flies[mode], strict=True):
        y, rate, height, velocity = data.initial
        strut.append(data.spring.force(y) + data.damper.force(rate))
        road, c, k = data.road, data.tyre_stiffness, data.tyre_damping
        rise = road.value(window.end) - road.value(window.start)
        h = (c * road.integral(window.start, window.end) + k * rise) / window.duration
        tyre.append(data.static_load if air else c * height + k * velocity - h)
    body = np.linalg.solve(
        [[one.front_mass, one.coupling_mass], [one.coupling_mass, one.rear_mass]], -np.array(strut)
    )
    wheels = [
        (s - t) / data.unsprung_mass
        for s, t, data in zip(strut, tyre, (one.front, one.rear), strict=True)
    ]
    accelerations = [body[0] - wheels[0], wheels[0], body[1] - wheels[1], wheels[1]]
    reach = max(abs(p) for p in points.values())
    a, b = one.plane_scales
    for plane, acceleration in zip(one.planes, accelerations, strict=True):
        axis, n = plane.displacement, plane.number
        foot = points[plane.foot]
        read = (foot - points[f"Q{n}"]).real * axis.direction.real / axis.scale
        wanted = acceleration / plane.angular_frequency**2
        tolerance = 1e-9 * (abs(wanted) + 1.0) + 1e-11 * reach / axis.scale * (1 + a / b + b / a)
        assert abs(read - wanted) < tolerance * 100.0
        assert foot.imag == axis.origin.imag


@given(cars, modes)
def test_both_readings_of_the_accelerations_agree(one, mode):
    read = one.readings(mode, one.initial, 0.01, None)
    for axle in ("front", "rear"):
        by_planes, by_forces = (
            read[f"{which}{axle}_body_acceleration"] for which in ("", "control_")
        )
        size = abs(by_forces) + abs(read[f"{axle}_wheel_acceleration"]) + 1e3
        assert abs(by_planes - by_forces) < 1e-7 * size


def _contacts(solution: reference.Solution) -> list[float]:
    return [switch.time for switch in solution.switches if "tyre" in switch.element]


@pytest.mark.slow
@pytest.mark.parametrize("gyration", [1.0, 1.5])
def test_the_march_follows_an_independent_solution_with_lift_off_on_both_axles(gyration):
    """Body and wheels, and where the wheels leave the road and return; M3 of either sign."""
    one = car(gyration)
    assert (one.coupling_mass > 0.0) == (gyration < 1.2)
    errors = []
    for step in (0.001, 0.0005):
        drawing = construct_motion(one, step=step, duration=0.35)
        rows = [f for f in drawing if abs(f.time / 0.005 - round(f.time / 0.005)) < 1e-6]
        solution = referred(gyration, 0.06, np.array([f.time for f in rows]))
        wanted = solution.displacements.T
        names = ("front_body", "rear_body", "front_wheel", "rear_wheel")
        found = np.array([[f.readings[f"{n}_displacement"] for f in rows] for n in names])
        errors.append(np.max(np.abs(found - wanted)))
    made = [(f.event, f.time) for f in drawing if f.event]
    assert [event for event, _ in made][:4] == [
        "front_lift_off", "front_touchdown", "rear_lift_off", "rear_touchdown",
    ]  # fmt: skip
    for (_, time), wanted_time in zip(made, _contacts(solution), strict=True):
        assert abs(time - wanted_time) < 1e-4
    assert errors[0] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=1.0)


@pytest.mark.sampled
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_converges_with_its_order(rule):
    """Over a bump too low to leave; the reference is an exact solution of the same car."""
    one = car(1.5, 0.01)
    solution = referred(1.5, 0.01, np.array([0.0, 0.1]))
    assert not _contacts(solution)
    wanted = solution.displacements.T
    errors = []
    for n in (100, 200, 400):
        last = construct_motion(one, rule, step=0.1 / n, steps=n).frames[-1].points
        ends = [plane.displacement.read(last[f"{plane.state}'"]) for plane in one.planes]
        found = np.array([ends[0] + ends[1], ends[2] + ends[3], ends[1], ends[3]])
        errors.append(np.max(np.abs(found - wanted[:, -1])))
    orders = [log2(e / f) for e, f in pairwise(errors)]
    assert orders[-1] == pytest.approx(rule.order, abs=0.35)


@pytest.mark.parametrize("tyre", [None, Strut(cubic(150e3, 1e8), linear(800.0))])
@pytest.mark.parametrize("rule", [RULES["osculating_circle"], RULES["delta"]], ids=lambda r: r.name)
def test_every_point_that_the_schemes_join_is_there(rule, tyre):
    one = car()
    if tyre:
        data = {**one.front.__dict__, "tyre": tyre, "tyre_stiffness": 0.0, "tyre_damping": 0.0}
        one = car(front=AxleData(**data))
    drawing = construct_motion(one, rule, step=0.002, duration=0.25)
    assert {f.scheme for f in drawing} >= {"contact", "front_flight", "rear_flight"}
    check_schemes(drawing)
    labels = {curve.label for curve in drawing.curves}
    assert labels >= {"I1", "II1", "I2", "II2", "III", "IV", "dtau11", "dtau22"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"plane_scales": (1.0, -1.0)}, "the second of plane_scales = -1.0"),
        ({"plane_distance": 0.0}, "plane_distance = 0.0"),
        (
            {"front": replace(car().front, friction=50.0)},
            "friction is constructed with one axle only",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        car(**changes)


def test_an_axle_that_cannot_be_drawn_is_refused():
    with pytest.raises(ValueError, match=r"tyre_stiffness = 0\.0"):
        AxleData(30.0, linear(1e4), linear(1e3))
    with pytest.raises(ValueError, match="four finite numbers"):
        AxleData(30.0, linear(1e4), linear(1e3), 1e5, initial=(0.0, 0.0, 0.0, float("inf")))


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_wheels_that_leave_and_meet_the_road_together_do_so_in_one_event(contact: str) -> None:
    """Two equal halves thrown upwards: both axles move alike, to rounding."""
    axle = AxleData(
        28.0, linear(14000.0), damper(1800.0, 600.0), 150e3, 800.0, 3000.0, roads.constant(),
        initial=(0.0, 0.0, 0.0, 3.0),
    )  # fmt: skip
    planes = HalfCarPlanes(280.0, 280.0, 0.0, front=axle, rear=axle, contact=contact)
    drawing = construct_motion(planes, RULES["delta"], step=0.0025, duration=1.0)
    events = [frame.event for frame in drawing.frames if frame.event]
    assert events[:2] == ["front_lift_off, rear_lift_off", "front_touchdown, rear_touchdown"]
    assert all(event.count(",") == 1 for event in events)
    for frame in drawing.frames:
        for name in ("suspension_deflection", "wheel_displacement"):
            front, rear = (frame.readings[f"{axle}_{name}"] for axle in ("front", "rear"))
            assert front == pytest.approx(rear, abs=1e-9)


def test_figure_8_turns_the_normals_of_four_planes():
    """It was refused, as a figure of two planes or more: no plane has the letter P2."""
    drawing = construct_motion(car(), RULES["tangent"], step=0.0025, steps=12)
    assert len(strips(figures.figure8(drawing), "turn")) == 4
