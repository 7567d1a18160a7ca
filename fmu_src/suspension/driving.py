"""What the inputs of a model drive: the roads and forces of its system."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

from .systems import System
from .variable import Value


class Driving(NamedTuple):
    """What inputs drive in a system.

    Parameters
    ----------
    sampled : whether they drive the roads, too
    lines : of each signal that they drive: its number, the input of its value, that of its rate or -1
    idle : by name why an input has no effect, as the end of a sentence
    """

    sampled: bool
    lines: tuple[tuple[int, int, int], ...]
    idle: Mapping[str, str]


def driving(system: System, inputs: tuple[str, ...], parameters: Mapping[str, Value]) -> Driving:
    """Return what the named inputs of a model drive in its system with these parameters."""
    roads = tuple([axle.road for axle in system.axles])
    return _driving(tuple(system.signals), roads, inputs, parameters.get("road.shape"))


@lru_cache(maxsize=16)
def _driving(
    signals: tuple[str, ...], roads: tuple[str, ...], inputs: tuple[str, ...], shape: object
) -> Driving:
    sampled = shape == "input"
    lines = []
    for signal, name in enumerate(signals):
        if sampled and name in roads:
            value, rate = f"{name}_elevation", f"{name}_velocity"
            lines.append((signal, inputs.index(value), inputs.index(rate)))
        elif name in inputs:
            lines.append((signal, inputs.index(name), -1))
    acting = {number for _, *numbers in lines for number in numbers}
    why = "as no signal of the system follows it"
    if shape is not None and not sampled:
        why = f"as road.shape is '{shape}' and not 'input'"
    idle = {name: why for number, name in enumerate(inputs) if number not in acting}
    return Driving(sampled, tuple(lines), idle)
