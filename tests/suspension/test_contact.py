"""Contact of tyre and road by both rules: what holds at every instant, and what kerbs do.

N = max(0, limit - S(d) - D(d')), and with `contact` = gap nothing where d is beyond the free length.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import Element, System
from stepped import read_at

BODY, WHEEL, GRAVITY = 300.0, 30.0, 9.80665
LOAD = (BODY + WHEEL) * GRAVITY
HARD = [(-0.05, -16e3), (-0.02, -4e3), (0.0, 0.0), (0.02, 2e3), (0.05, 4e3), (0.1, 6e3)]
TYRES = {
    "straight": law.linear(150e3),
    "table": law.table(HARD),
    "smooth": law.monotone_table(HARD),
    "cubic": law.cubic(100e3, 3e7),
}
LOSSES = {
    "plain": law.linear(1000.0),
    "none": law.linear(0.0),
    "blow-off": law.damper(4e3, 1e3, 300.0),
}


def car(road: roads.Signal, contact: str, tyre: str = "straight", loss: str = "plain") -> System:
    """A quarter car whose tyre may be of any kind, and leave the road."""
    return System(
        coordinates=("body", "wheel"),
        mass=((BODY, 0.0), (0.0, WHEEL)),
        elements=(
            Element("strut", (1.0, -1.0), law.linear(18e3), law.damper(2000.0, 700.0)),
            Element("tyre", (0.0, 1.0), TYRES[tyre], LOSSES[loss], "road", LOAD, contact=contact),
        ),
        signals={"road": road},
        scales=(0.05, 0.05),
    )


def rows(integrator: Integrator, instants: np.ndarray, road: roads.Signal) -> np.ndarray:
    """Deflection and rate of the tyre, and its contact force, at each instant."""
    found = []
    for t in instants:
        read_at(integrator, t)
        integrator.sample_forces(t)
        level, rate, *_ = road.derivatives(t)
        d, w = integrator.sample_q[1] - level, integrator.sample_v[1] - rate
        found.append((d, w, LOAD - integrator.sample_f[1]))
    return np.array(found)


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("tyre", TYRES)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-8])
def test_the_rule_holds_at_every_instant(
    tyre: str, loss: str, contact: str, tolerance: float
) -> None:
    """Rough road at speed: many flights, and the contact force is that of the rule, flying or not."""
    road = roads.random_profile("F", 30.0, 20.0, 3)
    integrator = Integrator(car(road, contact, tyre, loss), tolerance=tolerance)
    instants = np.linspace(0.0, 1.5, 3001)
    d, w, force = rows(integrator, instants, road).T
    spring, damper = TYRES[tyre], LOSSES[loss]
    free = car(road, contact, tyre, loss).elements[1].free_length
    pressed = np.array(
        [LOAD - spring.force(x) - damper.force(v) for x, v in zip(d, w, strict=True)]
    )
    expected = np.maximum(pressed, 0.0)
    if contact == "gap":
        expected[d > free] = 0.0
    switches = [t for t, e, kind, *_ in integrator.log if e == 1 and KINDS[kind] == "contact"]
    assert len(switches) >= 10
    assert (force >= 0.0).all()
    near = np.abs(instants[:, None] - np.array(switches)).min(axis=1) < 1e-9
    slack = 30.0 * tolerance * np.abs(pressed).max()
    # within an error of a switch either side may count
    unsure = (
        near | (np.abs(pressed) < slack) | (np.abs(d - free) < 10.0 * tolerance * np.abs(d).max())
    )
    assert unsure.mean() < 0.2
    np.testing.assert_allclose(force[~unsure], expected[~unsure], rtol=1e-9, atol=1e-6)
    if contact == "gap":
        assert (force[(d > free) & ~unsure] == 0.0).all()


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("tyre", TYRES)
def test_contact_switches_turn_by_turn_and_the_ledger_closes(tyre: str, contact: str) -> None:
    """No switch twice the same way, no two at one instant, and every joule is accounted for."""
    road = roads.random_profile("F", 30.0, 20.0, 4)
    integrator = Integrator(car(road, contact, tyre), tolerance=1e-9)
    assert integrator.advance(1.5) == 0
    switches = [(t, after) for t, e, kind, _, after in integrator.log if e == 1 and kind == 3]
    assert len(switches) >= 10
    assert all(b[0] > a[0] and b[1] != a[1] for a, b in pairwise(switches))
    kinetic, _stored, lost, brought_in = integrator.energies()
    turned_over = kinetic + sum(lost) + sum(map(abs, brought_in))
    assert abs(integrator.energy_residual()) < 1e-7 * turned_over


def launched(contact: str, road: roads.Signal, up: float = 0.03) -> Integrator:
    """The car in the air above a road, with nothing moving yet."""
    integrator = Integrator(car(road, contact), tolerance=1e-10)
    height = LOAD / 150e3 + up
    integrator.set_state([height, height], [0.0, 0.0])
    return integrator


@pytest.mark.parametrize("jump", [0.01, 0.02])
def test_a_kerb_under_a_flying_wheel_does_nothing_until_it_touches(jump: float) -> None:
    """By gap: the wheel falls as if there were no kerb, and meets it where its top is."""
    kerb = roads.step(jump, 0.01)
    with_kerb, without = launched("gap", kerb), launched("gap", roads.constant())
    for t in np.linspace(0.0, 0.012, 13):
        for integrator in (with_kerb, without):
            read_at(integrator, t)
        assert list(with_kerb.sample_q) == pytest.approx(list(without.sample_q), abs=1e-12)
        assert list(with_kerb.sample_v) == pytest.approx(list(without.sample_v), abs=1e-11)


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize(
    ("jump", "up"), [(0.02, -0.005), (0.05, 0.03), (0.02, 0.03), (-0.02, -0.01)]
)
def test_a_kerb_is_the_limit_of_ever_shorter_ramps(jump: float, up: float, contact: str) -> None:
    """In contact, through a gap, within a gap, and downwards."""
    ends = []
    for length in (0.0, 1e-5, 1e-6):
        road = (
            roads.table([(0.0, 0.0), (0.01, 0.0), (0.01 + length, jump)], 1.0)
            if length
            else roads.step(jump, 0.01)
        )
        integrator = launched(contact, road, up)
        read_at(integrator, 0.1, stop=True)
        ends.append(np.array(integrator.sample_q))
    kerb, long, short = ends
    peak = np.abs(kerb).max()
    assert np.abs(short - kerb).max() < 1e-4 * peak
    assert np.abs(long - kerb).max() < 1e-3 * peak


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_a_sampled_kerb_under_a_flying_wheel(contact: str) -> None:
    """A jump of the input road acts through the tyre's damper only where the tyre touches.

    By force it touches wherever the road comes up fast enough.
    """
    parameters = {"road.shape": "input", "contact": contact, "initial.wheel_displacement": 0.06,
                  "initial.body_displacement": 0.06}  # fmt: skip
    session = Session("QuarterCar", parameters)
    session.advance(0.001)
    before = session.value("wheel_velocity")
    session.set_input("road_elevation", 0.01)
    session.set_input("road_velocity", 10.0)
    session.advance(0.00100001)
    kicked = abs(session.value("wheel_velocity") - before) > 1e-3
    assert kicked == (contact == "force")
    assert (session.value("contact_force") > 0.0) == (contact == "force")


@pytest.mark.parametrize("rule", ["", "Gap", "both"])
def test_an_unknown_rule_is_refused(rule: str) -> None:
    with pytest.raises(ValueError, match=r"contact = .* gap, force"):
        Element("tyre", (1.0,), contact=rule)
    with pytest.raises(ValueError, match=r"contact = .* gap, force"):
        build("QuarterCar", {"contact": rule})


def test_without_a_free_length_there_is_no_gap() -> None:
    """A law that never bears the limit keeps contact by force."""
    slack = Element("rope", (1.0,), law.linear(0.0), law.linear(10.0), limit=5.0)
    assert slack.opening == np.inf
    assert Element("tyre", (1.0,), law.linear(10.0), limit=5.0).opening == 0.5
    assert Element("tyre", (1.0,), law.linear(10.0), limit=5.0, contact="force").opening == np.inf


PARAMETERS: dict[str, Any] = {"road.height": 0.1, "tyre.table": "-0.1:-3e4, 0:0, 0.1:1e4"}


@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("method", ["equilibrium", "mean", "tangent", "wilson"])
def test_plain_methods_follow_both_rules(method: str, contact: str) -> None:
    """Half the step, a fourth of the error, through lift-off and touchdown."""
    truth = Session("QuarterCar", {**PARAMETERS, "contact": contact, "solver.tolerance": 1e-11})
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        plain = Session(
            "QuarterCar",
            {**PARAMETERS, "contact": contact, "solver.method": method, "solver.step": step},
        )
        plain.advance(0.15)
        truth.advance(0.15)
        errors.append(
            abs(plain.value("wheel_displacement") - truth.value("wheel_displacement"))
            + abs(plain.value("body_displacement") - truth.value("body_displacement"))
        )
        assert plain.value("lift_off_count") == truth.value("lift_off_count") > 0
    assert errors[2] < 0.15 * errors[0] + 1e-9
