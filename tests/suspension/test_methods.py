"""The methods `wilson` and `exact`: against closed forms, matrix exponentials and their own theory."""

from __future__ import annotations

from itertools import pairwise
from math import inf, sqrt

import numpy as np
import pytest
import truth as campaign
import vehicle_reference as reference
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, Load, System
from scipy.integrate import solve_ivp
from stepped import STOPS, displaced, mass_on, read_at, started


def oscillator(
    stiffness: float = 1.0, damping: float = 0.0, force: roads.Signal | float = 0.0
) -> System:
    laws = characteristics.linear(stiffness), characteristics.linear(damping)
    return mass_on(Element("spring", (1.0,), *laws), force=force, scale=1e-3)


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
        options = {"method": "wilson", "step": 1.0, "theta": theta, "energy": False}
        integrator = started(oscillator(phase**2), 1.0, **options)
        assert integrator.advance(2000.0) == 0
        integrator.sample(integrator.time)
        assert abs(integrator.sample_q[0]) <= 1e-3


def test_the_step_of_wilson_is_its_own_amplification_matrix() -> None:
    """A of Bathe and Wilson 1976, section 8.2: (q'', q', q) over one step, here worked out afresh."""
    theta, h, k, c = 1.4, 0.3, 5.0, 0.7
    integrator = started(oscillator(k, c), 0.01, 0.02, method="wilson", step=h, theta=theta)
    a, v, q = -c * 0.02 - k * 0.01, 0.02, 0.01
    s = theta * h
    for number in range(1, 6):
        # equilibrium at s with a linear: (1 + s/2 c + s^2/6 k) a_s = -c v* - k q*
        beyond = -c * (v + s / 2 * a) - k * (q + s * v + s * s / 3 * a)
        beyond /= 1 + s / 2 * c + s * s / 6 * k
        after = a + (beyond - a) / theta
        q, v = q + h * v + h * h / 6 * (2 * a + after), v + h / 2 * (a + after)
        a = after
        read_at(integrator, number * h)
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
    read_at(integrator, 0.5, stop=True)
    assert np.allclose(integrator.sample_q, z[:n], rtol=0, atol=1e-10 * np.abs(z[:n]).max())


def test_exact_keeps_a_slow_motion_beside_a_dead_one() -> None:
    """Damping of 1e10/s beside a creep of 1/s: two digits of the creep would be lost per decade."""
    damping, stiffness = 1e10, 1e10
    integrator = started(oscillator(stiffness, damping), 1.0, method="exact", step=0.25)
    read_at(integrator, 1.0, stop=True)
    root = sqrt(damping**2 - 4 * stiffness)
    slow, fast = 2 * stiffness / (damping + root), (damping + root) / 2
    expected = np.exp(-slow) / (1.0 - slow / fast)
    assert integrator.sample_q[0] == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    ("system", "reason"),
    [
        (build("QuarterCar", {"spring.cubic": 1e5}), "the spring of 'spring' is curved"),
        (
            oscillator(force=roads.sweep(1.0, 1.0, 5.0, 2.0)),
            "the frequency of 'force' changes",
        ),
    ],
)
def test_exact_refuses_what_has_no_closed_form(system: System, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        Integrator(system, "exact")
