"""Windows that fit what a portrait shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, isfinite, sqrt

import numpy as np
import numpy.typing as npt
from scipy.integrate import cumulative_simpson

from phaseplane.portrait.energy import potential
from phaseplane.portrait.equilibria import equilibria
from phaseplane.portrait.poincare import Section
from phaseplane.portrait.system import Grid, PhaseSystem, Window
from phaseplane.portrait.trajectories import followed

_ROOM = 1.25  # size of the window relative to its content
_AROUND = 1.7  # of the farthest equilibrium: what lies beyond it
_POINTS, _SHIFT = 2001, 0.37  # of the search for poles; a shift in steps, off round numbers
_STEEP = 20.0  # times the median of |f|: beside a pole
_PEAK, _STEPS = 1.5, 3  # |f| beside a pole is so many times as large as so many steps away
_ZOOMS, _ZOOM = 3, 100  # a pole is looked for so many times, each in steps so much smaller
_GROWS = 1e4  # |f| at a pole, as closely as it is found, to |f| a step away
_LEAST = 0.05  # of the sides of a plane: half of those of its section
_BESIDE = 0.05  # of the width between two poles: what lies nearer to one is no measure of height
_SHORT = 1e-3  # of the distance between two poles across the plane: a window ends before them
_MARGIN, _LENGTH, _PART = 3.0, 30.0, 0.05  # windows: how far and how closely motions are followed

_ROUNDS, _GROWN = 5, 1.02  # how often, and as long as the window grows by so much
_ASIDE = 0.02  # of the width: a start beside an equilibrium that repels

Line = Callable[[Grid], Grid]
"""|f| along a line of the plane, of the places on it."""


def good_window(system: PhaseSystem, reach: float) -> Window:
    """Return a window of given width, as high as the velocities of motions that turn at its sides.

    Parameters
    ----------
    reach : largest displacement to either side
    """
    x = np.linspace(-reach, reach, 401)
    force = system.forces(x, 0.0 * x)
    most = _STEEP * float(np.nanmedian(np.abs(force))) if np.isfinite(force).any() else 0.0
    # a very stiff stop is not used for the height: the motion hardly enters it
    energy = potential(system, x, most or inf)
    known = energy[np.isfinite(energy)]
    height = sqrt(2.0 * float(known.max())) if len(known) else 0.0
    height = height or reach
    return Window(-_ROOM * reach, _ROOM * reach, -_ROOM * height, _ROOM * height)


def window_of(
    system: PhaseSystem, reach: float, starts: Sequence[tuple[float, float]] = ()
) -> Window:
    """Return a window that fits the equilibria of a system and the motions from some states.

    It does not go beyond a pole of f, or to where f is undefined: there the plane of a motion ends.
    Nor does it if f is so along a whole line x' = const.

    Parameters
    ----------
    reach : largest displacement to either side, if nothing else is to be seen
    starts : states (x, x') that must be inside; so must their motions, unless they go far away
    """
    places = np.reshape(np.array(starts or [(0.0, 0.0)], float), (-1, 2))
    found = _of_width(system, reach, places)
    ends = [
        _domain(_across(system, x), float(places[0, 1]), found.top)
        for x in (found.left, float(places[0, 0]), found.right)
    ]
    low, high = min(low for low, _ in ends), max(high for _, high in ends)
    short = _SHORT * (high - low)
    return replace(
        found,
        bottom=low + short if low > found.bottom else found.bottom,
        top=high - short if high < found.top else found.top,
    )


def _of_width(system: PhaseSystem, reach: float, places: Grid) -> Window:
    """Return a window that fits along the x axis, as high above it as below."""
    least = 1.1 * float(np.abs(places[:, 0]).max())
    reach = max(reach, least)
    low, high = _domain(_along(system), float(places[0, 0]), _ROOM * reach)
    if system.driven:
        return good_window(system, reach)
    if low > -_ROOM * reach or high < _ROOM * reach:
        return _within(system, (low, high), places, reach)
    first = good_window(system, reach)
    at_rest = equilibria(system, first)
    if len(at_rest) > 1:
        farthest = max(abs(e) for at in at_rest for e in (at.x, at.until) if isfinite(e))
        first = good_window(system, max(_AROUND * farthest, least))
    aside = _ASIDE * first.width
    repelled = [(at.x + aside, 0.0) for at in at_rest if "unstable" in at.kind]
    first = _reached(system, enlarged(first, places), np.array([*places, *repelled]))
    far = max(-first.left, first.right)
    low, high = _domain(_along(system), float(places[0, 0]), far)
    if low > first.left or high < first.right:
        return _within(system, (low, high), places, far / _ROOM)
    return first


def _reached(system: PhaseSystem, window: Window, states: Grid) -> Window:
    """Return the window enlarged to fit the motions from some states, unless they go far away.

    A motion may go on to a limit cycle beyond the window. If it still grows after some rounds, it counts
    only as far as it came in the first.
    """
    wide, found = window, [window]
    grows = True
    for _ in range(_ROUNDS):
        motions = followed(
            system, wide, *states.T, margin=_MARGIN, length=_LENGTH, part=_PART, tolerance=1e-6
        )
        ends = np.array([motion[-1] for motion in motions])
        stays = wide.holds(ends[:, 0], ends[:, 1], _MARGIN)
        for motion, stay in zip(motions, stays.tolist(), strict=True):
            window = enlarged(window, motion) if stay else window
        before = found[-1]
        grows = max(window.width / before.width, window.height / before.height) > _GROWN
        found.append(window)
        if stays.all() and not grows:
            break
        wide = window if stays.all() else Window(
            2.0 * wide.left, 2.0 * wide.right, 2.0 * wide.bottom, 2.0 * wide.top
        )  # fmt: skip
        states = np.where(stays[:, None], ends, states)
    return found[1] if grows else window


def enlarged(window: Window, points: npt.ArrayLike) -> Window:
    """Return a window with room for points (x, x'), and still as high above the x axis as below."""
    x, v = np.reshape(np.asarray(points, float), (-1, 2)).T
    if not len(x):
        return window
    middle, _ = window.centre
    high = _ROOM * float(np.abs(v).max())
    return Window(
        min(window.left, middle + _ROOM * (float(x.min()) - middle)),
        max(window.right, middle + _ROOM * (float(x.max()) - middle)),
        min(window.bottom, -high),
        max(window.top, high),
    )


def fitted_window(shown: Section, otherwise: Window, turn: float = 0.0) -> Window:
    """Return a window that fits the points of a section.

    Parameters
    ----------
    turn : of an angle x, which is shown as a whole; 0 if x is none
    """
    if not len(shown.points):
        return otherwise
    low, high = shown.points.min(axis=0), shown.points.max(axis=0)
    sides = np.array([otherwise.width, otherwise.height])
    half = np.maximum(0.5 * _ROOM * (high - low), _LEAST * sides)
    (left, bottom), (right, top) = 0.5 * (low + high) - half, 0.5 * (low + high) + half
    if turn:
        left, right = -0.5 * turn, 0.5 * turn
    return Window(*map(float, (left, right, bottom, top)))


def _along(system: PhaseSystem) -> Line:
    """Return |f| along the x axis."""
    return lambda x: np.abs(system.forces(x, 0.0 * x))


def _across(system: PhaseSystem, x: float) -> Line:
    """Return |f| at one x, of x'."""
    return lambda v: np.abs(system.forces(0.0 * v + x, v))


def _domain(line: Line, at: float, reach: float) -> tuple[float, float]:
    """Return the ends, within a reach, of the interval around a place in which |f| is finite."""
    step = 2.0 * reach / (_POINTS - 1)
    x = np.linspace(-reach, reach, _POINTS) + _SHIFT * step
    force = line(x)
    known = np.isfinite(force)
    if not known.any():
        return -reach, reach
    ends = list(x[~known])
    steep = np.where(known, force, 0.0)
    tops = 1 + np.flatnonzero((steep[1:-1] >= steep[:-2]) & (steep[1:-1] > steep[2:]))
    padded = np.pad(steep, _STEPS)
    around = np.maximum(padded[tops], padded[tops + 2 * _STEPS])
    for k in tops[steep[tops] > _PEAK * around]:
        pole = _pole(line, float(x[k]), step)
        if pole is not None:
            ends.append(pole)
    return (
        max((float(end) for end in ends if end < at), default=-reach),
        min((float(end) for end in ends if end > at), default=reach),
    )


def _pole(line: Line, near: float, step: float) -> float | None:
    """Return the pole of f near a place; None if f only has a sharp maximum there.

    Towards a pole |f| grows as 1/distance at least. A weaker singularity leaves the energy finite.
    """
    finer = step
    for _ in range(_ZOOMS):
        x = near + finer * (np.linspace(-1.0, 1.0, 2 * _ZOOM + 1) + _SHIFT / _ZOOM)
        force = line(x)
        if not np.isfinite(force).all():
            return near
        near, finer = float(x[np.argmax(force)]), finer / _ZOOM
    beside = line(np.array([near - step, near + step]))
    return near if force.max() > _GROWS * beside.max() else None


def _within(system: PhaseSystem, domain: tuple[float, float], starts: Grid, reach: float) -> Window:
    """Return a window between poles, for energies a little above those of the starts."""
    low, high = domain
    width = high - low
    from_x = float(starts[0, 0])
    sides = [np.linspace(from_x, end, _POINTS)[:-1] for end in (low, high)]
    energies = [
        np.sign(x[1] - x[0])
        * cumulative_simpson(
            np.nan_to_num(system.forces(x, 0.0 * x), posinf=0.0, neginf=0.0),
            dx=abs(x[1] - x[0]),
            initial=0.0,
        )
        for x in sides
    ]
    x = np.concatenate([sides[0][:0:-1], sides[1]])
    energy = np.concatenate([energies[0][:0:-1], energies[1]])
    force = np.abs(system.forces(np.array([x[1], x[-2]]), np.zeros(2)))
    usual = _STEEP * float(np.nanmedian(np.abs(system.forces(x, 0.0 * x))))
    # f is finite up to where it becomes undefined, but not up to a pole
    near, far = _BESIDE * width * (force > usual)
    free = (x > low + near) & (x < high - far) | (x == from_x)
    lowest = float(energy[free].min())
    inside = starts[(starts[:, 0] > low) & (starts[:, 0] < high)]
    highest = float(np.max(np.interp(inside[:, 0], x, energy) + 0.5 * inside[:, 1] ** 2))
    spare = (_ROOM - 1.0) * (highest - lowest)
    nearest, farthest = (low, high) if low > -_ROOM * reach else (high, low)
    halfway = np.interp([0.5 * (from_x + end) for end in (nearest, farthest)], x, energy)
    to_pole, away = np.abs(halfway - lowest).tolist()
    if abs(nearest - from_x) <= _SHORT * width:  # at the edge itself
        spare = away
    elif spare <= 1e-9 * float(np.ptp(energy[free])):  # at rest
        spare = to_pole
    over = np.flatnonzero(energy > highest + spare)
    start = len(sides[0]) - 1
    first = int(max(over[over < start], default=-1)) + 1
    last = int(min(over[over > start], default=len(x))) - 1
    seen = np.flatnonzero(free[first : last + 1]) + first
    left, right = float(x[seen[0]]), float(x[seen[-1]])
    height = _ROOM * sqrt(2.0 * (highest + spare - float(energy[seen].min(initial=lowest))))
    height = height or 0.5 * (right - left)  # without any force
    margin = 0.5 * (_ROOM - 1.0) * (right - left)
    # up to a pole, but with a start that is closer to it
    before, beyond = left - margin, right + margin
    if low > -_ROOM * reach:
        before = max(before, min(left, low + 0.5 * near))
    if high < _ROOM * reach:
        beyond = min(beyond, max(right, high - 0.5 * far))
    return Window(before, beyond, -height, height)
