"""The step that is being tried."""

from __future__ import annotations


class Trial:
    """Its length, where it ends, and what its attempts so far have shown."""

    def __init__(self) -> None:
        self.joint = 0.0  # the next joint of a signal, s
        self.begin(0.0)

    def begin(self, length: float) -> None:
        """Begin with a proposed length, s."""
        self.length = length
        self.end = 0.0  # its latest end, s
        self.to_end = False  # whether it ends there
        self.on_knot = False  # whether it is shortened to a point of a smooth table
        self.cuts = 0  # how often to such a point
        self.flips = 0  # elements that left their branch at once
        self.lands = False  # whether it ends on a switch
        # the next step, by the error of the last attempt; 0 if that is no measure
        self.longer = 0.0

    def stop_at(self, latest: float, time: float) -> None:
        """End at the next joint, or at a latest time before it, unless the step ends before that."""
        self.end = min(self.joint, latest)
        self.to_end = time + self.length * (1.0 + 1e-9) >= self.end
        if self.to_end:
            self.length = self.end - time
