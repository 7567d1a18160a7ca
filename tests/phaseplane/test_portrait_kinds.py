"""Portraits where the linear part says nothing: bent springs, weak damping, play, relaxation."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import gamma

from phaseplane.equations import Formula
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    compute_portrait,
    conserves,
    equilibria,
    followed,
    limit_cycles,
    section,
    separatrices,
    window_of,
)
from phaseplane.portrait.returns import turns
from phaseplane.portrait.trajectories import length_of, motions

WIDE = Window(-3.75, 3.75, -3.75, 3.75)


def of(function: Callable[[Any, Any], Any]) -> PhaseSystem:
    """An autonomous system by its f(x', x)."""
    return PhaseSystem(lambda v, x, t: function(v, x))


# -- how motions are followed --------------------------------------------------------------------------


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


# -- kinds ---------------------------------------------------------------------------------------------

KINDS: list[tuple[str, Callable[[Any, Any], Any], dict[float, str]]] = [
    ("x^3", lambda v, x: x**3, {0.0: "centre"}),
    ("-x^3", lambda v, x: -(x**3), {0.0: "saddle"}),
    ("x^5", lambda v, x: x**5, {0.0: "centre"}),
    ("x^3 damped", lambda v, x: x**3 + v, {0.0: "stable node"}),
    ("x^3 driven", lambda v, x: x**3 - v, {0.0: "unstable node"}),
    ("-x^3 damped", lambda v, x: v - x**3, {0.0: "saddle"}),
    ("double root", lambda v, x: x * (x - 1.0) ** 2, {0.0: "centre", 1.0: "cusp"}),
    (
        "double root, damped", lambda v, x: 0.3 * v + x * (x - 1.0) ** 2,
        {0.0: "stable focus", 1.0: "saddle-node"},
    ),
    ("near miss", lambda v, x: x * ((x - 1.0) ** 2 + 1e-4), {0.0: "centre"}),
    ("v^3", lambda v, x: x + v**3, {0.0: "stable focus"}),
    ("-v^3", lambda v, x: x - v**3, {0.0: "unstable focus"}),
    ("v^5", lambda v, x: x + v**5, {0.0: "stable focus"}),
    ("v |v|", lambda v, x: x + v * abs(v), {0.0: "stable focus"}),
    ("x^2 v", lambda v, x: x + x * x * v, {0.0: "stable focus"}),
    ("x v", lambda v, x: x + 0.3 * x * v, {0.0: "centre"}),  # it gives back what it takes
    # over a turn the mean of v^4 is three times that of x^2 v^2
    ("-x^2 v + v^3", lambda v, x: x - x * x * v + v**3, {0.0: "stable focus"}),
    (
        "dead band", lambda v, x: x + np.sign(v) * np.maximum(np.abs(v) - 0.5, 0.0),
        {0.0: "centre"},
    ),
    # small motions meet nothing: the point is a centre, however close it begins
    (
        "narrow dead band", lambda v, x: x + np.sign(v) * np.maximum(np.abs(v) - 0.03, 0.0),
        {0.0: "centre"},
    ),
    (
        "driven beyond a dead band", lambda v, x: x - np.sign(v) * np.maximum(np.abs(v) - 0.004, 0.0),
        {0.0: "centre"},
    ),
    ("friction on a stop", lambda v, x: x + 0.01 * np.sign(v) * (np.abs(x) > 0.02), {0.0: "centre"}),
    ("edge of the reals", lambda v, x: np.sqrt(x), {0.0: "degenerate"}),
]  # fmt: skip


def test_a_plane_turned_by_half_a_turn_has_the_same_kinds() -> None:
    """On a corner, from which a turn to eleven digits did not come back."""
    texts = "0.11*atan(3*x) - 0.22*abs(x) + 0.21*x*v", "0.11*atan(3*x) + 0.22*abs(x) - 0.21*x*v"
    windows = Window(-3.0, 2.6, -3.0, 2.9), Window(-2.6, 3.0, -2.9, 3.0)
    there, turned = (
        [at.kind for at in equilibria(system, window)]
        for made, window in zip(map(Formula, texts), windows, strict=True)
        for system in (
            PhaseSystem(made.function, on_arrays=made.on_arrays, switching=made.switching),
        )
    )
    assert there == turned[::-1] == ["stable focus", "saddle"]


@pytest.mark.parametrize("half", [0.03, 0.3, 3.0, 30.0, 60.0, 300.0])
@pytest.mark.parametrize(
    ("text", "kind"),
    [
        # the same with x and t reversed; but wide turns pass v = -1/10 too near to be followed
        ("x + 10*x*v", "centre"),
        ("x + x*v + x^3*v", "centre"),
        ("x + 10*x*v - v^3", "unstable focus"),  # from wide turns it does not return
        ("x + x^2*v - 5*v^5", "stable focus"),  # beyond its limit cycle motions spiral outwards
        ("x + v^3", "stable focus"),  # its damping begins with the third power
        # of second and third order: a turn changes the distance r by a part that goes with r^4, r^6
        ("sin(x) + 3*x^2*v - v^3", "stable focus"),
        ("x + 3*x^2*v - v^3", "stable focus"),
        ("x - 3*x^2*v + v^3 + x^3*v^2", "unstable focus"),
    ],
)
def test_the_kind_does_not_depend_on_the_size_of_the_window(
    text: str, kind: str, half: float
) -> None:
    made = Formula(text)
    system = PhaseSystem(made.function, on_arrays=made.on_arrays, switching=made.switching)
    found = equilibria(system, Window(-half, half, -half, half))
    assert [at.kind for at in found if at.x == 0.0] == [kind]


@pytest.mark.parametrize(("name", "function", "kinds"), KINDS, ids=[name for name, _, _ in KINDS])
@pytest.mark.parametrize("shift", [0.0, 0.0123])
def test_kinds_without_a_linear_part(
    name: str, function: Callable[[Any, Any], Any], kinds: dict[float, str], shift: float
) -> None:
    """Wherever the points of the search lie."""
    window = Window(-3.75 + shift, 3.75, -3.75, 3.75)
    found = equilibria(of(function), window)
    if name == "edge of the reals" and shift:
        return  # it lies between two points, of which one has no f
    assert {round(at.x, 6): at.kind for at in found} == kinds


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_kinds_do_not_depend_on_units(scale: float) -> None:
    """x in other units, with the window going along."""
    window = Window(*(scale * side for side in (-3.7, 3.75, -3.75, 3.75)))
    for name, function, kinds in KINDS[:-1]:
        found = equilibria(of(lambda v, x, f=function: scale * f(v / scale, x / scale)), window)
        assert {round(at.x / scale, 5): at.kind for at in found} == kinds, name


def test_a_dead_zone_is_one_stretch_of_rest() -> None:
    system = of(lambda v, x: 0.1 * v + np.sign(x) * np.maximum(np.abs(x) - 0.5, 0.0))
    (rest,) = equilibria(system, WIDE)
    assert rest.kind == "interval of rest"
    assert (rest.x, rest.until) == (pytest.approx(-0.5), pytest.approx(0.5))


def test_dry_friction_rests_where_it_can_hold() -> None:
    (rest,) = equilibria(of(lambda v, x: x + 0.3 * np.sign(v)), WIDE)
    assert rest.stretches
    assert (rest.x, rest.until) == (pytest.approx(-0.3), pytest.approx(0.3))
    # a drive that jumps the other way holds nothing
    (point,) = equilibria(of(lambda v, x: x - 0.3 * np.sign(v)), WIDE)
    assert not point.stretches


def test_a_jump_past_zero_is_no_rest() -> None:
    assert equilibria(of(lambda v, x: np.where(x < 0.1, -1.0, 1.0) + 0.1 * v), WIDE) == []


@pytest.mark.parametrize("at", [0.0, 0.06])
def test_a_relay_rests_in_the_middle_of_its_jump(at: float) -> None:
    window = Window(-13.23, 3.75, -3.0, 3.0)  # whose grid has no point there
    (rest,) = equilibria(of(lambda v, x: np.sign(x - at) + 0.1 * v), window)
    assert rest.x == at
    assert rest.kind == "stable focus"


def test_a_saddle_without_a_linear_part_has_the_curves_of_its_energy() -> None:
    """x'' = x^3: x'^2 = x^4 / 2 through the saddle."""
    system = of(lambda v, x: -(x**3))
    (saddle,) = equilibria(system, WIDE)
    curves = separatrices(system, WIDE, saddle)
    assert len(curves) == 4
    for curve in curves:
        assert curve[:, 1] ** 2 == pytest.approx(curve[:, 0] ** 4 / 2.0, abs=1e-5)
        assert np.abs(curve[-1]).max() > 3.7  # up to the border


# -- cycles --------------------------------------------------------------------------------------------


def van_der_pol(mu: float) -> tuple[float, float]:
    """Amplitude and period of the cycle, by another method: Radau's, event by event."""

    def axis(_t: float, state: Any) -> float:
        return float(state[1])

    axis.direction = -1.0  # type: ignore[attr-defined]
    solution = solve_ivp(
        lambda _t, y: [y[1], -mu * (y[0] ** 2 - 1.0) * y[1] - y[0]], (0.0, 4.0 * mu + 30.0),
        [2.0, 0.0], method="Radau", rtol=1e-9, atol=1e-11, events=axis,
    )  # fmt: skip
    times, states = solution.t_events[0], solution.y_events[0]
    return float(states[-1][0]), float(times[-1] - times[-2])


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("mu", [1.0, 5.0, 10.0, 20.0, 50.0])
def test_relaxation_cycles_in_high_windows(mu: float, sense: float) -> None:
    amplitude, period = van_der_pol(mu)
    window = Window(-3.0, 3.0, -2.0 * mu - 2.0, 2.0 * mu + 2.0)
    (cycle,) = limit_cycles(of(lambda v, x: sense * mu * (x * x - 1.0) * v + x), window)
    assert cycle.crossing == pytest.approx(amplitude, abs=2e-6)
    assert cycle.period == pytest.approx(period, rel=2e-6)
    assert cycle.attracts == (sense > 0.0)
    assert cycle.curve[:, 1].max() > mu


def radial(*radii: float, power: int = 1, size: float = 1.0) -> PhaseSystem:
    """x'' + x + size (r^2 - r1^2)(r^2 - r2^2)... x' = 0: circles as cycles."""

    def function(v: Any, x: Any) -> Any:
        square = x * x + v * v
        product = size
        for r in radii:
            product = product * (square - r * r)
        return x + product**power * v

    return of(function)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radii", "size", "attracts"),
    [
        ((1.0, 1.1), 1.0, [False, True]),
        ((1.0, 1.01), 1.0, [False, True]),
        ((2.0, 2.004), -0.05, [True, False]),
        ((0.5, 1.0, 3.0), 0.3, [True, False, True]),
    ],
)
def test_close_cycles_are_told_apart(
    radii: tuple[float, ...], size: float, attracts: list[bool]
) -> None:
    found = limit_cycles(radial(*radii, size=size), WIDE)
    assert [c.crossing for c in found] == pytest.approx(radii, abs=2e-5)
    assert [c.attracts for c in found] == attracts
    assert [c.period for c in found] == pytest.approx([2.0 * pi] * len(radii), abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("radius", [1.0, 0.98765, 2.5])
def test_a_cycle_that_attracts_from_one_side_is_found_and_said(radius: float) -> None:
    (cycle,) = limit_cycles(radial(radius, power=2), WIDE)
    assert cycle.kind == "semi-stable"
    assert cycle.crossing == pytest.approx(radius, abs=1e-3)
    assert not cycle.attracts


@pytest.mark.sampled
@pytest.mark.parametrize(
    "function",
    [
        lambda v, x: 0.2 * v + np.sin(x),
        lambda v, x: x + v**3,
        lambda v, x: x + 0.3 * x * v,  # closed curves all over
        lambda v, x: x + np.sign(v) * np.maximum(np.abs(v) - 0.5, 0.0),  # closed curves inside
        lambda v, x: x + 0.3 * np.sign(v),
        lambda v, x: x + ((x * x + v * v - 1.0) ** 2 + 0.01) * v,  # nearly one
        lambda v, x: np.sqrt(x),
        lambda v, x: x**3,
    ],
)
def test_what_has_no_limit_cycle(function: Callable[[Any, Any], Any]) -> None:
    assert limit_cycles(of(function), Window(-12.0, 12.0, -4.0, 4.0)) == []


@pytest.mark.slow
def test_a_cycle_around_three_equilibria_is_found_once() -> None:
    """Van der Pol's damping in a double well."""
    found = limit_cycles(of(lambda v, x: 0.3 * (x * x - 1.0) * v - x + x**3), WIDE)
    (outer,) = [c for c in found if c.crossing > 1.5]
    assert outer.attracts
    assert outer.curve[:, 0].min() < -1.5


# -- what is drawn -------------------------------------------------------------------------------------


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


def test_a_stop_as_hard_as_a_rail_does_not_flatten_a_portrait() -> None:
    soft = of(lambda v, x: 0.5 * v + x)
    hard = of(lambda v, x: 0.5 * v + x + 1e6 * np.minimum(x + 1.0, 0.0))
    assert window_of(hard, 3.0).top < 10.0 * window_of(soft, 3.0).top


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


def test_a_backlash_is_one_stretch_of_rest() -> None:
    formula = Formula("backlash(x, 0.6)")
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays)
    (rest,) = equilibria(system, WIDE)
    assert (rest.x, rest.until) == pytest.approx((-0.3, 0.3), abs=1e-6)


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


@pytest.mark.sampled
@pytest.mark.parametrize("half", [3e-4, 3e-2, 30.0])
@pytest.mark.parametrize(
    ("text", "kind"),
    [
        # the mean of v^4 is above zero, that of x^3 v^2 is zero; small windows said a centre
        ("x - v^3 + 3*x*abs(x)*v", "unstable focus"),
        ("x^3 - v^3 + 3*x*abs(x)*v", "unstable focus"),
        ("x + x*v - v*abs(x)^1.5 + v^3", "unstable focus"),  # the term of the least power decides
        # x'' + g dG/dx x' + dG/dx = 0 with g of G alone, over which as many turns lose as gain
        ("x + x^2 + (x + x^2)*sqrt(x^2/2 + x^3/3)*v", "centre"),
        # turns are closed at ever smaller distances, and not between them
        ("x + v*x^2*sin(2*log(x^2 + 1e-300))", "centre or focus"),
    ],
)
def test_the_kind_where_f_has_no_taylor_series(text: str, kind: str, half: float) -> None:
    made = Formula(text)
    system = PhaseSystem(made.function, on_arrays=made.on_arrays, switching=made.switching)
    found = equilibria(system, Window(-half, half, -half, half))
    assert [at.kind for at in found if at.x == 0.0] == [kind]


@pytest.mark.parametrize("half", [3.0, 8.0, 50.0])
def test_the_kind_beside_a_pole_that_is_looked_at(half: float) -> None:
    """At 8 and 50 the poles at -1 and 1 are points of the window, or of the rings about the centre."""
    made = Formula("x/(1 - x^2) - v^3 + 3*x*abs(x)*v")
    system = PhaseSystem(made.function, on_arrays=made.on_arrays, switching=made.switching)
    found = equilibria(system, Window(-half, half, -half, half))
    assert [at.kind for at in found if at.x == 0.0] == ["unstable focus"]


@pytest.mark.parametrize("half", [1e-2, 1e-6, 1e-8])
def test_the_kind_in_a_window_near_the_rounding_of_its_place(half: float) -> None:
    made = Formula("(x - C) - v^3 + 3*(x - C)*abs(x - C)*v", {"C": 1e6})
    system = PhaseSystem(made.function, on_arrays=made.on_arrays, switching=made.switching)
    (found,) = equilibria(system, Window(1e6 - half, 1e6 + half, -half, half))
    assert (found.x, found.kind) == (1e6, "unstable focus")


@pytest.mark.parametrize(("length", "time"), [(1e-9, 1.0), (1e6, 1.0), (1.0, 1e-4), (1.0, 1e4)])
@pytest.mark.parametrize(
    ("text", "kind"),
    [("X + V^3", "stable focus"), ("X - 0.001*V^3", "unstable focus"), ("X", "centre"),
     ("X + V*abs(V)", "stable focus"), ("X + 3*V", "stable node"),
     ("0.1*V - 0.3*sign(V) + X", "unstable node"), ("0.0001*sign(V) + X", "stable node"),
     ("X*abs(X) + 0.2*V", "stable node")],
)  # fmt: skip
def test_the_kind_of_an_equilibrium_does_not_depend_on_the_units(text, kind, length, time):
    scaled = text.replace("X", "(x/L)").replace("V", "(v*T/L)")
    formula = Formula(f"L/T^2*({scaled})", {"L": length, "T": time})
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays)
    height = 6.0 * length / time
    (found,) = equilibria(system, Window(-4.0 * length, 4.0 * length, -height, height))
    assert (found.kind, found.x) == (kind, 0.0)


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


def test_the_limit_cycle_of_a_clock_is_found_from_the_start_beside_it():
    """Half a turn multiplies the distance from the centre +-R by exp(-zeta pi / sqrt(1 - zeta^2))."""
    formula = Formula("0.1*v - 3*sign(v) + x")
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays, switching=formula.switching)
    (cycle,) = limit_cycles(system, window_of(system, 3.0, [(0.5, 0.0)]))
    shrink = exp(-0.05 * pi / sqrt(1.0 - 0.05**2))
    assert cycle.crossing == pytest.approx(3.0 * (1.0 + shrink) / (1.0 - shrink), rel=1e-6)
