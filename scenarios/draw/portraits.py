"""Phase portraits of scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.models import build
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import MODELS, Value

from phaseplane import figures
from phaseplane import portrait as computed

from ..errors import InputError, check_picture, one_line
from ..scene.equation import EQUATION, function_of
from ..scene.loading import load_scene

if TYPE_CHECKING:
    from phaseplane.suspension.systems import System

    from phaseplane.portrait import PhaseSystem, Portrait

    from ..scene.schema import Scene

_REACH = 3.0  # of an equation, unless it starts farther out
_PART = 0.1  # m, that of a vehicle
_PERIODS = 200


def portrait(
    reference: str,
    overrides: Sequence[str],
    figure: Path | None,
    *,
    coordinate: str = "",
    window: Sequence[float] = (),
    period: float = 0.0,
    dark: bool = False,
) -> dict[str, Any]:
    """Compute the phase portrait of a scene, and draw it if wanted.

    Parameters
    ----------
    reference, overrides : the scene
    figure : picture to be written
    coordinate : which one moves while the others rest at zero; the first if left out
    window : left, right, bottom, top; chosen if left out
    period : of an equation's excitation, for its Poincaré section, s

    Returns
    -------
    the window, equilibria, limit cycles, and the last states of the section, as plain data

    Raises
    ------
    InputError : a scene without a portrait, no such coordinate, a window that is none.
    """
    if figure is not None:
        check_picture(figure)
    scene = load_scene(reference, overrides)
    try:
        system, forced, labels, reach, start = _of_scene(scene, coordinate, period)
        shown = computed.Window(*window) if window else computed.good_window(system, reach)
        with np.errstate(all="ignore"):  # motions that leave every window
            made = computed.whole_portrait(
                system, shown, forced=forced, start=start, periods=_PERIODS
            )
    except (ValueError, OverflowError) as error:
        raise InputError(f"portrait of {scene.name}: {one_line(error)}") from None
    title = scene.title or scene.name
    if scene.fmu.model == EQUATION:
        title = f"{title}: x'' + {scene.all_parameters['equation']} = 0"
    if figure is not None:
        figures.save(figures.portrait(made, labels=labels, title=title, dark=dark), figure)
    return {
        "title": title,
        "coordinate": labels[0],
        **_told(made),
        "files": [str(figure)] if figure is not None else [],
    }


def _told(made: Portrait) -> dict[str, Any]:
    """A portrait in numbers."""
    window = made.window
    return {
        "window": [window.left, window.right, window.bottom, window.top],
        "equilibria": [{"x": at.x, "kind": at.kind, "on_corner": at.on_corner}
                       for at in made.equilibria],
        "cycles": [
            {
                "crossing": c.crossing, "period": c.period, "multiplier": c.multiplier,
                "attracts": c.attracts,
            }
            for c in made.cycles
        ],
        "section": None if made.section is None else made.section[-3:].tolist(),
    }  # fmt: skip


def portrait_in_words(told: Mapping[str, Any]) -> str:
    """The same for a terminal."""
    left, right, bottom, top = told["window"]
    lines = [
        told["title"],
        f"window       {left:.4g} to {right:.4g}, {bottom:.4g} to {top:.4g}",
        *(f"equilibrium  {at['x']:.6g}: {at['kind']}" for at in told["equilibria"]),
        *(
            f"limit cycle  crosses the axis at {c['crossing']:.6g}, period {c['period']:.6g} s, "
            + ("attracts" if c["attracts"] else "repels")
            for c in told["cycles"]
        ),
    ]
    if told["section"]:
        x, v = told["section"][-1]
        lines.append(f"section      {x:.6g}, {v:.6g} after {_PERIODS} periods")
    return "\n".join([*lines, *(f"file         {name}" for name in told["files"])])


def _of_scene(
    scene: Scene, coordinate: str, period: float
) -> tuple[PhaseSystem, PhaseSystem | None, tuple[str, str], float, tuple[float, float]]:
    """The system, the same under its periodic excitation, names of the axes, reach and start."""
    parameters = scene.all_parameters
    if scene.fmu.model == EQUATION:
        return _of_equation(parameters, period)
    if scene.fmu.model not in MODELS:
        raise ValueError(f"there is no portrait of {scene.fmu.model}")
    return _of_model(build(scene.fmu.model, parameters), parameters, coordinate)


def _of_equation(
    parameters: Mapping[str, Value], period: float
) -> tuple[PhaseSystem, PhaseSystem | None, tuple[str, str], float, tuple[float, float]]:
    function, _ = function_of(str(parameters["equation"]))
    system = computed.PhaseSystem(function)
    start = float(parameters["displacement_start"]), float(parameters["velocity_start"])
    forced = replace(system, period=period) if period else None
    return system, forced, ("x", "x'"), max(_REACH, 1.1 * abs(start[0])), start


def _of_model(
    system: System, parameters: Mapping[str, Value], coordinate: str
) -> tuple[PhaseSystem, PhaseSystem | None, tuple[str, str], float, tuple[float, float]]:
    """A section in which one coordinate moves; on a sinusoidal road also once in each period."""
    names = list(system.coordinates)
    name = (coordinate or names[0]).removesuffix("_displacement")
    if name not in names:
        raise ValueError(
            f"coordinate {coordinate!r} is not known{nearest(name, names)}; there are "
            f"{', '.join(names)}"
        )
    section = computed.of_coordinate(system, names.index(name))
    forced = None
    if len(names) == 1 and system.axles and parameters.get("road.shape") == "sine":
        road = system.signals[system.axles[0].road]
        begin = float(parameters["road.start"]) / float(parameters["speed"])
        forced = replace(
            section,
            function=lambda v, x, t: section.function(v, x, t) + road.derivatives(begin + t)[2],
            period=float(parameters["road.length"]) / float(parameters["speed"]),
        )
    words = name.replace("_", " ")
    what = f"{words} displacement" if len(names) > 1 else "deflection"
    labels = (f"{what} [m]", "its rate [m/s]")
    return section, forced, labels, _PART, (0.0, 0.0)
