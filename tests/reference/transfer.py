"""The transfer function from a road to the coordinates of a linearised system."""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike, NDArray
from phaseplane.scenarios.measures.linearised import linearised
from phaseplane.suspension.systems import System


def transfer(system: System, frequencies: ArrayLike) -> NDArray[np.complex128]:
    """Displacements of the coordinates for a unit sine under all linear elements on a road.

    (K + i w B - w^2 M) q = sum b (k + i w c)

    A spring k in series with a damper c adds b i w k / (k/c + i w) b' on the left. The frequencies are in
    Hz; the result has the shape (frequencies, coordinates).
    """
    rest = linearised(system)
    w = 2.0 * pi * np.asarray(frequencies)[:, None, None]
    dynamic = rest.stiffness + 1j * w * rest.damping - w**2 * rest.mass
    for b, k, rate in rest.series:
        dynamic = dynamic + 1j * w * k / (rate + 1j * w) * np.outer(b, b)
    excitation = sum(
        (e.spring.tangent(0.0) + 1j * w[..., 0] * e.damper.tangent(0.0)) * np.array(e.direction)
        for e in system.elements
        if e.road
    )
    return np.linalg.solve(dynamic, excitation[..., None])[..., 0]
