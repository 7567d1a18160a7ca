"""Curves of the plane: nullclines, isoclines, levels of energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from contourpy import contour_generator
from scipy.integrate import cumulative_simpson

from phaseplane.portrait.system import Grid, PhaseSystem, Window

Curves = list[Grid]
"""Polylines of shape (points, 2): x and x'."""


def nullcline(system: PhaseSystem, window: Window, resolution: int = 300) -> Curves:
    """Where x'' = 0: f(x', x, 0) = 0. The other nullcline, x' = 0, is the x axis."""
    return isocline(system, window, 0.0, resolution)


def isocline(system: PhaseSystem, window: Window, slope: float, resolution: int = 300) -> Curves:
    """Where integral curves have a given slope dx'/dx = -f / x': f + slope x' = 0 (AP57 section 3)."""
    x, v = window.grid(resolution, resolution)
    return _levels(x, v, system.forces(x, v) + slope * v, [0.0])[0]


def energy_levels(
    system: PhaseSystem, window: Window, levels: Sequence[float] | int = 12, resolution: int = 401
) -> tuple[Grid, list[Curves]]:
    """Curves of constant energy x'^2 / 2 + U(x), U' = f(0, x, 0), U least at 0.

    Without damping they are the integral curves themselves.

    Parameters
    ----------
    levels : energies over the least one in the window, or how many

    Returns
    -------
    The energies, and the curves of each.
    """
    x, v = window.grid(resolution, resolution)
    along = x[0]
    potential = cumulative_simpson(system.forces(along, 0.0 * along), x=along, initial=0.0)
    energy = 0.5 * v**2 + (potential - potential.min())
    if isinstance(levels, int):  # evenly spaced in velocity, so that curves lie evenly
        energies = np.linspace(0.0, np.sqrt(energy.max()), levels + 2)[1:-1] ** 2
    else:
        energies = np.array(levels, float)
    return energies, _levels(x, v, energy, energies.tolist())


def _levels(x: Grid, v: Grid, z: Grid, levels: Sequence[float]) -> list[Curves]:
    generator = contour_generator(x, v, z)
    return [[np.asarray(line) for line in generator.lines(level)] for level in levels]
