"""A portrait: its curves, equilibria and cycles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from phaseplane.portrait.curves import (
    Curves,
    energy_levels,
    isoclines,
    levels_apart,
    levels_in_wells,
    switch_lines,
)
from phaseplane.portrait.cycles import Cycle, limit_cycles
from phaseplane.portrait.energy import conserves
from phaseplane.portrait.equilibria import Equilibrium, equilibria, separatrices
from phaseplane.portrait.poincare import Section, section
from phaseplane.portrait.system import Grid, PhaseSystem, Window, direction_field
from phaseplane.portrait.trajectories import followed, length_of, traced
from phaseplane.portrait.windows import enlarged

_SLOPES = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of isoclines, in heights per width of the window
_ASIDE = 0.01  # of the width: distance of a curve's start from a repelling equilibrium
_CELLS = 60  # of a window's sides, in which places without curves are looked for
_EMPTY = 0.1  # windows: a place so far from every curve gets one
_LONGEST = 32.0  # windows: half of a curve
_FILLING = 80.0  # windows: length of all curves that fill such places
_BEYOND = 0.02  # windows: a curve ends so far outside
_PRECISION = 1e-6  # windows: of one step of a curve


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
    switches : the lines on which f jumps
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
    switches: Curves | tuple[()] = ()
    equilibria: tuple[Equilibrium, ...] = ()
    separatrices: tuple[Grid, ...] = ()
    cycles: tuple[Cycle, ...] = ()
    section: Section | None = None
    frozen: float | None = None


def compute_portrait(
    system: PhaseSystem,
    window: Window,
    *,
    starts: Sequence[tuple[float, float]] = ((0.0, 0.0),),
    periods: int = 100,
    frozen: float | None = None,
    fits: bool = False,
) -> Portrait:
    """Compute the portrait in a window.

    A driven system has no fixed field or equilibria, and its curves cross: its section is computed.
    Alternatively f is frozen at a given time, which is meaningful only for a slow excitation.

    Parameters
    ----------
    starts : of integral curves, if there are several; the first is that of the section
    periods : of the section
    frozen : time at which f is held constant, s
    fits : whether the window is enlarged such that limit cycles are inside as a whole
    """
    if system.driven:
        if frozen is None:
            return Portrait(window, section=section(system, window, starts[0], periods))
        system = system.frozen(frozen)
    constant = conserves(system, window)
    cycles = [] if constant else limit_cycles(system, window)
    for cycle in cycles if fits else ():
        window = enlarged(window, cycle.curve)
    at_rest = equilibria(system, window)
    steep = window.height / window.width
    slopes = tuple(_rounded(slope * steep) for slope in _SLOPES)
    nullcline, *lines = isoclines(system, window, [0.0, *slopes])
    saddles = [at for at in at_rest if "saddle" in at.kinds]
    ends = tuple(at.x for at in saddles) if constant else ()
    borders = tuple(separatrices(system, window, *saddles, ends=ends))
    several = starts if starts[1:] else ()
    if constant:
        curves = followed(system, window, *zip(*several, strict=True)) if several else []
    else:
        curves = _through(system, window, several)
        shown = [*curves, *borders, *(cycle.curve for cycle in cycles)]
        curves += _orbits(system, window, at_rest, cycles, shown)
    return Portrait(
        window,
        direction_field(system, window),
        nullcline,
        tuple(lines),
        slopes,
        _energy_curves(system, window, saddles) if constant else (),
        tuple(curves),
        switch_lines(system, window),
        tuple(at_rest),
        borders,
        tuple(cycles),
        frozen=frozen,
    )


def _energy_curves(
    system: PhaseSystem, window: Window, saddles: list[Equilibrium]
) -> tuple[Curves, ...]:
    """Return curves all over the window, and some in each well; none close to a separatrix."""
    levels = levels_apart(system, window, [at.x for at in saddles], levels_in_wells(system, window))
    return tuple(energy_levels(system, window, levels)[1])


def _filling(system: PhaseSystem, window: Window, shown: Sequence[Grid]) -> list[Grid]:
    """Return integral curves through the places of a window that are farthest from any curve.

    Each goes from the window's edge, or from what repels it, to the edge again or to what attracts it.
    If the plane is symmetric about its origin, so are the curves, as far as they find room.
    """
    empty = np.isfinite(system.forces(*window.grid(_CELLS, _CELLS)))
    _cover(empty, shown, window)
    symmetric = _is_symmetric(system, window)
    x, v = window.grid(_CELLS, _CELLS)
    found: list[Grid] = []
    length = 0.0
    while length < _FILLING:
        apart = _apart(empty)
        place = np.unravel_index(np.argmax(apart), apart.shape)
        if apart[place] < _EMPTY:
            break
        (curve,) = _through(system, window, [(float(x[place]), float(v[place]))], [*shown, *found])
        length += length_of(curve, window)
        _cover(empty, [curve], window)
        found.append(curve)
        # the grid turned by 180 degrees is itself, backwards
        if symmetric and _apart(empty)[::-1, ::-1][place] >= _EMPTY:
            _cover(empty, [-curve], window)
            found.append(-curve)
    return found


def _through(
    system: PhaseSystem,
    window: Window,
    places: Sequence[tuple[float, float]],
    beside: Sequence[Grid] = (),
) -> list[Grid]:
    """Return the integral curves through places, from their past to their future.

    Parameters
    ----------
    beside : curves that are there already
    """
    x, v = np.repeat(np.reshape(np.array(places, float), (-1, 2)), 2, axis=0).T
    halves = traced(
        system, window, x, v, np.tile([-1.0, 1.0], len(places)),
        margin=_BEYOND, length=_LONGEST, tolerance=_PRECISION, beside=beside,
    )  # fmt: skip
    return [
        np.vstack([past[::-1], future[1:]])
        for past, future in zip(halves[::2], halves[1::2], strict=True)
    ]


def _is_symmetric(system: PhaseSystem, window: Window) -> bool:
    """Return whether the plane turned by 180 degrees is the same: f(-x', -x) = -f(x', x)."""
    if window.left != -window.right or window.bottom != -window.top:
        return False
    force = system.forces(*window.grid(_CELLS, _CELLS))
    return np.allclose(force[::-1, ::-1], -force, rtol=1e-9, atol=1e-12, equal_nan=True)


def _cover(empty: npt.NDArray[np.bool_], curves: Sequence[Grid], window: Window) -> None:
    """Mark the cells that curves go through as no longer empty."""
    corner, sides = [window.left, window.bottom], [window.width, window.height]
    for curve in curves:
        inside = curve[window.holds(*curve.T)]
        columns, rows = np.rint((inside - corner) / sides * (_CELLS - 1)).astype(int).T
        empty[rows, columns] = False


def _apart(empty: npt.NDArray[np.bool_]) -> Grid:
    """Return how far each cell is from any curve, in windows; from a corner if there is no curve."""
    if empty.all():
        empty = empty.copy()
        empty[0, 0] = False
    return distance_transform_edt(empty) / _CELLS


def _rounded(slope: float) -> float:
    """Return a slope as it can be written on its isocline: two digits."""
    return float(f"{slope:.2g}")


def _between(at_rest: Sequence[Equilibrium], window: Window) -> Iterator[float]:
    """Yield places on the axis between neighbouring equilibria, nearer to the attracting one."""
    for left, right in pairwise(at_rest):
        low, high = (left.until if left.stretches else left.x), right.x
        attracts = [any("stable" in k and "un" not in k for k in at.kinds) or at.stretches
                    for at in (left, right)]  # fmt: skip
        if high - low > 4.0 * _ASIDE * window.width and any(attracts):
            part = 0.45 if attracts[0] else 0.55
            yield low + part * (high - low)


def _orbits(
    system: PhaseSystem,
    window: Window,
    at_rest: Sequence[Equilibrium],
    cycles: Sequence[Cycle],
    shown: Sequence[Grid],
) -> list[Grid]:
    """Return integral curves for every basin and every empty part of a window, (points, 2) each.

    Parameters
    ----------
    shown : curves that are there already
    """
    aside = _ASIDE * window.width
    places = [(x, 0.0) for x in _between(at_rest, window)]
    places += [(at.x + aside, 0.0) for at in at_rest if any("unstable" in k for k in at.kinds)]
    for cycle in cycles:
        if not cycle.attracts:
            places += [(cycle.crossing - aside, 0.0), (cycle.crossing + aside, 0.0)]
    first = _through(system, window, places, shown)
    return first + _filling(system, window, [*shown, *first])
