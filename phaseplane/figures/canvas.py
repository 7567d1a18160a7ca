"""The sheet as a figure: axes, lines, points, letters and legend."""

from __future__ import annotations

from cmath import phase
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor
from textwrap import wrap

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from phaseplane.constructions.primitives import Arc, Axis, Curve, Drawing, Frame, Plane
from phaseplane.constructions.rules import REPEATED
from phaseplane.constructions.sheet import events_of, round_step, trail
from phaseplane.figures.lettering import Box, Points, is_letter, place, text_box, typeset
from phaseplane.figures.style import Palette, new_figure, role_style

_TYPE = 9.0  # size of the letters, points
_LARGEST = (11.0, 10.0)  # inches that the sheet may take up
_EVENTS = {"lift_off": "U", "touchdown": "V"}
_TURN_POINTS = ("W", "N")


def is_main(name: str) -> bool:
    """Return whether a point belongs to the step itself, not to a repetition or the turn angles."""
    return REPEATED not in name and not name.startswith(_TURN_POINTS)


@dataclass(frozen=True, slots=True)
class Graduation:
    """Ticks of an axis in m, the display unit, and the number of display units per metre."""

    values: list[float]
    unit: str
    factor: float


def motions_of(drawing: Drawing) -> list[Points]:
    """Return the state points of each plane, including the end of the motion, shape (frames + 1,)."""
    return [np.array(trail(plane, drawing.frames)) for plane in drawing.planes]


def reach_of(axis: Axis, motion: Points) -> tuple[float, float]:
    """Return the smallest and largest value of a motion on an axis, always including zero."""
    values = ((motion - axis.origin) * axis.direction.conjugate()).real / axis.scale
    return min(0.0, float(values.min())), max(0.0, float(values.max()))


def graduation_of(axis: Axis, motion: Points, least: float = 0.0) -> Graduation:
    """Return round values over the range of the motion, at least `least` m of paper apart."""
    low, high = reach_of(axis, motion)
    unit, factor = ("cm", 100.0) if high - low >= 0.01 else ("mm", 1000.0)
    if axis.unit != "m":
        unit, factor = axis.unit, 1.0
    span = max((high - low) / 6.0, least / axis.scale) * factor
    interval = round_step(span or 1.0, 1)
    first, last = ceil(low * factor / interval - 0.6), floor(high * factor / interval + 0.6)
    values = [i * interval / factor for i in range(first, last + 1) if i]
    return Graduation(values, unit, factor)


class Sheet:
    """A figure of a sheet, drawn part by part; it records the lines that letters must avoid."""

    def __init__(self, drawing: Drawing, view: Box, palette: Palette) -> None:
        self.drawing = drawing
        self.view = view
        self.palette = palette
        size = 2.0 * view.half
        self.inches = min(_LARGEST[0] / size.real, _LARGEST[1] / size.imag)
        width, height = size.real * self.inches, size.imag * self.inches
        self.columns = max(2, int(width / 1.3))
        below, above, beside = (0.5 if self.columns > 6 else 0.7), 0.8, 0.1
        full = (width + 2 * beside, height + below + above)
        self.figure = new_figure(*full, palette)
        self.axes: Axes = self.figure.add_axes(
            (beside / full[0], below / full[1], width / full[0], height / full[1])
        )
        self.axes.set_aspect("equal")
        self.axes.set_axis_off()
        corner = view.centre - view.half
        self.axes.set_xlim(corner.real, corner.real + size.real)
        self.axes.set_ylim(corner.imag, corner.imag + size.imag)
        self.em = _TYPE / 72.0 / self.inches
        self.motions = motions_of(drawing)
        self._segments = [np.zeros((0, 2), complex)]
        self.taken: list[Box] = []
        self.seen: dict[str, None] = {}

    @property
    def segments(self) -> Points:
        """Ends of all lines drawn so far, shape (segments, 2)."""
        self._segments = [np.concatenate(self._segments)]
        return self._segments[0]

    def spare(self, strip: Sequence[complex] | Points) -> None:
        """Record a polyline that later letters must avoid."""
        points = np.asarray(strip, complex)
        self._segments.append(np.stack((points[:-1], points[1:]), axis=1))

    def colour(self, role: str) -> str:
        return role_style(role).colour or self.palette.faint

    def lines(
        self, role: str, strips: Sequence[Sequence[complex] | Points], thin: float = 1.0
    ) -> None:
        """Draw polylines of one role."""
        if not strips:
            return
        look = role_style(role)
        self.axes.add_collection(
            LineCollection(
                [vertices(strip) for strip in strips],
                colors=self.colour(role),
                linewidths=look.width * thin,
                linestyles=look.dash,
                alpha=thin,
                capstyle="round",
                zorder=3.0 if role in ("trail", "normal") else 2.0,
                gid=role,
            ),
            autolim=False,
        )
        for strip in strips:
            self.spare(strip)
        self.seen[role] = None

    def dots(self, role: str, points: Sequence[complex], size: float = 1.0) -> None:
        """Draw points of one role."""
        self.axes.plot(
            [z.real for z in points],
            [z.imag for z in points],
            "o",
            color=self.colour(role),
            markersize=role_style(role).size * size,
            markeredgecolor=self.palette.paper,
            markeredgewidth=0.5,
            zorder=4.0,
            gid=role,
        )

    def write(self, centre: complex, text: str, colour: str, size: float = _TYPE) -> None:
        """Write a text, centred."""
        self.axes.text(
            centre.real,
            centre.imag,
            text,
            color=colour,
            fontsize=size,
            fontstyle="italic" if is_letter(text) else "normal",
            ha="center",
            va="center",
            path_effects=self.palette.halo(),
            zorder=6.0,
        )
        self.taken.append(text_box(centre, text, self.em * size / _TYPE))

    def axes_of_planes(self) -> None:
        """Draw the axes with arrows, ticks, values and names."""
        for plane, motion in zip(self.drawing.planes, self.motions, strict=True):
            self._horizontal(plane, motion)
            self._vertical(plane, motion)

    def _arrow(self, start: complex, tip: complex) -> None:
        self.axes.annotate(
            "",
            (tip.real, tip.imag),
            (start.real, start.imag),
            arrowprops={
                "arrowstyle": "-|>,head_width=0.2,head_length=0.5",
                "color": self.palette.ink,
                "linewidth": 0.9,
                "shrinkA": 0,
                "shrinkB": 0,
            },
            zorder=1.5,
        )
        self.spare((start, tip))

    def _horizontal(self, plane: Plane, motion: Points) -> None:
        """Draw the y axis across the whole view, because feet of normals are far out on it."""
        axis, em = plane.displacement, self.em
        sense = axis.direction.real
        edge = self.view.half.real - 0.5 * em
        start = complex(self.view.centre.real - sense * edge, axis.origin.imag)
        tip = complex(self.view.centre.real + sense * edge, axis.origin.imag)
        self._arrow(start, tip)
        graduation = graduation_of(axis, motion, 2.2 * em)
        for value in graduation.values:
            at = axis.at(value)
            self._tick(at, 0.35j * em)
            self.write(at - 1.0j * em, _number(value * graduation.factor), self.palette.faint, 7.0)
        # one word per line, to keep clear of the motion
        rows = plane.name.split("_")
        name = "\n".join(rows) + f" {typeset(axis.label)}{_bracketed(graduation.unit)}"
        self._name(tip + (0.6 + 0.6 * len(rows)) * 1j * em, name, sense)

    def _vertical(self, plane: Plane, motion: Points) -> None:
        """Draw the y-bar axis only over the range of the motion, to keep clear of other planes."""
        axis, em = plane.scaled_velocity, self.em
        graduation = graduation_of(axis, motion)
        ends = [0.0, *graduation.values, *reach_of(axis, motion)]
        start, tip = axis.at(min(ends)) - 0.8j * em, axis.at(max(ends)) + 1.6j * em
        self._arrow(start, tip)
        # on the side of the axis away from the motion
        side = -1.0 if (motion - axis.origin).real.sum() > 0.0 else 1.0
        for value in graduation.values:
            at = axis.at(value)
            self._tick(at, 0.35 * em)
            text = _number(value * graduation.factor)
            self.write(at + side * 1.2 * em, text, self.palette.faint, 7.0)
        name = f"{typeset(axis.label)}{_bracketed(graduation.unit)}"
        self._name(tip + side * 0.8 * em - 0.2j * em, name, -side)

    def y_axis(self, plane: Plane) -> None:
        """Draw only the y axis, across a view that may not contain the origin."""
        axis, reach_of_view = plane.displacement, self.view.half.real - 0.5 * self.em
        sense = axis.direction.real
        middle = complex(self.view.centre.real, axis.origin.imag)
        tip = middle + sense * reach_of_view
        self._arrow(middle - sense * reach_of_view, tip)
        self._name(tip - 1.0j * self.em, typeset(axis.label), sense)

    def _name(self, edge: complex, name: str, sense: float) -> None:
        """Write the name of an axis, ending (sense > 0) or beginning at the edge of the view."""
        self.axes.text(
            edge.real,
            edge.imag,
            name,
            color=self.palette.ink,
            fontsize=8.5,
            ha="right" if sense > 0.0 else "left",
            va="center",
            path_effects=self.palette.halo(),
            zorder=6.0,
            gid="axis_name",
        )
        rows = name.split("\n")
        box = text_box(edge, max(rows, key=len), 0.9 * self.em)
        box = Box(edge, complex(box.half.real, box.half.imag * len(rows)))
        self.taken.append(Box(edge - sense * box.half.real, box.half))

    def _tick(self, at: complex, half: complex) -> None:
        self.axes.plot(
            [(at - half).real, (at + half).real],
            [(at - half).imag, (at + half).imag],
            color=self.palette.ink,
            linewidth=0.8,
            zorder=1.6,
        )

    def stay(self, roles: Sequence[str] | None) -> None:
        """Draw the fixed curves of the given roles, or of all."""
        curves = [c for c in self.drawing.curves if roles is None or c.role in roles]
        highest = max((c.vertices[0].imag for c in curves if c.role == "line"), default=0.0)
        for curve in curves:
            self.lines(curve.role, [curve.vertices])
            end = curve.vertices[-1]
            if curve.role == "line":
                side = 0.75j if end.imag == highest else -0.75j
                edge = self.view.centre.real + 0.93 * self.view.half.real
                centre = complex(min(edge, end.real - 0.5 * self.em), end.imag) + side * self.em
                self.write(centre, curve.label, self.colour("line"))
            elif curve.role == "axis":
                self.write(end - 0.8j * self.em, curve.label, self.palette.faint, 7.0)
            elif curve.role != "auxiliary":
                self.write(end + 1.2 * self.em, typeset(curve.label), self.colour(curve.role))
        for curve in curves:
            if curve.role == "auxiliary" and curve.label:
                self._along(curve, 7.0)

    def _along(self, curve: Curve, size: float) -> None:
        """Write the label of a curve on it, as near to its end as possible, if there is room."""
        text = typeset(curve.label)
        for vertex in reversed(curve.vertices):
            box = text_box(vertex, text, self.em * size / _TYPE)
            if self.view.contains(box) and not any(box.overlap(other) for other in self.taken):
                self.write(vertex, text, self.colour(curve.role), size)
                return

    def trails(self) -> None:
        """Draw the motion in all planes."""
        self.lines("trail", self.motions)

    def step(self, frame: Frame, *, repeated: bool, turn: bool, thin: float = 1.0) -> None:
        """Draw all lines and points of one step."""
        strips = step_strips(self.drawing, frame, repeated=repeated, turn=turn)
        for role, lines in strips.items():
            self.lines(role, lines, thin)
        points = frame.points
        for mark in self.drawing.schemes[frame.scheme].marks:
            if is_main(mark.point) and self.view.holds(points[mark.point]):
                self.dots(mark.role, [points[mark.point]], thin)

    def events(self) -> None:
        """Mark lift-off U and touchdown V in every plane."""
        colour = self.colour("event")
        named = [
            (frame.points[plane.state], _EVENTS.get(event.kind, event.kind), colour)
            for frame in self.drawing.frames
            for event in events_of(frame, self.drawing.planes)
            for plane in event.planes
        ]
        if named:
            self.dots("event", [z for z, *_ in named])
            self.letter(named)

    def letters(self, frame: Frame) -> None:
        """Write the letters of one step."""
        marks = [
            mark
            for mark in self.drawing.schemes[frame.scheme].marks
            if mark.label and is_main(mark.point) and self.view.holds(frame.points[mark.point])
        ]
        named = [
            (frame.points[mark.point], typeset(mark.label), self.colour(mark.role))
            for mark in marks
        ]
        named += [
            (plane.displacement.origin, typeset("O" + plane.state[1:]), self.palette.ink)
            for plane in self.drawing.planes
        ]
        self.letter(named)

    def letter(self, named: Sequence[tuple[complex, str, str]], size: float = 10.0) -> None:
        """Write letters beside points; each has a position, a text and a colour."""
        letters = [(z, text) for z, text, _ in named]
        em = size / _TYPE * self.em
        centres = place(letters, em, self.view, self.segments, self.taken)
        for (_, text, colour), centre in zip(named, centres, strict=True):
            self.write(centre, text, colour, size)

    def numbers(self, frames: Sequence[Frame]) -> None:
        """Write the numbers of the state points, up to the successors of the last step."""
        for plane in self.drawing.planes:
            points = [(frame.points[plane.state], str(frame.step)) for frame in frames]
            last = frames[-1]
            points.append((last.points[plane.state + "'"], str(last.step + 1)))
            self.dots("state", [z for z, _ in points], 0.6)
            # lines are everywhere here, so numbers avoid only letters and points
            nothing = np.zeros((0, 2), complex)
            centres = place(points, 0.8 * self.em, self.view, nothing, self.taken)
            for (_, text), centre in zip(points, centres, strict=True):
                self.write(centre, text, self.colour("state"), 7.0)

    def finish(self, title: str, words: str) -> None:
        """Write the title and the notes above the sheet and the legend below it."""
        width, height = self.figure.get_size_inches()
        lines = [
            line for text in (title, *words.split("\n")) for line in wrap(text, int(13 * width))
        ]
        self.figure.text(
            0.5, 1.0 - 0.4 / height, "\n".join(lines), color=self.palette.ink,
            fontsize=10.0, ha="center", va="center",
        )  # fmt: skip
        handles = [
            Line2D(
                [],
                [],
                color=self.colour(role),
                linestyle=look.dash,
                linewidth=1.6,
                label=look.words,
            )
            for role in self.seen
            if (look := role_style(role)).words
        ]
        self.figure.legend(
            handles=handles,
            loc="lower center",
            ncols=min(self.columns, len(handles)),
            frameon=False,
            fontsize=8.0,
            labelcolor=self.palette.ink,
        )


def step_strips(
    drawing: Drawing, frame: Frame, *, repeated: bool, turn: bool
) -> dict[str, list[Sequence[complex] | Points]]:
    """Return the lines of one step by role.

    Parameters
    ----------
    repeated : include the construction that the rule repeats
    turn : include the arcs of the turn angles
    """
    scheme, points = drawing.schemes[frame.scheme], frame.points
    by_role: dict[str, list[Sequence[complex] | Points]] = {}
    for stroke in scheme.strokes:
        if repeated or is_main(stroke.start + stroke.end):
            by_role.setdefault(stroke.role, []).append([points[stroke.start], points[stroke.end]])
    for arc in scheme.arcs:
        of_turn = arc.centre.startswith("W")
        if (turn and of_turn) or (not of_turn and is_main(arc.start + arc.end)):
            by_role.setdefault(arc.role, []).append(arc_vertices(arc, frame))
    return by_role


def vertices(strip: Sequence[complex] | Points) -> npt.NDArray[np.float64]:
    """Return a polyline as matplotlib takes it, shape (points, 2)."""
    points = np.asarray(strip, complex)
    return np.column_stack((points.real, points.imag))


def arc_vertices(arc: Arc, frame: Frame) -> Points:
    """Return a polyline along an arc."""
    centre, start = frame.points[arc.centre], frame.points[arc.start]
    radius, to = start - centre, frame.points[arc.end] - centre
    if radius == 0.0 or to == 0.0:
        return np.array([start, start])
    turn = phase(to / radius)
    return centre + radius * np.exp(1j * turn * np.linspace(0.0, 1.0, 3 + ceil(abs(turn) / 0.05)))


def time_words(time: float) -> str:
    """Return a time in s as text."""
    return f"t = {time:.4g} s" if time >= 1.0 else f"t = {1e3 * time:.4g} ms"


def _bracketed(unit: str) -> str:
    """Return a unit to follow a name; empty for a plain number."""
    return f" [{unit}]" if unit not in ("", "1") else ""


def _number(value: float) -> str:
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")
