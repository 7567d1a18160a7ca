"""Constructions of equations and vehicles that switch."""

from __future__ import annotations

from dataclasses import replace
from math import acos, cos, pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import damper, linear
from scipy.integrate import solve_ivp

from phaseplane.constructions import (
    RULES,
    ElastoplasticPlane,
    EquationPlane,
    OneDofPlane,
    construct_motion,
    family,
    rule_named,
)
from phaseplane.constructions.two_planes_schemes import axle_scheme
from phaseplane.equations import Formula, motion


def test_a_driven_mass_with_friction_breaks_loose_in_its_construction():
    """x'' + x + R sign(x') = F cos(t) from x = 0.5: it waits until 0.5 - F cos(t) = R, and no longer."""
    switching = Formula("x + 0.3*sign(v) - 0.5*cos(t)").switching
    drawing = construct_motion(
        EquationPlane(switching, initial_displacement=0.5), step=0.02, duration=6.0
    )
    first = next(frame for frame in drawing if frame.scheme == "contact")
    assert first.time == pytest.approx(acos(0.4), abs=1e-9)
    known = motion(switching, (0.5, 0.0), drawing.frames.times)
    found = [frame.readings["displacement"] for frame in drawing]
    assert found == pytest.approx(known.displacements, abs=2e-4)


def test_a_construction_of_rest_has_one_step():
    resting = EquationPlane(Formula("x + 0.3*sign(v)").switching, initial_displacement=0.2)
    drawing = construct_motion(resting, step=0.1, duration=2.0)
    (frame,) = drawing
    assert frame.scheme == "rest"
    assert frame.points["P'"] == frame.points["P"]
    moving = replace(resting, initial_displacement=1.0)
    sheet = family(moving, [(0.2, 0.0)], step=0.1, duration=2.0)
    assert [curve.label for curve in sheet.curves if curve.role == "trail"] == ["(0.2, 0)"]


def test_the_construction_of_dry_friction_is_exact_and_ends_its_steps_on_the_switch():
    """Every step turns P about -+R, where the auxiliary curve jumps from -R to R."""
    friction = 0.3
    one = EquationPlane(
        Formula("x + R*sign(v)", {"R": friction}).switching, initial_displacement=2.05
    )
    drawing = construct_motion(one, rule_named("delta"), step=0.21, duration=20.0)
    assert drawing.end is not None
    assert drawing.end.time == pytest.approx(3.0 * pi)
    assert drawing.end.event == drawing.end.scheme == "rest"
    assert drawing.end.readings["displacement"] == pytest.approx(0.25 * -1.0, abs=1e-9)
    for frame in drawing:
        foot = frame.points["D"].real / one.scale
        assert abs(foot) == pytest.approx(friction, abs=1e-12)
        assert foot * (frame.readings["velocity"] or -1.0 * frame.points["P"].real) < 0.0
    (curve,) = [c for c in drawing.curves if c.role == "auxiliary"]
    on_axis = [z.real / one.scale for z in curve.vertices if abs(z.imag) < 1e-6 * one.scale]
    assert (min(on_axis), max(on_axis)) == pytest.approx((-friction, friction))
    aside = {round(z.real / one.scale, 9) for z in curve.vertices if abs(z.imag) > 1e-6 * one.scale}
    assert aside == {-friction, friction}  # upright but for the jump: nothing slanted


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("sign(x + 0.3*v)", 2.0),
        ("x + 0.3*sign(v) + 0.5*cos(1.1*t)", 2.0),
        ("x + 3*dead_zone(x, 0.5)", 2.0),
        # held at a velocity that is no rest; one switch passes while another holds
        ("0.3*x + sin(x) + 3*relay(v, 0.2)", 2.0),
        ("0.6*sin(x) + 0.3*sign(v + 0.3*x) - 0.4*max(sin(3*t), 0)", -0.1),
    ],
)
def test_the_construction_keeps_its_order_through_switches(text, start):
    formula = Formula(text)
    one = EquationPlane(formula.switching, initial_displacement=start)
    errors = []
    for step in (0.1, 0.05, 0.025):
        drawing = construct_motion(one, rule_named("delta"), step=step, duration=6.0)
        assert drawing.instants[-1].time == 6.0
        known = motion(formula.switching, (start, 0.0), [f.time for f in drawing])
        errors.append(
            max(abs(f.readings["displacement"] - x)
                for f, x in zip(drawing, known.displacements, strict=True))
        )  # fmt: skip
    assert errors[0] / errors[2] > 11.0
    assert errors[2] < 2e-3


@pytest.mark.parametrize("at", [0.7, 1.0, 1.05])
@pytest.mark.parametrize("step", [0.1, 0.05])
def test_a_force_that_switches_at_the_end_of_a_step_does_so_there(at, step):
    """The steps of a circle are exact; and the mass rests until then."""
    formula = Formula("x + 0.3*sign(v) - 0.5*sign(t - t_on) - 0.5", {"t_on": at})
    drawing = construct_motion(EquationPlane(formula.switching), step=step, duration=3.0)
    expected = [0.7 * (1.0 - cos(max(f.time - at, 0.0))) for f in drawing]
    assert [f.readings["displacement"] for f in drawing] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("linear_tyre", [True, False])
def test_of_a_strut_that_is_held_d1_is_known_and_a1_is_found(linear_tyre: bool):
    held, free = (
        " ".join(axle_scheme(flies=False, linear_tyre=linear_tyre, sticks=sticks).stages)
        for sticks in (True, False)
    )
    assert "D1 = Q1" in held
    assert "the y1 axis in A1*" in held
    assert "gives D1" not in held
    assert "Down to the axes: A1*" in free
    assert "Q2 through C2 gives D1" in free


def test_a_car_with_dry_friction_sticks_and_slips_in_its_plane():
    """The body stays on the axle until the road's acceleration overcomes the friction."""
    one = OneDofPlane(
        mass=100.0, spring=linear(1e4), damper=linear(0.0), friction=30.0,
        road=roads.sine(0.01, 2.0, 2.0),
    )  # fmt: skip
    drawing = construct_motion(one, rule_named("delta"), step=2e-3, duration=1.0)
    at_rest = [f for f in drawing if f.scheme == "rest"]
    assert at_rest
    for frame in at_rest:
        assert frame.points["D"] == frame.points["Q"]
        assert frame.readings["suspension_deflection_rate"] == pytest.approx(0.0, abs=1e-12)
        balance = 100.0 * one.road.derivatives(frame.time)[2]
        held = balance + 1e4 * frame.readings["suspension_deflection"]
        assert abs(held) <= 30.0 * (1.0 + 1e-6)
        control = frame.readings["control_body_acceleration"]
        assert frame.readings["body_acceleration"] == pytest.approx(control, abs=1e-9)

    def slope(t, y):
        return y[1], -(1e4 * y[0] + 30.0 * np.tanh(y[1] / 1e-6)) / 100.0 - one.road.derivatives(t)[
            2
        ]

    known = solve_ivp(
        slope, (0.0, 1.0), (0.0, one.initial_rate), method="BDF", rtol=1e-8, atol=1e-10
    )
    end = drawing.end
    assert end is not None
    assert end.readings["suspension_deflection"] == pytest.approx(known.y[0, -1], abs=2e-5)


force = st.floats(-20.0, 20.0)

switched = st.one_of(
    st.builds(
        OneDofPlane, mass=st.just(300.0), spring=st.just(linear(15000.0)),
        damper=st.just(damper(2000.0, 500.0)), friction=st.floats(5.0, 500.0),
        road=st.builds(roads.sine, st.floats(0.005, 0.02), st.floats(0.7, 4.0), st.just(20.0)),
        initial_deflection=st.floats(-0.05, 0.05), initial_rate=st.floats(-1.0, 1.0),
    ),
    st.builds(
        ElastoplasticPlane, mass=st.just(100.0), damping=st.floats(0.0, 200.0),
        spring_rate=st.just(5000.0), yield_force=st.just(6.0),
        initial_displacement=st.floats(-0.01, 0.01), initial_velocity=st.floats(-0.3, 0.3),
        load=st.tuples(force, force, force).map(
            lambda forces: roads.table([(0.1 * k, f) for k, f in enumerate((0.0, *forces, 0.0))])
        ),
    ),
)  # fmt: skip


held_at_almost_zero = ElastoplasticPlane(
    mass=100.0, damping=0.0, spring_rate=5000.0, yield_force=6.0,
    initial_displacement=5e-324, initial_velocity=0.0, load=roads.table([(0.0, 0.0), (0.4, 0.0)]),
)  # fmt: skip


@settings(max_examples=40)
@example(held_at_almost_zero, "tangent", 0.25)
@given(switched, st.sampled_from(list(RULES)), st.floats(0.02, 0.25))
def test_every_step_begins_within_the_limits_of_its_mode(plane, rule, turn):
    """So friction acts against the velocity, and a spring yields only outwards."""
    step = turn / plane.angular_frequency
    for frame in construct_motion(plane, RULES[rule], step=step, steps=20):
        states = tuple(frame.points[name] for name in "PR" if name in frame.points)
        assert min(plane.margins(frame.mode, states, frame.time), default=0.0) > -1e-9
