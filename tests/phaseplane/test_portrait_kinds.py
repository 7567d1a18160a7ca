"""The kinds of equilibria, also where the linear part says nothing: bent springs, weak damping, play."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from phase_systems import WIDE, of

from phaseplane.equations import Formula
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    equilibria,
)

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
        ("x + v*((x^2 + v^2)^2 - 1e-6*(x^2 + v^2))", "unstable focus"),  # in a cycle of 1e-3
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


def test_a_backlash_is_one_stretch_of_rest() -> None:
    formula = Formula("backlash(x, 0.6)")
    system = PhaseSystem(formula.function, on_arrays=formula.on_arrays)
    (rest,) = equilibria(system, WIDE)
    assert (rest.x, rest.until) == pytest.approx((-0.3, 0.3), abs=1e-6)


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
        # limit cycles of radii e^(k pi/2), or 35 000 times as large as the next
        ("x + v*x^2*sin(log(x^2 + v^2 + 1e-300))", "centre or focus"),
        ("x + v*x^2*sin(0.15*log(x^2 + v^2 + 1e-300))", "centre or focus"),
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
