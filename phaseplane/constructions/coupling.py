"""Projection from one phase plane into the next: lines I and II between them (AP57 figures 7, 12)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from phaseplane.constructions.geometry import at_height
from phaseplane.constructions.primitives import Curve, Plane
from phaseplane.constructions.sheet import trail
from phaseplane.constructions.storage import StoredFrames


@dataclass(frozen=True, slots=True)
class Lines:
    """Two planes with parallel y axes, and the lines that project each onto the other.

    X and Q are points on the y axis of each plane. The line through X1 and X2 cuts line I in C1 and
    line II in C2. Q1, projected through C1 to the axis of plane 2, gives D2 with
    X2D2 = b/a kappa21 X1Q1; Q2 through C2 gives D1 with X1D1 = a/b kappa12 X2Q2. Both lengths are
    opposite in sense to the projected ones.

    Parameters
    ----------
    axis_1, axis_2 : heights of the y axes on the sheet, m
    line_1, line_2 : heights of lines I and II, m
    """

    axis_1: float
    axis_2: float
    line_1: float
    line_2: float

    @classmethod
    def between(
        cls, axis_1: float, axis_2: float, ratio: float, kappa_12: float, kappa_21: float
    ) -> Lines:
        """Return the lines for given couplings and scales.

        Parameters
        ----------
        axis_1, axis_2 : heights of the y axes on the sheet, m
        ratio : r = b / a, scale of plane 2 over that of plane 1
        kappa_12, kappa_21 : weight of plane 2 in plane 1 and of plane 1 in plane 2, magnitudes
        """
        way = axis_2 - axis_1
        return cls(
            axis_1,
            axis_2,
            axis_1 + way / (1.0 + ratio * kappa_21),
            axis_1 + way * kappa_12 / (ratio + kappa_12),
        )

    def to_plane_2(self, x_1: complex, x_2: complex, q_1: complex) -> tuple[complex, complex]:
        """Return C1 and D2."""
        c_1 = at_height(x_1, x_2, self.line_1)
        return c_1, at_height(q_1, c_1, self.axis_2)

    def from_plane_1(self, d_1: complex, x_2: complex, q_2: complex) -> tuple[complex, complex]:
        """Return C2 and X1 for a known D1: the projection of `to_plane_1` backwards."""
        c_2 = at_height(q_2, d_1, self.line_2)
        return c_2, at_height(x_2, c_2, self.axis_1)

    def to_plane_1(self, x_1: complex, x_2: complex, q_2: complex) -> tuple[complex, complex]:
        """Return C2 and D1."""
        c_2 = at_height(x_1, x_2, self.line_2)
        return c_2, at_height(q_2, c_2, self.axis_1)


def lines_across(
    lines: Lines,
    names: tuple[str, str],
    pair: tuple[Plane, Plane],
    frames: StoredFrames,
    others: Sequence[str] = (),
) -> tuple[Curve, ...]:
    """Return lines I and II, across everything drawn in their two planes."""
    abscissae = [z.real for plane in pair for z in trail(plane, frames)]
    wanted = (*(plane.foot for plane in pair), *others)
    abscissae += [z.real for name in wanted for z in frames.points(name)]
    left, right = min(abscissae), max(abscissae)
    margin = 0.05 * (right - left) or 0.1 * abs(lines.axis_2 - lines.axis_1)
    return tuple(
        Curve("line", (complex(left - margin, height), complex(right + margin, height)), name)
        for height, name in zip((lines.line_1, lines.line_2), names, strict=True)
    )
