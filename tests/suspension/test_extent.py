"""How far a road reaches, said without making it: held against the road itself."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from phaseplane.suspension.parts import road_from
from phaseplane.suspension.roads import extent
from phaseplane.suspension.roads.profiles import _harmonics, share_of_variance
from phaseplane.suspension.variables import checked_parameters, variables
from scipy.integrate import quad


def parameters(**road: object) -> dict[str, object]:
    return checked_parameters("QuarterCar", {f"road.{key}": x for key, x in road.items()})


def length_for(duration: float, **road: object) -> float | None:
    return extent.length_for(parameters(**road), duration)


def test_the_default_length_is_the_fmus() -> None:
    declared = {v.name: v.start for v in variables("QuarterCar")}
    assert declared[extent.LENGTH] == extent.DEFAULT_LENGTH


def test_a_random_road_lasts_as_long_as_the_run_before_it_fades_out() -> None:
    assert length_for(5.0, shape="random") == 200.0
    for duration in (9.5, 20.0, 61.7):
        length = length_for(duration, shape="random")
        found = extent.road_end(parameters(shape="random", profile_length=length))
        assert found is not None
        fading, end = found
        assert duration <= fading < duration + 0.06 < end  # whole metres at 20 m/s
    assert length_for(20.0, shape="random", start=10.0) == 220.0
    assert length_for(1e6, shape="random") == extent.LONGEST
    assert length_for(20.0, shape="bump") is None


@pytest.mark.parametrize(
    "road",
    [
        {"shape": "random", "profile_length": 60.0, "start": 0.5},
        {"shape": "table", "table": "0:0, 3:0.02, 44:0"},
        {"shape": "spline", "table": "-1:0, 3:0.02, 44:0", "start": 1.0},
        {"shape": "sweep", "duration": 3.0},
    ],
)
def test_the_end_is_where_the_road_becomes_level_for_good(road: dict[str, object]) -> None:
    given = parameters(**road)
    found = extent.road_end(given)
    assert found is not None
    assert found[1] == pytest.approx(road_from(given).joints[-1], rel=1e-12)


@pytest.mark.parametrize("shape", ["flat", "bump", "plank", "sine", "step", "sequence", "input"])
def test_single_obstacles_and_endless_roads_do_not_end(shape: str) -> None:
    assert extent.road_end(parameters(shape=shape)) is None
    assert list(extent.remarks(parameters(shape=shape), 1e3)) == []


def test_what_is_said() -> None:
    def said(duration: float, **road: object) -> list[str]:
        return list(extent.remarks(parameters(**road), duration))

    assert said(20.0, shape="table", table="0:0, 3:0.02, 124:0") == [
        "road ends at 6.2 s of 20 s; it is level afterwards"
    ]
    assert said(20.0, shape="random") == [
        "road ends at 10 s of 20 s (fading out from 9 s); it is level afterwards"
    ]
    assert said(9.5, shape="random") == ["road fades out from 9 s of 9.5 s"]
    assert said(9.0, shape="random") == []
    short = said(0.5, shape="random", profile_length=20.0)
    assert short == [
        "a random road of 20 m contains no wavelengths above 32 m, which carry 68 % of the variance "
        "of its class"
    ]


@pytest.mark.parametrize(("length", "lacking"), [(20.0, 0.68), (50.0, 0.36), (200.0, 0.15)])
def test_a_short_road_has_no_long_waves(length: float, lacking: float) -> None:
    share, longest = share_of_variance(length)
    density = quad(lambda n: n**-2.0, 1.0 / longest, 4.0)[0]
    assert share == pytest.approx(density / quad(lambda n: n**-2.0, 0.01, 4.0)[0], rel=1e-6)
    assert share == pytest.approx(1.0 - lacking, abs=0.01)
    # the spectrum of a whole period of such a road begins at its longest wave
    period = 2 ** round(32.0 * length).bit_length()
    waves = _harmonics(1e-6, period - 1, 1.0 / 32.0, (0.01, 4.0), Random(1))
    spectrum = abs(np.fft.rfft(waves))
    found = np.flatnonzero(spectrum > 1e-6 * spectrum.max())
    assert found[0] * 32.0 / period == pytest.approx(1.0 / longest)
