"""The axes of the planes, with their ticks, values and names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from math import ceil, copysign, floor
from operator import itemgetter

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Axis, Plane
from phaseplane.constructions.sheet import round_step
from phaseplane.equations.typeset import number

from .frames import reach_of
from .letters import PLATE, text_box
from .page import STRAIGHT, TYPE, Lines, Page, Text, value_text
from .paper import NOTHING, Box, Points, segments_of, telling_vertices
from .quantities import display_unit
from .text import bracketed

# places of the name of an axis: up, em, and to the side, half-widths of the name
_BESIDE = (0.0, 1.2, -1.2, 2.4, -2.4, 3.6, -3.6, 4.8, -4.8)
_BACK = (0.0, 0.5, 1.0, 2.0)
# places of a value: beside its tick, em, and along the axis; shifted and far it would name no tick
_PLACES = ((0.0, 0.0), (0.0, -0.8), (0.0, 0.8), (0.8, 0.0))
_MOTION = 2  # of what lies under a text, see `_struck`
_FARTHEST = 3.5  # em: of a name from its axis, where a shorter one is nearer
_ROW = 1.5  # em: from the units of a plane to its name above them
_WIDEST = 0.28  # part of the width that the name of an axis may take up


@dataclass(frozen=True, slots=True)
class Graduation:
    """Ticks of an axis in its own unit, the display unit, and the number of these in its own."""

    values: list[float]
    unit: str
    factor: float


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A drawn axis, with where its name and its values may stand."""

    start: complex
    tip: complex
    edge: complex  # of its name, which ends there, or begins if the sense is negative
    sense: float
    names: Sequence[str]  # the whole name, and shorter ones
    values: Sequence[Sequence[Text]] = ()  # each in several places

    @property
    def line(self) -> Box:
        """The axis as a box without width or without height."""
        half = (self.tip - self.start) / 2.0
        return Box(self.start + half, complex(abs(half.real), abs(half.imag)))

    @property
    def upright(self) -> bool:
        """Whether it is a y-bar axis."""
        return self.start.real == self.tip.real


def graduation_of(
    axis: Axis, motion: Points, least: float = 0.0, along: Axis | None = None, beyond: float = 0.6
) -> Graduation:
    """Return round values over the range of the motion, at least `least` m of paper apart.

    Parameters
    ----------
    along : the axis whose range decides on the display unit; default: this one
    beyond : how far the last values may be outside of the range, in intervals
    """
    low, high = reach_of(axis, motion)
    unit, factor = display_unit(axis.unit, float(np.ptp(reach_of(along or axis, motion))))
    span = max((high - low) / 6.0, least / axis.scale) * factor
    interval = round_step(span or 1.0, 1)
    first, last = ceil(low * factor / interval - beyond), floor(high * factor / interval + beyond)
    values = [i * interval / factor for i in range(first, last + 1) if i]
    if least and not values:  # at rest: the scale is seen all the same
        values = [-interval / factor, interval / factor]
    return Graduation(values, unit, factor)


def draw_axes(page: Page, clear: Points = NOTHING) -> None:
    """Draw the axes with arrows, ticks, values and names, which keep clear of some segments, too."""
    beside, planes = _in_columns(page), page.drawing.planes
    if beside:
        _write_heads(page)
    axes = [axis for plane in planes for axis in (_vertical(page, plane), _horizontal(page, plane))]
    ways = _ways(page, clear)
    for axis in axes if not beside else ():  # which keeps clear of the axes of all planes
        _name(page, ways, axis, [other.line for other in axes if other.upright == axis.upright])
    for axis in axes:
        _write_values(page, axis.values, ways)


def _write_heads(page: Page) -> None:
    """Write the names of planes beside each other above them, with the units of their axes."""
    shared = Counter(plane.name for plane in page.drawing.planes)
    for plane in page.drawing.planes:
        words = plane.name.split("_")
        above = " ".join(words[:-1] or words)
        if shared[plane.name] > 1:  # they differ in what is upwards
            above = plane.scaled_velocity.label
        both = page.units[plane.name][0], _graduation_up(page, plane).unit
        units = ", ".join(filter(None, (bracketed(unit).strip() for unit in both)))
        tip = _upright(page, plane)[1]
        # two texts: of many with two rows, the viewer shows only the first
        for row, text in enumerate(filter(None, (units, above))):
            page.write(Text("axis", text, tip + (1.0 + _ROW * row) * 1j * page.em, kind="name"))


def draw_y_axis(page: Page, plane: Plane) -> None:
    """Draw only the y axis, across a view that may not contain the origin."""
    axis, reach_of_view = plane.displacement, page.view.half.real - 0.5 * page.em
    sense = axis.direction.real
    middle = complex(page.view.centre.real, axis.origin.imag)
    start, tip = middle - sense * reach_of_view, middle + sense * reach_of_view
    page.arrow("axis", start, tip)
    drawn = _Drawn(start, tip, tip - 1.0j * page.em, sense, [typeset(axis.label)])
    _name(page, _ways(page), drawn)


def _horizontal(page: Page, plane: Plane) -> _Drawn:
    """Draw the y axis across the whole view, because feet of normals are far out on it."""
    axis, em = plane.displacement, page.em
    # values on both sides of a motion, which may cover all others
    graduation = graduation_of(axis, page.motion(plane), 2.2 * em, beyond=1.4)
    sense = axis.direction.real
    ends = _room(page, plane)[:: 1 if sense > 0.0 else -1]
    start, tip = (complex(x, axis.origin.imag) for x in ends)
    places = _ticked(page, axis, _between(graduation, axis, start, tip), start, tip, 0.35j * em)
    # one word per line, to keep clear of the motion
    rows = plane.name.split("_")
    label = f"{typeset(axis.label)}{bracketed(graduation.unit)}".strip()
    names = ["\n".join(rows) + f" {label}", f"{' '.join(rows[:-1] or rows)}\n{label}", label]
    sides = [complex(along, way * (1.0 + far)) for far, along in _PLACES for way in (-1, 1)]
    values = [[value_text(z + side * em, text) for side in sides] for z, text in places]
    return _Drawn(start, tip, tip + 1.2j * em, sense, _fitting(page, names), values)


def _vertical(page: Page, plane: Plane) -> _Drawn:
    """Draw the y-bar axis only over the range of the motion, to keep clear of other planes."""
    axis, em = plane.scaled_velocity, page.em
    start, tip = _upright(page, plane)
    graduation = _between(
        _graduation_up(page, plane), axis, start, tip - 0.7j * em
    )  # clear of the arrow
    places = _ticked(page, axis, graduation, start, tip, 0.35 * em)
    # on the side of the axis away from the motion
    side = -1.0 if (page.motion(plane) - axis.origin).real.sum() > 0.0 else 1.0
    label = typeset(axis.label)
    label, *_ = _fitting(page, [label, label.partition(" =")[0]])
    values = [
        [value_text(z + (way * (0.7 + far + 0.2 * len(text)) + up * 1j) * em, text)
         for (far, up), way in product(_PLACES, (side, -side))]
        for z, text in places
    ]  # fmt: skip
    edge = tip + side * 0.8 * em - 0.2j * em
    return _Drawn(start, tip, edge, -side, [label + bracketed(graduation.unit)], values)


def _ticked(
    page: Page, axis: Axis, graduation: Graduation, start: complex, tip: complex, half: complex
) -> list[tuple[complex, str]]:
    """Draw an axis with its ticks, and return the places of its values, with these as texts."""
    page.arrow("axis", start, tip)
    places = [axis.at(value) for value in graduation.values]
    strips = tuple((z - half, z + half) for z in places if page.view.holds(z))
    if strips:
        page.items.append(Lines("axis", strips, 0.9))
    return [
        (z, number(v * graduation.factor)) for z, v in zip(places, graduation.values, strict=True)
    ]


def _between(graduation: Graduation, axis: Axis, start: complex, end: complex) -> Graduation:
    """Return the values between the ends of an axis; if there is none, a round one that is."""
    low, high = axis.read(start), axis.read(end)
    values = [value for value in graduation.values if low < value < high]
    farther = max(low, high, key=abs)
    if low < 0.0 < high and not values:
        least = round_step(abs(farther) * graduation.factor / 2.6, 1) / graduation.factor
        values = [copysign(least, farther)]
    return replace(graduation, values=values)


def _fitting(page: Page, names: Sequence[str]) -> list[str]:
    """Return the names that are not too wide, or else the last and shortest."""
    most = _WIDEST * page.view.half.real
    return [n for n in names if text_box(0j, n, page.em).half.real <= most] or [names[-1]]


def _graduation_up(page: Page, plane: Plane) -> Graduation:
    axis, along = plane.scaled_velocity, plane.displacement
    return graduation_of(axis, page.motion(plane), 1.5 * page.em, along)


def _upright(page: Page, plane: Plane) -> tuple[complex, complex]:
    """Return the ends of the y-bar axis, which are in view and clear of the planes above and below."""
    x = plane.scaled_velocity.origin.real
    (bottom, top), (low, high) = _wanted(page, plane), _heights(page, plane)
    start = max(bottom, low)
    return complex(x, start), complex(x, min(top, max(high, start)))


def _wanted(page: Page, plane: Plane) -> tuple[float, float]:
    """Return the heights of the ends of a y-bar axis with all its values, an arrow above the last."""
    axis, values = plane.scaled_velocity, _graduation_up(page, plane).values
    ends = [axis.at(value).imag for value in (0.0, *values, *reach_of(axis, page.motion(plane)))]
    return min(ends) - 0.8 * page.em, max(ends) + 1.6 * page.em


def _heights(page: Page, plane: Plane) -> tuple[float, float]:
    """Return the least and the greatest height of a y-bar axis.

    It is in view, below the name of the plane, and clear of the axes above and below, or where they
    would meet halfway between the motions.
    """
    name = (1.8 + _ROW if _in_columns(page) else 0.2) * page.em
    low, high = (z.imag for z in page.view.grown(-name).corners)
    low -= name
    (bottom, top), apart = _extent(page, plane), 0.2 * page.em
    for other in page.drawing.planes:
        away = other.displacement.origin - plane.displacement.origin
        (its_bottom, its_top), wanted = _extent(page, other), _wanted(page, other)
        if away.real == 0.0 and away.imag < 0.0:
            between = min((bottom + its_top + name) / 2.0, wanted[1] + name)
            low = max(low, min(bottom, between + apart))
        elif away.real == 0.0 and away.imag > 0.0:
            between = max((top + its_bottom - name) / 2.0, wanted[0] - name)
            high = min(high, max(top, between - apart))
    return low, high


def _extent(page: Page, plane: Plane) -> tuple[float, float]:
    """Return how far down and up a motion reaches, with its origin."""
    heights = np.append(page.motion(plane), plane.scaled_velocity.origin).imag
    return float(np.nanmin(heights)), float(np.nanmax(heights))


def _in_columns(page: Page) -> bool:
    """Whether there are planes beside each other; their names then stand above them."""
    return len({plane.displacement.origin.real for plane in page.drawing.planes}) > 1


def _room(page: Page, plane: Plane) -> tuple[float, float]:
    """Return the ends of a y axis: those of the view, or halfway to the planes beside it."""
    origin = plane.displacement.origin
    places = [p.displacement.origin for p in page.drawing.planes]
    ends = [(z.real + origin.real) / 2.0 for z in places if z.imag == origin.imag]
    low, high = (z.real for z in page.view.grown(-0.5 * page.em).corners)
    return (
        max([low, *(x + page.em for x in ends if x < origin.real)]),
        min([high, *(x - page.em for x in ends if x > origin.real)]),
    )


def _ways(page: Page, clear: Points = NOTHING) -> list[Points]:
    """Return what texts keep clear of, each as segments: auxiliary curves, motions, straight lines.

    Motions are thinned, for they are asked for at every place of a text. Straight lines are axes, lines I
    and II, which may be close to them, and those given.
    """
    curves = page.drawing.curves
    lines = segments_of((c.vertices[0], c.vertices[-1]) for c in curves if c.role == "line")
    motions = page.subject.motions if page.subject.known else []
    few = [z[telling_vertices(z, STRAIGHT * page.em, len(z))] for z in motions]
    return [
        segments_of(c.vertices for c in curves if c.role == "auxiliary").T,
        segments_of(few).T,
        np.concatenate([page.segments, lines, clear]).T,
    ]


def _struck(page: Page, texts: Iterable[Text], ways: Sequence[Points]) -> list[int]:
    """Return what is under each text: 1 for auxiliary curves, 2 for motions, 4 for lines, added."""
    plates = Box.of([text.box(page.em).grown(PLATE * page.em) for text in texts])
    many = Box(plates.centre[:, None], plates.half[:, None])
    found = (2**i * many.inside(*way).any(axis=1) for i, way in enumerate(ways))
    return sum(found, np.zeros(len(many.centre), int)).tolist()


def _name(page: Page, ways: Sequence[Points], axis: _Drawn, parallel: Sequence[Box] = ()) -> None:
    """Write the name of an axis, ending (sense > 0) or beginning at the edge of the view.

    It avoids the axes, and lines I and II, which may be close to them; if it can the motion, too, for
    which it may be a shorter one, and then the auxiliary curves. Of the places that are equally free it
    takes the one nearest to the axis; the unit may stand in a row of its own. Where all places at its
    tip are on the motion, an upright axis may have its name at its lower end. No place is nearer to one
    of the other `parallel` axes.
    """
    words = {
        each: shorter
        for shorter, name in enumerate(axis.names)
        for each in (name, name.replace(" [", "\n["))
    }
    low, high = page.view.grown(-0.3 * page.em).corners
    line, edge, sense = axis.line, axis.edge, axis.sense
    heights = [edge.imag, *([(axis.start + axis.tip - edge).imag] if axis.upright else ())]
    found = []
    for (foot, end), (each, shorter), other, back, up in product(
        enumerate(heights), words.items(), (0, 1), _BACK, _BESIDE
    ):
        text, rows = Text("axis", each, edge, 8.5 / TYPE, "name"), each.count("\n")
        half = text.box(page.em).half
        x = min(max(edge.real - sense * half.real, low.real + half.real), high.real - half.real)
        height = end + (up + copysign(0.6 * rows, up)) * page.em
        x -= back * sense * half.real
        centre = complex(2.0 * axis.tip.real - x if other else x, height)
        box = Box(centre, half)
        gap = line.gap(box)
        if page.view.contains(box) and all(gap <= of.gap(box) for of in parallel):
            broken = each not in axis.names
            far = gap + (broken + 0.3 * other + 1.5 * back) * page.em
            astray = gap > _FARTHEST * page.em
            found.append((replace(text, centre=centre), astray, foot, shorter, far))
    struck = _struck(page, [text for text, *_ in found], ways)
    ranked = [
        ((inside >= _MOTION, astray, foot, inside, shorter, far), text)
        for (text, astray, foot, shorter, far), inside in zip(found, struck, strict=True)
    ]
    page.write_first(text for _, text in sorted(ranked, key=itemgetter(0)))


def _write_values(page: Page, values: Sequence[Sequence[Text]], ways: Sequence[Points]) -> None:
    """Write the values of an axis, each in the place with the least in it.

    The motion is not covered, so that the state points are always seen; the ticks of values without a
    place remain. If no value had a place, all are written.
    """
    known = iter(_struck(page, chain.from_iterable(values), ways))
    struck = [list(zip(places, known, strict=False)) for places in values]
    free = [[of for of in places if not of[1] & _MOTION] for places in struck]
    for places in free if any(free) else struck:
        page.write_first(text for text, _ in sorted(places, key=itemgetter(1)))
