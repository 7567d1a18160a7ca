"""Phase portraits of scenes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.models import build
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import MODELS, Value

from phaseplane import figures
from phaseplane import portrait as computed
from phaseplane.picture.text import bracketed

from ..errors import blaming
from ..look import FigureFile
from ..scene.equation import EQUATION, formula_of, start_of
from ..scene.loading import load_scene

if TYPE_CHECKING:
    from phaseplane.suspension.signals import Segment
    from phaseplane.suspension.systems import System

    from phaseplane.portrait import PhaseSystem, Portrait

    from ..scene.schema import Scene

_OF_EQUATION = ("displacement", "x")
_REACH = 3.0  # of an equation, unless it starts farther out
_PART = 0.1  # m, of a vehicle
_PERIODS = 100
_OF_CYCLE = ("crossing", "period", "multiplier", "attracts", "kind")


@dataclass(frozen=True, slots=True)
class _Subject:
    """The subject of a portrait."""

    system: PhaseSystem  # with its periodic forcing if there is one
    words: tuple[str, str]  # of the axes
    units: tuple[str, str]
    reach: float  # least half-width of the window, in the coordinate's unit
    start: tuple[float, float] = (0.0, 0.0)  # of the Poincaré section: displacement and rate
    held: tuple[str, ...] = ()  # names of the coordinates that rest while one moves
    loaded: bool = False  # whether there are loads, which the portrait of free motion omits

    @property
    def labels(self) -> tuple[str, str]:
        """The labels of the axes."""
        x, v = (words + bracketed(unit) for words, unit in zip(self.words, self.units, strict=True))
        return x, v


def portrait(
    reference: str,
    overrides: Sequence[str],
    figure: FigureFile | None,
    *,
    coordinate: str = "",
    window: Sequence[float] | None = None,
    period: float | None = None,
    frozen: float | None = None,
) -> dict[str, Any]:
    """Compute the phase portrait of a scene, and draw it if `figure` is given.

    Parameters
    ----------
    coordinate : the coordinate that moves while the others rest at zero; the first if empty
    window : left, right, bottom, top; automatic if None
    period : forcing period of an equation, s; found in the equation if None
    frozen : draw a forced system with its forcing frozen at this time, s; if None, draw its section

    Returns
    -------
    The window, equilibria, limit cycles and attractors of the section, as plain data.

    Raises
    ------
    InputError : if the scene has no portrait, or the coordinate or the window is not valid.
    """
    scene = load_scene(reference, overrides, expect=False)
    with blaming(f"portrait of {scene.name}", ValueError):
        subject = _of_scene(scene, coordinate, period)
        system = subject.system
        with np.errstate(all="ignore"):  # motions that diverge, forces beyond the largest number
            starts = (subject.start, *scene.construction.starts)
            still = system if frozen is None else system.frozen(frozen)
            if window:
                shown = computed.Window(*window)
            else:
                shown = computed.window_of(still, subject.reach, starts)
            made = computed.compute_portrait(
                system, shown, starts=starts, periods=_PERIODS, frozen=frozen, fits=not window
            )
        if made.section is not None and not window:
            made = replace(made, window=computed.fitted_window(made.section, shown, system.turn))
    title = _title(scene, subject, made)
    files = []
    if figure is not None:
        files = figure.save(
            figures.portrait(made, labels=subject.labels, title=title, look=figure.look)
        )
    return {
        "title": title,
        "coordinate": subject.labels[0],
        "units": [unit.removeprefix("1") for unit in subject.units],
        **_as_data(made),
        "files": files,
    }


def _title(scene: Scene, subject: _Subject, made: Portrait) -> str:
    """Return the title of a portrait: the scene, and what is left out or held."""
    title = scene.title or scene.name
    if scene.fmu.model == EQUATION:
        title += f": {formula_of(scene.all_parameters).words}"
    elif subject.held:
        title += f"; {', '.join(subject.held)} held at rest"
    if subject.loaded:
        title += "; without loads"
    if scene.controller is not None:
        title += "; without the controller"
    if made.frozen is not None and subject.system.driven:
        title += f", frozen at t = {made.frozen:g} s"
    elif made.section is not None:
        title += ": Poincaré section, once per forcing period"
    return title


def _as_data(made: Portrait) -> dict[str, Any]:
    window = made.window
    return {
        "window": [window.left, window.right, window.bottom, window.top],
        "equilibria": [
            {"x": at.x, "kind": at.kind, "on_corner": at.on_corner}
            | ({"until": at.until} if at.stretches else {})
            for at in made.equilibria
        ],
        "cycles": [{name: getattr(c, name) for name in _OF_CYCLE} for c in made.cycles],
        "section": None if made.section is None else {
            "period": made.section.period,
            "transient": made.section.transient,
            "periods": made.section.periods,
            "attractors": [states.tolist() for states in made.section.attractors],
        },
    }  # fmt: skip


def format_portrait(summary: Mapping[str, Any]) -> str:
    """Return the portrait as text for a terminal."""
    left, right, bottom, top = summary["window"]
    x_unit, v_unit = (f" {unit}".rstrip() for unit in summary["units"])
    lines = [
        summary["title"],
        f"window       {left:.4g} to {right:.4g}{x_unit}, {bottom:.4g} to {top:.4g}{v_unit}",
        *(f"equilibrium  {_place(at)}{x_unit}: {at['kind']}" for at in summary["equilibria"]),
        *(
            f"limit cycle  crosses the axis at {c['crossing']:.6g}{x_unit}, period {c['period']:.6g} s, "
            f"{c['kind']}"
            for c in summary["cycles"]
        ),
    ]
    if summary["section"] is not None:
        lines += _format_section(summary["section"], x_unit, v_unit)
    return "\n".join([*lines, *(f"file         {name}" for name in summary["files"])])


def _place(at: Mapping[str, Any]) -> str:
    return f"{at['x']:.6g} to {at['until']:.6g}" if "until" in at else f"{at['x']:.6g}"


def _format_section(summary: Mapping[str, Any], x_unit: str, v_unit: str) -> list[str]:
    """Return the section of a forced system and its periodic attractors, in lines."""
    kept = f"{summary['periods']} states of each motion"
    after = f" after {summary['transient']} periods" if summary["transient"] else ""
    lines = [f"section      once per forcing period, {summary['period']:.6g} s: {kept}{after}"]
    for states in summary["attractors"]:
        x, v = states[-1]
        m = len(states)
        every = "one forcing period" if m == 1 else f"{m} forcing periods"
        lines.append(
            f"attractor    motion with a period of {every}, at {x:.6g}{x_unit}, {v:.6g}{v_unit}"
        )
    return lines


def _of_scene(scene: Scene, coordinate: str, period: float | None) -> _Subject:
    parameters = scene.all_parameters
    if scene.fmu.model == EQUATION:
        if coordinate not in ("", *_OF_EQUATION):
            raise ValueError(f"coordinate {coordinate!r}: an equation has only displacement")
        return _of_equation(parameters, period)
    if period:
        raise ValueError("--period is for equations only; a vehicle takes the period of its road")
    if scene.fmu.model not in MODELS:
        raise ValueError(f"there is no portrait of {scene.fmu.model}")
    outputs = scene.fmu.outputs()
    angles = {name for name in outputs if outputs[name].unit == "rad"}
    return _of_model(build(scene.fmu.model, parameters), parameters, coordinate, angles)


def _of_equation(parameters: Mapping[str, Value], period: float | None) -> _Subject:
    formula = formula_of(parameters)
    found = period or formula.period
    if found is None:
        raise ValueError(
            "the equation has no recognisable forcing period; give it with --period, or use --frozen TIME"
        )
    jumps = formula.switching.jumps
    system = computed.PhaseSystem(
        formula.function,
        period=found,
        on_arrays=formula.on_arrays,
        switching=formula.switching if jumps else None,
    )
    if system.repeats(2.0 * pi):
        system = replace(system, turn=2.0 * pi)
    unit = str(parameters["unit"])
    units = (unit, "1" if unit == "1" else f"{unit}/s")
    return _Subject(system, ("x", "x'"), units, _REACH, start_of(parameters))


def _of_model(
    system: System, parameters: Mapping[str, Value], coordinate: str, angles: Collection[str]
) -> _Subject:
    """Return a subject with one moving coordinate; a sine road forces one degree of freedom."""
    names = list(system.coordinates)
    name = (coordinate or names[0]).removesuffix("_displacement")
    if name not in names:
        raise ValueError(
            f"coordinate {coordinate!r} is not known; coordinates are {', '.join(names)}"
            + nearest(name, names)
        )
    section = computed.of_coordinate(system, names.index(name))
    if len(names) == 1 and system.axles and parameters.get("road.shape") == "sine":
        section = _on_waves(section, system.signals[system.axles[0].road].segments[-1])
    words = name.replace("_", " ")
    unit = "rad" if f"{name}_displacement" in angles else "m"
    what, rate = (f"{words} displacement", f"{words} velocity")
    if len(names) == 1 and system.axles:
        what, rate = "deflection", "deflection rate"
    held = tuple(other.replace("_", " ") for other in names if other != name)
    loaded = any(system.signals[load.signal].scale for load in system.loads)
    return _Subject(section, (what, rate), (unit, f"{unit}/s"), _PART, held=held, loaded=loaded)


def _on_waves(still: PhaseSystem, wave: Segment) -> PhaseSystem:
    """Return the system on a sinusoidal road, y'' + f = -xi'', from the road's start on."""
    (phase, speed, _), size = wave.phase, wave.amplitude

    def function(v: float, x: float, t: float) -> float:
        return still.function(v, x, t) - size * speed**2 * cos(phase + speed * t)

    def on_arrays(v: Any, x: Any, t: Any) -> Any:
        return still.forces(x, v) - size * speed**2 * np.cos(phase + speed * t)

    return replace(still, function=function, on_arrays=on_arrays, period=2.0 * pi / abs(speed))
