"""A page: the content of one picture, as plain data that any canvas can draw.

A page is filled part by part and remembers its lines and texts, so that later letters avoid them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, floor
from typing import Literal, TypeVar

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.construction import FLIGHT
from phaseplane.constructions.primitives import Axis, Curve, Drawing, Mark, Plane, Scheme
from phaseplane.constructions.sheet import events_of, round_step
from phaseplane.constructions.storage import Frame

from .layers import Layer, is_main, layers_at
from .letters import place, text_box
from .paper import Box, Boxes, Points, Strip, arcs, columns, table, telling_vertices
from .quantities import display_unit
from .styles import style_of
from .text import LETTER_OF_EVENT, MINUS, bracketed, level_text, number, typeset

TYPE = 9.0
"""Size of the type, points: 1 em of a page."""
CURVES = ("auxiliary", "line", "shortcut", "trail")
"""The roles of the curves that belong to the planes, and not to the turn angles; a trail is one from
another start."""
_LETTER, _VALUE = 10.0 / TYPE, 7.0 / TYPE  # sizes, em

_PLACES = 12  # for the label of a curve on each of its segments
_BESIDE = (0.0, 1.2, -1.2, 2.4, -2.4, 3.6, -3.6, 4.8, -4.8)  # places of the name of an axis, em
_WIDEST = 0.27  # part of the width that the name of an axis may take up
_RECEDING = 0.45  # opacity of what earlier stages drew
_SEEN = 2e-4  # m of paper: distance of two points that are seen apart
_STRAIGHT = 0.01  # em: how far a thinned curve may be from the whole one
_RECENT = 200  # steps of a long motion that are drawn in full
MOST_LETTERED = 24
"""Events that are lettered; more of them are small dots."""

Kind = Literal["letter", "value", "name", "label", "dimension"]


@dataclass(frozen=True, slots=True)
class Lines:
    """Polylines of one role; `weight` multiplies their width, `strength` is their opacity."""

    role: str
    strips: tuple[Strip, ...]
    weight: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True, slots=True)
class Dots:
    """Points of one role; `weight` multiplies their diameter, `strength` is their opacity."""

    role: str
    points: tuple[complex, ...]
    weight: float = 1.0
    strength: float = 1.0


@dataclass(frozen=True, slots=True)
class Arrow:
    """A straight arrow with a head at its tip, or at both ends."""

    role: str
    start: complex
    tip: complex
    both: bool = False
    shaft: bool = True


@dataclass(frozen=True, slots=True)
class Text:
    """A text about its centre.

    Parameters
    ----------
    size : of the type, em of the page
    kind : what it is; letters name points
    point : what a letter names, and `led` whether a line leads from it to the letter
    upright : whether it reads upwards
    """

    role: str
    text: str
    centre: complex
    size: float = 1.0
    kind: Kind = "label"
    point: complex | None = None
    led: bool = False
    upright: bool = False

    def box(self, em: float) -> Box:
        """Return its box, for a page with this size of type."""
        half = text_box(self.centre, self.text, self.size * em).half
        if "frac" in self.text:  # two lines high
            half = complex(half.real, 2.0 * half.imag)
        return Box(self.centre, complex(half.imag, half.real) if self.upright else half)


Item = Lines | Dots | Arrow | Text
Kindred = TypeVar("Kindred", Lines, Dots, Arrow, Text)


@dataclass(frozen=True, slots=True)
class Graduation:
    """Ticks of an axis in its own unit, the display unit, and the number of these in its own."""

    values: list[float]
    unit: str
    factor: float


def motions_of(drawing: Drawing) -> list[Points]:
    """Return the state points of each plane, including the end of the motion if the last step has it."""
    names = [plane.state for plane in drawing.planes]
    states = table(drawing.frames, names)
    ends = [f"{name}'" for name in names]
    if all(name in drawing.frames[-1].points for name in ends):
        states = np.concatenate([states, table(drawing.frames[-1:], ends)])
    return list(states.T)


def paths_of(drawing: Drawing, motions: Sequence[Points]) -> list[Points]:
    """Return the way from each state point to the next, shape (steps, vertices): chords, or the arcs
    on which the rule has stepped.
    """
    ways = []
    for plane, motion in zip(drawing.planes, motions, strict=True):
        ends = np.stack([motion[:-1], motion[1:]], 1)
        schemes = drawing.frames.schemes[: len(ends)]
        centres = {key: _centre(scheme, plane) for key, scheme in drawing.schemes.items()}
        if any(centres.values()) and len(ends):
            names = sorted({*centres.values()} - {""})
            of = columns(drawing.frames[: len(ends)], names)
            places = [names.index(centres[key]) if centres[key] else 0 for key in schemes]
            middle = of[np.arange(len(ends)), places]
            middle[[not centres[key] for key in schemes]] = np.inf
            swept = np.isfinite(middle) & (abs(middle - ends[:, 0]) < 1e3 * abs(np.ptp(ends)))
            curved = arcs(*(np.where(swept, z, 0) for z in (middle, ends[:, 0], ends[:, 1])))
            part = np.linspace(0.0, 1.0, curved.shape[1])
            straight = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * part
            # an arc that misses the next point is of a step that was cut short
            missed = ends[:, 1] - curved[:, -1]
            meets = abs(missed) < 0.02 * abs(ends[:, 1] - ends[:, 0])
            curved = curved + missed[:, None] * part
            ends = np.where((swept & meets)[:, None], curved, straight)
        ways.append(ends)
    return ways


def _centre(scheme: Scheme, plane: Plane) -> str:
    """Return the centre of the arc on which a state point moves; empty if it moves on a line."""
    ends = (plane.state, f"{plane.state}'")
    return next((a.centre for a in scheme.arcs if (a.start, a.end) == ends), "")


def reach_of(axis: Axis, motion: Points) -> tuple[float, float]:
    """Return the smallest and largest value of a motion on an axis, always including zero."""
    values = ((motion - axis.origin) * axis.direction.conjugate()).real / axis.scale
    values = values[np.isfinite(values)]
    return float(values.min(initial=0.0)), float(values.max(initial=0.0))


def graduation_of(axis: Axis, motion: Points, least: float = 0.0) -> Graduation:
    """Return round values over the range of the motion, at least `least` m of paper apart."""
    low, high = reach_of(axis, motion)
    unit, factor = display_unit(axis.unit, high - low)
    span = max((high - low) / 6.0, least / axis.scale) * factor
    interval = round_step(span or 1.0, 1)
    first, last = ceil(low * factor / interval - 0.6), floor(high * factor / interval + 0.6)
    values = [i * interval / factor for i in range(first, last + 1) if i]
    return Graduation(values, unit, factor)


@dataclass
class Page:
    """A picture under way.

    Parameters
    ----------
    drawing : the construction it shows
    view : the visible part of the sheet
    em : size of the type, m of paper
    motions : the state points of each plane; default: those of the drawing
    title, words : above it
    keyed : whether it has a legend
    """

    drawing: Drawing
    view: Box
    em: float
    motions: list[Points] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)
    taken: list[Box] = field(default_factory=list)
    title: str = ""
    words: str = ""
    keyed: bool = True

    def __post_init__(self) -> None:
        """Read the motions once."""
        self.motions = self.motions or motions_of(self.drawing)
        self._segments = np.zeros((0, 2), complex)
        self._strips: list[Strip] = []  # whose segments are not among them yet
        # shared by all pages that follow this one
        self._ways: list[Points] = []
        self._few: list[tuple[Points, npt.NDArray[np.int64]]] = []
        self._last: list[tuple[Frame, list[Layer]]] = []  # the last step drawn, and its layers

    @property
    def ways(self) -> list[Points]:
        """The way from each state point to the next in each plane, shape (steps, vertices)."""
        if not self._ways:
            known = [np.asarray(way, complex) for way in self.drawing.ways]
            self._ways += known or paths_of(self.drawing, self.motions)
        return self._ways

    def following(self) -> Page:
        """Return an empty page of the same view, whose letters keep clear of what is on this one."""
        page = Page(self.drawing, self.view, self.em, self.motions, taken=list(self.taken))
        page._segments, page._ways = self.segments, self._ways
        page._few, page._last = self._few, self._last
        return page

    @cached_property
    def units(self) -> dict[str, tuple[str, float]]:
        """The display unit of each plane's displacement, as on its axis, and its number in one unit."""
        found = {}
        for plane in self.drawing.planes:
            low, high = reach_of(plane.displacement, self._motion(plane))
            found[plane.name] = display_unit(plane.displacement.unit, high - low)
        return found

    # What is on the page.

    def of(self, kind: type[Kindred]) -> list[Kindred]:
        """Return all items of one kind, in the order of drawing."""
        return [item for item in self.items if isinstance(item, kind)]

    @property
    def texts(self) -> list[Text]:
        """All texts."""
        return self.of(Text)

    @property
    def roles(self) -> list[str]:
        """The roles of all lines, each once, in the order of drawing."""
        return list(dict.fromkeys(lines.role for lines in self.of(Lines)))

    @property
    def segments(self) -> Points:
        """Ends of all lines drawn so far, shape (segments, 2)."""
        if self._strips:
            new = (np.asarray(strip, complex) for strip in self._strips)
            ends = (np.stack((points[:-1], points[1:]), axis=1) for points in new)
            self._segments = np.concatenate([self._segments, *ends])
            self._strips.clear()
        return self._segments

    def legend(self) -> list[tuple[str, str]]:
        """Return the roles in the legend, with their words."""
        found: dict[str, str] = {}
        for role in self.roles if self.keyed else ():
            words = _legend_text(self.drawing, role)
            if words and words not in found.values():
                found[role] = typeset(words)
        return list(found.items())

    # Primitive parts.

    def spare(self, strip: Strip) -> None:
        """Record a polyline that later letters must avoid."""
        self._strips.append(strip)

    def lines(
        self, role: str, strips: Sequence[Strip], weight: float = 1.0, strength: float = 1.0
    ) -> None:
        """Draw polylines of one role."""
        strips = [strip for strip in strips if len(strip) > 2 or strip[0] != strip[1]]
        if not strips:
            return
        self.items.append(Lines(role, tuple(strips), weight, strength))
        for strip in strips:
            self.spare(strip)

    def dots(
        self, role: str, points: Sequence[complex], weight: float = 1.0, strength: float = 1.0
    ) -> None:
        """Draw points of one role."""
        self.items.append(Dots(role, tuple(points), weight, strength))

    def arrow(self, role: str, start: complex, tip: complex, **more: bool) -> None:
        """Draw an arrow."""
        self.items.append(Arrow(role, start, tip, **more))
        self.spare((start, tip))

    def write(self, text: Text) -> None:
        """Write a text at its place."""
        self.items.append(text)
        self.taken.append(text.box(self.em))

    def write_if_free(self, text: Text) -> bool:
        """Write a text unless another is there or it is out of view; return whether it was written."""
        box = text.box(self.em)
        free = self.view.contains(box) and not any(box.overlap(other) for other in self.taken)
        if free:
            self.write(text)
        return free

    def letter(
        self,
        named: Sequence[tuple[complex, str, str]],
        size: float = _LETTER,
        *,
        lines: bool = True,
        others: Sequence[complex] = (),
    ) -> None:
        """Write letters beside points; each has a position, a text and a role.

        Parameters
        ----------
        lines : whether letters avoid lines, too
        others : points for which they must not be taken
        """
        if not named:
            return
        em = size * self.em
        segments = self.segments if lines else np.zeros((0, 2), complex)
        points = np.array([z for z, *_ in named])
        texts = [text for _, text, _ in named]
        placed = place(points, texts, em, self.view, segments, self.taken, others)
        for (z, text, role), centre, led, free in zip(named, *placed, strict=True):
            if free:  # better no letter than two on one another
                self.put(Text(role, text, complex(centre), size, "letter", z, bool(led)))

    def put(self, letter: Text) -> None:
        """Write a letter at its place, with the leader that it may need."""
        self.write(letter)
        if letter.led and letter.point is not None:
            end = letter.box(self.em).nearest(letter.point)
            self.items.append(Lines("foot", ((letter.point, end),), 0.7))

    # The planes.

    def axes_of_planes(self) -> None:
        """Draw the axes with arrows, ticks, values and names."""
        known = [
            (plane, motion, graduation_of(plane.displacement, motion, 2.2 * self.em),
             graduation_of(plane.scaled_velocity, motion, 1.5 * self.em))
            for plane in self.drawing.planes for motion in (self._motion(plane),)
        ]  # fmt: skip
        for plane, motion, _, up in known if self._in_columns else ():
            words = plane.name.split("_")
            centre = self._upright(plane, motion, up)[1] + 1.0j * self.em
            self.write(Text("axis", " ".join(words[:-1] or words), centre, kind="name"))
        values: list[Text] = []
        for plane, motion, along, up in known:
            values += self._vertical(plane, motion, up)
            values += self._horizontal(plane, along)
        for text in values:
            self.write_if_free(text)

    def _horizontal(self, plane: Plane, graduation: Graduation) -> list[Text]:
        """Draw the y axis across the whole view, because feet of normals are far out on it."""
        axis, em = plane.displacement, self.em
        sense = axis.direction.real
        ends = self._room(plane)[:: 1 if sense > 0.0 else -1]
        start, tip = (complex(x, axis.origin.imag) for x in ends)
        self.arrow("axis", start, tip)
        self._ticks(axis, graduation, 0.35j * em)
        # one word per line, to keep clear of the motion
        rows = plane.name.split("_")
        label = f"{typeset(axis.label)}{bracketed(graduation.unit)}".strip()
        name = "\n".join(rows) + f" {label}"
        if self._in_columns or text_box(0j, name, em).half.real > _WIDEST * self.view.half.real:
            name, rows = label, rows[:1]
        self._name(tip + (0.6 + 0.6 * len(rows)) * 1j * em, name, sense)
        return [
            _value(axis.at(v) - 1.0j * em, number(v * graduation.factor)) for v in graduation.values
        ]

    def _vertical(self, plane: Plane, motion: Points, graduation: Graduation) -> list[Text]:
        """Draw the y-bar axis only over the range of the motion, to keep clear of other planes."""
        axis, em = plane.scaled_velocity, self.em
        start, tip = self._upright(plane, motion, graduation)
        below = [v for v in graduation.values if axis.at(v).imag < tip.imag - 0.7 * em]
        graduation = replace(graduation, values=below)  # clear of the arrow
        self.arrow("axis", start, tip)
        self._ticks(axis, graduation, 0.35 * em)
        # on the side of the axis away from the motion
        side = -1.0 if (motion - axis.origin).real.sum() > 0.0 else 1.0
        name = f"{typeset(axis.label)}{bracketed(graduation.unit)}"
        if self._in_columns:
            name = bracketed(graduation.unit).strip()
        self._name(tip + side * 0.8 * em - 0.2j * em, name, -side)
        texts = [(axis.at(v), number(v * graduation.factor)) for v in graduation.values]
        return [_value(z + side * (0.7 + 0.2 * len(t)) * em, t) for z, t in texts]

    def _upright(
        self, plane: Plane, motion: Points, graduation: Graduation
    ) -> tuple[complex, complex]:
        """Return the ends of the y-bar axis; its tip is in view."""
        axis = plane.scaled_velocity
        ends = [0.0, *graduation.values, *reach_of(axis, motion)]
        start, tip = axis.at(min(ends)) - 0.8j * self.em, axis.at(max(ends)) + 1.6j * self.em
        above = 1.8 if self._in_columns else 0.2  # room for the name of the plane
        highest = self.view.centre.imag + self.view.half.imag - above * self.em
        return start, complex(tip.real, min(tip.imag, max(highest, start.imag)))

    @property
    def _in_columns(self) -> bool:
        """Whether there are planes beside each other; their names then stand above them."""
        return len({plane.displacement.origin.real for plane in self.drawing.planes}) > 1

    def _room(self, plane: Plane) -> tuple[float, float]:
        """Return the ends of a y axis: those of the view, or halfway to the planes beside it."""
        origin = plane.displacement.origin
        places = [p.displacement.origin for p in self.drawing.planes]
        ends = [(z.real + origin.real) / 2.0 for z in places if z.imag == origin.imag]
        low, high = (z.real for z in self.view.grown(-0.5 * self.em).corners)
        return (
            max([low, *(x + self.em for x in ends if x < origin.real)]),
            min([high, *(x - self.em for x in ends if x > origin.real)]),
        )

    def y_axis(self, plane: Plane) -> None:
        """Draw only the y axis, across a view that may not contain the origin."""
        axis, reach_of_view = plane.displacement, self.view.half.real - 0.5 * self.em
        sense = axis.direction.real
        middle = complex(self.view.centre.real, axis.origin.imag)
        tip = middle + sense * reach_of_view
        self.arrow("axis", middle - sense * reach_of_view, tip)
        self._name(tip - 1.0j * self.em, typeset(axis.label), sense)

    def _name(self, edge: complex, name: str, sense: float) -> None:
        """Write the name of an axis, ending (sense > 0) or beginning at the edge of the view.

        It avoids the axes, and lines I and II, which may be close to them, and the motion if it can.
        """
        text = Text("axis", name, edge, 8.5 / TYPE, "name")
        half = text.box(self.em).half
        low, high = self.view.grown(-0.3 * self.em).corners
        x = min(max(edge.real - sense * half.real, low.real + half.real), high.real - half.real)
        places = [(back, up) for back in (0.0, 1.0, 2.0, -3.0) for up in _BESIDE]
        centres = [
            complex(x - back * sense * half.real, edge.imag + up * self.em) for back, up in places
        ]
        lines = [(c.vertices[0], c.vertices[-1]) for c in self.drawing.curves if c.role == "line"]
        ends = np.concatenate([self.segments, np.array(lines, complex).reshape(-1, 2)])
        boxes = Boxes(np.array(centres)[:, None], np.array(half))
        ways = np.concatenate([np.stack([z[:-1], z[1:]], 1) for z in self.motions])
        struck, crossed = (
            boxes.inside(z[:, 0], z[:, 1]).sum(axis=1) > 0.0
            for z in (ends, ways if len(self.drawing.frames) else ways[:0])
        )
        for i in np.argsort(2 * struck + crossed, kind="stable"):
            if self.write_if_free(replace(text, centre=centres[i])):
                return

    def _ticks(self, axis: Axis, graduation: Graduation, half: complex) -> None:
        places = [axis.at(value) for value in graduation.values]
        strips = tuple((z - half, z + half) for z in places if self.view.holds(z))
        if strips:
            self.items.append(Lines("axis", strips, 0.9))

    def curves(self, roles: Sequence[str] | None = CURVES) -> None:
        """Draw the fixed curves of the given roles, or of all, with their labels."""
        chosen = [c for c in self.drawing.curves if roles is None or c.role in roles]
        for curve in chosen:  # motions from other starts recede behind the one that is drawn
            self.lines(curve.role, [curve.vertices], 0.6 if curve.role == "trail" else 1.0)
        highest = max((c.vertices[0].imag for c in chosen if c.role == "line"), default=0.0)
        low, high = (z.real for z in self.view.corners)
        arrows = [(arrow.start, arrow.tip) for arrow in self.of(Arrow) if arrow.role == "axis"]
        axes = np.array(arrows, complex).reshape(-1, 2).T
        for curve in reversed(chosen):  # the last value of an axis has its unit
            if curve.role == "axis" and curve.label:
                self.write_if_free(_value(curve.vertices[-1] - 0.8j * self.em, curve.label))
        for curve in chosen:
            end = curve.vertices[-1]
            if curve.role == "line":
                side = 0.75j if end.imag == highest else -0.75j
                edge = min(high - 0.04 * (high - low), end.real - 0.5 * self.em)
                for shift in range(0, 40, 2):
                    centre = complex(edge - shift * self.em, end.imag) + side * self.em
                    name = Text("line", typeset(curve.label), centre)
                    half = np.array(name.box(self.em).half)
                    struck = Boxes(np.array(centre), half).inside(*axes).any()
                    if not struck and self.write_if_free(name):
                        break
            elif curve.role not in (*CURVES, "axis") and curve.label:
                name = Text(curve.role, words_at_end(curve, chosen), 0j)
                beside = end + name.box(self.em).half.real + 0.5 * self.em
                for up in (0.0, 0.4, 0.8, 1.2) if name.text else ():
                    if self.write_if_free(replace(name, centre=beside + up * 1j * self.em)):
                        break
        for curve in chosen:
            if curve.role == "auxiliary" and curve.label:
                self._along(curve)
            # further integral curves are named where they begin, since many of them end together
            place = {"shortcut": -1, "trail": 0}.get(curve.role)
            if place is not None and self.view.holds(curve.vertices[place]):
                words = typeset(curve.label).replace("-", MINUS)
                self.dots(curve.role, [curve.vertices[place]])
                self.letter([(curve.vertices[place], words, curve.role)], _VALUE)

    def _along(self, curve: Curve) -> None:
        """Write the label of a curve on it, as near to its end as possible, if there is room."""
        plane = self._plane_of(curve)
        unit, factor = display_unit(
            plane.displacement.unit,
            float(np.ptp(reach_of(plane.displacement, self._motion(plane)))),
        )
        text = level_text(curve.label, unit, factor)
        ends = np.asarray(curve.vertices, complex)
        part = np.linspace(0.0, 1.0, _PLACES)[:, None]
        places = ends[:-1] + part * (ends[1:] - ends[:-1])
        for z in reversed(places.T.ravel().tolist()):
            if self.write_if_free(Text("auxiliary", text, z, _VALUE)):
                return

    def _motion(self, plane: Plane) -> Points:
        """Return the state points of a plane, with those in view of the motions from other starts."""
        trails = [c.vertices for c in self.drawing.curves if c.role == "trail"]
        others = [z for vertices in trails for z in vertices if self.view.holds(z)]
        own = self.motions[self.drawing.planes.index(plane)]
        return np.append(own, others) if len(self.drawing.planes) == 1 else own

    def _plane_of(self, curve: Curve) -> Plane:
        """Return the plane whose displacement a curve's label names, else the first."""
        named = curve.label.partition(" =")[0]
        planes = self.drawing.planes
        return next((p for p in planes if p.displacement.label == named), planes[0])

    def trails(
        self, steps: int | None = None, strength: float = 1.0, most: int | None = None
    ) -> None:
        """Draw the motion in all planes, up to a number of steps or to its end.

        Parameters
        ----------
        most : vertices of each whole curve, which is thinned to them; default: all
        """
        known = min(map(len, self.ways), default=0)
        last = known if steps is None else min(steps, known)
        since = last - _RECENT if last > 2 * _RECENT else 0
        if since:  # a long motion would be a blot
            self.lines("trail", self._past(since, most), 0.4, 0.5 * strength)
        recent = [_joined(way[since:last]) for way in self.ways if last]
        if most:
            recent = [z[telling_vertices(z, _STRAIGHT * self.em, len(z))] for z in recent]
        self.lines("trail", recent, 1.0, strength)

    def _past(self, steps: int, most: int | None) -> list[Points]:
        """Return the motion in all planes over the first steps: parts of curves thinned once."""
        if most is None:
            return [_joined(way[:steps]) for way in self.ways]
        if not self._few:
            joined = map(_joined, self.ways)
            self._few += [(z, telling_vertices(z, _STRAIGHT * self.em, most)) for z in joined]
        ends = [steps * (way.shape[1] - 1) for way in self.ways]
        return [
            z[np.append(kept[kept < end], end)]
            for end, (z, kept) in zip(ends, self._few, strict=True)
        ]

    def missed(self) -> None:
        """Draw the steps that miss the next state point, as those over a known motion do."""
        for plane, motion in zip(self.drawing.planes, self.motions, strict=True):
            frames = self.drawing.frames[: len(motion) - 1]
            end = columns(frames, [f"{plane.state}'"])[:, 0]
            beside = np.flatnonzero(abs(end - motion[1:]) > _SEEN)
            strips: list[Strip] = []
            for i in beside.tolist():
                frame = frames[i]
                centre = _centre(self.drawing.schemes[frame.scheme], plane)
                if centre:
                    strips.append(arcs(frame.points[centre], motion[i], end[i]))
                else:
                    strips.append((motion[i], end[i]))
            self.lines("arc", strips, 0.6)
            self.dots("successor", end[beside].tolist(), 0.6)

    # A step.

    def step(
        self,
        frame: Frame,
        *,
        stage: int | None = None,
        repeated: bool = False,
        turn: bool = False,
        sheet: bool = True,
        thin: float = 1.0,
    ) -> None:
        """Draw the lines and points of one step.

        Parameters
        ----------
        stage : the present stage, which stands out; later ones are left out. All stages if None
        repeated : include the construction that the rule repeats
        turn, sheet : include the arcs on the arm of the turn angles, and all else
        thin : factor of all widths and opacities
        """
        layers = self._layers(frame)
        if stage is not None:
            layers = [layer for layer in layers if layer.stage <= stage]
        for layer in layers:
            weight, strength = thin, thin
            if stage is not None:
                weight, strength = (2.0, 1.0) if layer.stage == stage else (0.8, _RECEDING)
            wanted = [i for i in range(len(layer)) if _wanted(layer, i, repeated, turn, sheet)]
            for role in dict.fromkeys(layer.roles[i] for i in wanted):
                chosen = [layer.vertices[0, i] for i in wanted if layer.roles[i] == role]
                if layer.kind == "points":
                    seen = [complex(z[0]) for z in chosen if self.view.holds(complex(z[0]))]
                    self.dots(role, seen, min(weight, 1.5), strength)
                else:
                    self.lines(role, chosen, weight, strength)

    def _layers(self, frame: Frame) -> list[Layer]:
        """Return the layers of a step; pages that follow each other draw the same one several times."""
        if not self._last or self._last[0][0] != frame:
            self._last[:] = [(frame, layers_at(self.drawing, frame))]
        return self._last[0][1]

    def letters(self, frame: Frame, marks: Sequence[Mark] | None = None) -> None:
        """Write the letters of one step; those of points out of view are at the rim.

        Parameters
        ----------
        marks : the points to be lettered; default: those of the step itself, and the origins
        """
        named: list[tuple[complex, str, str]] = []
        far: list[tuple[complex, str, str]] = []
        for mark in self.drawing.schemes[frame.scheme].marks if marks is None else marks:
            z = frame.points[mark.point]
            if mark.label and (marks is not None or is_main(mark.point)):
                (named if self.view.holds(z) else far).append((z, typeset(mark.label), mark.role))
        origins = [
            (plane.displacement.origin, typeset("O" + plane.number), "axis")
            for plane in (self.drawing.planes if marks is None else ())
        ]
        of_step = self.drawing.schemes[frame.scheme].marks
        others = [frame.points[m.point] for m in of_step if m.label and is_main(m.point)]
        own = [at for at, *_ in named]
        self.letter(
            named + [at for at in origins if self.view.holds(at[0])],
            others=[z for z in others if z not in own],
        )
        for z, text, role in far:
            self._at_the_rim(z, text, role)

    def _at_the_rim(self, z: complex, text: str, role: str) -> None:
        """Mark a point out of view with an arrow at the rim, its letter and its value on its axis."""
        rim = self.view.grown(-0.4 * self.em).nearest(z)
        if not np.isfinite(z):
            return
        inwards = 1.4 * self.em * (z - rim) / abs(z - rim)
        self.arrow(role, rim - inwards, rim)
        for plane in self.drawing.planes:
            axis, (unit, factor) = plane.displacement, self.units[plane.name]
            if abs(z.imag - axis.origin.imag) < _SEEN:  # on this axis, as a foot is
                text = f"{text} at {number(factor * axis.read(z), 3)} {unit}".rstrip()
        self.letter([(rim - inwards, text, role)], 1.0, lines=False)

    def events(self, known: int | None = None) -> None:
        """Mark the events of the first `known` frames in every plane, or of all."""
        named = [
            (frame.points[plane.state], LETTER_OF_EVENT.get(event.kind, event.kind), "event")
            for i in self.drawing.frames[:known].events
            for frame in (self.drawing.frames[i],)
            for event in events_of(frame, self.drawing.planes)
            for plane in event.planes
            if self.view.holds(frame.points[plane.state])
        ]
        if named:
            several = len(named) > MOST_LETTERED
            self.dots("event", [z for z, *_ in named], 0.4 if several else 1.0)
            self.letter([] if several else named)

    def numbers(self, frames: Sequence[Frame]) -> None:
        """Write the numbers of the state points, up to the successors of the last step.

        Points that cannot be told apart, as those of a motion that has not begun, share a text.
        """
        last = frames[-1]
        for plane in self.drawing.planes:
            points = [(frame.points[plane.state], frame.step) for frame in frames]
            points.append((last.points[plane.state + "'"], last.step + 1))
            runs = [[points[0]]]
            for at in points[1:]:
                if abs(at[0] - runs[-1][0][0]) < _SEEN:
                    runs[-1].append(at)
                else:
                    runs.append([at])
            self.dots("state", [z for z, _ in points], 0.6)
            named = [
                (run[-1][0], "–".join(dict.fromkeys((str(run[0][1]), str(run[-1][1])))), "state")
                for run in runs
            ]
            # lines are everywhere here, so numbers avoid only letters and points
            self.letter(named, _VALUE, lines=False)


def words_at_end(curve: Curve, curves: Sequence[Curve]) -> str:
    """Return the names of all curves of its role that end with a curve; empty if it is not the first."""
    end = curve.vertices[-1]
    near = 0.01 * abs(end - curve.vertices[0])
    alike = [c for c in curves if c.role == curve.role and abs(c.vertices[-1] - end) <= near]
    return ", ".join(typeset(c.label) for c in alike) if alike[0] is curve else ""


def _joined(way: Points) -> Points:
    """Return the ways of several steps as one polyline."""
    return np.append(way[:, :-1].ravel(), way[-1, -1])


def _wanted(layer: Layer, item: int, repeated: bool, turn: bool, sheet: bool) -> bool:
    name = layer.names[item]
    of_turn = name.startswith(("W", "N"))
    if of_turn:
        return turn and layer.kind != "points"
    return sheet and (repeated or layer.is_main(item))


def _value(centre: complex, text: str) -> Text:
    return Text("value", text, centre, _VALUE, "value")


def _legend_text(drawing: Drawing, role: str) -> str:
    """Return the words of a role in the legend of a drawing; empty for none."""
    words = style_of(role).words
    if role == "line":
        labels = [curve.label for curve in drawing.curves if curve.role == "line"]
        return f"lines {labels[0]} to {labels[-1]}" if len(labels) > 2 else words
    if role == "auxiliary":
        valued = any(curve.role == role and curve.label for curve in drawing.curves)
        of = drawing.planes[0].displacement.label.rstrip("0123456789")
        return f"{words} (of {of})" if valued else words
    if role != "excitation":
        return words
    if any(name.endswith("road_elevation") for f in drawing.frames[:1] for name in f.readings):
        flies = any(FLIGHT in key for key in drawing.schemes)
        return words if flies else "road"
    return "load" if drawing.planes[0].displacement.unit == "m" else "change of f"
