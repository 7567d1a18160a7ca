"""Roads and loads as functions of time: named shapes, sequences, measured and random profiles.

They consist of the signals in `signals`. All functions for roads and loads can be imported from here.
"""

from __future__ import annotations

from ..measurement_files import read_points
from ..signals import LEVEL, Segment, Signal, constant
from .profiles import REFERENCE_FREQUENCY, class_roughness, random_profile, spline, table
from .shapes import (
    bump,
    obstacle,
    plank,
    pothole,
    ramp,
    sequence,
    sine,
    step,
    sweep,
    wave_length_sweep,
)

__all__ = [
    "LEVEL",
    "REFERENCE_FREQUENCY",
    "Segment",
    "Signal",
    "bump",
    "class_roughness",
    "constant",
    "obstacle",
    "plank",
    "pothole",
    "ramp",
    "random_profile",
    "read_points",
    "sequence",
    "sine",
    "spline",
    "step",
    "sweep",
    "table",
    "wave_length_sweep",
]
