"""The construction of the quarter car, with and without lift-off."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice, pairwise
from math import cos, inf, log2, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from phaseplane.constructions import (
    RULES,
    OneDofPlane,
    QuarterCarPlanes,
    Window,
    delta,
    frames,
    march,
    overlay,
)
from suspension import roads
from suspension.characteristics import bump_stop, cubic, damper, linear

KGF = 9.80665
M, m = 30.0 * KGF, 3.0 * KGF
C1, C2, K2 = 1500.0 * KGF, 15000.0 * KGF, 100.0 * KGF
STEP = 0.0025


def ap57(**changes) -> QuarterCarPlanes:
    """AP57 section 8 in SI."""
    data = {
        "sprung_mass": M,
        "unsprung_mass": m,
        "spring": linear(C1),
        "damper": damper(200.0 * KGF, 50.0 * KGF),
        "tyre_stiffness": C2,
        "tyre_damping": K2,
        "road": roads.bump(0.05, 1.0, 20.0),
    }
    return QuarterCarPlanes(**(data | changes))


def elevation(t: float) -> tuple[float, float]:
    """The bump of AP57 section 8 and its velocity, written out."""
    if not 0.0 <= t <= 0.05:
        return 0.0, 0.0
    return 0.025 * (1.0 - cos(40.0 * pi * t)), pi * sin(40.0 * pi * t)


def _slope(t, z, flies):
    x1, x2, v1, v2 = z
    rate = v1 - v2
    force = C1 * (x1 - x2) + (200.0 if rate > 0.0 else 50.0) * KGF * rate
    xi, xi_rate = elevation(t)
    tyre = (M + m) * 9.80665 if flies else C2 * (x2 - xi) + K2 * (v2 - xi_rate)
    return v1, v2, -force / M, (force - tyre) / m


def _gap(t, z, flies):
    xi, xi_rate = elevation(t)
    return C2 * (z[1] - xi) + K2 * (z[3] - xi_rate) - (M + m) * 9.80665


def by_scipy(times: np.ndarray, lift_off: bool) -> tuple[np.ndarray, list[float]]:
    """x1, x2, x1', x2' from AP57 eqs. 12, 26 and 29 in the coordinates of the masses; instants of
    lift-off and touchdown.
    """
    time, state, flies = 0.0, np.zeros(4), False
    rows, switches = [], []
    while time < times[-1]:
        end = 0.05 if time < 0.05 else times[-1]

        def switch(t, z, flies):
            return _gap(t, z, flies)

        switch.terminal, switch.direction = lift_off, -1.0 if flies else 1.0
        solution = solve_ivp(
            _slope, (time, end), state, args=(flies,), events=switch,
            method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.002, dense_output=True,
        )  # fmt: skip
        last = solution.t[-1]
        rows += [solution.sol(t) for t in times if time <= t < last]
        time, state = last, solution.y[:, -1]
        if solution.status == 1:
            switches.append(time)
            flies = not flies
    rows.append(state)
    return np.array(rows).T, switches


@pytest.fixture(scope="module")
def without_lift_off() -> np.ndarray:
    return by_scipy(np.arange(61) * STEP, lift_off=False)[0]


@pytest.fixture(scope="module")
def lift_off_and_touchdown() -> tuple[float, float]:
    _, switches = by_scipy(np.array([0.0, 0.15]), lift_off=True)
    lift_off, touchdown = switches
    return lift_off, touchdown


def column(drawing, name: str) -> np.ndarray:
    return np.array([frame.readings[name] for frame in drawing])


# Published numbers (AP57 section 8; its kgf, cm, s).


def test_published_constants():
    car = ap57()
    one, two = car.angular_frequencies
    assert one == pytest.approx(23.452, abs=5e-4)
    assert two == pytest.approx(70.7107, abs=5e-5)
    # the paper truncates its second turn angle
    assert STEP * one == pytest.approx(0.05863, abs=5e-6)
    assert STEP * two == pytest.approx(0.17677, abs=1e-5)
    assert car.line_distances == pytest.approx((0.20, 0.19608), abs=5e-6)
    assert car.axle.tyre_ratio == pytest.approx(0.471, abs=5e-4)
    assert car.coupling == pytest.approx(1.0 / 0.11)
    assert car.axle.strut.rate / car.tyre_stiffness == pytest.approx(1.0 / 10.0)
    assert car.static_tyre_deflection == pytest.approx(0.02157, abs=5e-6)


@given(st.floats(0.0, 0.05))
def test_published_excitation(t):
    wanted = 2.5 * (1.0 - cos(40.0 * pi * t)) + 2.0 * pi / 3.0 * sin(40.0 * pi * t)
    assert 100.0 * ap57().axle.excitation(Window(t)) == pytest.approx(wanted, abs=1e-12)


def test_the_wheel_would_leave_the_road(without_lift_off):
    """The bracket of the tyre reaches 4.82 cm, more than twice the static deflection."""
    road = np.array([elevation(t) for t in np.arange(61) * STEP]).T
    _, x2, _, v2 = without_lift_off
    bracket = x2 - road[0] + K2 / C2 * (v2 - road[1])
    drawing = march(ap57(lift_off=False), step=STEP, steps=60)
    points = [frame.points for frame in drawing]
    assert 100.0 * bracket.max() == pytest.approx(4.82, abs=0.01)
    assert column(drawing, "contact_force").min() < 0.0
    assert max((p["B2"] - p["Q2"]).real / 2.5 for p in points) > 0.0215


# Geometry: what is constructed equals what the formulas say.

scale = st.floats(0.1, 10.0)
cars = st.builds(
    QuarterCarPlanes,
    sprung_mass=st.floats(50.0, 2000.0),
    unsprung_mass=st.floats(5.0, 200.0),
    spring=st.builds(cubic, st.floats(1e3, 1e5), st.floats(0.0, 1e6)),
    damper=st.builds(damper, st.floats(0.0, 5e3), st.floats(0.0, 5e3), st.just(400.0)),
    tyre_stiffness=st.floats(5e4, 1e6),
    tyre_damping=st.floats(0.0, 3e3),
    road=st.builds(roads.bump, st.floats(-0.1, 0.1), st.floats(0.5, 3.0), st.just(20.0)),
    plane_scales=st.tuples(scale, scale),
    plane_distance=st.floats(0.02, 2.0),
    plane_offset=st.floats(-0.5, 0.5),
    initial_deflection=st.floats(-0.1, 0.1),
    initial_deflection_rate=st.floats(-3.0, 3.0),
    initial_wheel_displacement=st.floats(-0.1, 0.1),
    initial_wheel_velocity=st.floats(-3.0, 3.0),
)
windows = st.builds(Window, st.floats(0.0, 0.2), st.one_of(st.just(0.0), st.floats(1e-4, 0.01)))


def excitation_by_quadrature(car: QuarterCarPlanes, window: Window) -> float:
    def h(t):
        return car.road.value(t) + car.tyre_damping / car.tyre_stiffness * car.road.rate(t)

    if window.duration == 0.0:
        return h(window.start)
    cuts = [
        window.start,
        *(t for t in car.road.joints if window.start < t < window.end),
        window.end,
    ]
    inside = [quad(h, a, b, epsabs=1e-14, epsrel=1e-12)[0] for a, b in pairwise(cuts)]
    return sum(inside) / window.duration


@given(cars, windows)
def test_projection_gives_the_feet_of_the_formulas(car, window):
    """D1 and D2 by points C1, C2 against the denominators of AP57 eqs. 18 and 30."""
    big, small = car.sprung_mass, car.unsprung_mass
    c1, c2, k2 = car.axle.strut.rate, car.tyre_stiffness, car.tyre_damping
    a, b = car.plane_scales
    y, v = car.initial_deflection, car.initial_deflection_rate
    x2, v2 = car.initial_wheel_displacement, car.initial_wheel_velocity
    force = car.damper.force(v) + car.spring.force(y)
    bracket = x2 + k2 / c2 * v2 - excitation_by_quadrature(car, window)
    weight = (big + small) * car.gravity / c2
    for mode, tyre in (("contact", bracket), ("flight", weight)):
        points = car.points(mode, car.initial, window)
        one = force / c1 - c2 / c1 * big / (big + small) * tyre
        two = tyre - force / c2
        size = max(abs(p) for p in points.values()) * (1.0 + a / b + b / a)
        tolerance = 1e-10 * (size + a * c2 / c1 * abs(tyre))
        assert abs((points["Q1"] - points["D1"]).real - a * one) < tolerance
        assert abs((points["D2"] - points["Q2"]).real - b * two) < tolerance
        assert points["D1"].imag == 0.0
        assert points["D2"].imag == -car.plane_distance


@given(cars, windows)
def test_points_lie_on_the_lines_that_give_them(car, window):
    points = car.points("contact", car.initial, window)

    def on_one_line(*names):
        p, q, r = (points[name] for name in names)
        size = max(abs(p - q), abs(q - r), 1e-6) ** 2
        return abs(((q - p).conjugate() * (r - p)).imag) < 1e-9 * size

    assert on_one_line("A1*", "C1", "B2")
    assert on_one_line("A1*", "C2", "B2")
    assert on_one_line("Q1", "C1", "D2")
    assert on_one_line("Q2", "C2", "D1")
    first, second = car.line_distances
    assert points["C1"].imag == -first
    assert points["C2"].imag == -second
    assert 0.0 < second < first < car.plane_distance


@given(cars)
def test_readings_balance_the_forces(car):
    """Accelerations read off as Q1D1 and Q2D2 (AP57 eqs. 23, 24) satisfy eqs. 12 and 29."""
    for mode in ("contact", "flight"):
        read = car.readings(mode, car.initial, 0.01, None, 0.0)
        y, v = read["suspension_deflection"], read["suspension_deflection_rate"]
        force = car.damper.force(v) + car.spring.force(y)
        tyre = (car.sprung_mass + car.unsprung_mass) * car.gravity - read["contact_force"]
        size = 1e-8 * (abs(force) + abs(tyre) + 1e3) * max(1.0, car.coupling)
        assert abs(car.sprung_mass * read["body_acceleration"] + force) < size * 10.0
        assert abs(car.unsprung_mass * read["wheel_acceleration"] - force + tyre) < size
        # the control (25) is the acceleration of the body by another way
        assert car.sprung_mass * read["control_body_acceleration"] == pytest.approx(
            -force, rel=1e-9, abs=1e-6
        )
        assert y == pytest.approx(car.initial_deflection, abs=1e-12)
        assert v == pytest.approx(car.initial_deflection_rate, abs=1e-10)
        assert read["wheel_displacement"] == pytest.approx(
            car.initial_wheel_displacement, abs=1e-12
        )
        assert read["wheel_velocity"] == pytest.approx(car.initial_wheel_velocity, abs=1e-9)


def test_the_normals_turn_in_opposite_senses():
    """Time runs clockwise in plane 1 and the other way in plane 2 (AP57 figure 8)."""
    frame = next(
        frames(ap57(initial_deflection=0.05, initial_wheel_displacement=0.05), step=1e-4, steps=1)
    )
    for number, sense in (("1", -1.0), ("2", 1.0)):
        p, d, successor = (frame.points[n] for n in (f"P{number}", f"D{number}", f"P{number}'"))
        assert ((p - d).conjugate() * (successor - p)).imag * sense > 0.0


# The worked example against an independent solution.


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [
        ("tangent", 0.65, 0.67),
        ("mean_normal", 1.00, 1.04),
        ("osculating_circle", 0.87, 0.89),
        ("velocity", 0.65, 0.67),
        ("midpoint_circle", 0.05, 0.06),
        ("delta", 0.02, 0.03),
    ],
)
def test_largest_error_of_the_worked_example(name, least, most, without_lift_off):
    """In y, x2 and x1 over 60 points of 2.5 ms, cm."""
    drawing = march(ap57(lift_off=False), RULES[name], step=STEP, steps=60)
    x1, x2, _, _ = without_lift_off[:, :-1]
    errors = [
        column(drawing, "suspension_deflection") - (x1 - x2),
        column(drawing, "wheel_displacement") - x2,
        column(drawing, "body_displacement") - x1,
    ]
    assert least <= 100.0 * np.max(np.abs(errors)) <= most


@pytest.mark.parametrize("name", ["delta", "midpoint_circle"])
def test_second_order_in_coupled_planes(name, without_lift_off):
    x1, x2, _, _ = without_lift_off[:, :-1]
    errors = []
    for parts in (1, 2, 4):
        drawing = march(ap57(lift_off=False), RULES[name], step=STEP / parts, steps=60 * parts)
        body = column(drawing, "body_displacement")[::parts] - x1
        wheel = column(drawing, "wheel_displacement")[::parts] - x2
        errors.append(np.max(np.abs([body, wheel])))
    orders = [log2(e / f) for e, f in pairwise(errors)]
    assert orders == pytest.approx([2.0, 2.0], abs=0.15)


def test_the_control_agrees_to_the_error_of_the_step():
    """x1 = x2 + y (24) against (25) integrated twice."""
    apart = []
    for parts in (1, 2, 4):
        drawing = march(ap57(), step=STEP / parts, duration=0.15)
        difference = column(drawing, "body_displacement") - column(
            drawing, "control_body_displacement"
        )
        accelerations = column(drawing, "body_acceleration") - column(
            drawing, "control_body_acceleration"
        )
        assert np.max(np.abs(accelerations)) < 1e-10
        apart.append(np.max(np.abs(difference)))
    assert apart[0] < 5e-4
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2] > 0.0


# Lift-off.


def test_lift_off_and_touchdown_converge(lift_off_and_touchdown):
    lift_off, touchdown = lift_off_and_touchdown
    assert 1e3 * touchdown == pytest.approx(65.6, abs=0.05)
    for step in (STEP, STEP / 2, STEP / 4, STEP / 8):
        found = {f.event: f.time for f in frames(ap57(), step=step, duration=0.15) if f.event}
        assert list(found) == ["lift_off", "touchdown"]
        assert abs(found["lift_off"] - lift_off) < 7.0 * step**2
        assert abs(found["touchdown"] - touchdown) < 7.0 * step**2


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_steps_end_on_u_and_v(rule):
    """There B2Q2 = b x2st (AP57 eq. 28), so that B2 and B0 are one point."""
    car = ap57(plane_scales=(0.7, 3.1), plane_offset=0.03)
    drawing = march(car, rule, step=STEP, duration=0.15)
    events = [frame for frame in drawing if frame.event]
    assert [f.event for f in events] == ["lift_off", "touchdown"]
    assert [f.scheme for f in events] == ["flight", "contact"]
    for frame in events:
        states = (frame.points["P1"], frame.points["P2"])
        points = car.points(frame.scheme, states, Window(frame.time))
        assert abs(points["B2"] - points["B0"]) < 1e-13
        length = (points["B2"] - points["Q2"]).real
        assert length == pytest.approx(3.1 * (M + m) * 9.80665 / C2, rel=1e-11)
        # the two constructions agree there: the tyre's force is continuous
        other = car.points("contact", states, Window(frame.time))
        flight = car.points("flight", states, Window(frame.time))
        assert abs(other["D1"] - flight["D1"]) < 1e-12
        assert abs(other["D2"] - flight["D2"]) < 1e-12


def test_steps_follow_one_another_without_a_gap():
    drawing = march(ap57(), step=STEP, duration=0.15)
    for frame, following in pairwise(drawing.frames):
        assert following.time == pytest.approx(frame.time + frame.duration, abs=1e-15)
        assert following.points["P1"] == frame.points["P1'"]
        assert following.points["P2"] == frame.points["P2'"]
    ends = {round((f.time + f.duration) / STEP, 6) for f in drawing}
    assert ends >= set(range(1, 61))
    assert len(drawing.frames) == 62
    flights = [f for f in drawing if f.scheme == "flight"]
    assert all(f.readings["contact_force"] == 0.0 for f in flights)
    assert column(drawing, "contact_force").min() > -1e-9
    assert all("C2" in f.points for f in drawing if f.scheme == "contact")
    assert all("C2" not in f.points for f in flights)


def test_in_flight_the_centre_of_mass_falls_freely():
    drawing = march(ap57(), step=STEP / 8, duration=0.15)
    for frame in drawing:
        if frame.scheme == "flight":
            read = frame.readings
            pull = M * read["body_acceleration"] + m * read["wheel_acceleration"]
            assert pull == pytest.approx(-(M + m) * 9.80665, rel=1e-10)


def test_a_wheel_that_hangs_in_the_air_falls_and_bounces():
    """A drop of half a metre: it begins in flight, and every flight ends with a touchdown."""
    car = ap57(
        road=roads.constant(),
        damper=linear(300.0),
        tyre_damping=100.0,
        initial_wheel_displacement=0.5,
    )
    drawing = march(car, step=0.001, duration=1.5)
    assert drawing.frames[0].scheme == "flight"
    events = [f.event for f in drawing if f.event]
    assert events[0] == "touchdown"
    assert len(events) >= 3
    assert all(one != other for one, other in pairwise(events))


def test_a_wheel_that_only_just_loses_the_road_does_not_hang_the_march():
    """Bumps about the height at which lift-off begins, with rules of the first order too."""
    for height in np.linspace(0.004, 0.02, 9):
        for rule in (RULES["tangent"], delta):
            made = list(frames(ap57(road=roads.bump(height, 1.0, 20.0)), rule, step=STEP, steps=40))
            events = [f.event for f in made if f.event]
            assert len(made) == 40 + len(events) or len(made) == 40
            assert all(f.duration > 0.0 for f in made)
            assert made[-1].time + made[-1].duration == pytest.approx(0.1, abs=1e-12)


class Touching(OneDofPlane):
    """Changes its mode at 10 ms, where the margin of the new mode is a rounding error and falls."""

    def margins(self, mode, states, time):
        if mode == "flight":
            return (1e-18 - 1e-3 * (time - 0.01),)
        return (0.01 - time if time < 0.013 else 1.0,)

    def succeeding(self, mode, limit):
        return "flight" if mode == "contact" else "contact"

    def event(self, mode, successor):
        return "lift_off" if successor == "flight" else "touchdown"


def test_a_limit_that_is_only_touched_does_not_stop_the_march():
    one = Touching(1.0, linear(100.0), linear(0.0), initial_deflection=0.1)
    made = list(islice(frames(one, step=0.004, duration=0.02), 10))
    ends = [f.time + f.duration for f in made]
    assert ends == pytest.approx([0.004, 0.008, 0.01, 0.012, 0.016, 0.02])
    assert [f.event for f in made] == ["", "", "", "lift_off", "touchdown", ""]


def test_without_lift_off_the_wheel_sticks_to_the_road():
    drawing = march(ap57(lift_off=False), step=STEP, duration=0.15)
    assert {f.scheme for f in drawing} == {"contact"}
    assert not any(f.event for f in drawing)


# The drawing as data.


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_every_point_that_a_scheme_joins_is_there(rule):
    drawing = march(ap57(), rule, step=STEP, duration=0.1)
    assert set(drawing.schemes) == {"contact", "flight"}
    for frame in drawing:
        scheme = drawing.schemes[frame.scheme]
        names = {mark.point for mark in scheme.marks}
        names |= {n for s in scheme.strokes for n in (s.start, s.end)}
        names |= {n for arc in scheme.arcs for n in (arc.centre, arc.start, arc.end)}
        assert names <= set(frame.points)
        assert all(np.isfinite(p) for p in frame.points.values())
        parts = (*scheme.marks, *scheme.strokes, *scheme.arcs)
        assert {part.stage for part in parts} == set(range(len(scheme.stages)))


def test_what_stays_on_the_sheet():
    drawing = march(ap57(), step=STEP, duration=0.15)
    by_label = {curve.label: curve for curve in drawing.curves}
    assert {z.imag for z in by_label["I"].vertices} == {-0.2}
    assert by_label["II"].vertices[0].imag == pytest.approx(-0.19608, abs=5e-6)
    vertex = drawing.frames[0].points["W"]
    for label, turn in (("dtau1", 0.05863), ("dtau2", 0.17678)):
        arm = by_label[label].vertices[1] - vertex
        assert np.angle(arm) == pytest.approx(turn, abs=5e-6)
    one, two = (c for c in drawing.curves if c.role == "auxiliary")
    # the line y2 = -(k2/c2) Omega2 y-bar2 through the origin of plane 2
    way = two.vertices[-1] - two.vertices[0]
    assert way.real / way.imag == pytest.approx(0.4714, abs=5e-5)
    assert min(abs(z + 0.25j) for z in two.vertices) < 1e-12
    for frame in drawing:
        a = frame.points["A1"]
        spread = np.interp(a.imag, [z.imag for z in one.vertices], [z.real for z in one.vertices])
        assert spread == pytest.approx(a.real, abs=1e-12)
    state, wheel = drawing.planes
    p1, p2 = drawing.frames[10].points["P1"], drawing.frames[10].points["P2"]
    read = drawing.frames[10].readings
    assert state.displacement.read(p1) == pytest.approx(read["suspension_deflection"])
    assert wheel.displacement.read(p2) == pytest.approx(read["wheel_displacement"])
    assert 70.71067811865476 * wheel.scaled_velocity.read(p2) == pytest.approx(
        read["wheel_velocity"]
    )


@given(st.tuples(scale, scale), st.floats(0.1, 1.0), st.floats(-0.2, 0.2))
def test_the_motion_does_not_depend_on_the_sheet(scales, distance, offset):
    other = ap57(plane_scales=scales, plane_distance=distance, plane_offset=offset)
    one = march(ap57(), step=STEP, steps=20).frames[-1].readings
    two = march(other, step=STEP, steps=20).frames[-1].readings
    for name, value in one.items():
        assert two[name] == pytest.approx(value, rel=1e-7, abs=1e-7)


def test_a_stop_in_the_spring_is_felt():
    stop = ap57(spring=linear(C1) + bump_stop(0.03, 10.0 * C1))
    bare = column(march(ap57(), step=STEP / 4, duration=0.15), "suspension_deflection")
    held = column(march(stop, step=STEP / 4, duration=0.15), "suspension_deflection")
    assert bare.min() < -0.045
    assert bare.min() + 0.002 < held.min() < -0.03


# Laid over a given motion.


def test_laid_over_a_solution_it_drifts_by_the_local_error():
    times = np.arange(121) * STEP / 2
    (x1, x2, v1, v2), _ = by_scipy(times, lift_off=False)
    car = ap57(lift_off=False)
    drawing = overlay(car, times, x1 - x2, v1 - v2, x2, v2)
    assert [f.time for f in drawing] == pytest.approx(list(times[:-1]))
    assert np.allclose(column(drawing, "suspension_deflection"), (x1 - x2)[:-1], atol=1e-15)
    assert np.allclose(column(drawing, "wheel_velocity"), v2[:-1], atol=1e-13)
    fine = max(f.readings["wheel_displacement_drift"] for f in drawing)
    halved = (z[::2] for z in (times, x1 - x2, v1 - v2, x2, v2))
    coarse = max(f.readings["wheel_displacement_drift"] for f in overlay(car, *halved))
    assert 0.0 < fine < 1e-4
    assert coarse / fine == pytest.approx(8.0, abs=2.0)


def test_laid_over_its_own_march_it_does_not_drift_even_in_flight():
    drawing = march(ap57(), step=STEP, duration=0.15)
    names = (
        "suspension_deflection", "suspension_deflection_rate", "wheel_displacement", "wheel_velocity",
    )  # fmt: skip
    rows = [column(drawing, name) for name in names]
    airborne = [frame.scheme == "flight" for frame in drawing]
    times = [frame.time for frame in drawing]
    laid = overlay(ap57(), times, *rows, airborne=airborne)
    for name in ("suspension_deflection_drift", "wheel_displacement_drift"):
        assert max(frame.readings[name] for frame in laid) < 1e-14
    assert [f.event for f in laid if f.event] == ["lift_off", "touchdown"]
    for one, other in zip(drawing.frames, laid.frames, strict=False):
        assert one.readings["control_body_displacement"] == pytest.approx(
            other.readings["control_body_displacement"], abs=1e-13
        )


def test_instants_given_twice_count_once():
    rows = [[0.0, 0.01, 0.01, 0.02], *([[0.0, 0.0, 0.001, 0.001]] * 4)]
    drawing = overlay(ap57(), *rows)
    assert [f.time for f in drawing] == [0.0, 0.01]
    assert drawing.frames[1].readings["suspension_deflection"] == pytest.approx(0.001)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ([[0.0, 0.1]] * 4, "3 columns given; displacement and velocity of .* make 4"),
        ([[0.0, 0.1], *[[0.0]] * 4], "one length, at least 2; given 2, 1, 1, 1, 1"),
        ([[0.0, 0.1], *[[0.0, nan]] * 4], r"row 1 .* \(time 0.1 s\) is not finite"),
        ([[0.1, 0.0], *[[0.0, 0.0]] * 4], "times must ascend, but 0 s follows 0.1 s"),
        ([[0.1, 0.1], *[[0.0, 0.0]] * 4], "at least two different instants"),
    ],
)
def test_a_motion_that_cannot_be_drawn_is_refused(columns, message):
    with pytest.raises(ValueError, match=message):
        overlay(ap57(), *columns)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sprung_mass": -1.0}, r"sprung_mass = -1\.0: must be finite and greater than 0"),
        ({"unsprung_mass": 0.0}, "unsprung_mass = 0.0"),
        ({"tyre_stiffness": nan}, "tyre_stiffness = nan"),
        ({"tyre_damping": -1.0}, "tyre_damping = -1.0: must be finite and at least 0"),
        ({"gravity": 0.0}, "gravity = 0.0: must be finite and greater than 0"),
        ({"plane_scales": (1.0, 0.0)}, "plane scale b = 0.0"),
        ({"plane_distance": -0.2}, "plane_distance = -0.2"),
        ({"plane_offset": inf}, "plane_offset = inf"),
        ({"initial_wheel_velocity": nan}, "initial_wheel_velocity = nan"),
        ({"spring": linear(-3.0)}, "rate at zero deflection is -3 N/m"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        ap57(**changes)


def test_without_lift_off_weight_may_be_absent():
    assert replace(ap57(), gravity=0.0, lift_off=False).static_tyre_deflection == 0.0


# The mean of the road over a step.

segments = st.builds(
    roads.Segment,
    start=st.just(-inf),
    origin=st.floats(-1.0, 1.0),
    coefficients=st.tuples(*[st.floats(-1.0, 1.0)] * 4),
    amplitude=st.floats(-1.0, 1.0),
    phase=st.tuples(
        st.floats(-3.0, 3.0), st.floats(-50.0, 50.0), st.sampled_from((0.0, 5.0, -20.0))
    ),
)


@given(segments, segments, st.floats(-1.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_integral_of_a_road_over_a_joint(before, after, joint, back, ahead):
    road = roads.Signal((before, replace(after, start=joint)))
    start, end = joint - back, joint + ahead
    wanted = (
        quad(lambda t: before.derivatives(t)[0], start, joint, limit=200)[0]
        + quad(lambda t: after.derivatives(t)[0], joint, end, limit=200)[0]
    )
    assert road.integral(start, end) == pytest.approx(wanted, abs=1e-7)
    assert road.integral(end, start) == -road.integral(start, end)


def test_integral_of_a_bump():
    road = roads.bump(0.05, 1.0, 20.0, start=0.1)
    assert road.integral(0.0, 1.0) == pytest.approx(0.5 * 0.05 * 0.05, rel=1e-13)
    assert road.integral(0.1, 0.125) == pytest.approx(0.25 * 0.05 * 0.05, rel=1e-13)
