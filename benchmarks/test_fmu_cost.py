"""The cost of an FMU in FMPy stays below its limit."""

from __future__ import annotations

from pathlib import Path

from fmu_cost import step_costs


def test_a_communication_step(tmp_path: Path) -> None:
    costs = step_costs(tmp_path)
    assert costs["QuarterCar"] <= 2.5 * costs["native"], costs
