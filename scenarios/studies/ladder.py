"""The model ladder: the smallest system that serves a scene, found by running them all.

From the half car with four degrees of freedom down to one degree (AP57 section 2): what never acts can
go; with M3 = 0 the axles do not feel each other; where the excitation is well below the wheels' own
frequency the tyres are rigid. Each rung is argued so, then checked against the scene as it stands.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.models import axle_masses, build
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import MODELS, Value

from ..errors import InputError, RunError, one_line
from ..measures.solution import instants, refinement
from ..results.comparison import compared
from ..results.report import aligned

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from phaseplane.suspension.systems import System

    from ..scene.schema import Scene

    Columns = dict[str, npt.NDArray[np.float64]]

_REPEATS = 3
# Compared unless the scene names its outputs: how the body moves, and the suspension.
_COMPARED = ("body_displacement", "body_velocity", "body_acceleration", "suspension_deflection")
_ACTS: dict[str, tuple[str, Value, str]] = {  # parameter, its value when off, the output that tells
    "lift-off": ("lift_off", False, "lift_off_count"),
    "bump stop": ("bump_stop.stiffness", 0.0, "bump_stop_force"),
    "rebound stop": ("rebound_stop.stiffness", 0.0, "rebound_stop_force"),
    "friction": ("friction", 0.0, "friction_force"),
}


@dataclass(frozen=True, slots=True)
class Part:
    """One model of a rung, and where its outputs belong.

    Parameters
    ----------
    model : of this project
    parameters : in SI
    prefix : before the names of its outputs
    """

    model: str
    parameters: Mapping[str, Value]
    prefix: str = ""


@dataclass(frozen=True, slots=True)
class Rung:
    """A way to model the scene.

    Parameters
    ----------
    name : what it is called
    parts : one model, or one for each axle
    degrees : of freedom in all
    argument : why it may serve
    """

    name: str
    parts: tuple[Part, ...]
    degrees: int
    argument: str


def ladder(scene: Scene, tolerance: float) -> dict[str, Any]:
    """All rungs of a scene with their errors and times, and the smallest that serves.

    Parameters
    ----------
    scene : of a model of this project
    tolerance : largest error in the outputs compared, over their peaks

    Raises
    ------
    InputError : a model that has no smaller one, or an FMU that is not of this project.
    RunError : the scene itself does not run to its end.
    """
    if scene.fmu.path is not None or scene.fmu.model not in ("HalfCar", "HalfCarRigidTyres",
                                                             "QuarterCar"):  # fmt: skip
        raise InputError(
            f"{scene.fmu.model} has no smaller model; there is a ladder for HalfCar, "
            "HalfCarRigidTyres and QuarterCar"
        )
    names = _outputs_compared(scene)
    whole = Rung(
        "as it stands",
        (Part(scene.fmu.model, scene.all_parameters),),
        _DEGREES[scene.fmu.model],
        "",
    )
    try:
        truth, seconds = _run(whole, scene, (*names, *_telling(scene)))
    except Exception as error:
        raise RunError(f"{scene.name}: {one_line(error)}") from error
    rungs = [_told(whole, seconds, 0.0, "", tolerance)]
    for rung in _below(scene, truth):
        try:
            columns, seconds = _run(rung, scene, names)
            worst = compared(
                {n: c for n, c in truth.items() if n in (*names, "time")}, columns
            ).differences[0]
        except Exception as failure:
            rungs.append(_told(rung, None, None, one_line(failure), tolerance))
        else:
            lacking = [name for name in names if name not in columns]
            note = f"does not tell {', '.join(lacking)}" if lacking else f"worst in {worst.name}"
            rungs.append(_told(rung, seconds, None if lacking else worst.relative, note, tolerance))
    # of equal degrees the one further down, which has less in it
    best = min(reversed([rung for rung in rungs if rung["serves"]]), key=lambda r: r["degrees"])
    return {
        "scene": scene.name,
        "tolerance": tolerance,
        "compared": list(names),
        "rungs": rungs,
        "proposal": best["name"],
    }


_DEGREES = {"OneDof": 1, "QuarterCar": 2, "HalfCarRigidTyres": 2, "HalfCar": 4}


def _outputs_compared(scene: Scene) -> tuple[str, ...]:
    wanted = scene.show.outputs
    return tuple(
        name
        for name, output in scene.fmu.outputs().items()
        if type(output.start) is float
        and (name in wanted if isinstance(wanted, list) else name.endswith(_COMPARED))
        # the centre of gravity follows from the axles
        and (
            isinstance(wanted, list)
            or scene.fmu.model == "QuarterCar"
            or name[:4] in ("fron", "rear")
        )
    )


def _told(
    rung: Rung, seconds: float | None, error: float | None, note: str, tolerance: float
) -> dict[str, Any]:
    return {
        "name": rung.name,
        "models": [part.model for part in rung.parts],
        "degrees": rung.degrees,
        "argument": rung.argument,
        "seconds": seconds,
        "error": error,
        "note": note,
        "serves": error is not None and error <= tolerance,
    }


# -- rungs -----------------------------------------------------------------------------------------


def _below(scene: Scene, truth: Columns) -> Iterator[Rung]:
    """The smaller models, largest first."""
    model, p = scene.fmu.model, scene.all_parameters
    idle = {what: values for what, values in _off(p, truth) if values}
    if idle:
        p = {**p, **{name: value for values in idle.values() for name, value in values.items()}}
        words = ", ".join(idle)
        argument = f"{words}: never acts" if len(idle) == 1 else f"{words}: never act"
        yield Rung(f"without {words}", (Part(model, p),), _DEGREES[model], argument)
    if model != "QuarterCar":
        single = "QuarterCar" if model == "HalfCar" else "OneDof"
        yield _two(single, p, _coupling_words(p))
        if model == "HalfCar":
            rigid = _only("HalfCarRigidTyres", p)
            words = _frequency_words(model, p)
            yield Rung("rigid tyres", (Part("HalfCarRigidTyres", rigid),), 2, words)
            yield _two("OneDof", p, f"{_coupling_words(p)}; {words}")
    else:
        words = _frequency_words(model, p)
        yield Rung("rigid tyre", (Part("OneDof", _only("OneDof", p)),), 1, words)


def _off(p: Mapping[str, Value], truth: Columns) -> Iterator[tuple[str, dict[str, Value]]]:
    """What is there but never acts, with the parameters that switch it off."""
    for what, (switch, off, output) in _ACTS.items():
        names = [name for name in p if name in (switch, f"front.{switch}", f"rear.{switch}")]
        acts = any(column.any() for name, column in truth.items() if name.endswith(output))
        if not acts:
            yield what, {name: off for name in names if p[name] != off}


def _telling(scene: Scene) -> list[str]:
    ends = tuple(output for *_, output in _ACTS.values())
    return [name for name in scene.fmu.outputs() if name.endswith(ends)]


def _two(model: str, p: Mapping[str, Value], argument: str) -> Rung:
    """One model for each axle, each with the body's mass that rests on it."""
    a, b = float(p["cg_to_front"]), float(p["cg_to_rear"])
    late = {"road.start": float(p["road.start"]) + (a + b) / float(p["speed"])}
    parts = []
    for axle, arm, more in (("front", b, {}), ("rear", a, late)):
        own = {name.removeprefix(f"{axle}."): value for name, value in p.items()}
        own |= {name.replace(f"{axle}_", ""): v for name, v in p.items() if name.startswith("initial.")
                and f".{axle}_" in name}  # fmt: skip
        own |= {"sprung_mass": float(p["sprung_mass"]) * arm / (a + b), **more}
        parts.append(Part(model, _only(model, own), f"{axle}_"))
    name = "two quarter cars" if model == "QuarterCar" else "two of one degree"
    return Rung(name, tuple(parts), 2 * _DEGREES[model], argument)


def _only(model: str, p: Mapping[str, Value]) -> dict[str, Value]:
    """The parameters that the model has."""
    declared = {v.name for v in MODELS[model] if v.causality == "parameter"}
    return {name: value for name, value in p.items() if name in declared}


def _coupling_words(p: Mapping[str, Value]) -> str:
    front, rear, coupling = axle_masses(
        *(float(p[name]) for name in
          ("sprung_mass", "pitch_radius_of_gyration", "cg_to_front", "cg_to_rear"))
    )  # fmt: skip
    return f"M3 = {coupling:.3g} kg couples M1 = {front:.3g} and M2 = {rear:.3g} kg"


def _frequency_words(model: str, p: Mapping[str, Value]) -> str:
    """The excitation's frequency against half of the wheels' own, where both are known."""
    shape, speed = p["road.shape"], float(p["speed"])
    if shape not in ("bump", "obstacle", "sine"):
        return "AP57: the excitation must stay below half of the wheel's own frequency"
    excitation = speed / float(p["road.length"])
    own = min(_wheel_frequencies(build(model, p)))
    relation = "below" if excitation < 0.5 * own else "not below"
    return f"excitation of {excitation:.3g} Hz is {relation} half of the wheel's own {own:.3g} Hz"


def _wheel_frequencies(system: System) -> Iterator[float]:
    """Natural frequency of each wheel while the body is held, Hz, by the tangents at rest."""
    for i, name in enumerate(system.coordinates):
        if name.endswith("wheel"):
            stiffness = sum(e.direction[i] ** 2 * e.spring.tangent(0.0) for e in system.elements)
            yield sqrt(max(0.0, stiffness) / system.mass[i][i]) / (2.0 * pi)


# -- running ---------------------------------------------------------------------------------------


def _run(rung: Rung, scene: Scene, names: Sequence[str]) -> tuple[Columns, float]:
    """The outputs a rung can tell, under the scene's names, and its shortest time, s."""
    interval = scene.show.output_interval
    time = instants(scene.duration, interval, refinement(scene.duration, interval))
    columns: Columns = {"time": time}
    best = 0.0
    for part in rung.parts:
        own = {
            name: name.removeprefix(part.prefix)
            for name in names
            if name.startswith(part.prefix)
            and any(v.name == name.removeprefix(part.prefix) for v in MODELS[part.model])
        }
        taken = []
        for _ in range(_REPEATS):
            started = perf_counter()
            found = simulate(part.model, dict(part.parameters), time.tolist(), own.values())
            taken.append(perf_counter() - started)
        best += min(taken)
        columns |= {name: np.asarray(found[short], float) for name, short in own.items()}
    return columns, best


def ladder_in_words(told: Mapping[str, Any]) -> str:
    """The same for a terminal."""
    rows = [("rung", "degrees", "error", "time", "serves")]
    for rung in told["rungs"]:
        error = "" if rung["error"] is None else f"{rung['error']:.2g}"
        seconds = "" if rung["seconds"] is None else f"{1e3 * rung['seconds']:.2f} ms"
        rows.append(
            (rung["name"], str(rung["degrees"]), error, seconds, "yes" if rung["serves"] else "no")
        )
    lines = aligned(rows)
    for rung in told["rungs"]:
        words = [word for word in (rung["argument"], rung["note"]) if word]
        if words:
            lines.append(f"  {rung['name']}: {'; '.join(words)}")
    lines.append(f"to {told['tolerance']:g} of the peaks serves: {told['proposal']}")
    return "\n".join(lines)
