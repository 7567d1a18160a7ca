"""A system linearised about rest: natural frequencies, damping ratios, transfer functions.

    M q'' + B q' + K q = sum b (c u' + k u)

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
    damping_ratio : -Re s / |s|; 1 for a real eigenvalue
    shape : complex displacements of the coordinates, scaled so that the largest is 1, shape (n,)
    """

    frequency: float
    damping_ratio: float
    shape: npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Linearised:
    """A system linearised about rest.

    Parameters
    ----------
    coordinates : names of the coordinates
    mass, damping, stiffness : shape (n, n), kg, N s/m, N/m
    road_damping, road_stiffness : force per velocity and per elevation of each road, shape (n,)
    series : of each spring in series with a damper: direction b, shape (n,); its rate k, N/m; and k/c,
        1/s, with the rate c of the damper
    """

    coordinates: tuple[str, ...]
    mass: Matrix
    damping: Matrix
    stiffness: Matrix
    road_damping: dict[str, Matrix]
    road_stiffness: dict[str, Matrix]
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
        values, vectors = np.linalg.eig(state)
        modes = []
        for s, vector in zip(values, vectors.T, strict=True):
            size = float(abs(s))
            creeps = abs(s.imag) <= _REAL * size
            if s.imag > 0.0 or creeps:
                shape = vector[:n]
                shape = shape / shape[abs(shape).argmax()]
                ratio = float(-s.real / size) if size > 0.0 else 1.0
                modes.append(Mode(size / (2.0 * pi), ratio, shape))
        return sorted(modes, key=lambda mode: mode.frequency)

    def transfer(self, road: str, frequencies: Matrix) -> npt.NDArray[np.complex128]:
        """Return the displacements of the coordinates for a unit sine of a road's elevation.

        (K + i w B - w^2 M) q = sum b (k + i w c)

        A spring k in series with a damper c adds b i w k / (k/c + i w) b' on the left.

        Parameters
        ----------
        road : name of the road's signal
        frequencies : Hz, shape (m,)

        Returns
        -------
        Complex amplitudes, m/m, shape (m, n).
        """
        w = 2.0 * pi * np.asarray(frequencies)[:, None, None]
        dynamic = self.stiffness + 1j * w * self.damping - w**2 * self.mass
        for b, k, rate in self.series:
            dynamic = dynamic + 1j * w * k / (rate + 1j * w) * np.outer(b, b)
        excitation = self.road_stiffness[road] + 1j * w[..., 0] * self.road_damping[road]
        return np.linalg.solve(dynamic, excitation[..., None])[..., 0].astype(complex)


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
    roads = {e.road for e in system.elements if e.road}
    road_damping, road_stiffness = ({road: np.zeros(n) for road in roads} for _ in range(2))
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
        if e.road:
            road_stiffness[e.road] += k * b
            road_damping[e.road] += c * b
    return Linearised(
        system.coordinates, np.array(system.mass), damping, stiffness, road_damping, road_stiffness,
        tuple(series),
    )  # fmt: skip


def _tangent(law: Characteristic, x: float) -> float:
    """Return the slope at x; at a corner the mean of both sides."""
    return 0.5 * (law.tangent(x) + law.tangent(nextafter(x, -inf)))
