"""The protocol of a construction: every point in the order of drawing, its construction, its place."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from math import ceil, hypot, log10

from phaseplane.constructions.letters import axis_letter, typeset
from phaseplane.constructions.primitives import Axis, Drawing, Mark, Plane
from phaseplane.constructions.sheet import plane_of
from phaseplane.constructions.storage import Frame
from phaseplane.equations.typeset import number, printed

_COLUMNS = ("step", "time", "stage", "point", "found", "length_cm", "value")
_ROUNDING = 1e-12  # m of paper
_SEEN = 1e-4  # m of paper: what a ruler shows
_MOST_DECIMALS, _LARGEST, _DIGITS = 6, 1e6, 9  # of a number that is written without a power of ten


@dataclass(frozen=True, slots=True)
class Entry:
    """One point of a construction.

    Parameters
    ----------
    step : number of the step, from 0
    time : at the start of the step, s
    stage : number of the stage within the step, from 0
    point : its letters
    found : how it is constructed
    length : of the line drawn to it in this stage, cm of paper; None if none is drawn
    value : its place on the axes of its plane, as text
    """

    step: int
    time: float
    stage: int
    point: str
    found: str
    length: float | None
    value: str


def protocol(drawing: Drawing, steps: int | None = None) -> list[Entry]:
    """Return the protocol of the first steps of a construction, or of all."""
    return [entry for frame in drawing.frames[:steps] for entry in _of_frame(drawing, frame)]


def _of_frame(drawing: Drawing, frame: Frame) -> Iterator[Entry]:
    scheme = drawing.schemes[frame.scheme]
    for stage, words in enumerate(scheme.stages):
        for mark in scheme.marks:
            if mark.stage == stage and mark.point in frame.points:
                lines = [s for s in scheme.strokes if s.stage == stage and s.end == mark.point]
                length = None
                if lines:
                    way = frame.points[lines[0].end] - frame.points[lines[0].start]
                    length = 100.0 * hypot(way.real, way.imag)
                yield Entry(
                    frame.step, frame.time, stage, typeset(mark.label or mark.point),
                    typeset(words), length, place(plane_of(drawing.planes, mark.point), frame, mark),
                )  # fmt: skip


def place(plane: Plane, frame: Frame, mark: Mark) -> str:
    """Return where a point is on the axes of its plane; its velocity only off the axis."""
    point = frame.points[mark.point]
    readings = [_read(plane.displacement, point)]
    if abs(plane.scaled_velocity.read(point)) * plane.scaled_velocity.scale > 1e-6:
        readings.append(_read(plane.scaled_velocity, point))
    return ", ".join(readings)


def display(axis: Axis) -> tuple[float, str]:
    """Return the factor and the unit of values on an axis: lengths in cm."""
    return (100.0, "cm") if axis.unit == "m" else (1.0, axis.unit)


def displayed(planes: Iterable[Plane], states: Iterable[complex]) -> list[float]:
    """Return y and y-bar of each plane's state point as they are displayed, one after another."""
    return [
        display(plane.displacement)[0] * axis.read(p) + 0.0
        for plane, p in zip(planes, states, strict=False)
        for axis in (plane.displacement, plane.scaled_velocity)
    ]


def point_of(plane: Plane, y: float, y_bar: float = 0.0) -> complex:
    """Return the point of displayed values on the sheet."""
    factor, _ = display(plane.displacement)
    return plane.at(y / factor, y_bar / factor)


def written(plane: Plane, value: float) -> str:
    """Return a displayed value with the digits that can be read off the paper."""
    factor, _ = display(plane.displacement)
    return decimal(value, factor * _SEEN / plane.displacement.scale)


def decimal(value: float, resolution: float) -> str:
    """Return a number with the decimals that a resolution needs; with a power of ten if they are many."""
    digits = ceil(-log10(resolution))
    rounded = round(value, digits) + 0.0
    if digits > _MOST_DECIMALS:
        return number(rounded, _DIGITS)
    return f"{rounded:.{max(digits, 0)}f}" if abs(rounded) < _LARGEST else number(rounded, _DIGITS)


def excitations(drawing: Drawing) -> dict[str, list[str]]:
    """Return what is laid off along the axes for the road or another drive, as displayed, in each step.

    By the letters of its ends; empty in a step in which it is not drawn.
    """
    found: dict[str, list[str]] = {}
    moved: set[str] = set()
    for i, frame in enumerate(drawing.frames):
        for line in drawing.schemes[frame.scheme].strokes:
            if line.role == "excitation":
                axis = (plane := plane_of(drawing.planes, line.end)).displacement
                way = axis.read(frame.points[line.end]) - axis.read(frame.points[line.start])
                name = line.start + line.end
                column = found.setdefault(name, [""] * len(drawing.frames))
                column[i] = written(plane, display(axis)[0] * way)
                if abs(way) * axis.scale > _ROUNDING:
                    moved.add(name)
    return {name: column for name, column in found.items() if name in moved}


def _read(axis: Axis, point: complex) -> str:
    factor, unit = display(axis)
    value = axis.read(point)
    value = 0.0 if abs(value) * axis.scale < _ROUNDING else factor * value
    return f"{axis_letter(axis.label)} = {value:.4g} {unit}".rstrip()


def protocol_text(entries: Sequence[Entry]) -> str:
    """Return a protocol as a table for a terminal."""
    values = [printed(e.value) for e in entries]
    wide = max(map(len, values), default=0)
    lines = [f"step  time s   point   length cm  {'value':<{wide}}  how it is found"]
    before: tuple[int, int] | None = None
    for e, value in zip(entries, values, strict=True):
        first = before is None or before[0] != e.step
        new = before != (e.step, e.stage)
        head = f"{e.step:4d}  {e.time:<8.5g}" if first else " " * 14
        length = "" if e.length is None else f"{e.length:9.2f}"
        found = e.found if new else ""
        lines.append(f"{head} {e.point:<7} {length:>9}  {value:<{wide}}  {found}".rstrip())
        before = (e.step, e.stage)
    return "\n".join(lines) + "\n"


def protocol_csv(entries: Sequence[Entry]) -> str:
    """Return a protocol as CSV."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for e in entries:
        length = "" if e.length is None else f"{e.length:.4f}"
        writer.writerow([e.step, f"{e.time:.9g}", e.stage, e.point, e.found, length, e.value])
    return out.getvalue()
