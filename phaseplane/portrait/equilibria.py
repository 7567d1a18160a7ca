"""Equilibria with their kinds, also on corners, and the separatrices of saddles."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from phaseplane.portrait.system import Grid, PhaseSystem, Window

_STEP = 1e-6  # of the window's width, for differences
_SAME = 1e-9  # of the window's width
_AWAY = 1e-4  # of the window's width: where a separatrix is started beside its saddle


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """A state of rest (x, 0).

    Parameters
    ----------
    x : its displacement
    kinds : by eigenvalues, as seen from the sides (x above, x' above), (x above, x' below), (x below,
        x' above), (x below, x' below); all the same unless it lies on a corner
    eigenvalues : of the same sides
    """

    x: float
    kinds: tuple[str, str, str, str]
    eigenvalues: tuple[tuple[complex, complex], ...]

    @property
    def on_corner(self) -> bool:
        """Whether the sides differ."""
        return len(set(self.kinds)) > 1

    @property
    def kind(self) -> str:
        """Its kind; on a corner those of all sides, each once."""
        return " / ".join(dict.fromkeys(self.kinds))


def equilibria(system: PhaseSystem, window: Window, resolution: int = 2000) -> list[Equilibrium]:
    """All states of rest in a window, at time 0: f(0, x, 0) = 0.

    Parameters
    ----------
    resolution : into how many parts the window is divided in the search
    """
    width = window.right - window.left
    corners = [c for c in system.corners if window.left <= c <= window.right]
    points = np.unique(
        np.concatenate([np.linspace(window.left, window.right, resolution + 1), corners])
    )
    forces = system.forces(points, 0.0 * points)
    roots = list(points[forces == 0.0])
    for k in np.flatnonzero(forces[:-1] * forces[1:] < 0.0):
        roots.append(
            brentq(
                lambda x: system.function(0.0, x, 0.0),
                points[k],
                points[k + 1],
                xtol=1e-15 * width,
                maxiter=1000,
            )
        )
    found: list[Equilibrium] = []
    for x in sorted(map(float, roots)):
        near = min(corners, key=lambda c: abs(c - x), default=x)
        at = near if abs(near - x) <= _SAME * width else x
        if not found or at - found[-1].x > _SAME * width:
            found.append(_classified(system, at, width))
    return found


def _classified(system: PhaseSystem, x: float, width: float) -> Equilibrium:
    """The kinds on the four sides, by one-sided differences."""
    h = _STEP * width
    sides = [(sx, sv) for sx in (1.0, -1.0) for sv in (1.0, -1.0)]

    def slope(along_x: float, along_v: float) -> float:
        # of second order from one side: exact on straight and on parabolic pieces
        f = [system.function(k * along_v, x + k * along_x, 0.0) for k in range(3)]
        return (4.0 * f[1] - f[2] - 3.0 * f[0]) / 2.0

    values = []
    for sx, sv in sides:
        stiffness, damping = slope(sx * h, 0.0) / (sx * h), slope(0.0, sv * h) / (sv * h)
        root = np.emath.sqrt(damping**2 / 4.0 - stiffness)
        values.append((complex(-damping / 2.0 + root), complex(-damping / 2.0 - root)))
    kinds = tuple(kind_of(*pair) for pair in values)
    return Equilibrium(x, kinds, tuple(values))  # type: ignore[arg-type]


def kind_of(first: complex, second: complex) -> str:
    """The kind of an equilibrium by its two eigenvalues."""
    size = max(abs(first), abs(second))
    real = max(abs(first.real), abs(second.real)) > 1e-7 * size
    if size == 0.0 or min(abs(first), abs(second)) <= 1e-9 * size:
        return "degenerate"
    if abs(first.imag) > 1e-7 * size:
        if not real:
            return "centre"
        return f"{'stable' if first.real < 0.0 else 'unstable'} focus"
    if first.real * second.real < 0.0:
        return "saddle"
    return f"{'stable' if first.real < 0.0 else 'unstable'} node"


def separatrices(
    system: PhaseSystem, window: Window, saddle: Equilibrium, duration: float | None = None
) -> list[Grid]:
    """The four curves that run into a saddle or out of it, each of shape (points, 2).

    Parameters
    ----------
    duration : how long they are followed, s; twenty times the slowest eigenvalue's time if left out

    Raises
    ------
    ValueError : an equilibrium that is a saddle from no side.
    """
    if "saddle" not in saddle.kinds:
        raise ValueError(f"the equilibrium at {saddle.x:g} is no saddle but a {saddle.kind}")
    width, height = window.right - window.left, window.top - window.bottom
    curves = []
    for side, (kind, pair) in enumerate(zip(saddle.kinds, saddle.eigenvalues, strict=True)):
        for value in pair if kind == "saddle" else ():
            rate = value.real
            sx = 1.0 if side < 2 else -1.0
            sv = 1.0 if side % 2 == 0 else -1.0
            if sx * rate * sv < 0.0:
                continue  # that eigenvector (1, rate) leaves through another side
            size = _AWAY / sqrt((1.0 / width) ** 2 + (rate / height) ** 2)
            start = [saddle.x + sx * size, sx * rate * size]
            time = duration or 20.0 / min(abs(v.real) for v in pair)
            curves.append(_followed(system, window, start, time if rate > 0.0 else -time, saddle.x))
    return curves


def _followed(
    system: PhaseSystem, window: Window, start: list[float], time: float, x: float
) -> Grid:
    def gone(_t: float, state: npt.NDArray[np.float64]) -> float:
        return 1.0 if window.holds(state[0], state[1], 0.5) else -1.0

    gone.terminal = True  # type: ignore[attr-defined]
    solution = solve_ivp(
        system.rates, (0.0, time), start, rtol=1e-9, atol=1e-12, events=gone,
        max_step=abs(time) / 400.0,
    )  # fmt: skip
    return np.vstack([[x, 0.0], solution.y.T])
