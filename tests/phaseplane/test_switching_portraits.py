"""Portraits of equations that switch."""

from __future__ import annotations

from math import exp, nan, pi, sqrt

import numpy as np
import pytest
from phaseplane.suspension.models import build

from phaseplane.equations import Formula, motion
from phaseplane.equations.stepping import steps
from phaseplane.portrait import (
    PhaseSystem,
    Window,
    compute_portrait,
    equilibria,
    followed,
    limit_cycles,
    of_coordinate,
    section,
)
from phaseplane.portrait.returns import turns

WINDOW = Window(-4.0, 4.0, -4.0, 4.0)


def portrayed(text: str, **parameters: float) -> PhaseSystem:
    formula = Formula(text, parameters)
    return PhaseSystem(
        formula.function, period=formula.period or 0.0, on_arrays=formula.on_arrays,
        switching=formula.switching,
    )  # fmt: skip


def test_curves_of_dry_friction_are_circles_that_end_on_the_stretch_of_rest():
    (found,) = followed(portrayed("x + 0.3*sign(v)"), WINDOW, [2.05], [0.0])
    below = found[: int(np.argmax(found[1:, 1] >= 0.0)) + 1]
    assert np.hypot(below[:, 0] - 0.3, below[:, 1]) == pytest.approx(1.75, abs=1e-6)
    assert found[-1] == pytest.approx([-0.25, 0.0], abs=1e-7)


def test_curves_of_a_relay_end_in_the_origin_along_its_line():
    (found,) = followed(portrayed("sign(x + 0.3*v)"), WINDOW, [2.0], [0.0])
    assert np.hypot(*found[-1]) < 1e-4
    late = found[np.abs(found[:, 1]) < 0.2][-50:]
    assert late[:, 0] + 0.3 * late[:, 1] == pytest.approx(0.0, abs=1e-7)


def test_backwards_a_curve_is_the_one_that_it_came_along():
    system = portrayed("x + 0.3*sign(v)")
    (there,) = followed(system, WINDOW, [1.0], [1.0])
    middle = there[len(there) // 4]
    (back,) = followed(system, WINDOW, [middle[0]], [middle[1]], -1.0)
    assert np.hypot(*(back - [1.0, 1.0]).T).min() < 0.06


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("d", [0.15, -0.05])
def test_half_turns_with_dry_friction_are_about_the_ends_of_the_stretch_of_rest(d, backwards):
    """x'' - 2d x' + x + R sign(x') = 0: forwards about R first, where x' < 0, backwards about -R."""
    friction, turned = 0.3, sqrt(1.0 - d * d)
    q = exp((-d if backwards else d) * pi / turned)
    centre = -friction if backwards else friction
    x = np.array([0.25, 0.7, 1.5, 2.5])
    far = centre - q * (x - centre)
    back = -centre - q * (far + centre)
    if not backwards:  # a motion that comes to the stretch of rest stays there
        far[(x < friction) | (np.abs(far) < friction)] = nan
        back[np.isnan(far) | (np.abs(back) < friction)] = nan
    into = [[(float(start), 0.0)] for start in x]
    system = portrayed("-2*d*v + x + R*sign(v)", d=d, R=friction)
    made = turns(system, WINDOW, x, backwards=backwards, into=into)
    assert made.far == pytest.approx(far, abs=1e-8, nan_ok=True)
    assert made.back == pytest.approx(back, abs=1e-8, nan_ok=True)
    assert made.time == pytest.approx(np.where(np.isnan(back), nan, 2.0 * pi / turned), nan_ok=True)
    for start, points in zip(x, into, strict=True):
        (x1, v1), *_ = points[1:] or [(start, 0.0)]
        assert v1 * centre <= 0.0
        assert x1 <= start


def test_the_limit_cycle_of_negative_damping_and_dry_friction():
    """x'' - 2d x' + x + R sign(x') = 0: half turns about +-R grow by q = exp(d pi / w).

    A half turn from x to -x closes the cycle: x + R = q (x - R).
    """
    d, friction = 0.15, 0.5
    turned = sqrt(1.0 - d * d)
    q = exp(d * pi / turned)
    (cycle,) = limit_cycles(portrayed("-2*d*v + x + R*sign(v)", d=d, R=friction), WINDOW)
    assert cycle.crossing == pytest.approx(friction * (q + 1.0) / (q - 1.0), rel=1e-6)
    assert cycle.period == pytest.approx(2.0 * pi / turned, rel=1e-6)
    assert cycle.multiplier == pytest.approx(q * q, rel=1e-3)
    assert cycle.kind == "repels"


@pytest.mark.slow
def test_the_section_of_a_driven_mass_with_friction_is_den_hartogs():
    """J. P. Den Hartog, Trans. ASME 53 (1931): without stops, x at the turn from the closed form."""
    friction, force, w = 0.1, 0.5, 0.8
    shown = compute_portrait(
        portrayed("x + R*sign(v) - F*cos(w*t)", R=friction, F=force, w=w), WINDOW, periods=60
    )
    assert shown.section is not None
    (attractor,) = shown.section.attractors
    x, v = attractor[-1]
    beta = 1.0 / w
    response = beta**2 / (beta**2 - 1.0)
    damping = beta * np.sin(beta * pi) / (1.0 + np.cos(beta * pi))
    amplitude = force * sqrt(response**2 - (friction / force) ** 2 * damping**2)
    formula = Formula("x + R*sign(v) - F*cos(w*t)", {"R": friction, "F": force, "w": w})
    times = np.linspace(0.0, 2.0 * pi / w, 4001)
    found = motion(formula.switching, (float(x), float(v)), times.tolist())
    assert max(found.displacements) == pytest.approx(amplitude, rel=1e-5)


def test_motions_with_many_switches_have_a_section_of_fewer_periods(monkeypatch):
    """Fast turns far out and a relay took a minute and a half: 600 000 steps, followed one by one."""
    made = []

    def counted(*start, **how):
        for step in steps(*start, **how):
            made.append(step)
            yield step

    monkeypatch.setattr("phaseplane.portrait.switched.steps", counted)
    monkeypatch.setattr("phaseplane.portrait.poincare._MOST_SWITCHED_STEPS", 2000)
    system = portrayed("x + 10*sinh(x) + 10*relay(v, 0.2) + 1.5*cos(1.2*t)")
    states = section(system, Window(-3.0, 3.0, -20.0, 20.0), (0.5, 0.0))
    assert len(made) < 8000
    assert len(states.points) > 26


def test_a_vehicle_with_dry_friction_has_its_stretch_of_rest():
    """The friction of a leaf spring over its rate, to both sides."""
    system = build("OneDof", {"friction": 300.0})
    rate = system.elements[0].spring.tangent(0.0)
    section = of_coordinate(system)
    (rest,) = equilibria(section, Window(-0.1, 0.1, -1.0, 1.0))
    assert (rest.x, rest.until) == pytest.approx((-300.0 / rate, 300.0 / rate), rel=1e-6)
    (curve,) = followed(section, Window(-0.1, 0.1, -1.0, 1.0), [0.08], [0.0])
    assert curve[-1, 1] == 0.0
    assert abs(curve[-1, 0]) <= 300.0 / rate * (1.0 + 1e-9)
