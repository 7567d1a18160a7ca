"""One motion by the compiled and by the uncompiled kernel, which must agree to the bit."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from phaseplane.suspension import engine
from phaseplane.suspension.systems import System

_NAME = "uncompiled_kernel"


def _uncompiled() -> Any:
    """The integrator from its source, beside the compiled one in this process."""
    package = ModuleType(_NAME)
    package.__path__ = [str(engine.KERNEL)]
    sys.modules[_NAME] = package
    with engine.cython_directives():
        return import_module(f"{_NAME}.interface").Integrator


UNCOMPILED = _uncompiled()
_KERNELS = (UNCOMPILED, engine.Integrator)


class Switch(NamedTuple):
    """An element changes branch: instant in s, its name, what of it, branch left and entered."""

    time: float
    element: str
    kind: str
    before: int
    after: int


class Motion(NamedTuple):
    """Displacements and velocities, (len(times), n), and all switches."""

    displacements: NDArray[np.float64]
    velocities: NDArray[np.float64]
    switches: list[Switch]

    def instants(self, element: str = "") -> list[float]:
        """When an element, or any, has switched."""
        return [s.time for s in self.switches if element in ("", s.element)]


def motion(
    system: System,
    times: Sequence[float],
    displacements: Sequence[float] = (),
    velocities: Sequence[float] = (),
    **options: Any,
) -> Motion:
    """The motion from some state at 0 (at rest, if left out), the same to the bit by both kernels."""
    rest = [0.0] * len(system.mass)
    found = []
    for kernel in _KERNELS:
        integrator = kernel(system, **options)
        integrator.set_state(list(displacements) or rest, list(velocities) or rest)
        rows = []
        for t in times:
            assert integrator.advance(t) == 0
            integrator.sample(t)
            rows.append([*integrator.sample_q, *integrator.sample_v])
        found.append((rows, integrator.log))
    uncompiled, compiled = found
    assert uncompiled == compiled
    rows, log = compiled
    n = len(rest)
    switches = [Switch(t, system.elements[e].name, engine.KINDS[k], *way) for t, e, k, *way in log]
    return Motion(np.array(rows)[:, :n], np.array(rows)[:, n:], switches)
