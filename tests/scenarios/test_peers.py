"""Other integrators on the project's problems, where they are installed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from dop853 import landing
from phaseplane.scenarios.studies import peers, workbench
from phaseplane.scenarios.studies.accuracy import Solver, solvers
from phaseplane.scenarios.studies.problems import PROBLEMS, of_model
from phaseplane.scenarios.studies.reference import largest_error, truth
from phaseplane.scenarios.studies.workbench import UnableError, Workbench

PEERS = [s for s in solvers(with_peers=True) if s.family == "peer"]
of_every_peer = pytest.mark.parametrize(
    "solver",
    [
        pytest.param(
            s,
            id=s.name,
            marks=pytest.mark.skipif(
                bool(s.missing), reason=f"not installed: {', '.join(s.missing)}"
            ),
        )
        for s in PEERS
    ],
)


@pytest.fixture(scope="module")
def car() -> Workbench:
    """A quarter car with lift-off over a bump that begins after the start."""
    parameters = {"road.start": 0.02, "speed": 20.0}
    problem = of_model("car", "", "non-smooth", "QuarterCar", parameters, 0.3, 30)
    return Workbench(problem, truth(problem))


@cache
def bench_of(name: str) -> Workbench:
    problem = PROBLEMS[name]()
    return Workbench(problem, truth(problem))


@pytest.fixture(scope="module")
def leaf() -> Workbench:
    return bench_of("friction")


def test_scipy_runs_without_a_compiler_too(car: Workbench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workbench, "find_spec", lambda name: None)
    bench = Workbench(car.problem, car.true)
    assert bench.compiled == {}
    assert largest_error(peers.scipy_method("DOP853", bench, 1e-9)(), car.true) < 1e-7


@pytest.mark.slow
@of_every_peer
def test_a_peer_comes_as_near_as_its_setting_says(solver: Solver, car: Workbench) -> None:
    # fixed steps run through the touchdown, where the tyre's force jumps
    value, bound = (1e-3 / 16, 1e-4) if solver.knob == "step" else (1e-8, 1e-5)
    run = solver.prepare(car, value)
    assert largest_error(run(), car.true) < bound
    assert np.array_equal(run(), run())  # and a run begins where the one before began


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:invalid value")  # steps tried far beyond the end of a piece
@of_every_peer
@pytest.mark.parametrize("name", ["curved", "curved_half_car"])
def test_every_peer_finds_the_same_motion_of_curved_springs_and_dampers(
    solver: Solver, name: str
) -> None:
    """Cubic polynomials, a hyperbolic tangent, tables of many pieces, and wheels that leave the road."""
    bench = bench_of(name)
    value, bound = (1e-3 / 16, 1e-3) if solver.knob == "step" else (1e-8, 1e-5)
    assert largest_error(solver.prepare(bench, value)(), bench.true) < bound


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lift_off", "curved"])
def test_the_hard_coded_peer_lands_on_every_switch(name: str) -> None:
    pytest.importorskip("numba", reason="not installed: numba")
    bench = bench_of(name)
    errors = [largest_error(landing(bench, 10.0**-k)(), bench.true) for k in (5, 8, 11)]
    assert errors[0] < 1e-3
    assert errors[1] < 1e-5
    assert errors[2] < 1e-8  # one switch missed costs more than 1e-6
    run = landing(bench, 1e-6)
    assert np.array_equal(run(), run())


@pytest.mark.parametrize("name", ["half_car", "friction", "hard_stop"])
def test_what_is_not_hard_coded_is_refused(name: str) -> None:
    problem = PROBLEMS[name]()
    with pytest.raises(UnableError, match="only a quarter car over a bump"):
        landing(Workbench(problem, np.zeros((1, 1))), 1e-6)


@pytest.mark.slow
@of_every_peer
def test_dry_friction_needs_events(solver: Solver, leaf: Workbench) -> None:
    if solver.name.startswith(("numbalsoda", "rk4")):
        with pytest.raises(UnableError, match="depends on the past"):
            solver.prepare(leaf, 1e-3)
    else:
        assert largest_error(solver.prepare(leaf, 1e-7)(), leaf.true) < 1e-3
