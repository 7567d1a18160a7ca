"""A run that ends early says why, with the numbers of what it ended on, and what to try."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from phaseplane.suspension import characteristics
from phaseplane.suspension.engine import FAILURES, Integrator
from phaseplane.suspension.kernel import outcomes
from phaseplane.suspension.models import build
from phaseplane.suspension.reasons import _DETAILS, remedy_of, why_stopped
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.systems import Element, System
from stepped import mass_on


def stopped(system: System, until: float, start: tuple[Any, Any] = ((), ()), **options: Any) -> str:
    """The sentence with which a run of a system ends."""
    integrator = Integrator(system, **options)
    if start[0]:
        integrator.set_state(*start)
    status = integrator.advance(until)
    assert status != 0
    return why_stopped(status, f"at {integrator.time:.3g} s", integrator, system)


def test_an_unstable_step_names_the_fastest_mode_and_its_limit() -> None:
    """Quarter car by default: the wheel hops on tyre and spring."""
    system = build("QuarterCar", {})
    said = stopped(system, 1.0, method="equilibrium", step=0.08, beyond_stable="refuse")
    found = re.search(
        r"its limit is (\S+) s for the fastest mode, (\S+) rad/s, which moves (\w+)", said
    )
    assert found
    limit, omega = float(found[1]), float(found[2])
    assert limit == pytest.approx(12.0**0.5 / omega, rel=1e-2)
    tangent = Integrator(system).tangents()[0]
    wheel = system.coordinates.index(found[3])
    assert "wheel" in found[3]
    # that of the wheel alone, but for the body that gives way
    assert omega == pytest.approx(
        (tangent[wheel][wheel] / system.mass[wheel][wheel]) ** 0.5, rel=0.02
    )
    assert said.endswith("shorten it, or set it to 0")


def falling(stiffness: float) -> System:
    """A mass that a spring of negative stiffness drives away."""
    driving = Element("driving", (1.0,), characteristics.linear(stiffness))
    return replace(mass_on(driving, scale=0.01), coordinates=("heave",))


def test_a_motion_that_diverges_is_named_with_its_size() -> None:
    said = stopped(falling(-100.0), 10.0, ([0.1], [0.0]), energy=False)
    found = re.search(
        r"diverged at (\S+) s \(heave is at (\S+) m; the last step was (\S+) s\)", said
    )
    assert found
    assert abs(float(found[2])) > 1e6
    assert 0.0 < float(found[3]) < 1.0


def test_a_matrix_without_inverse_is_named_with_its_stiffness_and_step() -> None:
    said = stopped(falling(-1e4), 1.0, ([0.1], [0.0]), method="equilibrium", step=0.1,
                   beyond_stable="allow", energy=False)  # fmt: skip
    assert "(a step of 0.1 s; the least stiffness is -1e+04 N/m, that of heave)" in said


@pytest.mark.parametrize(
    ("model", "step", "moved"),
    [("QuarterCar", 0.08, r"wheel\S*"), ("Elastoplastic", 1.0, "the mass")],
)
def test_a_session_says_it_too(model: str, step: float, moved: str) -> None:
    fixed = {"solver.step": step, "solver.beyond_stable": "refuse"}
    session = Session(model, fixed)
    with pytest.raises(SimulationError, match=rf"which moves {moved} most\); shorten it"):
        session.advance(10.0)


def test_a_session_names_the_switches_between_which_no_time_passes() -> None:
    """It also takes them off the integrator's log, which it must not do first."""
    session = Session("QuarterCar", {"road.height": 0.08})

    class Stalling:
        def __init__(self, integrator: Integrator) -> None:
            self.integrator = integrator

        def __getattr__(self, name: str) -> Any:
            return getattr(self.integrator, name)

        def advance(self, until: float, stop: bool) -> int:
            assert self.integrator.advance(until, stop) == 0
            return outcomes.NO_TIME_PASSES

    session._integrator = Stalling(session._integrator)  # type: ignore[assignment]
    session._notices = SimpleNamespace(new=lambda *_: [])  # type: ignore[assignment]
    with pytest.raises(SimulationError, match=r"the last are those of the .*contact of tyre"):
        session.advance(1.0)


@pytest.mark.parametrize("status", sorted(_DETAILS))
def test_every_reason_has_numbers_or_names_of_a_run(status: int) -> None:
    """After any run; that it is the reason given has its own tests."""
    system = build("QuarterCar", {"road.height": 0.08, "spring.cubic": 1e6})
    integrator = Integrator(system)
    assert integrator.advance(1.0) == 0
    said = why_stopped(status, "at 1 s", integrator, system)
    assert said.startswith(f"{FAILURES[status]} at 1 s (")
    assert said.endswith(f"); {remedy_of(status, fixed=False)}")
    inside = said[len(FAILURES[status]) :]
    assert re.search(r"\d (m|s|J|rad/s|1/s|N/m)\b", inside) or "of tyre" in inside


@pytest.mark.parametrize("status", sorted(FAILURES))
def test_what_to_try_fits_the_steps(status: int) -> None:
    """Steps of a fixed length ignore the tolerance; chosen ones have no length to shorten."""
    fixed, chosen = (remedy_of(status, fixed=steps) for steps in (True, False))
    assert "tolerance" not in fixed
    assert status == outcomes.UNSTABLE or "step" not in chosen
    assert ("tolerance" in chosen) <= ("solver.step" in fixed)


def test_a_run_with_fixed_steps_says_so() -> None:
    given = {"spring.cubic": -1e9, "road.height": 0.2, "solver.step": 1e-3}
    with pytest.raises(SimulationError, match=r"; shorten solver\.step, or look"):
        Session("QuarterCar", given).advance(1.0)


def test_without_a_run_the_sentence_has_no_numbers() -> None:
    said = f"{FAILURES[2]} at 1 s; {remedy_of(2, fixed=False)}"
    assert why_stopped(2, "at 1 s") == said
