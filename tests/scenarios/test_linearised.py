"""Small motions about rest against closed forms and against runs of the model itself."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from phaseplane.scenarios.measures.linearised import linearised
from phaseplane.suspension.characteristics import cubic, damper, linear
from phaseplane.suspension.models import build
from phaseplane.suspension.roads import constant
from phaseplane.suspension.session import simulate
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import checked_parameters
from transfer import transfer


def oscillator(mass: float, rate: float, damping: float) -> System:
    strut = Element("strut", (1.0,), linear(rate), linear(damping), road="road")
    return System(
        coordinates=("body",), mass=((mass,),), elements=(strut,), signals={"road": constant()}
    )


def test_one_degree_has_its_closed_forms() -> None:
    (mode,) = linearised(oscillator(2.0, 800.0, 16.0)).modes()
    assert mode.frequency == pytest.approx(20.0 / (2.0 * pi))
    assert mode.damping_ratio == pytest.approx(16.0 / (2.0 * sqrt(800.0 * 2.0)))
    creeping = linearised(oscillator(2.0, 800.0, 400.0)).modes()
    assert [m.damping_ratio for m in creeping] == pytest.approx([1.0, 1.0])
    product = np.prod([2.0 * pi * m.frequency for m in creeping])
    assert product == pytest.approx(800.0 / 2.0)  # of the roots of m s^2 + c s + k


def test_transfer_of_one_degree() -> None:
    """|q/u|^2 = (1 + (2 D r)^2) / ((1 - r^2)^2 + (2 D r)^2)."""
    system = oscillator(2.0, 800.0, 16.0)
    r = np.linspace(0.1, 3.0, 30)
    d = 16.0 / (2.0 * sqrt(1600.0))
    gain = abs(transfer(system, r * 20.0 / (2.0 * pi))[:, 0])
    expected = np.sqrt((1.0 + (2 * d * r) ** 2) / ((1.0 - r**2) ** 2 + (2 * d * r) ** 2))
    assert gain == pytest.approx(expected)


def test_ap57_in_its_own_frequencies() -> None:
    """AP57 section 8: Omega_1 = 23.452 and Omega_2 = 70.7107 belong to the uncoupled planes."""
    modes = linearised(build("QuarterCar", checked_parameters("QuarterCar", {}))).modes()
    undamped = checked_parameters(
        "QuarterCar", {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "tyre.damping": 0.0}
    )
    free = linearised(build("QuarterCar", undamped)).modes()
    squares = [(2.0 * pi * m.frequency) ** 2 for m in free]
    # det(K - w^2 M) = 0 of AP57's car, with c2 = 10 c1 and M = 10 m: w^4 - (c1/M + (c1+c2)/m) w^2 + ...
    assert sum(squares) == pytest.approx(50.0 + 5500.0)
    assert np.prod(squares) == pytest.approx(50.0 * 5000.0)
    assert [m.damping_ratio for m in free] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert all(m.damping_ratio > 0.05 for m in modes)


def test_corners_count_with_the_mean_of_both_sides_and_springs_at_their_rest() -> None:
    strut = Element("strut", (1.0,), cubic(100.0, 5.0), damper(30.0, 10.0))
    preload = Element("preload", (1.0,), linear(0.0) + linear(0.0))
    system = System(coordinates=("x",), mass=((1.0,),), elements=(strut, preload))
    found = linearised(system)
    assert found.damping[0][0] == pytest.approx(20.0)
    assert found.stiffness[0][0] == pytest.approx(100.0)


@pytest.mark.parametrize(("frequency", "coordinate"), [(1.0, 0), (3.0, 0), (10.0, 1), (20.0, 1)])
def test_small_steady_motion_of_the_model_follows_the_transfer_function(
    frequency: float, coordinate: int
) -> None:
    speed = 20.0
    given = {
        "road.shape": "sine", "road.height": "0.02 mm", "road.length": speed / frequency,
        "damper.rebound_rate": 1000.0, "damper.bump_rate": 1000.0, "speed": speed,
    }  # fmt: skip
    system = build("QuarterCar", checked_parameters("QuarterCar", given))
    gain = abs(transfer(system, [frequency])[0, coordinate])
    time = np.concatenate([[0.0], np.linspace(9.0, 10.0, 1001)])
    name = ("body_displacement", "wheel_displacement")[coordinate]
    column = np.array(simulate("QuarterCar", given, time.tolist(), [name])[name])[1:]
    assert 0.5 * (column.max() - column.min()) == pytest.approx(gain * 1e-5, rel=2e-3)


def test_a_half_car_pitches_and_bounces() -> None:
    """With M3 = 0 and equal axles every frequency of the quarter car comes twice."""
    quarter = linearised(build("QuarterCar", checked_parameters("QuarterCar", {}))).modes()
    half = linearised(build("HalfCar", checked_parameters("HalfCar", {}))).modes()
    assert [m.frequency for m in half] == pytest.approx(
        [m.frequency for m in quarter for _ in range(2)]
    )
