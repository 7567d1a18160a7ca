"""Energy of a motion: the potential of f(0, x), and the power dissipated by damping."""

from __future__ import annotations

from math import inf

import numpy as np
import numpy.typing as npt
from scipy.integrate import cumulative_simpson

from phaseplane.portrait.system import Grid, PhaseSystem, Window

_ROUNDING = 1e-12  # of the force: below it nothing is dissipated


def potential(system: PhaseSystem, x: Grid, most: float = inf) -> Grid:
    """Return U over ascending x, U' = f(0, x, 0), with min U = 0; NaN where f is not finite.

    Parameters
    ----------
    most : float
        largest magnitude of f that counts; steeper walls are cut there
    """
    forces = system.forces(x, 0.0 * x)
    known = np.isfinite(forces)
    forces = np.clip(forces, -most, most)
    energy = cumulative_simpson(np.where(known, forces, 0.0), x=x, initial=0.0)
    energy = np.where(known, energy, np.nan)
    return np.asarray(energy - np.nanmin(energy)) if known.any() else energy


def power(system: PhaseSystem, x: npt.ArrayLike, v: npt.ArrayLike) -> Grid:
    """Return the power dissipated per unit mass, (f(x', x) - f(0, x)) x'; 0 within rounding.

    It is not finite where one of the two forces is not.
    """
    x, v = np.asarray(x, float), np.asarray(v, float)
    moving, still = system.forces(x, v), system.forces(x, 0.0 * v)
    with np.errstate(invalid="ignore"):  # at a pole of f
        damping = moving - still
        rounding = _ROUNDING * (np.abs(moving) + np.abs(still))
        return np.where(np.abs(damping) < rounding, 0.0, damping * v)


def conserves(system: PhaseSystem, window: Window) -> bool:
    """Return whether nothing is dissipated anywhere in a window; not if no power is known at all."""
    x, v = window.grid(61, 61)
    lost = power(system, x, v)
    known = np.isfinite(lost)
    return bool(known.any() and not lost[known].any())
