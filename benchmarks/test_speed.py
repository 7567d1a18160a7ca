"""Times of steps and whole runs, stored and compared by `pytest benchmarks`.

`ratios.py` measures the decisive ratios, with interleaved sides.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import cases
import pytest
from phaseplane.scenarios.studies import peers, project_solvers
from phaseplane.scenarios.studies.problems import PROBLEMS
from phaseplane.scenarios.studies.reference import truth
from phaseplane.scenarios.studies.workbench import UnableError, Workbench
from phaseplane.suspension.engine import Integrator
from pytest_benchmark.fixture import BenchmarkFixture


@pytest.mark.benchmark(group="2000 fixed steps")
@pytest.mark.parametrize("name", ["C", "numba", "plain floats"])
def test_hard_coded_steps(benchmark: BenchmarkFixture, tmp_path: Path, name: str) -> None:
    made = cases.hard_coded_steps(tmp_path)
    if name not in made:
        pytest.skip("numba is not installed")
    benchmark(made[name])


@pytest.mark.benchmark(group="2000 fixed steps")
@pytest.mark.parametrize("method", ["equilibrium", "mean", "tangent", "extrapolated"])
def test_fixed_steps(benchmark: BenchmarkFixture, method: str) -> None:
    benchmark(cases.fixed_steps(Integrator, method))


@pytest.mark.benchmark(group="2000 fixed steps")
def test_uncompiled_steps(benchmark: BenchmarkFixture) -> None:
    benchmark.pedantic(cases.fixed_steps(cases.uncompiled_integrator()), rounds=3)


@pytest.fixture(scope="module", params=list(PROBLEMS))
def bench(request: pytest.FixtureRequest) -> Workbench:
    problem = PROBLEMS[request.param]()
    return Workbench(problem, truth(problem))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_whole_runs(benchmark: BenchmarkFixture, bench: Workbench, tolerance: float) -> None:
    benchmark.group = f"{bench.problem.name}, tolerance {tolerance:g}"
    benchmark(project_solvers.in_process(bench, tolerance=tolerance))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("name", ["dop853", "lsoda", "heyoka"])
def test_peers(benchmark: BenchmarkFixture, bench: Workbench, name: str, tolerance: float) -> None:
    package = "heyoka" if name == "heyoka" else "numbalsoda"
    pytest.importorskip(package)
    benchmark.group = f"{bench.problem.name}, tolerance {tolerance:g}"
    make = peers.heyoka if name == "heyoka" else partial(peers.numbalsoda, name)
    try:
        run = make(bench, tolerance)
        run()
    except (UnableError, ArithmeticError) as error:
        pytest.skip(str(error))
    benchmark(run)
