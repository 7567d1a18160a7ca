"""Stability watched: steps that are too long, energy from nowhere, interrupts, what takes for ever."""

from __future__ import annotations

import sys
from array import array
from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from hosting import in_python
from phaseplane.suspension import characteristics, engine, roads
from phaseplane.suspension.engine import FAILURES, Filling, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import ParameterError, checked_parameters
from stepped import at, mass_on, read_at, started


def car(**parameters: object) -> System:
    named = {name.replace("__", "."): value for name, value in parameters.items()}
    return build("QuarterCar", checked_parameters("QuarterCar", named))


def oscillator(phase: float) -> System:
    return mass_on(Element("spring", (1.0,), characteristics.linear(phase**2)), scale=1.0)


def drawn(rng: np.random.Generator) -> System:
    """A car with blow-off and stops on a bump, everything acting."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    return car(
        sprung_mass=between(150.0, 600.0), unsprung_mass=between(15.0, 60.0),
        spring__rate=between(8e3, 4e4), tyre__stiffness=between(1e5, 3e5),
        tyre__damping=between(10.0, 500.0), damper__rebound_rate=between(200.0, 4e3),
        damper__bump_rate=between(100.0, 2e3), damper__rebound_limit=between(100.0, 1e3),
        damper__limit_slope=between(10.0, 200.0), bump_stop__gap=between(0.005, 0.05),
        bump_stop__stiffness=between(1e4, 1e6), rebound_stop__gap=between(0.005, 0.05),
        rebound_stop__stiffness=between(1e4, 1e6), road__height=between(0.02, 0.2),
        road__length=between(0.3, 3.0), speed=between(3.0, 40.0),
    )  # fmt: skip


def test_a_step_beyond_the_stable_one_is_taken_in_equal_parts() -> None:
    integrator = started(oscillator(1.0), 1.0, method="equilibrium", step=10.0)
    assert integrator.advance(100.0) == 0
    assert integrator.step_count == 30  # 10 s in parts below 2 sqrt 3
    since, stable = integrator.beyond_stable()
    assert since == 0.0
    assert stable == pytest.approx(2.0 * sqrt(3.0), rel=1e-3)
    # the same motion as with the parts given
    other = started(oscillator(1.0), 1.0, method="equilibrium", step=10.0 / 3.0)
    assert at(integrator, 100.0)[0] == pytest.approx(at(other, 100.0)[0], rel=1e-9)
    assert other.beyond_stable() is None


@pytest.mark.parametrize(
    ("options", "limit"),
    [({"method": "equilibrium"}, 2 * sqrt(3)), ({"order": 4}, 2.2), ({"order": 8}, 3.2)],
)
def test_each_method_has_its_limit(options: dict[str, object], limit: float) -> None:
    for factor, status in ((0.99, 0), (1.01, 6)):
        integrator = Integrator(
            oscillator(1.0), step=factor * limit, beyond_stable="refuse", **options
        )
        assert integrator.advance(50.0) == status
    assert "largest stable step" in FAILURES[6]


@pytest.mark.parametrize("method", ["wilson", "exact"])
def test_methods_without_a_limit_take_any_step(method: str) -> None:
    integrator = Integrator(oscillator(1.0), method, step=10.0, beyond_stable="refuse")
    assert integrator.advance(50.0) == 0
    assert integrator.step_count == 5


def test_an_unknown_policy_is_refused() -> None:
    with pytest.raises(ValueError, match="'halve' is not one of substep, refuse, allow"):
        Integrator(oscillator(1.0), beyond_stable="halve")


def test_energy_from_nowhere_ends_a_run() -> None:
    options = {"method": "equilibrium", "step": 3.6, "beyond_stable": "allow"}
    integrator = started(oscillator(1.0), 1.0, **options)
    assert integrator.advance(1e4) == 7
    assert integrator.time < 500.0
    assert "energy" in FAILURES[7]


@pytest.mark.parametrize(
    "options",
    [
        {"tolerance": 1e-1}, {"tolerance": 1e-4}, {"step": 3e-2}, {"step": 5e-2, "order": 4},
        {"method": "equilibrium", "step": 5e-3}, {"method": "tangent", "step": 1e-2},
        {"method": "mean", "step": 5e-3}, {"method": "wilson", "step": 5e-3}, {"method": "exact"},
    ],
)  # fmt: skip
def test_right_runs_of_drawn_cars_never_end_for_their_energy(options: dict[str, object]) -> None:
    rng = np.random.default_rng(5)
    for _ in range(40):
        integrator = Integrator(drawn(rng), **options)
        assert integrator.advance(2.0) == 0


def test_a_sampled_road_that_jumps_is_no_energy_from_nowhere() -> None:
    session = Session("QuarterCar", {"road.shape": "input"})
    for k in range(1, 300):
        session.set_input("road_elevation", 0.05 * (k // 20 % 2))
        session.set_input("road_velocity", 1e-9)  # so that it counts as given
        session.advance(0.01 * k)
    assert session.ok
    assert abs(session.value("energy_residual")) < 1e-2


def test_a_session_says_once_that_its_step_is_too_long() -> None:
    given = {"solver.method": "equilibrium", "solver.step": 0.2}
    session = Session("QuarterCar", given)
    for k in range(1, 11):
        session.advance(0.1 * k)
    said = [text for _, text in session.messages if "not stable" in text]
    assert said == [
        "solver.step = 0.2 s is not stable from 0 s on: it is divided into parts of at most 0.0467 s"
    ]
    refusing = Session("QuarterCar", {**given, "solver.beyond_stable": "refuse"})
    with pytest.raises(SimulationError, match="longer than the largest stable step at 0 s"):
        refusing.advance(0.1)


def test_a_session_says_why_exact_is_refused() -> None:
    with pytest.raises(
        ParameterError,
        match=r"'exact' cannot integrate this system: the spring .*; use 'extrapolated'",
    ):
        Session("QuarterCar", {"solver.method": "exact", "spring.cubic": 1e5})


@pytest.mark.skipif(sys.platform == "win32", reason="not on this platform: no interval timer")
@pytest.mark.skipif(not engine.compiled, reason="uncompiled code is interrupted by Python itself")
def test_an_interrupt_ends_one_long_call() -> None:
    code = """
import signal
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
signal.signal(signal.SIGPROF, signal.default_int_handler)
integrator = Integrator(build("QuarterCar", {}), "equilibrium", step=1e-6)
try:
    signal.setitimer(signal.ITIMER_PROF, 0.3)  # of its own work, however busy the machine is
    integrator.advance(25.0)  # 25 million steps
except KeyboardInterrupt:
    print("interrupted", integrator.time > 0)
"""
    assert in_python(code).split() == ["interrupted", "True"]


def test_a_session_keeps_a_log_of_its_events_and_its_whole_state() -> None:
    session, other = (Session("QuarterCar", {"bump_stop.gap": 0.02, "bump_stop.stiffness": 3e5})
                      for _ in range(2))  # fmt: skip
    session.advance(0.03)
    kept = session.snapshot()
    session.advance(0.5)
    contact = [e for e in session.events if (e.element, e.kind) == ("tyre", "contact")]
    assert (contact[0].before, contact[0].after) == (0, 1)
    assert contact[0].time == session.value("last_lift_off") or len(contact) > 2
    assert [e.time for e in session.events] == sorted(e.time for e in session.events)
    ahead, events = session.snapshot(), list(session.events)
    session.restore(kept)  # back to the bit, events with it, and forward again
    assert session.snapshot() == kept
    assert len(session.events) < len(events)
    session.advance(0.5)
    assert session.snapshot() == ahead
    assert list(session.events) == events
    other.advance(0.03)
    assert other.snapshot() == kept  # two sessions compare by what they are
    other.advance(0.04)
    assert other.snapshot() != kept


def test_a_wheel_of_a_gram_does_not_lift_off_where_a_heavy_one_stays() -> None:
    """Over a low swell nothing leaves the road; a light wheel least of all."""
    swell = {"road__shape": "sine", "road__height": 0.01, "road__length": 5.0, "speed": 10.0}
    for mass in (30.0, 1.0, 1e-3):
        system = car(**swell, unsprung_mass=mass)
        integrator = Integrator(system)
        assert integrator.advance(2.0) == 0
        tyre = system.element("tyre")
        assert [entry for entry in integrator.log if entry[1] == tyre] == []


def still_beside_a_slow_one(ratio: float, omega: float = 100.0) -> System:
    """Two masses that do not feel each other: one swings at 1 rad/s, the other could at omega."""
    slow = Element("slow", (1.0, 0.0), characteristics.linear(1.0))
    rate = characteristics.linear(2.0 * ratio * omega)
    fast = Element("fast", (0.0, 1.0), characteristics.linear(omega**2), rate)
    return System(("x", "y"), ((1.0, 0.0), (0.0, 1.0)), (slow, fast), scales=(1.0, 1.0))


@pytest.mark.parametrize(
    ("options", "ratio", "phase"),
    [
        ({"tolerance": 1e-3}, 0.0, 2.4),
        ({"tolerance": 1e-3}, 0.042, 2.4),
        ({"tolerance": 1e-3}, 0.044, 6.0),
        ({"tolerance": 1e-7}, 0.020, 2.4),
        ({"tolerance": 1e-7}, 0.021, 6.0),
        ({"tolerance": 1e-3, "order": 4}, 0.100, 2.4),
        ({"tolerance": 1e-3, "order": 4}, 0.102, 6.0),
        ({"tolerance": 1e-3}, 0.117, 6.0),
        ({"tolerance": 1e-3}, 0.119, 8.4),
        ({"tolerance": 1e-7}, 0.055, 6.0),
        ({"tolerance": 1e-7}, 0.056, 8.4),
        ({"tolerance": 1e-3, "order": 4}, 0.277, 6.0),
        ({"tolerance": 1e-3, "order": 4}, 0.279, 8.4),
        ({"tolerance": 1e-3}, 50.0, 8.4),
    ],
)
def test_steps_chosen_by_the_error_are_as_long_as_damping_allows(
    options: dict[str, float], ratio: float, phase: float
) -> None:
    """A fast mode at rest has no error to show, and must not grow from rounding."""
    integrator = Integrator(still_beside_a_slow_one(ratio), **options)
    integrator.set_state([1.0, 1e-12], [0.0, 0.0])
    longest = 0.0
    while integrator.time < 20.0:
        before = integrator.time
        assert integrator.advance(before + 1e-9) == 0
        longest = max(longest, integrator.time - before)
    assert 100.0 * longest == pytest.approx(phase, rel=1e-6)
    integrator.sample(integrator.time)
    assert abs(integrator.sample_q[1]) < 1e-11
    assert integrator.sample_q[0] == pytest.approx(
        np.cos(integrator.time), abs=options["tolerance"]
    )


def test_a_million_fixed_steps_keep_an_undamped_amplitude() -> None:
    steps = 1_000_000 if engine.compiled else 20_000
    integrator = started(oscillator(1.0), 1.0, method="equilibrium", step=0.5)
    assert integrator.advance(0.5 * steps) == 0
    integrator.sample(integrator.time)
    energy = integrator.sample_q[0] ** 2 + integrator.sample_v[0] ** 2
    # the method keeps a quadratic form close to the energy, which its amplitude shows
    assert 0.9 < energy < 1.1


@pytest.mark.slow
def test_what_would_take_for_ever_is_refused_soon() -> None:
    """A motion a million times faster than the run is long."""
    parameters = {"unsprung_mass": 1e-12}
    integrator = Integrator(car(**parameters))
    status = integrator.advance(0.5)
    assert FAILURES[status].startswith("the run needs more than 30 million steps")
    assert integrator.step_count < 250_000
    again = Integrator(car(**parameters), energy=False)
    filling = Filling(again, array("d", [0.0, 0.5]), array("d", bytes(2 * 8 * 2)))
    assert filling.fill() == status
    assert filling.filled == 1


@pytest.mark.slow
def test_a_body_of_a_milligram_on_a_damper_is_stepped_right() -> None:
    """It clings to the corner of the damper, which it passes thousands of times."""
    found, truth = (
        read_at(Integrator(car(sprung_mass=1e-6), method), 0.5)[0]
        for method in ("extrapolated", "exact")
    )
    assert found == pytest.approx(truth, rel=1e-6)


def test_a_road_without_a_finite_energy_ends_the_run_in_words() -> None:
    """Branches were left beyond the last piece of a law, and the process with them."""
    system = car(**{"road.shape": "bump"})
    road = roads.table([(0.0, 0.0), (1.0, 1e300)], 20.0)
    integrator = Integrator(replace(system, signals={**system.signals, "road": road}))
    assert integrator.advance(0.05) in FAILURES


@pytest.mark.parametrize(
    ("model", "name"),
    [
        ("QuarterCar", "initial.wheel_displacement"),
        ("HalfCar", "initial.rear_body_velocity"),
        ("Elastoplastic", "initial.displacement"),
        ("OneDof", "road.height"),
        ("Road", "road.height"),
    ],
)
@pytest.mark.parametrize("value", [1e200, -1e300])
def test_starts_and_roads_as_far_away_as_numbers_reach_are_refused(
    model: str, name: str, value: float
) -> None:
    with pytest.raises(ParameterError, match=rf"{name} = .*at most 1e\+09 m"):
        Session(model, {name: value})
