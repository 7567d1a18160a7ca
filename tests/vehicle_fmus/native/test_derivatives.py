"""Native FMUs: derivatives of outputs over time, and in directions of inputs and parameters."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description
from phaseplane.suspension.variables import variables
from structures import STRUCTURES

Packer = Callable[..., Path]

REFERENCE = {v.name: k for k, v in enumerate(variables("QuarterCar"))}


@pytest.mark.slow
@pytest.mark.parametrize("what", ["QuarterCar", "Elastoplastic"])
def test_outputs_have_derivatives(
    what: str, native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """Against differences of the outputs on both sides, within one step of the integrator."""
    model = STRUCTURES[what].model
    fmu = native_fmu(model, *STRUCTURES[what].settings.items())
    declared = read_model_description(str(fmu)).modelVariables
    outputs = [v for v in declared if v.causality == "output" and v.type == "Real"]
    references, h = [v.valueReference for v in outputs], 1e-6
    with slave(fmu, tmp_path) as one:

        def rates() -> np.ndarray[Any, Any]:
            found = (ctypes.c_double * len(outputs))()
            one.fmi2GetRealOutputDerivatives(
                one.component, (ctypes.c_uint * len(outputs))(*references), len(outputs),
                (ctypes.c_int * len(outputs))(*[1] * len(outputs)), found,
            )  # fmt: skip
            return np.array(found)

        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        time, largest, compared = 0.0, np.zeros(len(outputs)), 0
        count = [v.name for v in variables(model)].index("step_count")
        for k in range(1, 40):
            one.doStep(time, 0.01 * k - h - time)
            before, steps = np.array(one.getReal(references)), one.getInteger([count])
            one.doStep(0.01 * k - h, h)
            found = rates()
            one.doStep(0.01 * k, h)
            time = 0.01 * k + h
            if one.getInteger([count]) != steps:
                continue  # a switch between them
            wanted = (np.array(one.getReal(references)) - before) / (2.0 * h)
            largest = np.maximum(largest, np.abs(wanted))
            noise = 1e-10 * np.abs(before) / h
            assert np.all(np.abs(found - wanted) <= 1e-4 * largest + noise + 1e-6), k
            compared += 1
        assert compared > 20
        assert np.count_nonzero(largest) > 5


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_directional_derivatives_of_the_start(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """Against closed forms; the start and the run stay what they are."""
    fmu = native_fmu("QuarterCar", fmi=fmi)
    mass, rate, x, v = 350.0, 3e4, 0.01, 0.2
    given = {"sprung_mass": mass, "spring.rate": rate, "spring.cubic": 4e6,
             "initial.body_displacement": x, "initial.body_velocity": v, "body_force": 20.0}  # fmt: skip

    def started(folder: str, ask: bool) -> Any:
        one = kept.enter_context(slave(fmu, tmp_path / folder))
        one.setupExperiment(startTime=0.0)
        for name, value in given.items():
            one.setReal([REFERENCE[name]], [value])
        one.enterInitializationMode()
        if ask:
            compare(one)
        one.exitInitializationMode()
        return one

    def along(one: Any, seeds: dict[str, float], *outputs: str) -> list[float]:
        return list(
            one.getDirectionalDerivative(
                [REFERENCE[name] for name in outputs], [REFERENCE[name] for name in seeds],
                list(seeds.values()),
            )
        )  # fmt: skip

    def compare(one: Any) -> None:
        def value(name: str) -> float:
            return float(one.getReal([REFERENCE[name]])[0])

        wanted = {
            ("body_force", "body_acceleration"): 1.0 / mass,
            ("body_force", "wheel_acceleration"): 0.0,
            ("gravity", "contact_force"): mass + value("unsprung_mass"),
            ("sprung_mass", "contact_force"): value("gravity"),
            ("spring.rate", "body_acceleration"): -x / mass,
            ("initial.body_displacement", "body_acceleration"): -(rate + 3 * 4e6 * x**2) / mass,
            ("initial.body_velocity", "body_acceleration"): -value("damper.rebound_rate") / mass,
            ("tyre.stiffness", "tyre_force"): 0.0,
            ("sprung_mass", "body_acceleration"): -value("body_acceleration") / mass,
        }
        scale = abs(value("body_acceleration"))
        for (known, unknown), exact in wanted.items():
            (found,) = along(one, {known: 1.0}, unknown)
            assert found == pytest.approx(exact, rel=1e-9, abs=1e-12 * scale), (known, unknown)
            (found,) = along(one, {known: -2.5}, unknown)
            assert found == pytest.approx(-2.5 * exact, rel=1e-9, abs=3e-12 * scale)
        seeds = {known: 1.0 / (1.0 + k) for k, (known, _) in enumerate(wanted)}
        both = along(one, seeds, "body_acceleration", "contact_force")
        parts = [along(one, {name: seed}, "body_acceleration", "contact_force")
                 for name, seed in seeds.items()]  # fmt: skip
        assert both == pytest.approx(np.sum(parts, axis=0), rel=1e-7)
        with pytest.raises(Exception, match="status 3"):
            along(one, {"body_displacement": 1.0}, "body_velocity")

    with ExitStack() as kept:
        asked, other = started("asked", True), started("other", False)
        outputs = [REFERENCE[v.name] for v in variables("QuarterCar")
                   if v.causality == "output" and isinstance(v.start, float)]  # fmt: skip
        for k in range(50):
            assert asked.getReal(outputs) == other.getReal(outputs)
            asked.doStep(0.01 * k, 0.01)
            other.doStep(0.01 * k, 0.01)
        # outputs of a step do not depend on inputs set after it
        assert along(asked, {"body_force": 1.0}, "body_acceleration", "tyre_force") == [0.0, 0.0]
        with pytest.raises(Exception, match="status 3"):
            along(asked, {"sprung_mass": 1.0}, "body_acceleration")


def test_directional_derivatives_at_the_end_of_a_range(
    native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """Values on one side are refused; those on the other give the derivative."""
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        one.setReal([REFERENCE["sprung_mass"]], [1e-5])
        one.enterInitializationMode()
        found = [
            one.getDirectionalDerivative(
                [REFERENCE["contact_force"]], [REFERENCE["sprung_mass"]], [seed]
            )[0]
            for seed in (1.0, -1.0)
        ]
        (gravity,) = one.getReal([REFERENCE["gravity"]])
    assert found == pytest.approx([gravity, -gravity], rel=1e-9)


def test_a_derivative_by_a_road_without_effect_leaves_the_warning_to_the_host(
    native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    body, road = REFERENCE["body_acceleration"], REFERENCE["road_elevation"]
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        one.setDebugLogging(True, [])
        one.enterInitializationMode()
        assert one.getDirectionalDerivative([body], [road], [1.0]) == [0.0]
        assert "has no effect" not in capfd.readouterr().out
        one.setReal([road], [0.01])
    assert "road_elevation = 0.01 has no effect" in capfd.readouterr().out
