"""Graphical constructions in the phase plane, step by step, as plain geometry (AP57).

A construction (`OneDofPlane`, `QuarterCarPlanes`, ...) says which points belong to a state; a step
rule (`RULES`) goes from there to the next state; `march` and `frames` string the steps together, and
`overlay` lays the same geometry over a motion that is known already.
"""

from __future__ import annotations

from phaseplane.constructions.construction import Construction, Window
from phaseplane.constructions.equation import EquationPlane
from phaseplane.constructions.four_planes import AxleData, HalfCarPlanes
from phaseplane.constructions.inertial import HalfCarRigidTyresPlanes
from phaseplane.constructions.laws import Strut
from phaseplane.constructions.marching import StepError, frames, march
from phaseplane.constructions.one_plane import OneDofPlane
from phaseplane.constructions.overlaying import held_against, overlay
from phaseplane.constructions.primitives import (
    Arc,
    Axis,
    Curve,
    Drawing,
    Frame,
    Mark,
    Plane,
    Scheme,
    Stroke,
)
from phaseplane.constructions.rules import RULES, Rule, delta, rule_named, tangent, velocity
from phaseplane.constructions.shortcuts import shortcut_flights, with_shortcuts
from phaseplane.constructions.two_planes import QuarterCarPlanes
from phaseplane.constructions.yielding import ElastoplasticPlane

__all__ = [
    "RULES",
    "Arc",
    "Axis",
    "AxleData",
    "Construction",
    "Curve",
    "Drawing",
    "ElastoplasticPlane",
    "EquationPlane",
    "Frame",
    "HalfCarPlanes",
    "HalfCarRigidTyresPlanes",
    "Mark",
    "OneDofPlane",
    "Plane",
    "QuarterCarPlanes",
    "Rule",
    "Scheme",
    "StepError",
    "Stroke",
    "Strut",
    "Window",
    "delta",
    "frames",
    "held_against",
    "march",
    "overlay",
    "rule_named",
    "shortcut_flights",
    "tangent",
    "velocity",
    "with_shortcuts",
]
