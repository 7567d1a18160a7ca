"""The integral curves of portraits: how they are followed, where they end, and that they keep apart."""

from __future__ import annotations

from math import inf, pi

import numpy as np
import pytest
from phase_systems import WIDE, of
from scipy.special import gamma

from phaseplane.equations import Formula
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    compute_portrait,
    conserves,
    equilibria,
    followed,
    separatrices,
    window_of,
)
from phaseplane.portrait.returns import turns
from phaseplane.portrait.trajectories import length_of, motions


def test_the_steps_are_of_fourth_order_forwards_and_backwards() -> None:
    """A damped, driven oscillator against its closed form, with steps of one length."""
    system = PhaseSystem(lambda v, x, t: 0.4 * v + x - np.cos(2.0 * t), period=pi)
    amplitude = 1.0 / complex(1.0 - 4.0, 0.8)
    x0, v0 = amplitude.real, (2j * amplitude).real
    for sense in (1.0, -1.0):
        errors = []
        for count in (20, 40, 80):
            going = motions(system, WIDE, x0, v0, sense)
            h = np.full(1, 1.0 / count)
            x, v, t = going.x, going.v, going.t
            for _ in range(count):
                x, v, _error = going.tried(x, v, t, going.sense, h)
                t = t + sense * h
            end = amplitude * np.exp(2j * sense)
            errors.append(abs(x[0] - end.real) + abs(v[0] - (2j * end).real))
        assert errors[0] / errors[1] > 13.0
        assert errors[1] / errors[2] > 13.0


@pytest.mark.slow
def test_a_turn_of_the_cubic_spring_takes_its_time() -> None:
    """x'' + x^3 = 0 from rest at a: period 4 K(1/2) / a = Gamma(1/4)^2 / (sqrt(pi) a)."""
    starts = np.array([0.5, 1.0, 3.0])
    made = turns(of(lambda v, x: x**3), WIDE, starts, tolerance=1e-11)
    assert made.back == pytest.approx(starts, abs=1e-8)
    assert made.far == pytest.approx(-starts, abs=1e-8)
    assert made.time == pytest.approx(gamma(0.25) ** 2 / (np.sqrt(pi) * starts), rel=1e-6)


def test_a_saddle_without_a_linear_part_has_the_curves_of_its_energy() -> None:
    """x'' = x^3: x'^2 = x^4 / 2 through the saddle."""
    system = of(lambda v, x: -(x**3))
    (saddle,) = equilibria(system, WIDE)
    curves = separatrices(system, WIDE, saddle)
    assert len(curves) == 4
    for curve in curves:
        assert curve[:, 1] ** 2 == pytest.approx(curve[:, 0] ** 4 / 2.0, abs=1e-5)
        assert np.abs(curve[-1]).max() > 3.7  # up to the border


@pytest.mark.slow
def test_a_system_that_dissipates_is_not_drawn_by_its_energy() -> None:
    for function in (lambda v, x: x + v**3, lambda v, x: x + x * x * v):
        made = compute_portrait(of(function), WIDE)
        assert not made.energy_curves
        assert made.orbits
    made = compute_portrait(of(lambda v, x: x**3), WIDE)
    assert made.energy_curves
    assert not made.orbits
    assert conserves(of(lambda v, x: np.sin(x)), WIDE)
    assert not conserves(of(lambda v, x: x + 1e-9 * v), WIDE)


def test_each_well_has_its_curves() -> None:
    made = compute_portrait(of(lambda v, x: x**3 - x), WIDE)
    for well in (-1.0, 1.0):
        inside = [
            line for lines in made.energy_curves for line in lines
            if np.hypot(*(line - [well, 0.0]).T).max() < 1.0
        ]  # fmt: skip
        assert len(inside) >= 2


def test_integral_curves_end_at_the_border_or_at_rest() -> None:
    for x, v in ((-3.0, 3.0), (0.5, 0.0)):
        (curve,) = followed(of(lambda v, x: v + x), WIDE, x, v)
        assert np.abs(curve[-1]).max() < 1e-2
    (gone,) = followed(of(lambda v, x: -x), WIDE, 0.5, 0.0, margin=0.0)
    assert gone[-1, 0] > WIDE.right
    assert gone[:, 0] ** 2 - gone[:, 1] ** 2 == pytest.approx(0.25, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", ["x - v^3", "0.08*tan(0.2*x) - 0.6*v^5", "x + 0.002*v", "x - v*x^2"]
)
def test_windings_around_a_weak_focus_keep_apart(text: str) -> None:
    formula = Formula(text)
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays)
    made = compute_portrait(system, window_of(system, 3.0))
    turns_there = 0
    for curve in made.orbits:
        x, v = curve.T
        downwards = (v[:-1] > 0.0) & (v[1:] <= 0.0)
        turns_there += int((downwards & (x[1:] > 0.0) & (x[1:] < made.window.right)).sum())
    assert turns_there <= 45
    assert sum(length_of(curve, made.window) for curve in made.orbits) < 60.0


def test_a_motion_ends_at_a_pole_of_its_damping() -> None:
    """Backwards in time motions of x'' + tan x' + x = 0 come to x' = pi/2 and end there."""
    (line,) = followed(of(lambda v, x: np.tan(v) + x), WIDE, 0.5, 1.2, -1.0, tolerance=1e-6)
    assert line[-1, 1] == pytest.approx(0.5 * pi, abs=1e-3)
    assert len(line) < 150


def test_a_motion_with_switches_ends_where_its_steps_lead_nowhere() -> None:
    """Beside the poles of its damping steps are ever shorter, backwards in time."""
    formula = Formula("1.7*x*v^3 - 4*x*abs(x) - 0.04*tan(2.2*v) - 0.5*sign(v)")
    system = PhaseSystem(formula.function, switching=formula.switching)
    (line,) = followed(system, WIDE, -1.0, 1.0, -1.0)
    assert len(line) < 1000


@pytest.mark.slow
def test_no_curve_ends_in_mid_air() -> None:
    """End stops with little damping, a limit cycle, dry friction."""
    stops = of(lambda v, x: 0.1 * v + x + 20.0 * (x - np.clip(x, -1.0, 1.0)))
    cycle = of(lambda v, x: (x * x - 1.0) * v + x)
    dry = Formula("x + 0.3*sign(v)")
    friction = PhaseSystem(dry.function, on_arrays=dry.on_arrays, switching=dry.switching)
    for system in (stops, cycle, friction):
        window = window_of(system, 3.0, [(1.5, 0.0)])
        made = compute_portrait(system, window)
        sides = np.array([window.width, window.height])
        ends = np.vstack([curve[[0, -1]] for curve in made.orbits])
        attracting = [cycle.curve for cycle in made.cycles]
        attracting += [np.column_stack([np.linspace(at.x, at.until if at.stretches else at.x, 99),
                                        np.zeros(99)]) for at in made.equilibria]  # fmt: skip
        for end in ends[window.holds(*ends.T)]:
            near = min(np.hypot(*((line - end) / sides).T).min() for line in attracting)
            assert near < 0.02, (end, near)


@pytest.mark.slow
def test_a_driven_system_is_drawn_frozen_on_demand_alone() -> None:
    system = PhaseSystem(lambda v, x, t: 0.2 * v + x - np.cos(2.0 * t), period=pi)
    made = compute_portrait(system, WIDE, periods=30)
    assert made.field is None
    assert made.section is not None
    shown = (made.equilibria, made.orbits, made.nullcline, made.separatrices)
    assert not any(map(len, shown))
    still = compute_portrait(system, WIDE, frozen=pi / 6.0)
    assert still.section is None
    assert still.frozen == pi / 6.0
    assert [at.x for at in still.equilibria] == pytest.approx([0.5])


@pytest.mark.slow
def test_a_driven_system_that_dissipates_nothing_keeps_all_its_points() -> None:
    """Linear, without damping: ellipses in the section, by the difference from the forced motion."""
    w = 0.7320508
    system = PhaseSystem(lambda v, x, t: x - np.cos(w * t), period=2.0 * pi / w)
    made = compute_portrait(system, WIDE, periods=40).section
    assert made is not None
    assert made.transient == 0
    assert made.attractors == ()
    energy = np.hypot(made.points[:, 0] - 1.0 / (1.0 - w * w), made.points[:, 1])
    rows = energy.reshape(made.periods, -1)
    assert np.ptp(rows, axis=0).max() < 1e-4


@pytest.mark.slow
def test_what_leaves_every_window_ends_there() -> None:
    system = of(lambda v, x: -(x**3) - v**3)
    made = compute_portrait(system, WIDE)
    assert all(np.isfinite(curve).all() for curve in (*made.orbits, *made.separatrices))
    assert inf not in [c.multiplier for c in made.cycles]


@pytest.mark.slow
def test_no_place_of_a_portrait_is_empty() -> None:
    fast = of(lambda v, x: 0.25 * np.sin(2.0 * x) * v**2 / (1.25 - 0.25 * np.cos(2.0 * x)))
    for system in (fast, of(lambda v, x: 10.0 * (x**2 - 1.0) * v + x)):
        window = Window(-4.0, 4.0, -12.0, 12.0)
        made = compute_portrait(system, window)
        drawn = np.vstack([*made.orbits, *(cycle.curve for cycle in made.cycles)])
        sides = [window.width, window.height]
        for place in np.column_stack([each.ravel() for each in window.grid(9, 9)]):
            assert np.hypot(*((drawn - place) / sides).T).min() < 0.16


def test_a_jump_of_f_is_a_switch_and_no_isocline() -> None:
    formula = Formula("sign(x + 0.3*v)")
    relay = PhaseSystem(formula.function, on_arrays=formula.on_arrays, switching=formula.switching)
    made = compute_portrait(relay, WIDE)
    (switch,) = made.switches
    assert switch[:, 0] + 0.3 * switch[:, 1] == pytest.approx(0.0, abs=1e-9)
    assert not made.nullcline
    for slope, lines in zip(made.slopes, made.isoclines, strict=True):
        for line in lines:
            off = relay.forces(*line.T) + slope * line[:, 1]  # f is 1 or -1
            assert off == pytest.approx(0.0, abs=0.3)


def test_curves_of_constant_energy_keep_apart() -> None:
    system = of(lambda v, x: np.sin(x))
    made = compute_portrait(system, Window(-6.7, 6.7, -2.5, 2.5))
    energies = [
        float(np.mean(0.5 * line[0][:, 1] ** 2 - np.cos(line[0][:, 0]))) + 1.0
        for line in made.energy_curves
    ]
    speeds = np.sqrt([2.0, *energies])  # the first is that of the separatrix
    apart = np.abs(speeds[:, None] - speeds)[np.triu_indices(len(speeds), 1)]
    assert apart.min() > 0.05
