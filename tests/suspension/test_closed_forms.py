"""Motions that have a closed form, each through the element or the model that makes it."""

from __future__ import annotations

from cmath import cosh, sinh
from cmath import sqrt as complex_sqrt
from math import acos, asin, cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.engine import METHODS, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, System
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk
from stepped import displaced, mass_on, read_at, started

TIGHT = 1e-11


def oscillator(
    mass: float,
    spring: Characteristic | float = 0.0,
    damper: Characteristic | float = 0.0,
    force: roads.Signal | float = 0.0,
    **more: float,
) -> System:
    """A mass on one element; numbers are linear rates."""
    laws = [
        characteristics.linear(law) if isinstance(law, float) else law for law in (spring, damper)
    ]
    return mass_on(Element("element", (1.0,), *laws, **more), mass=mass, force=force, scale=1e-2)


def positions(
    system: System, times: np.ndarray, start: tuple[float, float] = (0.0, 0.0)
) -> tuple[np.ndarray, Integrator]:
    """Displacements of the first coordinate at some instants, from x and x' at 0."""
    integrator = started(system, *start, tolerance=TIGHT)
    return displaced(integrator, times)[:, 0], integrator


def swing(natural: float, ratio: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The free motions of x'' + 2 D w x' + w^2 x = 0 that start from (1, 0) and from (0, 1)."""
    decay = ratio * natural
    s = complex_sqrt(decay**2 - natural**2)
    shapes = [(cosh(s * u), sinh(s * u) / s if s else u) for u in t]
    c, d = np.array(shapes).real.T * np.exp(-decay * t)
    return c + decay * d, d


RATIOS = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 3.0))


@settings(max_examples=30)
@given(st.floats(0.1, 500.0), st.floats(1.0, 100.0), RATIOS, st.floats(-1.0, 1.0))
def test_damped_free_vibration(mass: float, natural: float, ratio: float, speed: float) -> None:
    """Below, at and above critical damping."""
    t = np.linspace(0.0, 12.0 / natural, 13)
    system = oscillator(mass, mass * natural**2, 2.0 * ratio * natural * mass)
    found, _ = positions(system, t, (0.01, speed))
    from_place, from_speed = swing(natural, ratio, t)
    expected = 0.01 * from_place + speed * from_speed
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ratio", [3.0, 30.0, 1000.0])
def test_steps_chosen_by_a_method_resolve_what_a_damper_alone_brings_to_rest(
    method: str, ratio: float
) -> None:
    """Without a spring, and with one so soft that its period says nothing of the decay."""
    mass, natural, t = 100.0, 0.1, np.array([0.5])
    damping = 2.0 * ratio * natural * mass
    soft = oscillator(mass, mass * natural**2, damping)
    for system, expected in (
        (soft, swing(natural, ratio, t)[1]),
        (oscillator(mass, 0.0, damping), mass / damping * -np.expm1(-damping / mass * t)),
    ):
        integrator = started(system, 0.0, 1.0, method=method, tolerance=1e-6)
        assert displaced(integrator, t)[0, 0] == pytest.approx(expected[0], rel=3e-5)


@settings(max_examples=20)
@given(st.floats(20.0, 800.0), st.floats(3.0, 30.0), RATIOS, st.sampled_from([-5e3, 10.0, 700.0]))
def test_step_of_the_force_on_the_body(
    mass: float, natural: float, ratio: float, force: float
) -> None:
    """x = F/k (1 - free motion from 1), through the input of the public model."""
    rate, damping = mass * natural**2, 2.0 * ratio * natural * mass
    session = Session(
        "OneDof",
        {"sprung_mass": mass, "spring.rate": rate, "damper.rebound_rate": damping,
         "damper.bump_rate": damping, "road.shape": "flat", "solver.tolerance": TIGHT},
    )  # fmt: skip
    session.set_input("body_force", force)
    t = np.linspace(0.0, 12.0 / natural, 13)
    expected = force / rate * (1.0 - swing(natural, ratio, t)[0])
    for instant, x in zip(t, expected, strict=True):
        session.advance(float(instant))
        assert session.value("body_displacement") == pytest.approx(x, abs=1e-9 * abs(force) / rate)


def test_a_force_table_that_rises_and_then_stays() -> None:
    """m x'' + k x = F' t: x = F'/k (t - sin(w t)/w); from its end on less the same, later."""
    mass, natural, slope, ends = 250.0, 9.0, 4e3, 0.25
    session = Session(
        "OneDof",
        {"sprung_mass": mass, "spring.rate": mass * natural**2, "damper.rebound_rate": 0.0,
         "damper.bump_rate": 0.0, "road.shape": "flat", "solver.tolerance": TIGHT,
         "body_force.table": f"0:0, {ends}:{slope * ends}"},
    )  # fmt: skip

    def rising(t: float) -> float:
        return slope / (mass * natural**2) * (t - sin(natural * t) / natural)

    for t in np.linspace(0.0, 1.0, 21):
        session.advance(float(t))
        expected = rising(t) - (rising(t - ends) if t > ends else 0.0)
        assert session.value("body_displacement") == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("duration", [0.05, 0.3, 0.9])
@pytest.mark.parametrize("ratio", [0.0, 0.2])
def test_half_a_sine_of_force(duration: float, ratio: float) -> None:
    """The steady part less the free motion that cancels it at 0; free motion afterwards."""
    k, mass, peak = 5000.0, 100.0, 4.0
    natural, drive = sqrt(k / mass), pi / duration
    half_sine = roads.Signal(
        (
            roads.Segment(-float("inf")),
            roads.Segment(0.0, 0.0, amplitude=peak, phase=(-pi / 2, drive, 0.0)),
            roads.Segment(duration),
        ),
        peak,
    )
    damping = 2.0 * ratio * natural * mass
    steady = peak / complex(k - mass * drive**2, damping * drive)  # Im(steady exp(i drive t))

    def forced(t: np.ndarray) -> np.ndarray:
        from_place, from_speed = swing(natural, ratio, t)
        part = (steady * np.exp(1j * drive * t)).imag
        return part - steady.imag * from_place - (steady * 1j * drive).imag * from_speed

    def forced_rate(t: float) -> float:
        # the derivatives of the two free motions: -w^2 from_speed, and from_place - 2 D w from_speed
        (from_place,), (from_speed,) = swing(natural, ratio, np.array([t]))
        rates = (-(natural**2) * from_speed, from_place - 2.0 * ratio * natural * from_speed)
        part = (steady * 1j * drive * np.exp(1j * drive * t)).imag
        return part - steady.imag * rates[0] - (steady * 1j * drive).imag * rates[1]

    t = np.linspace(0.0, 1.2, 25)
    found, _ = positions(oscillator(mass, k, damping, half_sine), t)
    during, after = forced(np.minimum(t, duration)), np.maximum(t - duration, 0.0)
    from_place, from_speed = swing(natural, ratio, after)
    free = float(forced(np.array([duration]))[0]) * from_place + forced_rate(duration) * from_speed
    expected = np.where(t < duration, during, free)
    assert np.abs(found - expected).max() < 1e-11


@pytest.mark.parametrize("hardening", [0.0, 200.0, 2500.0])
def test_impact_on_an_elastic_plastic_spring(hardening: float) -> None:
    """Undamped: part of a sine up to the yield point, one of the hardening slope, elastic again."""
    k, mass, limit, speed = 5000.0, 100.0, 6.0, 0.05
    omega = sqrt(k / mass)
    at_yield = asin(limit / k * omega / speed) / omega
    slower = speed * cos(omega * at_yield)
    slow = sqrt(hardening / mass)
    # while it flows: m x'' = -limit - h x, from x' = slower
    if hardening:
        reach, lag = sqrt((limit / hardening) ** 2 + (slower / slow) ** 2), limit / hardening
        turning = asin(slower / slow / reach) / slow
        flowed = reach - lag
    else:
        turning, flowed = slower * mass / limit, 0.5 * mass * slower**2 / limit
    turns, furthest = at_yield + turning, limit / k + flowed
    left = furthest - (limit + hardening * flowed) / k
    system = oscillator(mass, k, yield_force=limit, hardening=hardening)
    # elastic over a range of 2 limit / k, which with no hardening takes just half a period
    ends = acos(max(-1.0, 1.0 - 2.0 * limit / k / (furthest - left)))
    late = np.array([0.1, 0.5, 1.0]) * ends / omega
    found, integrator = positions(system, turns + late, (0.0, speed))
    assert [event[0] for event in integrator.log[:2]] == pytest.approx([at_yield, turns], abs=1e-9)
    expected = left + (furthest - left) * np.cos(omega * late)
    assert found == pytest.approx(expected, abs=1e-11)
    assert integrator.energy_residual() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("damping", [0.0, 300.0])
def test_flight_between_lift_off_and_touchdown(damping: float, contact: str) -> None:
    """Parabola of the centre of mass, and the two masses swinging about it on their spring.

    In flight M x1'' = -k y - c y' and m x2'' = k y + c y' - (M + m) g, so that the centre falls freely
    and y'' + (k y + c y') / mu = (M + m) g / m with mu = M m / (M + m).
    """
    body, wheel, rate, stiffness, loss, g = 300.0, 30.0, 15e3, 150e3, 500.0, 9.80665
    system = build(
        "QuarterCar",
        {"sprung_mass": body, "unsprung_mass": wheel, "spring.rate": rate,
         "damper.rebound_rate": damping, "damper.bump_rate": damping,
         "tyre.stiffness": stiffness, "tyre.damping": loss, "road.height": 0.06,
         "contact": contact},
    )  # fmt: skip
    whole, reduced = body + wheel, body * wheel / (body + wheel)
    natural = sqrt(rate / reduced)
    ratio = damping / (2.0 * reduced * natural)
    first = Integrator(system, tolerance=1e-12)
    tyre = system.element("tyre")
    while not any(e == tyre for _, e, *_ in first.log):
        assert first.advance(first.time + 1e-4) == 0
    lift_off = next(t for t, e, *_ in first.log if e == tyre)
    touchdown = next(
        t for t, e, *_ in _switches(system, lift_off + 0.2) if e == tyre and t > lift_off
    )
    integrator = Integrator(system, tolerance=1e-12)
    (x1, x2), (v1, v2) = read_at(integrator, lift_off, stop=True)
    centre, drift = (body * x1 + wheel * x2) / whole, (body * v1 + wheel * v2) / whole
    hanging = whole * g / wheel / natural**2  # y at which the spring carries the wheel's weight

    def closed(t: float) -> tuple[float, float]:
        s = t - lift_off
        (from_place,), (from_speed,) = swing(natural, ratio, np.array([s]))
        y = hanging + (x1 - x2 - hanging) * from_place + (v1 - v2) * from_speed
        fallen = centre + drift * s - 0.5 * g * s * s
        return fallen + wheel / whole * y, fallen - body / whole * y

    for t in np.linspace(lift_off, touchdown, 9):
        assert read_at(integrator, t)[0] == pytest.approx(closed(t), abs=1e-11)
    # touchdown is where the tyre, its rate included, would press again, or where its gap closes
    road = system.signals["road"]

    def bracket(t: float) -> float:
        step = 1e-6
        rate_of_wheel = (closed(t + step)[1] - closed(t - step)[1]) / (2 * step)
        squeezed = stiffness * (closed(t)[1] - road.value(t))
        return squeezed + loss * (rate_of_wheel - road.rate(t)) - whole * g

    assert touchdown - lift_off > 0.02
    assert bracket(lift_off + 1e-3) > 0.0

    def gap(t: float) -> float:
        return stiffness * (closed(t)[1] - road.value(t)) - whole * g

    condition = bracket if contact == "force" else gap
    found = brentq(condition, touchdown - 2e-3, touchdown + 2e-3)
    assert touchdown == pytest.approx(found, abs=1e-7)


def _switches(system: System, until: float) -> list[tuple[float, int]]:
    integrator = Integrator(system, tolerance=1e-12)
    assert integrator.advance(until) == 0
    return list(integrator.log)


@pytest.mark.parametrize("amplitude", [0.01, 0.1, 0.5])
def test_a_hardening_spring_swings_as_the_elliptic_cosine(amplitude: float) -> None:
    """m x'' + k x + g x^3 = 0: x = A cn(w t, p), w^2 = (k + g A^2)/m, p = g A^2 / 2(k + g A^2)."""
    mass, rate, cubic = 2.0, 800.0, 2e4
    omega = sqrt((rate + cubic * amplitude**2) / mass)
    p = cubic * amplitude**2 / (2.0 * mass * omega**2)
    t = np.linspace(0.0, 3.0 * 4.0 * ellipk(p) / omega, 40)  # three periods
    found, _ = positions(oscillator(mass, characteristics.cubic(rate, cubic)), t, (amplitude, 0.0))
    assert found == pytest.approx(amplitude * ellipj(omega * t, p)[1], abs=1e-9 * amplitude)


def test_beyond_blow_off_the_damper_brakes_evenly() -> None:
    """A valve that opens at F and holds it: v falls by F/m a second to F/c, then exponentially."""
    mass, rate, limit, speed = 4.0, 200.0, 30.0, 2.0
    system = oscillator(mass, damper=characteristics.damper(rate, rate, limit, limit, 0.0))
    closes = (speed - limit / rate) * mass / limit
    t = np.array([0.4 * closes, closes, closes + 0.02, closes + 1.0])
    found, integrator = positions(system, t, (0.0, speed))
    braked = speed * closes - 0.5 * limit / mass * closes**2
    creeping = (limit / rate) * mass / rate
    expected = [
        speed * t[0] - 0.5 * limit / mass * t[0] ** 2,
        braked,
        *(braked + creeping * (1.0 - np.exp(-rate / mass * (u - closes))) for u in t[2:]),
    ]
    assert found == pytest.approx(np.array(expected), abs=1e-11)
    assert integrator.log[0][0] == pytest.approx(closes, abs=1e-12)
