"""A portrait, and a suitable window for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite, sqrt

import numpy as np

from phaseplane.portrait.curves import Curves, energy_levels, isoclines, levels_in_wells
from phaseplane.portrait.cycles import Cycle, limit_cycles
from phaseplane.portrait.energy import conserves, potential
from phaseplane.portrait.equilibria import Equilibrium, equilibria, separatrices
from phaseplane.portrait.poincare import Section, section
from phaseplane.portrait.system import Grid, PhaseSystem, Window, direction_field
from phaseplane.portrait.trajectories import followed

_ROOM = 1.25  # size of the window relative to its content
_SLOPES = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of isoclines, in heights per width of the window
_AROUND = 1.7  # of the farthest equilibrium: what lies beyond it
_ASIDE = 0.01  # of the width: distance of a curve's start from a repelling equilibrium


@dataclass(frozen=True, slots=True)
class Portrait:
    """The data of a phase portrait: the curves of an autonomous system, the section of a driven one.

    Parameters
    ----------
    window : the part of the plane
    field : x, x' and their rates, see `direction_field`; None for a driven system
    nullcline : curves x'' = 0
    isoclines : curves on which integral curves have equal slope; a list for each slope
    slopes : dx'/dx on them
    energy_curves : curves of constant energy of a conservative system; a list for each energy
    orbits : integral curves of any other system
    equilibria, separatrices, cycles : inside the window
    section : of a driven system
    frozen : the time at which f of a driven system is held constant, s; or None
    """

    window: Window
    field: tuple[Grid, Grid, Grid, Grid] | None = None
    nullcline: Curves | tuple[()] = ()
    isoclines: tuple[Curves, ...] = ()
    slopes: tuple[float, ...] = ()
    energy_curves: tuple[Curves, ...] = ()
    orbits: tuple[Grid, ...] = ()
    equilibria: tuple[Equilibrium, ...] = ()
    separatrices: tuple[Grid, ...] = ()
    cycles: tuple[Cycle, ...] = ()
    section: Section | None = None
    frozen: float | None = None


def good_window(system: PhaseSystem, reach: float) -> Window:
    """Return a window of given width, as high as the velocities of motions that turn at its sides.

    Parameters
    ----------
    reach : largest displacement to either side
    """
    energy = potential(system, np.linspace(-reach, reach, 401))
    known = energy[np.isfinite(energy)]
    height = sqrt(2.0 * float(known.max())) if len(known) else 0.0
    height = height or reach
    return Window(-_ROOM * reach, _ROOM * reach, -_ROOM * height, _ROOM * height)


def window_of_equilibria(system: PhaseSystem, reach: float, least: float = 0.0) -> Window:
    """Return a window that fits the equilibria of a system, if there are several.

    Parameters
    ----------
    reach : largest displacement to either side at first
    least : displacement that must be inside
    """
    first = good_window(system, reach)
    if system.driven:
        return first
    at_rest = equilibria(system, first)
    if len(at_rest) < 2:
        return first
    places = [abs(e) for at in at_rest for e in (at.x, at.until) if isfinite(e)]
    farthest = max(places)
    return good_window(system, max(_AROUND * farthest, least))


def fitted_window(shown: Section, otherwise: Window) -> Window:
    """Return a window that fits the points of a section."""
    if not len(shown.points):
        return otherwise
    low, high = shown.points.min(axis=0), shown.points.max(axis=0)
    sides = np.array([otherwise.width, otherwise.height])
    half = np.maximum(0.5 * _ROOM * (high - low), 0.02 * sides)
    (left, bottom), (right, top) = 0.5 * (low + high) - half, 0.5 * (low + high) + half
    return Window(*map(float, (left, right, bottom, top)))


def compute_portrait(
    system: PhaseSystem,
    window: Window,
    *,
    start: tuple[float, float] = (0.0, 0.0),
    periods: int = 100,
    frozen: float | None = None,
) -> Portrait:
    """Compute the portrait in a window.

    A driven system has no fixed field or equilibria, and its curves cross: its section is computed.
    Alternatively f is frozen at a given time, which is meaningful only for a slow excitation.

    Parameters
    ----------
    start, periods : of the section
    frozen : time at which f is held constant, s
    """
    if system.driven and frozen is None:
        return Portrait(window, section=section(system, window, start, periods))
    if system.driven and frozen is not None:
        system = system.frozen(frozen)
    at_rest = equilibria(system, window)
    steep = window.height / window.width
    slopes = tuple(_rounded(slope * steep) for slope in _SLOPES)
    nullcline, *lines = isoclines(system, window, [0.0, *slopes])
    constant = conserves(system, window)
    saddles = [at for at in at_rest if "saddle" in at.kinds]
    ends = tuple(at.x for at in saddles) if constant else ()
    cycles = [] if constant else limit_cycles(system, window)
    return Portrait(
        window,
        direction_field(system, window),
        nullcline,
        tuple(lines),
        slopes,
        _energy_curves(system, window) if constant else (),
        () if constant else orbits(system, window, at_rest, cycles),
        tuple(at_rest),
        tuple(separatrices(system, window, *saddles, ends=ends)),
        tuple(cycles),
        frozen=frozen,
    )


def _energy_curves(system: PhaseSystem, window: Window) -> tuple[Curves, ...]:
    """Return curves all over the window, and some in each well."""
    inner = levels_in_wells(system, window)
    return (*energy_levels(system, window)[1], *energy_levels(system, window, inner)[1])


def _rounded(slope: float) -> float:
    """Return a slope as it can be written on its isocline: two digits."""
    return float(f"{slope:.2g}")


def _between(
    at_rest: list[Equilibrium] | tuple[Equilibrium, ...], window: Window
) -> Iterator[float]:
    """Yield places on the axis between neighbouring equilibria, nearer to the attracting one."""
    for left, right in pairwise(at_rest):
        low, high = (left.until if left.stretches else left.x), right.x
        attracts = [any("stable" in k and "un" not in k for k in at.kinds) or at.stretches
                    for at in (left, right)]  # fmt: skip
        if high - low > 4.0 * _ASIDE * window.width and any(attracts):
            part = 0.45 if attracts[0] else 0.55
            yield low + part * (high - low)


def orbits(
    system: PhaseSystem,
    window: Window,
    at_rest: list[Equilibrium] | tuple[Equilibrium, ...] = (),
    cycles: list[Cycle] | tuple[Cycle, ...] = (),
    count: int = 4,
) -> tuple[Grid, ...]:
    """Return integral curves inwards from the border and outwards from repellers, (points, 2) each.

    Beside them there is one from between any two neighbouring equilibria, so that every basin has some.

    Parameters
    ----------
    count : number of curves through each of the long sides
    """
    places = np.linspace(window.left, window.right, count + 2)[1:-1]
    x = [*places, *places]
    v = [window.top] * count + [window.bottom] * count
    aside = _ASIDE * window.width
    for inner in _between(at_rest, window):
        x.append(inner)
        v.append(0.0)
    for at in at_rest:
        if any("unstable" in kind for kind in at.kinds):
            x.append(at.x + aside)
            v.append(0.0)
    for cycle in cycles:
        if not cycle.attracts:
            x += [cycle.crossing - aside, cycle.crossing + aside]
            v += [0.0, 0.0]
    return tuple(followed(system, window, x, v))
