"""What a portrait is of: one equation of second order, or a section of a larger system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import numpy as np
import numpy.typing as npt

from phaseplane.suspension.systems import System

Function = Callable[[float, float, float], float]
"""f(x', x, t) of x'' + f = 0."""

Grid = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PhaseSystem:
    """x'' + f(x', x, t) = 0 in its phase plane (x, x').

    Parameters
    ----------
    function : f(x', x, t)
    corners : displacements at which f has a corner
    rate_corners : velocities at which f has a corner
    period : of f in time, s; 0 where f does not depend on it
    """

    function: Function
    corners: tuple[float, ...] = ()
    rate_corners: tuple[float, ...] = ()
    period: float = 0.0

    def rates(self, t: float, state: npt.ArrayLike) -> list[float]:
        """(x', x'') at a state (x, x'), for an integrator."""
        x, v = np.asarray(state, float)
        return [float(v), -self.function(float(v), float(x), t)]

    def forces(self, x: npt.ArrayLike, v: npt.ArrayLike) -> Grid:
        """f at time 0 over arrays of equal shape."""
        return np.vectorize(lambda a, b: self.function(b, a, 0.0), otypes=[float])(x, v)


@dataclass(frozen=True, slots=True)
class Window:
    """The part of the plane that is looked at.

    Parameters
    ----------
    left, right : of x
    bottom, top : of x'

    Raises
    ------
    ValueError : sides that are not finite or not in order.
    """

    left: float
    right: float
    bottom: float
    top: float

    def __post_init__(self) -> None:
        """Check the sides."""
        if not (-inf < self.left < self.right < inf and -inf < self.bottom < self.top < inf):
            raise ValueError(
                f"a window from {self.left:g} to {self.right:g} and from {self.bottom:g} to "
                f"{self.top:g}: left must lie below right and bottom below top, all finite"
            )

    def grid(self, columns: int, rows: int) -> tuple[Grid, Grid]:
        """x and x' of shape (rows, columns)."""
        x, v = np.meshgrid(
            np.linspace(self.left, self.right, columns), np.linspace(self.bottom, self.top, rows)
        )
        return x, v

    def holds(self, x: float, v: float, margin: float = 0.0) -> bool:
        """Whether a state lies inside, or outside by no more than a part of the sides."""
        dx, dv = margin * (self.right - self.left), margin * (self.top - self.bottom)
        return self.left - dx <= x <= self.right + dx and self.bottom - dv <= v <= self.top + dv


def direction_field(
    system: PhaseSystem, window: Window, columns: int = 25, rows: int = 19
) -> tuple[Grid, Grid, Grid, Grid]:
    """x, x' and their rates x', x'' on a grid at time 0, of shape (rows, columns)."""
    x, v = window.grid(columns, rows)
    return x, v, v, -system.forces(x, v)


def of_coordinate(system: System, coordinate: int = 0) -> PhaseSystem:
    """The section of a system in which one coordinate moves and the others rest at zero.

    On its roads at rest; for a system of one degree of freedom it is the whole plane. Dry friction and
    yielding, which have a memory, are refused.

    Parameters
    ----------
    coordinate : its number

    Raises
    ------
    ValueError : no such coordinate, or an element with a memory.
    """
    n = len(system.mass)
    if not 0 <= coordinate < n:
        raise ValueError(f"coordinate {coordinate}: there are {', '.join(system.coordinates)}")
    for element in system.elements:
        if element.friction or element.yield_force < inf:
            raise ValueError(f"{element.name} has a memory: a phase portrait has none")
    inverse = np.linalg.inv(np.array(system.mass, float))[coordinate]
    acting = [
        (e, e.direction[coordinate], float(inverse @ np.array(e.direction)))
        for e in system.elements
        if e.direction[coordinate] != 0.0
    ]

    def function(v: float, x: float, _t: float) -> float:
        total = 0.0
        for e, b, share in acting:
            d, w = b * x, b * v
            force = e.spring.force(d) + e.damper.force(w) * e.modulation.force(d)
            total += share * min(force, e.limit)
        return total

    return PhaseSystem(
        function,
        tuple(sorted({c / b for e, b, _ in acting for c in e.spring.corners})),
        tuple(sorted({c / b for e, b, _ in acting for c in e.damper.corners})),
    )
