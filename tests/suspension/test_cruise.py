"""Fixed steps taken one after the other in a linear branch, against the same steps taken singly.

Where the energy ledger is kept each step is seen by itself; without it, steps in a linear branch are
cruised through. Both are the same method and must give the same motion and the same switches.
"""

from __future__ import annotations

from array import array

import numpy as np
import pytest
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System

BUSY = {
    "damper.rebound_limit": 588.399,
    "damper.bump_limit": 294.1995,
    "damper.limit_slope": 200.0,
    "bump_stop.gap": 0.02,
    "bump_stop.stiffness": 3e5,
}
SYSTEMS = {
    "lift-off": ("QuarterCar", {}),
    "stops": ("QuarterCar", BUSY),
    "sine": ("QuarterCar", {"road.shape": "sine", "road.height": 0.02, "road.length": 3.0}),
    "friction": ("QuarterCar", {"friction": 200.0}),
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
        assert integrator.advance(t) == 0
        integrator.sample(t)
        rows.append([*integrator.sample_q, *integrator.sample_v, *integrator.sample_a])
    return np.array(rows), integrator.log, integrator


def lasting(log: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Without switches that the next one takes back at the same instant, as rounding has it."""
    kept: list[tuple[float, ...]] = []
    for event in log:
        t, element, kind, before, after = event
        if kept and kept[-1] == (t, element, kind, after, before):
            kept.pop()
        else:
            kept.append(event)
    return kept


@pytest.mark.parametrize("method", ["equilibrium", "mean", "tangent"])
def test_cruising_is_stepping(system: System, method: str) -> None:
    cruised, log, fast = run(system, 40, method=method, energy=False)
    stepped, singly, slow = run(system, 40, method=method, energy=True)
    scale = np.abs(stepped).max(axis=0)
    # yield and blow-off magnify rounding; a step missed or made twice would show at 1e-3
    assert (np.abs(cruised - stepped) <= 1e-9 * scale + 1e-300).all()
    log, singly = lasting(log), lasting(singly)
    assert [event[1:] for event in log] == [event[1:] for event in singly]
    assert [event[0] for event in log] == pytest.approx([event[0] for event in singly], abs=1e-10)
    assert abs(fast.step_count - slow.step_count) <= 1  # the grid of the one drifts by rounding


@pytest.mark.parametrize("parts", [1, 8, 2000, 2001])
def test_where_results_are_read_changes_no_bit(system: System, parts: int) -> None:
    once, log, _ = run(system, 1, method="equilibrium", energy=False)
    often, log_often, _ = run(system, parts, method="equilibrium", energy=False)
    assert (once[-1] == often[-1]).all()
    assert log == log_often


def test_a_state_goes_on_to_the_bit(system: System) -> None:
    through = Integrator(system, "equilibrium", STEP, energy=False)
    again = Integrator(system, "equilibrium", STEP, energy=False)
    through.advance(0.4)
    again.restore(through.snapshot())
    for integrator in (through, again):
        assert integrator.advance(1.0) == 0
        integrator.sample(1.0)
    assert list(through.sample_q) == list(again.sample_q)
    assert list(through.sample_a) == list(again.sample_a)


def test_a_whole_run_is_the_same() -> None:
    system = build("QuarterCar", BUSY)
    times = array("d", np.linspace(0.0, 1.0, 333))
    columns = np.empty((2, len(times)))
    assert Integrator(system, "mean", STEP, energy=False).run(times, columns.reshape(-1)) == 0
    integrator = Integrator(system, "mean", STEP, energy=False)
    for t, row in zip(times, columns.T, strict=True):
        integrator.advance(t)
        integrator.sample(t)
        assert list(integrator.sample_q) == list(row)


def test_a_motion_without_bound_ends_a_cruise() -> None:
    system = build("OneDof", {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0})
    integrator = Integrator(system, "equilibrium", 10.0, energy=False, beyond_stable="allow")
    integrator.set_state([0.01], [0.0])
    assert integrator.advance(1e6) == 2
