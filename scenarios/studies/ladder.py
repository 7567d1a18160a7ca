"""The model ladder: the smallest system that is accurate for a scene, found by running them all.

From the half car with four degrees of freedom down to one (AP57 section 2): elements that never act can
be left out; with M3 = 0 the axles are uncoupled; if the excitation is well below the wheels' natural
frequency, the tyres can be rigid. Each rung is justified in this way and compared with the full model.
A user-defined system cannot be simplified automatically, so the user names its smaller models.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import pi, sqrt
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.models import build, declared_parameters
from phaseplane.suspension.session import simulate
from phaseplane.suspension.two_axles import axle_masses
from phaseplane.suspension.variables import Value, outputs

from ..errors import InputError, RunError, one_line
from ..measures.solution import instants, refinement
from ..results.comparison import compared
from ..results.report import aligned
from ..scene.loading import check_systems

if TYPE_CHECKING:
    from phaseplane.suspension.systems import System

    from ..columns import Column, Columns
    from ..scene.schema import Scene


_REPEATS = 3
# Compared unless the scene names its outputs: the motion of the body, and the suspension.
_COMPARED = ("body_displacement", "body_velocity", "body_acceleration", "suspension_deflection")
_ACTS: dict[str, tuple[str, Value, str]] = {  # parameter, its value when off, output that shows it
    "lift-off": ("lift_off", False, "lift_off_count"),
    "bump stop": ("bump_stop.stiffness", 0.0, "bump_stop_force"),
    "rebound stop": ("rebound_stop.stiffness", 0.0, "rebound_stop_force"),
    "friction": ("friction", 0.0, "friction_force"),
}


@dataclass(frozen=True, slots=True)
class Part:
    """One model of a rung, with the prefix of its outputs.

    Parameters
    ----------
    model : a model of this package
    parameters : its parameters, SI
    prefix : prefix of its outputs in the scene
    """

    model: str
    parameters: Mapping[str, Value]
    prefix: str = ""


@dataclass(frozen=True, slots=True)
class Rung:
    """A way to model the scene.

    Parameters
    ----------
    name : name of the rung
    parts : one model, or one for each axle
    argument : why it may be accurate
    """

    name: str
    parts: tuple[Part, ...]
    argument: str = ""

    @property
    def degrees(self) -> int:
        """The degrees of freedom in all."""
        return sum(len(build(part.model, part.parameters).coordinates) for part in self.parts)


def ladder(scene: Scene, tolerance: float, smaller: Sequence[Scene] = ()) -> dict[str, Any]:
    """Return all rungs of a scene with their errors and times, and the smallest accurate one.

    Parameters
    ----------
    scene : a scene of a model of this package, or of a user-defined system
    tolerance : largest error of the outputs compared, over their peaks
    smaller : scenes of smaller models, which are run for the duration of `scene`

    Raises
    ------
    InputError : if there is no smaller model, a scene is not run by its model alone, two systems have
        one name, or the models have no output of motion in common.
    RunError : if the scene itself does not run to its end.
    """
    check_systems((scene, *smaller))
    for each in (scene, *smaller):
        _check(each)
    if scene.fmu.model not in _DESCENDS and not smaller:
        raise InputError(
            f"{scene.fmu.model} has no smaller model in the package; allowed: {', '.join(_DESCENDS)}, "
            f"or name the files of smaller models: phaseplane ladder {scene.given_as} SMALLER..."
        )
    names = _outputs_compared(scene, smaller)
    whole = _as_it_stands(scene, "unchanged")
    try:
        truth, seconds = _run(whole, scene, (*names, *_outputs_of_features(scene)))
    except Exception as error:
        raise RunError(f"{scene.name}: {error}") from error
    rungs = [_rung_data(whole, tolerance, seconds, 0.0)]
    named = (_as_it_stands(replace(s, duration=scene.duration), s.name) for s in smaller)
    wanted = {name: truth[name] for name in ("time", *names)}
    for rung in (*_below(scene, truth), *named):
        try:
            columns, seconds = _run(rung, scene, names)
            worst = compared(wanted, columns).differences[0]
        except Exception as failure:
            rungs.append(_rung_data(rung, tolerance, note=one_line(failure)))
            continue
        if lacking := [name for name in names if name not in columns]:
            note = f"has no {', '.join(lacking)}"
            rungs.append(_rung_data(rung, tolerance, seconds, note=note))
            continue
        size = "largest error" if worst.relative <= tolerance else "the error is too large"
        note = f"{size} in {worst.name}" if worst.relative else "no difference"
        rungs.append(_rung_data(rung, tolerance, seconds, worst.relative, note))
    # of rungs with equal degrees of freedom the lower one, which is simpler
    best = min(reversed([rung for rung in rungs if rung["serves"]]), key=lambda r: r["degrees"])
    return {
        "scene": scene.name,
        "tolerance": tolerance,
        "compared": list(names),
        "rungs": rungs,
        "proposal": best["name"],
    }


_DESCENDS = ("HalfCar", "HalfCarRigidTyres", "QuarterCar")
_MOTION = ("displacement", "velocity", "acceleration", "deflection")


def _check(scene: Scene) -> None:
    if not scene.fmu.in_package:
        raise InputError(
            f"{scene.name}: {scene.fmu.model} cannot be compared; allowed: models of this package, "
            "and systems in .toml or .py files"
        )
    scene.refuse_controller("the ladder runs")


def _as_it_stands(scene: Scene, name: str) -> Rung:
    return Rung(name, (Part(scene.fmu.model, scene.all_parameters),))


def _outputs_compared(scene: Scene, smaller: Sequence[Scene]) -> tuple[str, ...]:
    """Return the outputs the scene names, or else those of the motion that the models share."""
    wanted = scene.show.outputs
    numbers = [name for name, output in scene.fmu.outputs().items() if type(output.start) is float]
    if isinstance(wanted, tuple):
        names = [name for name in numbers if name in wanted]
    elif scene.fmu.model in _DESCENDS:
        # the centre of gravity of a half car follows from its axles
        axles = ("",) if scene.fmu.model == "QuarterCar" else ("front_", "rear_")
        names = [name for name in numbers if name.endswith(_COMPARED) and name.startswith(axles)]
    else:
        common = set(numbers).intersection(*(other.fmu.outputs() for other in smaller))
        names = [name for name in numbers if name in common and name.endswith(_MOTION)]
    if not names:
        raise InputError(
            f"{scene.name}: the models have no displacement, velocity, acceleration or deflection of "
            "the same name; give coordinates that describe the same motion the same name"
        )
    return tuple(names)


def _rung_data(
    rung: Rung,
    tolerance: float,
    seconds: float | None = None,
    error: float | None = None,
    note: str = "",
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


def _joined(names: Sequence[str]) -> str:
    """Return names in a row, the last one after `and`."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


# -- rungs -----------------------------------------------------------------------------------------


def _below(scene: Scene, truth: Columns) -> Iterator[Rung]:
    """Yield the smaller models of a model of this package, largest first."""
    model, p = scene.fmu.model, scene.all_parameters
    if model not in _DESCENDS:
        return
    idle = {what: values for what, values in _off(model, p, truth) if values}
    if idle:
        p = {**p, **{name: value for values in idle.values() for name, value in values.items()}}
        words = _joined(list(idle))
        argument = f"{words} never {'acts' if len(idle) == 1 else 'act'}"
        yield Rung(f"without {words}", (Part(model, p),), argument)
    if model != "QuarterCar":
        single = "QuarterCar" if model == "HalfCar" else "OneDof"
        yield _two(single, p, _format_coupling(p))
        if model == "HalfCar":
            rigid = _only("HalfCarRigidTyres", p)
            words = _format_frequency(model, p)
            yield Rung("rigid tyres", (Part("HalfCarRigidTyres", rigid),), words)
            yield _two("OneDof", p, f"{_format_coupling(p)}; {words}")
    else:
        words = _format_frequency(model, p)
        yield Rung("rigid tyre", (Part("OneDof", _only("OneDof", p)),), words)


def _off(
    model: str, p: Mapping[str, Value], truth: Columns
) -> Iterator[tuple[str, dict[str, Value]]]:
    """Yield the features that never act, with the parameters that switch them off."""
    system, end = build(model, p), truth["time"][-1]
    # where the road falls at an edge, a tyre that may lift off does not pull the wheel after it
    falls = any(
        0.0 <= time < end and height < 0.0
        for axle in system.axles
        for time, height in system.signals[axle.road].jumps
    )
    for what, (switch, off, output) in _ACTS.items():
        names = [name for name in p if name in (switch, f"front.{switch}", f"rear.{switch}")]
        acts = any(column.any() for name, column in truth.items() if name.endswith(output))
        if not acts and not (falls and what == "lift-off"):
            yield what, {name: off for name in names if p[name] != off}


def _outputs_of_features(scene: Scene) -> list[str]:
    ends = tuple(output for *_, output in _ACTS.values())
    return [name for name in scene.fmu.outputs() if name.endswith(ends)]


def _two(model: str, p: Mapping[str, Value], argument: str) -> Rung:
    """Return one model for each axle, each with the body's mass that rests on it."""
    a, b = float(p["cg_to_front"]), float(p["cg_to_rear"])
    late = {"road.start": float(p["road.start"]) + (a + b) / float(p["speed"])}
    parts = []
    for axle, arm, more in (("front", b, {}), ("rear", a, late)):
        own = {name.removeprefix(f"{axle}."): value for name, value in p.items()}
        own |= {name.replace(f"{axle}_", ""): v for name, v in p.items() if name.startswith("initial.")
                and f".{axle}_" in name}  # fmt: skip
        own |= {"sprung_mass": float(p["sprung_mass"]) * arm / (a + b), **more}
        parts.append(Part(model, _only(model, own), f"{axle}_"))
    name = "two quarter cars" if model == "QuarterCar" else "two single-mass models"
    return Rung(name, tuple(parts), argument)


def _only(model: str, p: Mapping[str, Value]) -> dict[str, Value]:
    """Return the parameters that the model has."""
    return {name: value for name, value in p.items() if name in declared_parameters(model)}


def _format_coupling(p: Mapping[str, Value]) -> str:
    front, rear, coupling = axle_masses(
        *(float(p[name]) for name in
          ("sprung_mass", "pitch_radius_of_gyration", "cg_to_front", "cg_to_rear"))
    )  # fmt: skip
    return f"coupling mass M3 = {coupling:.3g} kg, with M1 = {front:.3g} and M2 = {rear:.3g} kg"


def _format_frequency(model: str, p: Mapping[str, Value]) -> str:
    """Return the excitation frequency compared with half the wheels' natural frequency, in words."""
    shape, speed = p["road.shape"], float(p["speed"])
    if shape not in ("bump", "obstacle", "sine"):
        return "AP57's condition: excitation below half the wheel's natural frequency"
    excitation = speed / float(p["road.length"])
    own = min(_wheel_frequencies(build(model, p)))
    holds, relation = ("holds", "below") if excitation < 0.5 * own else ("fails", "not below")
    return (
        f"AP57's condition {holds}, as excitation at {excitation:.3g} Hz is {relation} half the wheel's "
        f"natural frequency, {own:.3g} Hz"
    )


def _wheel_frequencies(system: System) -> Iterator[float]:
    """Yield the natural frequency of each wheel with the body held, Hz, by the tangents at rest."""
    for i, name in enumerate(system.coordinates):
        if name.endswith("wheel"):
            stiffness = sum(e.direction[i] ** 2 * e.spring.tangent(0.0) for e in system.elements)
            yield sqrt(max(0.0, stiffness) / system.mass[i][i]) / (2.0 * pi)


# -- running ---------------------------------------------------------------------------------------


def _run(rung: Rung, scene: Scene, names: Sequence[str]) -> tuple[Columns, float]:
    """Return the outputs of a rung under the scene's names, and its shortest run time, s."""
    interval = scene.show.output_interval
    time = instants(scene.duration, interval, refinement(scene.duration, interval))
    columns: dict[str, Column] = {"time": time}
    best = 0.0
    for part in rung.parts:
        own = {
            name: name.removeprefix(part.prefix)
            for name in names
            if name.startswith(part.prefix)
            and name.removeprefix(part.prefix) in outputs(part.model)
        }
        taken = []
        for _ in range(_REPEATS):
            started = perf_counter()
            found = simulate(part.model, dict(part.parameters), time.tolist(), own.values())
            taken.append(perf_counter() - started)
        best += min(taken)
        columns |= {name: np.asarray(found[short], float) for name, short in own.items()}
    return columns, best


def format_ladder(summary: Mapping[str, Any]) -> str:
    """Return the ladder as text for a terminal."""
    rows = [("model", "DOF", "error", "time", "accurate")]
    for rung in summary["rungs"]:
        error = "" if rung["error"] is None else f"{rung['error']:.2g}"
        seconds = "" if rung["seconds"] is None else f"{1e3 * rung['seconds']:.2f} ms"
        rows.append(
            (rung["name"], str(rung["degrees"]), error, seconds, "yes" if rung["serves"] else "no")
        )
    lines = aligned(rows)
    for rung in summary["rungs"]:
        words = [word for word in (rung["argument"], rung["note"]) if word]
        if words:
            lines.append(f"  {rung['name']}: {'; '.join(words)}")
    lines.append(
        f"smallest model accurate to {summary['tolerance']:g} of the peaks: {summary['proposal']}"
    )
    return "\n".join(lines)
