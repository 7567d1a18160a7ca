"""From scenes and results to constructions, pictures and recordings.

Only what is asked for is imported and made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any

from suspension.characteristics import linear
from suspension.models import build
from suspension.variables import Value

from .errors import InputError, one_line
from .replays import of_results

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from phaseplane.constructions import QuarterCarPlanes
    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content

    from .results import Results
    from .schema import Scene

CONSTRUCTED = ("QuarterCar",)  # models whose construction is known
RECORDING = "construction.rrd"
_SHEET_STEPS = 20  # as many as AP57 shows with all auxiliary lines (figure 13)
# What the construction is laid over: displacement and velocity of each plane, and the mode.
_MOTION = (
    "suspension_deflection", "suspension_deflection_rate", "wheel_displacement", "wheel_velocity",
)  # fmt: skip


def constructed(
    model: str, parameters: Mapping[str, Value], settings: Mapping[str, Any], duration: float
) -> Drawing:
    """The graphical construction marching by itself.

    Parameters
    ----------
    parameters : what differs from the model's defaults, SI
    settings : rule, step (s), plane_distance (m), plane_scales
    duration : s

    Raises
    ------
    InputError : a model without a construction, or settings with which it cannot be drawn.
    ArithmeticError : the construction leaves every sheet.
    """
    from phaseplane.constructions import march, rule_named  # noqa: PLC0415

    try:
        return march(
            _planes(model, parameters, settings),
            rule_named(settings["rule"]),
            step=settings["step"],
            duration=duration,
        )
    except ValueError as error:
        raise InputError(f"construction: {one_line(error)}") from None


def laid_over(results: Results, settings: Mapping[str, Any]) -> Drawing:
    """The graphical construction with the state points of a run.

    Parameters
    ----------
    settings : as for `constructed`; where `step` is longer than the rows of the results are apart,
        rows are skipped, but never those where the wheel leaves the road or returns

    Raises
    ------
    InputError : a model without a construction, columns that the results lack, or settings with
        which it cannot be drawn.
    """
    from phaseplane.constructions import overlay, rule_named  # noqa: PLC0415

    missing = [name for name in _MOTION if name not in results.columns]
    if missing:
        raise InputError(f"no column {missing[0]}; put it into show.outputs and run")
    rows = list(_rows(results, settings["step"]))
    airborne = results.columns.get("airborne")
    summary = results.summary
    try:
        return overlay(
            _planes(summary["model"], summary["parameters"], settings),
            results.columns["time"][rows].tolist(),
            *(results.columns[name][rows].tolist() for name in _MOTION),
            rule=rule_named(settings["rule"]),
            airborne=None if airborne is None else airborne[rows].astype(bool).tolist(),
        )
    except ValueError as error:
        raise InputError(f"construction: {one_line(error)}") from None


def draw_all(
    scene: Scene, results: Results, drawing: Drawing | None, folder: Path
) -> Iterator[str]:
    """Draw what the scene shows into the folder; yields a line for what could not be drawn."""
    makers = {name: f"{name}.png" for name in scene.show.figures}
    for name, file in makers.items():
        if name == "time_histories" or drawing is not None:
            try:
                draw(name, folder / file, drawing, results)
            except Exception as error:  # a picture that fails must not cost the results
                yield f"{file} was not drawn: {one_line(error)}"
    if scene.show.recording:
        try:
            record(of_results(results, drawing, scene.show.model_dump()), folder / RECORDING)
        except Exception as error:
            yield f"{RECORDING} was not written: {one_line(error)}"


def draw(name: str, path: Path, drawing: Drawing | None, results: Results | None = None) -> None:
    """Draw one picture: `time_histories` from results, the others from a construction."""
    from phaseplane import figures  # noqa: PLC0415  (imports matplotlib)

    if name == "time_histories":
        assert results is not None
        figure = figures.time_histories(histories(results), title=results.summary["title"])
    else:
        assert drawing is not None
        figure = (
            figures.phase_planes(drawing)
            if name == "phase_planes"
            else figures.construction_sheet(
                drawing, frames=range(min(_SHEET_STEPS, len(drawing.frames)))
            )
        )
    figures.save(figure, path)


def record(shown: Content, path: Path) -> None:
    """Write a recording."""
    from phaseplane import recording  # noqa: PLC0415  (imports rerun)

    recording.record(shown, path)


def histories(results: Results) -> dict[str, npt.NDArray[np.float64]]:
    """The columns under the names that pictures and recordings know."""
    renamed = {"ground_elevation": "road_elevation", "ground_velocity": "road_velocity"}
    columns = {renamed.get(name, name): column for name, column in results.columns.items()}
    if {"body_acceleration", "wheel_acceleration"} <= columns.keys():
        deflection = columns["body_acceleration"] - columns["wheel_acceleration"]
        columns["suspension_deflection_acceleration"] = deflection
    return columns


def _rows(results: Results, step: float) -> Iterator[int]:
    """The rows that lie a step apart, and those where the mode changes."""
    time = results.columns["time"]
    airborne = results.columns.get("airborne")
    due = time[0]
    for row, instant in enumerate(time):
        changed = airborne is not None and row > 0 and airborne[row] != airborne[row - 1]
        if changed or instant >= due - 1e-6 * step or row == len(time) - 1:
            yield row
        if instant >= due - 1e-6 * step:
            due += step * max(1, round((instant - due) / step + 1e-6) + 1)


def _planes(
    model: str, parameters: Mapping[str, Value], settings: Mapping[str, Any]
) -> QuarterCarPlanes:
    """Both phase planes of a quarter car; spring and end stops act side by side."""
    from phaseplane.constructions import QuarterCarPlanes  # noqa: PLC0415

    if model not in CONSTRUCTED:
        raise InputError(f"no construction is known for {model}; only for {', '.join(CONSTRUCTED)}")
    system = build(model, parameters)
    tyre = system.element("tyre")
    between = [e for i, e in enumerate(system.elements) if i != tyre]
    return QuarterCarPlanes(
        sprung_mass=float(system.mass[0][0]),
        unsprung_mass=float(system.mass[1][1]),
        spring=reduce(add, (e.spring for e in between), linear(0.0)),
        damper=reduce(add, (e.damper for e in between), linear(0.0)),
        tyre_stiffness=float(parameters["tyre.stiffness"]),
        tyre_damping=float(parameters["tyre.damping"]),
        road=system.signals["road"],
        gravity=float(parameters["gravity"]),
        lift_off=bool(parameters["lift_off"]) and float(parameters["gravity"]) > 0.0,
        plane_distance=settings["plane_distance"],
        plane_scales=tuple(settings["plane_scales"]),
    )
