"""The FMU script of `Road`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class Road(VehicleSlave):
    """Road for vehicles that take their road as inputs (AP57 eqs. 9, 10 and others)."""

    model = "Road"
    description = "Road: elevation and velocity under the front and the rear axle of a vehicle"
