"""One car with every kind of element in it, against DOP853 restarted at every switch (see `truth`)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import truth
from phaseplane.suspension.characteristics import linear
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from stepped import read_at

END = 1.2
MOUNT, MOUNT_DAMPING, FRAME = 60e3, 150.0, 40.0
DECLARED = {
    "sprung_mass": 250.0, "unsprung_mass": 30.0, "spring.rate": 18e3, "spring.cubic": 5e5,
    "damper.rebound_rate": 2500.0, "damper.bump_rate": 900.0, "damper.saturation_force": 900.0,
    "damper.deflection_table": "-0.03:2, 0:1", "bump_stop.gap": 0.03, "bump_stop.stiffness": 3e5,
    "friction": 120.0, "tyre.table": "-0.1:-18800, -0.015:-1800, 0.1:12000", "tyre.damping": 400.0,
    "road.height": 0.05, "speed": 15.0,
}  # fmt: skip
LIGHT = {
    "sprung_mass": 150.0,
    "unsprung_mass": 20.0,
    "damper.saturation_force": 400.0,
    "speed": 22.0,
}
DAMPING_OF_TYRE = "-1:-900, -0.1:-250, 0:0, 0.1:150, 1:400"
CARS: dict[str, tuple[dict[str, Any], float]] = {  # parameters, and the force at which the mount yields
    "as declared": ({}, 700.0),
    "low and stiff": ({"bump_stop.gap": 0.015, "bump_stop.stiffness": 8e5, "road.height": 0.03,
                       "friction": 300.0, "speed": 8.0}, 700.0),
    "light and soft": (LIGHT, 400.0),
    "contact by force": ({**LIGHT, "contact": "force"}, 400.0),
    "a tyre damped by a table": ({**LIGHT, "tyre.damping_table": DAMPING_OF_TYRE}, 400.0),
}  # fmt: skip


def on_a_frame(car: System, yields: float) -> System:
    """The car with a frame between body and suspension, on a mount that yields: body, frame, wheel."""
    weight = 9.80665 * FRAME
    elements = (
        Element("mount", (1.0, -1.0, 0.0), linear(MOUNT), linear(MOUNT_DAMPING),
                yield_force=yields, hardening=6e3),
        *(replace(e, direction=(0.0, *e.direction),
                  limit=e.limit + weight * (e.name == "tyre")) for e in car.elements),
    )  # fmt: skip
    (body, _), (_, wheel) = car.mass
    return System(
        ("body", "frame", "wheel"),
        ((body, 0.0, 0.0), (0.0, FRAME, 0.0), (0.0, 0.0, wheel)),
        elements,
        car.signals,
        scales=3 * (0.05,),
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", CARS)
def test_every_kind_at_once(name: str) -> None:
    given, yields = CARS[name]
    instants = np.linspace(0.01, END, 120)
    system = on_a_frame(build("QuarterCar", DECLARED | given), yields)
    wanted = truth.solve(system, np.zeros(6), np.array([0.0, *instants]))
    peak = np.abs(wanted.displacements).max()
    stretch, rate = (wanted_of[1:, 0] - wanted_of[1:, 1]
                     for wanted_of in (wanted.displacements, wanted.velocities))  # fmt: skip
    sets = stretch - (wanted.forces[1:, 0] - MOUNT_DAMPING * rate) / MOUNT
    assert abs(sets[-1]) > 1e-3  # it has yielded
    for tolerance in (1e-5, 1e-7, 1e-8, 1e-10):
        integrator = Integrator(system, tolerance=tolerance)
        for t, row, permanent in zip(instants, wanted.displacements[1:], sets, strict=True):
            read_at(integrator, t)
            integrator.sample_forces(t)
            assert np.abs(np.array(integrator.sample_q) - row).max() < tolerance * peak
            assert integrator.sample_set[0] == pytest.approx(permanent, abs=tolerance * peak)
        kinds = {KINDS[kind] for _, _, kind, _, _ in integrator.log}
        assert kinds >= {"spring", "damper", "modulation", "friction"}
        assert ("contact" in kinds) == (name != "low and stiff")
        _, _, lost, supplied = integrator.energies()
        turned_over = np.abs([*lost, *supplied]).sum()
        assert abs(integrator.energy_residual()) < 0.1 * tolerance * turned_over
