"""The content of a recording of a scene or of a run."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.models import build
from phaseplane.suspension.variables import MODELS, Value

from phaseplane import recording
from phaseplane.picture.frames import read_over, switches_of
from phaseplane.picture.quantities import rate_of

from .. import draw
from ..errors import RunError
from ..scene.fmus import LEDGER
from ..scene.sections import Show

if TYPE_CHECKING:
    from phaseplane.suspension.systems import Axle, System

    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content, Vehicle

    from ..columns import Column, Columns
    from ..results.folder import Results
    from ..scene.schema import Scene


# The displacements whose phase planes are drawn by default: the first group that exists.
_PLANES = (
    ("suspension_deflection", "wheel_displacement"),
    ("front_suspension_deflection", "front_wheel_displacement",
     "rear_suspension_deflection", "rear_wheel_displacement"),
    ("displacement",),
    ("body_displacement",),
)  # fmt: skip
_MOST_ROWS = 20_000
_ROAD_POINTS = 2_000
_SIDE = {"", "front_", "rear_"}  # the prefixes of axles that are seen from the side


def content(
    *,
    title: str,
    model: str,
    parameters: Mapping[str, Value],
    drawing: Drawing | None,
    columns: Columns,
    units: Mapping[str, str],
    duration: float,
    shown: Show,
    live: bool = False,
    alone: bool = True,
) -> Content:
    """Return the content of a recording.

    Parameters
    ----------
    model, parameters : the model and its parameters, SI
    drawing : its construction, if there is one
    columns : columns of the run by the names of its outputs; without rows before it starts
    units : SI units of the outputs
    duration : of the run, s
    shown : its detail, views, planes and staged steps
    alone : whether the model moved without a controller, so that its energies can be found again

    Raises
    ------
    RunError : if rerun cannot be loaded.
    """
    _load_rerun()
    kept = alone and parameters.get(LEDGER, True)
    views: tuple[Any, ...] = shown.views or recording.VIEWS
    views = tuple(view for view in views if kept or view != "energies")
    rows = recording.thinned(columns, _MOST_ROWS)
    if "energies" in views and model in MODELS and not live:
        rows = {**rows, **draw.energies.energies(model, parameters, rows["time"])}
    detail: Any = shown.recording
    pairs = shown.planes or default_pairs(units)
    return recording.Content(
        title=title,
        drawing=None if shown.planes else drawing,
        histories={known(name): column for name, column in rows.items()},
        units={known(name): unit for name, unit in units.items()},
        pairs=tuple((known(y), known(rate)) for y, rate in pairs),
        vehicle=vehicle(model, parameters, duration) if "vehicle" in views else None,
        detail=detail if detail in recording.DETAILS else "stages",
        views=views,
        staged=shown.staged,
        numbers=tuple(known(n) for n, u in units.items() if u in ("", "1"))
        if model not in MODELS
        else (),
        live=live,
    )


def readings(drawing: Drawing) -> dict[str, Column]:
    """Return the readings of a construction up to its end, except those that check it, and its switches.

    Without the rates of its planes: with them, they would be drawn as the motion of a run.
    """
    rates = {rate_of(plane.name) for plane in drawing.planes}
    names = [
        n for n in drawing.frames[0].readings if not n.startswith("control_") and n not in rates
    ]
    times, read = read_over(drawing, names)
    switches = {name: states.astype(float) for name, states in switches_of(drawing).items()}
    return {"time": times, **dict(zip(names, read.T, strict=True)), **switches}


def default_pairs(units: Mapping[str, str]) -> list[tuple[str, str]]:
    """Return the displacements and rates of the phase planes to draw by default.

    Those of the models here are known by name; of other FMUs, a variable and what is named as its rate
    or its derivative make a pair, or else the only two outputs in m and m/s, or in rad and rad/s.
    """
    names = list(units)
    for displacements in (*_PLANES, names):
        pairs = [
            (y, rate) for y in displacements for rate in _rates(y) if {y, rate} <= units.keys()
        ]
        if pairs:
            return pairs
    for unit, per_second in (("m", "m/s"), ("rad", "rad/s")):
        alone = [[n for n in names if units[n] == u] for u in (unit, per_second)]
        if len(alone[0]) == len(alone[1]) == 1:
            return [(alone[0][0], alone[1][0])]
    return []


def _rates(name: str) -> tuple[str, ...]:
    """Return how the rate of a variable may be named."""
    return rate_of(name), f"der({name})", f"der_{name}", f"{name}_dot", f"d{name}"


def vehicle(model: str, parameters: Mapping[str, Value], duration: float) -> Vehicle | None:
    """Return the side view of a model's vehicle that travels for so long, s.

    There is none without a road, or with wheels side by side.
    """
    if model not in MODELS:
        return None
    system = build(model, parameters)
    if not system.axles or not {axle.prefix for axle in system.axles} <= _SIDE:
        return None
    places = {
        "front_": float(parameters.get("cg_to_front", 0.0)),
        "rear_": -float(parameters.get("cg_to_rear", 0.0)),
    }

    def gap(prefix: str, stop: str) -> float | None:
        of = prefix.replace("_", ".")
        present = system.element(f"{prefix}{stop}") is not None
        return float(parameters[f"{of}{stop}.gap"]) if present else None

    axles = tuple(
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
        for axle in system.axles
    )
    road = system.signals[system.axles[0].road]
    passed = [duration * i / _ROAD_POINTS for i in range(_ROAD_POINTS + 1)]
    profile = tuple((instant, road.value(instant)) for instant in passed)
    return recording.Vehicle(axles, float(parameters["speed"]), profile)


def _static_tyre_deflection(system: System, axle: Axle) -> float:
    """Return the static deflection of a tyre, m: how far it extends until it carries no force."""
    number = system.element(axle.tyre)
    if number is None:
        return 0.0
    free = system.elements[number].spring.argument(axle.static_load)
    return free if isfinite(free) else 0.0  # a table that never reaches zero force


def _load_rerun() -> None:
    """Load what writes recordings, and refuse a rerun that is broken."""
    try:
        _ = recording.record
    except Exception as error:  # a library that is loaded may raise anything
        raise RunError(
            f"rerun cannot be loaded ({error}); try `pip install --force-reinstall rerun-sdk`"
        ) from error


def of_scene(
    scene: Scene,
    drawing: Drawing | None,
    columns: Columns | None = None,
    units: Mapping[str, str] | None = None,
    shown: Show | None = None,
    *,
    live: bool = False,
) -> Content:
    """Return the content of the recording of a scene.

    By default with the readings of its drawing, and the steps and views that the scene chooses.
    """
    if columns is None:
        columns = {} if drawing is None else readings(drawing)
    return content(
        title=scene.title or scene.name,
        model=scene.fmu.model,
        parameters=scene.all_parameters,
        drawing=drawing,
        columns=columns,
        units=units or {},
        duration=scene.duration,
        shown=shown or Show(staged=scene.show.staged, views=scene.show.views),
        live=live,
    )


def of_results(results: Results, drawing: Drawing | None, shown: Show) -> Content:
    """Return the content of the recording of a run."""
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
        alone=not summary.get("controller"),
    )


def of_table(
    title: str, columns: Columns, units: Mapping[str, str], plane: tuple[str, str] | None
) -> Content:
    """Return the content of the recording of any table: its columns over time, and a plane of two."""
    return content(
        title=title,
        model="",
        parameters={},
        drawing=None,
        columns=columns,
        units=units,
        duration=float(columns["time"][-1]),
        shown=Show(views=("planes", "histories", "words"), planes=(plane,) if plane else ()),
    )


def known(name: str) -> str:
    """Return the name of a column in a recording."""
    return name.replace("ground_", "road_")
