"""The methods `wilson` and `exact`: against closed forms, matrix exponentials and their own theory."""

from __future__ import annotations

from itertools import pairwise
from math import inf, pi, sqrt

import numpy as np
import pytest
import truth as campaign
import vehicle_reference as reference
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, Load, System
from scipy.integrate import solve_ivp
from stepped import displaced

STOPS = {
    "damper.rebound_limit": 588.399,
    "damper.limit_slope": 200.0,
    "bump_stop.gap": 0.02,
    "bump_stop.stiffness": 3e5,
    "rebound_stop.gap": 0.02,
    "rebound_stop.stiffness": 3e5,
}


def oscillator(stiffness: float = 1.0, damping: float = 0.0, signals: object = None) -> System:
    element = Element(
        "spring", (1.0,), characteristics.linear(stiffness), characteristics.linear(damping)
    )
    loads = (Load((1.0,), "force"),) if signals else ()
    return System(("x",), ((1.0,),), (element,), signals or {}, loads, (1e-3,))


def chain(rng: np.random.Generator, n: int) -> System:
    """n masses in a row with drawn springs and dampers, the first of them on a road."""
    elements, signals = [], {"road": roads.sine(0.03, 1.0, 3.0)}
    rows = [np.eye(n)[0], *(np.eye(n)[k] - np.eye(n)[k - 1] for k in range(1, n))]
    for k, row in enumerate(rows):
        spring = characteristics.linear(10 ** rng.uniform(2, 5))
        damper = characteristics.linear(10 ** rng.uniform(0, 3))
        road = "road" if k == 0 else ""
        elements.append(Element(f"e{k}", tuple(map(float, row)), spring, damper, road))
    signals["force"] = roads.Signal(
        (
            roads.Segment(-inf),
            roads.Segment(0.1, 0.1, (20.0, 300.0, -4e3, 5e3)),
            roads.Segment(0.3, 0.3, amplitude=50.0, phase=(0.3, 40.0, 0.0)),
        )
    )
    factor = rng.normal(size=(n, n)) * 0.3
    mass = factor @ factor.T + np.diag(rng.uniform(1.0, 50.0, n))
    return System(
        tuple(f"x{k}" for k in range(n)),
        tuple(tuple(map(float, row)) for row in mass),
        tuple(elements),
        signals,
        (Load(tuple(map(float, np.eye(n)[-1])), "force"),),
        tuple([1e-2] * n),
    )


@pytest.mark.parametrize("theta", [1.37, 1.4, 2.0])
def test_wilson_dies_away_at_any_step(theta: float) -> None:
    """Its acceleration is carried on, not recomputed: that alone makes it stable."""
    for phase in (1.0, 3.0, 10.0, 1e3):
        integrator = Integrator(oscillator(phase**2), "wilson", step=1.0, theta=theta, energy=False)
        integrator.set_state([1.0], [0.0])
        assert integrator.advance(2000.0) == 0
        integrator.sample(integrator.time)
        assert abs(integrator.sample_q[0]) <= 1e-3


def test_the_step_of_wilson_is_its_own_amplification_matrix() -> None:
    """A of Bathe and Wilson 1976, section 8.2: (q'', q', q) over one step, here worked out afresh."""
    theta, h, k, c = 1.4, 0.3, 5.0, 0.7
    integrator = Integrator(oscillator(k, c), "wilson", step=h, theta=theta)
    integrator.set_state([0.01], [0.02])
    a, v, q = -c * 0.02 - k * 0.01, 0.02, 0.01
    s = theta * h
    for number in range(1, 6):
        # equilibrium at s with a linear: (1 + s/2 c + s^2/6 k) a_s = -c v* - k q*
        beyond = -c * (v + s / 2 * a) - k * (q + s * v + s * s / 3 * a)
        beyond /= 1 + s / 2 * c + s * s / 6 * k
        after = a + (beyond - a) / theta
        q, v = q + h * v + h * h / 6 * (2 * a + after), v + h / 2 * (a + after)
        a = after
        assert integrator.advance(number * h) == 0
        integrator.sample(number * h)
        assert integrator.sample_q[0] == pytest.approx(q, rel=1e-12)
        assert integrator.sample_v[0] == pytest.approx(v, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("parameters", [{}, {"spring.rate": 5e4, "lift_off": False}])
def test_wilson_is_of_order_two(parameters: dict[str, object]) -> None:
    truth = reference.quarter_car(parameters, np.linspace(0.0, 0.4, 21))
    steps = 5e-4 / 2.0 ** np.arange(4)
    errors = [error(parameters, truth, method="wilson", step=h) for h in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


def test_theta_below_its_limit_is_refused() -> None:
    with pytest.raises(ValueError, match=r"theta = 1\.3 must be at least 1\.37"):
        Integrator(oscillator(), "wilson", theta=1.3)


def error(
    parameters: dict[str, object], truth: reference.Solution | campaign.Truth, **options: object
) -> float:
    found = displaced(Integrator(build("QuarterCar", parameters), **options), truth.times)
    exact = truth.displacements
    return float(np.abs(found - exact).max() / np.abs(exact).max())


@pytest.mark.slow
@pytest.mark.parametrize("parameters", [{}, STOPS, {"road.shape": "sine"}])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-10])
def test_exact_is_right_to_its_interpolant(parameters: dict[str, object], tolerance: float) -> None:
    truth = reference.quarter_car(parameters, np.linspace(0.0, 0.5, 26))
    assert error(parameters, truth, method="exact", tolerance=tolerance) < tolerance


def test_exact_at_any_fixed_step_is_right_to_rounding() -> None:
    truth = campaign.solve(build("QuarterCar", STOPS), np.zeros(4), np.linspace(0.0, 0.5, 26))
    assert error(STOPS, truth, method="exact", step=0.02) < 2e-13
    assert error({**STOPS, "tyre.damping": 990.0}, truth, method="exact", step=0.02) > 1e-5


@pytest.mark.parametrize("seed", range(4))
def test_exact_on_drawn_chains_over_cubics_and_cosines(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 6))
    system = chain(rng, n)
    mass = np.array(system.mass)

    def rates(t: float, z: np.ndarray) -> np.ndarray:
        net = np.zeros(n)
        net[-1] = system.signals["force"].value(t)
        for e in system.elements:
            b = np.array(e.direction)
            u = system.signals["road"].derivatives(t) if e.road else (0.0, 0.0)
            force = e.spring.force(b @ z[:n] - u[0]) + e.damper.force(b @ z[n:] - u[1])
            net -= b * force
        return np.concatenate([z[n:], np.linalg.solve(mass, net)])

    z, cuts = np.zeros(2 * n), (0.0, 0.1, 0.3, 0.5)
    for a, b in pairwise(cuts):
        z = solve_ivp(rates, (a, b - 1e-15), z, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    integrator = Integrator(system, "exact", step=0.1)
    assert integrator.advance(0.5, True) == 0
    integrator.sample(0.5)
    assert np.allclose(integrator.sample_q, z[:n], rtol=0, atol=1e-10 * np.abs(z[:n]).max())


def test_exact_keeps_a_slow_motion_beside_a_dead_one() -> None:
    """Damping of 1e10/s beside a creep of 1/s: two digits of the creep would be lost per decade."""
    damping, stiffness = 1e10, 1e10
    integrator = Integrator(oscillator(stiffness, damping), "exact", step=0.25)
    integrator.set_state([1.0], [0.0])
    integrator.advance(1.0, True)
    integrator.sample(1.0)
    root = sqrt(damping**2 - 4 * stiffness)
    slow, fast = 2 * stiffness / (damping + root), (damping + root) / 2
    expected = np.exp(-slow) / (1.0 - slow / fast)
    assert integrator.sample_q[0] == pytest.approx(expected, rel=1e-13)


def test_exact_with_friction_that_sticks_and_slips() -> None:
    """x'' + x = -+F after Coulomb: half swings about -+F, each shorter by 2 F."""
    friction, start = 0.1, 1.05
    system = System(
        ("x",), ((1.0,),), (Element("s", (1.0,), characteristics.linear(1.0), friction=friction),)
    )
    system = System(system.coordinates, system.mass, system.elements, scales=(1.0,))
    integrator = Integrator(system, "exact", tolerance=1e-9)
    integrator.set_state([start], [0.0])
    for swing in range(1, 5):
        assert integrator.advance(swing * pi) == 0
        integrator.sample(swing * pi)
        expected = (-1) ** swing * (start - 2 * friction * swing)
        assert integrator.sample_q[0] == pytest.approx(expected, abs=1e-8)
    integrator.advance(100.0)
    integrator.sample(100.0)
    assert integrator.sample_v[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"spring.cubic": 1e5}, "the spring of 'spring' is curved"),
    ],
)
def test_exact_refuses_what_is_not_straight(parameters: dict[str, object], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        Integrator(build("QuarterCar", parameters), "exact")


def test_exact_refuses_a_changing_frequency() -> None:
    signals = {"force": roads.sweep(1.0, 1.0, 5.0, 2.0)}
    with pytest.raises(ValueError, match="the frequency of 'force' changes"):
        Integrator(oscillator(1.0, 0.1, signals), "exact")
