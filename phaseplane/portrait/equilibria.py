"""Equilibria and their kinds, also on corners and over intervals, and the separatrices of saddles."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from phaseplane.portrait.energy import power
from phaseplane.portrait.focal import first_focal_value
from phaseplane.portrait.returns import turns
from phaseplane.portrait.system import Grid, PhaseSystem, Window
from phaseplane.portrait.trajectories import traced

_PARTS = 2000  # into which the window is divided in the search
_STEP = 1e-6  # of the window's sides, for differences
_SAME = 1e-9  # of the window's width
_AWAY = 1e-4  # of the window's sides: distance of a separatrix's start from its saddle
_FAR = 1e-2  # the same for a saddle without a linear part; also the range of tests by f itself
_LONGEST = 30.0  # windows over which a separatrix is followed
_NO_SLOPE = 1e-6  # of the mean slope of f over the window: smaller slopes count as 0
_TOUCH = 1e-10  # of the largest f: a minimum of |f| below it is a root
_ROUNDING = 1e-13  # of the largest f, and of the window's width
_RINGS = 0.7 ** np.arange(39.0, -1.0, -1.0)  # about an equilibrium, of the room that it has
_OUTER = 14  # the largest of them: damping that begins beyond the smallest of these leaves a centre
_SIZES = 0.5 ** np.arange(20.0, -11.0, -1.0)  # of a turn, in windows
_CLOSE = 1e-2  # of a turn in which damping counts: motions that are small, if the window is smaller
_DAMPED = 0.2  # of the force: the part of damping in a turn from which smaller ones follow
_MANY = 20  # rings, each 0.7 times as large: inside a limit cycle they tell the kind
_TURNS = 12  # trials of a turn about a centre, each from half the distance before
_SPIRALS = 1e-8  # of the distance: a smaller change in a turn is one of rounding
_ALIKE = 0.25  # by which the ratios of successive changes may differ that go with a power of the distance
_MIRRORED = 1e-9  # of the damping on a ring: a smaller difference between its halves counts as none
_ROUNDED = 1e-15  # of the largest f on a ring, and of the forces of a displacement as large as x
_GRADUAL = 1e-6  # of the force: damping that begins with more than this begins at some distance
_STRETCH = 3  # least number of grid points at rest that make a stretch

STRETCH = "interval of rest"
CUSP, SADDLE_NODE = "cusp", "saddle-node"
UNDECIDED = "centre or focus"


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """An equilibrium (x, 0), or an interval of them.

    Parameters
    ----------
    x : its displacement; the left end of a stretch
    kinds : on the sides (x above, x' above), (x above, x' below), (x below, x' above), (x below,
        x' below); all the same unless it is on a corner
    eigenvalues : on the same sides; empty for a stretch
    until : the right end of a stretch, otherwise x
    """

    x: float
    kinds: tuple[str, str, str, str]
    eigenvalues: tuple[tuple[complex, complex], ...] = ()
    until: float = float("nan")

    @property
    def stretches(self) -> bool:
        """Whether it is a stretch."""
        return self.until > self.x

    @property
    def on_corner(self) -> bool:
        """Whether the sides differ."""
        return len(set(self.kinds)) > 1

    @property
    def kind(self) -> str:
        """Its kind; on a corner the different kinds of its sides."""
        return " / ".join(dict.fromkeys(self.kinds))


def equilibria(system: PhaseSystem, window: Window) -> list[Equilibrium]:
    """Return all equilibria in a window, at time 0: f(0, x, 0) = 0.

    Rest is also possible where f jumps at x' = 0 from below zero to above it, as with dry friction.
    Several neighbouring points of either kind make a stretch.
    """
    corners = [c for c in system.corners if window.left <= c <= window.right]
    points = np.unique(
        np.concatenate([np.linspace(window.left, window.right, _PARTS + 1), corners])
    )
    found = _stretches(system, window, points)
    width = window.width
    part = width / _PARTS
    places: list[float] = []
    for x in sorted(_roots(system, points)):
        near = min(corners, key=lambda c: abs(c - x), default=x)
        at = near if abs(near - x) <= _SAME * width else x
        known = places and at - places[-1] <= _SAME * width
        if not known and not any(s.x - part <= at <= s.until + part for s in found):
            places.append(at)
    steepest = _largest(system.forces(points, 0.0 * points)) / width
    others = np.array(places + [end for s in found for end in (s.x, s.until)])
    for x in places:
        gaps = np.abs(others - x)
        room = 0.5 * float(gaps[gaps > 0.0].min(initial=width))
        found.append(_classified(system, window, x, steepest, min(room, _FAR * width)))
    return sorted(found, key=lambda at: at.x)


def _largest(forces: Grid) -> float:
    known = np.abs(forces[np.isfinite(forces)])
    return float(known.max(initial=0.0))


def _roots(system: PhaseSystem, points: Grid) -> list[float]:
    """Return the roots of f(0, x, 0), by a change of sign or by touching zero."""

    def force(x: float) -> float:
        return float(system.forces(x, 0.0))

    forces = system.forces(points, 0.0 * points)
    roots = list(points[forces == 0.0])
    most = _largest(forces)
    with np.errstate(all="ignore"):
        through = np.flatnonzero(forces[:-1] * forces[1:] < 0.0)
        size = np.abs(forces)
        touching = 1 + np.flatnonzero(
            (size[1:-1] < size[:-2]) & (size[1:-1] <= size[2:])
            & (forces[1:-1] * forces[:-2] > 0.0) & (forces[1:-1] * forces[2:] > 0.0)
        )  # fmt: skip
    for k in through:
        a, b = float(points[k]), float(points[k + 1])
        x = float(brentq(force, a, b, xtol=1e-15 * (points[-1] - points[0]), maxiter=1000))
        if force(even := round(x, 12)) == 0.0:  # as in the middle of the jump of a sign
            x = even
        # otherwise a jump past zero; the root may be one of the points, but for rounding
        if abs(force(x)) <= max(0.5 * min(size[k], size[k + 1]), _ROUNDING * most):
            roots.append(x)
    for k in touching:
        least = minimize_scalar(
            lambda x: abs(force(x)), bounds=(points[k - 1], points[k + 1]), method="bounded",
            options={"xatol": 1e-12 * (points[-1] - points[0])},
        )  # fmt: skip
        if least.fun <= _TOUCH * most:
            roots.append(float(least.x))
    tiny = _ROUNDING * float(points[-1] - points[0])
    return [float(x) if abs(x) > tiny else 0.0 for x in roots]


def _stretches(system: PhaseSystem, window: Window, points: Grid) -> list[Equilibrium]:
    """Return stretches of neighbouring points of rest, with their ends found by bisection."""
    slow = 1e-12 * window.height

    def rests(x: Grid) -> Grid:
        low, high = system.forces(x, 0.0 * x - slow), system.forces(x, 0.0 * x + slow)
        tiny = 4e-16 * window.height  # possible effect of damping at the velocity `slow`
        with np.errstate(invalid="ignore"):  # at a pole of f
            jump = high - low > 1e-9 * (np.abs(low) + np.abs(high))
        jumps = (low < -tiny) & (high > tiny) & jump
        return (system.forces(x, 0.0 * x) == 0.0) | jumps

    resting = np.concatenate([[False], rests(points), [False]])
    edges = np.flatnonzero(resting[1:] != resting[:-1])
    found = []
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        if after - first < _STRETCH:
            continue
        ends = []
        for inside, outside in ((first, first - 1), (after - 1, after)):
            a, b = points[inside], points[min(max(outside, 0), len(points) - 1)]
            for _ in range(60):
                middle = 0.5 * (a + b)
                a, b = (middle, b) if rests(np.array([middle]))[0] else (a, middle)
            ends.append(float(a))
        found.append(Equilibrium(ends[0], (STRETCH,) * 4, until=ends[1]))
    return found


def _classified(
    system: PhaseSystem, window: Window, x: float, steepest: float, room: float
) -> Equilibrium:
    """Classify an equilibrium on its four sides by the linear part or, if it vanishes, by f farther out.

    Parameters
    ----------
    steepest : largest f over the window's width, 1/s^2, the scale of slopes
    room : distance within which there is no other equilibrium
    """
    dx, dv = _STEP * window.width, _STEP * window.height
    sides = [(sx, sv) for sx in (1.0, -1.0) for sv in (1.0, -1.0)]
    values, kinds = [], []
    far = system.forces(x + np.array([room, -room]), np.zeros(2))
    restores = dict(zip((1.0, -1.0), (far * [1.0, -1.0] > 0.0).tolist(), strict=True))
    linear = True
    for sx, sv in sides:
        stiffness = _slope(system, x, sx * dx, 0.0) / (sx * dx)
        damping = _slope(system, x, 0.0, sv * dv) / (sv * dv)
        if abs(stiffness) <= _NO_SLOPE * steepest:
            stiffness, linear = 0.0, False
        if abs(damping) <= _NO_SLOPE * sqrt(steepest):
            damping = 0.0
        root = np.emath.sqrt(damping**2 / 4.0 - stiffness)
        pair = complex(-damping / 2.0 + root), complex(-damping / 2.0 - root)
        values.append(pair)
        if not isfinite(stiffness + damping):
            kinds.append("degenerate")
        elif stiffness == 0.0:
            kinds.append(_bent_kind(restores[sx], damping))
        else:
            kinds.append(kind_of(*pair))
    if not linear and restores[1.0] != restores[-1.0] and np.isfinite(far).all():
        # f touches zero: the equilibrium of a double root
        undamped = all(pair[0] == pair[1] == 0.0 for pair in values)
        kinds = [CUSP if undamped else SADDLE_NODE] * 4
    if "degenerate" in kinds:  # on the edge of the domain of f
        kinds = ["degenerate"] * 4
    elif set(kinds) == {"centre"}:
        kinds = [_turning_kind(system, window, x, room, abs(values[0][0]))] * 4
    return Equilibrium(x, tuple(kinds), tuple(values), x)  # type: ignore[arg-type]


def _slope(system: PhaseSystem, x: float, along_x: float, along_v: float) -> float:
    """Return the one-sided change of f over a step, of third order: exact on cubic pieces."""
    k = np.arange(4.0)
    f = system.forces(x + k * along_x, k * along_v)
    return float((18.0 * f[1] - 9.0 * f[2] + 2.0 * f[3] - 11.0 * f[0]) / 6.0)


def _bent_kind(restores: bool, damping: float) -> str:
    """Return the kind on a side where f has no slope but restores, or repels."""
    if not restores:
        return "saddle"
    if damping == 0.0:
        return "centre"
    return "stable node" if damping > 0.0 else "unstable node"


def _turning_kind(system: PhaseSystem, window: Window, x: float, room: float, omega: float) -> str:
    """Return the kind of a centre of the linear part.

    It follows from the dissipation around it, at whatever distance; if that is positive and negative,
    from the first focal value that is not zero; if there is none, from turns. It stays a centre if small
    motions meet no damping: if that begins at some distance, all at once.

    Parameters
    ----------
    omega : angular frequency of small motions, rad/s; 0 without a linear part
    """
    considerable = _size_of_damping(system, x, window.width)
    room = max(room, _CLOSE * considerable)
    angle = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
    size = _RINGS[:, None] * room
    force = _largest(system.forces(x + np.array([room, -room]), np.zeros(2)))
    height = sqrt(force / room) if force > 0.0 else window.height / window.width
    away, v = size * np.cos(angle), height * size * np.sin(angle)
    lost = power(system, x + away, v)
    outer = slice(len(size) - _OUTER, None)
    (damped,) = np.nonzero(lost[outer].any(axis=1))
    if not len(damped):
        return "centre"
    first = len(size) - _OUTER + damped[0]
    begins = np.abs(lost[first]).max() > _GRADUAL * force * np.abs(v[first]).max()
    if begins and damped[0] > 0:
        return "centre"
    gains, losses = np.any(lost < 0.0, axis=1), np.any(lost > 0.0, axis=1)
    alone = losses[losses != gains]  # of rings that only lose, or only gain; limit cycles part them
    alike = bool((alone == alone[:1]).all())
    if losses[first] != gains[first] and alike:
        return "stable focus" if losses[first] else "unstable focus"
    if _is_mirrored(system, x, away[outer], v[outer]):
        return "centre"
    if omega > 0.0 and (value := first_focal_value(system, x, omega, window.width)):
        return "stable focus" if value < 0.0 else "unstable focus"
    if alike:
        return _kind_by_turns(system, x, considerable)
    inner = int((alone != alone[0]).argmax())
    return UNDECIDED if inner < _MANY else "stable focus" if alone[0] else "unstable focus"


def _kind_by_turns(system: PhaseSystem, x: float, widest: float) -> str:
    """Return the kind of a centre of the linear part by smaller and smaller turns about it.

    Three successive turns decide if the parts by which they change their distances go with a power of
    it, or one that is closed. A wider turn may be beyond a limit cycle, may not return, or may come too
    near to where motions part to be followed.

    Parameters
    ----------
    widest : distance at which the first begins
    """
    changes: list[float] = []
    for distance in widest * 0.5 ** np.arange(_TURNS):
        start, side = np.array([x + distance]), 3.0 * distance
        top = side * float(_steepness(system, x, distance))
        if not (top > 0.0 and x - side < x < x + side):
            break  # the distance is lost in the rounding of x
        around = Window(x - side, x + side, -top, top)
        change, roughly = (
            float((turns(system, around, start, tolerance=tolerance).back - start)[0]) / distance
            for tolerance in (1e-11, 1e-9)
        )
        if abs(change) < _SPIRALS:
            return UNDECIDED if changes else "centre"
        if not abs(change - roughly) < 0.1 * abs(change):
            changes.clear()
            continue
        changes.append(change)
        if len(changes) > 2:
            first, second = changes[-3] / changes[-2], changes[-2] / changes[-1]
            if first > 1.0 and second > 1.0 and abs(first - second) < _ALIKE * second:
                return "stable focus" if change < 0.0 else "unstable focus"
    return UNDECIDED


def _size_of_damping(system: PhaseSystem, x: float, scale: float) -> float:
    """Return the smallest distance at which the part of damping in the forces of a turn is considerable.

    Parameters
    ----------
    scale : any length, of x
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 65)[:-1]
    sizes = scale * _SIZES
    steep = _steepness(system, x, sizes)
    away = x + sizes[:, None] * np.cos(angle)
    with np.errstate(all="ignore"):  # at a pole of f, and beyond what restores
        v = (steep * sizes)[:, None] * np.sin(angle)
        damped = np.abs(system.forces(away, v) - system.forces(away, 0.0 * away)).max(axis=1)
        share = damped / (steep**2 * sizes)
    known = np.isfinite(share)
    begin = int(known.argmax())  # what is smaller is lost in the rounding of x
    unknown = np.flatnonzero(~known[begin:])  # what is larger reaches beyond what restores
    share = share[begin : begin + unknown[0]] if len(unknown) else share[begin:]
    counts = share >= min(_DAMPED, 0.5 * share.max(initial=0.0))
    return float(sizes[begin + int(counts.argmax())]) if len(share) else float(sizes[0])


def _steepness(system: PhaseSystem, x: float, away: Grid | float) -> Grid:
    """Return the rate of motions about an equilibrium over their displacement, 1/s."""
    away = np.asarray(away)
    forces = np.maximum(system.forces(x + away, 0.0 * away), -system.forces(x - away, 0.0 * away))
    with np.errstate(all="ignore"):
        return np.sqrt(forces / away)


def _is_mirrored(system: PhaseSystem, x: float, away: Grid, v: Grid) -> bool:
    """Return whether f is even in v, or odd about x: then so are motions, and turns are closed."""
    f, still = system.forces(x + away, v), system.forces(x + away, 0.0 * v)
    with np.errstate(invalid="ignore"):  # outside the domain of f
        damping = np.abs(f - still).max(axis=1)
        rounding = _ROUNDED * (1.0 + abs(x) / np.abs(away).max(axis=1)) * np.abs(f).max(axis=1)
        allowed = (_MIRRORED * damping + rounding)[:, None]
        mirrored = (system.forces(x + away, -v), -system.forces(x - away, v))
        return any(bool((np.abs(f - other) <= allowed).all()) for other in mirrored)


def kind_of(first: complex, second: complex) -> str:
    """Return the kind of an equilibrium by its two eigenvalues, of which none is zero.

    Where f jumps at x' = 0 one is huge: friction that drives makes an unstable node.
    """
    size = max(abs(first), abs(second))
    real = max(abs(first.real), abs(second.real)) > 1e-7 * size
    if abs(first.imag) > 1e-7 * size:
        if not real:
            return "centre"
        return f"{'stable' if first.real < 0.0 else 'unstable'} focus"
    if first.real * second.real < 0.0:
        return "saddle"
    return f"{'stable' if first.real < 0.0 else 'unstable'} node"


def separatrices(
    system: PhaseSystem, window: Window, *saddles: Equilibrium, ends: tuple[float, ...] = ()
) -> list[Grid]:
    """Return the curves into and out of saddles, four for each, of shape (points, 2).

    Parameters
    ----------
    ends : displacements of saddles in which a curve may end, for a conservative system

    Raises
    ------
    ValueError : an equilibrium that is not a saddle on any side.
    """
    starts = [start for saddle in saddles for start in _starts(system, window, saddle)]
    if not starts:
        return []
    origin, x, v, sense = np.array(starts).T
    curves = traced(
        system, window, x, v, sense, margin=0.5, length=_LONGEST, tolerance=1e-9, ends=ends
    )
    return [np.vstack([[at, 0.0], curve]) for at, curve in zip(origin, curves, strict=True)]


def _starts(
    system: PhaseSystem, window: Window, saddle: Equilibrium
) -> list[tuple[float, float, float, float]]:
    """Return the starts of a saddle's curves: its x, then x, x' and the direction of time."""
    if "saddle" not in saddle.kinds:
        raise ValueError(f"the equilibrium at {saddle.x:g} is not a saddle but a {saddle.kind}")
    starts = []
    for side, (kind, pair) in enumerate(zip(saddle.kinds, saddle.eigenvalues, strict=True)):
        if kind != "saddle":
            continue
        sx, sv = (1.0 if side < 2 else -1.0), (1.0 if side % 2 == 0 else -1.0)
        for rate, part in _rates(system, window, saddle.x, sx, pair):
            if sx * rate * sv < 0.0 or rate == 0.0:
                continue  # that eigenvector (1, rate) leaves through another side
            size = part / sqrt((1.0 / window.width) ** 2 + (rate / window.height) ** 2)
            sense = 1.0 if rate > 0.0 else -1.0
            starts.append((saddle.x, saddle.x + sx * size, sx * rate * size, sense))
    return starts


def _rates(
    system: PhaseSystem, window: Window, x: float, sx: float, pair: tuple[complex, complex]
) -> list[tuple[float, float]]:
    """Return slopes x'/x of the curves through a saddle on one side, and the distance of their starts.

    Without a linear part they follow from the energy at some distance: x'^2 / 2 = -U.
    """
    if min(abs(pair[0]), abs(pair[1])) > 0.0:
        return [(value.real, _AWAY) for value in pair]
    out = np.linspace(0.0, _FAR * window.width, 65)
    forces = system.forces(x + sx * out, 0.0 * out) * sx
    given_up = -2.0 * float(np.trapezoid(forces, out)) / out[-1] ** 2
    damping = -(pair[0] + pair[1]).real
    root = sqrt(max(damping**2 / 4.0 + given_up, 0.0))
    return [(-damping / 2.0 + root, _FAR), (-damping / 2.0 - root, _FAR)]
