"""Numbers that note what is done to them, beside the same calculation with floats."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.suspension.trace import Number, Tape


def calculation(a: float, b: float) -> float:
    c = (a - b) * (a - (b - 1.5)) / (2.0 - -a)
    return abs(-c) + (c + a) ** 2 if c < b else -(c * b) - 0.25


def evaluated(number: Number, **values: float) -> float:
    """The C of a number, read as Python: the operators are the same."""
    text = number.node.written({})[0]
    return float(eval(text, {"fabs": abs, "pow": pow, **values}))


@given(st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_what_is_noted_gives_the_same_bits(a: float, b: float) -> None:
    tape = Tape()
    found = calculation(tape.given("a", a), tape.given("b", b))  # type: ignore[arg-type]
    assert isinstance(found, Number)
    assert found.value == calculation(a, b)
    assert evaluated(found, a=a, b=b) == calculation(a, b)


@given(st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_a_guard_tells_where_the_calculation_would_be_another(a: float, b: float) -> None:
    tape = Tape()
    calculation(tape.given("a", 3.0), tape.given("b", 1.0))  # type: ignore[arg-type]
    (guard,) = tape.guards.values()
    c = (a - b) * (a - (b - 1.5)) / (2.0 + a)
    text = guard.condition.written({})[0]
    assert (eval(text, {"a": a, "b": b}) == guard.holds) == ((c < b) == (c_of(3.0, 1.0) < 1.0))


def c_of(a: float, b: float) -> float:
    return (a - b) * (a - (b - 1.5)) / (2.0 + a)


def test_where_a_float_is_wanted_the_value_is_fixed() -> None:
    tape = Tape()
    speed = tape.given("p[3]", 20.0, "speed")
    assert float(speed) == 20.0
    (guard,) = tape.guards.values()
    assert (guard.in_words(), guard.holds) == ("speed == 20", True)


def test_a_condition_that_does_not_hold_is_said_by_its_opposite() -> None:
    tape = Tape()
    friction = tape.given("p[0]", 0.0, "friction")
    assert not friction < 0.0
    assert not friction > 1.0
    assert [guard.in_words() for guard in tape.guards.values()] == [
        "friction >= 0",
        "friction <= 1",
    ]


def test_a_number_is_not_taken_for_a_plain_one() -> None:
    number = Tape().given("a", 1.0)
    assert hash(number) != hash(1.0)
    with pytest.raises(TypeError):
        number + "text"
