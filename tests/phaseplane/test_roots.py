"""The root finder of motions and constructions, against roots that are known."""

from __future__ import annotations

from collections.abc import Callable
from math import atan, copysign, expm1

import pytest
from hypothesis import given
from hypothesis import strategies as st

from phaseplane.equations.roots import root

SHAPES: list[Callable[[float], float]] = [
    lambda x: x,
    lambda x: -(x**3),
    lambda x: expm1(30.0 * x),
    lambda x: atan(1e3 * x),
    lambda x: copysign(abs(x) ** 0.3, x),
    lambda x: -1.0 if x < 0.0 else 5.0,
]


@pytest.mark.parametrize("shape", SHAPES)
@given(at=st.floats(-3.0, 3.0), before=st.floats(1e-6, 2.0), after=st.floats(1e-6, 2.0))
def test_a_root_is_found_to_rounding(
    shape: Callable[[float], float], at: float, before: float, after: float
) -> None:
    """The place found is one where the function has changed its sign: there a motion has switched."""
    values: dict[float, float] = {}

    def function(x: float) -> float:
        return values.setdefault(x, shape(x - at))

    low, high = at - before, at + after
    found = root(function, low, high)
    assert found == pytest.approx(at, abs=5e-16 * max(-low, high, before, after))
    ends = sorted([shape(-before), values[found]])
    assert ends[0] < 0.0 < ends[1] or values[high] == 0.0
    assert len(values) < 60


def test_the_end_of_a_plateau_counts() -> None:
    """A margin that stays at zero for a while has not been passed before it falls."""
    assert root(lambda t: min(0.0, 0.7 - t), 0.0, 1.0) == pytest.approx(0.7, rel=1e-15)


def test_a_function_that_is_zero_at_the_end_ends_there() -> None:
    assert root(lambda t: 1.0 - t, 0.0, 1.0) == 1.0
