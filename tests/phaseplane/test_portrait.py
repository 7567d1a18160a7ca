"""Phase portraits against equations whose portraits are known."""

from __future__ import annotations

from math import cos, exp, pi, sin

import numpy as np
import pytest
from phaseplane.suspension import characteristics
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import checked_parameters
from scipy.integrate import solve_ivp

from phaseplane.portrait import (
    PhaseSystem,
    Window,
    compute_portrait,
    direction_field,
    energy_levels,
    equilibria,
    good_window,
    isocline,
    limit_cycles,
    nullcline,
    of_coordinate,
    section,
    separatrices,
)
from phaseplane.portrait.trajectories import Motions

WIDE = Window(-4.0, 4.0, -3.0, 3.0)
PENDULUM = PhaseSystem(lambda v, x, t: sin(x))


def linear(stiffness: float, damping: float) -> PhaseSystem:
    return PhaseSystem(lambda v, x, t: damping * v + stiffness * x)


@pytest.mark.parametrize(
    ("stiffness", "damping", "kind"),
    [
        (1.0, 0.0, "centre"),
        (1.0, 0.5, "stable focus"),
        (1.0, -0.5, "unstable focus"),
        (1.0, 3.0, "stable node"),
        (1.0, -3.0, "unstable node"),
        (-1.0, 0.3, "saddle"),
        (0.0, 1.0, "stable node"),
    ],
)
def test_kinds_of_the_linear_oscillator(stiffness: float, damping: float, kind: str) -> None:
    window = Window(-0.9, 1.0, -1.0, 1.0)  # rest lies on no point of the search grid
    found = equilibria(linear(stiffness, damping) if stiffness else PhaseSystem(
        lambda v, x, t: damping * v + x**3), window)  # fmt: skip
    assert [e.kind for e in found] == [kind]
    assert found[0].x == pytest.approx(0.0, abs=1e-6)
    roots = np.roots([1.0, damping, stiffness])
    if stiffness:
        assert sorted(found[0].eigenvalues[0], key=lambda z: (z.real, z.imag)) == pytest.approx(
            sorted(roots, key=lambda z: (z.real, z.imag)), abs=1e-6
        )


def test_the_pendulums_equilibria_and_separatrices() -> None:
    """On a separatrix x'^2 / 2 - cos x = 1."""
    found = equilibria(PENDULUM, WIDE)
    assert [e.x for e in found] == pytest.approx([-pi, 0.0, pi])
    assert [e.kind for e in found] == ["saddle", "centre", "saddle"]
    curves = separatrices(PENDULUM, WIDE, found[2])
    assert len(curves) == 4
    for curve in curves:
        energy = curve[:, 1] ** 2 / 2.0 - np.cos(curve[:, 0])
        assert energy == pytest.approx(1.0, abs=1e-6)
        assert len(curve) > 50
    reach = [(float(curve[:, 0].min()), float(curve[:, 0].max())) for curve in curves]
    assert min(low for low, _ in reach) < -3.0  # two go round to the other saddle
    with pytest.raises(ValueError, match="is not a saddle but a centre"):
        separatrices(PENDULUM, WIDE, found[1])


def test_an_equilibrium_is_classified_on_either_side_of_its_own_corner() -> None:
    """Slopes 1 below 0.3 and 4 above; rest lies beside that corner by rounding."""
    bent = PhaseSystem(
        lambda v, x, t: (x - 0.3 - 1e-13) * (1.0 if x < 0.3 else 4.0), corners=(-0.5, 0.3, 0.7)
    )
    (rest,) = equilibria(bent, Window(-0.93, 1.0, -1.0, 1.0))
    assert rest.x == 0.3
    stiffness = sorted({round(abs(pair[0]) ** 2, 6) for pair in rest.eigenvalues})
    assert stiffness == [1.0, 4.0]


def test_energy_levels_of_the_pendulum() -> None:
    energies, curves = energy_levels(PENDULUM, WIDE, [0.5, 2.0, 3.0])
    for energy, lines in zip(energies, curves, strict=True):
        assert lines
        for line in lines:
            # U is least at 0 in the window
            got = line[:, 1] ** 2 / 2.0 + 1.0 - np.cos(line[:, 0])
            assert got == pytest.approx(energy, abs=2e-3)
    spaced, _ = energy_levels(PENDULUM, WIDE, 7)
    assert len(spaced) == 7
    assert np.diff(np.sqrt(spaced)) == pytest.approx(np.sqrt(spaced[0]))


def test_isoclines_have_their_slope_and_nullclines_none() -> None:
    system = PhaseSystem(lambda v, x, t: 0.4 * v + x + 0.3 * x**3)
    for slope in (-2.0, 0.0, 1.5):
        curves = isocline(system, WIDE, slope)
        points = np.vstack(curves)
        moving = points[abs(points[:, 1]) > 0.3]
        assert len(moving) > 20
        assert -system.forces(*moving.T) / moving[:, 1] == pytest.approx(slope, abs=2e-2)
    assert np.vstack(nullcline(system, WIDE)) == pytest.approx(
        np.vstack(isocline(system, WIDE, 0.0))
    )
    x, v, dx, dv = direction_field(system, WIDE, 5, 4)
    assert x.shape == (4, 5)
    assert (dx == v).all()
    assert dv == pytest.approx(-(0.4 * v + x + 0.3 * x**3))


def test_an_equilibrium_on_a_corner_has_a_kind_on_each_side() -> None:
    """Stiff and damped on one side, soft and driven on the other."""
    system = PhaseSystem(
        lambda v, x, t: (4.0 if x > 0 else -1.0) * x + (0.5 if v > 0 else -0.2) * v,
        corners=(0.0,), rate_corners=(0.0,),
    )  # fmt: skip
    (rest,) = equilibria(system, Window(-0.7, 1.0, -1.0, 1.0))
    assert rest.x == 0.0
    assert rest.kinds == ("stable focus", "unstable focus", "saddle", "saddle")
    assert rest.on_corner
    assert rest.kind == "stable focus / unstable focus / saddle"


@pytest.mark.parametrize(
    ("mu", "amplitude", "period", "within"),
    [
        (1.0, 2.008619860874843, 6.663286859323130, 1e-9),
        pytest.param(3.0, 2.023304, 8.859096, 2e-6, marks=pytest.mark.slow),
    ],
)
def test_van_der_pols_limit_cycle(
    mu: float, amplitude: float, period: float, within: float
) -> None:
    """Amplitude and period as published: for mu = 1 by Amore (arXiv:2111.12198) to 25 digits."""
    system = PhaseSystem(lambda v, x, t: mu * (x * x - 1.0) * v + x)
    (cycle,) = limit_cycles(system, WIDE)
    assert cycle.crossing == pytest.approx(amplitude, abs=within)
    assert cycle.period == pytest.approx(period, abs=within)
    assert cycle.attracts
    assert cycle.curve[:, 0].max() == pytest.approx(amplitude, abs=1e-3)


@pytest.mark.slow
def test_a_cycle_that_repels_is_found_too_and_a_focus_has_none() -> None:
    backwards = PhaseSystem(lambda v, x, t: (1.0 - x * x) * v + x)
    (cycle,) = limit_cycles(backwards, WIDE)
    assert not cycle.attracts
    assert cycle.crossing == pytest.approx(2.00861986, abs=2e-5)
    assert limit_cycles(linear(1.0, 0.1), WIDE) == []


@pytest.mark.slow
def test_a_cycle_of_known_multiplier() -> None:
    """x'' + (x^2 + x'^2 - 1) x' + x = 0 has the unit circle; its multiplier is exp(-int 2 x'^2 dt)."""
    system = PhaseSystem(lambda v, x, t: (x * x + v * v - 1.0) * v + x)
    (cycle,) = limit_cycles(system, Window(-2.0, 2.0, -2.0, 2.0))
    assert (cycle.crossing, cycle.period) == (pytest.approx(1.0, abs=1e-7), pytest.approx(2.0 * pi))
    assert cycle.multiplier == pytest.approx(exp(-2.0 * pi), abs=1e-4)


@pytest.mark.slow
def test_a_forced_linear_oscillator_settles_in_its_closed_form() -> None:
    d, w = 0.1, 0.8
    system = PhaseSystem(lambda v, x, t: 2.0 * d * v + x - cos(w * t), period=2.0 * pi / w)
    size = 1.0 / ((1.0 - w * w) ** 2 + (2.0 * d * w) ** 2)
    state = ((1.0 - w * w) * size, 2.0 * d * w * w * size)  # of the steady motion at t = 0
    seen = section(system, WIDE, (1.5, -1.0))
    ((attractor,),) = seen.attractors
    assert attractor == pytest.approx(state, abs=1e-5)
    assert seen.points == pytest.approx(np.tile(state, (len(seen.points), 1)), abs=5e-3)
    with pytest.raises(ValueError, match="has no period"):
        section(PENDULUM, WIDE, (0.0, 1.0))


@pytest.mark.slow
def test_all_five_periodic_motions_of_a_cubic_spring_are_told_apart() -> None:
    """Y. Ueda, Ann. N.Y. Acad. Sci. 357 (1980) 422: two of period 1, two of period 2, one of period 3."""
    system = PhaseSystem(lambda v, x, t: 0.08 * v + x**3 - 0.2 * np.cos(t), period=2.0 * pi)
    found = section(system, Window(-1.5, 1.5, -1.5, 1.5), (0.1, 0.0), 110).attractors
    assert sorted(map(len, found)) == [1, 1, 2, 2, 3]
    for states in found:
        times = 2.0 * pi * np.arange(len(states) + 1.0)
        known = solve_ivp(
            lambda t, y: [y[1], -system.function(y[1], y[0], t)], (0.0, times[-1]), states[-1],
            "DOP853", times, rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        assert known.y.T[1:] == pytest.approx(states, abs=1e-4)
        assert len({round(float(x), 2) for x in known.y[0]}) == len(states)


def test_motions_that_run_away_within_a_period_do_not_hold_up_a_section(monkeypatch) -> None:
    """In a softening spring they took 100 000 steps and minutes, far outside the window."""
    step, made = Motions.step, []

    def counted(going: Motions, longest: float) -> object:
        made.append(going)
        assert len(made) < 20_000
        return step(going, longest)

    monkeypatch.setattr(Motions, "step", counted)
    softening = PhaseSystem(lambda v, x, t: x - x**3 + x * v - 0.3 * np.cos(2.0 * t), period=pi)
    window = Window(-3.75, 3.75, -7.3, 7.3)
    states = section(softening, window, (0.1, 0.0), periods=20)
    assert states.periods == 21
    assert len(states.points) > states.periods  # those that stay


def test_sections_of_the_models() -> None:
    """One degree: its whole plane. Quarter car: the body above a wheel that is held."""
    one = build(
        "OneDof", checked_parameters("OneDof", {"bump_stop.stiffness": 1e5, "road.shape": "flat"})
    )
    system = of_coordinate(one)
    assert system.corners == (-0.08,)
    assert system.rate_corners == (0.0,)
    c, m = 14709.975, 294.1995
    assert system.function(0.0, 0.01, 0.0) == pytest.approx(0.01 * c / m)
    assert system.function(-0.2, -0.1, 0.0) == pytest.approx(
        (-0.1 * c - 0.02 * 1e5 - 0.2 * 490.3325) / m
    )
    (rest,) = equilibria(system, Window(-0.11, 0.1, -1.0, 1.0))
    assert rest.kinds == ("stable focus",) * 4
    assert len(set(rest.eigenvalues)) == 2  # rebound and bump are damped differently
    quarter = build("QuarterCar", checked_parameters("QuarterCar", {}))
    assert of_coordinate(quarter).function(0.0, 0.01, 0.0) == pytest.approx(0.01 * c / m)
    with pytest.raises(ValueError, match=r"must be from 0 to 1 \(body, wheel\)"):
        of_coordinate(quarter, 2)
    for contact in ("gap", "force"):  # across a gap a tyre does not push however fast it closes
        parameters = {"contact": contact, "tyre.damping": 100.0}
        wheel = of_coordinate(build("QuarterCar", checked_parameters("QuarterCar", parameters)), 1)
        grid = [(v, x) for v in (-10.0, 0.0, 10.0) for x in (-0.05, 0.0, 0.03, 0.05)]
        one = [wheel.function(v, x, 0.0) for v, x in grid]
        assert wheel.on_arrays(*np.array(grid).T, np.zeros(len(grid))) == pytest.approx(one)
    frame = build("Elastoplastic", checked_parameters("Elastoplastic", {}))
    with pytest.raises(ValueError, match="has a memory"):
        of_coordinate(frame)


def test_laws_with_powers_and_functions_of_ones_own() -> None:
    strut = Element(
        "strut", (1.0,), characteristics.function(sin, cos), characteristics.power(0.3, 2.0)
    )
    system = of_coordinate(System(("x",), ((1.0,),), (strut,), scales=(1.0,)))
    x, v = np.array([0.4, -0.7]), np.array([-1.5, 2.0])
    expected = np.sin(x) + 0.3 * v * np.abs(v)
    assert system.on_arrays is not None
    assert system.on_arrays(v, x, np.zeros(2)) == pytest.approx(expected)
    assert system.function(2.0, -0.7, 0.0) == pytest.approx(expected[1])
    block = Element("block", (1.0,), characteristics.linear(1.0), friction=1.0, breakaway=2.0)
    with pytest.raises(ValueError, match="block: friction whose breakaway"):
        of_coordinate(System(("x",), ((1.0,),), (block,), scales=(1.0,)))


@pytest.mark.parametrize("sides", [(1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, float("inf"))])
def test_windows_are_checked(sides: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="left must be below right"):
        Window(*sides)


def test_a_window_is_as_high_as_motions_from_its_sides_get() -> None:
    window = good_window(linear(9.0, 0.0), 0.2)
    assert (window.left, window.bottom) == (-window.right, -window.top)
    assert window.top == pytest.approx(3.0 * window.right, rel=1e-4)


def test_isoclines_of_a_whole_portrait_have_slopes_of_the_windows_shape() -> None:
    """Of x'' = -9 x straight lines, as f + s x' = 0 says; slopes in heights over widths."""
    window = Window(-1.0, 1.0, -6.0, 6.0)
    lines = compute_portrait(linear(9.0, 0.0), window).isoclines
    for (line,), wanted in zip(lines, (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0), strict=True):
        x, v = line[abs(line[:, 1]) > 1e-3].T
        assert -9.0 * x / v == pytest.approx(6.0 * wanted, rel=1e-6)


@pytest.mark.slow
def test_a_repelling_cycle_is_the_attracting_one_backwards() -> None:
    """Van der Pol's of both signs; a small distance from it grows by exp(-integral of df/dv)."""
    window = Window(-3.0, 3.0, -4.0, 4.0)
    (inwards,), (outwards,) = (
        limit_cycles(PhaseSystem(lambda v, x, t, mu=mu: mu * (x * x - 1.0) * v + x), window)
        for mu in (1.0, -1.0)
    )
    assert inwards.crossing == pytest.approx(outwards.crossing, rel=1e-8)
    assert inwards.period == pytest.approx(outwards.period, rel=1e-8)
    assert inwards.multiplier * outwards.multiplier == pytest.approx(1.0, rel=1e-2)
    x, v = inwards.curve.T
    along = np.hypot(np.diff(x), np.diff(v))  # by arcs, so that any spacing will do
    speed = np.hypot(v, (x * x - 1.0) * v + x)
    times = along * 0.5 * (1.0 / speed[1:] + 1.0 / speed[:-1])
    growth = -np.sum(0.5 * (x[1:] ** 2 + x[:-1] ** 2 - 2.0) * times)
    assert np.sum(times) == pytest.approx(inwards.period, rel=1e-2)
    assert np.log(inwards.multiplier) == pytest.approx(growth, rel=2e-2)
