"""The public variables of every model, and the check of parameters given for one.

FMU model descriptions, parameter checks and printed tables are all made from them.
"""

from __future__ import annotations

from .declared import METHODS, ROAD_SHAPES, SOLVER_PARAMETERS
from .models import MODELS, SOURCES, checked_parameters, outputs, variables
from .outputs import SOLVER_OUTPUTS
from .variable import ParameterError, Value, Variable, refuse_unknown

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
