"""The stages of a step in words, with the lengths that are measured in them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from textwrap import wrap

from phaseplane.constructions.letters import axis_letter, rate_letter, typeset
from phaseplane.constructions.primitives import Plane
from phaseplane.constructions.sheet import plane_of
from phaseplane.constructions.storage import Frame
from phaseplane.equations.typeset import number

from .page import Page
from .quantities import rate_unit
from .text import ROUNDING, markdown

# characters of a row and rows of a protocol in the pane of the text in a window of 1366x768
_ROW, _MOST_ROWS = 75, 17


def protocol(page: Page, frame: Frame, present: int) -> str:
    """Return all stages as a list, an arrow before the present one, with the lengths measured so far.

    Where the text would be too long for its pane, the lengths of the first stages are left out, and
    then stages far from the present one. The numbers belong to the text, because the viewer cuts the
    number of a list off if it has two digits.
    """
    stages = page.drawing.schemes[frame.scheme].stages
    lines = [f"- {i}: {markdown(typeset(words))}" for i, words in enumerate(stages, 1)]
    lines[present] = f"- **\N{RIGHTWARDS ARROW} {lines[present][2:]}**"
    for stage in range(present, -1, -1):
        found = markdown("; ".join(measured(page, frame, stage)))
        longer = [*lines[:stage], f"{lines[stage]} {found}".rstrip(), *lines[stage + 1 :]]
        if stage < present and sum(map(_rows, longer)) > _MOST_ROWS:
            break
        lines = longer
    first, last = 0, len(lines)
    while sum(map(_rows, lines[first:last])) + (last < len(lines)) > _MOST_ROWS:
        first, last = (first, last - 1) if last > present + 1 else (first + 1, last)
    more = [f"- {last + 1}: …"] if last < len(lines) else []
    return "\n".join(lines[first:last] + more)


@lru_cache(maxsize=4096)
def _rows(line: str) -> int:
    """Return the rows that an item of a list takes up in a pane of `_ROW` characters."""
    return len(wrap(re.sub(r"^- |\*\*|\\", "", line), _ROW))


def measured(page: Page, frame: Frame, stage: int) -> list[str]:
    """Return the lengths measured in a stage, each with the value derived from it.

    Displacements and velocities follow from AP57 eqs. 21 and 22, accelerations from eq. 23, arcs from
    eq. 8.
    """
    planes, scheme = page.drawing.planes, page.drawing.schemes[frame.scheme]
    lengths = _Lengths(frame.points, page.units, ROUNDING * page.subject.size)
    shown = {mark.point for mark in scheme.marks}
    marked = {mark.point for mark in scheme.marks if mark.stage == stage}
    strokes = [stroke for stroke in scheme.strokes if stroke.stage == stage]
    normals = {stroke.start for stroke in strokes if stroke.role == "normal"}
    swept = {arc.start for arc in scheme.arcs if arc.stage == stage}
    excited = any(stroke.role == "excitation" for stroke in scheme.strokes)
    found: list[str] = []
    for plane in planes:
        if plane.state in marked:
            found += lengths.state(plane)
    for stroke in strokes:
        if stroke.role == "excitation":
            plane = plane_of(planes, stroke.start)
            found.append(lengths.laid_off(plane, stroke.start, stroke.end))
    for plane in planes:
        if plane.foot in marked or (plane.foot in normals and plane.foot not in shown):
            found.append(lengths.acceleration(plane, mean=excited))
        if plane.foot in normals:
            found.append(lengths.between(plane.foot, plane.state))
    for plane in planes:
        if f"N{plane.number}" in swept:
            found.append(lengths.turn(plane, plane.angular_frequency * frame.duration))
    for plane in planes:
        successor = f"{plane.state}'"
        if successor in marked:
            found.append(f"{typeset(successor)}: {lengths.displacement(plane, successor)}")
    return found


@dataclass(frozen=True, slots=True)
class _Lengths:
    """The lengths of a step, measured on the sheet, with what they stand for."""

    points: Mapping[str, complex]
    units: Mapping[str, tuple[str, float]]  # of the displacements, see `Page.units`
    least: float  # a shorter length is one of rounding, m of paper

    def _read(self, value: float, length: float, digits: int = 4) -> str:
        """Return what a length stands for as text."""
        return number(0.0 if abs(length) < self.least else value, digits)

    def _centimetres(self, length: float) -> str:
        return f"{self._read(100.0 * length, length, 3)} cm"

    def between(self, start: str, end: str) -> str:
        """Return the distance of two points."""
        length = abs(self.points[end] - self.points[start])
        return f"{_pair(start, end)} = {self._centimetres(length)}"

    def laid_off(self, plane: Plane, start: str, end: str) -> str:
        """Return a length that is laid off along the axis of the displacement, or against it."""
        axis = plane.displacement
        along = axis.read(self.points[end]) >= axis.read(self.points[start])
        way = "along" if along else "against"
        return f"{self.between(start, end)} {way} {axis_letter(axis.label)}"

    def state(self, plane: Plane) -> Iterator[str]:
        """Yield both coordinates of the state point."""
        z, foot = self.points[plane.state], f"Q{plane.number}"
        axis, rate = plane.displacement, plane.scaled_velocity
        away = self._centimetres(axis.scale * axis.read(z))
        yield f"{_pair(f'O{plane.number}', foot)} = {away}: {self.displacement(plane, plane.state)}"
        up = self._centimetres(rate.scale * rate.read(z))
        yield f"{_pair(foot, plane.state)} = {up}: {self._rate(plane, 1, rate.read(z))}"

    def displacement(self, plane: Plane, point: str) -> str:
        """Return the displacement of a point."""
        (unit, factor), axis = self.units[plane.name], plane.displacement
        y = axis.read(self.points[point])
        return f"{typeset(axis.label)} = {self._read(factor * y, axis.scale * y)} {unit}".rstrip()

    def acceleration(self, plane: Plane, *, mean: bool) -> str:
        """Return what D gives; it is constructed with the mean excitation over the step, if any."""
        axis = plane.displacement
        away = axis.read(self.points[plane.foot]) - axis.read(self.points[plane.state])
        length = f"{_pair(f'Q{plane.number}', plane.foot)} = {self._centimetres(axis.scale * away)}"
        return f"{length}: {'mean ' * mean}{self._rate(plane, 2, away)}"

    def turn(self, plane: Plane, angle: float) -> str:
        """Return the turn angle and the arc that the normal sweeps in it."""
        arc = angle * abs(self.points[plane.state] - self.points[plane.foot])
        angle_text = f"{typeset('dtau' + plane.number)} = {number(angle, 3)} rad"
        return f"{angle_text}, arc {self._centimetres(arc)}"

    def _rate(self, plane: Plane, order: int, away: float) -> str:
        """Return the rate that a length, in the unit of the displacement, stands for."""
        axis = plane.displacement
        value = self._read(plane.angular_frequency**order * away, axis.scale * away)
        return f"{rate_letter(axis.label, order)} = {value} {rate_unit(axis.unit, order)}"


def _pair(start: str, end: str) -> str:
    return typeset(start) + typeset(end)
