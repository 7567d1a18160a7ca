"""The check of AP57 section 4: the motion of a body computed independently of the planes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

Motion = tuple[float, float, float]
"""Displacement, velocity and acceleration, SI."""


class Before(NamedTuple):
    """The readings before, and the time since then, s."""

    readings: Mapping[str, float]
    elapsed: float


def added(one: Motion, other: Motion) -> Motion:
    """Return the motion of which two others are the parts."""
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def moved(what: str, motion: Motion) -> dict[str, float]:
    """Return a motion by the names of its readings, which begin with `what`."""
    displacement, velocity, acceleration = motion
    return {
        f"{what}displacement": displacement,
        f"{what}velocity": velocity,
        f"{what}acceleration": acceleration,
    }


def deflected(prefix: str, motion: Motion) -> dict[str, float]:
    """Return the motion of the suspension of an axle by the names of its readings."""
    name = f"{prefix}suspension_deflection"
    return dict(zip((name, f"{name}_rate", f"{name}_acceleration"), motion, strict=True))


def controlled(
    prefix: str, motion: Motion, acceleration: float, before: Before | None
) -> dict[str, float]:
    """Return a body's motion and the same from its forces, integrated from the readings before.

    The latter is the control (AP57 eq. 25).

    The acceleration is taken as linear over the elapsed time. The result must agree with the motion
    read off the planes (eq. 24): acceleration to rounding, the others to the error of the step.

    Parameters
    ----------
    prefix : of the axle below it
    motion : read off the planes; displacement and velocity start the control if there are no
        readings before
    acceleration : from the forces, m/s^2
    before : None at the start
    """
    displacement, velocity, _ = motion
    body = f"{prefix}body_"
    control = f"control_{body}"
    if before is not None:
        read, elapsed = before
        old_velocity, old = read[f"{control}velocity"], read[f"{control}acceleration"]
        velocity = old_velocity + 0.5 * elapsed * (old + acceleration)
        displacement = read[f"{control}displacement"] + elapsed * (
            old_velocity + elapsed * (2.0 * old + acceleration) / 6.0
        )
    return moved(body, motion) | moved(control, (displacement, velocity, acceleration))
