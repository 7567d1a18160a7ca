"""A system linearised about rest on a level road: natural frequencies and damping ratios.

    M q'' + B q' + K q = 0

with the tangents at static equilibrium. At a corner of a law (a damper with different rates) the mean
of the slopes on both sides is used. Dry friction is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, nextafter, pi
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.equilibrium import static_equilibrium
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import Value

if TYPE_CHECKING:
    import numpy.typing as npt

    Matrix = npt.NDArray[np.float64]

_REAL = 1e-9  # of its magnitude: an eigenvalue with a smaller imaginary part counts as real


@dataclass(frozen=True)
class Mode:
    """One mode of free motion.

    Parameters
    ----------
    frequency : natural frequency |s| / 2 pi, Hz
    damping_ratio : -Re s / |s|; 1 if s = 0
    """

    frequency: float
    damping_ratio: float


@dataclass(frozen=True)
class Linearised:
    """A system linearised about rest.

    Parameters
    ----------
    coordinates : names of the coordinates
    mass, damping, stiffness : shape (n, n), kg, N s/m, N/m
    series : of each spring in series with a damper: direction b, shape (n,); its rate k, N/m; and k/c,
        1/s, with the rate c of the damper
    """

    coordinates: tuple[str, ...]
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    series: tuple[tuple[Matrix, float, float], ...] = ()

    def modes(self) -> list[Mode]:
        """Return all modes, lowest frequency first; each real eigenvalue is a mode of its own.

        The state is q, q' and the extension x of each spring in series, x' = b' q' - k x / c.
        """
        n, more = len(self.mass), len(self.series)
        along = np.array([b for b, _, _ in self.series]).reshape(more, n)
        pull = np.array([k * b for b, k, _ in self.series]).reshape(more, n).T
        state = np.block(
            [
                [np.zeros((n, n)), np.eye(n), np.zeros((n, more))],
                [-np.linalg.solve(self.mass, x) for x in (self.stiffness, self.damping, pull)],
                [np.zeros((more, n)), along, -np.diag([rate for _, _, rate in self.series])],
            ]
        )
        modes = []
        for s in np.linalg.eigvals(state):
            size = float(abs(s))
            creeps = abs(s.imag) <= _REAL * size
            if s.imag > 0.0 or creeps:
                ratio = float(-s.real / size) if size > 0.0 else 1.0
                modes.append(Mode(size / (2.0 * pi), ratio))
        return sorted(modes, key=lambda mode: mode.frequency)


def about_rest(model: str, parameters: Mapping[str, Value]) -> Linearised:
    """Linearise a model on a level road, as `linearised`."""
    level = {"road.shape": "flat"} if "road.shape" in parameters else {}
    return linearised(build(model, {**parameters, **level}))


def linearised(system: System) -> Linearised:
    """Linearise a system about its static equilibrium.

    Raises
    ------
    ValueError : if the system has no equilibrium.
    """
    n = len(system.mass)
    rest = static_equilibrium(system)
    damping, stiffness = np.zeros((n, n)), np.zeros((n, n))
    series = []
    for e in system.elements:
        b = np.array(e.direction)
        if e.series < inf:
            series.append((b, e.series, e.series / e.damper.tangent(0.0)))
            continue
        deflection = float(b @ rest)
        k = _tangent(e.spring, deflection)
        c = _tangent(e.damper, 0.0) * e.modulation.force(deflection)
        stiffness += k * np.outer(b, b)
        damping += c * np.outer(b, b)
    return Linearised(system.coordinates, np.array(system.mass), damping, stiffness, tuple(series))


def _tangent(law: Characteristic, x: float) -> float:
    """Return the slope at x; at a corner the mean of both sides."""
    return 0.5 * (law.tangent(x) + law.tangent(nextafter(x, -inf)))
