"""The axes of the planes, with their ticks, values and names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import ceil, copysign, floor
from operator import itemgetter

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Axis, Plane
from phaseplane.constructions.sheet import round_step

from .frames import reach_of
from .letters import text_box
from .page import PLATE, TYPE, Lines, Page, Text, value_text
from .paper import NOTHING, Box, Points, segments_of
from .quantities import display_unit
from .text import bracketed, number

# places of the name of an axis: up, em, and to the side, half-widths of the name
_BESIDE = (0.0, 1.2, -1.2, 2.4, -2.4, 3.6, -3.6, 4.8, -4.8)
_BACK = (0.0, 0.5, 1.0, 2.0)
# places of a value: beside its tick, em, and along the axis; shifted and far it would name no tick
_PLACES = ((0.0, 0.0), (0.0, -0.8), (0.0, 0.8), (0.8, 0.0))
_MOTION = 2  # of what lies under a text, see `_struck`
_WIDEST = 0.27  # part of the width that the name of an axis may take up


@dataclass(frozen=True, slots=True)
class _Drawn:
    """An axis that is drawn, but not yet its texts: its values, each in the places where it may stand."""

    ends: tuple[complex, complex]
    edge: complex  # at which the name ends (sense > 0) or begins
    name: str
    sense: float
    values: list[list[Text]]


def ticks_of(
    axis: Axis, motion: Points, factor: float = 0.0, least: float = 0.0, beyond: float = 0.6
) -> list[float]:
    """Return values over the range of the motion that are round in a unit of 1 / factor of the axis' own.

    They are at least `least` m of paper apart, the last ones up to `beyond` intervals out of the range.
    """
    low, high = reach_of(axis, motion)
    factor = factor or display_unit(axis.unit, high - low)[1]
    interval = round_step(max((high - low) / 6.0, least / axis.scale) * factor or 1.0, 1)
    first, last = ceil(low * factor / interval - beyond), floor(high * factor / interval + beyond)
    return [i * interval / factor for i in range(first, last + 1) if i]


def draw_axes(page: Page, clear: Points = NOTHING) -> None:
    """Draw the axes with arrows, ticks, values and names, which keep clear of some segments, too."""
    em, planes = page.em, page.drawing.planes
    rises = {}  # the values on the y-bar axes
    for plane in planes:
        axis = plane.scaled_velocity
        _, factor = page.unit_of(plane, axis)
        rises[plane] = ticks_of(axis, page.motion(plane), factor, 1.5 * em)
        if _in_columns(page):
            words = plane.name.split("_")
            centre = _upright(page, plane, rises[plane])[1] + 1.0j * em
            page.write(Text("axis", " ".join(words[:-1] or words), centre, kind="name"))
    drawn = [
        axis
        for plane in planes
        for axis in (_vertical(page, plane, rises[plane]), _level(page, plane))
    ]
    ways = _ways(page, clear)
    for one in drawn:  # names keep clear of the axes of all planes
        _name(page, ways, one)
    for one in drawn:
        _write_values(page, ways, one.values)


def draw_y_axis(page: Page, plane: Plane) -> None:
    """Draw only the y axis, across a view that may not contain the origin."""
    axis, half = plane.displacement, page.view.half.real - 0.5 * page.em
    sense = axis.direction.real
    middle = complex(page.view.centre.real, axis.origin.imag)
    ends = middle - sense * half, middle + sense * half
    page.arrow("axis", *ends)
    name = _Drawn(ends, ends[1] - 1.0j * page.em, typeset(axis.label), sense, [])
    _name(page, _ways(page), name)


def _level(page: Page, plane: Plane) -> _Drawn:
    """Draw the y axis across the whole view, because feet of normals are far out on it."""
    axis, em, (unit, factor) = plane.displacement, page.em, page.units[plane.name]
    # a y axis has values on both sides of a motion, which may cover all others
    ticks = ticks_of(axis, page.motion(plane), factor, 2.2 * em, beyond=1.4)
    sense = axis.direction.real
    start, tip = (
        complex(x, axis.origin.imag) for x in _room(page, plane)[:: 1 if sense > 0.0 else -1]
    )
    _draw(page, axis, (start, tip), ticks, 0.35j * em)
    # one word per line, to keep clear of the motion
    rows = plane.name.split("_")
    label = f"{typeset(axis.label)}{bracketed(unit)}".strip()
    name = "\n".join(rows) + f" {label}"
    if _in_columns(page) or _too_wide(page, name):
        name, rows = label, rows[:1]
    sides = [complex(along, way * (1.0 + far)) for far, along in _PLACES for way in (-1, 1)]
    values = [
        [value_text(axis.at(v) + side * em, number(v * factor)) for side in sides] for v in ticks
    ]
    edge = tip + (0.6 + 0.6 * len(rows)) * 1j * em
    return _Drawn((start, tip), edge, name, sense, values)


def _vertical(page: Page, plane: Plane, ticks: Sequence[float]) -> _Drawn:
    """Draw the y-bar axis only over the range of the motion, to keep clear of other planes."""
    axis, em = plane.scaled_velocity, page.em
    unit, factor = page.unit_of(plane, axis)
    start, tip = _upright(page, plane, ticks)
    ticks = [v for v in ticks if axis.at(v).imag < tip.imag - 0.7 * em]  # clear of the arrow
    _draw(page, axis, (start, tip), ticks, 0.35 * em)
    # on the side of the axis away from the motion
    side = -1.0 if (page.motion(plane) - axis.origin).real.sum() > 0.0 else 1.0
    label, unit = typeset(axis.label), bracketed(unit)
    if _in_columns(page):
        label, unit = "", unit.strip()
    elif _too_wide(page, label):
        label = label.partition(" =")[0]
    values = [
        [
            value_text(axis.at(v) + (way * (0.7 + far + 0.2 * len(text)) + up * 1j) * em, text)
            for (far, up), way in product(_PLACES, (side, -side))
        ]
        for v in ticks
        for text in (number(v * factor),)
    ]
    return _Drawn((start, tip), tip + side * 0.8 * em - 0.2j * em, label + unit, -side, values)


def _draw(
    page: Page, axis: Axis, ends: tuple[complex, complex], ticks: Sequence[float], half: complex
) -> None:
    page.arrow("axis", *ends)
    strips = tuple((z - half, z + half) for z in map(axis.at, ticks) if page.view.holds(z))
    if strips:
        page.items.append(Lines("axis", strips, 0.9))


def _too_wide(page: Page, name: str) -> bool:
    return bool(text_box(0j, name, page.em).half.real > _WIDEST * page.view.half.real)


def _upright(page: Page, plane: Plane, ticks: Sequence[float]) -> tuple[complex, complex]:
    """Return the ends of the y-bar axis, which are in view."""
    axis = plane.scaled_velocity
    ends = [0.0, *ticks, *reach_of(axis, page.motion(plane))]
    start, tip = axis.at(min(ends)) - 0.8j * page.em, axis.at(max(ends)) + 1.6j * page.em
    above = 1.8 if _in_columns(page) else 0.2  # room for the name of the plane
    low, high = (z.imag for z in page.view.corners)
    start = complex(start.real, max(start.imag, low))
    return start, complex(tip.real, min(tip.imag, max(high - above * page.em, start.imag)))


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

    The last are axes, lines I and II, which may be close to them, and those given.
    """
    curves = page.drawing.curves
    lines = segments_of((c.vertices[0], c.vertices[-1]) for c in curves if c.role == "line")
    return [
        segments_of(c.vertices for c in curves if c.role == "auxiliary").T,
        segments_of(page.subject.motions if len(page.drawing.frames) else ()).T,
        np.concatenate([page.segments, lines, clear]).T,
    ]


def _struck(page: Page, text: Text, ways: Sequence[Points]) -> int:
    """Return what a text covers: 1 for auxiliary curves, 2 for motions, 4 for straight lines, added."""
    plate = text.box(page.em).grown(PLATE * page.em)
    return sum(2**i for i, way in enumerate(ways) if plate.inside(*way).any())


def _name(page: Page, ways: Sequence[Points], axis: _Drawn) -> None:
    """Write the name of an axis at the edge of the view.

    It avoids the axes, and lines I and II, which may be close to them; if it can the motion, too, and
    then the auxiliary curves. Of the places that are equally free it takes the one nearest to the axis;
    the unit may stand in a row of its own.
    """
    start, tip = axis.ends
    words = axis.name, axis.name.replace(" [", "\n[")
    texts = [Text("axis", each, axis.edge, 8.5 / TYPE, "name") for each in dict.fromkeys(words)]
    low, high = page.view.grown(-0.3 * page.em).corners
    line = Box((start + tip) / 2.0, complex(abs((tip - start).real), abs((tip - start).imag)) / 2.0)
    found = []
    for (rows, text), other, back, up in product(enumerate(texts), (0, 1), _BACK, _BESIDE):
        half = text.box(page.em).half
        x = axis.edge.real - axis.sense * half.real
        x = min(max(x, low.real + half.real), high.real - half.real) - back * axis.sense * half.real
        height = axis.edge.imag + (up + copysign(0.6 * rows, up)) * page.em
        placed = replace(text, centre=complex(2.0 * tip.real - x if other else x, height))
        box = placed.box(page.em)
        if page.view.contains(box):
            far = line.gap(box) + (rows + 0.3 * other + 1.5 * back) * page.em
            found.append((_struck(page, placed, ways), far, placed))
    page.write_first(text for *_, text in sorted(found, key=itemgetter(0, 1)))


def _write_values(page: Page, ways: Sequence[Points], values: list[list[Text]]) -> None:
    """Write the values of an axis, each in the place with the least in it.

    The motion is not covered, so that the state points are always seen; the ticks of values without a
    place remain. If no value had a place, all are written.
    """
    struck = [[(_struck(page, text, ways), text) for text in places] for places in values]
    free = [[of for of in places if not of[0] & _MOTION] for places in struck]
    for places in free if any(free) else struck:
        page.write_first(text for _, text in sorted(places, key=itemgetter(0)))
