"""Interrupts deferred to the end of a step."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter, sleep
from types import FrameType

_NOT_OURS = (signal.SIG_IGN, None)  # handlers: ignored, and set by another than Python
_LONGEST_SLEEP = 0.1  # s between two checks for an interrupt


class _Record(list[int]):
    """A signal handler that records the signals that came."""

    def __call__(self, number: int, _frame: FrameType | None) -> None:
        self.append(number)

    def last(self) -> int:
        return self[-1] if self else 0


@contextmanager
def deferred_interrupt() -> Iterator[Callable[[], int]]:
    """Record Ctrl-C and SIGTERM; inside the FMU they would be lost, or treated as its failure.

    A nested deferral yields the record of the outer one; in another thread, which gets no signals, it
    records none. Signals that this process ignores, such as Ctrl-C in the background of a script, remain
    ignored.
    """
    record = _Record()
    if threading.current_thread() is not threading.main_thread():
        yield record.last
        return
    before = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
    outer = [handler for handler in before.values() if isinstance(handler, _Record)]
    if outer:
        yield outer[0].last
        return
    heeded = {one: handler for one, handler in before.items() if handler not in _NOT_OURS}
    for one in heeded:
        signal.signal(one, record)
    try:
        yield record.last
    finally:
        for one, handler in heeded.items():
            signal.signal(one, handler)


def wait_until(instant: float, interrupted: Callable[[], int]) -> None:
    """Wait until a time of the clock, or until the run is interrupted."""
    while (left := instant - perf_counter()) > 0.0 and not interrupted():
        sleep(min(left, _LONGEST_SLEEP))
