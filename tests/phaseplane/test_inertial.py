"""The construction of the half car on rigid tyres, for a coupling mass of either sign."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import log2, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import cubic, damper, linear
from recorded import check_schemes
from scipy.integrate import solve_ivp

from phaseplane.constructions import RULES, HalfCarRigidTyresPlanes, Window, construct_motion

FRONT = roads.bump(0.05, 3.0, 12.0)
REAR = FRONT.delayed(2.5 / 12.0)


def car(coupling: float = 90.0, **changes) -> HalfCarRigidTyresPlanes:
    data = {
        "front_mass": 330.0,
        "rear_mass": 280.0,
        "coupling_mass": coupling,
        "front_spring": linear(15000.0),
        "rear_spring": cubic(18000.0, 3e6),
        "front_damper": damper(1500.0, 400.0),
        "rear_damper": damper(1300.0, 500.0, 200.0, 0.0, 100.0),
        "front_road": FRONT,
        "rear_road": REAR,
    }
    return HalfCarRigidTyresPlanes(**(data | changes))


scale = st.floats(0.1, 10.0)
cars = st.builds(
    HalfCarRigidTyresPlanes,
    front_mass=st.floats(100.0, 1000.0),
    rear_mass=st.floats(100.0, 1000.0),
    coupling_mass=st.floats(-95.0, 95.0),
    front_spring=st.builds(cubic, st.floats(1e3, 1e5), st.floats(0.0, 1e6)),
    rear_spring=st.builds(cubic, st.floats(1e3, 1e5), st.floats(0.0, 1e6)),
    front_damper=st.builds(damper, st.floats(0.0, 5e3), st.floats(0.0, 5e3), st.just(400.0)),
    rear_damper=st.builds(damper, st.floats(0.0, 5e3), st.floats(0.0, 5e3)),
    front_road=st.builds(roads.bump, st.floats(-0.1, 0.1), st.floats(0.5, 3.0), st.just(20.0)),
    rear_road=st.builds(roads.bump, st.floats(-0.1, 0.1), st.floats(0.5, 3.0), st.just(20.0)),
    plane_scales=st.tuples(scale, scale),
    plane_distance=st.floats(0.02, 2.0),
    initial_deflections=st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)),
    initial_rates=st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
)
windows = st.builds(Window, st.floats(0.0, 0.2), st.floats(1e-4, 0.01))


@given(cars, windows)
def test_projection_gives_the_feet_of_the_formulas(one, window):
    """D and H by points C1, C2 against the denominators of AP57 eq. 37."""
    points = one.points("contact", one.initial, window)
    m1, m2, m3 = one.front_mass, one.rear_mass, one.coupling_mass
    c = one.front_spring.tangent(0.0), one.rear_spring.tangent(0.0)
    y, v = one.initial_deflections, one.initial_rates
    force = (
        one.front_spring.force(y[0]) + one.front_damper.force(v[0]),
        one.rear_spring.force(y[1]) + one.rear_damper.force(v[1]),
    )
    length = [f / rate for f, rate in zip(force, c, strict=True)]  # y + epsilon
    kappa = m3 / m2 * c[1] / c[0], m3 / m1 * c[0] / c[1]
    square = [rate * other / (m1 * m2 - m3**2) for rate, other in zip(c, (m2, m1), strict=True)]
    senses = (1.0, -1.0 if m3 >= 0.0 else 1.0)
    for i, (n, road) in enumerate((("1", one.front_road), ("2", one.rear_road))):
        change = (road.rate(window.end) - road.rate(window.start)) / window.duration
        before = length[i] - kappa[i] * length[1 - i]
        wanted = before + change / square[i]
        factor = senses[i] * one.plane_scales[i]
        reach = max(abs(p) for p in points.values()) * (1.0 + max(map(abs, kappa)))
        a, b = one.plane_scales
        tolerance = 1e-11 * reach * (1.0 + a / b + b / a) ** 2 + 1e-9 * abs(wanted) * abs(factor)
        assert abs((points[f"Q{n}"] - points[f"D{n}"]).real - factor * before) < tolerance
        assert abs((points[f"Q{n}"] - points[f"H{n}"]).real - factor * wanted) < tolerance
        assert points[f"D{n}"].imag == points[f"H{n}"].imag == points[f"Q{n}"].imag


@pytest.mark.slow
@given(cars)
def test_lines_lie_between_the_axes_for_either_sign(one):
    first, second = -one.lines.line_1, -one.lines.line_2
    k1, k2 = map(abs, one.couplings)
    assert 0.0 <= second <= first <= one.plane_distance
    if one.plane_scales[0] == one.plane_scales[1]:
        assert first == pytest.approx(one.plane_distance / (1.0 + k2))
        assert second == pytest.approx(one.plane_distance * k1 / (1.0 + k1))
    same = one.planes[0].displacement.direction == one.planes[1].displacement.direction
    assert same == (one.coupling_mass < 0.0)


@given(cars)
def test_both_readings_of_the_accelerations_agree(one):
    read = one.readings("contact", one.initial, 0.01, None)
    for axle in ("front", "rear"):
        by_planes, by_forces = (
            read[f"{which}{axle}_body_acceleration"] for which in ("", "control_")
        )
        size = abs(by_forces) + abs(read[f"{axle}_suspension_deflection_acceleration"]) + 1e3
        assert abs(by_planes - by_forces) < 1e-8 * size


@pytest.mark.parametrize("coupling", [90.0, -60.0])
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_converges_with_its_order(rule, coupling):
    one = car(
        coupling, front_road=roads.constant(), rear_road=roads.constant(),
        front_damper=lambda rate, y: (1500.0 + 600.0 * rate) * rate,
        rear_damper=linear(900.0), initial_deflections=(0.04, -0.03), initial_rates=(0.2, 0.4),
    )  # fmt: skip
    smooth = replace(one, front_damper=linear(0.0))  # for the reference, whose law is added there

    def slope(t, z):
        y, v = z[:2], z[2:]
        force = [
            smooth.front_spring.force(y[0]) + (1500.0 + 600.0 * v[0]) * v[0],
            smooth.rear_spring.force(y[1]) + 900.0 * v[1],
        ]
        mass = [[330.0, coupling], [coupling, 280.0]]
        return [*v, *np.linalg.solve(mass, -np.array(force))]

    exact = solve_ivp(slope, (0.0, 0.3), (0.04, -0.03, 0.2, 0.4), rtol=1e-11, atol=1e-13).y[:, -1]
    errors = []
    for n in (60, 120, 240):
        last = construct_motion(one, rule, step=0.3 / n, steps=n).frames[-1].points
        ends = [plane.displacement.read(last[f"{plane.state}'"]) for plane in one.planes]
        errors.append(np.max(np.abs(np.array(ends) - exact[:2])))
    orders = [log2(e / f) for e, f in pairwise(errors)]
    assert orders == pytest.approx([rule.order, rule.order], abs=0.25)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_every_point_that_the_scheme_joins_is_there(rule):
    drawing = construct_motion(car(), rule, step=0.005, duration=0.05)
    check_schemes(drawing)
    assert {mark.label for mark in drawing.schemes["contact"].marks} >= {
        "H1",
        "H2",
        "D1",
        "D2",
        "C1",
        "C2",
        "A1*",
    }


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"front_mass": 0.0}, "front_mass = 0.0: must be finite and greater than 0"),
        ({"coupling_mass": 400.0}, "coupling_mass = 400 kg: its square must be below"),
        ({"coupling_mass": nan}, "coupling_mass = nan"),
        ({"plane_scales": (1.0, 0.0)}, "the second of plane_scales = 0.0"),
        ({"plane_distance": -1.0}, "plane_distance = -1.0"),
        ({"initial_rates": (nan, 0.0)}, "the first of initial_rates = nan"),
        ({"rear_spring": linear(0.0)}, "rate at zero deflection is 0 N/m"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        car(**changes)
