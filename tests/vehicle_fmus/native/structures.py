"""The structures that native FMUs are tested with: a model, its settings, the file of a system."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from phaseplane.suspension.own_systems import file as system_file

SANITIZED = "PHASEPLANE_TEST_SANITIZED"
"""Set in the environment where native FMUs under test are to be compiled with sanitizers."""
SANITIZERS = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@dataclass(frozen=True)
class Structure:
    """A model with settings that are chosen when it is packed."""

    model: str
    settings: dict[str, Any] = field(default_factory=dict)
    text: str = ""

    @property
    def loaded(self) -> str:
        """The name of the model, which is registered if it is a system of one's own."""
        if self.text:
            system_file.load(self.text, checked=False)
        return self.model


def case(name: str) -> str:
    """The file of a system in the package."""
    return files("phaseplane.scenarios").joinpath("cases", f"{name}.toml").read_text("utf-8")


# wheels, elements and loads whose numbers are expressions; friction, a power law, a spring in series
TRAILER = """
[system]
name = "Trailer"

[system.parameters]
mass = "600 kg"
inertia = "300 kg.m2"
half_track = "0.8 m"
rate = "20 N/mm"
power = 2500

[system.coordinates]
bounce = { mass = "mass" }
roll = { mass = "inertia", angle = true }

[system.couplings]
bounce.roll = "0.05 * mass * half_track"

[system.wheels.left]
axle = "only"
body = { bounce = 1, roll = "half_track" }
load = "mass / 2"

[system.wheels.right]
axle = "only"
body = { bounce = 1, roll = "-half_track" }
load = "mass / 2"
delay = "0.1 * half_track / speed"

[system.elements.bar]
direction = { bounce = "-0.1 + 2e-2", roll = "2 * half_track^2" }
spring = { rate = "rate / 4" }
damper = { power = "power", exponent = 1.7 }
friction = 30

[system.elements.mount]
direction = { bounce = 1, roll = "half_track" }
damper = { rate = "power / 2", series = "5 * rate" }

[system.loads.wind]
direction = { roll = 1 }
sine = { amplitude = "mass / 10", frequency = "1.5" }
"""

STRUCTURES: dict[str, Structure] = {
    "OneDof": Structure("OneDof", {"road.shape": "input"}),
    "QuarterCar": Structure("QuarterCar"),
    "without the energy ledger": Structure("QuarterCar", {"solver.energy": False}),
    "with stops, friction and a sampled road": Structure(
        "QuarterCar",
        {"road.shape": "input", "bump_stop.stiffness": 2e5, "bump_stop.gap": 0.03, "friction": 40.0,
         "tyre.damping_table": "-1:-900, 0:0, 1:400"},
    ),
    "curved, on a random road": Structure(
        "QuarterCar",
        {"road.shape": "random", "road.profile_length": 30.0, "spring.cubic": 1e6,
         "damper.saturation_force": 800.0},
    ),
    "on a road high above zero": Structure(
        "HalfCar", {"road.shape": "table", "road.table": "0:100, 5:100.2, 9:100, 30:102"}
    ),
    "HalfCarRigidTyres": Structure("HalfCarRigidTyres", {"road.shape": "sine"}),
    "HalfCar": Structure("HalfCar"),
    "Elastoplastic": Structure("Elastoplastic", {"hardening": 500.0}),
    "Road": Structure("Road"),
    "planks": Structure("Road", {"road.shape": "plank", "road.ramp_length": 0.1}),
    "full car": Structure("FullCar", text=case("full_car")),
    "double pendulum": Structure("DoublePendulum", text=case("double_pendulum")),
    "trailer": Structure("Trailer", text=TRAILER),
}  # fmt: skip
