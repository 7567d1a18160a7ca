"""Dampers that saturate or depend on deflection: closed forms, an independent reference, energy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, System, damper_family
from phaseplane.suspension.variable import ParameterError
from scipy.integrate import quad
from stepped import read_at

RATES = st.floats(10.0, 1e5)
FORCES = st.floats(1.0, 1e4)


@given(RATES, FORCES, RATES, st.floats(-2.0, 2.0))
def test_saturating_law_is_force_tanh(rate: float, force: float, bump: float, x: float) -> None:
    damper = law.saturating(rate, force, bump)
    slope = rate if x >= 0.0 else bump
    u = slope * x / force
    assert damper.force(x) == pytest.approx(force * math.tanh(u), rel=1e-14)
    sech = 1.0 / math.cosh(u) if abs(u) < 300.0 else 0.0
    assert damper.tangent(x) == pytest.approx(slope * sech * sech, rel=1e-12, abs=1e-200)


@pytest.mark.parametrize("force", [1e-105, 1e-300, 5e-324])
def test_a_force_far_too_small_for_its_rate_is_refused(force: float) -> None:
    """It was a division by zero: compiled for the least of them alone, uncompiled for all."""
    told = f"damper.saturation_force: .* a rate of 1961.33 cannot have a force of {force:g}: it must be"
    with pytest.raises(ParameterError, match=f"{told} at least 1e-100 times the rate"):
        Session("QuarterCar", {"damper.saturation_force": force})
    session = Session("QuarterCar", {"damper.saturation_force": 1e-90})
    session.set_parameter("damper.saturation_force", force)
    with pytest.raises(ParameterError, match=told):
        session.advance(0.1)


@pytest.mark.parametrize("side", ["rebound_rate", "bump_rate"])
def test_a_damper_that_saturates_needs_both_rates(side: str) -> None:
    """The message was about the force, and did not say which rate."""
    given = {"rear.damper.saturation_force": 500.0, f"rear.damper.{side}": 0.0}
    words = rf"^rear\.damper\.{side} = 0: must .* if rear\.damper\.saturation_force is given"
    with pytest.raises(ParameterError, match=words):
        build("HalfCar", given)


@pytest.mark.parametrize("x", [1e-9, 1e-4, 0.3, 1.0, 1.0001, 30.0, 1e4, 1e8, 1e300])
def test_work_of_a_saturating_law_keeps_its_digits(x: float) -> None:
    found = law.saturating(1.0, 1.0).potential(x)
    series = x * x / 2.0 - x**4 / 12.0 + x**6 / 45.0 if x < 1e-3 else None
    asymptote = x - math.log(2.0) if x > 20.0 else None
    exact = series or asymptote or quad(math.tanh, 0.0, x, epsabs=1e-14, epsrel=1e-14)[0]
    assert found == pytest.approx(exact, rel=1e-14)
    assert law.saturating(1.0, 1.0).potential(-x) == found


@given(RATES, FORCES, st.floats(-0.3, 0.3))
def test_laws_add_where_one_saturates(rate: float, force: float, x: float) -> None:
    one, other = law.saturating(rate, force), law.cubic(rate, 1e4) + law.bump_stop(0.1, 1e3)
    assert (one + other).force(x) == pytest.approx(one.force(x) + other.force(x), rel=1e-12)
    assert (one + one).force(x) == pytest.approx(2.0 * one.force(x), rel=1e-14)
    with pytest.raises(ValueError, match="two elements"):
        _ = one + law.saturating(2.0 * rate, force)


@given(
    st.one_of(
        st.builds(law.linear, RATES),
        st.builds(law.cubic, RATES, st.floats(0.0, 1e7)),
        st.builds(law.bump_stop, st.just(0.05), RATES).map(lambda stop: stop + law.linear(50.0)),
        st.just(law.monotone_table([(-0.1, -900.0), (0.0, 0.0), (0.02, 50.0), (0.1, 700.0)])),
        st.builds(law.saturating, RATES, st.just(1e5)),
    ),
    st.floats(-0.3, 0.3),
)
def test_argument_inverts_the_force(curve: law.Characteristic, x: float) -> None:
    force = curve.force(x)
    assert curve.force(curve.argument(force)) == pytest.approx(force, rel=1e-12, abs=1e-12)


SOFTENING = law.cubic(2e4, -2.7e6) + law.bump_stop(0.08, 5e5)  # falls again from 50 mm on


@pytest.mark.parametrize(
    ("curve", "x"),
    [
        (SOFTENING, -0.015),
        (SOFTENING, -0.045),
        (SOFTENING, -0.09),
        (law.table([(-0.3, -1000.0), (-0.1, -2000.0), (0.0, 0.0)]), -0.075),
    ],
)
def test_a_law_that_falls_again_has_a_force_where_it_rises(
    curve: law.Characteristic, x: float
) -> None:
    assert curve.argument(curve.force(x)) == pytest.approx(x, rel=1e-9)


def test_a_force_that_is_never_reached_has_no_argument() -> None:
    assert law.saturating(1e3, 500.0).argument(501.0) == math.inf
    assert law.bump_stop(0.1, 1e4).argument(1.0) == math.inf


def test_a_family_gives_its_curves_and_what_lies_between() -> None:
    deflections = {-0.05: law.linear(3e3), 0.0: law.damper(2e3, 500.0), 0.02: law.linear(1e3)}
    parts = damper_family("damper", (1.0,), deflections)
    assert [part.name for part in parts] == ["damper_1", "damper_2", "damper_3"]

    def force(rate: float, deflection: float) -> float:
        return sum(p.damper.force(rate) * p.modulation.force(deflection) for p in parts)

    for rate in (-0.7, 0.4):
        at = {d: curve.force(rate) for d, curve in deflections.items()}
        for d, wanted in at.items():
            assert force(rate, d) == pytest.approx(wanted)
        assert force(rate, 0.005) == pytest.approx(0.75 * at[0.0] + 0.25 * at[0.02])
        assert force(rate, -1.0) == pytest.approx(at[-0.05])


MASS, RATE = 300.0, 2e4


def test_a_modulated_damper_needs_no_iteration_where_its_factor_is_level() -> None:
    """Twice the damper by a level factor: the same motion as a damper of twice the rate, to rounding."""

    def car(damper: law.Characteristic, factor: law.Characteristic) -> System:
        strut = Element("strut", (1.0,), law.linear(RATE), damper, "road", modulation=factor)
        road = {"road": roads.bump(0.05, 1.0, 20.0)}
        return System(("body",), ((MASS,),), (strut,), road, scales=(0.05,))

    one = Integrator(car(law.linear(1e3), law.constant(2.0)), tolerance=1e-8)
    other = Integrator(car(law.linear(2e3), law.constant(1.0)), tolerance=1e-8)
    for integrator in (one, other):
        read_at(integrator, 1.0)
        integrator.sample_forces(1.0)
    assert one.step_count == other.step_count
    assert one.sample_q[0] == pytest.approx(other.sample_q[0], rel=1e-12)
    assert one.sample_f[0] == pytest.approx(other.sample_f[0], rel=1e-10)
