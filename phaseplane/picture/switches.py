"""Which wheels are off the road, and whether the spring yields or dry friction sticks, step by step."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.two_planes import STUCK
from phaseplane.constructions.yielding import FLOWS

from .paper import read_over


def switches_of(drawing: Drawing) -> dict[str, npt.NDArray[np.bool_]]:
    """Return the states at all points of a construction by the names of the columns of a run.

    Those that never occur are left out.
    """
    schemes = [frame.scheme for frame in drawing.instants]
    forces = [n for n in drawing.frames[0].readings if n.endswith("contact_force")]
    _, read = read_over(drawing, forces)
    found = {
        **{n.replace("contact_force", "airborne"): read[:, k] == 0.0 for k, n in enumerate(forces)},
        "yielding": np.array([scheme in FLOWS for scheme in schemes]),
        "sticking": np.array([scheme.endswith(STUCK) for scheme in schemes]),
    }
    return {name: states for name, states in found.items() if states.any()}
