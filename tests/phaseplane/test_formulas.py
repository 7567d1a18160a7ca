"""Formulas: what they say, what is wrong with one, and what is known of it."""

from __future__ import annotations

from math import isnan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from phaseplane.equations import Formula

number = st.floats(-2.0, 2.0)


@given(number, number, number)
def test_a_formula_is_what_it_says(v, x, t):
    formula = Formula("-(x^2 - 1)*v + 2*sin(pi*t)/ (1 + exp(x)) - max(x, v)")
    wanted = -(x**2 - 1) * v + 2 * np.sin(pi * t) / (1 + np.exp(x)) - max(x, v)
    assert formula.function(v, x, t) == pytest.approx(wanted, rel=1e-12, abs=1e-12)
    assert not formula.autonomous
    assert Formula("x").autonomous


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x +", "not a formula"),
        ("y + x", r"'y' is not known.*allowed are numbers"),
        ("sin(x", "not a formula"),
        ("x + 0.1*v  # damped", "not a formula; write comments after the closing quotation mark"),
        ("sni(x)", "did you mean 'sin'"),
        ("x.real", r"'x\.real' is not known"),
        ("__import__('os')", "is not known"),
        ("(lambda: 1)()", "is not known"),
        ("x if v else t", "is not known"),
        ("[x for x in v]", "is not known"),
        ("sin(x=1)", "is not known"),
        ("x + True", "'True' is not known"),
        ("'a' * 9", "is not known"),
        ("sin", "'sin' is not known"),
        ("1" + "+1" * 600, "1201 characters"),
        ("9" * 400, "too large"),
        ("", "not a formula"),
        ("x + mu*v", "'mu' is not known.*give its value in .parameters., such as mu = 1.0"),
        ("relay(x, 1, 2)", "relay takes 1 or 2 values, not 3"),
        ("saturation(x)", "saturation takes 2 values, not 1"),
        ("max(x)", "max takes at least 2 values, not 1"),
        ("sin()", "sin takes 1 value, not 0"),
        ("x'' + x = 0", "not a formula; write f of x'' . f = 0 alone, with v for x'"),
        ("ẋ + x", "did you mean 'v'?"),
        ("x if x > 0 else 0", "write cases by sign, abs, max"),
        ("1,5*x", "write numbers with a point"),
        ("x² + v", "write powers with"),
        ("v*|v| + x", "write abs.x. for"),
        ("sin x", "write arguments in brackets"),
        ("lambda*x", "lambda is reserved: write λ"),
        ("ln(x + 2)", "did you mean 'log'?"),
        ("heaviside(x)", r"did you mean '0.5\*\(1 \+ sign"),
        ("e^x", r"did you mean 'exp\(1\)'.*Otherwise give its value"),
    ],
)
def test_what_is_wrong_with_a_formula_is_said(text, message):
    with pytest.raises(ValueError, match=message):
        Formula(text)


def test_a_parameter_cannot_be_called_like_what_a_formula_knows():
    for name in ("v", "t", "sin", "pi", "2x", "a b"):
        with pytest.raises(ValueError, match="cannot name a parameter"):
            Formula("x", {name: 1.0})


def test_where_a_formula_has_no_value_it_is_not_a_number():
    function = Formula("sqrt(x) + (0 - 8)^(1/3)").function
    assert isnan(function(0.0, -1.0, 0.0))
    assert isnan(function(0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    ("text", "period"),
    [
        ("x + v", 0.0),
        ("x + cos(0*t)", 0.0),
        ("x - 0.3*cos(1.2*t)", 2.0 * np.pi / 1.2),
        ("x - cos(2*t + 1)^3 + v*sin(3*(t - 1))", 2.0 * np.pi),
        ("x + sign(sin(pi*t/2))", 4.0),
        ("x + sin(cos(t))", 2.0 * np.pi),
        ("x + 0.1*t", None),
        ("x + t*sin(t)", None),
        ("x + sin(t^2)", None),
        ("x + sin(t - t^2)", None),
        ("x + sin(x*t)", None),
        ("x + sin(t) + sin(pi*t)", None),
    ],
)
def test_the_period_of_a_drive_is_found_in_its_sines(text: str, period: float | None) -> None:
    assert Formula(text).period == (period if period is None else pytest.approx(period))


@given(
    st.sampled_from(
        ["max(x, v, 0.1) - min(x, v)", "atan2(v, x) + acos(x/9)", "sign(x)*abs(v)^1.5 + tanh(t)",
         "hypot(x, v) - copysign(2, v) + 3", "exp(-x^2)*cosh(v)/ (1 + t^2)", "2", "sqrt(x) + log(v)"]
    ),
    st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 3), min_size=1, max_size=5),
)  # fmt: skip
def test_equations_of_arrays_are_those_of_numbers(
    text: str, states: list[tuple[float, float, float]]
) -> None:
    v, x, t = np.array(states).T
    formula = Formula(text)
    with np.errstate(all="ignore"):
        many = np.broadcast_to(formula.on_arrays(v, x, t), v.shape)
    singly = [formula.function(*state) for state in states]
    # a logarithm of zero is no number for Python, and minus infinity for numpy
    finite = np.isfinite(singly)
    np.testing.assert_allclose(many[finite], np.array(singly)[finite], rtol=1e-12, atol=1e-12)
    assert not np.isfinite(many[~finite]).any()
