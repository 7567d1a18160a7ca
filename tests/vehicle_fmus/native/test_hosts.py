"""Native FMUs in hosts of others: one in C, libcosim, Ecos; on other platforms; several at once."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.simulation import simulate_fmu
from hosting import MASTERS, comparable_outputs, difference, in_master, in_python
from phaseplane.suspension.models import FILES
from phaseplane.suspension.variables import variables
from phaseplane.vehicle_fmus.native import compilers, pack

Packer = Callable[..., Path]
HERE = Path(__file__).parent
STEP, STEPS = 2e-3, 300
AGREE = 1e-12  # of the peak: hosts add up their time in different ways


class CHost:
    """The host in `loading.c`, compiled, with one FMU unpacked."""

    def __init__(self, fmu: Path, program: list[str], work: Path, binaries: str) -> None:
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(work)
        described = read_model_description(str(work))
        (library,) = (work / "binaries" / binaries).iterdir()
        self.start = [*program, str(library), described.guid]
        self.outputs = comparable_outputs(described)

    def say(self, *words: object) -> str:
        done = subprocess.run(
            [*self.start, *map(str, words)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, (done.returncode, done.stderr)
        return done.stdout

    def rows(self) -> np.ndarray:
        """The outputs after every step."""
        text = self.say("run", STEPS, STEP, *(v.valueReference for v in self.outputs))
        return np.array([list(map(float.fromhex, line.split())) for line in text.splitlines()])


def compiled_host(folder: Path, command: list[str], name: str = "loading") -> str:
    program = folder / name
    subprocess.run(
        [*command, "-O1", "-w", f"-I{pack.HEADERS}", "-o", str(program), str(HERE / "loading.c"),
         *([] if name.endswith(".exe") else ["-ldl"])],
        check=True,
    )  # fmt: skip
    return str(program)


@pytest.fixture(scope="session")
def c_host(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path], CHost]:
    if not sys.platform.startswith("linux"):
        pytest.skip("the host is built for Linux, which is not on this platform")
    program = compiled_host(tmp_path_factory.mktemp("host"), ["cc"])
    return lambda fmu: CHost(fmu, [program], tmp_path_factory.mktemp("unpacked"), "linux64")


def in_fmpy(fmu: Path, names: list[str]) -> np.ndarray:
    result = simulate_fmu(
        str(fmu), stop_time=STEP * STEPS, output_interval=STEP, output=names, validate=False
    )
    return np.array([list(row)[1:] for row in result[1:]])


@pytest.mark.parametrize("model", ["QuarterCar", pytest.param("Road", marks=pytest.mark.slow)])
def test_a_host_in_c_sees_what_fmpy_sees(
    model: str, c_host: Callable[[Path], CHost], native_fmu: Packer
) -> None:
    host = c_host(native_fmu(model))
    theirs = in_fmpy(native_fmu(model), [v.name for v in host.outputs])
    assert difference(host.rows(), theirs).max() < AGREE


def test_a_host_in_c_is_refused_a_bad_value_and_goes_on(
    c_host: Callable[[Path], CHost], native_fmu: Packer
) -> None:
    host = c_host(native_fmu("QuarterCar"))
    assert host.say("refuse", 0, -5.0) == "3\n"  # fmi2Error
    assert host.say("refuse", 0, 300.0) == "0\n"


def test_ten_thousand_instances_leave_nothing_behind(
    c_host: Callable[[Path], CHost], native_fmu: Packer
) -> None:
    before, after = map(int, c_host(native_fmu("QuarterCar")).say("cycles", 10000).split())
    assert after == before > 0


@pytest.mark.slow
@pytest.mark.parametrize("master", MASTERS)
def test_other_masters_see_what_fmpy_sees(master: str, native_fmu: Packer, tmp_path: Path) -> None:
    jobs, expected = [], []
    for model in FILES:
        fmu = native_fmu(model)
        names = [v.name for v in comparable_outputs(read_model_description(str(fmu)))]
        jobs.append({"file": str(fmu), "step": STEP, "steps": STEPS, "start": {}, "outputs": names})
        expected.append(in_fmpy(fmu, names))
    for theirs, ours in zip(in_master(master, jobs, tmp_path), expected, strict=True):
        assert difference(theirs, ours).max() < AGREE


# -- other platforms -------------------------------------------------------------------------------

OTHERS = {
    "aarch64-linux": (["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"], 0.0),
    "x86_64-windows": (["wine64"], 1e-11),  # whose sine is another
}


@pytest.mark.slow
@pytest.mark.parametrize("platform", OTHERS)
def test_other_platforms_give_the_same_numbers(
    platform: str,
    c_host: Callable[[Path], CHost],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The library of each platform, by zig, in a host compiled for it, in an emulator or in wine."""
    command, allowed = OTHERS[platform]
    program = shutil.which(command[0], path=f"{sys.exec_prefix}/bin:/usr/bin:/usr/lib/wine")
    if program is None or not compilers.has_zig():
        pytest.skip(f"no {command[0]}, or no zig")
    monkeypatch.setenv("WINEPREFIX", str(tmp_path / "wine"))
    monkeypatch.setenv("WINEDEBUG", "-all")
    targets = [compilers.this_platform(), platform]
    (fmu,) = pack.build(["QuarterCar"], tmp_path, platforms=targets)
    target = compilers.PLATFORMS[platform]
    zig = [sys.executable, "-P", "-m", "ziglang", "cc", "-target", target.target]
    name = "loading.exe" if target.suffix == ".dll" else "loading"
    other = CHost(
        fmu, [program, *command[1:], compiled_host(tmp_path, zig, name)], tmp_path / "other",
        target.folder(2),
    )  # fmt: skip
    assert difference(other.rows(), c_host(fmu).rows()).max() <= allowed


@pytest.mark.slow
def test_files_for_all_platforms_are_packed(tmp_path: Path) -> None:
    if not compilers.has_zig():
        pytest.skip("no zig")
    (fmu,) = pack.build(["OneDof"], tmp_path, platforms=["all"])
    with zipfile.ZipFile(fmu) as archive:
        libraries = [archive.read(n)[:4] for n in archive.namelist() if n.startswith("binaries/")]
    elf, mach_o, windows = b"\x7fELF", b"\xcf\xfa\xed\xfe", b"MZ"
    kinds = [start[:2] if start.startswith(windows) else start for start in libraries]
    assert sorted(kinds) == sorted([elf, elf, mach_o, mach_o, windows])


# -- several in one process ------------------------------------------------------------------------

TOGETHER = """
import sys
from fmpy import extract, read_model_description
from fmpy.simulation import instantiate_fmu, simulate_fmu

def runs(files):
    made = []
    for file in files:
        folder = extract(file)
        described = read_model_description(folder)
        made.append((described, instantiate_fmu(folder, described, "CoSimulation")))
    for described, one in made:
        if described.fmiVersion == "2.0":
            one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
    for described, one in made:
        one.exitInitializationMode()
    rows = [[] for _ in made]
    for k in range(200):
        for (described, one), kept in zip(made, rows):
            one.doStep(k * 1e-3, 1e-3)
            get = one.getReal if described.fmiVersion == "2.0" else one.getFloat64
            kept.append(get([v.valueReference for v in described.modelVariables
                             if v.causality == "output" and v.type in ("Real", "Float64")][:12]))
    for described, one in reversed(made):
        one.terminate()
        one.freeInstance()
    return rows

files = sys.argv[1:]
together = runs(files)
assert all(together[k] == runs([file])[0] for k, file in enumerate(files))
print("undisturbed")
"""


@pytest.mark.slow
def test_fmus_of_all_kinds_do_not_disturb_each_other(
    native_fmu: Packer, python_fmu: Packer
) -> None:
    fmus = [native_fmu("QuarterCar"), native_fmu("Road"), native_fmu("QuarterCar", fmi=3),
            python_fmu("QuarterCar"), python_fmu("OneDof")]  # fmt: skip
    assert in_python(TOGETHER, *fmus).strip() == "undisturbed"


def test_the_c_is_named_like_its_source(native_fmu: Packer) -> None:
    """One function for one method, with its words; no names that nobody gave."""
    with zipfile.ZipFile(native_fmu("QuarterCar")) as archive:
        text = archive.read("sources/model.c").decode()
    functions = re.findall(r"^static (?:double|int|void|long long) (\w+)\([^;]*\{$", text, re.M)
    assert len(functions) == len(set(functions)) > 150
    assert {"Network_jerk", "Columns_iterate", "Integrator_sample"} & set(functions)
    names = [v.name for v in variables("QuarterCar") if v.causality == "output"]
    cases = [f"case V_{name.replace('.', '_').upper()}:" for name in names]
    assert all(case in text for case in cases)
    assert len(cases) > 20
