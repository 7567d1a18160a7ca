"""Constructions and single runs for a web page: requests and answers as plain data.

Only the standard library is imported, so that it works in a browser, too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.roads.extent import LENGTH
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import Value

from phaseplane import exercises
from phaseplane.constructions.rules import RULES
from phaseplane.equations.motion import motion

from ..errors import InputError, one_line
from ..scene.equation import EQUATION, check_equation, formula_of, start_of
from ..scene.fmus import Fmu, find_fmu
from ..scene.layers import case_titles, find_scene, given_layers, overlay, read_layers
from ..toml_files import in_si
from .constructions import draw_construction
from .planes import CONSTRUCTED, planes_of

if TYPE_CHECKING:
    from phaseplane.constructions.primitives import Drawing

OWN = "own"
"""The name of a scene that is an equation of the user's own."""

_MOST_STEPS = 400
_POINTS = 401  # of a run
_DEFAULTS: dict[str, Any] = {
    "rule": "delta", "step": 2.5e-3, "plane_distance": 0.25, "plane_scales": None, "starts": (),
}  # fmt: skip


def catalogue() -> dict[str, Any]:
    """Return the scenes that can be constructed by their steps, with their titles, and the rules."""
    scenes = {OWN: "Your own equation"}
    for name, title in case_titles().items():
        if read_layers(find_scene(name)).tables().get("fmu") in CONSTRUCTED:
            fields = described(name)
            try:
                drawn({"scene": name, **fields, "duration": fields["step"]})
            except ValueError:  # too long a step, and no shorter one would do: a wheel of 1 g
                continue
            scenes[name] = title
    return {"scenes": scenes, "rules": list(RULES)}


def described(name: str) -> dict[str, Any]:
    """Return the settings of a scene, as the page shows them in its fields.

    Raises
    ------
    InputError : if there is no such scene.
    """
    if name == OWN:
        return {"equation": "x + 0.3*sign(v)", "settings": "displacement_start = 2.0", "rule": "delta",
                "step": "0.2", "duration": "12"}  # fmt: skip
    tables = read_layers(find_scene(name)).tables()
    drawn = {**_DEFAULTS, **tables.get("construction", {})}
    parameters = tables.get("parameters", {})
    step = _seconds(drawn["step"], "step")
    duration = _seconds(drawn.get("duration") or tables["duration"], "duration")
    return {
        "equation": str(parameters.get("equation", "")),
        "settings": "\n".join(
            f"{key} = {_toml(value)}" for key, value in parameters.items() if key != "equation"
        ),
        "rule": drawn["rule"],
        "step": f"{step:g}",
        "duration": f"{min(duration, _MOST_STEPS * step):g}",
    }


def answered(request: str) -> str:
    """Return the answer to a request, both JSON: what is shown, or `error` in one line.

    Parameters
    ----------
    request : `what` (sheet, run, catalogue or scene), `scene`, and the fields of `described`
    """
    asked = json.loads(request)
    try:
        match asked["what"]:
            case "catalogue":
                found = catalogue()
            case "scene":
                found = described(asked["scene"])
            case "run":
                found = _ran(asked)
            case _:
                found = exercises.sheet_data(drawn(asked))
        return json.dumps(found, ensure_ascii=False, allow_nan=False)
    except (ArithmeticError, ValueError, InputError) as error:
        return json.dumps({"error": one_line(str(error))})


def drawn(asked: Mapping[str, Any]) -> Drawing:
    """Return the construction that is asked for.

    Raises
    ------
    InputError, ValueError : if a field cannot be used.
    ArithmeticError : if the construction diverges.
    """
    fmu, parameters, settings = _read(asked)
    duration = _seconds(asked["duration"], "duration")
    settings["rule"] = asked["rule"]
    settings["step"] = _seconds(asked["step"], "step")
    if duration / settings["step"] > _MOST_STEPS:
        raise InputError(
            f"{duration / settings['step']:.0f} steps; this page draws at most {_MOST_STEPS}: take a "
            "longer step or a shorter duration"
        )
    return draw_construction(fmu.model, parameters, settings, duration)


def _ran(asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return the motion from the numerical solution, in the coordinates of the planes."""
    fmu, parameters, settings = _read(asked)
    duration = _seconds(asked["duration"], "duration")
    times = [duration * i / (_POINTS - 1) for i in range(_POINTS)]
    if fmu.model == EQUATION:
        found = motion(formula_of(parameters).switching, start_of(parameters), times)
        columns: dict[str, list[float]] = {"x": found.displacements, "x'": found.velocities}
        return {"time": found.times, "columns": columns, "unit": "", "note": found.complaint}
    planes = planes_of(fmu.model, parameters, settings)
    names = [plane.name for plane in planes.planes]
    if fmu.model == "OneDof":
        names = ["body_displacement"]
    made = simulate(fmu.model, parameters, times, names)
    return {
        "time": times,
        "columns": {
            name.replace("_", " "): [100.0 * float(v) for v in made[name]] for name in names
        },
        "unit": "cm",
        "note": "",
    }


def _read(asked: Mapping[str, Any]) -> tuple[Fmu, dict[str, Value], dict[str, Any]]:
    """Return model, parameters in SI and the settings of the construction."""
    if asked["scene"] == OWN:
        layers = given_layers({"fmu": EQUATION}, "page")
    else:
        layers = read_layers(find_scene(asked["scene"]))
    own = [line for line in asked.get("settings", "").splitlines() if line.strip()]
    overlay(layers, own)
    if asked.get("equation"):
        layers.put({"parameters.equation": asked["equation"]}, "equation", Path())
    tables = layers.tables()
    given = tables.get("parameters", {})
    fmu = find_fmu(str(tables["fmu"]), None, given)
    checked = {name: fmu.checked(name, raw) for name, raw in given.items()}
    if fmu.model == EQUATION:
        check_equation(checked)
    parameters = {name: v.start for name, v in fmu.parameters().items()} | checked
    if LENGTH not in checked:
        parameters.pop(LENGTH, None)
    settings = {**_DEFAULTS, **tables.get("construction", {})}
    settings["plane_distance"] = in_si(settings["plane_distance"], "m")
    return fmu, parameters, settings


def _seconds(value: object, name: str) -> float:
    seconds = in_si(value, "s")
    if not 0.0 < seconds < 1e6 * pi:
        raise InputError(f"{name} = {value!r}: must be a time above 0, such as 0.1 or '2.5 ms'")
    return seconds


def _toml(value: object) -> str:
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)
