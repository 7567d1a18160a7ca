"""Native FMUs: calls out of place, steps from another time, and states that are restored."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from phaseplane.suspension.variables import variables

Packer = Callable[..., Path]

REFERENCE = {v.name: k for k, v in enumerate(variables("QuarterCar"))}


def begin(one: Any, start: float = 0.0) -> None:
    one.setupExperiment(startTime=start)
    one.enterInitializationMode()
    one.exitInitializationMode()


@pytest.mark.parametrize("fmi", [2, 3])
def test_calls_out_of_place_are_refused_and_change_nothing(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    """In every mode the calls that FMI allows in others, and then the run that there is without them."""
    body, road = [REFERENCE["body_displacement"]], REFERENCE["road_elevation"]
    fmu = native_fmu("QuarterCar", fmi=fmi)
    with slave(fmu, tmp_path / "plain") as plain, slave(fmu, tmp_path / "tried") as one:
        calls = {
            "EnterInitializationMode": one.enterInitializationMode,
            "ExitInitializationMode": one.exitInitializationMode,
            "DoStep": lambda: one.doStep(0.1, 0.1),
            "Terminate": one.terminate,
            "Set": lambda: one.setReal([REFERENCE["damper.scale"]], [2.0]),
        }
        if fmi == 2:
            calls["SetupExperiment"] = lambda: one.setupExperiment(startTime=5.0)

        def refuse(mode: str, *allowed: str) -> None:
            for name, call in calls.items():
                if name not in allowed:
                    with pytest.raises(Exception, match="status 3"):
                        call()
                    said = capfd.readouterr().out
                    assert f"fmi{fmi}{name}" in said
                    assert f"cannot be called {mode}, but only" in said

        for _ in range(2):
            for each in (plain, one):
                each.setupExperiment(startTime=0.0)
            refuse("after instantiation", "SetupExperiment", "EnterInitializationMode", "Set")
            for each in (plain, one):
                each.enterInitializationMode()
            refuse("in initialization mode", "ExitInitializationMode", "Set")
            for each in (plain, one):
                each.exitInitializationMode()
                each.doStep(0.0, 0.1)
            refuse("in step mode", "DoStep", "Terminate", "Set")
            for each in (plain, one):
                each.doStep(0.1, 0.1)
            state = one.getFMUstate()
            one.terminate()
            refuse("after the end")
            assert one.getReal(body) == plain.getReal(body) != [0.0]
            assert one.getDirectionalDerivative(body, [road], [1.0]) == [0.0]
            with pytest.raises(Exception, match="status 3"):
                one.setFMUstate(None)
            assert "there is no state: get or deserialize one first" in capfd.readouterr().out
            one.setFMUstate(state)
            for each in (plain, one):
                each.doStep(0.2, 0.1)
                each.terminate()
            assert one.getReal(body) == plain.getReal(body)
            for each in (plain, one):
                each.reset()


@pytest.mark.parametrize("fmi", [2, 3])
def test_after_a_refused_step_no_output_looks_right(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        begin(one)
        one.doStep(0.0, 0.1)
        assert one.getBoolean([REFERENCE["ok"]]) == [True]
        with pytest.raises(Exception, match="status 3"):
            one.setReal([REFERENCE["damper.rebound_rate"]], [-5.0])
        with pytest.raises(Exception, match=r"status [23]"):
            one.doStep(0.1, 0.1)
        assert one.getBoolean([REFERENCE["ok"]]) == [False]
        assert np.isnan(one.getReal([REFERENCE["body_displacement"]])).all()
    assert "damper.rebound_rate = -5" in capfd.readouterr().out


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("time", [0.0, 0.05, 0.2])
def test_a_step_that_is_repeated_or_left_out(
    fmi: int, time: float, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        begin(one)
        one.doStep(0.0, 0.1)
        state = one.getFMUstate()
        with pytest.raises(Exception, match=r"status [23]"):
            one.doStep(time, 0.1)
        assert one.getBoolean([REFERENCE["ok"]]) == [False]
        one.setFMUstate(state)
        for k in range(1, 100):  # in single precision
            one.doStep(float(np.float32(k) * np.float32(0.1)), float(np.float32(0.1)))
        assert one.getBoolean([REFERENCE["ok"]]) == [True]
    said = capfd.readouterr().out
    assert f"the host steps from {time:g} s, but the FMU is at 0.1 s: step from there" in said


def test_short_steps_that_are_repeated_far_from_zero(
    native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """A host may count from 1970."""
    start = 1.7e9
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        begin(one, start)
        one.doStep(start, 0.001)
        with pytest.raises(Exception, match="status 2"):
            one.doStep(start, 0.001)


@pytest.mark.slow
@pytest.mark.parametrize("start", [0.0, 1e6])
def test_a_step_that_ends_before_its_start_by_rounding_goes_nowhere(
    start: float, native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    names = [v.name for v in variables("OneDof")]
    force, rate, body = map(names.index, ("body_force", "damper.rebound_rate", "body_displacement"))
    found = []
    now = start + 0.1
    for name, steps in (
        ("plain", ()),
        ("touched", ((now, -5e-13), (float(np.nextafter(now, 0.0)), 0.0))),
    ):
        with slave(native_fmu("OneDof", ("road.shape", "input")), tmp_path / name) as one:
            begin(one, start)
            one.setReal([force], [300.0])
            one.doStep(start, 0.1)
            for time, size in steps:
                one.doStep(time, size)
            one.setReal([rate], [900.0])
            one.doStep(now, 0.1)
            found += one.getReal([body])
    assert found[0] == found[1] != 0.0


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_restored_state_reads_as_it_was_left(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    """Forces too, of a wheel so light that its motion decays within a step; a damaged one is refused."""
    outputs = [REFERENCE[v.name] for v in variables("QuarterCar")
               if v.causality == "output" and isinstance(v.start, float)]  # fmt: skip
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        one.setReal([REFERENCE["body_force"], REFERENCE["unsprung_mass"]], [100.0, 0.01])
        one.enterInitializationMode()
        one.exitInitializationMode()
        for time in (0.0, 0.5, 1.0, 1.5):
            one.doStep(time, 0.5)
            left = one.getReal(outputs)
            one.setFMUstate(one.getFMUstate())
            assert one.getReal(outputs) == left
        damaged = bytearray(one.serializeFMUstate(one.getFMUstate()))
        damaged[-1] ^= 1
        with pytest.raises(Exception, match="status 3"):
            one.deSerializeFMUstate(bytes(damaged))
        assert "this state is damaged" in capfd.readouterr().out


def test_a_state_keeps_a_refusal(
    native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    """So does that of an FMU that runs Python; a state from before the refusal can be continued."""
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        begin(one)
        before = one.getFMUstate()
        with pytest.raises(Exception, match="status 3"):
            one.setReal([REFERENCE["damper.scale"]], [-1.0])
        refused = one.getFMUstate()
        one.setFMUstate(before)
        one.doStep(0.0, 0.1)
        one.setFMUstate(refused)
        capfd.readouterr()
        with pytest.raises(Exception, match="status 2"):
            one.doStep(0.0, 0.1)
    assert "damper.scale = -1" in capfd.readouterr().out
