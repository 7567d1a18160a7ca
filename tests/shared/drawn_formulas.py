"""Formulas drawn at random, of v, x, t, a constant a, numbers, operators and all kinds of functions."""

from __future__ import annotations

from hypothesis import strategies as st

LEAVES = st.sampled_from(
    ["x", "v", "t", "x", "v", "a", "0", "1", "0.5", "3", "9.81", "1e-3", "100"]
)
ONE = (
    "sin", "cos", "tan", "atan", "tanh", "exp", "log", "sqrt", "asin", "sinh", "abs", "sign", "relay",
)  # fmt: skip
TWO = ("min", "max", "copysign", "hypot", "atan2", "relay", "dead_zone", "backlash", "saturation")


def combined(parts: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Larger expressions made of others."""
    return st.one_of(
        st.tuples(parts, st.sampled_from(["+", "-", "*", "/", "^"]), parts).map(
            lambda found: f"({' '.join(found)})"
        ),
        st.tuples(st.sampled_from(ONE), parts).map(lambda found: f"{found[0]}({found[1]})"),
        st.tuples(st.sampled_from(TWO), parts, parts).map(
            lambda found: f"{found[0]}({found[1]}, {found[2]})"
        ),
    )


FORMULAS = st.recursive(LEAVES, combined, max_leaves=8)
