"""The FMU script of `Elastoplastic`."""

from __future__ import annotations

from phaseplane.vehicle_fmus.slaves.vehicle_slave import VehicleSlave


class Elastoplastic(VehicleSlave):
    """Oscillator whose spring yields (H83 example 40)."""

    model = "Elastoplastic"
    description = "Elastoplastic oscillator: a mass on a spring that yields, and a damper"
