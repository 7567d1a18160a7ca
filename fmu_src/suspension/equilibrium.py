"""Where a system rests, sum b f(b' q - u, 0) = p (see `kernel.network.rest`), and where a run starts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from .signals import Signal
from .systems import System
from .variable import ParameterError, Value, numbers


def static_equilibrium(
    system: System, signals: Mapping[str, float] | None = None
) -> tuple[float, ...]:
    """Return the displacements at which a system rests, for given road levels and loads.

    sum b f(b' q - u, 0) = p, with dry friction left out

    Parameters
    ----------
    system : any system
    signals : elevation (m) or force (N) of its roads and loads by name; the others are 0

    Returns
    -------
    One displacement per coordinate, m.

    Raises
    ------
    ValueError : no equilibrium was found: a coordinate is not held by any spring, or is unstable.
    """
    from .engine import Network, Rest  # noqa: PLC0415  (commands that find no equilibrium need no kernel)

    levels = [(signals or {}).get(name, 0.0) for name in system.signals]
    found: tuple[float, ...] | None = Rest(Network(system)).displacements(levels)
    if found is None:
        raise ValueError(
            "no static equilibrium was found: every coordinate must be held by springs that can carry "
            "its load"
        )
    return found


def start_state(
    system: System,
    parameters: Mapping[str, Value],
    time: float,
    signals: Mapping[str, Signal] | None = None,
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the initial displacements (m) and velocities (m/s) of all coordinates.

    They are the static equilibrium on the road just before, plus the initial values. External forces
    act from the start on and are not part of the equilibrium.

    Parameters
    ----------
    system : any system
    parameters : of its model, by name
    time : s
    signals : roads and loads in place of those of the system

    Raises
    ------
    ParameterError : no equilibrium was found on a road that is not at zero.
    """
    signals = system.signals if signals is None else signals
    levels = {axle.road: signals[axle.road].before(time) for axle in system.axles}
    displacements, velocities = (
        numbers(parameters, names) for names in initial_names(system.coordinates)
    )
    if any(levels.values()):
        try:
            rest = static_equilibrium(system, levels)
        except ValueError as error:
            raise ParameterError(f"the start: {error}") from None
        displacements = tuple(r + q for r, q in zip(rest, displacements, strict=True))
    return displacements, velocities


@cache
def initial_names(coordinates: tuple[str, ...]) -> list[list[str]]:
    """Return the names of the parameters: initial displacements of coordinates, then velocities."""
    return [
        [f"initial.{name}_{what}".replace("._", ".") for name in coordinates]
        for what in ("displacement", "velocity")
    ]
