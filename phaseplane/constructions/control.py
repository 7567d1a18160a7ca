"""The check of AP57 section 4: the motion of a body computed independently of the planes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Before(NamedTuple):
    """The readings before, and the time since then, s."""

    readings: Mapping[str, float]
    elapsed: float


def controlled(
    body: str, motion: tuple[float, float, float], acceleration: float, before: Before | None
) -> dict[str, float]:
    """Return a body's motion from its forces, integrated from the readings before (AP57 eq. 25).

    The acceleration is taken as linear over the elapsed time. The result must agree with the motion
    read off the planes (eq. 24): acceleration to rounding, the others to the error of the step.

    Parameters
    ----------
    body : prefix of the names of its readings
    motion : displacement, velocity and acceleration read off the planes, SI; the first two start
        the control if there are no readings before
    acceleration : from the forces, m/s^2
    before : None at the start
    """
    displacement, velocity, _ = motion
    if before is not None:
        read, elapsed = before
        old_velocity, old = read[f"control_{body}_velocity"], read[f"control_{body}_acceleration"]
        velocity = old_velocity + 0.5 * elapsed * (old + acceleration)
        displacement = read[f"control_{body}_displacement"] + elapsed * (
            old_velocity + elapsed * (2.0 * old + acceleration) / 6.0
        )
    return {
        f"control_{body}_displacement": displacement,
        f"control_{body}_velocity": velocity,
        f"control_{body}_acceleration": acceleration,
    }
