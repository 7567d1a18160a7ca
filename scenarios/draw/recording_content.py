"""What a recording of a scene or of a run holds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.models import build
from phaseplane.suspension.variables import MODELS, Value

from phaseplane import recording

from .. import draw

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from phaseplane.suspension.signals import Signal
    from phaseplane.suspension.systems import Axle, System

    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content, Vehicle

    from ..results.folder import Results

    Columns = Mapping[str, npt.NDArray[np.float64]]

# The displacements whose phase planes are drawn where nobody says which, the first that exist.
_PLANES = (
    ("suspension_deflection", "wheel_displacement"),
    ("front_suspension_deflection", "front_wheel_displacement",
     "rear_suspension_deflection", "rear_wheel_displacement"),
    ("displacement",),
    ("body_displacement",),
)  # fmt: skip
_READ_OFF = ("_displacement", "_elevation", "_acceleration", "_force")
_MOST_ROWS = 20_000
_ROAD_POINTS = 2_000


def content(
    *,
    title: str,
    model: str,
    parameters: Mapping[str, Value],
    drawing: Drawing | None,
    columns: Columns,
    units: Mapping[str, str],
    duration: float,
    shown: Mapping[str, Any],
    live: bool = False,
) -> Content:
    """All that a recording shows.

    Parameters
    ----------
    title : of the scene
    model, parameters : what was run, parameters in SI
    drawing : its construction, if there is one
    columns : of the run, by the names of its outputs; of no rows before it begins
    units : SI units of the outputs
    duration : of the run, s
    shown : `recording` (its detail), `views`, `planes` (pairs of outputs)
    live : whether the run is yet to come
    """
    views = tuple(shown.get("views") or recording.VIEWS)
    rows = recording.thinned(columns, _MOST_ROWS)
    if "energies" in views and model in MODELS and not live:
        rows = {**rows, **draw.energies.energies(model, parameters, rows["time"])}
    detail = shown.get("recording")
    pairs = tuple(map(tuple, shown.get("planes") or default_pairs(units)))
    return recording.Content(
        title=title,
        drawing=None if shown.get("planes") else drawing,
        histories={known(name): column for name, column in rows.items()},
        units={known(name): unit for name, unit in units.items()},
        pairs=pairs,
        vehicle=vehicle(model, parameters, duration) if "vehicle" in views else None,
        detail=detail if detail in recording.DETAILS else "stages",
        views=views,
        live=live,
    )


def readings(drawing: Drawing) -> dict[str, npt.NDArray[np.float64]]:
    """Columns of what a construction has read off its sheet, but for its own phase planes."""
    names = [
        name
        for name in drawing.frames[0].readings
        if name.endswith(_READ_OFF) and not name.startswith("control_")
    ]
    return {
        "time": np.array([frame.time for frame in drawing.frames]),
        **{n: np.array([frame.readings[n] for frame in drawing.frames]) for n in names},
    }


def default_pairs(names: Iterable[str]) -> list[tuple[str, str]]:
    """Displacements and their rates whose phase planes tell most."""
    names = set(names)
    for displacements in _PLANES:
        pairs = [(y, rate) for y in displacements if {y, rate := recording.rate_of(y)} <= names]
        if pairs:
            return pairs
    return []


def vehicle(model: str, parameters: Mapping[str, Value], duration: float) -> Vehicle | None:
    """The vehicle of a model as it is seen from the side; none for a model without a road.

    Parameters
    ----------
    duration : for which it travels, s
    """
    if model not in MODELS:
        return None
    system = build(model, parameters)
    if not system.axles:
        return None
    places = {
        "front_": float(parameters.get("cg_to_front", 0.0)),
        "rear_": -float(parameters.get("cg_to_rear", 0.0)),
    }

    def gap(prefix: str, stop: str) -> float | None:
        of = prefix.replace("_", ".")
        present = system.element(f"{prefix}{stop}") is not None
        return float(parameters[f"{of}{stop}.gap"]) if present else None

    axles = []
    for axle in system.axles:
        axles.append(
            recording.AxleView(
                name=axle.prefix.rstrip("_") or "axle",
                position=places.get(axle.prefix, 0.0),
                body=f"{axle.prefix}body_displacement",
                road=f"{axle.prefix}road_elevation",
                wheel=f"{axle.prefix}wheel_displacement" if axle.tyre else "",
                airborne=f"{axle.prefix}airborne" if axle.tyre else "",
                static_tyre_deflection=_static_tyre_deflection(system, axle),
                bump_gap=gap(axle.prefix, "bump_stop"),
                rebound_gap=gap(axle.prefix, "rebound_stop"),
            )
        )
    road = system.signals[system.axles[0].road]
    return recording.Vehicle(
        tuple(axles), float(parameters["speed"]), tuple(_profile(road, duration))
    )


def _static_tyre_deflection(system: System, axle: Axle) -> float:
    """How far the weight compresses a tyre, m: as far as it must extend to be free of force."""
    number = system.element(axle.tyre)
    if number is None:
        return 0.0
    free = system.elements[number].spring.argument(axle.static_load)
    return free if isfinite(free) else 0.0  # a table that never lets go


def _profile(road: Signal, duration: float) -> Iterator[tuple[float, float]]:
    """Points of a road, close together, as far as it is met."""
    for i in range(_ROAD_POINTS + 1):
        instant = duration * i / _ROAD_POINTS
        yield instant, road.value(instant)


def of_results(results: Results, drawing: Drawing | None, shown: Mapping[str, Any]) -> Content:
    """The recording of a run."""
    summary = results.summary
    return content(
        title=summary["title"] or summary["scene"],
        model=summary["model"],
        parameters=summary["parameters"],
        drawing=drawing,
        columns=results.columns,
        units=summary["units"],
        duration=summary["duration"],
        shown=shown,
    )


def known(name: str) -> str:
    """The name under which a recording knows a column."""
    return name.replace("ground_", "road_")
