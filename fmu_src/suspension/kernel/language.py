"""Words of the kernel's sources that Python does not have: C's types and functions, and marks.

`kernel_types` reads them, for Cython and for the translation to C. Uncompiled they mean nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

Routine = TypeVar("Routine", bound=Callable[..., Any])

Doubles = list[float]  # an array of doubles
Integers = list[int]  # an array of C's integers
Long = int  # an integer of 64 bits
Size = int  # a length of one of Python's objects
Address = Any  # of a byte
Buffer = Any  # the memory of one of Python's objects, as C sees it
Numbers = Sequence[float]  # of Python
Lendable = Any  # an array of doubles of Python's, contiguous and writable
Switch = tuple[float, int, int, int, int]  # time, element, kind, branch before, branch after

# only the compiled kernel calls C and Python's interface for it
memcpy: Any = None
PyBUF_C_CONTIGUOUS: Any = None
PyBUF_FORMAT: Any = None
PyBUF_WRITABLE: Any = None
PyBuffer_Release: Any = None
PyByteArray_AsString: Any = None
PyErr_CheckSignals: Any = None
PyObject_GetBuffer: Any = None


def uses_python(routine: Routine) -> Routine:
    """Mark a routine that can raise, although only C's types are among its own."""
    return routine


def inline(routine: Routine) -> Routine:
    """Mark a routine that takes the place of its calls: without them steps take 3 to 25 % longer."""
    return routine


def open_to_python(routine: Routine) -> Routine:
    """Mark a method that Python calls, too."""
    return routine


def of_python(routine: Routine) -> Routine:
    """Mark a routine of Python, whose types are no types of C."""
    return routine


def takes_gil(routine: Routine) -> Routine:
    """Mark a routine that calls Python, and is called by others that do not hold its lock."""
    return routine
