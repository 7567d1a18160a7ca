"""Measures of a run: each has a name, a unit, a definition and a source.

Only the measures that a scene shows or bounds are taken, and only the outputs they need are read.
"""

from .catalogue import at_end, catalogue, default_measures, outputs_needed, take
from .reading import COUNT, Measure, Reading, Run

__all__ = [
    "COUNT",
    "Measure",
    "Reading",
    "Run",
    "at_end",
    "catalogue",
    "default_measures",
    "outputs_needed",
    "take",
]
