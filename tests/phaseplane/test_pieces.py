"""The pieces of formulas, such as relays and saturations."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_formulas import FORMULAS
from hypothesis import assume, example, given
from hypothesis import strategies as st

from phaseplane.equations import Formula

number = st.floats(-3.0, 3.0)
part = st.integers(-4000, 4000).map(lambda thousandths: 1e-3 * thousandths)


@given(number, number, st.floats(0.0, 3.0))
def test_pieces_are_what_they_are_called(x, v, d):
    def value(text: str) -> float:
        return Formula(text, {"d": d}).function(v, x, 0.0)

    sign = (x > 0) - (x < 0)
    assert value("sign(x)") == sign
    assert value("relay(x, d)") == pytest.approx(sign if abs(x) > d else 0.5 * sign * (abs(x) == d))
    assert value("saturation(x, d)") == pytest.approx(min(max(x, -d), d), abs=1e-15)
    assert value("dead_zone(x, d)") == pytest.approx(sign * max(abs(x) - d, 0.0), abs=1e-15)
    assert value("backlash(x, 2*d)") == pytest.approx(value("dead_zone(x, d)"), abs=1e-15)


@given(
    st.sampled_from([
        "relay(x, 0.5)*v + saturation(v, 1)", "max(x, v, 0.1) - min(x, 2*v)", "abs(x)*abs(v)",
        "dead_zone(x - abs(v), 0.3)", "copysign(x, v) + sign(sign(x) + 0.5*v)", "backlash(x, 1)^3",
        "copysign(x, 0) + copysign(x, relay(v, 1))", "atan2(v, x)*atan2(v, x - 1)",
        "atan2(v, -1) + atan2(v, 0) + atan2(0, v)", "atan2(x - 1, v^2)", "atan2(sign(x), sign(x))",
    ]),
    number, number,
)  # fmt: skip
def test_pieces_by_their_signs_are_the_pieces(text, x, v):
    assume(v != 0.0)  # there copysign(x, v) jumps
    formula = Formula(text)
    assert formula.switching.value(v, x, 0.0) == pytest.approx(
        formula.function(v, x, 0.0), rel=1e-12, abs=1e-12
    )
    assert formula.on_arrays(np.array([v]), np.array([x]), np.array([0.0])) == pytest.approx(
        formula.function(v, x, 0.0), rel=1e-12, abs=1e-12
    )


@example("copysign(x, 0*t)", 0.5, 0.0, -1.0)  # -0 is not negative
@example("min(x, exp(100))", 0.5, 0.0, 0.0)  # a large number leaves no digits of x in a sum
@example("x^dead_zone(t, 9.81)", 0.0, 0.0, 2.3)  # exactly 0
@example("atan2(0*x, 0*v)", 0.5, 0.5, 0.0)  # 0, though 0 counts as positive
@given(FORMULAS, part, part, part)
def test_drawn_formulas_by_their_signs_are_the_formulas(text, x, v, t):
    try:
        formula = Formula(text, {"a": -0.7})
    except ValueError:
        return
    switching = formula.switching
    signs = switching.signs(v, x, t)
    assume(all(abs(g(v, x, t, signs)) > 1e-9 for g in switching.guards))  # on one, f may jump
    value = formula.function(v, x, t)
    assert switching.value(v, x, t) == pytest.approx(value, rel=1e-8, abs=1e-8, nan_ok=True)


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_zero_counts_as_positive_whatever_its_sign(zero):
    """As a controller or at the start of a motion, copysign(2, -v) was -2 at rest."""
    formula = Formula("copysign(2, -x) + copysign(2, x) + atan2(0, x) + atan2(0, -x)")
    assert formula.function(0.0, zero, 0.0) == 4.0
    assert formula.on_arrays(np.zeros(1), np.array([zero]), np.zeros(1)) == [4.0]


@pytest.mark.parametrize(
    ("text", "switches"),
    [
        ("abs(x*x)", 0), ("abs(x^2/(1 + v^4))", 0), ("abs(exp(x)*v^2)", 0), ("abs(sqrt(x) + 2)", 0),
        ("abs(x*v)", 1), ("abs(x^3)", 1), ("abs(x^2 - v^2)", 1), ("abs(0.5 - x^2)", 1),
    ],
)  # fmt: skip
def test_what_cannot_change_its_sign_is_no_switch(text: str, switches: int):
    assert len(Formula(text).switching.guards) == switches


@pytest.mark.parametrize(
    "text", ["dead_zone(x, -1)", "saturation(x, -2)", "relay(x, -d)", "backlash(x, d - 1)"]
)
def test_negative_widths_are_refused(text: str):
    with pytest.raises(
        ValueError, match=r"the second value of \w+ is -[\d.]+; it must be at least 0"
    ):
        Formula(text, {"d": 0.1})
    assert Formula(text.replace("-", "+"), {"d": 0.1}).names <= {"d"}


@pytest.mark.parametrize("width", ["10^400", "exp(1000)", "d/0"])
def test_widths_beyond_all_numbers_are_refused(width: str):
    with pytest.raises(ValueError, match=r"value of saturation has no finite value; it must"):
        Formula(f"saturation(x, {width})", {"d": 0.1})
