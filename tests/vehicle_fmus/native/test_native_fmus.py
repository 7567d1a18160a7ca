"""Native FMUs in FMPy: refusals, what is in the archive, and what the library shows."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.validation import validate_fmu
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import MODELS, variables
from structures import STRUCTURES

Packer = Callable[..., Path]


REFERENCE = {v.name: k for k, v in enumerate(variables("QuarterCar"))}


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_all_variables_of_the_model_are_there(fmi: int, native_fmu: Packer) -> None:
    """Energies, too."""
    declared = read_model_description(str(native_fmu("QuarterCar", fmi=fmi))).modelVariables
    found = {v.name for v in declared if v.name != "time" and v.type != "Clock"}
    assert found == {v.name for v in variables("QuarterCar")}
    assert {"kinetic_energy", "stored_energy", "dissipated_energy"} <= found


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


@pytest.mark.slow
@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic"])
def test_fmpy_has_no_complaint(model: str, native_fmu: Packer) -> None:
    assert validate_fmu(str(native_fmu(model, *STRUCTURES[model].settings.items()))) == []


def test_the_fmu_that_runs_python_gives_the_same_numbers(
    native_fmu: Packer, quarter_car_fmu: Path
) -> None:
    runs = [
        simulate_fmu(
            str(fmu), stop_time=0.5, output_interval=1e-3, start_values={"sprung_mass": 350.0}
        )
        for fmu in (native_fmu("QuarterCar"), quarter_car_fmu)
    ]
    assert len(runs[0].dtype.names) > 20
    for name in runs[0].dtype.names:  # those of both
        assert np.array_equal(runs[0][name], runs[1][name]), name


def test_the_library_shows_the_functions_of_fmi_alone(native_fmu: Packer, tmp_path: Path) -> None:
    if shutil.which("nm") is None:
        pytest.skip("no nm")
    folder = extract(str(native_fmu("QuarterCar")), str(tmp_path))
    (library,) = Path(folder, "binaries").rglob("QuarterCar.*")
    shown = subprocess.run(
        ["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True, check=True
    ).stdout.split()[2::3]
    assert len(shown) == 34
    assert all(name.startswith("fmi2") for name in shown)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("name", "value", "at_once", "why"),
    [
        ("sprung_mass", -5.0, False, "sprung_mass = -5: must be greater than 0 in kg"),
        ("payload", float("nan"), False, "payload = nan: must be finite and at least 0 in kg"),
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
def test_after_a_refused_step_no_output_looks_right(
    fmi: int, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
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


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("time", [0.0, 0.05, 0.2])
def test_a_step_that_is_repeated_or_left_out(
    fmi: int, time: float, native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    ok = [[v.name for v in variables("QuarterCar")].index("ok")]
    with slave(native_fmu("QuarterCar", fmi=fmi), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        one.doStep(0.0, 0.1)
        state = one.getFMUstate()
        with pytest.raises(Exception, match=r"status [23]"):
            one.doStep(time, 0.1)
        assert one.getBoolean(ok) == [False]
        one.setFMUstate(state)
        for k in range(1, 100):  # in single precision
            one.doStep(float(np.float32(k) * np.float32(0.1)), float(np.float32(0.1)))
        assert one.getBoolean(ok) == [True]
    said = capfd.readouterr().out
    assert f"the host steps from {time:g} s, but the FMU is at 0.1 s: step from there" in said


def test_a_state_keeps_a_refusal(
    native_fmu: Packer, slave: Any, tmp_path: Path, capfd: Any
) -> None:
    """So does that of an FMU that runs Python; a state from before the refusal can be continued."""
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
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


def test_short_steps_that_are_repeated_far_from_zero(
    native_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    """A host may count from 1970."""
    start = 1.7e9
    with slave(native_fmu("QuarterCar"), tmp_path) as one:
        one.setupExperiment(startTime=start)
        one.enterInitializationMode()
        one.exitInitializationMode()
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
            one.setupExperiment(startTime=start)
            one.enterInitializationMode()
            one.exitInitializationMode()
            one.setReal([force], [300.0])
            one.doStep(start, 0.1)
            for time, size in steps:
                one.doStep(time, size)
            one.setReal([rate], [900.0])
            one.doStep(now, 0.1)
            found += one.getReal([body])
    assert found[0] == found[1] != 0.0


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


@pytest.mark.slow
def test_what_is_fixed_is_declared_so(native_fmu: Packer) -> None:
    fmu = native_fmu("QuarterCar", ("friction", 50.0))
    found = {v.name: v for v in read_model_description(str(fmu)).modelVariables}
    assert found["friction"].start == "50.0"
    for without in ("bump_stop.stiffness", "damper.rebound_limit"):
        assert found[without].variability == "fixed"
        assert "chosen when the FMU was packed" in found[without].description
    assert found["friction"].variability == "tunable"
    assert found["spring.table"].variability == "fixed"
    assert found["tyre.stiffness"].variability == "tunable"
    for k, ours in enumerate(MODELS["QuarterCar"]):
        v = found[ours.name]
        assert (v.valueReference, v.causality) == (k, ours.causality)


def test_the_archive_has_all_that_it_is_made_of(native_fmu: Packer, tmp_path: Path) -> None:
    with zipfile.ZipFile(native_fmu("QuarterCar")) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path)
    page = (tmp_path / "documentation/index.html").read_text("utf-8")
    chosen = page[
        page.index("chosen when this FMU was packed") : page.index("fixed before the run")
    ]
    assert "<td>road.shape</td>" in chosen
    assert "<td>sprung_mass</td>" not in chosen
    assert {"sources/all.c", "sources/model.c", "sources/core.c", "sources/fmi2Functions.h",
            "documentation/index.html", "documentation/licenses/fmi_headers.txt", "model.png",
            "modelDescription.xml"} <= names  # fmt: skip
    licence = (tmp_path / "documentation/licenses/fmi_headers.txt").read_text()
    assert "Modelica Association" in licence
    assert "Redistributions in binary form" in licence
    text = (tmp_path / "sources/model.c").read_text()
    assert "static int Integrator__step(Integrator *self, double latest) {" in text
    assert "/* Add M^-1 times the impulses to v. */" in text
