"""The FMU script of `QuarterCar`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class QuarterCar(VehicleSlave):
    """Body and wheel with elastic coupling (AP57 eqs. 12 to 14, in flight 29)."""

    model = "QuarterCar"
    description = "Quarter car: body and wheel, nonlinear suspension, tyre that can leave the road"
