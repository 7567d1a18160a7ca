"""The check of AP57 section 4: the motion of a body computed independently of the planes."""

from __future__ import annotations

from collections.abc import Mapping


def controlled(
    body: str,
    motion: tuple[float, float, float],
    acceleration: float,
    previous: Mapping[str, float] | None,
    elapsed: float,
) -> dict[str, float]:
    """Return a body's motion from its forces, integrated from the previous readings (AP57 eq. 25).

    The acceleration is taken as linear over the elapsed time. The result must agree with the motion
    read off the planes (eq. 24): acceleration to rounding, the others to the error of the step.

    Parameters
    ----------
    body : prefix of the names of its readings
    motion : displacement, velocity and acceleration read off the planes, SI; the first two start
        the control if there are no previous readings
    acceleration : from the forces, m/s^2
    previous : readings at the previous step, or None at the start
    elapsed : time since the previous readings, s
    """
    displacement, velocity, _ = motion
    if previous is not None:
        before = previous[f"control_{body}_acceleration"]
        old_velocity = previous[f"control_{body}_velocity"]
        velocity = old_velocity + 0.5 * elapsed * (before + acceleration)
        displacement = previous[f"control_{body}_displacement"] + elapsed * (
            old_velocity + elapsed * (2.0 * before + acceleration) / 6.0
        )
    return {
        f"control_{body}_displacement": displacement,
        f"control_{body}_velocity": velocity,
        f"control_{body}_acceleration": acceleration,
    }
