"""A process that has run FMUs ends with the status it means, whoever hosts them.

It says nothing, except why an FMU refused a value, if the host did not switch logging on.

As it is, pythonfmu's library writes into freed memory when a process exits: a few in a hundred abort,
all of them behind the fence of `fence.c`. Valgrind sees it, too.
"""

from __future__ import annotations

import re
import shutil
import signal
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import hosting
import pytest
from command_line import BARE, settings
from fmpy import extract, read_model_description
from hosting import MASTERS, compiled, fence, hosted, libpython
from phaseplane.scenarios.simulate.fmu_cache import FOLDER_VARIABLE
from phaseplane.suspension.models import FILES
from phaseplane.vehicle_fmus import build as packing
from phaseplane.vehicle_fmus.build import build

HERE = Path(__file__).parent
STATUS = 3  # what the hosts are told to end with
SIX = sorted(FILES, key=lambda model: model == "QuarterCar")  # the last is to refuse something
EVERY, SOME, NONE = len(SIX), 2, 0  # how many are freed
SAID = {"refused": r"([^\n]+ must be (greater than 0 kg|finite)\n)?"}

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="not on this platform: no ELF")


@pytest.fixture(scope="module")
def fenced(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The fence, to be preloaded."""
    return fence(tmp_path_factory.mktemp("fence"))


@pytest.fixture(scope="module")
def unmended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU with pythonfmu's library as it is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(packing, "ended_once", lambda library: library)
        return build(["QuarterCar"], tmp_path_factory.mktemp("unmended"))[0]


@pytest.fixture(scope="module")
def in_c(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., tuple[int, str]]:
    """Run FMUs in the plain C host."""
    program = compiled(HERE / "ending.c", tmp_path_factory.mktemp("host") / "host")

    def run(
        ending: str, freed: int, folders: Sequence[str], *preloaded: Path, under: Sequence[str] = ()
    ) -> tuple[int, str]:
        given = [ending, str(freed), str(STATUS)]
        for folder in folders:
            about = read_model_description(folder)
            library = Path(folder, "binaries", "linux64", f"{about.modelName}.so")
            given += [str(library), about.guid, Path(folder, "resources").as_uri()]
        environment = {
            "LD_PRELOAD": " ".join(map(str, [libpython(), *preloaded])),
            "PYTHONHOME": sys.base_prefix,
            "PYTHONMALLOC": "malloc" if under else "default",  # every block is seen
        }
        waits = ending in ("interrupted", "killed")
        return hosted([*under, program, *given], environment, "waiting" if waits else "")

    return run


def in_python(
    host: str, ending: str, freed: int, fmus: Sequence[Path], scratch: Path, *preloaded: Path
) -> tuple[int, str]:
    """Run FMUs in a host that is a Python program."""
    command = [sys.executable, "-P", HERE / "ending.py", host, ending, freed, STATUS, *fmus]
    environment = {"LD_PRELOAD": " ".join(map(str, preloaded)), "TMPDIR": str(scratch)}
    return hosted(command, environment, "waiting" if ending == "interrupted" else "")


# -- every host, watched -----------------------------------------------------------------------------


@pytest.mark.slow
def test_the_fence_finds_what_is_mended(
    in_c: Any, fenced: Path, unmended: Path, quarter_car_folder: str, tmp_path: Path
) -> None:
    faulty = extract(str(unmended), str(tmp_path))
    for freed in (0, 1):
        assert in_c("done", freed, [faulty], fenced) == (-signal.SIGSEGV, "")
        assert in_c("done", freed, [quarter_car_folder], fenced) == (STATUS, "")


@pytest.mark.slow
@pytest.mark.parametrize("host", ["fmpy", *MASTERS])
def test_the_fence_finds_it_in_every_host(
    host: str, fenced: Path, unmended: Path, tmp_path: Path
) -> None:
    assert in_python(host, "done", 1, [unmended], tmp_path, fenced) == (-signal.SIGSEGV, "")


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["done", "refused", "interrupted", "killed"])
def test_a_host_in_c(ending: str, in_c: Any, fenced: Path, folders: dict[str, str]) -> None:
    meant = -signal.SIGINT if ending == "killed" else STATUS
    for models in (SIX, ["QuarterCar"]):
        for freed in {NONE, SOME, EVERY} if models is SIX else {NONE}:
            if ending == "refused" and freed == EVERY:
                continue  # FMI forbids it for the one that failed
            status, said = in_c(ending, freed, [folders[model] for model in models], fenced)
            assert status == meant, (models, freed)
            assert re.fullmatch(SAID.get(ending, ""), said), (models, freed)


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["done", "refused", "interrupted"])
@pytest.mark.parametrize("host", ["fmpy", *MASTERS])
def test_a_host_in_python(
    host: str, ending: str, fenced: Path, fmus: dict[str, Path], tmp_path: Path
) -> None:
    for models in (SIX, ["QuarterCar"]):
        # libcosim and Ecos free all or none
        for freed in {NONE, SOME, EVERY} if (host, models) == ("fmpy", SIX) else {NONE, EVERY}:
            if (host, ending, freed) == ("fmpy", "refused", EVERY):
                continue  # FMI forbids it for the one that failed
            files = [fmus[model] for model in models]
            status, said = in_python(host, ending, freed, files, tmp_path, fenced)
            assert status == STATUS, (models, freed)
            assert re.fullmatch(SAID.get(ending, ""), said), (models, freed)


@pytest.mark.slow
def test_valgrind_finds_no_invalid_access(
    in_c: Any, unmended: Path, folders: dict[str, str], tmp_path: Path
) -> None:
    if shutil.which("valgrind") is None:
        pytest.skip("no valgrind")
    found = 99
    under = ["valgrind", "-q", "--undef-value-errors=no", f"--error-exitcode={found}"]
    six = [folders[model] for model in SIX]
    assert in_c("done", SOME, six, under=under) == (STATUS, "")
    status, said = in_c("done", NONE, [extract(str(unmended), str(tmp_path))], under=under)
    assert status == found
    assert "Invalid read" in said
    assert "finalizePythonInterpreter" in said


# -- as it is used -----------------------------------------------------------------------------------

COMMAND = [sys.executable, "-P", "-m", "phaseplane", "run", "ap57"]


@pytest.mark.slow
@pytest.mark.parametrize(("lift_offs", "meant"), [(1, 0), (2, 1)])
def test_a_scene_whose_fmu_is_not_mended(
    lift_offs: int, meant: int, fenced: Path, unmended: Path, tmp_path: Path
) -> None:
    given = settings(f"fmu={unmended}", f"expect.lift_off_count={lift_offs}")
    status, said = hosted(
        [*COMMAND, *BARE, *given, "-o", tmp_path / "out"], {"LD_PRELOAD": str(fenced)}
    )
    assert (status, len(said.splitlines())) == (meant, meant), said


@pytest.mark.slow
def test_one_process_after_another(fmus: dict[str, Path], tmp_path: Path) -> None:
    """The main job and six FMUs, many times, two at a time."""
    kept = {FOLDER_VARIABLE: str(tmp_path / "kept")}

    def main_job(k: int) -> tuple[int, str]:
        return hosted([*COMMAND, "-o", tmp_path / f"out {k}"], kept)

    def six(k: int) -> tuple[int, str]:
        scratch = tmp_path / f"six {k}"
        scratch.mkdir()
        return in_python("fmpy", "done", k % EVERY, [fmus[model] for model in SIX], scratch)

    with ThreadPoolExecutor(2) as two:
        ends = [*two.map(main_job, range(20)), *two.map(six, range(20))]
    assert ends == [(0, "")] * 20 + [(STATUS, "")] * 20


_AFTER_OURS = """
import gc, sys
import phaseplane
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

phaseplane.run("ap57", through="fmu", duration=0.05)
gc.collect()
folder = extract(sys.argv[1])
described = read_model_description(folder)
identity = dict(guid=described.guid, modelIdentifier="QuarterCar", instanceName="own")
own = FMU2Slave(unzipDirectory=folder, **identity)
own.instantiate(loggingOn=True)
own.setupExperiment(startTime=0.0)
mass = [v.valueReference for v in described.modelVariables if v.name == "sprung_mass"]
own.setReal(mass, [-5.0])
own.enterInitializationMode()
try:
    own.exitInitializationMode()
except Exception:
    print("refused")
"""


@pytest.mark.slow
def test_another_fmu_tells_fmpy_what_is_wrong_after_a_run_of_ours(quarter_car_fmu: Path) -> None:
    """FMPy gives the messages of all FMUs to the function that was given last: it must not be freed."""
    said = hosting.in_python(_AFTER_OURS, quarter_car_fmu)
    assert "sprung_mass = -5: must be greater than 0 kg" in said
    assert said.splitlines()[-1] == "refused"
