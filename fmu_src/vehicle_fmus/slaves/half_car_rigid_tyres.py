"""The FMU script of `HalfCarRigidTyres`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class HalfCarRigidTyres(VehicleSlave):
    """Body on two suspensions that stand directly on the road (AP57 eq. 33)."""

    model = "HalfCarRigidTyres"
    description = "Half car on rigid tyres: two axles coupled by the inertia of the body"
