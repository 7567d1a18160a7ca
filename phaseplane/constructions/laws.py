"""The characteristics that a construction takes, and the checks where they enter."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite

from suspension.characteristics import Characteristic
from suspension.roads import constant

LEVEL_ROAD = constant()
"""The road without an obstacle."""

Damper = Characteristic | Callable[[float, float], float]
"""Damping force Phi(y', y) in N: a law of the rate, or any function of rate and deflection."""


def damping_force(damper: Damper) -> Callable[[float, float], float]:
    """The damper as a function of rate (m/s) and deflection (m)."""
    if isinstance(damper, Characteristic):
        force = damper.force
        return lambda rate, deflection: force(rate)
    return damper


def corners_of(damper: Damper) -> tuple[float, ...]:
    """The rates at which a damper is known to bend, m/s."""
    return damper.corners if isinstance(damper, Characteristic) else ()


def check_number(name: str, value: float, least: float, *, exclusive: bool) -> None:
    """Refuse what is not a finite number, or too small.

    Raises
    ------
    ValueError : with name, value and range.
    """
    if not isfinite(value) or value < least or (exclusive and value == least):
        relation = "greater than" if exclusive else "at least"
        raise ValueError(f"{name} = {value!r}: must be finite and {relation} {least:g}")


def check_laws(spring: Characteristic, damper: Damper) -> None:
    """Refuse characteristics that a phase plane cannot be drawn for.

    Raises
    ------
    ValueError : forces that do not vanish at rest, a spring whose rate at zero is not positive.
    """
    if not isinstance(spring, Characteristic):
        raise ValueError(f"spring = {spring!r}: must be a Characteristic")
    if not callable(damper) and not isinstance(damper, Characteristic):
        raise ValueError(f"damper = {damper!r}: must be a Characteristic or a function (rate, y)")
    for name, force in (("spring", spring.force(0.0)), ("damper", damping_force(damper)(0.0, 0.0))):
        if not abs(force) < 1e-9:
            raise ValueError(
                f"the {name} has the force {force:g} N at rest; "
                "forces are measured from static equilibrium and must vanish there"
            )
    rate = spring.tangent(0.0)
    if not (isfinite(rate) and rate > 0.0):
        raise ValueError(
            f"the spring's rate at zero deflection is {rate:g} N/m; it sets the scale of the phase "
            "plane and must be positive"
        )
