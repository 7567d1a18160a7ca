"""The memory of an integrator, which contains all of its arrays next to each other.

Compiled, an array is an address within blocks of bytes that live as long as their `Memory`. Two
integrators never share a cache line, because threads that write to the same line wait for each other.
Uncompiled, it is a list, whose items Python reads in half the time that it takes with an `array`.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Sequence
from typing import Any

import cython

from .language import (
    Address,
    Buffer,
    Doubles,
    Integers,
    Lendable,
    PyBUF_C_CONTIGUOUS,
    PyBUF_FORMAT,
    PyBUF_WRITABLE,
    PyBuffer_Release,
    PyByteArray_AsString,
    PyObject_GetBuffer,
    Size,
    of_python,
    uses_python,
)

if not cython.compiled:

    class View(Sequence[float]):
        """The first numbers of a list, as a memoryview shows those of an array."""

        def __init__(self, numbers: list[Any], count: int, code: str) -> None:
            self.numbers, self.length, self.format = numbers, count, code

        def __len__(self) -> int:
            return self.length

        def __getitem__(self, at: Any) -> Any:
            return self.numbers[: self.length][at]

        def __setitem__(self, at: int, value: float) -> None:
            self.numbers[at] = value

        def tolist(self) -> list[float]:
            return self.numbers[: self.length]


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

    def __init__(self, block: Size = _BLOCK) -> None:
        self.block = block
        self.blocks: list[Any] = []  # of bytes; uncompiled, the lists themselves
        self.codes: list[str] = []  # uncompiled, the types of their items: "d" or "i"
        self.used: list[int] = []  # bytes of each block that arrays occupy
        self.left: Size = -1  # free doubles in the last block; -1 while there is no block

    @uses_python
    def _take(self, count: Size) -> Doubles:
        """Return `count` doubles of the last block, or of a new one."""
        if count > self.left:
            self.left = max(count, self.block)
            block = bytearray(_SIZE_OF_DOUBLE * (self.left + 2 * _LINE))
            self.blocks.append(block)
            self.used.append(0)
            # one cache line is left free on both sides
            self.free: Doubles = cython.cast("double *", PyByteArray_AsString(block))
            self.free += _LINE  # an address
        taken = self.free
        self.free += count  # type: ignore[arg-type]
        self.left -= count
        self.used[len(self.used) - 1] += _SIZE_OF_DOUBLE * count
        return taken

    @uses_python
    def zeros(self, count: Size) -> Doubles:
        """Return a new array of `count` doubles."""
        if cython.compiled:
            return self._take(count)
        else:  # noqa: RET505  (uncompiled, the types differ)
            return self._list("d", [0.0] * count)

    @uses_python
    def marks(self, count: Size) -> Integers:
        """Return a new array of `count` integers."""
        if cython.compiled:
            return cython.cast("int *", self._take((count + 1) // 2))
        else:  # noqa: RET505
            return self._list("i", [0] * count)

    @of_python
    def _list(self, code: str, numbers: list[Any]) -> list[Any]:
        """Note a new list and the type of its items, and return it."""
        self.codes.append(code)
        self.blocks.append(numbers)
        return numbers

    def doubles(self, values: Iterable[float]) -> Doubles:
        """Return a new array with the given doubles."""
        given = list(values)
        placed = self.zeros(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def integers(self, values: Iterable[int]) -> Integers:
        """Return a new array with the given integers."""
        given = list(values)
        placed = self.marks(len(given))
        for i in range(len(given)):
            placed[i] = given[i]
        return placed

    def seen(self, numbers: Doubles, count: Size) -> Any:
        """Return a view of an array of doubles for Python; it keeps the memory alive."""
        if cython.compiled:
            return self._view_of(cython.cast("char *", numbers), _SIZE_OF_DOUBLE * count).cast("d")
        else:  # noqa: RET505
            return View(numbers, count, "d")

    def seen_marks(self, numbers: Integers, count: Size) -> Any:
        """Return such a view of an array of integers."""
        if cython.compiled:
            return self._view_of(cython.cast("char *", numbers), _SIZE_OF_INTEGER * count).cast("i")
        else:  # noqa: RET505
            return View(numbers, count, "i")

    def content(self) -> bytes:
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

    def put_back(self, content: bytes, at: Size) -> None:
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

    def _view_of(self, address: Address, size: Size) -> Any:
        """Return a view of `size` bytes at an address within one of the blocks."""
        for block in self.blocks:
            at = address - PyByteArray_AsString(block)
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

    _view: Buffer

    def __init__(self, given: Lendable) -> None:
        if not cython.compiled:
            self.numbers: Doubles = given
        elif given is not None:
            PyObject_GetBuffer(
                given,
                cython.address(self._view),
                PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE | PyBUF_FORMAT,
            )
            if (
                self._view.ndim != 1
                or self._view.itemsize != _SIZE_OF_DOUBLE
                or self._view.format[0] != _DOUBLE
            ):
                raise ValueError("an array of doubles is needed")
            self.numbers = cython.cast("double *", self._view.buf)

    def __dealloc__(self) -> None:
        """Release the buffer."""
        PyBuffer_Release(cython.address(self._view))
