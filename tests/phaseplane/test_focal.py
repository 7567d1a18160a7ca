"""Focal values: closed forms, and the change of distance in a turn that is followed."""

from __future__ import annotations

import numpy as np
import pytest

from phaseplane.equations import Formula
from phaseplane.portrait.focal import first_focal_value, focal_values
from phaseplane.portrait.returns import turns
from phaseplane.portrait.system import PhaseSystem, Window


def system(text: str) -> PhaseSystem:
    formula = Formula(text)
    return PhaseSystem(formula.function, on_arrays=formula.on_arrays)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("x + v^3", [-3 / 8]),  # the mean of cos^4
        ("x - x^2*v", [1 / 8]),  # of cos^2 sin^2
        ("x + v^5", [0.0, -5 / 16]),
        ("x + x*v - x^2", [-1 / 8]),  # from the product of both second powers
        ("x + x^2 + v^2", [0.0, 0.0, 0.0, 0.0]),  # even in v
    ],
)
def test_closed_forms(text: str, values: list[float]) -> None:
    size = 0.5
    wanted = [value * size ** (2 * k) for k, value in enumerate(values, 1)]
    found = focal_values(system(text), 0.0, 1.0, size)[: len(values)]
    assert found == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "omega", "order"),
    [
        ("x + x^2 + x*v + v^2", 1.0, 1), ("4*x - 3*x^2*v + x^2*v^2 + x*v - v^2*x/3", 2.0, 1),
        ("sin(x) + 3*x^2*v - v^3", 1.0, 2), ("x + 3*x^2*v - v^3", 1.0, 3),
    ],
)  # fmt: skip
def test_a_turn_changes_the_distance_as_the_value_says(text: str, omega: float, order: int) -> None:
    size, distance = 0.25, 0.1
    values = focal_values(system(text), 0.0, omega, size)
    assert values[: order - 1] == pytest.approx([0.0] * (order - 1), abs=1e-9)
    window, start = Window(-3.0, 3.0, -3.0, 3.0), np.array([distance])
    (back,) = turns(system(text), window, start, tolerance=1e-13).back
    wanted = 2.0 * np.pi * values[order - 1] * (distance / size) ** (2 * order)
    assert back / distance - 1.0 == pytest.approx(wanted, rel=0.2)


@pytest.mark.parametrize("text", ["x + v*abs(v)", "x + max(v - 0.1, 0)", "x*abs(x)", "x + x*v"])
def test_a_function_with_corners_and_a_centre_have_none(text: str) -> None:
    assert first_focal_value(system(text), 0.0, 1.0, 3.0) == 0.0
