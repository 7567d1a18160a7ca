"""The memory of an integrator, which contains all of its arrays next to each other.

Compiled, an array is an address within blocks of bytes that live as long as their `Memory`. Two
integrators never share a cache line, because threads that write to the same line wait for each other.
Uncompiled, it is a list, whose items Python reads in half the time that it takes with an `array`.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import cython

if not cython.compiled:

    class View(Sequence[float]):
        """The first numbers of a list, as a memoryview shows those of an array."""

        def __init__(self, numbers, count, code):
            self.numbers, self.count, self.format = numbers, count, code

        def __len__(self):
            return self.count

        def __getitem__(self, at):
            return self.numbers[: self.count][at]

        def __setitem__(self, at, value):
            self.numbers[at] = value

        def tolist(self):
            return self.numbers[: self.count]


_LINE = 8  # doubles in a cache line
_BLOCK = 4096  # doubles allocated at a time
_SIZE_OF_DOUBLE, _SIZE_OF_INTEGER = 8, 4  # bytes
_DOUBLE = 100  # "d", the format of a double


class Memory:
    """Allocates the arrays of an integrator, filled with zeros, and frees them all together at its end.

    Parameters
    ----------
    block : number of doubles allocated at a time
    """

    def __init__(self, block=_BLOCK):
        self.block = block
        self.blocks = []  # of bytes; uncompiled, the lists themselves
        self.codes = []  # uncompiled, the types of their items: "d" or "i"
        self.used = []  # bytes of each block that arrays occupy
        self.left = -1  # free doubles in the last block; -1 while there is no block

    def _take(self, count):
        """Return `count` doubles of the last block, or of a new one."""
        if count > self.left:
            self.left = max(count, self.block)
            block = bytearray(_SIZE_OF_DOUBLE * (self.left + 2 * _LINE))
            self.blocks.append(block)
            self.used.append(0)
            # one cache line is left free on both sides
            self.free = cython.cast("double *", PyByteArray_AsString(block)) + _LINE  # noqa: F821
        taken = self.free
        self.free += count
        self.left -= count
        self.used[len(self.used) - 1] += _SIZE_OF_DOUBLE * count
        return taken

    def zeros(self, count):
        """Return a new array of `count` doubles."""
        if cython.compiled:
            return self._take(count)
        else:  # noqa: RET505  (uncompiled, the types differ)
            return self._list("d", [0.0] * count)

    def marks(self, count):
        """Return a new array of `count` integers."""
        if cython.compiled:
            return cython.cast("int *", self._take((count + 1) // 2))
        else:  # noqa: RET505
            return self._list("i", [0] * count)

    def _list(self, code, numbers):
        """Note a new list and the type of its items, and return it."""
        self.codes.append(code)
        self.blocks.append(numbers)
        return numbers

    def doubles(self, values):
        """Return a new array with the given doubles."""
        given = list(values)
        placed = self.zeros(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def integers(self, values):
        """Return a new array with the given integers."""
        given = list(values)
        placed = self.marks(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def seen(self, numbers, count):
        """Return a view of an array of doubles for Python; it keeps the memory alive."""
        if cython.compiled:
            return self._view(cython.cast("char *", numbers), _SIZE_OF_DOUBLE * count).cast("d")
        else:  # noqa: RET505
            return View(numbers, count, "d")

    def seen_marks(self, numbers, count):
        """Return such a view of an array of integers."""
        if cython.compiled:
            return self._view(cython.cast("char *", numbers), _SIZE_OF_INTEGER * count).cast("i")
        else:  # noqa: RET505
            return View(numbers, count, "i")

    def content(self):
        """Return the numbers of all arrays as bytes."""
        if cython.compiled:
            first = _SIZE_OF_DOUBLE * _LINE
            parts = [
                block[first : first + used]
                for block, used in zip(self.blocks, self.used)  # noqa: B905  (one for each block)
            ]
            return b"".join(parts)
        else:  # noqa: RET505
            return b"".join(map(bytes, map(array, self.codes, self.blocks)))

    def put_back(self, content, at):
        """Set the numbers of all arrays to those of `content[at:]`."""
        if cython.compiled:
            first = _SIZE_OF_DOUBLE * _LINE
            for k in range(len(self.blocks)):
                used = self.used[k]
                self.blocks[k][first : first + used] = content[at : at + used]
                at += used
        else:
            for code, block in zip(self.codes, self.blocks, strict=True):
                size = array(code).itemsize * len(block)
                block[:] = array(code, content[at : at + size])
                at += size

    def _view(self, address, size):
        """Return a view of `size` bytes at an address within one of the blocks."""
        for block in self.blocks:
            at = address - PyByteArray_AsString(block)  # noqa: F821
            if 0 <= at < len(block):
                return memoryview(block)[at : at + size]
        raise ValueError("this array belongs to another Memory; use the one that allocated it")


class Lent:
    """An array of doubles from Python, whose address stays valid as long as this object lives.

    Compiled, `numbers` is its address: Cython's typed memoryviews would add 18 000 lines of C.

    Parameters
    ----------
    given : a contiguous, writable buffer; or None, which has no address

    Raises
    ------
    ValueError : if it is not a one-dimensional array of doubles.
    """

    def __init__(self, given):
        if not cython.compiled:
            self.numbers = given
        elif given is not None:
            PyObject_GetBuffer(  # noqa: F821
                given,
                cython.address(self.view),
                PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE | PyBUF_FORMAT,  # noqa: F821
            )
            if (
                self.view.ndim != 1
                or self.view.itemsize != _SIZE_OF_DOUBLE
                or self.view.format[0] != _DOUBLE
            ):
                raise ValueError("an array of doubles is needed")
            self.numbers = cython.cast("double *", self.view.buf)

    def __dealloc__(self):
        """Release the buffer."""
        PyBuffer_Release(cython.address(self.view))  # noqa: F821
