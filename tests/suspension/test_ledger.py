"""The energy ledger, entry by entry, against works that were integrated independently."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from make_drawn import SYSTEMS, instants, public, stored
from phaseplane.suspension import roads
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from stepped import read_at

AXLES = {"OneDof": [""], "QuarterCar": [""]}


def ledger(model: str, run: dict[str, Any], tolerance: float) -> tuple[System, Integrator]:
    """A stored run, ended on its last instant."""
    system = build(model, public(model, run["parameters"]))
    integrator = Integrator(system, tolerance=tolerance)
    assert integrator.advance(float(instants(model)[-1]), stop=True) == 0
    return system, integrator


@pytest.mark.parametrize("model", SYSTEMS)
def test_every_entry_is_that_of_the_reference(model: str) -> None:
    """Dissipated by damper, tyre and flow; brought in by each road and by the load."""
    tolerance = 1e-8
    for run in stored(model):
        system, integrator = ledger(model, run, tolerance)
        _, _, lost, brought_in = integrator.energies()
        lost = dict(zip((e.name for e in system.elements), lost, strict=True))
        brought_in = dict(zip(system.signals, brought_in, strict=True))
        works = np.array(run["works"])
        if model == "Elastoplastic":
            damper, flow, load = works
            assert sum(lost.values()) == pytest.approx(damper + flow, rel=10 * tolerance)
            assert sum(brought_in.values()) == pytest.approx(load, rel=10 * tolerance)
            continue
        allowed = 2.0 * tolerance * np.abs(works).sum()
        for axle, (damper, tyre, road) in zip(
            AXLES.get(model, ["front_", "rear_"]), works, strict=True
        ):
            assert lost[f"{axle}damper"] == pytest.approx(damper, abs=allowed)
            assert lost.get(f"{axle}tyre", 0.0) == pytest.approx(tyre, abs=allowed)
            assert brought_in[f"{axle}road"] == pytest.approx(road, abs=allowed)
            assert lost[f"{axle}spring"] == lost[f"{axle}bump_stop"] == 0.0


@pytest.mark.parametrize("model", SYSTEMS)
def test_the_entries_add_up_to_the_residual(model: str) -> None:
    """T + U + dissipated = brought in, but for what a damped tyre exchanges at a contact switch."""
    for run in stored(model)[:10]:
        system, integrator = ledger(model, run, 1e-6)
        kinetic, potential, lost, brought_in = integrator.energies()
        velocity = np.array(integrator.sample_v)
        integrator.sample(integrator.time)
        velocity = np.array(integrator.sample_v)
        assert kinetic == pytest.approx(0.5 * velocity @ np.array(system.mass) @ velocity, rel=1e-9)
        start = Integrator(system).energies()
        before = start[0] + sum(start[1])
        balance = kinetic + sum(potential) + sum(lost) - sum(brought_in) - before
        if "tyre" not in {e.name.removeprefix("front_") for e in system.elements}:
            scale = np.abs(run["works"]).sum()
            assert balance == pytest.approx(integrator.energy_residual(), abs=1e-13 * scale)


@pytest.mark.parametrize("element", ["spring", "bump_stop", "rebound_stop"])
def test_what_an_element_stores_is_its_potential(element: str) -> None:
    run = stored("OneDof")[3]
    system = build("OneDof", run["parameters"])
    integrator = Integrator(system, tolerance=1e-8)
    number = system.element(element)
    law = system.elements[number].spring
    seen = 0.0
    for t in np.linspace(0.02, 0.3, 15):
        read_at(integrator, t, stop=True)
        deflection = integrator.sample_q[0] - system.signals["road"].value(t)
        found = integrator.energies()[1][number]
        assert found == pytest.approx(law.potential(deflection), abs=1e-12)
        seen = max(seen, found)
    assert seen > 0.01


@pytest.mark.parametrize("model", SYSTEMS)
def test_between_steps_the_entries_are_those_of_a_run_that_ends_there(model: str) -> None:
    """Whatever begins or ends with the step: a kerb, a lift-off, slip."""
    system, whole = ledger(model, stored(model)[0], 1e-8)
    integrator = Integrator(system, tolerance=1e-8)
    between = 0
    for t in np.linspace(0.0, 0.3, 41)[1:]:
        assert integrator.advance(t) == 0
        between += integrator.time > t
        other = Integrator(system, tolerance=1e-8)
        assert other.advance(t, stop=True) == 0
        kinetic, kept, lost, brought_in = integrator.energies(t)
        found = np.array([kinetic, sum(kept), *lost, *brought_in])
        kinetic, kept, lost, brought_in = other.energies()
        there = np.array([kinetic, sum(kept), *lost, *brought_in])
        size = np.abs(whole.energies()[3]).sum() + np.abs(there).max()
        assert np.abs(found - there).max() < 1e-5 * size
    assert between > 20


def test_a_contact_switch_at_the_end_of_a_step_is_booked_if_steps_do_not_land_on_it() -> None:
    """The tyre's damper still carries a force when the wheel leaves the road."""
    parameters = {"tyre.damping": 500.0, "road.height": 0.08, "speed": 10.0}
    system = build("QuarterCar", parameters)
    integrator = Integrator(system, step=1e-4, landing=False)
    assert integrator.advance(0.3, stop=True) == 0
    assert len([kind for _, _, kind, *_ in integrator.log if KINDS[kind] == "contact"]) > 1
    assert abs(integrator.energy_residual()) < 1e-2


def test_a_jump_at_the_end_of_a_step_is_no_work_within_it() -> None:
    system = build("HalfCar", {})
    kerb = roads.step(0.004, 0.05)  # under the rear axle, too low for a tyre to leave the road
    signals = {**system.signals, "front_road": roads.LEVEL, "rear_road": kerb}
    integrator = Integrator(replace(system, signals=signals), tolerance=1e-8)
    assert integrator.advance(0.04) == 0
    assert integrator.time == 0.05
    assert sum(integrator.energies(0.049)[3]) == 0.0
    assert sum(integrator.energies()[3]) > 0.1
    assert integrator.advance(0.06) == 0
    assert sum(integrator.energies(0.055)[3]) > 0.1
