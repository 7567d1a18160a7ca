"""Every test in an empty folder of its own; one FMU for all, as packing takes longer than running."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from phaseplane.scenarios.simulate.fmu_cache import FOLDER_VARIABLE
from phaseplane.vehicle_fmus.build import build
from small_sweep import SCENE
from studied_car import CAR


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """QuarterCar.fmu, packed once."""
    return build(["QuarterCar"], tmp_path_factory.mktemp("fmus"))[0]


@pytest.fixture(scope="session", autouse=True)
def _kept_here(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """FMUs are kept in a folder of the tests' own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(FOLDER_VARIABLE, str(tmp_path_factory.mktemp("kept")))
        yield


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def scene_of_a_sweep(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)


@pytest.fixture
def studied_car(tmp_path: Path) -> None:
    (tmp_path / "car.toml").write_text(CAR)
