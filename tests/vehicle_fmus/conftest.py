"""The FMUs under test, packed once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import byref
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, printLogMessage
from fmpy.logging import addLoggerProxy
from fmpy.simulation import instantiate_fmu
from phaseplane.suspension.models import FILES
from phaseplane.vehicle_fmus.build import build

_PRINTING = fmi2CallbackFunctions()


@pytest.fixture(autouse=True)
def _messages_are_printed() -> None:
    """FMPy passes messages to the callbacks that any FMU of the process was given last, freed or not."""
    _PRINTING.logger = fmi2CallbackLoggerTYPE(printLogMessage)
    addLoggerProxy(byref(_PRINTING))


class Host:
    """A host that drives one extracted FMU by variable names."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.description = read_model_description(folder)
        self._references = {v.name: v.valueReference for v in self.description.modelVariables}
        self._types = {v.name: v.type for v in self.description.modelVariables}
        self.log: list[tuple[int, str, str]] = []  # status, category, text
        self.fmu: Any = None

    @contextmanager
    def instance(self) -> Iterator[Host]:
        self.log = []
        self.fmu = instantiate_fmu(
            self.folder, self.description, "CoSimulation", debug_logging=True, logger=self._note
        )
        yield self
        self.fmu.freeInstance()  # not after a failure: FMI forbids it, and FMPy does not do it

    def _note(self, _env: Any, _name: bytes, status: int, category: bytes, text: bytes) -> None:
        self.log.append((status, (category or b"").decode(), text.decode()))

    @property
    def texts(self) -> str:
        return "\n".join(text for _, _, text in self.log)

    def set(self, **values: Any) -> None:
        for key, value in values.items():
            name = key.replace("__", ".")
            setter = getattr(self.fmu, f"set{self._types[name]}")
            setter([self._references[name]], [value])

    def get(self, name: str) -> Any:
        return getattr(self.fmu, f"get{self._types[name]}")([self._references[name]])[0]

    def start(self, tolerance: float | None = None, time: float = 0.0, **values: Any) -> None:
        self.fmu.setupExperiment(startTime=time, tolerance=tolerance)
        self.set(**values)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time: float, until: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=until - time)


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """All FMUs by model."""
    files = build(list(FILES), tmp_path_factory.mktemp("fmus"))
    return dict(zip(FILES, files, strict=True))


@pytest.fixture(scope="session")
def folders(fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """All FMUs extracted, by model."""
    base = tmp_path_factory.mktemp("extracted")
    return {model: extract(str(file), str(base / model)) for model, file in fmus.items()}


@pytest.fixture(params=list(FILES))
def model(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def vehicle(model: str, folders: dict[str, str]) -> Host:
    return Host(folders[model])


@pytest.fixture(scope="session")
def quarter_car_fmu(fmus: dict[str, Path]) -> Path:
    return fmus["QuarterCar"]


@pytest.fixture(scope="session")
def quarter_car_folder(folders: dict[str, str]) -> str:
    return folders["QuarterCar"]


@pytest.fixture
def car(quarter_car_folder: str) -> Host:
    return Host(quarter_car_folder)


@pytest.fixture
def host() -> type[Host]:
    return Host


@pytest.fixture
def log_categories() -> Callable[[Path], list[str]]:
    """The categories of messages that an extracted FMU declares, which older FMPy do not read."""

    def declared(folder: Path) -> list[str]:
        root = ElementTree.parse(folder / "modelDescription.xml")
        return [one.attrib["name"] for one in root.iterfind("LogCategories/Category")]

    return declared
