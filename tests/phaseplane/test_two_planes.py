"""The construction of the quarter car, with and without lift-off."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, inf, log2, nan, pi, sin

import numpy as np
import pytest
from drawn_axles import AXLES
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import bump_stop, cubic, linear
from recorded import check_schemes
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from worked_example import C1, C2, K2, KGF, STEP, M, ap57, by_scipy, column, elevation, m

from phaseplane.constructions import (
    RULES,
    QuarterCarPlanes,
    Strut,
    Window,
    construct_motion,
    frames,
)


@pytest.fixture(scope="module")
def without_lift_off() -> np.ndarray:
    return by_scipy(np.arange(61) * STEP, lift_off=False)[0]


# Published numbers (AP57 section 8; its kgf, cm, s).


def test_published_constants():
    car = ap57()
    one, two = car.axles[0].angular_frequencies
    assert one == pytest.approx(23.452, abs=5e-4)
    assert two == pytest.approx(70.7107, abs=5e-5)
    # the paper truncates its second turn angle
    assert STEP * one == pytest.approx(0.05863, abs=5e-6)
    assert STEP * two == pytest.approx(0.17677, abs=1e-5)
    lines = car.axles[0].lines
    assert (lines.line_1, lines.line_2) == pytest.approx((-0.20, -0.19608), abs=5e-6)
    assert car.axles[0].wheel.epsilon(1.0, 0.0) == pytest.approx(0.471, abs=5e-4)
    assert car.axles[0].coupling == pytest.approx(1.0 / 0.11)
    assert car.axles[0].strut.rate / car.axle.tyre_stiffness == pytest.approx(1.0 / 10.0)
    assert car.axles[0].static_tyre_deflection == pytest.approx(0.02157, abs=5e-6)


@given(st.floats(0.0, 0.05))
def test_published_excitation(t):
    wanted = 2.5 * (1.0 - cos(40.0 * pi * t)) + 2.0 * pi / 3.0 * sin(40.0 * pi * t)
    assert 100.0 * ap57().axles[0].excitation(Window(t)) == pytest.approx(wanted, abs=1e-12)


def test_the_wheel_would_leave_the_road(without_lift_off):
    """The bracket of the tyre reaches 4.82 cm, more than twice the static deflection."""
    road = np.array([elevation(t) for t in np.arange(61) * STEP]).T
    _, x2, _, v2 = without_lift_off
    bracket = x2 - road[0] + K2 / C2 * (v2 - road[1])
    drawing = construct_motion(ap57(lift_off=False), step=STEP, steps=60)
    points = [frame.points for frame in drawing]
    assert 100.0 * bracket.max() == pytest.approx(4.82, abs=0.01)
    assert column(drawing, "contact_force").min() < 0.0
    assert max((p["B2"] - p["Q2"]).real / 2.5 for p in points) > 0.0215


# Geometry: what is constructed equals what the formulas say.

scale = st.floats(0.1, 10.0)
cars = st.builds(
    QuarterCarPlanes,
    sprung_mass=st.floats(50.0, 2000.0),
    axle=AXLES,
    plane_scales=st.tuples(scale, scale),
    plane_distance=st.floats(0.02, 2.0),
)
windows = st.builds(Window, st.floats(0.0, 0.2), st.one_of(st.just(0.0), st.floats(1e-4, 0.01)))


def excitation_by_quadrature(car: QuarterCarPlanes, window: Window) -> float:
    road, lag = car.axle.road, car.axle.tyre_damping / car.axle.tyre_stiffness

    def h(t):
        return road.value(t) + lag * road.rate(t)

    if window.duration == 0.0:
        return h(window.start)
    within = (t for t in road.joints if window.start < t < window.end)
    cuts = [window.start, *within, window.end]
    inside = [quad(h, a, b, epsabs=1e-14, epsrel=1e-12)[0] for a, b in pairwise(cuts)]
    return sum(inside) / window.duration


@given(cars, windows)
def test_projection_gives_the_feet_of_the_formulas(car, window):
    """D1 and D2 by points C1, C2 against the denominators of AP57 eqs. 18 and 30."""
    big, small = car.sprung_mass, car.axle.unsprung_mass
    c1, c2, k2 = car.axles[0].strut.rate, car.axle.tyre_stiffness, car.axle.tyre_damping
    a, b = car.plane_scales
    y, v, x2, v2 = car.axle.initial
    force = car.axle.damper.force(v) + car.axle.spring.force(y)
    bracket = x2 + k2 / c2 * v2 - excitation_by_quadrature(car, window)
    weight = car.axle.static_load / c2
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


@pytest.mark.slow
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
    lines = car.axles[0].lines
    assert points["C1"].imag == lines.line_1
    assert points["C2"].imag == lines.line_2
    assert 0.0 > lines.line_2 > lines.line_1 > -car.plane_distance


@given(cars)
def test_readings_balance_the_forces(car):
    """Accelerations read off as Q1D1 and Q2D2 (AP57 eqs. 23, 24) satisfy eqs. 12 and 29."""
    for mode in ("contact", "flight"):
        read = car.readings(mode, car.initial, 0.01, None)
        y, v = read["suspension_deflection"], read["suspension_deflection_rate"]
        force = car.axle.damper.force(v) + car.axle.spring.force(y)
        tyre = car.axle.static_load - read["contact_force"]
        size = 1e-8 * (abs(force) + abs(tyre) + 1e3) * max(1.0, car.axles[0].coupling)
        assert abs(car.sprung_mass * read["body_acceleration"] + force) < size * 10.0
        assert abs(car.axle.unsprung_mass * read["wheel_acceleration"] - force + tyre) < size
        # the control (25) is the acceleration of the body by another way
        assert car.sprung_mass * read["control_body_acceleration"] == pytest.approx(
            -force, rel=1e-9, abs=1e-6
        )
        motion = (y, v, read["wheel_displacement"], read["wheel_velocity"])
        assert motion == pytest.approx(car.axle.initial, rel=0.0, abs=1e-9)


def test_the_normals_turn_in_opposite_senses():
    """Time runs clockwise in plane 1 and the other way in plane 2 (AP57 figure 8)."""
    frame = next(frames(ap57(initial=(0.05, 0.0, 0.05, 0.0)), step=1e-4, steps=1))
    for number, sense in (("1", -1.0), ("2", 1.0)):
        p, d, successor = (frame.points[n] for n in (f"P{number}", f"D{number}", f"P{number}'"))
        assert ((p - d).conjugate() * (successor - p)).imag * sense > 0.0


# The worked example against an independent solution.


class RoadAtTheStart(QuarterCarPlanes):
    """A quarter car drawn with h2 at the start of each step in place of its mean."""

    def points(self, mode, states, window):
        return super().points(mode, states, Window(window.start))


@pytest.mark.parametrize(
    ("name", "least", "most", "kind"),
    [
        ("tangent", 0.65, 0.67, QuarterCarPlanes),
        ("mean_normal", 1.00, 1.04, QuarterCarPlanes),
        ("osculating_circle", 0.87, 0.89, QuarterCarPlanes),
        ("velocity", 0.65, 0.67, QuarterCarPlanes),
        ("midpoint_circle", 0.05, 0.06, QuarterCarPlanes),
        ("delta", 0.02, 0.03, QuarterCarPlanes),
        ("delta", 0.29, 0.31, RoadAtTheStart),
    ],
)
def test_largest_error_of_the_worked_example(name, least, most, kind, without_lift_off):
    """In y, x2 and x1 over 60 points of 2.5 ms, cm."""
    drawing = construct_motion(ap57(kind, lift_off=False), RULES[name], step=STEP, steps=60)
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
        drawing = construct_motion(
            ap57(lift_off=False), RULES[name], step=STEP / parts, steps=60 * parts
        )
        body = column(drawing, "body_displacement")[::parts] - x1
        wheel = column(drawing, "wheel_displacement")[::parts] - x2
        errors.append(np.max(np.abs([body, wheel])))
    orders = [log2(e / f) for e, f in pairwise(errors)]
    assert orders == pytest.approx([2.0, 2.0], abs=0.15)


def test_the_control_agrees_to_the_error_of_the_step():
    """x1 = x2 + y (24) against (25) integrated twice."""
    apart = []
    for parts in (1, 2, 4):
        drawing = construct_motion(ap57(contact="force"), step=STEP / parts, duration=0.15)
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


# The drawing as data.


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_every_point_that_a_scheme_joins_is_there(rule):
    drawing = construct_motion(ap57(), rule, step=STEP, duration=0.1)
    assert set(drawing.schemes) == {"contact", "flight"}
    check_schemes(drawing)


def test_what_stays_on_the_sheet():
    drawing = construct_motion(ap57(), step=STEP, duration=0.15)
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


@pytest.mark.slow
@given(st.tuples(scale, scale), st.floats(0.1, 1.0))
def test_the_motion_does_not_depend_on_the_sheet(scales, distance):
    other = ap57(plane_scales=scales, plane_distance=distance)
    one = construct_motion(ap57(), step=STEP, steps=20).frames[-1].readings
    two = construct_motion(other, step=STEP, steps=20).frames[-1].readings
    for name, value in one.items():
        assert two[name] == pytest.approx(value, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("height", [50.0, 120.0, 500.0])
def test_a_motion_is_as_large_in_flight_as_the_road_that_threw_the_wheel_up(height):
    """120 m: it is first farther than 100 m of paper from the origin in flight, where no road is seen."""
    road = roads.bump(height, 1.0, 20.0)
    one, two = (
        construct_motion(ap57(road=road, plane_scales=(scale, scale)), step=STEP, duration=0.15)
        for scale in (1.0, 1e-3)
    )
    assert any(frame.mode == "flight" for frame in one.frames)
    for name, value in one.frames[-1].readings.items():
        assert two.frames[-1].readings[name] == pytest.approx(value, rel=1e-7, abs=1e-7)


def test_a_stop_in_the_spring_is_felt():
    stop = ap57(spring=linear(C1) + bump_stop(0.03, 10.0 * C1))
    bare = column(construct_motion(ap57(), step=STEP / 4, duration=0.15), "suspension_deflection")
    held = column(construct_motion(stop, step=STEP / 4, duration=0.15), "suspension_deflection")
    assert bare.min() < -0.045
    assert bare.min() + 0.002 < held.min() < -0.03


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sprung_mass": -1.0}, r"sprung_mass = -1\.0: must be finite and greater than 0"),
        ({"unsprung_mass": 0.0}, "unsprung_mass = 0.0"),
        ({"tyre_stiffness": nan}, "tyre_stiffness = nan"),
        ({"tyre_damping": -1.0}, "tyre_damping = -1.0: must be finite and at least 0"),
        ({"static_load": -1.0}, "static_load = -1.0: must be finite and at least 0"),
        ({"plane_scales": (1.0, 0.0)}, "the second of plane_scales = 0.0"),
        ({"plane_distance": -0.2}, "plane_distance = -0.2"),
        ({"initial": (0.0, 0.0, 0.0, nan)}, "must be four finite numbers"),
        ({"initial": (0.0, 0.0)}, "must be four finite numbers"),
        ({"spring": linear(-3.0)}, "rate at zero deflection is -3 N/m"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        ap57(**changes)


def test_weight_may_be_absent():
    assert ap57(static_load=0.0).axles[0].static_tyre_deflection == 0.0


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


def integral(segment: roads.Segment, start: float, end: float) -> float:
    """By Gauss's rule of 200 points: exact to rounding for waves of 70 rad (quad gives up there)."""
    points, weights = np.polynomial.legendre.leggauss(200)
    half = 0.5 * (end - start)
    values = [segment.derivatives(start + half * (1.0 + x))[0] for x in points.tolist()]
    return half * float(weights @ values)


@pytest.mark.slow
@given(segments, segments, st.floats(-1.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_integral_of_a_road_over_a_joint(before, after, joint, back, ahead):
    road = roads.Signal((before, after._replace(start=joint)))
    start, end = joint - back, joint + ahead
    wanted = integral(before, start, joint) + integral(after, joint, end)
    assert road.integral(start, end) == pytest.approx(wanted, abs=1e-7)
    assert road.integral(end, start) == -road.integral(start, end)


def test_integral_of_a_bump():
    road = roads.bump(0.05, 1.0, 20.0, start=0.1)
    assert road.integral(0.0, 1.0) == pytest.approx(0.5 * 0.05 * 0.05, rel=1e-13)
    assert road.integral(0.1, 0.125) == pytest.approx(0.25 * 0.05 * 0.05, rel=1e-13)


# A tyre that is not linear.


def hard_tyre(**changes) -> QuarterCarPlanes:
    law = Strut(cubic(C2, 4e7), lambda rate, y: K2 * rate * (1.0 + 8.0 * y))
    return ap57(**({"tyre_stiffness": 0.0, "tyre_damping": 0.0, "tyre": law} | changes))


def test_a_linear_tyre_moves_alike_in_either_plane():
    """Over y2 = x2 - xi with xi'' as over x2 with h2, to the error of the step."""
    law = Strut(linear(C2), linear(K2))
    apart = []
    for parts in (1, 2, 4):
        ends = [
            construct_motion(car, step=STEP / parts, duration=0.15).frames[-1].readings
            for car in (ap57(), ap57(tyre_stiffness=0.0, tyre_damping=0.0, tyre=law))
        ]
        apart.append(abs(ends[0]["wheel_displacement"] - ends[1]["wheel_displacement"]))
    assert apart[0] < 1e-3
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2] > 0.0


@given(cars, windows)
def test_projection_gives_the_feet_of_the_formulas_for_any_tyre(car, window):
    """D1 and H2 against (18) with the bracket (f + phi) / c2, and xi'' / Omega2^2 in plane 2 alone."""
    law = Strut(cubic(car.axle.tyre_stiffness, 1e6), linear(car.axle.tyre_damping))
    data = replace(car.axle, tyre_stiffness=0.0, tyre_damping=0.0, tyre=law)
    one = replace(car, axle=data)
    points = one.points("contact", one.initial, window)
    c1, c2 = one.axles[0].strut.rate, car.axle.tyre_stiffness
    a, b = one.plane_scales
    elevation, rise, acceleration, _ = one.axle.road.derivatives(0.0)
    deflection, rate, x2, v2 = data.initial
    y, v = x2 - elevation, v2 - rise
    bracket = law.force(v, y) / c2
    force = data.damper.force(rate) + data.spring.force(deflection)
    if window.duration:
        change = one.axle.road.rate(window.end) - one.axle.road.rate(window.start)
        acceleration = change / window.duration
    else:
        acceleration = one.axle.road.acceleration(window.start)
    first = force / c1 - one.axles[0].coupling * bracket
    second = bracket - force / c2 + acceleration * one.axle.unsprung_mass / c2
    size = max(abs(p) for p in points.values()) * (1.0 + a / b + b / a)
    tolerance = 1e-10 * (size + a * one.axles[0].coupling * abs(bracket) + b)
    assert abs((points["Q1"] - points["D1"]).real - a * first) < tolerance
    assert abs((points["H2"] - points["Q2"]).real - b * second) < tolerance
    assert "B2" not in points


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_a_hardening_tyre_against_an_independent_solution(contact):
    car = hard_tyre(contact=contact)
    weight = (M + m) * 9.80665
    free = brentq(lambda y: C2 * y + 4e7 * y**3 - weight, 0.0, 0.1)  # of the unloaded tyre, m

    def bracket(t, z):
        xi, rise = elevation(t)
        y, rate = z[1] - xi, z[3] - rise
        return C2 * y + 4e7 * y**3 + K2 * rate * (1.0 + 8.0 * y)

    def slope(t, z, flies):
        rate = z[2] - z[3]
        force = C1 * (z[0] - z[1]) + (200.0 if rate > 0.0 else 50.0) * KGF * rate
        tyre = weight if flies else bracket(t, z)
        return z[2], z[3], -force / M, (force - tyre) / m

    time, state, flies, switches = 0.0, np.zeros(4), False, []
    while time < 0.15:

        def switch(t, z, flies):
            force, gap = bracket(t, z) - weight, C2 * (z[1] - elevation(t)[0] - free)
            return force if contact == "force" else max(force, gap)

        switch.terminal, switch.direction = True, -1.0 if flies else 1.0
        end = 0.05 if time < 0.05 else 0.15
        solution = solve_ivp(slope, (time, end), state, args=(flies,), events=switch,
                             method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.002)  # fmt: skip
        time, state = solution.t[-1], solution.y[:, -1]
        if solution.status == 1:
            switches.append(time)
            flies = not flies
    errors = []
    for parts in (4, 8):
        drawing = construct_motion(car, step=STEP / parts, duration=0.15)
        last = drawing.frames[-1].points
        y = [lienard.plane.displacement.read(last[f"{lienard.plane.state}'"])
             for lienard in (car.axles[0].suspension, car.axles[0].wheel)]  # fmt: skip
        errors.append(max(abs(y[1] - state[1]), abs(y[0] - state[0] + state[1])))
        events = [f.time for f in drawing if f.event]
        assert events == pytest.approx(switches, abs=6e-4 / parts)
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=1.2)
    assert {f.scheme for f in drawing} == {"contact", "flight"}
    assert "H2" in {mark.point for mark in drawing.schemes["contact"].marks}


def test_stiffness_and_a_tyre_exclude_each_other():
    with pytest.raises(ValueError, match="give either tyre_stiffness and tyre_damping or a tyre"):
        hard_tyre(tyre_stiffness=C2)


# A damper that depends on deflection, and its family of auxiliary curves.


def test_between_the_curves_of_a_family_the_point_is_interpolated():
    def progressive(rate: float, y: float) -> float:
        return 1200.0 * rate * (1.0 + 200.0 * y * y)

    own = construct_motion(ap57(damper=progressive), step=STEP, duration=0.15).frames[-1].points
    apart = []
    for count in (5, 9, 17):
        levels = tuple(np.linspace(-0.06, 0.06, count))
        car = ap57(damper=progressive, auxiliary_levels=levels)
        drawing = construct_motion(car, step=STEP, duration=0.15)
        apart.append(abs(drawing.frames[-1].points["P1'"] - own["P1'"]))
        curves = [c for c in drawing.curves if c.role == "auxiliary"]
        labels = [label for c in curves for label in c.label.split(" and ")]
        assert len(labels) == count + 1  # and the line of plane 2
        assert labels[0] == "y1 = -6 cm"
    assert apart[0] > 2.5 * apart[1] > 6.0 * apart[2] > 0.0
    car = ap57(damper=progressive, auxiliary_levels=(-0.05, 0.0, 0.05),
               initial=(0.02, 0.5, 0.0, 0.0))  # fmt: skip
    a = car.points("contact", car.initial, Window(0.0))["A1"].real
    between = [-progressive(0.5, y) / C1 for y in (0.0, 0.05)]
    assert a == pytest.approx(0.6 * between[0] + 0.4 * between[1], rel=1e-12)


def test_a_step_too_long_for_a_stiff_stop_says_when_it_leaves_the_sheet():
    car = ap57(spring=linear(C1) + bump_stop(0.02, 1e9))
    with pytest.raises(ArithmeticError, match=r"diverges after 0\.0\d+ s; try a step shorter"):
        construct_motion(car, step=STEP, duration=0.5)


@pytest.mark.parametrize(
    ("changes", "plane"),
    [({"tyre_damping": 4e4}, "wheel_displacement"),
     ({"damper": linear(4e4)}, "suspension_deflection")],
)  # fmt: skip
def test_damping_too_strong_for_the_step_is_refused_in_either_plane(changes, plane):
    with pytest.raises(ArithmeticError, match=f"too long for the damping in the plane {plane}"):
        construct_motion(ap57(**changes), step=STEP, duration=0.5)
