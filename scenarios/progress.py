"""How much of a slow task is done."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float], None]
"""Called now and then with the fraction done, 0 to 1."""


def silent(_done: float) -> None:
    """Show no progress."""


def part_of(progress: Progress, first: float, width: float) -> Progress:
    """Return the progress of a part of a task, from its place in the whole."""
    return lambda done: progress(first + width * done)
