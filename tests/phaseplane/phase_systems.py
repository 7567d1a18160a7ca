"""Systems of tests of portraits, and their window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from phaseplane.portrait import (
    PhaseSystem,
    Window,
)

WIDE = Window(-3.75, 3.75, -3.75, 3.75)


def of(function: Callable[[Any, Any], Any]) -> PhaseSystem:
    """An autonomous system by its f(x', x)."""
    return PhaseSystem(lambda v, x, t: function(v, x))
