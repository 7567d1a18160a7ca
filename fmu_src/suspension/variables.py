"""The public variables of every model, declared once.

FMU model descriptions, parameter checks and printed tables are all made from them. The defaults of
half cars are two quarter cars of AP57 section 8, with the radius of gyration that decouples them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache

from .declared import (
    ACTUATOR_FORCE,
    BODY_FORCE_TABLE,
    CONTACT_RULE,
    GRAVITY,
    LIFT_OFF,
    METHODS,
    PAYLOAD,
    ROAD_INPUTS,
    ROAD_SHAPES,
    SOLVER_PARAMETERS,
    SUSPENSION,
    WHEEL,
    body_force,
    initial,
    road,
)
from .outputs import (
    CONTACT,
    FRAME,
    GROUND,
    PITCH,
    SOLVER_OUTPUTS,
    SUSPENSION_FORCES,
    TYRE_DEFLECTION,
    energies,
    motion,
    output,
    suspension_deflection,
)
from .units import KGF, nearest
from .variable import ParameterError, Value, Variable, parameter, refuse_unknown

__all__ = [
    "METHODS",
    "MODELS",
    "ROAD_SHAPES",
    "SOLVER_OUTPUTS",
    "SOLVER_PARAMETERS",
    "SOURCES",
    "ParameterError",
    "Value",
    "Variable",
    "checked_parameters",
    "outputs",
    "refuse_unknown",
    "variables",
]

_ON_WHEEL = (  # outputs of a suspension that stands on a wheel
    *motion("body", "the body"),
    *motion("wheel", "the wheel"),
    *suspension_deflection("body minus wheel displacement"),
    *TYRE_DEFLECTION,
    *GROUND,
    *SUSPENSION_FORCES,
    *CONTACT,
)
_ON_ROAD = (  # outputs of a suspension that stands directly on the road
    *motion("body", "the body"),
    *suspension_deflection("body displacement minus ground elevation"),
    *GROUND,
    *SUSPENSION_FORCES,
)
_SPRUNG_MASS = parameter("sprung_mass", 30 * KGF, "body mass on one wheel", "kg", positive=True)
_ROAD = road("road under the wheel; 'input' uses the inputs road_elevation and road_velocity")

_ONE_DOF = (
    _SPRUNG_MASS,
    PAYLOAD,
    *SUSPENSION,
    *_ROAD,
    *initial({"body": "the body"}),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *ROAD_INPUTS,
    body_force(),
    ACTUATOR_FORCE,
    *_ON_ROAD,
    *energies("road", "body_force"),
    *SOLVER_OUTPUTS,
)

_QUARTER_CAR = (
    _SPRUNG_MASS,
    PAYLOAD,
    *WHEEL,
    *SUSPENSION,
    LIFT_OFF,
    CONTACT_RULE,
    GRAVITY,
    *_ROAD,
    *initial({"body": "the body", "wheel": "the wheel"}),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *ROAD_INPUTS,
    body_force(),
    ACTUATOR_FORCE,
    *_ON_WHEEL,
    *energies("road", "body_force"),
    *SOLVER_OUTPUTS,
)


def _both_axles(declared: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return the variables of one axle, for the front and for the rear axle."""
    declared = tuple(declared)
    return tuple(
        replace(
            v,
            name=f"{axle}{'.' if v.causality == 'parameter' else '_'}{v.name}",
            description=f"{axle} axle: {v.description}",
            axle=f"{axle}_" * (v.causality == "output"),
        )
        for axle in ("front", "rear")
        for v in declared
    )


_RIGID_BODY = (
    parameter("sprung_mass", 60 * KGF, "mass of the whole body", "kg", positive=True),
    parameter("pitch_radius_of_gyration", 1.25, "radius of gyration of the body in pitch; the axles "
               "are decoupled if its square equals cg_to_front times cg_to_rear", "m",
               positive=True),
    parameter("cg_to_front", 1.25, "distance of the front axle from the body's centre of gravity",
               "m", positive=True),
    parameter("cg_to_rear", 1.25, "distance of the rear axle from the body's centre of gravity; "
               "the wheelbase is cg_to_front plus cg_to_rear", "m", positive=True),
)  # fmt: skip

_BODY_OVER_AXLES = {
    "front_body": "the body over the front axle",
    "rear_body": "the body over the rear axle",
}

_HALF_CAR_ROAD = road(
    "road under the front wheel; the rear wheel follows after wheelbase/speed; 'input' uses the "
    "inputs front_road_elevation, front_road_velocity and those of the rear",
    "the front wheel",
)

_RIGID_BODY_MOTION = (*motion("body", "the unloaded body's centre of gravity"), *PITCH)

_HALF_CAR_RIGID_TYRES = (
    *_RIGID_BODY,
    *_both_axles((PAYLOAD, *SUSPENSION)),
    *_HALF_CAR_ROAD,
    *initial(_BODY_OVER_AXLES),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *_both_axles(ROAD_INPUTS),
    body_force(" at its centre of gravity"),
    *_both_axles((ACTUATOR_FORCE,)),
    *_RIGID_BODY_MOTION,
    *_both_axles(_ON_ROAD),
    *energies("front_road", "rear_road", "body_force"),
    *SOLVER_OUTPUTS,
)

_HALF_CAR = (
    *_RIGID_BODY,
    *_both_axles((PAYLOAD, *WHEEL, *SUSPENSION)),
    LIFT_OFF,
    CONTACT_RULE,
    GRAVITY,
    *_HALF_CAR_ROAD,
    *initial(
        {**_BODY_OVER_AXLES, "front_wheel": "the front wheel", "rear_wheel": "the rear wheel"}
    ),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *_both_axles(ROAD_INPUTS),
    body_force(" at its centre of gravity"),
    *_both_axles((ACTUATOR_FORCE,)),
    *_RIGID_BODY_MOTION,
    *_both_axles(_ON_WHEEL),
    *energies("front_road", "rear_road", "body_force"),
    *SOLVER_OUTPUTS,
)

_ELASTOPLASTIC = (  # start values of H83 example 40
    parameter("mass", 100.0, "mass", "kg", positive=True),
    parameter("damper.rate", 200.0, "damping rate", "N.s/m", display="kN.s/m", minimum=0.0),
    parameter("spring.rate", 5000.0, "spring rate below the yield force", "N/m", display="N/mm",
              positive=True),
    parameter("yield_force", 6.0, "spring force at which yield begins, with no permanent set",
              "N", display="kN", positive=True),
    parameter("hardening", 0.0, "spring rate while it yields, below spring.rate; kinematic: the "
              "elastic range keeps its size", "N/m", display="N/mm", minimum=0.0),
    parameter("force.table", "0:0, 0.1:5, 0.2:8, 0.3:7, 0.4:5, 0.5:3, 0.6:2, 0.7:1, 0.8:0",
              "force on the mass as 'time:force, ...' in s and N, joined by straight lines; empty: "
              "none"),
    parameter("initial.displacement", 0.0, "displacement at the start", "m", display="mm"),
    parameter("initial.velocity", 0.0, "velocity at the start", "m/s"),
    parameter("initial.permanent_set", 0.0, "displacement at which the spring force is zero, at "
              "the start", "m", display="mm"),
    *SOLVER_PARAMETERS,
    Variable("force", "force on the mass, added to that of force.table", "input", 0.0, "N", "kN",
             nominal=10.0),
    *FRAME,
    *energies(),
    *SOLVER_OUTPUTS,
)  # fmt: skip

MODELS: dict[str, tuple[Variable, ...]] = {
    "OneDof": _ONE_DOF,
    "QuarterCar": _QUARTER_CAR,
    "HalfCarRigidTyres": _HALF_CAR_RIGID_TYRES,
    "HalfCar": _HALF_CAR,
    "Elastoplastic": _ELASTOPLASTIC,
}


def _road_source() -> tuple[Variable, ...]:
    """Return the variables of a road that models take as input: its shape, its motion at both axles."""
    shapes = tuple(shape for shape in ROAD_SHAPES if shape != "input")
    along = road("road under the front axle; the rear axle follows after wheelbase/speed",
                 "the front axle")  # fmt: skip
    return (
        *(replace(v, choices=shapes) if v.name == "road.shape" else v for v in along),
        parameter("wheelbase", 2.5, "distance between the axles", "m", minimum=0.0),
        *(
            replace(
                variable,
                name=f"{axle}_{quantity}",
                description=f"{axle} axle: {what}",
                reading=None,
            )
            for axle in ("front", "rear")
            for variable, quantity, what in zip(
                GROUND,
                ("elevation", "velocity"),
                ("elevation of the road, upwards positive", "its rate of change"),
                strict=True,
            )
        ),
        output("ok", "false once the run has failed; all other outputs are then NaN",
               start=True),
    )  # fmt: skip


SOURCES: dict[str, tuple[Variable, ...]] = {"Road": _road_source()}


def declare(model: str, declared: tuple[Variable, ...]) -> None:
    """Add the public variables of a model, or replace those of one that was added before."""
    MODELS[model] = declared
    for known in (outputs, _parameters, _defaults):
        known.cache_clear()


def variables(model: str) -> tuple[Variable, ...]:
    """Return the public variables of a model, or of a source that drives one.

    Raises
    ------
    ParameterError : no such model.
    """
    known = MODELS | SOURCES
    if model not in known:
        raise ParameterError(
            f"model {model!r} is unknown; models are {', '.join(known)}{nearest(model, known)}"
        )
    return known[model]


def checked_parameters(model: str, given: Mapping[str, object]) -> dict[str, Value]:
    """Return all parameters of a model: given ones checked and in SI, the others at their defaults.

    Raises
    ------
    ParameterError : unknown name, wrong type, unit or range.
    """
    declared = _parameters(model)
    refuse_unknown(given, declared, f"{model} has no parameter")
    checked = {name: declared[name].checked(value) for name, value in given.items()}
    return _defaults(model) | checked


@cache
def outputs(model: str) -> dict[str, Variable]:
    """Return the outputs of a model by name.

    Raises
    ------
    ParameterError : no such model.
    """
    return {v.name: v for v in variables(model) if v.causality == "output"}


@cache
def _parameters(model: str) -> dict[str, Variable]:
    return {v.name: v for v in variables(model) if v.causality == "parameter"}


@cache
def _defaults(model: str) -> dict[str, Value]:
    return {name: variable.start for name, variable in _parameters(model).items()}
