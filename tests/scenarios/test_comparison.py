"""Two runs compared: how far they lie apart, and what only one of them has."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.scenarios.results.comparison import check_ascending, compared, format_extent

OURS = {"time": np.linspace(0.0, 1.0, 11), "a": np.linspace(0.0, 2.0, 11), "b": np.zeros(11)}
OTHER = {"time": np.linspace(0.0, 2.0, 5), "a": np.linspace(0.0, 4.4, 5), "b": np.zeros(5)}


def test_differences_over_the_common_time() -> None:
    found = compared(OURS, OTHER)
    worst, equal = found.differences
    assert (worst.name, equal.relative) == ("a", 0.0)
    assert worst.largest == pytest.approx(0.2)
    assert (worst.time, worst.relative) == (1.0, pytest.approx(0.2 / 2.2))
    assert format_extent(found.as_data()) == "2 columns, 11 rows from 0 to 1 s"


def test_a_run_with_rows_on_both_sides_of_a_jump_is_the_same_as_itself() -> None:
    """Each side was compared with the other side's value."""
    run = {
        "time": np.array([0.0, 0.1, 0.1, 0.2, 0.2]), "x": np.array([1.0, 2.0, -3.0, np.inf, 5.0]),
    }  # fmt: skip
    assert compared(run, run).differences[0].largest == 0.0
    other = {**run, "x": np.array([1.0, 2.0, -3.5, np.inf, 5.0])}
    assert compared(run, other).differences[0].largest == 0.5
    smooth = {"time": np.array([0.0, 0.4]), "x": np.array([1.0, 5.0])}
    assert (
        compared({"time": run["time"], "x": 1.0 + 10.0 * run["time"]}, smooth)
        .differences[0]
        .largest
        < 1e-15
    )


def test_a_run_with_several_rows_at_once_is_the_same_as_itself() -> None:
    """Of three rows the middle one was compared with the first."""
    run = {"time": np.array([0.0, 0.1, 0.1, 0.1]), "x": np.array([1.0, 2.0, 7.0, 3.0])}
    assert compared(run, run).differences[0].largest == 0.0


def test_what_is_no_number_in_one_of_them_is_a_difference() -> None:
    assert compared(OURS, {**OTHER, "a": np.full(5, np.nan)}).differences[0].largest == inf
    worst = compared({**OURS, "a": np.full(11, np.inf)}, OTHER).differences[0]
    assert (worst.name, worst.relative) == ("a", inf)
    both = {**OURS, "a": np.array([np.nan, np.inf, *range(9)])}
    assert [d.relative for d in compared(both, both).differences] == [0.0, 0.0]
    worst = compared(both, {**both, "a": np.array([np.nan, np.inf, *range(8), 16])}).differences[0]
    assert (worst.name, worst.relative) == ("a", 0.5)  # an infinite peak would hide it


def test_what_cannot_be_compared() -> None:
    with pytest.raises(ValueError, match="time cannot be compared"):
        compared(OURS, OURS, ["a", "time"])
    with pytest.raises(ValueError, match="no column in common"):
        compared(OURS, {"time": OTHER["time"]})
    with pytest.raises(ValueError, match="no time in common: 0 to 1 s and 5 to 7 s"):
        compared(OURS, {**OTHER, "time": OTHER["time"] + 5.0})
    with pytest.raises(ValueError, match=r"must not go back, but 0\.9 follows 1 s in row 2"):
        compared({name: column[::-1] for name, column in OURS.items()}, OTHER)
    with pytest.raises(ValueError, match="time is nan in row 2"):
        check_ascending(np.array([0.0, np.nan]))


@given(rows=st.integers(1, 10), shift=st.integers(0, 5), dropped=st.booleans())
def test_what_only_one_has_is_told_either_way(rows: int, shift: int, dropped: bool) -> None:
    """A part of a run is equal to the whole of it, where both have values, and never the same."""
    part = {name: column[shift : shift + rows] for name, column in OURS.items()}
    if dropped:
        del part["b"]
    for one, other in ((OURS, part), (part, OURS)):
        found = compared(one, other)
        assert all(difference.largest == 0.0 for difference in found.differences)
        assert found.common.rows == len(part["time"])
        assert len(found.unshared("x", "y")) == 1 + dropped
    chosen = compared(OURS, part, ["a"])
    assert not any("column" in words for words in chosen.unshared("x", "y"))


def test_instants_that_differ_by_rounding_are_the_same() -> None:
    rounded = {**OURS, "time": OURS["time"].astype(np.float32).astype(float) - 1e-9}
    assert compared(OURS, rounded).unshared("x", "y") == []
    assert compared(OURS, rounded).common.rows == 11
    assert compared(OURS, OURS).unshared("x", "y") == []
