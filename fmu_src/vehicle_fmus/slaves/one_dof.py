"""The FMU script of `OneDof`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class OneDof(VehicleSlave):
    """Body on a suspension that stands directly on the road (AP57 eqs. 2, 3)."""

    model = "OneDof"
    description = "One degree of freedom: body on a nonlinear suspension that stands on the road"
