"""The report says in words which road was driven."""

from __future__ import annotations

import pytest
from phaseplane.scenarios.results.report import format_road
from phaseplane.suspension.variables import checked_parameters


@pytest.mark.parametrize(
    ("road", "words"),
    [
        ({"shape": "flat"}, "flat"),
        ({"shape": "bump"}, "bump 50 mm high, 1 m long, at 20 m/s"),
        ({"shape": "pothole", "height": 0.03}, "pothole 30 mm deep, 1 m long, at 20 m/s"),
        ({"shape": "step"}, "step 50 mm high"),
        ({"shape": "sweep"}, "sweep 50 mm from crest to trough, 0.5 to 20 Hz in 10 s"),
        (
            {"shape": "random"},
            "random, class C, seed 1, 200 m long with a 20 m fade at both ends, at 20 m/s",
        ),
        (
            {"shape": "random", "roughness": 1e-4},
            "random, Gd(n0) = 100 cm3, seed 1, 200 m long with a 20 m fade at both ends, at 20 m/s",
        ),
        (
            {"shape": "sequence", "sequence": "bump 0.05 1,gap 3, step 0.02"},
            "bump 0.05 1, gap 3, step 0.02, at 20 m/s",
        ),
        ({"shape": "spline", "table": "0:0, 1:0.1, 2:0"}, "spline of 3 points, at 20 m/s"),
    ],
)
def test_words(road: dict[str, object], words: str) -> None:
    given = {f"road.{key}": value for key, value in road.items()}
    assert format_road(checked_parameters("QuarterCar", given)) == words
