"""How FMUs are packed: what is inside, under which names, and what runs where it does not fit."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any

import pytest
from fmpy import extract, read_model_description
from hosting import in_python
from phaseplane.suspension import engine
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import MODELS, ParameterError, variables
from phaseplane.vehicle_fmus import build as builder
from phaseplane.vehicle_fmus import content
from phaseplane.vehicle_fmus.build import build

OUTPUTS = ("body_displacement", "contact_force", "step_count")


def guid(fmu: Path) -> str:
    return str(read_model_description(str(fmu)).guid)


@pytest.fixture
def changed_fmu(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same FMU, packed from sources in which the kernel and a model differ."""
    sources = shutil.copytree(content.SUSPENSION, tmp_path / "sources")
    errors, parts = sources / "kernel" / "motion" / "errors.py", sources / "parts.py"
    shorter_steps = errors.read_text().replace("_SHARE = 0.1", "_SHARE = 0.001")
    heavier = parts.read_text().replace(
        'number(p, "sprung_mass")', '2.0 * number(p, "sprung_mass")'
    )
    assert shorter_steps != errors.read_text()
    assert heavier != parts.read_text()
    errors.write_text(shorter_steps)
    parts.write_text(heavier)
    monkeypatch.setattr(content, "SUSPENSION", sources)
    return build(["QuarterCar"], tmp_path)[0]


# -- archive ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_equal_content_gives_equal_files(quarter_car_fmu: Path, tmp_path: Path) -> None:
    before = (list(sys.path), set(sys.modules))
    (again,) = build(["QuarterCar"], tmp_path / "new" / "folder")
    assert again.read_bytes() == quarter_car_fmu.read_bytes()
    assert (list(sys.path), set(sys.modules)) == before
    assert list(again.parent.iterdir()) == [again]


def test_other_start_values_give_another_guid(quarter_car_fmu: Path, tmp_path: Path) -> None:
    (heavier,) = build(
        ["QuarterCar"], tmp_path, parameters={"QuarterCar": {"sprung_mass": "0.3 t"}}
    )
    assert guid(heavier) != guid(quarter_car_fmu)


@pytest.mark.slow
def test_other_sources_give_another_guid(quarter_car_fmu: Path, changed_fmu: Path) -> None:
    assert guid(changed_fmu) != guid(quarter_car_fmu)


@pytest.mark.slow
def test_the_date_comes_from_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    (fmu,) = build(["QuarterCar"], tmp_path)
    assert read_model_description(str(fmu)).generationDateAndTime == "1970-01-02T00:00:00Z"


def test_what_an_fmu_holds(model: str, fmus: dict[str, Path]) -> None:
    with zipfile.ZipFile(fmus[model]) as archive:
        names = archive.namelist()
        page = archive.read("documentation/index.html").decode()
        licence = archive.read("documentation/licenses/license.txt").decode()
        assert archive.read("model.png").startswith(b"\x89PNG")
        assert b"libpython" in archive.read("documentation/externalDependencies.txt")
        own = [n for n in names if n.startswith("resources/") and "/pythonfmu/" not in n]
        texts = {n: archive.read(n).decode() for n in own if not n.endswith((".so", ".pyd"))}
    assert all(f"<td>{variable.name}</td>" in page for variable in variables(model))
    assert "<svg" in page
    assert "$" not in page
    assert "NTNU" in licence
    assert "The phaseplane developers" in licence
    assert {Path(n).suffix for n in own} <= {".py", ".json", ".txt", ".so", ".pyd"}
    assert not [n for n, text in texts.items() if str(Path.cwd()) in text or "__pycache__" in n]


def test_an_fmu_holds_no_place_of_this_machine(model: str, fmus: dict[str, Path]) -> None:
    """Neither of the sources nor of the Python that compiled them, which linkers note to look in."""
    python = sysconfig.get_config_var("LIBDIR") or sys.base_prefix
    places = [os.fsencode(place) for place in (content.SUSPENSION.parents[1], python)]
    with zipfile.ZipFile(fmus[model]) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    assert [name for name, data in held.items() if any(place in data for place in places)] == []


@pytest.mark.slow
def test_start_values_are_burned_in(tmp_path: Path, host: Any) -> None:
    given = {"sprung_mass": "300 kg", "lift_off": False, "road.shape": "sine"}
    (fmu,) = build(["QuarterCar"], tmp_path, parameters={"QuarterCar": given})
    shown = {v.name: v.start for v in read_model_description(str(fmu)).modelVariables}
    assert (shown["sprung_mass"], shown["lift_off"], shown["road.shape"]) == (
        "300.0", "false", "sine",
    )  # fmt: skip
    car = host(extract(str(fmu), unzipdir=str(tmp_path / "fmu")))
    with car.instance():
        car.start()
        assert (car.get("sprung_mass"), car.get("lift_off")) == (300.0, False)
        car.step(0.0, 0.1)
        found = [car.get(name) for name in OUTPUTS]
    meant = {"sprung_mass": 300.0, "lift_off": False, "road.shape": "sine"}
    direct = simulate("QuarterCar", meant, [0.0, 0.1], OUTPUTS)
    assert found == [direct[name][-1] for name in OUTPUTS]


# -- refusals --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("models", "parameters", "words"),
    [
        (["QuarterCar", "QuaterCar"], None, "did you mean 'QuarterCar'"),
        (["Tractor"], None, "FMUs exist for OneDof, .*, Road, not for 'Tractor'"),
        (["QuarterCar"], {"HalfCar": {}}, "HalfCar"),
        (["QuarterCar"], {"QuarterCar": {"spring.rte": 1.0}}, "did you mean 'spring.rate'"),
        (["QuarterCar"], {"QuarterCar": {"speed": -1.0}}, "speed = -1: must be greater than 0"),
        (["QuarterCar"], {"QuarterCar": {"spring.table": "1:1"}}, "spring.table"),
    ],
)
def test_nothing_is_written_where_something_is_wrong(
    tmp_path: Path, models: list[str], parameters: Any, words: str
) -> None:
    with pytest.raises(ParameterError, match=words):
        build(models, tmp_path / "out", parameters=parameters)
    assert not (tmp_path / "out").exists()


def test_a_failing_builder_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = tmp_path / "QuarterCar.fmu"
    old.write_bytes(b"old")
    sources = shutil.copytree(content.SUSPENSION, tmp_path / "sources")
    (sources / "session.py").write_text("raise ImportError('no such session')")
    monkeypatch.setattr(content, "SUSPENSION", sources)
    with pytest.raises(RuntimeError, match=r"QuarterCar\.fmu:[^$]*no such session"):
        build(["QuarterCar"], tmp_path)
    assert old.read_bytes() == b"old"
    assert sorted(tmp_path.iterdir()) == [old, sources]


# -- several versions in one process ---------------------------------------------------------------


@pytest.mark.slow
def test_each_fmu_runs_its_own_code(
    quarter_car_folder: str, changed_fmu: Path, tmp_path: Path, host: Any
) -> None:
    installed = {name: sys.modules[name] for name in sys.modules if "suspension" in name}
    direct = simulate("QuarterCar", {}, [0.0, 0.1], OUTPUTS)
    expected = [direct[name][-1] for name in OUTPUTS]
    original, changed = host(quarter_car_folder), host(extract(str(changed_fmu), str(tmp_path)))
    found: dict[str, list[Any]] = {}
    with changed.instance(), original.instance():
        for car in (changed, original):
            car.start()
        for car in (original, changed):
            car.step(0.0, 0.05)
        for name, car in (("changed", changed), ("original", original)):
            car.step(0.05, 0.1)
            found[name] = [car.get(output) for output in OUTPUTS]
    assert found["original"] == expected
    twice = {"sprung_mass": 2.0 * float(MODELS["QuarterCar"][0].start)}
    heavier = simulate("QuarterCar", twice, [0.0, 0.1], OUTPUTS)
    assert found["changed"][0] == pytest.approx(heavier["body_displacement"][-1], rel=1e-4)
    assert found["changed"][0] != pytest.approx(expected[0], rel=1e-4)
    assert found["changed"][2] > 1.2 * expected[2]  # steps of a tenth where the phase limits them
    after = {name: sys.modules[name] for name in sys.modules if "suspension" in name}
    assert all(after[name] is module for name, module in installed.items())
    again = simulate("QuarterCar", {}, [0.0, 0.1], OUTPUTS)
    assert again == direct


_ONE_AFTER_ANOTHER = """
import shutil, sys
from fmpy import read_model_description
from fmpy.simulation import instantiate_fmu
for folder in sys.argv[1:]:
    description = read_model_description(folder)
    fmu = instantiate_fmu(folder, description, "CoSimulation")
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rates = [v.valueReference for v in description.modelVariables if "bound_rate" in v.name]
    for step in range(40):  # parameters that change often have their laws recorded
        for rate in rates:
            fmu.setReal([rate], [1000.0 + step])
        fmu.doStep(0.01 * step, 0.01)
    fmu.freeInstance()
    shutil.rmtree(folder)
print("all ran" if any(name.endswith(".trace") for name in sys.modules) else "nothing was recorded")
"""


@pytest.mark.slow
@pytest.mark.parametrize("first", ["OneDof", "Road"])
def test_an_fmu_does_not_need_the_folder_of_another(
    first: str, folders: dict[str, str], tmp_path: Path
) -> None:
    order = sorted(folders, key=lambda model: model != first)
    copies = [str(shutil.copytree(folders[model], tmp_path / model)) for model in order]
    assert in_python(_ONE_AFTER_ANOTHER, *copies) == "all ran\n"


# -- other hosts -----------------------------------------------------------------------------------

_BARE_HOST = """
import json, sys
resources = sys.argv[1]
sys.path.insert(0, resources)
name = open(resources + "/slavemodule.txt").read().strip()
slave = __import__(name).QuarterCar(instance_name="car", resources=resources)
slave.setup_experiment(0.0, None, None)
slave.exit_initialization_mode()
steps = [slave.do_step(0.02 * k, 0.02) for k in range(10)]
getters = {float: slave.get_real, int: slave.get_integer, bool: slave.get_boolean}
kinds = {name: type(start) for name, start in slave._starts.items()}
values = [getters[kinds[name]]([slave._names.index(name)])[0] for name in sys.argv[2:]]
folders = {getattr(m, "__file__", None) or "" for m in sys.modules.values()}
print(json.dumps({
    "steps": steps, "values": values, "log": [message.msg for message in slave.log_queue],
    "foreign": sorted(f for f in folders if "site-packages" in f),
    "paths": sys.path, "modules": sorted(sys.modules),
}))
"""


_IMPORTS_LATE = """
    def exit_initialization_mode(self) -> None:
        if self.model:
            from phaseplane.suspension import engine
            from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave as base
        super().exit_initialization_mode()
        self.log("imported: " + engine.__name__.rsplit("_", 1)[0])
        self.log("imported: " + base.__module__.rsplit("_", 1)[0])
"""


def run_in_a_bare_python(folder: Path, python: str = sys.executable) -> dict[str, Any]:
    """Step the FMU's code in a Python that has nothing but its standard library."""
    done = subprocess.run(
        [python, "-I", "-S", "-B", "-c", _BARE_HOST, str(folder / "resources"), *OUTPUTS],
        capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": ""},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.fixture
def bare_folder(quarter_car_folder: str, tmp_path: Path) -> Path:
    return Path(shutil.copytree(quarter_car_folder, tmp_path / "fmu"))


@pytest.mark.slow
def test_what_a_slave_imports_within_a_function_is_carried_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, expected: list[Any]
) -> None:
    monkeypatch.setattr(builder, "_SCRIPT", builder._SCRIPT + _IMPORTS_LATE)
    (fmu,) = build(["QuarterCar"], tmp_path)
    told = run_in_a_bare_python(Path(extract(str(fmu), str(tmp_path / "fmu"))))
    assert told["values"] == pytest.approx(expected, rel=1e-12)
    assert {"imported: suspension", "imported: vehicle_slave"} <= set(told["log"])
    assert not {"phaseplane", "suspension"} & set(told["modules"])


def binaries_of(folder: Path) -> Path:
    (kernel,) = (folder / "resources").glob("suspension_*/kernel")
    return Path(kernel, engine.kernel_name())


@pytest.fixture
def expected() -> list[Any]:
    times = [0.02 * k for k in range(11)]
    direct = simulate("QuarterCar", {}, times, OUTPUTS)
    return [direct[name][-1] for name in OUTPUTS]


def test_the_standard_library_is_enough(bare_folder: Path, expected: list[Any]) -> None:
    told = run_in_a_bare_python(bare_folder)
    assert told["steps"] == [True] * 10
    assert told["values"] == pytest.approx(expected, rel=1e-12)
    assert told["foreign"] == []
    assert not any(path == str(bare_folder / "resources") for path in told["paths"])
    assert not {"suspension", "vehicle_fmus", "cython", "numpy"} & set(told["modules"])
    assert any("uncompiled" in text for text in told["log"]) != engine.compiled


@pytest.mark.slow
def test_without_binaries_the_sources_run(bare_folder: Path) -> None:
    as_packed = run_in_a_bare_python(bare_folder)
    shutil.rmtree(binaries_of(bare_folder), ignore_errors=True)
    uncompiled = run_in_a_bare_python(bare_folder)
    assert uncompiled["values"] == as_packed["values"]
    assert any("uncompiled" in text for text in uncompiled["log"])


@pytest.mark.slow
def test_with_broken_binaries_the_sources_run(bare_folder: Path) -> None:
    as_packed = run_in_a_bare_python(bare_folder)
    binaries = binaries_of(bare_folder)
    binaries.mkdir(exist_ok=True)
    for suffix in EXTENSION_SUFFIXES:
        Path(binaries, "interface" + suffix).write_bytes(b"of another machine")
    broken = run_in_a_bare_python(bare_folder)
    assert broken["values"] == as_packed["values"]
    assert any("uncompiled" in text and "cannot be loaded" in text for text in broken["log"])


@pytest.mark.slow
def test_binaries_for_another_python_are_passed_over(bare_folder: Path) -> None:
    as_packed = run_in_a_bare_python(bare_folder)
    for file in list(binaries_of(bare_folder).glob("*.*")):
        file.rename(file.with_name("interface.cpython-399-x.so"))
    elsewhere = run_in_a_bare_python(bare_folder)
    assert elsewhere["values"] == as_packed["values"]
    assert any("uncompiled" in text for text in elsewhere["log"])


def _runs(python: str) -> bool:
    done = subprocess.run([python, "--version"], capture_output=True, check=False)
    return done.returncode == 0


def other_pythons() -> list[str]:
    """Interpreters on the path that have not built the FMU and do run."""
    names = (f"python3.{minor}" for minor in range(11, 16) if minor != sys.version_info.minor)
    found = [path for name in names if (path := shutil.which(name))]
    return [p for p in found if _runs(p)]


def test_another_python_runs_it(bare_folder: Path) -> None:
    """Compiled, too, if it was compiled here: the kernel's binary is for every CPython from 3.11 on."""
    pythons = other_pythons()
    if not pythons:
        pytest.skip("not on this platform: no other Python 3.11 or newer on the path")
    here = run_in_a_bare_python(bare_folder)
    for python in pythons:
        told = run_in_a_bare_python(bare_folder, python)
        assert told["values"] == here["values"]
        assert any("uncompiled" in text for text in told["log"]) != engine.compiled
