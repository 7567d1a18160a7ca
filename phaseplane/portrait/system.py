"""The system of a portrait: one second-order equation, or a section of a larger system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, inf
from typing import Any

import numpy as np
import numpy.typing as npt

from phaseplane.equations.switching import Switching
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.systems import System

Function = Callable[[Any, Any, Any], Any]
"""f(x', x, t) of x'' + f = 0."""

Grid = npt.NDArray[np.float64]

_LARGEST = 1e150  # from zero, of a side of a window: its square is finite


@dataclass(frozen=True, slots=True)
class PhaseSystem:
    """x'' + f(x', x, t) = 0 in its phase plane (x, x').

    Parameters
    ----------
    function : f(x', x, t) of three numbers
    corners : displacements at which f has a corner
    rate_corners : velocities at which f has a corner
    period : of f in time, s; 0 if f does not depend on time
    on_arrays : f of three arrays of equal shape; by default `function` is called with arrays, or
        number by number if it does not accept them
    switching : the same f with its switches, if it jumps: motions are then followed through them
    turn : of x after which f is the same again, as of a pendulum's angle; 0 if there is none
    """

    function: Function
    corners: tuple[float, ...] = ()
    rate_corners: tuple[float, ...] = ()
    period: float = 0.0
    on_arrays: Function | None = None
    switching: Switching | None = None
    turn: float = 0.0

    @property
    def driven(self) -> bool:
        """Whether f depends on time."""
        return self.period > 0.0

    def wrapped(self, x: Grid) -> Grid:
        """Return angles within half a turn of zero; x itself where f has no turn."""
        return x - self.turn * np.round(x / self.turn) if self.turn else x

    def repeats(self, turn: float) -> bool:
        """Return whether f depends on x, and is the same a turn further."""
        places = np.random.default_rng(1).uniform(-1.0, 1.0, (3, 64))
        x, v, t = turn * places[0], 3.0 * places[1], (self.period or 1.0) * places[2]
        here, there, between = (self.forces(x + part * turn, v, t) for part in (0.0, 1.0, 0.37))
        known = np.isfinite(here) & np.isfinite(there) & np.isfinite(between)
        if not known.any():
            return False
        here, there, between = here[known], there[known], between[known]
        size = 1e-9 * max(1.0, np.abs(here).max())
        return bool(np.abs(there - here).max() <= size < np.abs(between - here).max())

    def forces(self, x: npt.ArrayLike, v: npt.ArrayLike, t: npt.ArrayLike = 0.0) -> Grid:
        """Return f over arrays of equal shape; NaN where f is undefined."""
        # -0 as 0, on the same side of a pole
        x, v = np.asarray(x, float) + 0.0, np.asarray(v, float) + 0.0
        t = np.broadcast_to(np.asarray(t, float), x.shape)
        with np.errstate(all="ignore"):
            return self.over_arrays(x, v, t)(v, x, t)

    def over_arrays(self, x: Grid, v: Grid, t: Grid) -> Function:
        """Return f(x', x, t) as a function of arrays of equal shape, after a trial with these."""
        function = self.on_arrays or self.function
        with np.errstate(all="ignore"):
            try:
                found = np.asarray(function(v, x, t), float)
            except (TypeError, ValueError):  # a function of numbers alone
                return np.vectorize(self._number, otypes=[float])
        if found.shape == x.shape:
            return function
        return lambda v, x, t: np.broadcast_to(np.asarray(function(v, x, t), float), x.shape)

    def _number(self, v: float, x: float, t: float) -> float:
        try:
            return float(self.function(v, x, t))
        except (ValueError, ArithmeticError, TypeError):
            return float("nan")

    def frozen(self, time: float) -> PhaseSystem:
        """Return the autonomous system with f at a fixed time, s."""
        function, on_arrays = self.function, self.on_arrays
        return PhaseSystem(
            lambda v, x, _t: function(v, x, time),
            self.corners,
            self.rate_corners,
            on_arrays=on_arrays and (lambda v, x, t: on_arrays(v, x, np.full_like(t, time))),
            switching=self.switching and self.switching.frozen(time),
        )


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangular part of the plane.

    Parameters
    ----------
    left, right : of x
    bottom, top : of x'

    Raises
    ------
    ValueError : sides that are too far from zero or not in order.
    """

    left: float
    right: float
    bottom: float
    top: float

    def __post_init__(self) -> None:
        most = _LARGEST
        if not (-most < self.left < self.right < most and -most < self.bottom < self.top < most):
            raise ValueError(
                f"a window from {self.left:g} to {self.right:g} and from {self.bottom:g} to "
                f"{self.top:g}: left must be below right and bottom below top, all within {most:g}"
            )

    @property
    def width(self) -> float:
        """From left to right."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """From bottom to top."""
        return self.top - self.bottom

    @property
    def centre(self) -> tuple[float, float]:
        """Its centre, x and x'."""
        return 0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)

    def size(self, x: Grid, v: Grid) -> Grid:
        """Return the sizes of differences of x and x', in widths and heights of the window."""
        return np.hypot(x / self.width, v / self.height)

    def grid(self, columns: int, rows: int) -> tuple[Grid, Grid]:
        """Return x and x' on a grid of shape (rows, columns)."""
        x, v = np.meshgrid(
            np.linspace(self.left, self.right, columns), np.linspace(self.bottom, self.top, rows)
        )
        return x, v

    def holds(
        self, x: npt.ArrayLike, v: npt.ArrayLike, margin: float = 0.0
    ) -> npt.NDArray[np.bool_]:
        """Return whether states are inside the window enlarged by a margin, in parts of its sides."""
        x, v = np.asarray(x), np.asarray(v)
        dx, dv = margin * self.width, margin * self.height
        inside = (x >= self.left - dx) & (x <= self.right + dx)
        return np.asarray(inside & (v >= self.bottom - dv) & (v <= self.top + dv))


def direction_field(
    system: PhaseSystem, window: Window, columns: int = 25, rows: int = 19
) -> tuple[Grid, Grid, Grid, Grid]:
    """Return x, x' and their rates x', x'' on a grid at time 0, of shape (rows, columns)."""
    x, v = window.grid(columns, rows)
    return x, v, v, -system.forces(x, v)


def of_coordinate(system: System, coordinate: int = 0) -> PhaseSystem:
    """Return the section of a system in which one coordinate moves and the others rest at zero.

    The roads are level. For a system of one degree of freedom it is the whole plane. Yielding, which has
    a memory, is refused; dry friction acts against the rate, and jumps where it changes its sign.

    Parameters
    ----------
    coordinate : its index

    Raises
    ------
    ValueError : no such coordinate, or an element that yields, whose friction breaks away, or with a
        spring in series with its damper.
    """
    n = len(system.mass)
    if not 0 <= coordinate < n:
        raise ValueError(
            f"coordinate {coordinate}: must be from 0 to {n - 1} ({', '.join(system.coordinates)})"
        )
    for element in system.elements:
        if min(element.yield_force, element.series) < inf:
            raise ValueError(
                f"{element.name} has a memory: its forces do not depend on x and x' alone, so there "
                "is no phase portrait"
            )
        if element.holding > element.friction:
            raise ValueError(
                f"{element.name}: friction whose breakaway force is above its sliding force has no "
                "phase portrait"
            )
    inverse = np.linalg.inv(np.array(system.mass, float))[coordinate]
    acting = [
        (e, e.direction[coordinate], float(inverse @ np.array(e.direction)))
        for e in system.elements
        if e.direction[coordinate] != 0.0
    ]

    def total(v: float, x: float, sense: float) -> float:
        """Return f with dry friction against the rates that belong to a sense of x'."""
        found = 0.0
        for e, b, share in acting:
            d = b * x
            force = e.spring.force(d) + e.damper.force(b * v) * e.modulation.force(d)
            force += copysign(e.friction, b) * sense
            found += share * (e.limit if d > e.opening else min(force, e.limit))
        return found

    rubs = any(e.friction for e, _, _ in acting)
    guards = ((lambda v, _x, _t, _signs: v),)
    switching = Switching(lambda v, x, _t, signs: total(v, x, signs[0]), guards, autonomous=True)
    laws = [(_over(e.spring), _over(e.damper), _over(e.modulation)) for e, _, _ in acting]

    def on_arrays(v: Grid, x: Grid, _t: Grid) -> Grid:
        total = np.zeros_like(x)
        for (e, b, share), (spring, damper, modulation) in zip(acting, laws, strict=True):
            force = np.zeros_like(x) if spring is None else spring(b * x)
            if damper is not None:
                pull = damper(b * v)
                force = force + (
                    pull * modulation(b * x) if modulation and e.is_modulated else pull
                )
            if e.friction:
                force = force + e.friction * np.sign(b * v)
            if e.limit < inf:
                force = np.where(b * x > e.opening, e.limit, np.minimum(force, e.limit))
            total += share * force
        return total

    return PhaseSystem(
        lambda v, x, _t: total(v, x, copysign(1.0, v) if v else 0.0),
        tuple(sorted({c / b for e, b, _ in acting for c in e.spring.corners})),
        tuple(sorted({c / b for e, b, _ in acting for c in e.damper.corners})),
        on_arrays=on_arrays,
        switching=switching if rubs else None,
    )


def _over(law: Characteristic) -> Callable[[Grid], Grid] | None:
    """Return a characteristic as a function of arrays; None if it is zero."""
    if law.is_zero:
        return None
    if any(piece.power or piece.own for piece in law.pieces):
        return np.vectorize(law.force, otypes=[float])
    if not law.corners and not law.pieces[0].saturation:
        only, (c0, c1, c2, c3) = law.pieces[0].origin, law.pieces[0].coefficients
        if c2 == c3 == 0.0:
            return lambda x: c0 + c1 * (x - only)
    corners = np.array(law.corners)
    origin = np.array([piece.origin for piece in law.pieces])
    c = np.array([piece.coefficients for piece in law.pieces]).T
    saturation = np.array([piece.saturation for piece in law.pieces])
    scale = np.array([piece.scale for piece in law.pieces])

    def force(x: Grid) -> Grid:
        k = np.searchsorted(corners, x, side="right")
        s = x - origin[k]
        found = c[0][k] + s * (c[1][k] + s * (c[2][k] + s * c[3][k]))
        return found + saturation[k] * np.tanh(s / scale[k]) if saturation.any() else found

    return force
