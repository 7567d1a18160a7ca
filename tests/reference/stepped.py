"""Integrators stepped from one instant to the next, and a single mass for them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from phaseplane.suspension import roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.systems import Element, Load, System


def mass_on(
    *elements: Element, mass: float = 1.0, force: float | Signal = 0.0, scale: float = 0.05
) -> System:
    """A mass on some elements with a force on it."""
    signal = force if isinstance(force, Signal) else roads.constant(force)
    loads = (Load((1.0,), "force"),)
    return System(("x",), ((mass,),), elements, {"force": signal}, loads, (scale,))


def started(system: System, x: float = 0.0, v: float = 0.0, **options: object) -> Integrator:
    """An integrator of a single mass at some place and velocity."""
    integrator = Integrator(system, **{"tolerance": 1e-11, **options})
    integrator.set_state([x], [v])
    return integrator


def at(integrator: Integrator, t: float) -> tuple[float, float]:
    """Displacement and velocity of the first coordinate at an instant."""
    assert integrator.advance(t) == 0
    integrator.sample(t)
    return integrator.sample_q[0], integrator.sample_v[0]


def displaced(integrator: Integrator, times: Iterable[float]) -> NDArray[np.float64]:
    """All displacements at some instants, one row each."""
    rows = []
    for t in times:
        at(integrator, float(t))
        rows.append(list(integrator.sample_q))
    return np.array(rows)
