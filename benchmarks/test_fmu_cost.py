"""The cost of FMUs in FMPy and in a host in C stays below its limits."""

from __future__ import annotations

from pathlib import Path

from fmu_cost import host_costs, run_costs, step_costs, tuned_in_python, tuning_costs


def test_a_communication_step(tmp_path: Path) -> None:
    costs = step_costs(tmp_path)
    assert costs["QuarterCar"] <= 2.5 * costs["empty"], costs
    assert costs["native QuarterCar"] <= 1.3 * costs["empty"], costs


def test_a_native_fmu_in_a_host_in_c(tmp_path: Path) -> None:
    costs = host_costs(tmp_path)
    assert max(costs["step"], costs["step on random road"]) <= 1e-6, costs
    assert max(costs["instance"], costs["instance with random road"]) <= 1e-3, costs


def test_a_run_with_its_measures(tmp_path: Path) -> None:
    costs = run_costs(tmp_path)
    assert costs["through the FMU"] <= costs["FMPy"], costs
    assert costs["in process"] <= 0.35 * costs["FMPy"], costs


def test_a_parameter_that_changes_costs_about_a_step(tmp_path: Path) -> None:
    costs = tuning_costs(tmp_path)
    assert costs["step with parameter tuned"] <= 2.5 * costs["step on sampled road"], costs
    assert costs["step with parameter tuned on random road"] <= 2e-5, costs


def test_a_parameter_that_changes_in_an_fmu_that_runs_python(tmp_path: Path) -> None:
    costs = tuned_in_python(tmp_path)
    assert costs["setReal + doStep on input"] <= 3.0 * costs["doStep on input"], costs
    assert costs["setReal + doStep on bump"] <= 6.0 * costs["doStep on bump"], costs
