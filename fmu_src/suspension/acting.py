"""Conditions under which a parameter has an effect, declared once for all models.

A parameter that is not listed always has one, and a condition on parameters that a model does not have
holds. The conditions of an axle's parameter refer to the parameters of the same axle.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .declared import ROAD_SHAPES
from .variable import Value, is_table


class Given(NamedTuple):
    """At least one of these must be given (not empty, not 0) and have an effect."""

    names: tuple[str, ...]


class Without(NamedTuple):
    """None of these may be given and have an effect: each replaces the parameter."""

    names: tuple[str, ...]


class Among(NamedTuple):
    """Another parameter must have one of these values."""

    name: str
    values: tuple[Value, ...]


Condition = Given | Without | Among


def _shapes(*names: str) -> Among:
    return Among("road.shape", names)


_HUMPS = ("bump", "obstacle", "plank", "pothole", "ramp", "sine")
_WITH_EDGES = ("plank", "pothole")
_POINTS = ("table", "spline")
_MOVING = tuple(shape for shape in ROAD_SHAPES if shape not in ("input", "flat"))
_NO_TABLE_OF_DAMPER = Without(("damper.table",))
_OF_SOME_DAMPER = (Given(("damper.table", "damper.rebound_rate", "damper.bump_rate")),)
_BLOW_OFF = (_NO_TABLE_OF_DAMPER, Without(("damper.saturation_force",)))

CONDITIONS: Mapping[str, tuple[Condition, ...]] = {
    "spring.rate": (Without(("spring.table",)),),
    "spring.cubic": (Without(("spring.table",)),),
    "spring.interpolation": (Given(("spring.table",)),),
    # a linear spring has the same rate at any preload
    "spring.preload": (Given(("spring.table", "spring.cubic")),),
    "damper.rebound_rate": (_NO_TABLE_OF_DAMPER,),
    "damper.bump_rate": (_NO_TABLE_OF_DAMPER,),
    "damper.rebound_limit": (*_BLOW_OFF, Given(("damper.rebound_rate",))),
    "damper.bump_limit": (*_BLOW_OFF, Given(("damper.bump_rate",))),
    "damper.limit_slope": (*_BLOW_OFF, Given(("damper.rebound_limit", "damper.bump_limit"))),
    "damper.saturation_force": (_NO_TABLE_OF_DAMPER,),
    "damper.interpolation": (Given(("damper.table",)),),
    "damper.deflection_table": _OF_SOME_DAMPER,
    "damper.scale": _OF_SOME_DAMPER,
    "bump_stop.stiffness": (Without(("bump_stop.table",)),),
    "bump_stop.gap": (Given(("bump_stop.stiffness", "bump_stop.table")),),
    "rebound_stop.stiffness": (Without(("rebound_stop.table",)),),
    "rebound_stop.gap": (Given(("rebound_stop.stiffness", "rebound_stop.table")),),
    "tyre.stiffness": (Without(("tyre.table",)),),
    "tyre.damping": (Without(("tyre.damping_table",)),),
    "tyre.interpolation": (Given(("tyre.table",)),),
    "lift_off": (Given(("gravity",)),),
    "contact": (Given(("lift_off",)),),
    "road.height": (_shapes(*_HUMPS, "step", "sweep"),),
    "road.length": (_shapes(*_HUMPS),),
    "road.ramp_length": (_shapes(*_WITH_EDGES),),
    "road.start": (_shapes(*_MOVING),),
    "speed": (_shapes(*_MOVING),),
    "wheelbase": (_shapes(*_MOVING),),
    "road.first_frequency": (_shapes("sweep"),),
    "road.last_frequency": (_shapes("sweep"),),
    "road.duration": (_shapes("sweep"),),
    "road.class": (_shapes("random"), Without(("road.roughness",))),
    "road.roughness": (_shapes("random"),),
    "road.seed": (_shapes("random"),),
    "road.profile_length": (_shapes("random"),),
    "road.table": (_shapes(*_POINTS),),
    "road.sequence": (_shapes("sequence"),),
    "solver.tolerance": (Without(("solver.step",)),),
    "solver.beyond_stable": (
        Given(("solver.step",)),
        Among("solver.method", ("extrapolated", "equilibrium", "mean", "tangent")),  # have a limit
    ),
    "solver.theta": (Among("solver.method", ("wilson",)),),
}


class Idle(NamedTuple):
    """A parameter that has no effect.

    Parameters
    ----------
    name : of the parameter
    reason : as a phrase
    causes : names of the parameters that are the reason
    """

    name: str
    reason: str
    causes: frozenset[str]

    def __str__(self) -> str:
        return f"{self.name} has no effect on the motion: {self.reason}"


def idle(name: str, parameters: Mapping[str, Value]) -> Idle | None:
    """Return why a parameter has no effect, whatever its value; None if it may have one.

    Parameters
    ----------
    name : of the parameter
    parameters : all parameters of the model, checked
    """
    axle, conditions = _conditions(name, parameters)
    for condition in conditions:
        causes = _broken(condition, axle, parameters)
        if causes is not None:
            reason = " and ".join(_said(cause, parameters[cause]) for cause in causes)
            return Idle(name, reason, frozenset(causes))
    return None


def decided_by(name: str, parameters: Mapping[str, Value]) -> frozenset[str]:
    """Return the parameters that determine whether a parameter has an effect.

    Parameters
    ----------
    name : of the parameter
    parameters : all parameters of the model
    """
    axle, conditions = _conditions(name, parameters)
    others = {_full(other, axle, parameters) for c in conditions for other in _names_in(c)}
    known = others & parameters.keys()
    return frozenset(known).union(*(decided_by(other, parameters) for other in known))


def _conditions(name: str, parameters: Mapping[str, Value]) -> tuple[str, tuple[Condition, ...]]:
    """Return the axle of a parameter, as a prefix, and its conditions."""
    first = name.partition(".")[0]
    axle = f"{first}." if f"{first}.spring.table" in parameters else ""
    return axle, CONDITIONS.get(name.removeprefix(axle), ())


def _names_in(condition: Condition) -> tuple[str, ...]:
    match condition:
        case Among(name):
            return (name,)
        case Given(names) | Without(names):
            return names


def _full(name: str, axle: str, parameters: Mapping[str, Value]) -> str:
    """Return the name with the prefix of its axle, if it belongs to one."""
    return f"{axle}{name}" if f"{axle}{name}" in parameters else name


def _broken(
    condition: Condition, axle: str, parameters: Mapping[str, Value]
) -> tuple[str, ...] | None:
    """Return the parameters that violate a condition, or None if it holds."""

    def acts(name: str) -> bool:
        return bool(parameters.get(name)) and idle(name, parameters) is None

    names = [_full(name, axle, parameters) for name in _names_in(condition)]
    match condition:
        case Given():
            known = tuple(name for name in names if name in parameters)
            return None if any(map(acts, known)) else known or None
        case Without():
            return tuple(filter(acts, names)) or None
        case Among(values=values):
            return None if parameters.get(names[0], values[0]) in values else (names[0],)


def _said(name: str, value: Value) -> str:
    """Return the value of a parameter as a phrase."""
    if is_table(name) or name.endswith("sequence"):
        return f"{name} is {'given' if value else 'not given'}"
    if isinstance(value, bool):
        return f"{name} is {str(value).lower()}"
    return f"{name} is {value if isinstance(value, str) else format(value, 'g')}"
