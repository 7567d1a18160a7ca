"""One step in one plane: P, the foot D of its normal and the turn angle, and the geometry between them.

The y axes of the planes are parallel to the real axis of the sheet. (AP57 section 3, figure 4.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from phaseplane.constructions.geometry import meet

States = tuple[complex, ...]
"""One point of the sheet for each plane."""

Points = dict[str, complex]
"""The named points of a construction."""

Construct = Callable[[States], tuple[States, Points]]
"""The construction for the time of one step: feet of the normals, and all its points."""

_ROUNDING = 1e-9  # of the second normal: a first one no longer than this has no direction
_FAR = 1e6  # normals; a circle of this radius is a straight line on any sheet


class Move(NamedTuple):
    """The result of a step: the successors P', auxiliary points, the repeated construction.

    `helpers` has one point for each plane by a name in which {n} is the plane's number.
    """

    successors: States
    helpers: Mapping[str, States]
    repeated: Points


class Step(NamedTuple):
    """P, its foot D and turn angle; the predicted P'* and its foot D'*, or P and D again."""

    p: complex
    d: complex
    turn: float
    p_new: complex
    d_new: complex

    @property
    def along_tangent(self) -> complex:
        """The way from P along the tangent, as long as the arc."""
        return along_tangent(self.p, self.d, self.turn)

    @property
    def starts_in_foot(self) -> bool:
        """Whether P is D to rounding, as where dry friction gives way: there is no normal."""
        return abs(self.p - self.d) <= _ROUNDING * abs(self.p_new - self.d_new)

    @property
    def mean_share(self) -> float:
        """Mean of both normals, relative to the first; 1 if there is none."""
        if self.starts_in_foot:
            return 1.0
        return 0.5 * (1.0 + abs(self.p_new - self.d_new) / abs(self.p - self.d))

    @property
    def centre(self) -> complex | None:
        """The centre S of the osculating circle: where both normals cross (AP57 figure 4b)."""
        if self.starts_in_foot or self.p_new == self.d_new:
            return None
        return meet(self.p, self.d, self.p_new, self.d_new)

    @property
    def far_centre(self) -> complex:
        """A point of the normal so far off that the circle about it is the tangent."""
        return self.p + _FAR * (self.d - self.p)


def along_tangent(state: complex, foot: complex, turn: float) -> complex:
    """Return the step along the tangent, as long as the normal times the angle (AP57 eq. 8)."""
    return 1j * turn * (state - foot)
