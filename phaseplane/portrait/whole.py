"""All of a portrait, in a window that shows it well."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np
from scipy.integrate import solve_ivp

from phaseplane.portrait.curves import Curves, energy_levels, isocline, nullcline
from phaseplane.portrait.cycles import Cycle, limit_cycles
from phaseplane.portrait.equilibria import Equilibrium, equilibria, separatrices
from phaseplane.portrait.poincare import poincare_section
from phaseplane.portrait.system import Grid, PhaseSystem, Window, direction_field

_ROOM = 1.25  # of the window beyond what it shows
_TURNS, _FOLLOWED = 100.0, 30.0  # widths of the window over its height: times
_SLOPES = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of isoclines, in widths and heights of the window


@dataclass(frozen=True, slots=True)
class Portrait:
    """What a phase portrait shows.

    Parameters
    ----------
    window : the part of the plane
    field : x, x' and their rates, see `direction_field`
    nullcline : where x'' = 0
    isoclines : where integral curves have one and the same slope; a list for each slope
    energy_curves : curves of constant energy; a list for each energy
    orbits : integral curves from the border of the window inwards
    equilibria, separatrices, cycles : inside the window
    section : states once in each period of the excitation, shape (n, 2), or none
    """

    window: Window
    field: tuple[Grid, Grid, Grid, Grid]
    nullcline: Curves
    isoclines: tuple[Curves, ...]
    energy_curves: tuple[Curves, ...]
    orbits: tuple[Grid, ...]
    equilibria: tuple[Equilibrium, ...]
    separatrices: tuple[Grid, ...]
    cycles: tuple[Cycle, ...]
    section: Grid | None = None


def good_window(system: PhaseSystem, reach: float) -> Window:
    """A window as wide as it is asked for, and as high as motions get that turn at its sides.

    Parameters
    ----------
    reach : largest displacement on either side
    """
    x = np.linspace(-reach, reach, 401)
    forces = system.forces(x, 0.0 * x)
    forces = np.where(np.isfinite(forces), forces, 0.0)
    potential = np.concatenate([[0.0], np.cumsum(0.5 * (forces[1:] + forces[:-1]) * np.diff(x))])
    height = sqrt(2.0 * float(potential.max() - potential.min())) or reach
    return Window(-_ROOM * reach, _ROOM * reach, -_ROOM * height, _ROOM * height)


def whole_portrait(
    system: PhaseSystem,
    window: Window,
    *,
    forced: PhaseSystem | None = None,
    start: tuple[float, float] = (0.0, 0.0),
    periods: int = 200,
) -> Portrait:
    """Everything there is in a window.

    Parameters
    ----------
    system : at time 0, as its field, equilibria and cycles are
    forced : the same under a periodic excitation, of which the section is taken; none without
    start, periods : of the section
    """
    longest = _TURNS * (window.right - window.left) / (window.top - window.bottom)
    at_rest = tuple(equilibria(system, window))
    steep = (window.top - window.bottom) / (window.right - window.left)
    kinds = {kind for at in at_rest for kind in at.kinds}
    turning = any("focus" in kind or "node" in kind for kind in kinds)
    centres = [at.x for at in at_rest if "saddle" not in at.kinds]
    cycles = [
        cycle
        for centre in (centres if turning else ())
        for cycle in limit_cycles(system, window, centre, longest)
    ]
    return Portrait(
        window,
        direction_field(system, window),
        nullcline(system, window),
        tuple(isocline(system, window, slope * steep) for slope in _SLOPES),
        tuple(energy_levels(system, window)[1]) if kinds <= {"centre", "saddle"} else (),
        () if kinds <= {"centre", "saddle"} else orbits(system, window),
        at_rest,
        tuple(
            curve
            for at in at_rest
            if "saddle" in at.kinds
            for curve in separatrices(system, window, at)
        ),
        tuple(cycle for cycle in cycles if isfinite(cycle.period)),
        None if forced is None else poincare_section(forced, start, periods),
    )


def orbits(system: PhaseSystem, window: Window, count: int = 4) -> tuple[Grid, ...]:
    """Integral curves that enter through the upper and the lower side, each of shape (points, 2).

    Parameters
    ----------
    count : through either side
    """
    long = _FOLLOWED * (window.right - window.left) / (window.top - window.bottom)
    times = np.linspace(0.0, long, 2000)
    places = np.linspace(window.left, window.right, count + 2)[1:-1]

    def gone(_t: float, state: Grid) -> float:
        return 1.0 if window.holds(state[0], state[1], 0.2) else -1.0

    gone.terminal = True  # type: ignore[attr-defined]
    return tuple(
        solve_ivp(system.rates, (0.0, long), (x, v), events=gone, rtol=1e-8, t_eval=times).y.T
        for v in (window.top, window.bottom)
        for x in places
    )
