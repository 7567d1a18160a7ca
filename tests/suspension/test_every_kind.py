"""One car with every kind of element in it, against DOP853 restarted at every switch (see `truth`)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import truth
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.systems import Element, System, damper_family

GRAVITY = 9.80665
END = 1.2


@dataclass(frozen=True)
class Car:
    """Body and wheel; a spring, a family of dampers, stops, dry friction, a subframe that yields."""

    body: float = 250.0
    wheel: float = 30.0
    rate: float = 18e3
    cubic: float = 5e5
    rebound: float = 2500.0
    bump: float = 900.0
    most: float = 900.0  # the damper saturates here
    stiff_at: float = -0.03  # where the second, straight damper has its curve
    straight: float = 3000.0
    gap: float = 0.03
    stop: float = 3e5
    friction: float = 120.0
    mount: float = 60e3  # between body and frame
    mount_yields: float = 700.0
    mount_hardens: float = 6e3
    frame: float = 40.0
    tyre_soft: float = 120e3
    tyre_hard: float = 200e3  # beyond 15 mm of compression
    tyre_damping: float = 400.0
    height: float = 0.05
    contact: str = "gap"

    @property
    def load(self) -> float:
        return (self.body + self.frame + self.wheel) * GRAVITY

    def system(self, speed: float) -> System:
        """As data of the package: coordinates body, frame, wheel."""
        mount, strut = (1.0, -1.0, 0.0), (0.0, 1.0, -1.0)
        tyre = law.table(
            [
                (-0.1, -0.015 * self.tyre_soft - 0.085 * self.tyre_hard),
                (-0.015, -0.015 * self.tyre_soft),
                (0.1, 0.1 * self.tyre_soft),
            ]
        )
        curves = {
            self.stiff_at: law.linear(self.straight),
            0.0: law.saturating(self.rebound, self.most, self.bump),
        }
        masses = (self.body, self.frame, self.wheel)
        return System(
            coordinates=("body", "frame", "wheel"),
            mass=tuple(tuple(m * (i == j) for j in range(3)) for i, m in enumerate(masses)),
            elements=(
                Element("mount", mount, law.linear(self.mount), law.linear(150.0),
                        yield_force=self.mount_yields, hardening=self.mount_hardens),
                Element("spring", strut, law.cubic(self.rate, self.cubic)),
                *damper_family("damper", strut, curves),
                Element("bump_stop", strut, law.bump_stop(self.gap, self.stop)),
                Element("friction", strut, friction=self.friction),
                Element("tyre", (0.0, 0.0, 1.0), tyre, law.linear(self.tyre_damping), "road",
                        limit=self.load, contact=self.contact),
            ),
            signals={"road": roads.bump(self.height, 1.0, speed)},
            scales=3 * (self.height,),
        )  # fmt: skip


CARS = {
    "as declared": (Car(), 15.0),
    "low and stiff": (Car(gap=0.015, stop=8e5, height=0.04, friction=300.0), 8.0),
    "light and soft": (Car(body=150.0, wheel=20.0, mount_yields=400.0, most=400.0), 22.0),
    "contact by force": (
        Car(body=150.0, wheel=20.0, mount_yields=400.0, most=400.0, contact="force"),
        22.0,
    ),
}


@pytest.mark.parametrize("name", CARS)
def test_every_kind_at_once(name: str) -> None:
    car, speed = CARS[name]
    instants = np.linspace(0.01, END, 120)
    system = car.system(speed)
    wanted = truth.solve(system, np.zeros(6), np.array([0.0, *instants]))
    peak = np.abs(wanted.displacements).max()
    stretch, rate = (wanted_of[1:, 0] - wanted_of[1:, 1]
                     for wanted_of in (wanted.displacements, wanted.velocities))  # fmt: skip
    sets = stretch - (wanted.forces[1:, 0] - 150.0 * rate) / car.mount
    assert abs(sets[-1]) > 1e-3  # it has yielded
    for tolerance in (1e-5, 1e-7, 1e-8, 1e-10):
        integrator = Integrator(system, tolerance=tolerance)
        for t, row, permanent in zip(instants, wanted.displacements[1:], sets, strict=True):
            assert integrator.advance(t) == 0
            integrator.sample(t)
            integrator.sample_forces(t)
            assert np.abs(np.array(integrator.sample_q) - row).max() < tolerance * peak
            assert integrator.sample_set[0] == pytest.approx(permanent, abs=tolerance * peak)
        kinds = {KINDS[kind] for _, _, kind, _, _ in integrator.log}
        assert kinds >= {"spring", "damper", "modulation", "friction"}
        assert ("contact" in kinds) == (name != "low and stiff")
        assert abs(integrator.residual_end) < 30.0 * tolerance
