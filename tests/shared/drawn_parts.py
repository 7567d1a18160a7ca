"""What cars are drawn from: features that act or not, shapes of roads, numbers that vary."""

from __future__ import annotations

from random import Random
from typing import Any

from phaseplane.suspension.variables import MODELS

# What there is of a car besides its defaults; which of these act is its shape.
FEATURES: list[dict[str, float]] = [
    {},
    {"damper.rebound_limit": 300.0, "damper.bump_limit": 250.0, "damper.limit_slope": 100.0},
    {"bump_stop.stiffness": 2e5, "bump_stop.gap": 0.02, "rebound_stop.stiffness": 3e5,
     "rebound_stop.gap": 0.03},
    {"friction": 80.0, "damper.saturation_force": 900.0},
    {"spring.preload": 2500.0},
]  # fmt: skip
SHAPES = ("flat", "bump", "obstacle", "sine", "sweep", "step", "ramp", "plank", "pothole")
VARIED = (
    "sprung_mass", "unsprung_mass", "spring.rate", "damper.rebound_rate", "damper.bump_rate",
    "tyre.stiffness", "tyre.damping", "speed", "road.height", "road.length", "road.start", "mass",
    "damper.rate", "yield_force", "hardening", "initial.displacement", "cg_to_front",
    "pitch_radius_of_gyration",
)  # fmt: skip
START = {"road.start": 0.01, "hardening": 200.0, "initial.displacement": 1e-4}


def starting_numbers(model: str, numbers: dict[str, float]) -> dict[str, float]:
    """The numbers of features and all that vary, at their defaults, by the names of a model."""
    known = {v.name: v for v in MODELS[model] if v.causality == "parameter"}
    axles = ("front.", "rear.") if "front.spring.rate" in known else ("",)
    starts = {axle + name: x for axle in axles for name, x in numbers.items()}
    for name in VARIED:
        for full in (name, *(axle + name for axle in axles)):
            if full in known:
                starts[full] = START.get(name, known[full].start)
    return {name: x for name, x in starts.items() if name in known}


def drawn_parameters(
    dice: Random, model: str, spread: float, curved: bool = True
) -> dict[str, Any]:
    """Any road, any features, and every number up to 10^spread times its default or a part of it.

    Parameters
    ----------
    dice : what decides
    model : key of `MODELS`
    spread : decades
    curved : whether there may be forces that are not straight in each branch
    """
    known = {v.name: v for v in MODELS[model] if v.causality == "parameter"}
    fixed: dict[str, Any] = {"lift_off": dice.random() < 0.7} if "lift_off" in known else {}
    if "road.shape" in known:
        shapes = [s for s in SHAPES if curved or s != "sweep"]
        fixed |= {"road.shape": dice.choice(shapes), "road.duration": 0.3, "road.ramp_length": 0.01}
    numbers: dict[str, float] = {"spring.cubic": 1e5} if curved and dice.random() < 0.5 else {}
    for feature in dice.sample(FEATURES, dice.randint(0, len(FEATURES))):
        if curved or "friction" not in feature:
            numbers |= feature
    starts = starting_numbers(model, numbers)
    return fixed | {name: x * 10.0 ** dice.uniform(-spread, spread) for name, x in starts.items()}
