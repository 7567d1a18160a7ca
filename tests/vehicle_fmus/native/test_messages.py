"""What native FMUs tell the host: why values are refused, warnings, and reports of end stops."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from ctypes import c_char_p
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.variables import MODELS, variables

Packer = Callable[..., Path]

REFERENCE = {v.name: k for k, v in enumerate(variables("QuarterCar"))}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("name", "value", "at_once", "why"),
    [
        ("sprung_mass", -5.0, False, "sprung_mass = -5: must be greater than 0 kg"),
        ("payload", float("nan"), False, "payload = nan: must be finite and at least 0 kg"),
        ("friction", 50.0, False, "friction: this FMU was packed for another structure"),
        ("lift_off", False, False, "lift_off = false: this FMU was packed for true"),
        ("lift_off", False, False, "pack another with --set lift_off=false"),
        ("road.seed", 1234567, False, "pack another with --set road.seed=1234567"),
        ("road.shape", "100 %s", True, "road.shape = '100 %s': this FMU was packed for 'bump'"),
        ("body_displacement", 0.1, True, "body_displacement = 0.1: an output cannot be set"),
    ],
)
def test_what_it_cannot_have_is_refused_in_words(
    fmi: int, name: str, value: Any, at_once: bool, why: str,
    native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any,
) -> None:  # fmt: skip
    """By the end of initialisation, or at once if it can never be set."""
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        kinds = {float: "Real", int: "Integer", bool: "Boolean", str: "String"}
        setter = getattr(one, f"set{kinds[type(value)]}")
        with pytest.raises(Exception, match="status 3") if at_once else nullcontext():
            setter([REFERENCE[name]], [value])
        one.enterInitializationMode()
        with pytest.raises(Exception, match="status 3"):
            one.exitInitializationMode()
    assert why in capfd.readouterr().out


def test_a_logger_that_does_not_format_gets_the_whole_text(
    native_fmu: Packer, tmp_path: Path
) -> None:
    """As that of a host in Python, whose callback does not receive the values of a format."""
    fmu, texts = native_fmu("QuarterCar"), []
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(lambda *said: texts.append(said[-1].decode()))
    one = FMU2Slave(
        guid=read_model_description(str(fmu)).guid, unzipDirectory=extract(str(fmu), str(tmp_path)),
        modelIdentifier="QuarterCar", instanceName="car",
    )  # fmt: skip
    one.instantiate(callbacks=callbacks)
    with pytest.raises(Exception, match="status 3"):
        one.setReal([REFERENCE["body_displacement"]], [0.1])
    assert texts == ["body_displacement = 0.1: an output cannot be set"]
    one.freeInstance()


CATEGORIES = ["logEvents", "logStatusWarning", "logStatusError"]
# by version of FMI: in 3.0 a step that failed is an error
ALL_CATEGORIES = {2: [*CATEGORIES, "logStatusDiscard"], 3: CATEGORIES}
# of each message in the run below, of which the last is always told
TOLD = {"no effect": "logStatusWarning", "lift-off": "logEvents", "an output": "logStatusError"}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("calls", "told"),
    [
        ([(True, [])], {"logEvents", "logStatusWarning"}),
        ([(False, [])], set()),
        ([(False, []), (True, ["logEvents"])], {"logEvents"}),
        ([(False, []), (True, ["logStatusWarning", "logStatusError"])], {"logStatusWarning"}),
        ([(False, []), (True, ["logStatusError"])], set()),
        # in FMI 2.0 a call says all that is logged, in FMI 3.0 what changes
        ([(True, []), (True, ["logEvents"])], {2: {"logEvents"}, 3: {*CATEGORIES[:2]}}),
        ([(True, []), (False, ["logEvents"])], {2: set(), 3: {"logStatusWarning"}}),
    ],
)
def test_the_host_chooses_the_categories_of_messages(
    fmi: int, calls: Any, told: Any,
    native_fmu: Packer, slave: Any, log_categories: Any, tmp_path: Path, capfd: Any,
) -> None:  # fmt: skip
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        assert log_categories(tmp_path) == ALL_CATEGORIES[fmi]
        for on, categories in calls:
            one.setDebugLogging(on, categories)
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        one.setReal([REFERENCE["road_elevation"]], [0.1])
        one.doStep(0.0, 0.05)
        with pytest.raises(Exception, match="status 3"):
            one.setReal([REFERENCE["body_displacement"]], [0.1])
    said = capfd.readouterr().out
    told = told[fmi] if isinstance(told, dict) else told
    expected = {words for words, category in TOLD.items() if category in {*told, "logStatusError"}}
    assert {words for words in TOLD if words in said} == expected


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_category_that_does_not_exist_is_refused_and_changes_nothing(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        one.setDebugLogging(True, [])
        with pytest.raises(Exception, match="status 3"):
            one.setDebugLogging(False, ["logEvents", "logAll"])
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        one.doStep(0.0, 0.05)
    said = capfd.readouterr().out
    assert (
        f"there is no category 'logAll' of messages, but only {', '.join(ALL_CATEGORIES[fmi])}\n"
        in said
    )
    assert "lift-off" in said


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("names", [None, (c_char_p * 2)(b"logEvents", None)])
def test_categories_without_names_are_refused(
    fmi: int, names: Any, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        switch = getattr(one, f"fmi{fmi}SetDebugLogging")
        switch(one.component, 1, 0, None)  # all
        with pytest.raises(Exception, match="status 3"):
            switch(one.component, 1, 2, names)
    assert "there is no category '' of messages, but only logEvents" in capfd.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("elevation", "start", "why"),
    [
        (float("nan"), 0.0, "input road_elevation = nan: must be finite"),
        (float("inf"), 0.0, "input road_elevation = inf: must be finite"),
        (0.0, float("nan"), "start time = nan: must be finite"),
    ],
)
def test_inputs_and_start_times_that_are_not_finite_are_refused(
    fmi: int, elevation: float, start: float, why: str,
    native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any,
) -> None:  # fmt: skip
    """Otherwise the kernel would look for the energy of a spring nowhere, until the stack is full."""
    k = [v.name for v in variables("OneDof")].index("road_elevation")
    with slave(native_fmu("OneDof", ("road.shape", "input"), fmi=fmi), tmp_path) as one:
        one.setupExperiment(startTime=start)
        one.setReal([k], [elevation])
        one.enterInitializationMode()
        with pytest.raises(Exception, match="status 3"):
            one.exitInitializationMode()
    assert why in capfd.readouterr().out


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_road_set_on_a_built_in_road_is_warned_of(
    fmi: int, native_fmu: Packer, capfd: Any
) -> None:
    """Once, in the words of a session; 0, which many hosts set, says nothing."""
    times = np.linspace(0.0, 0.05, 6)
    rows = [(t, 0.0 if t < 0.015 else 0.01, 3.0) for t in times]
    given = np.array(rows, [("time", float), ("road_elevation", float), ("body_force", float)])
    simulate_fmu(
        str(native_fmu("QuarterCar", fmi=fmi)), stop_time=0.05, output_interval=0.01, input=given,
        debug_logging=True,
    )  # fmt: skip
    said = capfd.readouterr().out
    warning = "road_elevation = 0.01 has no effect, as road.shape is 'bump' and not 'input'"
    assert said.count("has no effect") == said.count(warning) == 1


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_run_that_will_not_reach_the_stop_time_fails_as_a_session_does(
    fmi: int, native_fmu: Packer, capfd: Any
) -> None:
    """Of the steps to come within one communication step there were never too many."""
    light: dict[str, Any] = {"sprung_mass": 1e-10, "road.shape": "bump", "speed": 20.0}
    session = Session("QuarterCar", light, stop_time=1.0)
    steps = (session.advance(1e-3 * k) for k in range(1, 1001))
    with pytest.raises(SimulationError) as failure:
        list(steps)
    fmu = native_fmu("QuarterCar", ("road.shape", "bump"), fmi=fmi)
    with nullcontext() if fmi == 2 else pytest.raises(FMICallException):  # 2.0 discards the step
        simulate_fmu(
            str(fmu), stop_time=1.0, output_interval=1e-3, start_values=light, debug_logging=True
        )
    cause = str(failure.value).partition(" (")[0]
    assert "more than 30 million steps" in cause
    assert cause in capfd.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_errors_that_add_up_are_told_once_in_the_words_of_a_session(
    fmi: int, native_fmu: Packer, capfd: Any
) -> None:
    undamped: dict[str, Any] = {
        "damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "tyre.damping": 0.0, "lift_off": False,
        "solver.tolerance": 1e-3,
    }  # fmt: skip
    session = Session("QuarterCar", undamped)
    for k in range(1, 201):
        session.advance(0.5 * k)
    (wanted,) = [text for _, text in session.messages if "errors accumulate" in text]
    fmu = native_fmu("QuarterCar", *undamped.items(), fmi=fmi)
    simulate_fmu(str(fmu), stop_time=100.0, output_interval=0.5, debug_logging=True)
    said = capfd.readouterr().out
    assert said.count("errors accumulate") == 1
    assert wanted in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "start", "reports"), [(490.0, 0.0, 2), (49e3, 0.0, 0), (490.0, -0.05, 0)]
)
def test_end_stops_are_reported_in_the_words_of_a_session(
    rate: float, start: float, reports: int, native_fmu: Packer, capfd: Any
) -> None:
    """A damper that is stiffer before the stop is met, when steps ahead have met it, prevents it.

    A stop that is compressed from the start is left, but was not met.
    """
    stop = {
        "bump_stop.gap": 0.03,
        "bump_stop.table": "0:0, 0.002:100, 0.004:600",
        "road.height": 0.08,
        "initial.body_displacement": start,
    }
    fmu = native_fmu("QuarterCar", *stop.items())
    session, number = Session("QuarterCar", stop), [v.name for v in MODELS["QuarterCar"]]

    def after_step(time: float, recorder: Any) -> bool:
        session.advance(time)
        if round(1e3 * time) == 19:
            session.set_parameter("damper.bump_rate", rate)
            recorder.fmu.setReal([number.index("damper.bump_rate")], [rate])
        return True

    simulate_fmu(str(fmu), stop_time=0.1, output_interval=1e-3, debug_logging=True,
                 step_finished=after_step)  # fmt: skip
    wanted = [text for _, text in session.messages if "stop" in text]
    said = [line for line in capfd.readouterr().out.splitlines() if "bump_stop" in line]
    assert len(said) == len(wanted) == reports
    assert all(text in line for text, line in zip(wanted, said, strict=True))


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-4, 0.1, 0.5, 2.0, -1.0, float("nan")])
def test_a_host_may_give_any_tolerance(
    fmi: int, tolerance: float, native_fmu: Packer, capfd: Any
) -> None:
    """One that needs another order or is out of range is ignored, with a warning that says why."""
    fmu, names = str(native_fmu("QuarterCar", fmi=fmi)), ["body_acceleration", "contact_force"]
    run = simulate_fmu(
        fmu, stop_time=0.3, output_interval=0.01, output=names, relative_tolerance=tolerance,
        debug_logging=True,
    )  # fmt: skip
    said = [line for line in capfd.readouterr().out.splitlines() if "the host's tolerance" in line]
    is_used = tolerance == 1e-5
    session = Session("QuarterCar", {}, tolerance=tolerance if is_used else None)
    session.advance(0.3)
    assert [run[name][-1] for name in names] == [session.value(name) for name in names]
    assert len(said) == (0 if is_used else 1)
    if not is_used:
        assert f"tolerance of {tolerance:g} is not used: solver.tolerance" in said[0]
        assert "WARNING" in said[0]
