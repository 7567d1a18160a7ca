"""Motions from many states at once, each with its own steps.

The method is Rodas4 (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.7): order 4 with
an embedded method of order 3 for the error, L-stable, so that a relaxation oscillator takes no more
steps on its slow branches than a harmonic one. All motions share numpy's overhead of a step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from phaseplane.portrait import switched
from phaseplane.portrait.system import Grid, PhaseSystem, Window

Indices = npt.NDArray[np.intp]

_GAMMA = 0.25
_A = (
    (),
    (1.544,),
    (0.9466785280815826, 0.2557011698983284),
    (3.314825187068521, 2.896124015972201, 0.9986419139977817),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
    (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0),
)
_C = (
    (),
    (-5.6688,),
    (-2.430093356833875, -0.2063599157091915),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160),
    (8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
     -6.058818238834054),
)  # fmt: skip
_OF_STATE = [np.array(row) for row in _A]
_OF_RATE = [np.array(row) for row in _C]
_ALPHA = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
_OF_TIME = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
_DIFFERENCES = np.array(
    [[0, 1, -1, 0, 0, 0, 0], [0, 0, 0, 1, -1, 0, 0], [0, 0, 0, 0, 0, 1, -1]], float
)[:, :, None]
_NEAR = 1e-7  # of the window's sides, for difference quotients
_FIRST = 1e-4  # length of the first step, in windows
_LEAST, _MOST = 0.2, 5.0  # factors by which a step may change
_STILL, _TRIES = 100.0, 24  # a motion ends that so many tries lead no farther, in tolerances
_PIECE = 2.0  # windows: length of a curve after which its windings are looked at
_PITCH = 0.01  # of the width: least distance between windings


@dataclass(slots=True)
class Motions:
    """States of many motions, stepped together; those that have ended no longer move.

    Parameters
    ----------
    system : the system that moves
    window : its sides are the scales of errors
    x, v, t : present states and times, shape (motions,)
    sense : 1 forwards in time, -1 backwards
    tolerance : of one step, in widths and heights of the window
    """

    system: PhaseSystem
    window: Window
    x: Grid
    v: Grid
    t: Grid
    sense: Grid
    tolerance: float = 1e-8
    h: Grid = field(init=False)
    active: npt.NDArray[np.bool_] = field(init=False)
    _tries: Indices = field(init=False)
    _way: Grid = field(init=False)
    _force: Callable[[Grid, Grid, Grid], Grid] = field(init=False)

    def __post_init__(self) -> None:
        """Choose the first steps by the speed of each state in windows."""
        self._force = self.system.over_arrays(self.x, self.v, self.t)
        self.active = np.ones(len(self.x), bool)
        self._tries, self._way = np.zeros(len(self.x), int), np.zeros(len(self.x))
        speed = self.speed(np.arange(len(self.x)))
        self.h = _FIRST / np.where(np.isfinite(speed) & (speed > 0.0), speed, 1.0)

    def speed(self, which: Indices) -> Grid:
        """Return speeds in windows per second."""
        x, v = self.x[which], self.v[which]
        force = self.system.forces(x, v, self.t[which])
        return self.window.size(v, force)

    def step(self, longest: Grid | float = np.inf) -> tuple[Indices, Grid, Grid, Grid]:
        """Make one step of every active motion.

        A step rejected for its error is shortened the next time. A motion ends if its steps vanish, or
        if it no longer moves: at rest, or at a pole of f, where ever shorter steps lead to and fro.

        Parameters
        ----------
        longest : upper bound of this step, s, shape (motions,)

        Returns
        -------
        The indices of the motions that have moved, and their previous x, v, t.
        """
        going = np.flatnonzero(self.active)
        h = np.minimum(self.h, longest)[going]
        before = self.x[going], self.v[going], self.t[going]
        x, v, error = self.tried(*before, self.sense[going], h)
        error = np.where(np.isfinite(error), error, 1e9)
        factor = np.clip(0.9 * np.maximum(error, 1e-10) ** -0.25, _LEAST, _MOST)
        good = error <= 1.0
        # a step limited by `longest` does not limit the next one
        self.h[going] = np.where(good & (h < self.h[going]), self.h[going], h * factor)
        vanishing = ~good & (h < 1e-13 * (np.abs(before[2]) + 1e-3))
        self.active[going[vanishing]] = False
        moved, x0, v0 = going[good], before[0][good], before[1][good]
        self.x[moved], self.v[moved] = x[good], v[good]
        self.t[moved] += self.sense[moved] * h[good]
        self._way[moved] += self.window.size(self.x[moved] - x0, self.v[moved] - v0)
        self._tries[going] += 1
        due = going[self._tries[going] == _TRIES]
        if len(due) and not self.system.driven:  # a driven motion at rest may move again
            self.active[due[self._way[due] < _STILL * self.tolerance]] = False
        self._tries[due], self._way[due] = 0, 0.0
        return moved, x0, v0, before[2][good]

    def tried(self, x: Grid, v: Grid, t: Grid, sense: Grid, h: Grid) -> tuple[Grid, Grid, Grid]:
        """Return the ends of steps of length h, s, and their errors in units of the tolerance."""
        with np.errstate(all="ignore"):
            return self._tried(np.array([x, v]), t, sense, h)

    def _tried(self, y: Grid, t: Grid, sense: Grid, h: Grid) -> tuple[Grid, Grid, Grid]:
        f, f_x, f_v, f_t = self._tangents(y[0], y[1], t)
        # (1/(h gamma) - J) k = r with J = sense ((0, 1), (-f_x, -f_v))
        g = 1.0 / (_GAMMA * h)
        damped = g + sense * f_v
        share = 1.0 / (g * damped + f_x)
        of_r = np.array([damped * share, -sense * f_x * share])
        of_s = np.array([sense * share, g * share])
        k = np.empty((6, *y.shape))
        flat = k.reshape(6, -1)
        ys = y
        for stage in range(6):
            if stage:
                ys = y + (_OF_STATE[stage] @ flat[:stage]).reshape(y.shape)
                f = self._force(ys[1], ys[0], t + sense * _ALPHA[stage] * h)
            r, s = sense * ys[1], -sense * f
            if f_t is not None:
                s = s - h * _OF_TIME[stage] * f_t
            if stage:
                before = (_OF_RATE[stage] @ flat[:stage]).reshape(y.shape) / h
                r, s = r + before[0], s + before[1]
            k[stage] = of_r * r + of_s * s
        end = ys + k[5]
        return end[0], end[1], self.window.size(*k[5]) / self.tolerance

    def _tangents(self, x: Grid, v: Grid, t: Grid) -> tuple[Grid, Grid, Grid, Grid | None]:
        """Return f and its derivatives with respect to x, x' and, for a driven system, t."""
        steps = np.array([_NEAR * self.window.width, _NEAR * self.window.height, 0.0])
        count = 2
        if self.system.driven:
            steps[2], count = 1e-6 * self.system.period, 3
        of_x, of_v, of_t = _DIFFERENCES[:, : 1 + 2 * count] * steps[:, None, None]
        f = self._force(v + of_v, x + of_x, t + of_t)
        f_x, f_v, *f_t = (f[1::2] - f[2::2]) / (2.0 * steps[:count, None])
        return f[0], f_x, f_v, f_t[0] if f_t else None


def motions(
    system: PhaseSystem,
    window: Window,
    x: npt.ArrayLike,
    v: npt.ArrayLike,
    sense: npt.ArrayLike = 1.0,
    tolerance: float = 1e-8,
) -> Motions:
    """Return motions that start from these states at time 0; see `Motions`."""
    parts = np.broadcast_arrays(*(np.asarray(part, float) for part in (x, v, 0.0, sense)))
    at = [part.ravel().copy() for part in parts]
    return Motions(system, window, at[0], at[1], at[2], at[3], tolerance)


def followed(
    system: PhaseSystem,
    window: Window,
    x: npt.ArrayLike,
    v: npt.ArrayLike,
    sense: npt.ArrayLike = 1.0,
    *,
    margin: float = 0.2,
    length: float = 8.0,
    part: float = 0.0125,
    tolerance: float = 1e-8,
    ends: npt.ArrayLike = (),
) -> list[Grid]:
    """Return integral curves until they leave the window or come to rest, (points, 2) each.

    Parameters
    ----------
    sense : 1 forwards in time, -1 backwards
    margin : by which the window is enlarged, in parts of its sides
    length : largest length of a curve, in windows
    part : largest distance between two points, in windows
    ends : displacements of saddles; a curve that comes close to one ends
    """
    if switched.switches(system):
        return switched.curves(system, window, x, v, sense, margin, length, part)
    going = motions(system, window, x, v, sense, tolerance)
    points: list[list[tuple[float, float]]] = [
        [state] for state in zip(going.x.tolist(), going.v.tolist(), strict=True)
    ]
    saddles = np.asarray(ends, float)
    went = np.zeros(len(going.x))
    away = np.zeros(len(going.x), bool)  # from the saddle that it may have started beside
    for _ in range(int(4.0 * length / part)):
        if not going.active.any():
            break
        every = np.arange(len(going.x))
        with np.errstate(all="ignore"):
            longest = part / going.speed(every)
        moved, x0, v0, _ = going.step(longest)
        x1, v1 = going.x[moved], going.v[moved]
        went[moved] += window.size(x1 - x0, v1 - v0)
        for k, state in zip(
            moved.tolist(), zip(x1.tolist(), v1.tolist(), strict=True), strict=True
        ):
            points[k].append(state)
        over = ~window.holds(x1, v1, margin) | (went[moved] > length)
        if len(saddles):
            far = _distance(saddles, x1, v1, window)
            arrived = away[moved] & (far < 2.0 * part) & (far > _distance(saddles, x0, v0, window))
            away[moved] |= far > 4.0 * part
            over |= arrived
        going.active[moved[over]] = False
    return [np.array(line) for line in points]


def traced(
    system: PhaseSystem,
    window: Window,
    x: npt.ArrayLike,
    v: npt.ArrayLike,
    sense: npt.ArrayLike,
    *,
    margin: float,
    length: float,
    tolerance: float,
    ends: npt.ArrayLike = (),
    beside: Sequence[Grid] = (),
) -> list[Grid]:
    """Return integral curves like `followed`, but only as far as their windings keep apart.

    Weakly damped motions would otherwise fill a disc around their focus.

    Parameters
    ----------
    beside : other curves, from which the windings keep apart, too
    """
    taken = np.concatenate([_crossings(curve)[1] for curve in beside] or [np.zeros(0)])
    curves = [np.array([start]) for start in zip(*np.atleast_1d(x, v), strict=True)]
    senses = np.broadcast_to(np.asarray(sense, float), len(curves))
    going = list(range(len(curves)))
    for _ in range(int(length / _PIECE)):
        if not going:
            break
        x, v = np.array([curves[k][-1] for k in going]).T
        pieces = followed(
            system, window, x, v, senses[going],
            margin=margin, length=_PIECE, tolerance=tolerance, ends=ends,
        )  # fmt: skip
        on = []
        for k, piece in zip(going, pieces, strict=True):
            whole = np.vstack([curves[k], piece[1:]])
            curves[k] = _unwound(whole, taken, window)
            if length_of(piece, window) > _PIECE and len(curves[k]) == len(whole):
                on.append(k)
        going = on
    return curves


def length_of(curve: Grid, window: Window) -> float:
    """Return the length of a curve in windows."""
    return float(window.size(*np.diff(curve, axis=0).T).sum())


def _unwound(curve: Grid, taken: Grid, window: Window) -> Grid:
    """Return a curve up to the end of its first winding that is too close to another.

    Parameters
    ----------
    taken : where other curves cross the x axis; at one place all curves cross it in the same sense
    """
    after, crossings = _crossings(curve)
    for k in range(2, len(crossings)):
        others = np.concatenate([taken, crossings[:k]])
        if np.abs(others - crossings[k]).min() < _PITCH * window.width:
            return curve[: after[k] + 1]
    return curve


def _crossings(curve: Grid) -> tuple[Indices, Grid]:
    """Return the points behind the crossings of the x axis, and the displacements there."""
    x, v = curve.T
    k = np.flatnonzero(np.signbit(v[:-1]) != np.signbit(v[1:]))
    return k + 1, x[k] + (x[k + 1] - x[k]) * v[k] / (v[k] - v[k + 1])


def _distance(places: Grid, x: Grid, v: Grid, window: Window) -> Grid:
    """Return the distance from the nearest of the places on the axis, in windows."""
    return window.size(np.abs(x[:, None] - places).min(axis=1), v)
