"""Where the energy of a run is: moving, stored, dissipated, brought in (L2 eqs. 21, 26).

T + U + D = W, with T = v' M v / 2, U the potentials of the springs, D what the elements have taken
up and do not give back, and W the work of the road. Taken from the columns of the run: works are
sums over its rows by the trapezoidal rule, so they are as exact as the rows are close.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import Value

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Reals = npt.NDArray[np.float64]


def energies(
    model: str, parameters: Mapping[str, Value], columns: Mapping[str, Reals]
) -> dict[str, Reals]:
    """Columns of energy, J, by name; none where the columns do not hold the whole motion.

    Parameters
    ----------
    model : key of `suspension.variables.MODELS`
    parameters : its public parameters, SI
    columns : `time`, displacements, velocities and the ground under the wheels, shape (rows,), SI
    """
    system = build(model, parameters)
    motion = _motion(system, columns)
    if motion is None or any(isfinite(e.yield_force) or e.friction for e in system.elements):
        return {}
    q, v, grounds = motion
    stored, dissipated, work = np.zeros(q.shape[1]), np.zeros(q.shape[1]), np.zeros(q.shape[1])
    for element in system.elements:
        ground, rate = grounds.get(element.road, (0.0, 0.0))
        b = np.array(element.direction)
        d, w = b @ q - ground, b @ v - rate
        force = _force(element, d, w)
        potential = _potential(element, d)
        taken_up = _summed(columns["time"], force * w)
        stored += potential
        dissipated += taken_up - (potential - potential[0])
        work -= _summed(columns["time"], force * rate)
    moving = 0.5 * np.einsum("it,ij,jt->t", v, np.array(system.mass), v)
    return {
        "kinetic_energy": moving,
        "stored_energy": stored,
        "dissipated_energy": dissipated,
        "supplied_energy": work,
    }


def _motion(
    system: System, columns: Mapping[str, Reals]
) -> tuple[Reals, Reals, dict[str, tuple[Reals, Reals]]] | None:
    """Displacements and velocities, shape (coordinates, rows), and the grounds by their signals."""
    grounds = {
        axle.road: tuple(f"{axle.prefix}ground_{what}" for what in ("elevation", "velocity"))
        for axle in system.axles
    }
    names = {
        order: [f"{coordinate}_{order}" for coordinate in system.coordinates]
        for order in ("displacement", "velocity")
    }
    needed = {n for group in (*names.values(), *grounds.values()) for n in group}
    if not needed <= columns.keys() or not system.axles:
        return None
    q, v = (np.array([columns[name] for name in group], float) for group in names.values())
    return q, v, {road: (columns[x], columns[y]) for road, (x, y) in grounds.items()}


def _force(element: Element, d: Reals, w: Reals) -> Reals:
    force = [
        element.spring.force(x) + element.damper.force(y) * element.modulation.force(x)
        for x, y in zip(d.tolist(), w.tolist(), strict=True)
    ]
    return np.minimum(force, element.limit)


def _potential(element: Element, d: Reals) -> Reals:
    """Potential of a spring, linear where an element that cannot pull is beyond its limit."""
    free = _free_deflection(element)
    elastic = np.array([element.spring.potential(x) for x in np.minimum(d, free).tolist()])
    beyond = np.maximum(0.0, d - free)
    return elastic + np.where(beyond > 0.0, min(element.limit, 1e300), 0.0) * beyond


def _free_deflection(element: Element) -> float:
    """The deflection at which a spring alone has the force that its element is limited to, m."""
    if not isfinite(element.limit):
        return inf
    low, high = 0.0, 1.0
    while element.spring.force(high) < element.limit:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if element.spring.force(middle) < element.limit else (low, middle)
        )
    return high


def _summed(times: Reals, power: Reals) -> Reals:
    """Integral over time from the first instant on, by the trapezoidal rule."""
    parts = 0.5 * np.diff(times) * (power[1:] + power[:-1])
    return np.concatenate([[0.0], np.cumsum(parts)])
