"""Steps do not depend on whether energy is accounted for, nor on where results are read."""

from __future__ import annotations

from array import array
from math import isfinite, isnan

import numpy as np
import pytest
from phaseplane.suspension.batch import run_many
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.session import Session
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import outputs
from stepped import STOPS, displaced, filled, read_at

SYSTEMS = {
    "lift-off": ("QuarterCar", {}),
    "stops": ("QuarterCar", STOPS),
    "sine": ("QuarterCar", {"road.shape": "sine", "road.height": 0.02, "road.length": 3.0}),
    "friction": ("QuarterCar", {"friction": 200.0}),
    "curved": ("QuarterCar", {"spring.cubic": 1e6, "damper.saturation_force": 800.0}),
    "half car": ("HalfCar", {}),
    "yielding": ("Elastoplastic", {"yield_force": 5.0}),
    "one mass": ("OneDof", {}),
}
STEP, STEPS = 5e-4, 2000


@pytest.fixture(params=list(SYSTEMS))
def system(request: pytest.FixtureRequest) -> System:
    return build(*SYSTEMS[request.param])


def run(
    system: System, parts: int, **options: object
) -> tuple[np.ndarray, list[tuple[float, ...]], Integrator]:
    """Displacements and accelerations at so many equal parts of a second, the switches."""
    integrator = Integrator(system, step=STEP, **options)
    rows = []
    for k in range(1, parts + 1):
        t = STEP * STEPS * k / parts
        read_at(integrator, t)
        rows.append([*integrator.sample_q, *integrator.sample_v, *integrator.sample_a])
    return np.array(rows), integrator.log, integrator


@pytest.mark.parametrize(
    "options",
    [{"method": "equilibrium"}, {"method": "mean"}, {"method": "wilson"}, {}, {"order": 4}],
    ids=str,
)
def test_the_ledger_changes_no_bit(system: System, options: dict[str, object]) -> None:
    without, log, _ = run(system, 40, energy=False, **options)
    kept, log_kept, _ = run(system, 40, energy=True, **options)
    assert (without == kept).all()
    assert log == log_kept


@pytest.mark.parametrize("parts", [1, 8, 2000, 2001])
def test_where_results_are_read_changes_no_bit(system: System, parts: int) -> None:
    once, log, _ = run(system, 1, method="equilibrium", energy=False)
    often, log_often, _ = run(system, parts, method="equilibrium", energy=False)
    assert (once[-1] == often[-1]).all()
    assert log == log_often


def test_a_whole_run_is_the_same() -> None:
    system = build("QuarterCar", STOPS)
    times = array("d", np.linspace(0.0, 1.0, 333))
    (rows,) = filled(Integrator(system, "mean", STEP, energy=False), times, 2)
    found = displaced(Integrator(system, "mean", STEP, energy=False), times)
    assert (found == rows).all()


def test_a_motion_without_bound_ends_the_run() -> None:
    system = build("OneDof", {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0})
    integrator = Integrator(system, "equilibrium", 10.0, energy=False, beyond_stable="allow")
    integrator.set_state([0.01], [0.0])
    assert integrator.advance(1e6) == 2


@pytest.mark.parametrize("road", ["bump", "input"])
def test_a_session_without_it_moves_alike_and_has_no_entries_of_it(road: str) -> None:
    """On a sampled road, too, whose jumps are booked otherwise; and after a parameter has changed."""
    kept, without = (
        Session("QuarterCar", {"road.shape": road, "solver.energy": energy})
        for energy in (True, False)
    )
    for k in range(1, 201):
        for session in (kept, without):
            if road == "input":
                session.set_input("road_elevation", 0.01 * (k > 50))
            if k == 100:
                session.set_parameter("damper.rebound_rate", 1500.0)
            session.advance(0.005 * k)
    for name in outputs("QuarterCar"):
        found = without.value(name)
        if needs_ledger(name):
            assert isnan(found), name
            assert isfinite(kept.value(name)), name
        else:
            assert found == kept.value(name), name


def test_a_batch_without_it_has_no_residual() -> None:
    wanted = ["body_displacement", "energy_residual"]
    sets = [{}, {"solver.energy": False}]
    kept, without = (one.columns for one in run_many("QuarterCar", sets, [0.0, 0.5, 1.0], wanted))
    assert np.isfinite(kept["energy_residual"]).all()
    assert np.isnan(without["energy_residual"]).all()
    assert (kept["body_displacement"] == without["body_displacement"]).all()
