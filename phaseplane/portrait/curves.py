"""Curves in the plane: nullclines, isoclines, energy levels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import sqrt

import numpy as np
import numpy.typing as npt
from contourpy import contour_generator

from phaseplane.portrait.energy import potential
from phaseplane.portrait.system import Grid, PhaseSystem, Window

Curves = list[Grid]
"""Polylines of shape (points, 2): x and x'."""

_POINTS, _OF_SWITCHES, _OF_ENERGY = 300, 120, 401  # along each side of the window
_LEVELS = 12  # of energy over the window
_CLOSE = 0.05  # of a cell
_JUMP = 1e-9  # of both sides: less is rounding
_IN_WELLS = 3  # levels in each well below its lower rim


def nullcline(system: PhaseSystem, window: Window) -> Curves:
    """Return the curves x'' = 0: f(x', x, 0) = 0. The other nullcline, x' = 0, is the x axis."""
    return isocline(system, window, 0.0)


def isocline(system: PhaseSystem, window: Window, slope: float) -> Curves:
    """Return the curves of equal slope dx'/dx = -f / x': f + slope x' = 0 (AP57 section 3)."""
    return isoclines(system, window, [slope])[0]


def isoclines(system: PhaseSystem, window: Window, slopes: Sequence[float]) -> list[Curves]:
    """Return the isoclines of several slopes."""
    x, v = window.grid(_POINTS, _POINTS)
    forces = system.forces(x, v)
    cell = np.array([window.width, window.height]) / (_POINTS - 1)
    return [
        [
            part
            for line in _levels(x, v, forces + slope * v, [0.0])[0]
            for part in _parts(line, _is_root(system, line, slope, cell))
        ]
        for slope in slopes
    ]


def _is_root(system: PhaseSystem, line: Grid, slope: float, cell: Grid) -> npt.NDArray[np.bool_]:
    """Return whether points are on the isocline: not where f jumps past it, nor at rest.

    Around a point of the isocline f + slope x' grows with the distance. Where it jumps, it is as large
    close by as a cell away; where it is zero all around, any curve is as good.
    """
    cross = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])[:, None, :] * cell

    def around(part: float) -> Grid:
        x, v = np.moveaxis(line + part * cross, -1, 0)
        return np.abs(system.forces(x, v) + slope * v)

    far, near = around(1.0), around(_CLOSE)
    with np.errstate(invalid="ignore"):
        grows = near.max(axis=0) < 0.5 * far.max(axis=0)
        zero = around(0.0).max(axis=0) <= 0.1 * far.max(axis=0)
    everywhere = (near == 0.0).sum(axis=0) >= 3
    moves = (np.abs(line[:, 1]) > 1e-3 * cell[1]) | (slope == 0.0)
    return grows & zero & ~everywhere & moves


def _parts(line: Grid, good: npt.NDArray[np.bool_]) -> list[Grid]:
    """Return the parts of a polyline of which all points are good."""
    cuts = np.flatnonzero(good[1:] != good[:-1]) + 1
    return [
        part
        for part, kept in zip(np.split(line, cuts), good[np.r_[0, cuts]], strict=True)
        if kept and len(part) > 1
    ]


def switch_lines(system: PhaseSystem, window: Window) -> Curves:
    """Return the lines on which f jumps, at time 0."""
    switching = system.switching
    if switching is None or not switching.jumps:
        return []
    x, v = window.grid(_OF_SWITCHES, _OF_SWITCHES)
    found: Curves = []
    for k, guard in enumerate(switching.guards):

        def value(v: float, x: float, k: int = k, guard: Callable[..., float] = guard) -> float:
            return guard(v, x, 0.0, switching.signs(v, x, 0.0)[:k])

        def jumps(v: float, x: float, k: int = k) -> bool:
            signs = switching.signs(v, x, 0.0)
            sides = [[*signs[:k], side, *signs[k + 1 :]] for side in (-1.0, 1.0)]
            low, high = (switching.function(v, x, 0.0, side) for side in sides)
            return abs(high - low) > _JUMP * (abs(low) + abs(high))

        over = np.vectorize(value, otypes=[float])(v, x)
        for line in _levels(x, v, over, [0.0])[0]:
            found += _parts(line, np.array([jumps(b, a) for a, b in line.tolist()], bool))
    return found


def energy_levels(
    system: PhaseSystem, window: Window, levels: Sequence[float] | int = _LEVELS
) -> tuple[Grid, list[Curves]]:
    """Return curves of constant energy x'^2 / 2 + U(x), U' = f(0, x, 0), with min U = 0.

    Without damping they are the integral curves.

    Parameters
    ----------
    levels : energies above the minimum in the window, or their number

    Returns
    -------
    The energies, and the curves of each.
    """
    x, v = window.grid(_OF_ENERGY, _OF_ENERGY)
    energy = 0.5 * v**2 + potential(system, x[0])
    if isinstance(levels, int):  # evenly spaced in velocity, and so in the plane
        energies = np.linspace(0.0, np.sqrt(np.nanmax(energy)), levels + 2)[1:-1] ** 2
    else:
        energies = np.array(levels, float)
    return energies, _levels(x, v, energy, energies.tolist())


def levels_apart(
    system: PhaseSystem, window: Window, saddles: Sequence[float], levels: Sequence[float]
) -> list[float]:
    """Return given energies and others between them, none close to those of saddles.

    Parameters
    ----------
    saddles : their displacements
    levels : energies of curves that are wanted
    """
    x = np.linspace(window.left, window.right, _OF_ENERGY)
    places = np.unique(np.concatenate([x, saddles]))
    energy = potential(system, places)
    speeds = [sqrt(e) for e in energy[np.isin(places, saddles)] if np.isfinite(e)]
    most = sqrt(0.5 * max(abs(window.top), abs(window.bottom)) ** 2 + float(np.nanmax(energy)))
    even = np.linspace(0.0, most, _LEVELS + 2)[1:-1]
    found: list[float] = []
    for wanted, beside, apart in ((np.sqrt(levels), [], 0.05), (even, speeds, 0.4)):
        for speed in wanted.tolist():
            if all(abs(speed - other) > apart * even[0] for other in (*beside, *found)):
                found.append(speed)
    return [speed**2 for speed in sorted(found)]


def levels_in_wells(system: PhaseSystem, window: Window) -> list[float]:
    """Return energies between the bottom and the lower rim of each well, above the minimum."""
    well = potential(system, np.linspace(window.left, window.right, 2001))
    tops = 1 + np.flatnonzero((well[1:-1] > well[:-2]) & (well[1:-1] >= well[2:]))
    if not len(tops):
        return []
    # the sides of the window are rims where they rise above the nearest top
    rims = [k for k, top in ((0, tops[0]), (len(well) - 1, tops[-1])) if well[k] > well[top]]
    found: list[float] = []
    for a, b in pairwise(sorted([*tops.tolist(), *rims])):
        bottom, rim = float(np.nanmin(well[a : b + 1])), float(min(well[a], well[b]))
        parts = np.arange(1, _IN_WELLS + 1) / (_IN_WELLS + 1)
        found += (bottom + (rim - bottom) * parts**2).tolist()
    return sorted(set(np.round(found, 12)))


def _levels(x: Grid, v: Grid, z: Grid, levels: Sequence[float]) -> list[Curves]:
    generator = contour_generator(x, v, np.ma.masked_invalid(z))
    return [[np.asarray(line) for line in generator.lines(level)] for level in levels]
