"""FMUs under test, packed once: native ones by the compiler at hand, and those that run Python."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from phaseplane.suspension.own_systems import file as system_file
from phaseplane.vehicle_fmus.build import build as build_in_python
from phaseplane.vehicle_fmus.native import compilers
from phaseplane.vehicle_fmus.native.pack import build
from structures import SANITIZED, SANITIZERS

Packer = Callable[..., Path]
# users compile the sources, too, with other compilers
STRICT = ("-O0", "-pedantic-errors", "-Wall", "-Wextra", "-Werror", "-Wno-unused")


@pytest.fixture(scope="session")
def compiler() -> str:
    """The path of the C compiler."""
    found = shutil.which("cc")
    if found is None:
        pytest.skip("no C compiler")
    return found


@pytest.fixture(scope="session")
def native_fmu(tmp_path_factory: pytest.TempPathFactory, compiler: str) -> Packer:
    """The function that packs a model, with settings as (name, value); not optimised, so sooner done."""

    @cache
    def packed(model: str, *settings: tuple[str, object], text: str = "", fmi: int = 2) -> Path:
        quick = tuple(flag for flag in compilers.FLAGS if flag != "-w") + STRICT
        if os.environ.get(SANITIZED):
            quick += SANITIZERS
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compilers, "FLAGS", quick)
            patch.setattr(compilers, "has_zig", lambda: False)
            pack = partial(build, fmi=fmi)
            return _packed(pack, model, settings, text, tmp_path_factory.mktemp("native"))

    return packed


@pytest.fixture
def functions_shown(tmp_path: Path) -> Callable[[Path], list[str]]:
    """The function that unpacks an FMU and lists what its library shows to a host, in order."""
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("no nm, which comes with most compilers")

    def shown(fmu: Path) -> list[str]:
        (library,) = Path(extract(str(fmu), str(tmp_path)), "binaries").rglob("QuarterCar.*")
        command = [nm, "-D", "--defined-only", str(library)]
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        return sorted(said.split()[2::3])

    return shown


@pytest.fixture(scope="session")
def python_fmu(tmp_path_factory: pytest.TempPathFactory) -> Packer:
    """The function that packs a model as an FMU that runs Python, with settings as (name, value)."""

    @cache
    def packed(model: str, *settings: tuple[str, object], text: str = "") -> Path:
        return _packed(build_in_python, model, settings, text, tmp_path_factory.mktemp("python"))

    return packed


def _packed(
    pack: Callable[..., list[Path]],
    model: str,
    settings: tuple[tuple[str, object], ...],
    text: str,
    folder: Path,
) -> Path:
    file = folder / "own.toml"
    if text:
        file.write_text(text, encoding="utf-8")
        system_file.load(text, checked=False)
    (path,) = pack(
        [model], folder, parameters={model: dict(settings)}, own={model: file} if text else {}
    )
    return path


class Fmi3(FMU3Slave):
    """An FMU of FMI 3.0 with the methods of one of FMI 2.0; with events, a step goes on from each."""

    def __init__(self, events: bool, **given: Any) -> None:
        super().__init__(**given)
        self.events = events
        self.getReal, self.getInteger = self.getFloat64, self.getInt32
        self.setReal, self.setInteger = self.setFloat64, self.setInt32
        self.serializeFMUstate, self.deSerializeFMUstate = (
            self.serializeFMUState, self.deserializeFMUState,
        )  # fmt: skip
        self.getFMUstate, self.setFMUstate = self.getFMUState, self.setFMUState
        self.instants: list[float] = []

    def instantiate(self, **options: Any) -> None:
        super().instantiate(eventModeUsed=self.events, earlyReturnAllowed=self.events, **options)

    def setupExperiment(self, startTime: float) -> None:  # noqa: N802
        self.start = startTime

    def enterInitializationMode(self) -> None:  # type: ignore[override] # noqa: N802
        super().enterInitializationMode(startTime=self.start)

    def exitInitializationMode(self) -> None:  # noqa: N802
        super().exitInitializationMode()
        if self.events:
            self.updateDiscreteStates()
            self.enterStepMode()

    def doStep(self, time: float, step: float) -> None:  # type: ignore[override] # noqa: N802
        end = time + step
        while True:
            event, over, early, time = super().doStep(time, end - time)
            assert not over
            assert early == (time < end)
            if event:
                self.instants.append(time)
                self.enterEventMode()
                assert not self.updateDiscreteStates()[0]
                self.enterStepMode()
            if not early:
                assert time == end
                return


@pytest.fixture
def slave() -> Callable[..., Any]:
    """The function that instantiates an FMU, unpacked into a folder, with the methods of FMI 2.0."""

    @contextmanager
    def instance(fmu: Path, work: Path, events: bool = False) -> Iterator[Any]:
        folder = extract(str(fmu), str(work))
        description = read_model_description(folder)
        kind = FMU2Slave if description.fmiVersion == "2.0" else partial(Fmi3, events)
        made = kind(
            guid=description.guid, unzipDirectory=folder, instanceName="one",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        made.instantiate()
        yield made
        made.freeInstance()

    return instance
