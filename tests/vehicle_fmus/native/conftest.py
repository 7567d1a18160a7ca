"""FMUs under test, packed once: native ones by the compiler at hand, and those that run Python."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from phaseplane.suspension import own
from phaseplane.vehicle_fmus.build import build as build_in_python
from phaseplane.vehicle_fmus.native import compilers
from phaseplane.vehicle_fmus.native.pack import build

Packer = Callable[..., Path]


@pytest.fixture(scope="session")
def native_fmu(tmp_path_factory: pytest.TempPathFactory) -> Packer:
    """The function that packs a model, with settings as (name, value); less optimised, so sooner done."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")

    @cache
    def packed(model: str, *settings: tuple[str, object], text: str = "") -> Path:
        quick = tuple("-O1" if flag == "-O2" else flag for flag in compilers.FLAGS)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compilers, "FLAGS", quick)
            patch.setattr(compilers, "has_zig", lambda: False)
            return _packed(build, model, settings, text, tmp_path_factory.mktemp("native"))

    return packed


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
    if text:
        own.load(text, checked=False)
    (path,) = pack(
        [model], folder, parameters={model: dict(settings)}, own={model: text} if text else {}
    )
    return path


@pytest.fixture
def slave() -> Callable[..., Any]:
    """The function that instantiates an FMU of FMI 2.0, unpacked into a folder."""

    @contextmanager
    def instance(fmu: Path, work: Path) -> Iterator[Any]:
        folder = extract(str(fmu), str(work))
        description = read_model_description(folder)
        made = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="one",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        made.instantiate()
        yield made
        made.freeInstance()

    return instance
