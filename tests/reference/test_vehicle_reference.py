"""The reference of the vehicles itself: against the campaign's, the paper's equations and its numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import truth
from phaseplane.suspension.models import build
from vehicle_reference import AP57, KGF, Solution, quarter_car, solved

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


def tyre_bracket_of_the_paper(solution: Solution) -> np.ndarray:
    """c2 (x2 - xi) + k2 (x2' - xi') of AP57 section 8, kgf."""
    elevation, velocity = bump_of_the_paper(solution.times)
    return 150.0 * (1e2 * solution.displacements[:, 1] - elevation) + 1.0 * (
        1e2 * solution.velocities[:, 1] - velocity
    )


def contact_force(solution: Solution) -> np.ndarray:
    """The force of the road on the tyre, N."""
    return KGF * (33.0 * 9.80665 + solution.accelerations @ [30.0, 3.0])


def airborne(solution: Solution) -> np.ndarray:
    """Whether an instant lies between a lift-off and the next touchdown."""
    lift_offs, touchdowns = (solution.instants("tyre", to) for to in ("lift-off", "touchdown"))
    return (np.searchsorted(lift_offs, solution.times, side="right")) > (
        np.searchsorted(touchdowns, solution.times, side="right")
    )


@pytest.mark.slow
@pytest.mark.parametrize("may_leave", [True, False])
def test_the_equations_of_the_paper_hold_in_its_own_units(may_leave: bool) -> None:
    """AP57 eqs. 14 and 29 with the numbers of section 8, kgf, cm and s."""
    run = quarter_car({"lift_off": may_leave}, np.linspace(0.0, 0.5, 501))
    y = 1e2 * (run.displacements @ [1.0, -1.0])
    rate = 1e2 * (run.velocities @ [1.0, -1.0])
    coupling = 15.0 * y + np.where(rate > 0.0, 2.0 * rate, 0.5 * rate)
    weight = 0.33 * 980.665
    tyre = np.where(airborne(run), weight, tyre_bracket_of_the_paper(run))
    assert airborne(run).any() == may_leave
    body = 0.3 * 1e2 * run.accelerations[:, 0] + coupling
    wheel = 0.03 * 1e2 * run.accelerations[:, 1] - coupling + tyre
    assert abs(body).max() < 1e-11 * abs(coupling).max()
    assert abs(wheel).max() < 1e-11 * abs(tyre).max()


def test_the_worked_example_has_its_known_numbers() -> None:
    held = quarter_car({"lift_off": False}, np.linspace(0.0, 0.1, 2001))
    static_deflection = contact_force(held)[0] / (15000.0 * KGF)
    assert static_deflection == pytest.approx(0.02157, abs=5e-6)
    # the wheel would leave the road: the bracket exceeds c2 x2st
    assert tyre_bracket_of_the_paper(held).max() / 150.0 == pytest.approx(4.82, abs=5e-3)
    assert contact_force(held).min() < 0.0

    force = {"contact": "force"}
    run = quarter_car(force, [0.0, 0.2])
    (lift_off,), (touchdown,) = (run.instants("tyre", to) for to in ("lift-off", "touchdown"))
    assert touchdown == pytest.approx(0.0656, abs=5e-5)
    # the wheel passes x2st, where AP57's shortcut sees the touchdown, only later
    at = quarter_car(force, [0.0, lift_off, touchdown, 0.07215, 0.0722, 0.08])
    wheel = at.displacements[1:5, 1] - 1e-2 * bump_of_the_paper(at.times[1:5])[0]
    from_free_length = wheel - static_deflection
    energies = 0.5 * 15000.0 * KGF * from_free_length[:2] ** 2
    np.testing.assert_allclose(energies, [48.2, 6.5], atol=0.05)
    assert from_free_length[2] > 0.0 > from_free_length[3]
    # until then the damper of a tyre that does not touch the road pushes the wheel
    apart = quarter_car(force, np.linspace(0.0, 0.08, 8001))
    gap = apart.displacements[:, 1] - 1e-2 * bump_of_the_paper(apart.times)[0] - static_deflection
    assert contact_force(apart)[gap > 0.0].max() == pytest.approx(1374.0, abs=1.0)
    assert gap[~airborne(apart)].max() == pytest.approx(9.4e-3, abs=5e-5)

    # by gap: the same lift-off, and contact where the road, level by then, is touched
    by_gap = quarter_car({}, [0.0, 0.2])
    assert by_gap.instants("tyre", "lift-off") == pytest.approx([lift_off], abs=1e-12)
    (touchdown,) = by_gap.instants("tyre", "touchdown")
    assert touchdown == pytest.approx(0.0719526, abs=5e-8)
    around = quarter_car({}, [0.0, touchdown - 1e-9, touchdown + 1e-9, 0.08])
    before, after = contact_force(around)[1:3]
    assert before == pytest.approx(0.0, abs=1e-9)
    assert after == pytest.approx(-100.0 * KGF * around.velocities[2, 1], rel=1e-5)


@pytest.mark.slow
def test_blow_off_case_switches_sixteen_times() -> None:
    elements = [switch.element for switch in solved("ap57_blow_off").switches if switch.time]
    assert {name: elements.count(name) for name in elements} == {"damper": 14, "tyre": 2}


def largest_difference(one: Solution, other: Solution) -> float:
    """Largest difference of the displacements, relative to the peak."""
    return float(np.abs(one.displacements - other.displacements).max()) / one.peak


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("car", "wrong"),
    [
        *(
            ({}, {name: 1.001 * AP57[name]})
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
    times = np.linspace(0.0, 0.1, 21)
    assert largest_difference(quarter_car(car, times), quarter_car({**car, **wrong}, times)) > 3e-6


@pytest.mark.slow
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
    times = np.linspace(0.0, 0.3, 61)
    by_table = quarter_car({"damper.table": table}, times)
    assert largest_difference(quarter_car(limits, times), by_table) < 1e-12


@pytest.mark.sampled
@pytest.mark.parametrize("tyre_damping", [0.0, 980.665])
@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("shape", ["bump", "obstacle", "sine"])
def test_the_reference_of_the_campaign_agrees(
    shape: str, contact: str, tyre_damping: float
) -> None:
    """DOP853 with switches of its own against matrix exponentials, everything acting."""
    changed = {
        "damper.rebound_limit": 588.399, "damper.bump_limit": 294.1995,
        "damper.limit_slope": 200.0, "bump_stop.gap": 0.02, "bump_stop.stiffness": 3e5,
        "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 3e5, "road.shape": shape,
        "road.length": 3.0 if shape == "sine" else 1.0, "contact": contact,
        "tyre.damping": tyre_damping,
    }  # fmt: skip
    times = np.linspace(0.0, 0.12, 7)
    system = build("QuarterCar", AP57 | changed)
    exact = truth.solve(system, np.zeros(4), times)
    other = quarter_car(changed, times)
    assert np.abs(other.displacements - exact.displacements).max() < 1e-12 * other.peak
    # from the start the damper leaves its corner, by rounding at any time
    ours = [(s.time, s.element) for s in other.switches if s.time > 1e-4]
    theirs = [(t, element) for t, element, _ in exact.switches if t > 1e-4]
    assert len(ours) > 3
    assert [what for _, what in ours] == [what for _, what in theirs]
    assert [t for t, _ in ours] == pytest.approx([t for t, _ in theirs], abs=1e-10)


def test_each_file_here_is_described() -> None:
    """With its source, or with what it is made by."""
    here = Path(__file__).parent
    text = (here / "README.md").read_text(encoding="utf-8")
    files = {path.name for path in here.glob("*.*")} - {"README.md"}
    assert not {name for name in files if f"`{name}`" not in text}
