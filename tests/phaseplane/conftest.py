"""A recording that many tests read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from recorded import HISTORIES, Recorded, content

from phaseplane.recording import record


@pytest.fixture(scope="session")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "two_planes.rrd"
    record(replace(content(), histories=HISTORIES), path)
    return path


@pytest.fixture(scope="session")
def recorded(path: Path) -> Recorded:
    return Recorded(path)
