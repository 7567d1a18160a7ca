"""The FMU script of `HalfCar`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class HalfCar(VehicleSlave):
    """Body and two wheels on tyres, each of which may leave the road (AP57 eq. 1)."""

    model = "HalfCar"
    description = (
        "Half car: body, two axles with nonlinear suspensions, tyres that can leave the road"
    )
