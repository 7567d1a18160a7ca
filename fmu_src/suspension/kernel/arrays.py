"""The arrays that hold all numbers of the kernel, allocated once at the start.

The arrays of one integrator are contiguous, in memory of their own. Threads that write to the same cache
line wait for each other, and Python's allocator hands out small blocks to all threads in turn, so two
integrators in parallel would otherwise be slower than one after the other.
"""

from __future__ import annotations

from array import array
from threading import local

import cython

_LINE = 64  # bytes of a cache line
_BLOCK = 1 << 15  # bytes allocated at a time
_WORD = 8  # bytes; every array starts at a multiple


class _Place(local):
    """The free memory for the next array, in each thread."""

    room = memoryview(b"")


_place = _Place()


def begin_apart():
    """Allocate the next arrays of this thread apart from all existing ones."""
    _place.room = memoryview(b"")


def doubles(values):
    return _placed(array("d", values))


def integers(values):
    return _placed(array("i", values))


def vectors(count, size):
    return [doubles([0.0] * size) for _ in range(count)]


def _placed(values):
    """Copy an array into the free memory; uncompiled, return it, as plain arrays are read faster."""
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
