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
_WORD, _HALF_WORD = (
    8,
    4,
)  # bytes of a double, at a multiple of which every array starts, and of an int


class _Place(local):
    """The free memory for the next array, in each thread."""

    room = memoryview(b"")
    at = 0  # the first free byte


_place = _Place()


def begin_apart():
    """Allocate the next arrays of this thread apart from all existing ones."""
    _place.room, _place.at = memoryview(b""), 0


def zeros(count):
    return (
        _allocated(count, "d")
        if cython.compiled and count > 0
        else array("d", bytes(_WORD * count))
    )


def marks(count):
    return _allocated(count, "i") if cython.compiled and count > 0 else array("i", [0] * count)


def doubles(values):
    return _placed(array("d", values))


def integers(values):
    return _placed(array("i", values))


def vectors(count, size):
    return [zeros(size) for _ in range(count)]


def _placed(values):
    """Copy an array into the free memory; uncompiled, return it, as plain arrays are read faster."""
    if not (cython.compiled and values):
        return values
    placed = _allocated(len(values), values.typecode)
    placed[:] = memoryview(values)
    return placed


def _allocated(count, typecode):
    """Return so many zeros from the free memory."""
    size = count * (_WORD if typecode == "d" else _HALF_WORD)
    place = _place
    if place.at + size > len(place.room):
        lines = max(size, _BLOCK) // _LINE + 1
        memory = array("B", bytes((lines + 1) * _LINE))
        first = -memory.buffer_info()[0] % _LINE
        place.room, place.at = memoryview(memory)[first : first + lines * _LINE], 0
    at = place.at
    place.at = at + (size + _WORD - 1) // _WORD * _WORD
    return place.room[at : at + size].cast(typecode)
