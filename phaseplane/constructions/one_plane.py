"""The construction in one phase plane (AP57 section 3, figure 2).

    M y'' + Phi(y', y) + c y + G(y) = -M xi'',    y = x - xi                      (AP57 eq. 3)

With y' = Omega y-bar and Omega^2 = c / M the normal of the integral curve goes through
P = (y, y-bar) and D = (-delta, 0), delta = (Phi + G) / c + xi'' / Omega^2 (AP57 eq. 6).
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

from phaseplane.constructions.construction import Construction
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.primitives import Curve, Plane, Scheme
from phaseplane.constructions.schemes import feet, marks, raised, scheme, strokes, turns
from phaseplane.constructions.storage import StoredFrames


def one_plane_scheme(excitation: str, letter: str = "y", also: str = "") -> Scheme:
    """Return AP57 figure 2 in the order of drawing.

    Parameters
    ----------
    excitation : describes the step from A* to D
    letter : of the axis of displacement
    also : a point that is marked from the start
    """
    return scheme(
        (
            *feet(f"The state point P and its foot Q on the {letter} axis.", ""),
            marks("excitation", also),
        ),
        raised(
            f"From P parallel to the {letter} axis to the auxiliary curve: A. Down to the axis: A*.",
            "",
        ),
        (excitation, marks("normal", "D"), strokes("excitation", "A*-D")),
        ("DP is the normal of the integral curve.", strokes("normal", "D-P")),
        turns(""),
    )


class OnePlane(Construction):
    """The common part of the constructions in a single phase plane."""

    @property
    @abstractmethod
    def lienard(self) -> Lienard:
        """The plane with its auxiliary curves."""

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """The one phase plane."""
        return (self.lienard.plane,)

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the family of auxiliary curves."""
        return self.lienard.curves(frames)
