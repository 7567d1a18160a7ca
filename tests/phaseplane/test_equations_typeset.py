"""Equations as they are written by hand."""

from __future__ import annotations

import pytest

from phaseplane.equations import Formula
from phaseplane.equations.typeset import number, read


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("(x^2 - 1)*v + x", "ẍ + (x² − 1)\u2009ẋ + x = 0"),
        ("-x + x^3", "ẍ − x + x³ = 0"),
        ("x - (v - t)", "ẍ + x − (ẋ − t) = 0"),
        ("x + -v", "ẍ + x − ẋ = 0"),
        ("-2*v*x - x", "ẍ − 2\u2009ẋ\u2009x − x = 0"),
        ("x + -x/2*v - (-x)", "ẍ + x − (x/2)\u2009ẋ + x = 0"),
        ("9.81/l*sin(x)", "ẍ + (9.81/l)\u2009sin(x) = 0"),  # and not 9.81/(l sin(x))
        ("x - -(x/2)*v/3", "ẍ + x + (x/2)\u2009ẋ/3 = 0"),
        ("v/2*3*x", "ẍ + (ẋ/2)·3\u2009x = 0"),
        ("-(-x/2)*v", "ẍ − (−x/2)\u2009ẋ = 0"),  # in brackets once
        ("(-x + v)*x - (-v)^2", "ẍ + (−x + ẋ)\u2009x − (−ẋ)² = 0"),
        ("2*3*x", "ẍ + 2·3\u2009x = 0"),
        ("x/(2*v)", "ẍ + x/(2\u2009ẋ) = 0"),
        ("(x + v)^2*abs(v)", "ẍ + (x + ẋ)²\u2009|ẋ| = 0"),
        ("x^(1/3)", "ẍ + x^(1/3) = 0"),
        ("1/x^2 - 1/(x^3*v)", "ẍ + 1/x² − 1/(x³\u2009ẋ) = 0"),
        ("dead_zone(x, 1)", "ẍ + dead zone(x, 1) = 0"),
        ("x^3/1e-12 + 2*1e-12*v", "ẍ + x³/(1·10⁻¹²) + 2·(1·10⁻¹²)\u2009ẋ = 0"),
    ],
)
def test_a_formula_is_typeset(text: str, words: str) -> None:
    assert Formula(text, {"l": 1.0} if "/l" in text else {}).words.partition("   (")[0] == words


def test_parameters_are_told_with_their_values() -> None:
    formula = Formula("omega^2*x + mu*v", {"omega": 2.0, "mu": 0.1, "unused": 3.0})
    assert formula.words == "ẍ + ω²\u2009x + μ\u2009ẋ = 0   (μ = 0.1, ω = 2)"


def test_numbers_in_names_are_indices() -> None:
    formula = Formula("x/J0 + omega_2*v + k10*t", {"J0": 0.02, "omega_2": 1.0, "k10": 3.0})
    assert formula.words == "ẍ + x/J₀ + ω₂\u2009ẋ + k₁₀\u2009t = 0   (J₀ = 0.02, k₁₀ = 3, ω₂ = 1)"


@pytest.mark.parametrize("value", [0.0, -1.25, 9.61e-10, -3.0e-300, 961e6, -2.5e123])
def test_a_number_is_read_as_it_is_printed(value: float) -> None:
    assert read(number(value)) == value


@pytest.mark.parametrize("text", ["", "x", "·10⁻³", "2·10", "2·10³ m"])
def test_what_is_no_number_is_not_read(text: str) -> None:
    with pytest.raises(ValueError, match="could not convert"):
        read(text)
