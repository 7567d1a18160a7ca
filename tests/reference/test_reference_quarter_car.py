"""The references themselves: against each other, the paper's equations and its numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import vehicle_reference
from quarter_car_reference import (
    DEFAULTS,
    KGF,
    Reference,
    largest_difference,
    solve,
    solved,
)

STOPS: dict[str, Any] = {
    "bump_stop.gap": 0.02,
    "bump_stop.stiffness": 2e5,
    "rebound_stop.gap": 0.002,
    "rebound_stop.stiffness": 5e4,
    "damper.rebound_limit": 400.0,
    "damper.bump_limit": 300.0,
    "damper.limit_slope": 80.0,
}


def bump_of_the_paper(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Elevation and velocity of AP57 section 8, cm and cm/s."""
    on = (t >= 0.0) & (t <= 0.05)
    turn = 40.0 * np.pi
    return (
        np.where(on, 2.5 * (1.0 - np.cos(turn * t)), 0.0),
        np.where(on, 2.5 * turn * np.sin(turn * t), 0.0),
    )


def tyre_bracket_of_the_paper(solution: Reference) -> np.ndarray:
    """c2 (x2 - xi) + k2 (x2' - xi') of AP57 section 8, kgf."""
    elevation, velocity = bump_of_the_paper(solution.times)
    return 150.0 * (1e2 * solution.wheel_displacement - elevation) + 1.0 * (
        1e2 * solution.wheel_velocity - velocity
    )


def airborne(solution: Reference) -> np.ndarray:
    """Whether an instant lies between a lift-off and the next touchdown."""
    lift_offs, touchdowns = (solution.instants("tyre", to) for to in ("flight", "contact"))
    return (np.searchsorted(lift_offs, solution.times, side="right")) > (
        np.searchsorted(touchdowns, solution.times, side="right")
    )


@pytest.mark.parametrize("may_leave", [True, False])
def test_the_equations_of_the_paper_hold_in_its_own_units(may_leave: bool) -> None:
    """AP57 eqs. 14 and 29 with the numbers of section 8, kgf, cm and s."""
    run = solve({"lift_off": may_leave}, np.linspace(0.0, 0.5, 501))
    y = 1e2 * (run.body_displacement - run.wheel_displacement)
    rate = 1e2 * (run.body_velocity - run.wheel_velocity)
    coupling = 15.0 * y + np.where(rate > 0.0, 2.0 * rate, 0.5 * rate)
    weight = 0.33 * 980.665
    tyre = np.where(airborne(run), weight, tyre_bracket_of_the_paper(run))
    assert airborne(run).any() == may_leave
    body = 0.3 * 1e2 * run.body_acceleration + coupling
    wheel = 0.03 * 1e2 * run.wheel_acceleration - coupling + tyre
    assert abs(body).max() < 1e-11 * abs(coupling).max()
    assert abs(wheel).max() < 1e-11 * abs(tyre).max()
    np.testing.assert_allclose(run.contact_force, KGF * (weight - tyre), rtol=0.0, atol=1e-9)


def test_the_worked_example_has_its_known_numbers() -> None:
    held = solve({"lift_off": False}, np.linspace(0.0, 0.1, 2001))
    static_deflection = held.contact_force[0] / (15000.0 * KGF)
    assert static_deflection == pytest.approx(0.02157, abs=5e-6)
    # the wheel would leave the road: the bracket exceeds c2 x2st
    assert tyre_bracket_of_the_paper(held).max() / 150.0 == pytest.approx(4.82, abs=5e-3)
    assert held.contact_force.min() < 0.0

    force = {"contact": "force"}
    events = solve(force, [0.2])
    (lift_off,), (touchdown,) = (
        events.instants("tyre", "flight"),
        events.instants("tyre", "contact"),
    )
    assert touchdown == pytest.approx(0.0656, abs=5e-5)
    at = solve(force, [lift_off, touchdown])
    elevation = bump_of_the_paper(at.times)[0] * 1e-2
    from_free_length = at.wheel_displacement - elevation - static_deflection
    energies = 0.5 * 15000.0 * KGF * from_free_length**2
    np.testing.assert_allclose(energies, [48.2, 6.5], atol=0.05)
    # the wheel passes x2st, where AP57's shortcut sees the touchdown, only later
    around = solve(force, [0.07215, 0.0722]).wheel_displacement - static_deflection
    assert around[0] > 0.0 > around[1]

    # by gap: the same lift-off, and contact where the road, level by then, is touched
    by_gap = solve({}, [0.2])
    assert by_gap.instants("tyre", "flight") == [lift_off]
    (touchdown,) = by_gap.instants("tyre", "contact")
    assert touchdown == pytest.approx(0.0719526, abs=5e-8)
    around = solve({}, [touchdown - 1e-9, touchdown + 1e-9])
    assert around.contact_force[0] == 0.0
    assert around.contact_force[1] == pytest.approx(
        -100.0 * KGF * around.wheel_velocity[1], rel=1e-5
    )


def test_blow_off_case_switches_seventeen_times() -> None:
    run = solved("ap57_blow_off")
    elements = [event.element for event in run.events]
    assert {name: elements.count(name) for name in elements} == {"damper": 14, "tyre": 2, "road": 1}


@pytest.mark.parametrize(
    ("car", "wrong"),
    [
        *(
            ({}, {name: 1.001 * float(DEFAULTS[name])})
            for name in (
                "sprung_mass", "unsprung_mass", "spring.rate", "damper.rebound_rate",
                "damper.bump_rate", "tyre.stiffness", "tyre.damping", "gravity", "road.height",
                "road.length", "speed",
            )
        ),
        *(
            (STOPS, {name: 1.001 * STOPS[name]})
            for name in STOPS
        ),
        ({}, {"road.start": 1e-5}),
        ({}, {"road.shape": "obstacle"}),
        ({}, {"lift_off": False}),
    ],
    ids=str,
)  # fmt: skip
def test_a_wrong_parameter_shows(car: dict[str, Any], wrong: dict[str, Any]) -> None:
    """A comparison at 1e-6 of the peak notices a parameter that is wrong by a thousandth."""
    times = np.linspace(0.0, 0.2, 41)
    assert largest_difference(solve(car, times), solve({**car, **wrong}, times)) > 3e-6


def test_blow_off_by_limits_and_by_table_are_one_law() -> None:
    limits = {
        "damper.rebound_limit": 60.0 * KGF,
        "damper.bump_limit": 30.0 * KGF,
        "damper.limit_slope": 20.0 * KGF,
    }
    table = ", ".join(
        f"{rate}:{force}"
        for rate, force in (
            (-1.6, -50.0 * KGF), (-0.6, -30.0 * KGF), (0, 0), (0.3, 60.0 * KGF), (1.3, 80.0 * KGF),
        )
    )  # fmt: skip
    times = np.linspace(0.0, 0.5, 101)
    assert largest_difference(solve(limits, times), solve({"damper.table": table}, times)) < 1e-12


@pytest.mark.parametrize("tyre_damping", [0.0, 980.665])
@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("shape", ["bump", "obstacle", "sine"])
def test_the_reference_of_all_vehicles_agrees(
    shape: str, contact: str, tyre_damping: float
) -> None:
    """DOP853 with switches of its own against matrix exponentials, everything acting."""
    parameters = {
        **DEFAULTS, "damper.rebound_limit": 588.399, "damper.bump_limit": 294.1995,
        "damper.limit_slope": 200.0, "bump_stop.gap": 0.02, "bump_stop.stiffness": 3e5,
        "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 3e5, "road.shape": shape,
        "road.length": 3.0 if shape == "sine" else 1.0, "contact": contact,
        "tyre.damping": tyre_damping,
    }  # fmt: skip
    times = np.linspace(0.0, 0.12, 7)
    exact = solve(parameters, times)
    other = vehicle_reference.solve("QuarterCar", parameters, times)
    expected = np.column_stack([exact.body_displacement, exact.wheel_displacement])
    assert np.abs(other.displacements - expected).max() < 1e-12 * exact.peak
    ours = [(s.time, s.element) for s in other.switches if s.time > 0.0]
    theirs = [(e.time, e.element) for e in exact.events if e.element != "road"]
    assert len(ours) > 3
    assert [what for _, what in ours] == [what for _, what in theirs]
    assert [t for t, _ in ours] == pytest.approx([t for t, _ in theirs], abs=1e-11)
