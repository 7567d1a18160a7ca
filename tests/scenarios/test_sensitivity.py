"""By how much a motion magnifies small differences."""

from __future__ import annotations

from math import sqrt
from typing import Any

import draws
import judging
import pytest
from command_line import printed, written
from phaseplane.scenarios.measures import sensitivity
from phaseplane.suspension.variables import checked_parameters


def magnification(model: str, given: dict[str, Any], duration: float = 1.0) -> float:
    found = sensitivity.magnification(model, checked_parameters(model, given), duration)
    assert found is not None
    return found


def test_a_free_oscillation_magnifies_by_what_its_phase_plane_says() -> None:
    """From rest at x0 it moves by 2 x0, at most at omega x0: kicks of 2 and 1 make sqrt(5) of 2."""
    free = {"road.shape": "flat", "damper.rebound_rate": 0.0, "damper.bump_rate": 0.0,
            "initial.body_displacement": 0.01}  # fmt: skip
    assert magnification("OneDof", free, 3.0) == pytest.approx(sqrt(1.25), rel=1e-2)


def test_what_damps_forgets_and_hard_stops_magnify() -> None:
    hard = {"road.height": 0.3, "bump_stop.stiffness": 1e9, "bump_stop.gap": 0.02,
            "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 1e9}  # fmt: skip
    heavy = {"damper.rebound_rate": 2e4, "damper.bump_rate": 2e4, "lift_off": False}
    assert magnification("QuarterCar", heavy) < 5.0
    assert magnification("QuarterCar", hard) > 10.0


def test_kicks_after_a_motion_that_has_come_to_rest_do_not_fail() -> None:
    """The energy of the motion before outweighed theirs: the magnification was infinite."""
    pothole = {"road.shape": "pothole", "road.length": 0.2, "speed": 90.0}
    assert 1.0 < magnification("OneDof", pothole, 2.0) < 5.0


@pytest.mark.slow
def test_it_is_that_of_the_true_motion() -> None:
    """Within what other instants and other signs of the kicks make of it."""
    given = {"road.height": 0.1, "bump_stop.stiffness": 1e7, "bump_stop.gap": 0.02}
    car = draws.Drawn(0, "QuarterCar", given, 1.0, "mean")
    true = judging.magnification(car, judging.standard(car), 1e-8)["displacements"]
    assert magnification("QuarterCar", given) == pytest.approx(true, rel=0.8)


@pytest.mark.parametrize("model", ["Elastoplastic", "HalfCarRigidTyres", "HalfCar"])
def test_nothing_changed_is_not_magnified(model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kick too small for the numbers leaves the motion as it was."""
    monkeypatch.setattr(sensitivity, "_KICK", 1e-25)
    assert magnification(model, {}) * 1e-25 < 1e-9


def test_a_motion_that_cannot_be_had_has_none() -> None:
    given = checked_parameters("QuarterCar", {"spring.cubic": -1e9, "road.height": 0.3})
    assert sensitivity.magnification("QuarterCar", given, 1.0) is None


def test_a_run_says_it_on_a_line() -> None:
    written('fmu = "QuarterCar"\nduration = "0.2 s"\n[show]\nmeasures = ["magnification"]\n')
    assert "this motion magnifies small differences by" in printed("run scene.toml")
