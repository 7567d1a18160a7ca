"""`phaseplane build --native`: what is refused before anything is packed."""

from __future__ import annotations

from pathlib import Path

import pytest
from phaseplane.scenarios.commands.build import build_native
from phaseplane.scenarios.errors import InputError


@pytest.mark.parametrize(
    ("models", "platforms", "settings", "why"),
    [
        (["QuarterCar"], [], ["road.hight=3"], "did you mean 'road.height'"),
        (["QuarterCar"], [], ["friction"], "must be name=value"),
        (["QuarterCar"], [], ["friction=-1"], "friction = -1: must be at least 0"),
        (["QuarterCar"], [], ["lift_off=perhaps"], "must be true or false"),
        (["Quartercar"], [], [], "did you mean 'QuarterCar'"),
        (["QuarterCar"], ["win"], [], "platform 'win' is unknown"),
    ],
)
def test_what_is_wrong_is_refused_and_nothing_written(
    models: list[str], platforms: list[str], settings: list[str], why: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=why):
        build_native(models, tmp_path, platforms, settings)
    assert list(tmp_path.iterdir()) == []
