"""The windows of portraits: what they hold, and where they end."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from phase_systems import of

from phaseplane.equations import Formula
from phaseplane.portrait import (
    PhaseSystem,
    compute_portrait,
    section,
    window_of,
)


def test_a_stop_as_hard_as_a_rail_does_not_flatten_a_portrait() -> None:
    soft = of(lambda v, x: 0.5 * v + x)
    hard = of(lambda v, x: 0.5 * v + x + 1e6 * np.minimum(x + 1.0, 0.0))
    assert window_of(hard, 3.0).top < 10.0 * window_of(soft, 3.0).top


@pytest.mark.parametrize("size", [1.0, 0.0])
def test_a_window_around_rest_at_the_edge_of_where_f_is_defined(size: float) -> None:
    """It had no height, or was a thousandth of the reach where f is not zero there."""
    window = window_of(of(lambda v, x: size * np.sqrt(x)), 3.0, [(0.0, 0.0)])
    assert -0.01 < window.left < 0.0
    assert window.right > 1.0
    assert window.height > 1.0
    assert window_of(of(lambda v, x: size + np.sqrt(x)), 3.0, [(0.0, 0.0)]).right > 1.0


@pytest.mark.parametrize("start", [1.5, -1.5])
def test_a_window_holds_a_start_beside_a_pole(start: float) -> None:
    """It ended a fortieth of the distance between the poles before them, and the start was outside."""
    window = window_of(of(lambda v, x: np.tan(x)), 3.0, [(start, 0.0)])
    assert window.left <= start <= window.right
    assert window.width < pi


@pytest.mark.slow
def test_a_window_ends_before_a_pole_and_holds_the_motions_from_its_starts() -> None:
    planet = of(lambda v, x: 1.0 / x**2 - 0.75 / x**3)
    window = window_of(planet, 3.0, [(0.5, 0.0), (0.75, 0.0)])
    assert 0.0 < window.left < 0.5  # f has a pole at 0
    assert 1.5 < window.right < 2.0
    assert 1.0 / sqrt(3.0) < window.top < 1.0
    falling = window_of(of(lambda v, x: 1.0 / x**2), 3.0, [(0.5, 0.0)])
    assert falling.left > 0.0
    weak = of(lambda v, x: 6.0 - 1.7 * x + 0.06 * np.tan(1.69 * x))
    window = window_of(weak, 3.0, [(0.0, 0.0)])
    assert -0.93 < window.left < window.right < 0.93  # 0.5 pi / 1.69 = 0.9295
    growing = of(lambda v, x: 0.4 * v - 4.0 * np.tan(0.37 * x))  # its pole is beyond the reach
    assert 3.0 < window_of(growing, 3.0, [(0.5, 0.0)]).right <= 0.5 * pi / 0.37
    root = of(lambda v, x: np.sqrt(x))
    assert -0.01 < window_of(root, 3.0, [(0.5, 0.0)]).left < 0.1
    # a sharp maximum, a jump and a weak singularity are no poles
    for bounded in (
        lambda v, x: np.sin(10.0 * x) / x,
        lambda v, x: x + np.exp(-1e6 * (x - 1.0) ** 2) * 1e3,
        lambda v, x: np.sign(x) / np.sqrt(np.abs(x)),
    ):
        window = window_of(of(bounded), 3.0, [(0.3, 0.0)])
        assert window.left <= -3.0
        assert window.right >= 3.0


@pytest.mark.slow
def test_a_window_holds_limit_cycles_and_starts() -> None:
    relaxing = of(lambda v, x: 10.0 * (x**2 - 1.0) * v + x)
    for starts in ([(0.5, 0.0)], [(0.0, 0.0)]):
        made = compute_portrait(relaxing, window_of(relaxing, 3.0, starts), fits=True)
        (cycle,) = made.cycles
        assert made.window.holds(*cycle.curve.T).all()
    wide = of(lambda v, x: (x**2 / 25.0 - 1.0) * v + x)
    window = window_of(wide, 3.0, [(0.5, 0.0)])
    assert window.right > 10.0
    fast = of(lambda v, x: 0.25 * np.sin(2.0 * x) * v**2 / (1.25 - 0.25 * np.cos(2.0 * x)))
    window = window_of(fast, 3.0, [(0.0, 10.0), (0.0, -6.0)])
    assert window.top == -window.bottom == pytest.approx(12.5)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_window_ends_at_the_velocity_from_which_on_f_is_undefined(side: float) -> None:
    window = window_of(of(lambda v, x: x + 0.1 * np.sqrt(1.0 - side * v)), 3.0)
    up, down = (window.top, -window.bottom)[:: int(side)]
    assert 0.98 < up < 1.0
    assert down > 3.0


@pytest.mark.slow
def test_a_window_ends_at_a_pole_across_the_plane() -> None:
    damped = of(lambda v, x: np.exp(x) - 1.0 + np.tan(v))
    window = window_of(damped, 3.0)
    assert (window.bottom, window.top) == pytest.approx((-0.5 * pi, 0.5 * pi), rel=0.01)
    assert window.top < 0.5 * pi < 1.01 * window.top
    slanted = window_of(of(lambda v, x: x + 1.0 / (v - x - 20.0)), 3.0)
    assert slanted.top == -slanted.bottom > 3.0  # no line v = const is its pole
    driven = PhaseSystem(lambda v, x, t: np.tan(v) + x - 0.5 * np.cos(2.0 * t), period=pi)
    seen = section(driven, window_of(driven, 3.0), (1.0, 0.0))
    assert np.ptp(seen.points, axis=0) == pytest.approx(0.0, abs=0.5)
    ((attractor,),) = seen.attractors
    assert attractor == pytest.approx([-0.11405, 0.155082], abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "start", "x", "v"),
    [
        ("(x^2 - 9)*v + x", 0.5, 6.046, 19.0),  # far above the window of the start
        ("v^3/30 - v + x", 0.0, 6.871, 6.0),  # the start is the equilibrium itself
        ("0.1*v - 3*sign(v) + x", 0.5, 38.228, 38.0),  # so far off that one look is too short
    ],
)
def test_a_window_has_room_for_the_limit_cycle_that_a_motion_goes_to(text, start, x, v):
    formula = Formula(text)
    switching = formula.switching if "sign" in text else None
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays, switching=switching)
    window = window_of(system, 3.0, [(start, 0.0)])
    assert x < window.right < 1.5 * x
    assert v < window.top < 3.0 * v
    growing = window_of(PhaseSystem(lambda v, x, t: x - 0.1 * v), 3.0, [(0.5, 0.0)])
    assert growing.width < 100.0


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("log(v)", (0.0, 1.0)),  # minus infinity at rest
        ("x + 1/v", (0.0, 1.0)),  # infinite there, with either sign
        ("(9.81 - x)^(x + v) + 0.1", (10.0, 0.0)),  # known for a whole exponent only
        ("sqrt(v - 1)", (0.0, 2.0)),
        ("v^(2*x)", (-2.0, -3.0)),  # infinite there, and known for a whole exponent only
    ],
)
def test_a_portrait_of_a_force_that_is_not_known_at_rest(
    text: str, start: tuple[float, float]
) -> None:
    """What was lost there was not known, so nothing was lost: curves of an energy that is not known."""
    formula = Formula(text)
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays)
    window = window_of(system, 3.0, [start])
    assert window.holds(*start)
    made = compute_portrait(system, window, starts=[start])
    assert made.energy_curves == ()
    assert all(np.isfinite(curve).all() for curve in made.orbits)


def test_the_side_of_a_pole_does_not_depend_on_the_sign_of_a_zero() -> None:
    reciprocal = of(lambda v, x: 1.0 / v)
    assert reciprocal.forces([-1.0, 1.0], [-0.0, 0.0]).tolist() == [np.inf, np.inf]
