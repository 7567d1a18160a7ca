"""A made-up run of a quarter car, to record."""

from __future__ import annotations

import numpy as np

from phaseplane.recording import AxleView, Vehicle

STATIC = 0.02
TIME = np.linspace(0.0, 0.3, 301)
QUARTER = Vehicle(
    (AxleView("axle", 0.0, "body", "road", "wheel", "airborne", STATIC, 0.06, 0.07),), speed=20.0
)
MOTION = {
    "time": TIME,
    "body": 0.01 * np.sin(20 * TIME),
    "wheel": 0.05 * np.sin(30 * TIME),
    "road": 0.02 * np.cos(10 * TIME),
    "airborne": 0.05 * np.sin(30 * TIME) - 0.02 * np.cos(10 * TIME) > STATIC,
    "body_displacement": 0.04 * np.sin(20 * TIME),
    "body_velocity": 0.8 * np.cos(20 * TIME),
    "speed": np.full(301, 20.0),
}
