"""What a method of steps is given, and what it returns."""

from __future__ import annotations

from collections.abc import Callable

Function = Callable[[float, float, float], float]
"""x'' as a function of x', x and t, smooth over a step."""

Made = tuple[float, float, float, float, float, float]
"""x, x' and x'' at the end of a step, the errors of x and x', and h times the rate at which x' decays."""
