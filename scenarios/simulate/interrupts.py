"""Interrupts deferred to the end of a step."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def deferred_interrupt() -> Iterator[Callable[[], int]]:
    """Record Ctrl-C and SIGTERM; raised inside the FMU they would count as its failure."""
    came: list[int] = [0]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: came[-1]
        return
    signals = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(one, lambda number, _frame: came.append(number)) for one in signals]
    try:
        yield lambda: came[-1]
    finally:
        for one, handler in zip(signals, before, strict=True):
            signal.signal(one, handler)
