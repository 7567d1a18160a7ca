"""What cannot be integrated as asked is refused when the integrator is made, with what is allowed."""

from __future__ import annotations

import re
from dataclasses import replace
from math import inf, nan

import pytest
from phaseplane.suspension.characteristics import power
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.roads import step
from phaseplane.suspension.systems import Load

CAR = build("QuarterCar", {})


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"order": 3}, "order = 3 is not one of 0"),
        ({"order": 10}, "order = 10 is not one of 0"),
        ({"step": -1.0}, "step = -1 s must be finite and positive, or 0"),
        ({"step": inf}, "step = inf s must be"),
        ({"step": nan}, "step = nan s must be"),
        ({"tolerance": 0.0}, "tolerance = 0 must be greater than 0"),
        ({"tolerance": nan}, "tolerance = nan must be greater than 0"),
        ({"start": nan}, "start = nan s must be finite"),
        ({"start": -inf}, "start = -inf s must be finite"),
    ],
    ids=str,
)
def test_a_setting_that_makes_no_sense(options: dict[str, float], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        Integrator(CAR, **options)


def test_scales_that_are_not_one_for_each_coordinate() -> None:
    with pytest.raises(ValueError, match="0 scales for 2 coordinates"):
        Integrator(replace(CAR, scales=()))


@pytest.mark.parametrize("scale", [nan, inf, -0.01])
def test_scales_that_are_no_displacements(scale: float) -> None:
    with pytest.raises(ValueError, match=f"scales = .*{scale}.* must be finite and at least 0"):
        Integrator(replace(CAR, scales=(0.01, scale)))


def test_a_road_and_a_load_that_no_signal_is_for() -> None:
    tyre = replace(CAR.elements[-1], name="tyre", road="gone", damper=power(300.0, 1.5))
    with pytest.raises(ValueError, match="tyre stands on the road 'gone', which is not a signal"):
        Integrator(replace(CAR, elements=(*CAR.elements[:-1], tyre)))
    with pytest.raises(
        ValueError, match="a load follows 'wind', which is not a signal of the system"
    ):
        Integrator(replace(CAR, loads=(Load((1.0, 0.0), "wind"),)))


def test_a_kerb_that_pushes_without_limit() -> None:
    tyre = replace(CAR.elements[-1], damper=power(300.0, 1.5))
    kerb = replace(
        CAR, elements=(*CAR.elements[:-1], tyre), signals={**CAR.signals, "road": step(0.05, 0.1)}
    )
    with pytest.raises(
        ValueError, match=r"^system: tyre: its road 'road' jumps by 0\.05 m at 0\.1 s, which pushes"
    ) as refusal:
        Integrator(kerb, start=0.0999)
    on_it = Integrator(kerb, start=0.1)
    rest = [0.0] * len(kerb.mass)
    on_it.row(kerb, rest, rest, 0.1)
    with pytest.raises(ValueError, match=re.escape(str(refusal.value))):
        on_it.row(kerb, rest, rest)
    level = replace(kerb, signals={**CAR.signals, "road": step(0.0, 0.1)})
    on_level, without = Integrator(level, start=0.1), [*rest]
    on_it.set_state([0.05] * len(rest), rest)
    on_level.set_state(without, rest)
    for integrator in (on_it, on_level):
        assert integrator.advance(0.2) == 0
        integrator.sample(0.2)
    risen = [q - 0.05 for q in on_it.sample_q]
    assert risen == pytest.approx(list(on_level.sample_q), abs=1e-12)
