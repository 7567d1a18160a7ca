"""What the FMUs say of themselves."""

from __future__ import annotations

from pathlib import Path
from sys import float_info
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
from phaseplane.suspension.session import Session
from phaseplane.suspension.units import UNITS
from phaseplane.suspension.variables import variables


@pytest.mark.sampled
def test_fmpy_finds_no_fault(model: str, fmus: dict[str, Path]) -> None:
    assert validate_fmu(str(fmus[model])) == []


def test_variables_are_those_of_the_table(model: str, vehicle: Any) -> None:
    shown = vehicle.description.modelVariables
    assert [v.name for v in shown] == [v.name for v in variables(model)]
    for said, meant in zip(shown, variables(model), strict=True):
        assert said.causality == meant.causality
        assert said.unit == (meant.unit or None)
        assert (said.declaredType, said.displayUnit) == (None, meant.display or None)
        assert meant.description in said.description
        assert all(choice in said.description for choice in meant.choices)
        bounds = (float_info.min if meant.positive else meant.minimum, meant.maximum, meant.nominal)
        assert tuple(v and float(v) for v in (said.min, said.max, said.nominal)) == bounds
        if said.causality == "parameter":
            may_change = "tunable" if meant.tunable else "fixed"
            assert (said.variability, said.initial) == (may_change, "exact")
        if said.causality == "output":
            continuous = isinstance(meant.start, float)
            assert said.variability == ("continuous" if continuous else "discrete")
            assert (said.initial, said.start) == ("calculated", None)
        elif isinstance(meant.start, float):
            assert float(said.start) == meant.start


def test_units_convert_as_ours_do(model: str, vehicle: Any) -> None:
    units = {unit.name: unit for unit in vehicle.description.unitDefinitions}
    assert set(units) == {v.unit for v in variables(model) if v.unit}
    for name, unit in units.items():
        base = {k: getattr(unit.baseUnit, k) for k in ("kg", "m", "s", "rad")}
        assert base == {k: UNITS[name].exponents.get(k, 0) for k in base}
        assert {d.name: 1.0 / d.factor for d in unit.displayUnits} == pytest.approx(
            dict(UNITS[name].display)
        )


def test_structure_and_experiment(model: str, vehicle: Any) -> None:
    description = vehicle.description
    outputs = [v.name for v in variables(model) if v.causality == "output"]
    assert [unknown.variable.name for unknown in description.outputs] == outputs
    assert all(unknown.dependencies == [] for unknown in description.outputs)
    assert [unknown.variable.name for unknown in description.initialUnknowns] == outputs
    experiment = description.defaultExperiment
    assert [float(x) for x in (experiment.startTime, experiment.stopTime, experiment.stepSize,
                               experiment.tolerance)] == [0.0, 1.0, 1e-3, 1e-6]  # fmt: skip
    can = description.coSimulation
    assert can.canGetAndSetFMUstate
    assert can.canSerializeFMUstate
    assert can.canHandleVariableCommunicationStepSize
    assert not can.canBeInstantiatedOnlyOncePerProcess


def test_fmpy_runs_it_as_it_runs_by_itself(model: str, fmus: dict[str, Path]) -> None:
    result = simulate_fmu(str(fmus[model]), stop_time=0.5, output_interval=0.01)
    session = Session(model, {})
    for row in result:
        session.advance(float(row["time"]))
        assert list(row)[1:] == [session.value(name) for name in result.dtype.names[1:]]
    assert result["ok"].all()
    assert max(np.abs(result[name]).max() for name in result.dtype.names[1:]) > 0.045
