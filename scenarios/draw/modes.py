"""The modes of scenes: frequencies, damping, shapes, and their phase planes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.variables import MODELS

from phaseplane import figures
from phaseplane.equations.typeset import number

from ..errors import InputError, blaming
from ..look import FigureFile
from ..measures.linearised import about_rest
from ..scene.equation import EQUATION
from ..scene.loading import load_scene

if TYPE_CHECKING:
    from ..measures.modal_planes import ModalPlanes

_ROUNDING = 1e-9  # of the largest part of a shape


def modes(reference: str, overrides: Sequence[str], figure: FigureFile | None) -> dict[str, Any]:
    """Return the modes of a scene's model about rest, and draw their planes if `figure` is given.

    Raises
    ------
    InputError : if the scene has no modes.
    """
    from ..measures.modal_planes import modal_planes  # noqa: PLC0415  (scipy)

    scene = load_scene(reference, overrides, expect=False)
    if scene.fmu.model not in MODELS:
        what = (
            "an equation has no modes; 'phaseplane portrait' shows its equilibria"
            if scene.fmu.model == EQUATION
            else f"{scene.fmu.model} is not a model of this package"
        )
        raise InputError(f"modes of {scene.name}: {what}")
    with blaming(f"modes of {scene.name}"):
        system = about_rest(scene.fmu.model, scene.all_parameters)
    found, why_damped = None, ""
    try:
        found = modal_planes(system)
    except ValueError as error:  # there are damped modes alone
        if figure is not None:
            raise InputError(
                f"modes of {scene.name}: {error}; without --figure the damped modes are listed"
            ) from None
        why_damped = str(error)
    modes = [] if found is None else _undamped(found)
    title = scene.title or scene.name
    if scene.controller is not None:
        title = f"{title}; without the controller"
    files = []
    if figure is not None and found is not None:
        names = [
            f"mode {i}: {number(one['frequency'], 4)} Hz, ξ = {number(one['damping_ratio'], 3)}"
            for i, one in enumerate(modes, 1)
        ]
        motions = [found.free(i) for i in range(len(modes))]
        files = figure.save(figures.modal_planes(motions, names, title=title, look=figure.look))
    return {
        "title": title,
        "modes": modes,
        "proportional": found is not None and found.proportional,
        "damped": [asdict(mode) for mode in system.modes()],
        "why_damped": why_damped,
        "files": files,
    }


def _undamped(found: ModalPlanes) -> list[dict[str, Any]]:
    modes = []
    for i, omega in enumerate(found.angular_frequencies.tolist()):
        shape = found.shapes[:, i] / found.shapes[abs(found.shapes[:, i]).argmax(), i]
        shape[abs(shape) < _ROUNDING] = 0.0
        modes.append(
            {
                "frequency": omega / (2.0 * pi),
                "angular_frequency": omega,
                "damping_ratio": float(found.damping_ratios[i]),
                "shape": dict(zip(found.coordinates, shape.tolist(), strict=True)),
            }
        )
    return modes


def _damped(mode: Mapping[str, float]) -> str:
    """Return the frequency at which a damped mode oscillates, and its damping ratio."""
    ratio = mode["damping_ratio"]
    frequency = mode["frequency"] * sqrt(max(0.0, 1.0 - ratio * ratio))
    return f"{frequency:.6g} Hz, {ratio:.4g}"


def format_modes(summary: Mapping[str, Any]) -> str:
    """Return the modes as text for a terminal."""
    lines = [summary["title"], ""]
    for i, one in enumerate(summary["modes"], 1):
        shape = ", ".join(
            f"{name or 'displacement'} {part:.4g}" for name, part in one["shape"].items() if part
        )
        lines.append(
            f"mode {i}   {one['frequency']:.6g} Hz ({one['angular_frequency']:.6g} rad/s), damping ratio "
            f"{one['damping_ratio']:.4g}; {shape}"
        )
    if not summary["proportional"]:
        damped = "; ".join(map(_damped, summary["damped"]))
        if summary["modes"]:
            lines += ["", f"the damping couples these modes; damped, they oscillate at {damped}"]
        else:
            lines.append(f"damped modes, as {summary['why_damped']}: {damped}")
    return "\n".join([*lines, *(f"file     {name}" for name in summary["files"])])
