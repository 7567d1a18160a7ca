"""Springs that yield: H83 example 40 (= CP75), closed forms, the energy they take, their memory."""

from __future__ import annotations

from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.session import simulate
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import ParameterError
from stepped import at, mass_on, read_at

# CP75's loads, which reproduce what H83 says of its example 40: N at 0, 0.1, ..., 0.8 s
LOADS = [0.0, 5.0, 8.0, 7.0, 5.0, 3.0, 2.0, 1.0, 0.0]


def frame(
    yield_force: float = 6.0,
    hardening: float = 0.0,
    *,
    damping: float = 200.0,
    loads: list[float] = LOADS,
    permanent_set: float = 0.0,
) -> System:
    """H83 example 40: 100 kg, 200 N s/m, 5000 N/m, perfectly plastic from 6 N on."""
    spring = Element(
        "frame", (1.0,), characteristics.linear(5000.0), characteristics.linear(damping),
        yield_force=yield_force, hardening=hardening, permanent_set=permanent_set,
    )  # fmt: skip
    force = roads.table([(0.1 * k, f) for k, f in enumerate(loads)])
    return mass_on(spring, mass=100.0, force=force, scale=1e-3)


def millimetres(integrator: Integrator) -> list[float]:
    """Displacements at 0, 0.1, ..., 0.8 s."""
    return [1e3 * at(integrator, 0.1 * k)[0] for k in range(9)]


def by_hand(*, carried: bool = False, elastic: bool = False) -> list[float]:
    """H83's equations (1) to (5) of example 40, worked step by step; displacements in mm.

    The acceleration at the start of a step is carried on by (15.14), as H83's text says, or worked
    out anew from the equation of motion. The spring's tangent is held over the step, its force cut
    to 6 N at the end; it yields from the next step on, and unloads from the step after the velocity
    turns negative.
    """
    u = v = a = q = 0.0
    yields = False
    found = [u]
    for load, load_next in pairwise(LOADS):
        if not carried:
            a = (load - 200.0 * v - q) / 100.0
        k = 0.0 if yields else 5000.0
        du = (load_next - load + 6600.0 * v + 310.0 * a) / (k + 66_000.0)  # (1), (2), (5)
        dv = 30.0 * du - 3.0 * v - 0.05 * a  # (4)
        da = 600.0 * du - 60.0 * v - 3.0 * a  # (3)
        u, v, a, q = u + du, v + dv, a + da, q + k * du
        if not elastic:
            q = min(q, 6.0)
            yields = q == 6.0 and v > 0.0
        found.append(1e3 * u)
    return found


HAND = [0, 0.0704, 0.4936, 1.2563, 2.0016, 2.5205, 2.6874, 2.4763, 1.9676]
HAND_CARRIED = [*HAND[:4], 1.9884, 2.4708, 2.5823, 2.3053, 1.7458]
HAND_ELASTIC = [*HAND[:4], 1.9368, 2.1065, 1.6250, 0.7073, -0.2697]


def test_hand_calculation_of_example_40() -> None:
    found = millimetres(Integrator(frame(), "tangent", step=0.1, landing=False))
    assert found == pytest.approx(HAND, abs=5e-5)
    assert found == pytest.approx(by_hand(), abs=1e-14)  # digit by digit


def test_hand_calculation_with_the_spring_kept_elastic() -> None:
    found = millimetres(Integrator(frame(inf), "tangent", step=0.1, landing=False))
    assert found == pytest.approx(HAND_ELASTIC, abs=5e-5)
    assert found == pytest.approx(by_hand(elastic=True), abs=1e-14)


def test_hand_calculation_with_the_acceleration_carried_on() -> None:
    """The force cut off the spring at 0.3 s stays missing from the equation of motion: 0.28 N."""
    assert by_hand(carried=True) == pytest.approx(HAND_CARRIED, abs=5e-5)


@pytest.mark.parametrize("options", [{"tolerance": 1e-10}, {"method": "equilibrium", "step": 1e-4}])
def test_converged_solution_of_example_40(options: dict[str, object]) -> None:
    integrator = Integrator(frame(), **options)
    assert millimetres(integrator) == pytest.approx(
        [0, 0.0774, 0.5182, 1.2919, 2.0387, 2.5564, 2.7212, 2.5024, 1.9828], abs=5e-5
    )
    assert [round(event[0], 5) for event in integrator.log] == [0.28866, 0.59273]
    integrator.sample_forces(integrator.time)
    assert 1e3 * integrator.sample_set[0] == pytest.approx(1.5223, abs=5e-5)


@settings(max_examples=40)
@given(
    st.floats(0.5, 20.0), st.floats(0.0, 0.95), st.floats(0.0, 300.0),
    st.lists(st.floats(-30.0, 30.0), min_size=2, max_size=8),
)  # fmt: skip
def test_flow_only_takes_energy_and_the_ledger_closes(
    yield_force: float, hardening: float, damping: float, loads: list[float]
) -> None:
    system = frame(yield_force, 5000.0 * hardening, damping=damping, loads=[0.0, *loads, 0.0])
    integrator = Integrator(system, tolerance=1e-9)
    assert integrator.advance(2.0) == 0
    work = max(abs(f) for f in loads) * 0.1 + 1e-6
    assert abs(integrator.energy_residual()) < 1e-5 * work


def test_a_given_set_only_shifts_the_motion() -> None:
    plain, shifted = Integrator(frame()), Integrator(frame(permanent_set=0.01))
    shifted.set_state([0.01], [0.0])
    for t in np.linspace(0.05, 0.8, 16):
        plain.advance(t)
        shifted.advance(t)
        plain.sample(t)
        shifted.sample(t)
        assert shifted.sample_q[0] - 0.01 == pytest.approx(plain.sample_q[0], abs=2e-8)


def test_a_start_beyond_the_yield_limit_has_flowed_there() -> None:
    integrator = Integrator(frame(loads=[0.0]))
    integrator.set_state([0.01], [0.0])
    integrator.sample_forces(0.0)
    assert integrator.sample_set[0] == pytest.approx(0.01 - 6.0 / 5000.0)
    read_at(integrator, 5.0)
    assert integrator.sample_q[0] == pytest.approx(0.01 - 6.0 / 5000.0, abs=1e-4)


@pytest.mark.parametrize(
    ("given_", "complaint"),
    [
        ({"yield_force": 0.0}, "must be positive"),
        ({"yield_force": 1.0, "hardening": 5000.0}, "below the spring rate"),
        ({"yield_force": 1.0, "spring": characteristics.cubic(1.0, 1.0)}, "only a linear spring"),
        ({"yield_force": 1.0, "damper": characteristics.damper(1.0, 2.0)}, "linear damper"),
        ({"yield_force": 1.0, "limit": 5.0}, "no limit"),
    ],
)
def test_what_cannot_yield_is_refused(given_: dict[str, object], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Element("frame", (1.0,), **{"spring": characteristics.linear(5000.0), **given_})  # type: ignore[arg-type]


def test_a_start_beyond_the_yield_force_is_refused_and_any_set_may_be_started_from() -> None:
    with pytest.raises(ParameterError, match=r"must be from -0\.0012 to 0\.0012 m for"):
        simulate("Elastoplastic", {"initial.permanent_set": 0.01}, [0.0], ["displacement"])
    start = {"initial.permanent_set": 0.01, "initial.displacement": 0.01}
    found = simulate("Elastoplastic", start, [0.0, 0.1], ["displacement", "permanent_set"])
    plain = simulate("Elastoplastic", {}, [0.0, 0.1], ["displacement"])
    assert found["permanent_set"] == [0.01, 0.01]
    assert found["displacement"][1] - 0.01 == pytest.approx(plain["displacement"][1], rel=1e-9)


@pytest.mark.parametrize("displacement", [0.0, 0.004, -0.02])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_start_between_the_lines_of_flow_is_allowed_up_to_them(
    displacement: float, sign: float
) -> None:
    """The spring force k (u - s) lies between -+ F (1 - h/k) + h u."""
    rate, limit, slope = 5000.0, 6.0, 500.0
    most = limit * (1.0 - slope / rate)
    edge = displacement - (slope * displacement + sign * most) / rate
    for inside in (True, False):
        start = {
            "hardening": slope,
            "initial.displacement": displacement,
            "initial.permanent_set": edge + sign * (1e-6 if inside else -1e-6),
        }
        if inside:
            found = simulate("Elastoplastic", start, [0.0], ["permanent_set", "spring_force"])
            assert found["permanent_set"] == [start["initial.permanent_set"]]
            assert found["spring_force"][0] * sign < most + sign * slope * displacement
        else:
            with pytest.raises(ParameterError, match=r"initial\.permanent_set = .*give both"):
                simulate("Elastoplastic", start, [0.0], ["displacement"])


def test_a_frame_that_yields_at_almost_nothing_moves_as_a_mass_under_its_load() -> None:
    """No damping: m u'' = f(t), whose double integral is known."""
    soft = {"yield_force": 1e-9, "damper.rate": 0.0, "force.table": "0:8, 1:8"}
    (_, moved) = simulate("Elastoplastic", soft, [0.0, 0.5], ["displacement"])["displacement"]
    assert moved == pytest.approx(8.0 / 100.0 * 0.5**2 / 2.0, rel=1e-6)
