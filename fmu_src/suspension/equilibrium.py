"""Static equilibrium of a system: sum b f(b' q - u, 0) = p (see `kernel.rest`)."""

from __future__ import annotations

from collections.abc import Mapping

from .systems import System


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
