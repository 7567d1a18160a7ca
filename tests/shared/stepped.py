"""Integrators stepped from one instant to the next or through a whole run, and a single mass for them."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from phaseplane.suspension import roads
from phaseplane.suspension.engine import Filling, Integrator
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.systems import Element, Load, System

STOPS = {
    "damper.rebound_limit": 588.399, "damper.bump_limit": 294.1995, "damper.limit_slope": 200.0,
    "bump_stop.gap": 0.02, "bump_stop.stiffness": 3e5,
    "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 3e5,
}  # fmt: skip


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


def read_at(integrator: Any, t: float, *, stop: bool = False) -> tuple[list[float], list[float]]:
    """All displacements and velocities at an instant, to which the run goes on."""
    assert integrator.advance(t, stop) == 0
    integrator.sample(t)
    return list(integrator.sample_q), list(integrator.sample_v)


def at(integrator: Integrator, t: float) -> tuple[float, float]:
    """Displacement and velocity of the first coordinate at an instant."""
    (x, *_), (v, *_) = read_at(integrator, t)
    return x, v


def displaced(integrator: Integrator, times: Iterable[float]) -> NDArray[np.float64]:
    """All displacements at some instants, one row each."""
    return np.array([read_at(integrator, float(t))[0] for t in times])


def filled(integrator: Any, times: Iterable[float], *counts: int) -> list[NDArray[np.float64]]:
    """Displacements, velocities, accelerations and forces of a run in one call, a row for each instant.

    `counts` are those of the coordinates, for as many of the four as are wanted, and of the elements.
    """
    instants = array("d", times)
    columns = [np.zeros((count, len(instants))) for count in counts]
    assert Filling(integrator, instants, *(c.reshape(-1) for c in columns)).fill() == 0
    return [column.T for column in columns]
