"""The arrays that all numbers of the kernel stand in; memory is had once, at the start.

Those of one integrator lie together in memory of their own. Where two threads write into one line of the
processor's cache, each waits for the other, and what Python has for small things it deals out to all
threads in turn: two integrators side by side were slower so than one after the other.
"""

from __future__ import annotations

from array import array
from threading import local

import cython

_LINE = 64  # bytes of the processor's cache that go together
_BLOCK = 1 << 15  # bytes had at a time
_WORD = 8  # bytes; every array begins at a multiple of them


class _Place(local):
    """Where there is room for the next array, in each thread."""

    room = memoryview(b"")


_place = _Place()


def begin_apart():
    """What this thread makes from now on lies apart from all that has been made."""
    _place.room = memoryview(b"")


def doubles(values):
    return _placed(array("d", values))


def integers(values):
    return _placed(array("i", values))


def vectors(count, size):
    return [doubles([0.0] * size) for _ in range(count)]


def _placed(values):
    """The same numbers where there is room for them; uncompiled, an array as it is is read faster."""
    if not (cython.compiled and values):
        return values
    content = memoryview(values)
    if content.nbytes > len(_place.room):
        lines = max(content.nbytes, _BLOCK) // _LINE + 1
        memory = array("B", bytes((lines + 1) * _LINE))
        first = -memory.buffer_info()[0] % _LINE
        _place.room = memoryview(memory)[first : first + lines * _LINE]
    room = _place.room[: content.nbytes].cast(values.typecode)
    room[:] = content
    _place.room = _place.room[(content.nbytes + _WORD - 1) // _WORD * _WORD :]
    return room
