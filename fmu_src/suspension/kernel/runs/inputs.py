"""The inputs of a run: their present values, and their rates of change from the samples of a host."""

from __future__ import annotations

from math import fabs

from ..arrays import Memory

_SAMPLES = 3  # for two slopes
_LONGEST = 2.0  # longest extrapolation, in intervals of the last slope


class Inputs:
    """Values of inputs, and the last samples of each."""

    def __init__(self, memory: Memory, count: int) -> None:
        self.memory, self.count = memory, count
        self.value = self.memory.zeros(count)
        self.samples = self.memory.marks(count)
        self.sample_time = self.memory.zeros(_SAMPLES * count)
        self.sample_value = self.memory.zeros(_SAMPLES * count)

    def start(self) -> None:
        """Reset all inputs: none has been set."""
        for i in range(self.count):
            self.value[i] = 0.0
            self.samples[i] = 0

    def set(self, i: int, value: float, time: float) -> None:
        """Set input i from a time on; a call at the same time replaces an earlier one."""
        at = _SAMPLES * i
        count = self.samples[i]
        while count > 0 and self.sample_time[at + count - 1] >= time:
            count -= 1
        if count == _SAMPLES:
            for k in range(1, _SAMPLES):
                self.sample_time[at + k - 1] = self.sample_time[at + k]
                self.sample_value[at + k - 1] = self.sample_value[at + k]
            count -= 1
        self.sample_time[at + count] = time
        self.sample_value[at + count] = value
        self.samples[i] = count + 1
        self.value[i] = value

    def since(self, i: int) -> float:
        """Return when input i was last set, s; 0 if it never was."""
        count = self.samples[i]
        return self.sample_time[_SAMPLES * i + count - 1] if count > 0 else 0.0

    def slope(self, i: int, until: float) -> float:
        """Return the rate of change of input i for a step that ends at `until`, s.

        0 if the step ends more than two intervals after the last sample: an input that a host has not
        set for so long is taken as constant.
        """
        if self.samples[i] < _SAMPLES:
            return 0.0
        at = _SAMPLES * i
        t0, t1, t2 = self.sample_time[at], self.sample_time[at + 1], self.sample_time[at + 2]
        f0, f1, f2 = self.sample_value[at], self.sample_value[at + 1], self.sample_value[at + 2]
        if until - t2 > _LONGEST * (t2 - t1) * (1.0 + 1e-9):
            return 0.0
        before = (f1 - f0) / (t1 - t0)
        last = (f2 - f1) / (t2 - t1)
        if before * last <= 0.0:
            return 0.0
        return before if fabs(before) <= fabs(last) else last
