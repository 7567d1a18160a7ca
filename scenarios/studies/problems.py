"""The test problems: every kind of system of this package, smooth, non-smooth and stiff."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import inf, pi, sqrt, tanh
from pathlib import Path
from typing import Any, Literal

import numpy as np
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.equilibrium import start_state
from phaseplane.suspension.models import SYSTEMS, build
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import Value, checked_parameters

from ..errors import InputError, shown
from ..scene.loading import load_scene
from ..scene.names import SCENE_FILES, case_names
from .equations import Vector

Kind = Literal["non-smooth", "smooth", "stiff"]
_KGF = 9.80665
_MOST_INTERVALS = 2000  # of a scene; values between them are as accurate


@dataclass(frozen=True)
class Problem:
    """A system, its initial state and its output times.

    Parameters
    ----------
    name, title : one word, and one line
    kind : `stiff` if stability, not accuracy, would limit the steps of an explicit method
    system : the system
    duration : s
    intervals : number of equal intervals between output times
    displacements, velocities : initial values, m and m/s; empty for rest
    model, parameters : the FMU of the same system and its parameters, if there is one
    file : a native FMU of that model; otherwise one that runs Python is packed
    """

    name: str
    title: str
    kind: Kind
    system: System
    duration: float
    intervals: int
    displacements: tuple[float, ...] = ()
    velocities: tuple[float, ...] = ()
    model: str = ""
    parameters: Mapping[str, Value] = field(default_factory=dict)
    file: Path | None = None

    @cached_property
    def times(self) -> Vector:
        """The output times, s."""
        return np.linspace(0.0, self.duration, self.intervals + 1)

    @property
    def start(self) -> Vector:
        """The initial displacements and velocities."""
        rest = (0.0,) * len(self.system.mass)
        return np.array([*(self.displacements or rest), *(self.velocities or rest)])

    def integrator(self, **options: Any) -> Integrator:
        """Return an integrator of the system at the initial state, with given options."""
        integrator = Integrator(self.system, **options)
        integrator.set_state(*(half.tolist() for half in np.split(self.start, 2)))
        return integrator


def of_model(
    name: str,
    title: str,
    kind: Kind,
    model: str,
    parameters: Mapping[str, Value],
    duration: float = 2.0,
    intervals: int = 400,
) -> Problem:
    """Return a problem that an FMU can run too, from the FMU's initial state."""
    system = build(model, parameters)
    start = start_state(system, checked_parameters(model, parameters), 0.0)
    return Problem(
        name, title, kind, system, duration, intervals, *start, model=model, parameters=parameters
    )


def _blow_off() -> str:
    """Return the damper of AP57 section 8, its slopes a fifth beyond +0.30 and -0.60 m/s, as a table."""
    rebound, bump = 200.0 * _KGF, 50.0 * _KGF
    points = (
        (-1.6, -0.8 * bump), (-0.6, -0.6 * bump), (0.0, 0.0), (0.3, 0.3 * rebound), (1.3, 0.5 * rebound),
    )  # fmt: skip
    return ", ".join(f"{rate!r}:{force!r}" for rate, force in points)


def car_axis() -> Problem:
    """Return an axle on two stiff springs, one over a bumpy road, after `caraxis` of the Bari test set.

    It has the springs of 1/epsilon^2 and the small rotation (linearised) of the original, but strong
    dampers: the axle follows the road and its oscillation dies out within milliseconds.
    """
    epsilon = 1e-2
    rate, half_length = 10.0 / epsilon**2, 0.5
    elements = tuple(
        Element(
            f"{side}_spring",
            (1.0, lever),
            spring=characteristics.cubic(rate, 100.0 * rate),
            damper=characteristics.linear(2.0 * sqrt(10.0 * rate) * 20.0),
            road=f"{side}_road",
        )
        for side, lever in (("left", -half_length), ("right", half_length))
    )
    system = System(
        coordinates=("heave", "pitch"),
        mass=((10.0, 0.0), (0.0, 10.0 / 12.0)),
        elements=elements,
        signals={
            "left_road": roads.constant(),
            "right_road": roads.sine(0.1, 2.0 * pi, 10.0),
        },
        scales=(0.05, 0.05),
    )
    return Problem(
        "car_axis", "axle on strongly damped springs, bumpy road", "stiff", system, 3.0, 300
    )


_AXLE: dict[str, Value] = {
    "damper.rebound_limit": 588.399, "damper.bump_limit": 294.1995, "damper.limit_slope": 150.0,
    "bump_stop.gap": 0.03, "bump_stop.stiffness": 2e5,
    "rebound_stop.gap": 0.04, "rebound_stop.stiffness": 2e5,
}  # fmt: skip
# A linear quarter car that stays on the road, which makes a smooth problem.
_SMOOTH: dict[str, Value] = {
    "lift_off": False, "damper.rebound_rate": 1000.0, "damper.bump_rate": 1000.0,
    "road.shape": "sine",
}  # fmt: skip


_LIFTING: dict[str, Value] = {"spring.cubic": 1e6, "damper.saturation_force": 800.0}


def _measured() -> dict[str, Value]:
    """Return the spring and damper of `_LIFTING` for one axle as smoothly joined tables of ten points."""
    spring = (-0.12, -0.085, -0.055, -0.025, 0.0, 0.02, 0.045, 0.07, 0.1, 0.14)
    damper = (-1.6, -0.9, -0.45, -0.15, 0.0, 0.08, 0.2, 0.4, 0.8, 1.5)
    bump, rebound = 50.0 * _KGF, 200.0 * _KGF
    forces = {
        "spring": [(y, 1.5e4 * y + 1e6 * y**3) for y in spring],
        "damper": [(v, 800.0 * tanh((bump if v < 0.0 else rebound) * v / 800.0)) for v in damper],
    }
    found: dict[str, Value] = {}
    for part, points in forces.items():
        found[f"{part}.table"] = ", ".join(f"{x:g}:{force:.4g}" for x, force in points)
        found[f"{part}.interpolation"] = "monotone"
    return found


def _of_scene(name: str) -> Problem:
    """Return the problem that a scene runs."""
    scene = load_scene(name)
    if not scene.fmu.is_ours:
        raise InputError(
            f"{name}: fmu = {str(scene.fmu.path or scene.fmu.model)!r}: only models of this "
            f"package can be compared: {', '.join(SYSTEMS)}"
        )
    scene.refuse_controller("problems are")
    intervals = min(max(1, round(scene.duration / scene.show.output_interval)), _MOST_INTERVALS)
    problem = of_model(
        scene.name,
        scene.title or scene.name,
        "non-smooth",
        scene.fmu.model,
        scene.all_parameters if scene.fmu.path else scene.start_values,
        scene.duration,
        intervals,
    )
    problem = replace(problem, file=scene.fmu.path)
    smooth = not any(
        element.limit < inf
        or element.friction
        or element.yield_force < inf
        or element.spring.corners
        or element.damper.corners
        or element.modulation.corners
        for element in problem.system.elements
    )
    return replace(problem, kind="smooth") if smooth else problem


def _of_models(
    **declared: tuple[str, Kind, str, Mapping[str, Value]],
) -> dict[str, Callable[[], Problem]]:
    """Return problems of models by name, from title, kind, model and parameters."""
    return {name: partial(of_model, name, *one) for name, one in declared.items()}


PROBLEMS: dict[str, Callable[[], Problem]] = {
    **_of_models(
        lift_off=(
            "quarter car of AP57 section 8, blow-off damper, lift-off", "non-smooth",
            "QuarterCar", {"damper.table": _blow_off()},
        ),
        half_car=(
            "half car of four degrees of freedom, blow-off dampers, end stops, lift-off",
            "non-smooth", "HalfCar",
            {
                **{f"{end}.{k}": v for end in ("front", "rear") for k, v in _AXLE.items()},
                "road.height": 0.07, "pitch_radius_of_gyration": 1.1,
            },
        ),
        curved=(
            "quarter car on a cubic spring and a damper that saturates, lift-off", "non-smooth",
            "QuarterCar", _LIFTING,
        ),
        curved_half_car=(
            "half car with smooth tables of ten points for springs and dampers, lift-off",
            "non-smooth", "HalfCar",
            {
                **{f"{end}.{k}": v for end in ("front", "rear") for k, v in _measured().items()},
                "road.height": 0.07, "pitch_radius_of_gyration": 1.1,
            },
        ),
        rigid_tyres=(
            "half car on rigid tyres, coupled by its inertia, over an obstacle", "non-smooth",
            "HalfCarRigidTyres",
            {
                "road.shape": "obstacle", "road.length": 3.0, "speed": 15.0,
                "pitch_radius_of_gyration": 1.1,
            },
        ),
        end_stops=(
            "one degree of freedom between end stops, on a sine road", "non-smooth", "OneDof",
            {
                "road.shape": "sine", "road.height": 0.04, "road.length": 12.0, "speed": 15.0,
                "damper.bump_rate": 300.0, "damper.rebound_rate": 600.0,
                "bump_stop.gap": 0.03, "bump_stop.stiffness": 1e5,
                "rebound_stop.gap": 0.03, "rebound_stop.stiffness": 1e5,
            },
        ),
        yielding=("elastoplastic frame of H83 example 40", "non-smooth", "Elastoplastic", {}),
        friction=(
            "quarter car on leaf springs with dry friction that sticks, lift-off", "non-smooth",
            "QuarterCar",
            {
                "spring.rate": 20e3, "damper.rebound_rate": 300.0, "damper.bump_rate": 300.0,
                "friction": 400.0, "road.length": 1.5, "speed": 15.0,
            },
        ),
    ),
    "full_car": partial(_of_scene, "full_car"),
    **_of_models(
        linear=(
            "linear quarter car on a sine road", "smooth", "QuarterCar",
            {**_SMOOTH, "road.height": 0.02, "road.length": 5.0},
        ),
        hardening=(
            "quarter car on a cubic spring and a sine road", "smooth", "QuarterCar",
            {**_SMOOTH, "spring.cubic": 5e6, "road.height": 0.03, "road.length": 8.0},
        ),
        saturating=(
            "quarter car on a damper that saturates, sine road", "smooth", "QuarterCar",
            {
                **_SMOOTH, "damper.saturation_force": 400.0, "damper.rebound_rate": 2000.0,
                "damper.bump_rate": 2000.0, "road.height": 0.03, "road.length": 8.0,
            },
        ),
        hard_stop=(
            "quarter car against end stops of 10 MN/m", "stiff", "QuarterCar",
            {
                "bump_stop.gap": 0.02, "bump_stop.stiffness": 1e7,
                "rebound_stop.gap": 0.03, "rebound_stop.stiffness": 1e7,
            },
        ),
    ),
    "car_axis": car_axis,
}  # fmt: skip


def find_problem(name: str) -> Problem:
    """Return the problem with a given name, or the problem that a scene runs.

    Raises
    ------
    InputError : if there is no such problem or scene, or the scene's FMU is not of this package.
    """
    if name in PROBLEMS:
        return PROBLEMS[name]()
    if not name.endswith(SCENE_FILES) and "/" not in name and name not in case_names():
        raise InputError(
            f"no problem or scene {shown(name)}; problems are {', '.join(PROBLEMS)}; 'phaseplane "
            f"list' shows the scenes{nearest(name, (*PROBLEMS, *case_names()))}"
        )
    return _of_scene(name)
