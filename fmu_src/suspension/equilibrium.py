"""Static equilibrium of a system: sum b f(b' q - u, 0) = p.

The forces at rest are the gradient of a potential U(q). It is minimised by Newton steps with the
tangent of the present branches. A step that does not reduce U is shortened and turned towards steepest
descent, so that the iteration cannot cycle between the branches of stops, tables and tyres.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from operator import mul

from .characteristics import Characteristic, Piece, polyline
from .systems import Element, System

_MOST_STEPS = 400


def static_equilibrium(
    system: System, signals: Mapping[str, float] | None = None
) -> tuple[float, ...]:
    """Return the displacements at which a system rests, for given road levels and loads.

    sum b f(b' q - u, 0) = p, with dry friction left out

    Parameters
    ----------
    system : any system
    signals : elevation (m) or force (N) of its roads and loads by name; the others are 0

    Returns
    -------
    One displacement per coordinate, m.

    Raises
    ------
    ValueError : no equilibrium was found: a coordinate is not held by any spring, or is unstable.
    """
    rest = _Rest(system, signals or {})
    q = [0.0] * len(system.mass)
    shift = 0.0  # of the tangent, in units of the mass matrix
    for _step in range(_MOST_STEPS):
        slope, tangent, size = rest.slope(q)
        if all(abs(s) <= 1e-13 * big for s, big in zip(slope, size, strict=True)):
            return tuple(q)
        matrix = [
            [k + shift * m for k, m in zip(row, masses, strict=True)]
            for row, masses in zip(tangent, system.mass, strict=True)
        ]
        change = _solution(matrix, slope)
        trial = [x - dx for x, dx in zip(q, change, strict=True)] if change else []
        if trial and all(map(isfinite, trial)) and rest.falls(q, trial, slope):
            if trial == q:
                return tuple(q)
            q, shift = trial, 0.1 * shift if shift > rest.least_shift else 0.0
        elif change and all(x - dx == x for x, dx in zip(q, change, strict=True)):
            return tuple(q)  # to rounding
        else:
            shift = max(4.0 * shift, rest.least_shift)
        if not shift < inf:
            break
    raise ValueError(
        "no static equilibrium was found: every coordinate must be held by springs that can carry "
        "its load"
    )


class _Rest:
    """Potential and forces of a system at rest."""

    def __init__(self, system: System, signals: Mapping[str, float]) -> None:
        self._elements = [
            (e, _law_at_rest(e), signals.get(e.road, 0.0) if e.road else 0.0)
            for e in system.elements
        ]
        n = len(system.mass)
        self._load = [
            sum(load.direction[i] * signals.get(load.signal, 0.0) for load in system.loads)
            for i in range(n)
        ]
        stiffness = sum(
            abs(law.tangent(0.0)) * b * b for e, law, _ in self._elements for b in e.direction
        )
        self.least_shift = 1e-6 * (stiffness or 1.0) / max(system.mass[i][i] for i in range(n))

    def potential(self, q: Sequence[float]) -> float:
        """U(q), J."""
        total = -sum(map(mul, self._load, q))
        for e, law, level in self._elements:
            d = sum(map(mul, e.direction, q)) - level
            total += law.potential(d)
        return total

    def slope(self, q: Sequence[float]) -> tuple[list[float], list[list[float]], list[float]]:
        """Return the gradient of U, its tangent, and the magnitude of the terms in the gradient."""
        n = len(q)
        slope, size = [-p for p in self._load], [abs(p) for p in self._load]
        tangent = [[0.0] * n for _ in range(n)]
        for e, law, level in self._elements:
            b = e.direction
            d = sum(map(mul, b, q)) - level
            force, k = law.force(d), law.tangent(d)
            # the magnitude includes the effect of rounding in d on the force
            rounding = abs(force) + abs(k) * (
                abs(level) + sum(abs(x * y) for x, y in zip(b, q, strict=True))
            )
            for i in range(n):
                slope[i] += b[i] * force
                size[i] += abs(b[i]) * rounding
                for j in range(n):
                    tangent[i][j] += b[i] * b[j] * k
        return slope, tangent, size

    def falls(self, q: Sequence[float], trial: Sequence[float], slope: Sequence[float]) -> bool:
        """Return whether U decreases from q to the trial or, within rounding, its gradient does."""
        before, after = self.potential(q), self.potential(trial)
        if abs(after - before) > 1e-9 * (abs(before) + abs(after)):
            return after < before
        now = self.slope(trial)[0]
        return max(map(abs, now)) < max(map(abs, slope))


def _law_at_rest(element: Element) -> Characteristic:
    """Return the force over deflection at rest: up to the limit, and along the yield lines."""
    law = element.spring
    if element.yield_force < inf:
        rate, flow, free = law.tangent(0.0), element.hardening, element.permanent_set
        line = element.yield_force * (1.0 - flow / rate)
        ends = [(rate * free + side * line) / (rate - flow) for side in (-1.0, 1.0)]
        return polyline([(d, rate * (d - free)) for d in ends], flow, flow)
    free = law.argument(element.limit) if element.limit < inf else inf
    if not abs(free) < inf:
        return law
    kept = [piece for piece in law.pieces if piece.start < free]
    return Characteristic((*kept, Piece(free, free, (element.limit, 0.0, 0.0, 0.0))))


def _solution(matrix: list[list[float]], right: Sequence[float]) -> list[float]:
    """Solve a symmetric positive definite system by elimination; empty if it is not definite."""
    n = len(right)
    rows = [[*row, x] for row, x in zip(matrix, right, strict=True)]
    for k in range(n):
        if not rows[k][k] > 1e-14 * abs(matrix[k][k]):
            return []
        for i in range(k + 1, n):
            ratio = rows[i][k] / rows[k][k]
            rows[i] = [x - ratio * y for x, y in zip(rows[i], rows[k], strict=True)]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x
