"""Roads and loads as signals, each a chain of segments (cubic plus cosine)."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from math import cos, fabs, sin
from typing import TYPE_CHECKING

from ..arrays import Memory
from ..language import Doubles, inline
from ..layout import (
    AMPLITUDE,
    ANGLE,
    C0,
    C1,
    C2,
    C3,
    CHIRP,
    ORIGIN,
    SEGMENT,
    SPEED,
    START,
    UNBOUNDED,
)
from ..state import KernelState

if TYPE_CHECKING:
    from ...signals import Signal

ROAD_PHASE = 1.5  # phase of a road's sinusoid per macro step


class Signals:
    """All signals of a system, each in its present segment."""

    count: int

    def __init__(self, memory: Memory, state: KernelState, signals: Mapping[str, Signal]) -> None:
        self.state = state
        count = [len(signal.segments) for signal in signals.values()]
        self.count = len(count)
        self.signal_count = memory.integers(count or [0])
        self.signal_first = memory.integers(accumulate(count, initial=0))
        self.signal_now = self.state.memory.marks(max(self.count, 1))
        self.segments = sum(count)
        self.segment = memory.zeros(SEGMENT * max(sum(count), 1))
        self.level = memory.marks(max(sum(count), 1))  # whether a segment is constant
        # roads are measured from the datum, as all displacements are in the kernel
        self.is_road = memory.marks(max(self.count, 1))
        self.acts = memory.marks(max(self.count, 1))  # whether it is a road or a load
        self.height = memory.zeros(max(sum(count), 1))  # c0 of each segment, measured from zero
        self.road = memory.zeros(4 * max(self.count, 1))  # value and three derivatives of each

    def enter_signals(self, x: Doubles, at: int) -> int:
        """Read the segments of all signals from x[at:]; return where they end."""
        for i in range(SEGMENT * self.segments):
            self.segment[i] = x[at + i]
        self.state.datum = 0.0
        for k in range(self.segments):
            self.height[k] = self.segment[k * SEGMENT + C0]
            self.find_level(k)
        return at + SEGMENT * self.segments

    def set_datum(self, datum: float) -> None:
        """Measure the heights of all roads from `datum`, m."""
        if datum == self.state.datum:
            return
        self.state.datum = datum
        for s in range(self.count):
            if self.is_road[s]:
                for k in range(self.signal_first[s], self.signal_first[s] + self.signal_count[s]):
                    self.segment[k * SEGMENT + C0] = self.height[k] - datum

    def find_level(self, k: int) -> None:
        """Find whether segment k is constant, after its numbers have changed."""
        self.level[k] = 1
        for i in range(C1, AMPLITUDE + 1):
            if self.segment[k * SEGMENT + i] != 0.0:
                self.level[k] = 0

    def enter_segment(self, s: int, t: float) -> float:
        """Move signal s to its segment from t on; return the jump of its value there."""
        now = self.signal_now[s]
        self.signal(s, t)
        before = self.road[4 * s]
        rounding = self._rounding(s, t)
        while (
            self.signal_now[s] + 1 < self.signal_count[s]
            and self.segment[(self.signal_first[s] + self.signal_now[s] + 1) * SEGMENT + START] <= t
        ):
            self.signal_now[s] += 1
        if self.signal_now[s] == now:
            return 0.0
        self.signal(s, t)
        jump = self.road[4 * s] - before
        return jump if fabs(jump) > rounding + self._rounding(s, t) else 0.0

    def _rounding(self, s: int, t: float) -> float:
        """Return how much two continuous segments may differ at t by the rounding of times and sums."""
        at = (self.signal_first[s] + self.signal_now[s]) * SEGMENT
        size = fabs(self.road[4 * s]) + fabs(self.segment[at + C0])
        size += fabs(self.segment[at + AMPLITUDE])
        return 1e-12 * size + 1e-15 * fabs(t) * fabs(self.road[4 * s + 1])

    def replace_signal(self, s: int, t: float, coefficients: Doubles) -> float:
        """Make a one-segment signal a cubic in time from t on; return the jump of its value."""
        self.signal(s, t)
        before = self.road[4 * s]
        at = self.signal_first[s] * SEGMENT
        self.segment[at + ORIGIN] = t
        for i in range(4):
            self.segment[at + C0 + i] = coefficients[i]
        self.segment[at + AMPLITUDE] = 0.0
        self.height[self.signal_first[s]] = coefficients[0]
        if self.is_road[s]:
            self.segment[at + C0] -= self.state.datum
        self.find_level(self.signal_first[s])
        return self.segment[at + C0] - before

    def set_at(self, s: int) -> float:
        """Return the time from which the numbers of a one-segment signal are valid, s."""
        return self.segment[self.signal_first[s] * SEGMENT + ORIGIN]

    def signal(self, s: int, t: float) -> None:
        """Set `road` to value and three derivatives of signal s in its present segment."""
        k = self.signal_first[s] + self.signal_now[s]
        self.read_segment(k, t, self.segment[k * SEGMENT + C0], self.road, 4 * s)

    def read_segment(self, k: int, t: float, c0: float, out: Doubles, to: int) -> None:
        """Set out[to:] to value and three derivatives of segment k, with c0 as its first coefficient."""
        if self.level[k]:
            out[to] = c0
            out[to + 1] = out[to + 2] = out[to + 3] = 0.0
            return
        segment, at = self.segment, k * SEGMENT
        x = t - segment[at + ORIGIN]
        c1, c2, c3 = segment[at + C1], segment[at + C2], segment[at + C3]
        value = c0 + x * (c1 + x * (c2 + x * c3))
        rate = c1 + x * (2.0 * c2 + x * 3.0 * c3)
        acceleration = 2.0 * c2 + 6.0 * c3 * x
        jerk = 6.0 * c3
        amplitude = segment[at + AMPLITUDE]
        if amplitude != 0.0:
            chirp = segment[at + CHIRP]
            angle = segment[at + ANGLE] + x * (segment[at + SPEED] + x * chirp)
            speed = segment[at + SPEED] + 2.0 * chirp * x
            c = amplitude * cos(angle)
            d = amplitude * sin(angle)
            value += c
            rate -= d * speed
            acceleration -= c * speed * speed + 2.0 * chirp * d
            jerk += d * speed * speed * speed - 6.0 * chirp * speed * c
        out[to] = value
        out[to + 1] = rate
        out[to + 2] = acceleration
        out[to + 3] = jerk

    def from_zero(self, s: int, t: float, after: bool, out: Doubles, to: int) -> None:
        """Set out[to:] to value and derivatives of signal s at any t, a road measured from zero.

        At a joint they are those after it if `after`.
        """
        k = self.signal_first[s]
        last = k + self.signal_count[s] - 1
        while k < last:
            middle = (k + last + 1) // 2
            start = self.segment[middle * SEGMENT + START]
            if start < t or (start == t and after):
                k = middle
            else:
                last = middle - 1
        self.read_segment(k, t, self.height[k], out, to)

    def all_signals(self, t: float) -> None:
        for s in range(self.count):
            self.signal(s, t)

    def still(self) -> bool:
        """Return whether all signals are constant in their present segments."""
        for s in range(self.count):
            if not self.is_level(s):
                return False
        return True

    @inline
    def is_level(self, s: int) -> bool:
        """Return whether signal s is constant in its present segment."""
        return self.level[self.signal_first[s] + self.signal_now[s]] != 0

    def next_joint(self) -> float:
        """Return the next time at which a signal changes segment."""
        joint = UNBOUNDED
        for s in range(self.count):
            k = self.signal_now[s] + 1
            if k < self.signal_count[s]:
                start = self.segment[(self.signal_first[s] + k) * SEGMENT + START]
                joint = min(joint, start)
        return joint

    def road_limit(self, t: float) -> float:
        """Return the longest macro step that the sinusoids of roads and loads allow now."""
        limit = UNBOUNDED
        for s in range(self.count):
            at = (self.signal_first[s] + self.signal_now[s]) * SEGMENT
            if self.segment[at + AMPLITUDE] != 0.0 and self.acts[s]:
                x = t - self.segment[at + ORIGIN]
                speed = fabs(self.segment[at + SPEED] + 2.0 * self.segment[at + CHIRP] * x)
                if speed * limit > ROAD_PHASE:
                    limit = ROAD_PHASE / speed
        return limit
