"""Every system against stored solutions of drawn parameter sets in which everything acts.

The solutions were made by programs that share nothing with the package (tests/reference); the first
of each system is solved again here, to show that the files are what the programs make.
"""

from __future__ import annotations

from collections import Counter
from functools import cache
from typing import Any

import make_drawn
import numpy as np
import pytest
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import System
from stepped import displaced
from switched import Switch
from vehicle_reference import BRANCHES


@cache
def stored(model: str) -> list[dict[str, Any]]:
    return make_drawn.stored(model)


def system_of(model: str, parameters: dict[str, Any]) -> System:
    return build(model, make_drawn.public(model, parameters))


def motion(model: str, parameters: dict[str, Any], **options: Any) -> tuple[np.ndarray, Integrator]:
    """Displacements at the stored instants, (coordinates, instants)."""
    integrator = Integrator(system_of(model, parameters), **options)
    return displaced(integrator, make_drawn.instants(model)).T, integrator


def error(run: dict[str, Any], found: np.ndarray) -> float:
    """Largest error at the stored instants, relative to the peak."""
    exact = np.array(run["displacements"])
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def switches(system: System, integrator: Integrator) -> list[Switch]:
    """What the integrator has noted, in the words of the references; those at the start left out."""
    found = []
    for t, element, _, _, new in integrator.log:
        name = system.elements[element].name
        for side in ("front", "rear"):
            name = name.replace(f"{side}_", f"{side} ")
        kind = name.split(" ")[-1]
        words = {
            "damper": BRANCHES[0],
            "bump_stop": ("met", "left"),
            "rebound_stop": ("left", "met"),
            "tyre": ("touchdown", "lift-off"),
            "spring": ("flows down", "elastic", "flows up"),
        }[kind]
        if t > 0.0:
            found.append(Switch(t, name, words[new]))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("model", make_drawn.SYSTEMS)
def test_the_files_hold_what_the_programs_make(model: str) -> None:
    """The beginning of the first run made again, and every switch in it at its instant."""
    run, times = stored(model)[0], make_drawn.instants(model)[:16]
    assert any(make_drawn.draw(model, 0, attempt) == run["parameters"] for attempt in range(20))
    solution = make_drawn.solve(model, run["parameters"], times)
    kept = np.array(run["displacements"]).T[:16]
    assert np.abs(solution.displacements - kept).max() < 1e-12 * np.abs(kept).max()
    system = system_of(model, run["parameters"])
    _, integrator = motion(model, run["parameters"], tolerance=1e-10)
    found = [switch for switch in switches(system, integrator) if switch.time < times[-1]]
    expected = [switch for switch in solution.switches if switch.time > 0.0]
    assert len(expected) >= 2
    assert [switch[1:] for switch in found] == [switch[1:] for switch in expected]
    assert [s.time for s in found] == pytest.approx([s.time for s in expected], abs=1e-8)


@pytest.mark.parametrize("model", make_drawn.SYSTEMS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_the_error_is_within_the_tolerance(model: str, tolerance: float) -> None:
    """And the ledger lacks no more than that of all the energy that has gone through it."""
    errors, residuals = [], []
    for run in stored(model):
        found, integrator = motion(model, run["parameters"], tolerance=tolerance)
        errors.append(error(run, found) / tolerance)
        turned_over = np.abs(run["works"]).sum()
        residuals.append(abs(integrator.energy_residual()) / (tolerance * turned_over))
    assert {k: round(e, 2) for k, e in enumerate(errors) if not e < 1.0} == {}
    assert {k: round(r, 2) for k, r in enumerate(residuals) if not r < 10.0} == {}


@pytest.mark.parametrize("model", make_drawn.SYSTEMS)
def test_no_switch_is_missed_and_none_is_made_up(model: str) -> None:
    end = make_drawn.instants(model)[-1]
    for run in stored(model):
        system = system_of(model, run["parameters"])
        _, integrator = motion(model, run["parameters"], tolerance=1e-9)
        found = Counter(
            f"{s.element}: {s.branch}"
            for s in switches(system, integrator)
            if s.time <= end  # the last step goes beyond
        )
        assert found == run["switches"]


@pytest.mark.parametrize("model", make_drawn.SYSTEMS)
def test_the_comparison_fails_for_another_parameter(model: str) -> None:
    """A millionth more mass shows: the error is no longer within a tolerance of 1e-9."""
    run = stored(model)[1]
    name = "mass" if model == "Elastoplastic" else "sprung_mass"
    other = {**run["parameters"], name: run["parameters"][name] * (1.0 + 1e-6)}
    found, _ = motion(model, other, tolerance=1e-9)
    assert error(run, found) > 1e-8


COORDINATES = {
    "OneDof": ["body_"], "QuarterCar": ["body_", "wheel_"],
    "HalfCarRigidTyres": ["front_body_", "rear_body_"],
    "HalfCar": ["front_body_", "rear_body_", "front_wheel_", "rear_wheel_"], "Elastoplastic": [""],
}  # fmt: skip


@pytest.mark.parametrize("model", make_drawn.SYSTEMS)
def test_the_public_model_says_the_same(model: str) -> None:
    """By parameters and outputs alone, as an FMU has them."""
    for run in stored(model)[:5]:
        session = Session(
            model, {**make_drawn.public(model, run["parameters"]), "solver.tolerance": 1e-9}
        )
        found = []
        for t in make_drawn.instants(model):
            session.advance(float(t))
            found.append([session.value(f"{name}displacement") for name in COORDINATES[model]])
        assert error(run, np.array(found).T) < 1e-9
        assert abs(session.value("energy_residual")) < 1e-8 * np.abs(run["works"]).sum()
        peak = np.abs(run["displacements"]).max()
        for name, velocity in zip(COORDINATES[model], run["final_velocities"], strict=True):
            assert session.value(f"{name}velocity") == pytest.approx(velocity, abs=1e-6 * peak)
        if "final_set" in run:
            assert session.value("permanent_set") == pytest.approx(
                run["final_set"], abs=1e-9 * peak
            )
        for name, count in run["switches"].items():
            if name.endswith("tyre: lift-off"):
                side = name.removesuffix("tyre: lift-off").strip()
                axle = f"{side}_" if side else ""
                assert session.value(f"{axle}lift_off_count") == count
