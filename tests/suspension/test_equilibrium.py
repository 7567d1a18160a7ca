"""Static equilibrium: closed forms, stops, tables, preload, and what cannot stand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import characteristics as law
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.equilibrium import static_equilibrium
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variable import ParameterError
from scipy.optimize import brentq
from stepped import mass_on, read_at


def hanging(spring: law.Characteristic, *more: Element, **changes: object) -> System:
    """A mass of 100 kg on one spring, under its load."""
    elements = (Element("spring", (1.0,), spring, law.linear(500.0), **changes), *more)  # type: ignore[arg-type]
    return mass_on(*elements, mass=100.0, force=-981.0, scale=0.01)


def test_a_system_in_equilibrium_stays_exactly() -> None:
    assert static_equilibrium(build("HalfCar", {})) == (0.0, 0.0, 0.0, 0.0)


@given(st.floats(1e2, 1e7), st.floats(0.0, 1e9), st.floats(-1e5, 1e5))
def test_cubic_springs(rate: float, cubic: float, weight: float) -> None:
    (x,) = static_equilibrium(hanging(law.cubic(rate, cubic)), {"force": weight})
    assert rate * x + cubic * x**3 == pytest.approx(weight, rel=1e-9, abs=1e-9)


@given(st.floats(0.0, 0.05), st.floats(1e3, 1e9), st.floats(-1e5, 1e5))
def test_stops_that_are_met(gap: float, stiffness: float, weight: float) -> None:
    both = law.bump_stop(gap, stiffness), law.rebound_stop(gap, stiffness)
    stops = [Element(f"stop {k}", (1.0,), stop) for k, stop in enumerate(both)]
    (x,) = static_equilibrium(hanging(law.linear(2e4), *stops), {"force": weight})
    free = weight / 2e4
    beyond = (abs(weight) + stiffness * gap) / (2e4 + stiffness)
    expected = free if abs(free) <= gap else (beyond if weight > 0 else -beyond)
    assert x == pytest.approx(expected, rel=1e-9, abs=1e-12)


TABLE = law.monotone_table([(-0.2, -9e3), (-0.1, -2e3), (0.0, 0.0), (0.05, 3e2), (0.1, 8e3)])


@given(st.floats(-5e4, 5e4))
def test_tables(weight: float) -> None:
    (x,) = static_equilibrium(hanging(TABLE), {"force": weight})
    assert x == pytest.approx(brentq(lambda d: TABLE.force(d) - weight, -5.0, 5.0, xtol=1e-15))


def test_law_with_a_force_at_zero() -> None:
    """Under preload: a spring pressed together from its free length by 0.1 m, and nothing outside."""
    pressed = law.cubic(2e4, 1e6).moved(-0.1, 0.0)
    assert pressed.force(0.0) == pytest.approx(-3e3)
    (x,) = static_equilibrium(hanging(pressed))
    assert x == pytest.approx(0.1)


def test_a_car_on_a_high_road_and_a_pulled_body() -> None:
    car = build("QuarterCar", {"bump_stop.stiffness": 1e6, "bump_stop.gap": 0.01})
    assert static_equilibrium(car, {"road": 0.1}) == pytest.approx((0.1, 0.1), rel=1e-13)
    spring, tyre = 1500 * 9.80665, 15000 * 9.80665
    body, wheel = static_equilibrium(car, {"body_force": 2000.0})
    assert (wheel, body - wheel) == pytest.approx((2000.0 / tyre, 2000.0 / spring))
    with pytest.raises(ValueError, match="no static equilibrium"):  # more than its weight
        static_equilibrium(car, {"body_force": 3500.0})


def test_beyond_yield() -> None:
    spring = hanging(law.linear(5e4), yield_force=600.0, hardening=5e3, permanent_set=0.002)
    (x,) = static_equilibrium(spring, {"force": 981.0})
    # on the line of flow: yield force (1 - flow / rate) + flow d
    assert x == pytest.approx((981.0 - 600.0 * 0.9) / 5e3)
    assert static_equilibrium(spring) == pytest.approx((0.002,))


def test_what_nothing_holds() -> None:
    with pytest.raises(ValueError, match="no static equilibrium"):
        static_equilibrium(hanging(law.linear(0.0)), {"force": -981.0})
    falling = {"spring.rate": 0.0, "spring.cubic": -1.0, "road.shape": "sine", "road.start": -1.0}
    with pytest.raises(ParameterError, match="the start: no static equilibrium"):
        Session("OneDof", falling)


def test_a_run_from_equilibrium_stays_there() -> None:
    system = hanging(TABLE, Element("friction", (1.0,), friction=5.0))
    integrator = Integrator(system)
    rest = static_equilibrium(system, {"force": -981.0})
    integrator.set_state(rest, (0.0,))
    read_at(integrator, 1.0)
    assert integrator.sample_q[0] == pytest.approx(rest[0], rel=1e-12)
