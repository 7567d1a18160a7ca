"""The modes of a linearised system, each in its own phase plane (H83 chapters 10 and 11).

    K v = Omega^2 M v,    v^T M v = 1,    2 xi Omega = v^T B v

In the modal coordinates eta = v^T M q free undamped motion is a circle in every plane (eta, eta'/Omega).
With proportional damping it is a spiral in each plane by itself; other damping couples the planes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import eigh, expm

from .linearised import Linearised

Matrix = npt.NDArray[np.float64]

_COUPLED = 1e-9  # of the largest modal damping: smaller terms beside the diagonal are rounding
_POINTS = 120  # of a period


@dataclass(frozen=True)
class ModalPlanes:
    """The undamped modes of a system, lowest frequency first.

    Parameters
    ----------
    coordinates : names of the coordinates
    angular_frequencies : Omega, rad/s, shape (n,)
    shapes : v by columns, normed by v^T M v = 1, shape (n, n)
    damping : v_i^T B v_j, shape (n, n); diagonal if the damping is proportional
    """

    coordinates: tuple[str, ...]
    angular_frequencies: Matrix
    shapes: Matrix
    damping: Matrix

    @property
    def damping_ratios(self) -> Matrix:
        """xi = v^T B v / (2 Omega) of each mode; exact if the damping is proportional."""
        return np.asarray(np.diag(self.damping) / (2.0 * self.angular_frequencies))

    @property
    def proportional(self) -> bool:
        """Whether the damping leaves the modes to themselves."""
        beside = self.damping - np.diag(np.diag(self.damping))
        return bool(np.abs(beside).max(initial=0.0) <= _COUPLED * np.abs(self.damping).max())

    def free(self, mode: int, periods: float = 5.0) -> Matrix:
        """Return free motion from the shape of a mode, in all planes: eta and eta'/Omega.

        Parameters
        ----------
        mode : index of the mode whose eta begins at 1, the others at rest
        periods : of this mode

        Returns
        -------
        shape (points, n, 2)
        """
        n, omega = len(self.angular_frequencies), self.angular_frequencies
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(omega**2), -self.damping]])
        step = expm(state * 2.0 * np.pi / omega[mode] / _POINTS)
        at = np.zeros(2 * n)
        at[mode] = 1.0
        points = [at]
        for _ in range(round(periods * _POINTS)):
            points.append(step @ points[-1])
        found = np.array(points)
        return np.stack([found[:, :n], found[:, n:] / omega], axis=-1)


def modal_planes(system: Linearised) -> ModalPlanes:
    """Return the modal planes of a linearised system.

    Raises
    ------
    ValueError : a mode without stiffness, or a spring in series with a damper, which have no phase
        plane.
    """
    if system.series:
        raise ValueError("a system with a spring in series with a damper has no modal planes")
    squares, shapes = eigh(system.stiffness, system.mass)
    if squares[0] <= 1e-12 * squares[-1]:
        raise ValueError("a mode without stiffness has no phase plane")
    return ModalPlanes(
        system.coordinates, np.sqrt(squares), shapes, shapes.T @ system.damping @ shapes
    )
