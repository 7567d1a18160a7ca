"""Curves in the plane: nullclines, isoclines, energy levels."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from contourpy import contour_generator

from phaseplane.portrait.energy import potential
from phaseplane.portrait.system import Grid, PhaseSystem, Window

Curves = list[Grid]
"""Polylines of shape (points, 2): x and x'."""

_IN_WELLS = 3  # levels in each well below its lower rim


def nullcline(system: PhaseSystem, window: Window, resolution: int = 300) -> Curves:
    """Return the curves x'' = 0: f(x', x, 0) = 0. The other nullcline, x' = 0, is the x axis."""
    return isocline(system, window, 0.0, resolution)


def isocline(system: PhaseSystem, window: Window, slope: float, resolution: int = 300) -> Curves:
    """Return the curves of equal slope dx'/dx = -f / x': f + slope x' = 0 (AP57 section 3)."""
    return isoclines(system, window, [slope], resolution)[0]


def isoclines(
    system: PhaseSystem, window: Window, slopes: Sequence[float], resolution: int = 300
) -> list[Curves]:
    """Return the isoclines of several slopes."""
    x, v = window.grid(resolution, resolution)
    forces = system.forces(x, v)
    return [_levels(x, v, forces + slope * v, [0.0])[0] for slope in slopes]


def energy_levels(
    system: PhaseSystem, window: Window, levels: Sequence[float] | int = 12, resolution: int = 401
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
    x, v = window.grid(resolution, resolution)
    energy = 0.5 * v**2 + potential(system, x[0])
    if isinstance(levels, int):  # evenly spaced in velocity, and so in the plane
        energies = np.linspace(0.0, np.sqrt(np.nanmax(energy)), levels + 2)[1:-1] ** 2
    else:
        energies = np.array(levels, float)
    return energies, _levels(x, v, energy, energies.tolist())


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
