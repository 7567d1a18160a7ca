"""All of a portrait, in a window that shows it well."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from phaseplane.portrait.curves import Curves, energy_levels, isoclines, levels_in_wells
from phaseplane.portrait.cycles import Cycle, limit_cycles
from phaseplane.portrait.energy import conserves, potential
from phaseplane.portrait.equilibria import Equilibrium, equilibria, separatrices
from phaseplane.portrait.poincare import Section, section
from phaseplane.portrait.system import Grid, PhaseSystem, Window, direction_field
from phaseplane.portrait.trajectories import followed

_ROOM = 1.25  # of the window beyond what it shows
_SLOPES = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of isoclines, in widths and heights of the window
_ASIDE = 0.01  # of the width: where a curve begins beside an equilibrium that repels


@dataclass(frozen=True, slots=True)
class Portrait:
    """What a phase portrait shows: of an autonomous system its curves, of a driven one its section.

    Parameters
    ----------
    window : the part of the plane
    field : x, x' and their rates, see `direction_field`; none of a driven system
    nullcline : where x'' = 0
    isoclines : where integral curves have one and the same slope; a list for each slope
    energy_curves : curves of constant energy, if it is constant; a list for each energy
    orbits : integral curves, where it is not
    equilibria, separatrices, cycles : inside the window
    section : of a driven system
    frozen : the instant at which a driven system is looked at as if f changed no more, s; or none
    """

    window: Window
    field: tuple[Grid, Grid, Grid, Grid] | None = None
    nullcline: Curves | tuple[()] = ()
    isoclines: tuple[Curves, ...] = ()
    energy_curves: tuple[Curves, ...] = ()
    orbits: tuple[Grid, ...] = ()
    equilibria: tuple[Equilibrium, ...] = ()
    separatrices: tuple[Grid, ...] = ()
    cycles: tuple[Cycle, ...] = ()
    section: Section | None = None
    frozen: float | None = None


def good_window(system: PhaseSystem, reach: float) -> Window:
    """A window as wide as it is asked for, and as high as motions get that turn at its sides.

    Parameters
    ----------
    reach : largest displacement on either side
    """
    energy = potential(system, np.linspace(-reach, reach, 401))
    known = energy[np.isfinite(energy)]
    height = sqrt(2.0 * float(known.max())) if len(known) else 0.0
    height = height or reach
    return Window(-_ROOM * reach, _ROOM * reach, -_ROOM * height, _ROOM * height)


def fitted_window(shown: Section, otherwise: Window) -> Window:
    """A window that the points of a section fill."""
    if not len(shown.points):
        return otherwise
    low, high = shown.points.min(axis=0), shown.points.max(axis=0)
    sides = np.array([otherwise.width, otherwise.height])
    half = np.maximum(0.5 * _ROOM * (high - low), 0.02 * sides)
    (left, bottom), (right, top) = 0.5 * (low + high) - half, 0.5 * (low + high) + half
    return Window(*map(float, (left, right, bottom, top)))


def whole_portrait(
    system: PhaseSystem,
    window: Window,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    periods: int = 100,
    frozen: float | None = None,
) -> Portrait:
    """Everything there is in a window.

    A driven system has no field, no equilibria and no curves that do not cross: its section is shown.
    On demand it is frozen at an instant, which says something only of a drive that is slow.

    Parameters
    ----------
    start, periods : of the section
    frozen : s
    """
    if system.driven and frozen is None:
        return Portrait(window, section=section(system, window, start, periods))
    if system.driven and frozen is not None:
        system = system.frozen(frozen)
    at_rest = equilibria(system, window)
    steep = window.height / window.width
    nullcline, *lines = isoclines(system, window, [0.0, *(slope * steep for slope in _SLOPES)])
    constant = conserves(system, window)
    saddles = [at for at in at_rest if "saddle" in at.kinds]
    ends = tuple(at.x for at in saddles) if constant else ()
    cycles = [] if constant else limit_cycles(system, window)
    return Portrait(
        window,
        direction_field(system, window),
        nullcline,
        tuple(lines),
        _energy_curves(system, window) if constant else (),
        () if constant else orbits(system, window, at_rest, cycles),
        tuple(at_rest),
        tuple(separatrices(system, window, *saddles, ends=ends)),
        tuple(cycles),
        frozen=frozen,
    )


def _energy_curves(system: PhaseSystem, window: Window) -> tuple[Curves, ...]:
    """Curves all over the window, and some in each well."""
    inner = levels_in_wells(system, window)
    return (*energy_levels(system, window)[1], *energy_levels(system, window, inner)[1])


def orbits(
    system: PhaseSystem,
    window: Window,
    at_rest: list[Equilibrium] | tuple[Equilibrium, ...] = (),
    cycles: list[Cycle] | tuple[Cycle, ...] = (),
    count: int = 4,
) -> tuple[Grid, ...]:
    """Integral curves, each of shape (points, 2): inwards from the border, outwards from what repels.

    Parameters
    ----------
    count : through either of the long sides
    """
    places = np.linspace(window.left, window.right, count + 2)[1:-1]
    x = [*places, *places]
    v = [window.top] * count + [window.bottom] * count
    aside = _ASIDE * window.width
    for at in at_rest:
        if any("unstable" in kind for kind in at.kinds):
            x.append(at.x + aside)
            v.append(0.0)
    for cycle in cycles:
        if not cycle.attracts:
            x += [cycle.crossing - aside, cycle.crossing + aside]
            v += [0.0, 0.0]
    return tuple(followed(system, window, x, v))
