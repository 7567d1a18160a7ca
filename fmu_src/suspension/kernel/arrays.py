"""The memory of the kernel: the arrays of one integrator, side by side.

Compiled, an array is an address within blocks of bytes that live as long as their `Memory`; the cache
lines of two integrators are apart, as threads that write to one line wait for each other. Uncompiled, an
array is one of Python's.
"""

from __future__ import annotations

from array import array

import cython

_LINE = 8  # doubles in a cache line
_BLOCK = 4096  # doubles allocated at a time
_SIZE_OF_DOUBLE, _SIZE_OF_INTEGER = 8, 4  # bytes
_DOUBLE = 100  # "d", the format of a double


class Memory:
    """Where the arrays of an integrator are; they are zero at first, and never given back.

    Parameters
    ----------
    block : doubles allocated at a time
    """

    def __init__(self, block=_BLOCK):
        self.block = block
        self.blocks = []  # of bytes; uncompiled, the arrays themselves
        self.used = []  # bytes of each that arrays take
        self.left = -1  # doubles that are free in the last block; there is none yet

    def _take(self, count):
        """Return so many doubles from the last block, or from a new one."""
        if count > self.left:
            self.left = max(count, self.block)
            block = bytearray(_SIZE_OF_DOUBLE * (self.left + 2 * _LINE))
            self.blocks.append(block)
            self.used.append(0)
            # a line is left free on both sides
            self.free = cython.cast("double *", PyByteArray_AsString(block)) + _LINE  # noqa: F821
        taken = self.free
        self.free += count
        self.left -= count
        self.used[len(self.used) - 1] += _SIZE_OF_DOUBLE * count
        return taken

    def zeros(self, count):
        """Return so many doubles."""
        if cython.compiled:
            return self._take(count)
        else:  # noqa: RET505  (what is not compiled has other types)
            self.blocks.append(array("d", bytes(_SIZE_OF_DOUBLE * count)))
            return self.blocks[-1]

    def marks(self, count):
        """Return so many integers."""
        if cython.compiled:
            return cython.cast("int *", self._take((count + 1) // 2))
        else:  # noqa: RET505
            self.blocks.append(array("i", bytes(_SIZE_OF_INTEGER * count)))
            return self.blocks[-1]

    def doubles(self, values):
        """Return an array of these doubles."""
        given = list(values)
        placed = self.zeros(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def integers(self, values):
        """Return an array of these integers."""
        given = list(values)
        placed = self.marks(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def seen(self, numbers, count):
        """Return an array of doubles as Python sees it: a view that keeps its memory alive."""
        if cython.compiled:
            return self._view(cython.cast("char *", numbers), _SIZE_OF_DOUBLE * count).cast("d")
        else:  # noqa: RET505
            return memoryview(numbers)[:count]

    def seen_marks(self, numbers, count):
        """Return an array of integers as Python sees it."""
        if cython.compiled:
            return self._view(cython.cast("char *", numbers), _SIZE_OF_INTEGER * count).cast("i")
        else:  # noqa: RET505
            return memoryview(numbers)[:count]

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
            return b"".join([block.tobytes() for block in self.blocks])

    def put_back(self, content, at):
        """Set the numbers of all arrays to those of `content[at:]`."""
        if cython.compiled:
            first = _SIZE_OF_DOUBLE * _LINE
            for k in range(len(self.blocks)):
                used = self.used[k]
                self.blocks[k][first : first + used] = content[at : at + used]
                at += used
        else:
            for block in self.blocks:
                size = block.itemsize * len(block)
                block[:] = array(block.typecode, content[at : at + size])
                at += size

    def _view(self, address, size):
        """Return bytes of the block that they are in."""
        for block in self.blocks:
            at = address - PyByteArray_AsString(block)  # noqa: F821
            if 0 <= at < len(block):
                return memoryview(block)[at : at + size]
        raise ValueError("these numbers are in another memory")


class Lent:
    """An array of doubles of Python's, which stays where it is as long as this object lives.

    Compiled, `numbers` is its address: Cython's typed views would bring 18 000 lines of C.

    Parameters
    ----------
    given : in one piece and writable; or None, which has no address

    Raises
    ------
    ValueError : if it holds something else than doubles.
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
        """Give it back."""
        PyBuffer_Release(cython.address(self.view))  # noqa: F821
