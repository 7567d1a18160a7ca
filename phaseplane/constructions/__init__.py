"""Graphical constructions in the phase plane, step by step, as plain geometry (AP57).

A construction (`OneDofPlane`, `QuarterCarPlanes`) says which points belong to a state; a step rule
(`RULES`) goes from there to the next state; `march` and `frames` string the steps together, and
`overlay` lays the same geometry over a motion that is known already.
"""

from __future__ import annotations

from phaseplane.constructions.marching import Construction, Window, frames, march
from phaseplane.constructions.one_plane import OneDofPlane
from phaseplane.constructions.overlaying import overlay
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
from phaseplane.constructions.steps import (
    RULES,
    Rule,
    delta,
    mean_normal,
    midpoint_circle,
    osculating_circle,
    rule_named,
    tangent,
    velocity,
)
from phaseplane.constructions.two_planes import QuarterCarPlanes

__all__ = [
    "RULES",
    "Arc",
    "Axis",
    "Construction",
    "Curve",
    "Drawing",
    "Frame",
    "Mark",
    "OneDofPlane",
    "Plane",
    "QuarterCarPlanes",
    "Rule",
    "Scheme",
    "Stroke",
    "Window",
    "delta",
    "frames",
    "march",
    "mean_normal",
    "midpoint_circle",
    "osculating_circle",
    "overlay",
    "rule_named",
    "tangent",
    "velocity",
]
