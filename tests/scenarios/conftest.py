"""One FMU for all tests of the scenes: packing takes longer than running."""

from __future__ import annotations

from pathlib import Path

import pytest

from vehicle_fmus.build import build


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """QuarterCar.fmu, packed once."""
    return build(["QuarterCar"], tmp_path_factory.mktemp("fmus"))[0]
