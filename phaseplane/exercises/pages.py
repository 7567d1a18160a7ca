"""Constructions as web pages that need only a browser: stage by stage, or a sheet to click on."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from importlib.resources import files
from math import ceil
from typing import Any

from phaseplane.constructions.letters import axis_letter, typeset
from phaseplane.constructions.primitives import Axis, Drawing, Plane
from phaseplane.constructions.sheet import arc_points, round_step, way_of, with_turn_angles_at
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.equations.typeset import printed
from phaseplane.exercises.protocol import display, excitations, protocol
from phaseplane.exercises.readings import columns

_ASSETS = files("phaseplane.exercises") / "assets"
_LOWEST = "PQADBCH"  # the points of the planes by their first letters
_GAP = 0.015  # m of paper between the planes and the turn angle
_ROUNDED = 4  # digits of cm


def sheet_data(drawing: Drawing, steps: int | None = None) -> dict[str, Any]:
    """Return a drawing as plain data for a page: lengths in cm of paper, y upwards.

    Parameters
    ----------
    steps : the first so many; all if None
    """
    drawing = gathered(drawing, steps)
    frames = drawing.frames[:steps]
    entries = protocol(drawing, steps)
    return {
        "title": typeset(drawing.title),
        "planes": [_plane(plane) for plane in drawing.planes],
        "axes": [_axes(plane, drawing, frames) for plane in drawing.planes],
        "curves": [
            {"role": curve.role, "label": typeset(curve.label), "points": _points(curve.vertices)}
            for curve in drawing.curves
        ],
        "steps": [
            {
                "step": frame.step,
                "time": frame.time,
                "event": frame.event.replace("_", " "),
                "stages": list(_stages(drawing, frame)),
                "state": _points([frame.points[plane.state] for plane in drawing.planes]),
                "ways": [
                    _points(way_of(plane, drawing.schemes[frame.scheme], frame))
                    for plane in drawing.planes
                ],
            }
            for frame in frames
        ],
        "protocol": [
            [
                e.step,
                e.stage,
                e.point,
                "" if e.length is None else f"{e.length:.2f}",
                printed(e.value),
            ]
            for e in entries
        ],
    }


def gathered(drawing: Drawing, steps: int | None = None) -> Drawing:
    """Return a drawing with its turn angles just below the planes, wherever they were.

    Parameters
    ----------
    steps : the first so many, below which they are; all if None
    """
    frames = drawing.frames[:steps]
    planes = [z for frame in frames for name, z in frame.points.items() if name[0] in _LOWEST] + [
        z for c in drawing.curves if c.role == "trail" for z in c.vertices
    ]
    if not planes:
        return drawing
    lowest = min(z.imag for z in planes)
    corner = complex(min(z.real for z in planes), lowest - _GAP)
    curves, moved = with_turn_angles_at(corner, drawing, drawing.frames, lowest - _GAP / 2.0)
    return replace(drawing, curves=curves, frames=StoredFrames(moved))


def protocol_page(drawing: Drawing) -> str:
    """Return a page that shows a construction stage by stage, with its protocol."""
    return _page(drawing.title, {"mode": "protocol", **sheet_data(drawing)})


def exercise_page(drawing: Drawing, steps: int) -> str:
    """Return a page with the sheet of an exercise: points are clicked, and saved as readings."""
    whole = sheet_data(drawing, steps)
    first, names = whole["steps"][0], columns(drawing.planes)
    shown = {
        **whole,
        "mode": "exercise",
        "columns": names,
        "heads": [typeset(name) for name in names[: 1 + 2 * len(drawing.planes)]],
        "start": first["state"],
        "count": steps,
        "given": list(_given(drawing)),
        # nothing that gives the solution away
        "steps": [],
        "protocol": [],
        "curves": [c for c in whole["curves"] if c["role"] != "trail"],
    }
    return _page(drawing.title, shown)


def _given(drawing: Drawing) -> Iterator[str]:
    """Yield what each step is made with: its end in time, and what is laid off for the drive."""
    laid_off, unit = excitations(drawing), display(drawing.planes[0].displacement)[1]
    for i, frame in enumerate(drawing.instants[1:]):
        lengths = (
            f"{typeset(name)} = {column[i]} {unit}".rstrip()
            for name, column in laid_off.items()
            if column[i]
        )
        yield ", ".join([f"t = {frame.time:.6g} s", *lengths])


def asset(name: str) -> str:
    """Return a file of the pages."""
    return (_ASSETS / name).read_text(encoding="utf-8")


def _page(title: str, data: dict[str, Any]) -> str:
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(typeset(title))}</title>\n<style>\n{asset('player.css')}</style>\n</head>\n"
        '<body>\n<main id="player"></main>\n'
        f"<script>\n{asset('player.js')}</script>\n"
        f'<script>\nphaseplanePlayer(document.getElementById("player"), {text});\n</script>\n'
        "</body>\n</html>\n"
    )


def _plane(plane: Plane) -> dict[str, Any]:
    factor, unit = display(plane.displacement)
    return {
        "number": plane.number,
        "name": axis_letter(plane.displacement.label),
        "velocity": axis_letter(plane.scaled_velocity.label),
        "unit": unit,
        "origin": _points([plane.displacement.origin])[0],
        "sense": plane.displacement.direction.real,
        "scale": 100.0 * plane.displacement.scale / factor,
        "rise": 100.0 * plane.scaled_velocity.scale / factor,
    }


def _axes(plane: Plane, drawing: Drawing, frames: Sequence[Frame]) -> dict[str, Any]:
    """Return both axes of a plane over the range of its motion, with round values."""
    points = [frame.points[plane.state] for frame in frames]
    points += [frame.points[plane.state + "'"] for frame in frames]
    points += [z for c in drawing.curves if c.role == "trail" for z in c.vertices]
    feet = [frame.points[plane.foot] for frame in frames]  # on the displacement's axis
    return {
        "x": _axis(plane.displacement, [*points, *feet]),
        "v": _axis(plane.scaled_velocity, points),
    }


def _axis(axis: Axis, points: Sequence[complex]) -> dict[str, Any]:
    factor, unit = display(axis)
    values = [factor * axis.read(p) for p in points]
    low, high = min(0.0, *values), max(0.0, *values)
    room = 0.12 * ((high - low) or 1.0)
    interval = round_step((high - low) or 1.0, 6)
    first, last = ceil((low - room) / interval), int((high + room) // interval)
    return {
        "label": axis_letter(axis.label) + (f" in {unit}" if unit else ""),
        "ends": _points([axis.at((low - room) / factor), axis.at((high + room) / factor)]),
        "ticks": [
            [*_points([axis.at(i * interval / factor)])[0], f"{i * interval:.6g}"]
            for i in range(first, last + 1)
        ],
    }


def _stages(drawing: Drawing, frame: Frame) -> Iterator[dict[str, Any]]:
    scheme = drawing.schemes[frame.scheme]
    for stage, words in enumerate(scheme.stages):
        yield {
            "words": typeset(words),
            "marks": [
                [m.role, typeset(m.label or m.point), *_points([frame.points[m.point]])[0]]
                for m in scheme.marks
                if m.stage == stage and m.point in frame.points
            ],
            "lines": [
                [s.role, _points([frame.points[s.start], frame.points[s.end]])]
                for s in scheme.strokes
                if s.stage == stage and {s.start, s.end} <= frame.points.keys()
            ]
            + [
                [a.role, _points(arc_points(frame, a))]
                for a in scheme.arcs
                if a.stage == stage and {a.centre, a.start, a.end} <= frame.points.keys()
            ],
        }


def _points(points: Sequence[complex]) -> list[list[float]]:
    return [
        [round(100.0 * z.real, _ROUNDED) + 0.0, round(100.0 * z.imag, _ROUNDED) + 0.0]
        for z in points
    ]
