"""Native FMUs under test, packed once, by the compiler at hand."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from phaseplane.vehicle_fmus.native import compilers
from phaseplane.vehicle_fmus.native.pack import build

Packer = Callable[..., Path]


@pytest.fixture(scope="session")
def native_fmu(tmp_path_factory: pytest.TempPathFactory) -> Packer:
    """The function that packs a model, with settings as (name, value); less optimised, so sooner done."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")

    @cache
    def packed(model: str, *settings: tuple[str, object]) -> Path:
        quick = tuple("-O1" if flag == "-O2" else flag for flag in compilers.FLAGS)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(compilers, "FLAGS", quick)
            patch.setattr(compilers, "has_zig", lambda: False)
            (path,) = build(
                [model], tmp_path_factory.mktemp("native"), parameters={model: dict(settings)}
            )
        return path

    return packed
