"""Modes in their own phase planes, against closed forms and the eigenvalues of the first-order system."""

from __future__ import annotations

import re
from math import exp, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, printed, reported
from phaseplane.scenarios.measures.linearised import Linearised, linearised
from phaseplane.scenarios.measures.modal_planes import modal_planes
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension.models import build


def chain(alpha: float, beta: float) -> Linearised:
    """Two masses on springs with Rayleigh damping B = alpha M + beta K."""
    mass, stiffness = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([[30.0, -10.0], [-10.0, 15.0]])
    return Linearised(("a", "b"), mass, alpha * mass + beta * stiffness, stiffness)


def test_modes_are_normed_and_solve_their_equation() -> None:
    system = chain(0.0, 0.0)
    found = modal_planes(system)
    shapes, squares = found.shapes, found.angular_frequencies**2
    assert shapes.T @ system.mass @ shapes == pytest.approx(np.eye(2), abs=1e-12)
    assert system.stiffness @ shapes == pytest.approx(system.mass @ shapes * squares, abs=1e-11)


def test_rayleigh_damping_leaves_the_modes_to_themselves() -> None:
    """Its ratios are alpha / (2 Omega) + beta Omega / 2 (H83 chapter 11)."""
    alpha, beta = 0.2, 0.01
    system = chain(alpha, beta)
    found = modal_planes(system)
    omega = found.angular_frequencies
    assert found.proportional
    assert found.damping_ratios == pytest.approx(alpha / (2 * omega) + beta * omega / 2, rel=1e-12)
    assert found.damping_ratios == pytest.approx(
        [m.damping_ratio for m in system.modes()], rel=1e-9
    )
    assert omega / (2 * pi) == pytest.approx([m.frequency for m in system.modes()], rel=1e-9)


def test_free_motion_is_a_circle_and_with_damping_a_spiral() -> None:
    motion = modal_planes(chain(0.0, 0.0)).free(1)
    assert np.hypot(*motion[:, 1].T) == pytest.approx(1.0, abs=1e-10)
    assert motion[:, 0] == pytest.approx(0.0, abs=1e-12)
    found = modal_planes(chain(0.2, 0.01))
    damped = found.free(0, periods=1.0)
    ratio = float(found.damping_ratios[0])
    turned = 2.0 * pi * sqrt(1.0 - ratio**2)
    known = exp(-2.0 * pi * ratio) * (
        np.cos(turned) + ratio / sqrt(1.0 - ratio**2) * np.sin(turned)
    )
    assert damped[-1, 0, 0] == pytest.approx(known, rel=1e-9)


def test_the_damping_of_a_car_couples_its_modes() -> None:
    found = modal_planes(linearised(build("QuarterCar", {})))
    assert not found.proportional
    assert np.abs(found.free(0)[:, 1]).max() > 0.005


def test_damped_modes_are_told_by_the_frequency_at_which_they_oscillate() -> None:
    done = printed("modes passenger_car")
    car = linearised(build("QuarterCar", load_scene("passenger_car").all_parameters))
    inverse = np.linalg.inv(car.mass)
    first_order = np.block(
        [[np.zeros((2, 2)), np.eye(2)], [-inverse @ car.stiffness, -inverse @ car.damping]]
    )
    poles = np.linalg.eigvals(first_order)
    told = [float(x) for x in re.findall(r"([\d.]+) Hz, ", done)]
    assert told == pytest.approx(sorted(p.imag / (2 * pi) for p in poles if p.imag > 0), rel=1e-5)


@pytest.mark.slow
def test_the_double_pendulum_is_told_and_drawn(tmp_path: Path) -> None:
    """H83 example 28: 0.7653668647 and 1.8477590650 sqrt(g/l)."""
    picture = tmp_path / "modes.png"
    told = reported("modes h83_example28 --figure", str(picture))
    unit = sqrt(9.80665)
    assert [m["angular_frequency"] / unit for m in told["modes"]] == pytest.approx(
        [0.7653668647, 1.8477590650], rel=1e-9
    )
    assert [m["damping_ratio"] for m in told["modes"]] == [0.0, 0.0]
    assert picture.stat().st_size > 10_000


def test_what_has_no_modes_is_refused_in_a_line() -> None:
    assert "an equation has no modes; 'phaseplane portrait' shows" in complaint("modes van_der_pol")
    with pytest.raises(ValueError, match="a mode without stiffness"):
        modal_planes(Linearised(("a",), np.eye(1), np.zeros((1, 1)), np.zeros((1, 1))))


def test_without_stiffness_the_damped_modes_are_listed(tmp_path: Path) -> None:
    """As the measure natural_frequencies has them; the planes alone need stiffness."""
    free = "modes ap57 --set spring.rate=0"
    why = "a mode without stiffness has no phase plane"
    assert f"damped modes, as {why}: 0 Hz, 1; 0 Hz, 1; 9.3" in printed(free)
    refused = complaint(f"{free} --figure", tmp_path / "modes.png")
    assert f"{why}; without --figure the damped modes are listed" in refused


def test_what_is_rounding_in_a_shape_is_zero() -> None:
    told = printed("modes full_car").splitlines()
    assert (
        told[2].split("; ")[1].startswith("heave 1, front_left_wheel 0.09167")
    )  # no pitch, no roll
    assert told[3].split("; ")[1].startswith("pitch 1, front_left_wheel")
