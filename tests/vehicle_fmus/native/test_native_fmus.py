"""Native FMUs in FMPy: the bits of a session, refusals, states, and what the library shows."""

from __future__ import annotations

import ctypes
import json
import random
import shutil
import subprocess
import zipfile
from collections.abc import Callable, Collection
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import MODELS, Variable, variables

Packer = Callable[..., Path]
GETTERS = {float: "getReal", int: "getInteger", bool: "getBoolean"}
KEPT = ("solver.theta", "initial.displacement", "initial.permanent_set", "pitch_radius_of_gyration")


@contextmanager
def slave(fmu: Path, model: str, work: Path) -> Any:
    folder = extract(str(fmu), str(work))
    description = read_model_description(folder)
    made = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=model, instanceName="native"
    )
    made.instantiate()
    yield made
    made.freeInstance()


def described(fmu: Path) -> dict[str, Any]:
    """The variables that the FMU has and that are not fixed by its packing, by name."""
    found = read_model_description(str(fmu)).modelVariables
    return {v.name: v for v in found if "chosen when the FMU was packed" not in v.description}


def drawn_values(model: str, free: Collection[str], drawn: random.Random) -> dict[str, float]:
    """Values of numbers that leave the structure as it is: none but what is there is changed."""
    found = {}
    for v in variables(model):
        if v.causality != "parameter" or v.name in KEPT or v.name not in free:
            continue
        assert isinstance(v.start, float)
        if v.start != 0.0 and drawn.random() < 0.5:
            found[v.name] = v.start * drawn.uniform(0.7, 1.4)
        elif v.name.startswith("initial.") and drawn.random() < 0.3:
            found[v.name] = drawn.gauss(0.0, 0.01)
        elif v.name == "road.start" and drawn.random() < 0.3:
            found[v.name] = drawn.uniform(0.0, 0.2)
    return found


def drawn_input(v: Variable, drawn: random.Random) -> float:
    if v.name == "force":
        return drawn.gauss(0.0, 3.0)
    return drawn.gauss(0.0, 300.0 if v.name.endswith("force") else 0.02)


def same_bits(fmu: Path, model: str, settings: dict[str, Any], seed: int, work: Path) -> None:
    """Drive both alike, with inputs, tuned parameters and a return, and compare all outputs."""
    drawn = random.Random(f"{model} {seed}")
    free = described(fmu)
    values = drawn_values(model, free, drawn)
    start = drawn.choice([0.0, 0.0, 0.25])
    session = Session(model, {**settings, **values}, start)
    declared = variables(model)
    reference = {v.name: k for k, v in enumerate(declared)}
    outputs = [v for v in declared if v.causality == "output" and v.name in free]
    inputs = [v for v in declared if v.causality == "input"]
    tunable = [v for v in declared if v.tunable and v.name in free and v.start > 0.0]  # type: ignore[operator]
    feeds = drawn.random() < 0.6
    with slave(fmu, model, work) as one:

        def feed() -> None:
            for v in inputs if feeds else ():
                if drawn.random() < 0.4:
                    value = drawn_input(v, drawn)
                    session.set_input(v.name, value)
                    one.setReal([reference[v.name]], [value])

        def compare(time: float) -> None:
            for v in outputs:
                (found,) = getattr(one, GETTERS[type(v.start)])([reference[v.name]])
                wanted = session.value(v.name)
                assert float(found).hex() == float(wanted).hex(), (time, v.name)  # NaN, too

        one.setupExperiment(startTime=start)
        for name, value in values.items():
            one.setReal([reference[name]], [value])
        feed()
        session.advance(start)
        one.enterInitializationMode()
        one.exitInitializationMode()
        compare(start)
        time, kept = start, None
        for k in range(30):
            feed()
            if tunable and drawn.random() < 0.08:
                v = drawn.choice(tunable)
                value = values.get(v.name, v.start) * drawn.uniform(0.8, 1.2)
                session.set_parameter(v.name, value)
                one.setReal([reference[v.name]], [value])
            if k == 8:
                kept = (time, session.snapshot(), one.serializeFMUstate(one.getFMUState()))
            if k == 20 and kept and json.loads(kept[1])["parameters"] == session.parameters:
                time = kept[0]
                session.restore(kept[1])
                one.setFMUState(one.deSerializeFMUstate(kept[2]))
            step = drawn.choice([1e-3, 5e-3, 2e-2])
            session.advance(time + step)
            one.doStep(time, step)
            time += step
            compare(time)


STRUCTURES: dict[str, tuple[str, dict[str, Any]]] = {
    "OneDof": ("OneDof", {"road.shape": "input"}),
    "QuarterCar": ("QuarterCar", {}),
    "with stops, friction and a sampled road": (
        "QuarterCar",
        {"road.shape": "input", "bump_stop.stiffness": 2e5, "bump_stop.gap": 0.03, "friction": 40.0},
    ),
    "curved, on a random road": (
        "QuarterCar",
        {"road.shape": "random", "road.profile_length": 30.0, "spring.cubic": 1e6,
         "damper.saturation_force": 800.0},
    ),
    "HalfCarRigidTyres": ("HalfCarRigidTyres", {"road.shape": "sine"}),
    "HalfCar": ("HalfCar", {}),
    "Elastoplastic": ("Elastoplastic", {"hardening": 500.0}),
}  # fmt: skip
QUICK = ("QuarterCar", "with stops, friction and a sampled road", "Elastoplastic")


@pytest.mark.parametrize("what", QUICK)
def test_an_fmu_has_the_bits_of_a_session(what: str, native_fmu: Packer, tmp_path: Path) -> None:
    model, settings = STRUCTURES[what]
    fmu = native_fmu(model, *settings.items())
    for seed in range(8):
        same_bits(fmu, model, settings, seed, tmp_path / str(seed))


@pytest.mark.slow
@pytest.mark.parametrize("what", STRUCTURES)
def test_many_drawn_runs_have_the_bits_of_a_session(
    what: str, native_fmu: Packer, tmp_path: Path
) -> None:
    model, settings = STRUCTURES[what]
    fmu = native_fmu(model, *settings.items())
    for seed in range(100, 130):
        same_bits(fmu, model, settings, seed, tmp_path / str(seed))


@pytest.mark.parametrize("what", ["QuarterCar", "Elastoplastic"])
def test_outputs_have_derivatives(what: str, native_fmu: Packer, tmp_path: Path) -> None:
    """Against differences of the outputs on both sides, within one step of the integrator."""
    model, settings = STRUCTURES[what]
    fmu = native_fmu(model, *settings.items())
    outputs = [v for v in described(fmu).values() if v.causality == "output" and v.type == "Real"]
    references, h = [v.valueReference for v in outputs], 1e-6
    with slave(fmu, model, tmp_path) as one:

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


@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic"])
def test_fmpy_has_no_complaint(model: str, native_fmu: Packer) -> None:
    assert validate_fmu(str(native_fmu(model, *STRUCTURES[model][1].items()))) == []


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


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("sprung_mass", -5.0, "sprung_mass = -5: must be greater than 0 in kg"),
        ("sprung_mass", float("nan"), "sprung_mass = nan: must be"),
        ("friction", 50.0, "friction: the structure with which this FMU was packed"),
        ("lift_off", False, "lift_off = 0: this FMU was packed for lift_off = 1"),
        ("road.shape", "sine", "road.shape = 'sine': this FMU was packed for 'bump'"),
    ],
)
def test_what_it_cannot_have_is_refused_in_words(
    name: str, value: Any, why: str, native_fmu: Packer, tmp_path: Path, capfd: Any
) -> None:
    k = [v.name for v in variables("QuarterCar")].index(name)
    with slave(native_fmu("QuarterCar"), "QuarterCar", tmp_path) as one:
        one.setupExperiment(startTime=0.0)
        {float: one.setReal, bool: one.setBoolean, str: one.setString}[type(value)]([k], [value])
        one.enterInitializationMode()
        with pytest.raises(Exception, match="status 3"):
            one.exitInitializationMode()
    assert why in capfd.readouterr().out


def test_what_is_fixed_is_declared_so(native_fmu: Packer) -> None:
    fmu = native_fmu("QuarterCar", ("friction", 50.0))
    found = {v.name: v for v in read_model_description(str(fmu)).modelVariables}
    assert found["friction"].start == "50.0"
    assert found["friction"].variability == "tunable"
    assert found["spring.table"].variability == "fixed"
    assert found["tyre.stiffness"].variability == "tunable"
    for k, ours in enumerate(MODELS["QuarterCar"]):
        if ours.name in found:
            v = found[ours.name]
            assert (v.valueReference, v.causality) == (k, ours.causality)
    # what Python reads from the ledger is all that is left out
    missing = {v.name for v in MODELS["QuarterCar"]} - found.keys()
    assert missing
    assert all(name.endswith("_energy") for name in missing), missing


def test_the_archive_has_all_that_it_is_made_of(native_fmu: Packer, tmp_path: Path) -> None:
    with zipfile.ZipFile(native_fmu("QuarterCar")) as archive:
        names = set(archive.namelist())
        archive.extractall(tmp_path)
    assert {"sources/all.c", "sources/model.c", "sources/core.c", "sources/fmi2Functions.h",
            "documentation/index.html", "documentation/licenses/fmi_headers.txt", "model.png",
            "modelDescription.xml"} <= names  # fmt: skip
    licence = (tmp_path / "documentation/licenses/fmi_headers.txt").read_text()
    assert "Modelica Association" in licence
    assert "Redistributions in binary form" in licence
    text = (tmp_path / "sources/model.c").read_text()
    assert "static int Integrator__step(Integrator *self, double latest) {" in text
    assert "/* Add M^-1 times the impulses in `scratch` to v. */" in text


@pytest.mark.slow
@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic"])
def test_sanitizers_find_nothing(model: str, native_fmu: Packer, tmp_path: Path) -> None:
    """The sources inside, compiled with a host in C."""
    with zipfile.ZipFile(native_fmu(model, *STRUCTURES[model][1].items())) as archive:
        archive.extractall(tmp_path)
    host = tmp_path / "host"
    built = subprocess.run(
        ["cc", "-g", "-O1", "-w", "-fsanitize=address,undefined", "-fno-sanitize-recover=all",
         "-ffp-contract=off", f"-I{tmp_path / 'sources'}", "-o", str(host),
         str(Path(__file__).parent / "host.c"), str(tmp_path / "sources" / "all.c"), "-lm"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if "cannot find" in built.stderr:
        pytest.skip("no sanitizers")
    assert built.returncode == 0, built.stderr
    first = next(
        k for k, v in enumerate(variables(model)) if v.name.endswith("displacement")
        and v.causality == "output"
    )  # fmt: skip
    guid = read_model_description(str(tmp_path)).guid
    done = subprocess.run(
        [str(host), guid, str(first)], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
