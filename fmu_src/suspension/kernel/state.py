"""The state shared by all steps: a snapshot copies its numbers, and all others follow from them."""

from __future__ import annotations

from array import array
from functools import cache

import cython

from .arrays import _SIZE_OF_INTEGER, Memory
from .language import Address, Long, Size, memcpy, of_python, uses_python
from .layout import UNBOUNDED

_BLOCK_OF_STATE = 256  # doubles, enough for four coordinates and nine elements


class KernelState:
    """The state of an integrator between steps, in two places: the numbers here, and its own memory.

    Whatever must outlive a step is either one of these numbers or an array in `memory`. A snapshot
    contains both, and needs no list of them. Compiled, the numbers are stored next to each other from
    `time` on, in the order of their declarations.
    """

    def __init__(self) -> None:
        self.memory = Memory(_BLOCK_OF_STATE)
        self.time = 0.0
        self.step_start = 0.0  # of the last step, which ends now
        self.grid_start = 0.0  # of fixed steps
        self.proposal = 0.0  # the next step by the last error, s; 0 if there is none
        self.scale = 0.0  # displacement, m; errors below its rounding are negligible
        self.reach = 0.0  # the largest motion so far, m, to which errors are relative
        self.speed = 0.0  # the largest velocity so far, m/s
        self.datum = 0.0  # from which displacements and roads are measured, m
        # energies, J: what contact switches have exchanged; what roads and loads have moved in or out
        self.exchange = self.supplied = 0.0
        self.exchange_in_step = 0.0  # the same before the switches at the end of the last step
        self.initial_energy = self.most_stored = 0.0
        self.brought_at = -UNBOUNDED  # time of the last jump of a road, s
        # time at which a fixed step was first too long, and the stable step then, s
        self.beyond_since = -UNBOUNDED
        self.beyond_step = 0.0
        self.grid_index: Long = 0  # steps of the grid that have been taken
        self.step_count: Long = 0
        self.in_step = False  # whether the branches are those of the last step
        self.entered = False  # whether they have been entered since
        self.stalled = 0  # consecutive steps in which no time has passed
        self.overruns = 0

    def stand_still(self, time: float, scale: float) -> None:
        """Reset the numbers to those before any step."""
        self.time = self.step_start = self.grid_start = time
        self.scale = scale
        self.proposal = 0.0
        self.grid_index = self.step_count = 0
        self.exchange_in_step = 0.0
        self.brought_at = -UNBOUNDED
        self.in_step = True
        self.stalled = self.overruns = 0

    def take_over(self, earlier: KernelState) -> None:
        """Take the extent of a motion, and its sums and counts, from an earlier state."""
        self.scale, self.reach, self.speed = earlier.scale, earlier.reach, earlier.speed
        self.exchange, self.supplied = earlier.exchange, earlier.supplied
        self.initial_energy = earlier.initial_energy
        self.step_count = earlier.step_count

    def content(self) -> bytes:
        """Return all numbers as bytes."""
        if cython.compiled:
            return self._numbers()[: self._size()] + self.memory.content()
        else:  # noqa: RET505  (uncompiled, the types differ)
            numbers = [getattr(self, name) for name in _names()]
            return array("d", numbers).tobytes() + self.memory.content()

    def put_back(self, content: bytes) -> None:
        """Set all numbers to those of some earlier content."""
        if cython.compiled:
            memcpy(self._numbers(), cython.cast("char *", content), self._size())
            self.memory.put_back(content, self._size())
        else:
            names = _names()
            size = array("d").itemsize * len(names)
            for name, x in zip(names, array("d", content[:size]), strict=True):
                setattr(self, name, type(getattr(self, name))(x))
            self.memory.put_back(content, size)

    @uses_python
    def _numbers(self) -> Address:
        """Return the address of the first number."""
        return cython.cast("char *", cython.address(self.time))

    @uses_python
    def _size(self) -> Size:
        """Return the size of the numbers in bytes."""
        last = cython.cast("char *", cython.address(self.overruns))
        return last + _SIZE_OF_INTEGER - self._numbers()


@cache
@of_python
def _names() -> list[str]:
    """Return the names of all numbers, uncompiled.

    They are those of another state: once it has shown its `vars`, Python reads an object more slowly.
    """
    return [name for name, x in vars(KernelState()).items() if isinstance(x, int | float)]
