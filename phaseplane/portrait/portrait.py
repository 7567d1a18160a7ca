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
from phaseplane.portrait.trajectories import followed
from phaseplane.portrait.windows import enlarged

_SLOPES = (-2.0, -1.0, -0.5, 0.5, 1.0, 2.0)  # of isoclines, in heights per width of the window
_ASIDE = 0.01  # of the width: distance of a curve's start from a repelling equilibrium
_CELLS = 60  # of a window's sides, in which places without curves are looked for
_EMPTY = 0.11  # windows: a place so far from every curve gets one
_ROUNDS, _AT_ONCE = 6, 4  # of filling such places
_FILLING = 3.0  # windows: length of their curves


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
    if system.driven and frozen is None:
        return Portrait(window, section=section(system, window, starts[0], periods))
    if system.driven and frozen is not None:
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
    curves = tuple(followed(system, window, *zip(*starts, strict=True))) if starts[1:] else ()
    if not constant:
        curves = (*curves, *orbits(system, window, at_rest, cycles))
        shown = (*curves, *borders, *(cycle.curve for cycle in cycles))
        curves = (*curves, *_filling(system, window, shown))
    return Portrait(
        window,
        direction_field(system, window),
        nullcline,
        tuple(lines),
        slopes,
        _energy_curves(system, window, saddles) if constant else (),
        curves,
        switch_lines(system, window),
        tuple(at_rest),
        borders,
        tuple(cycles),
        frozen=frozen,
    )


def _energy_curves(
    system: PhaseSystem, window: Window, saddles: list[Equilibrium]
) -> tuple[Curves, ...]:
    """Return curves all over the window, and some in each well; none beside a separatrix."""
    levels = levels_apart(system, window, [at.x for at in saddles], levels_in_wells(system, window))
    return tuple(energy_levels(system, window, levels)[1])


def _filling(system: PhaseSystem, window: Window, shown: Sequence[Grid]) -> list[Grid]:
    """Return integral curves through the places of a window that are farthest from any curve."""
    empty = np.isfinite(system.forces(*window.grid(_CELLS, _CELLS)))
    found: list[Grid] = []
    for _ in range(_ROUNDS):
        for curve in shown:
            empty[_cells(curve, window)] = False
        places = list(_emptiest(empty.copy(), window))
        if not places:
            break
        x, v = np.repeat(places, 2, axis=0).T
        senses = np.tile([-1.0, 1.0], len(places))
        halves = followed(system, window, x, v, senses, margin=0.02, length=_FILLING)
        shown = [
            np.vstack([past[::-1], future[1:]])
            for past, future in zip(halves[::2], halves[1::2], strict=True)
        ]
        found += shown
    return found


def _cells(curve: Grid, window: Window) -> tuple[Grid, Grid]:
    """Return the rows and columns of the cells that a curve goes through."""
    inside = curve[window.holds(*curve.T)]
    corner, sides = [window.left, window.bottom], [window.width, window.height]
    columns, rows = np.rint((inside - corner) / sides * (_CELLS - 1)).astype(int).T
    return rows, columns


def _emptiest(empty: npt.NDArray[np.bool_], window: Window) -> Iterator[tuple[float, float]]:
    """Yield a few places in a window that are far from all curves and from one another."""
    x, v = window.grid(_CELLS, _CELLS)
    for _ in range(_AT_ONCE):
        apart = distance_transform_edt(empty) / _CELLS
        row, column = np.unravel_index(np.argmax(apart), apart.shape)
        if apart[row, column] < _EMPTY:
            return
        yield float(x[row, column]), float(v[row, column])
        # its curve will go along the axis faster than across it
        empty[max(row - _CELLS // 8, 0) : row + _CELLS // 8 + 1] = False


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
