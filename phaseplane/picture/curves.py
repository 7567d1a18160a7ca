"""The fixed curves of a sheet with their labels, and the motion."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from math import inf

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Curve, Drawing, Plane
from phaseplane.constructions.storage import Frame

from .frames import columns
from .letters import PLATE, away
from .page import STRAIGHT, VALUE, Arrow, Page, Text, value_text
from .paper import NOTHING, SEEN, Box, Points, Strip, arcs, telling_vertices
from .subject import centre_of, joined
from .text import level_text

CURVES = ("auxiliary", "line", "shortcut", "trail")
"""The roles of the curves that belong to the planes, and not to the turn angles; a trail is one from
another start."""
_PLACES = 12  # for the label of a curve on each of its segments
_LEVELS = 9  # at which auxiliary curves are compared
_SAME = 1e-3  # of the width of their family: distance of curves that coincide
RECENT = 200  # steps of a long motion that are drawn in full, more than the viewer has in a block


def draw_curves(page: Page, roles: Sequence[str] | None = CURVES, clear: Points = NOTHING) -> None:
    """Draw the fixed curves of the given roles, or of all.

    Their labels keep clear of some segments, too, if they can.
    """
    chosen = [c for c in page.drawing.curves if roles is None or c.role in roles]
    for curve in chosen:  # motions from other starts recede behind the one that is drawn
        page.lines(curve.role, [curve.vertices], 0.6 if curve.role == "trail" else 1.0)
    for curve in reversed(chosen):  # the last value of an axis has its unit
        if curve.role == "axis" and curve.label:
            page.write_if_free(value_text(curve.vertices[-1] - 0.8j * page.em, curve.label))
    levels = {c.vertices[0].imag for c in chosen if c.role == "line"}
    levels |= {plane.displacement.origin.imag for plane in page.drawing.planes}
    for curve in chosen:
        if curve.role == "line":
            _name_line(page, curve, levels)
        elif curve.role not in (*CURVES, "axis") and curve.label:
            name = Text(curve.role, words_at_end(curve, chosen), 0j)
            beside = curve.vertices[-1] + name.box(page.em).half.real + 0.5 * page.em
            ups = (0.0, 0.4, 0.8, 1.2, 1.4) if name.text else ()  # on the right, or a little higher
            page.write_first(replace(name, centre=beside + up * 1j * page.em) for up in ups)
    for curve in chosen:
        if curve.role == "auxiliary" and curve.label:
            _along(page, curve, clear)
        # further integral curves are named where they begin, since many of them end together
        place = {"shortcut": -1, "trail": 0}.get(curve.role)
        if place is not None and page.view.holds(curve.vertices[place]):
            words = typeset(curve.label)
            page.dots(curve.role, [curve.vertices[place]])
            starts = [motion[0] for motion in page.subject.motions]
            page.letter([(curve.vertices[place], words, curve.role)], VALUE, others=starts)


def draw_own_curves(page: Page, frame: Frame, stage: float = inf) -> None:
    """Draw the auxiliary curves through the points A of a step that are found up to a stage."""
    marks = page.drawing.schemes[frame.scheme].marks
    known = {mark.point for mark in marks if mark.stage <= stage}
    for plane in page.drawing.planes:
        if (found := f"A{plane.number}") in known:
            through = curve_through(page.drawing, plane, frame.points[found])
            page.lines("auxiliary", through)


def curve_through(drawing: Drawing, plane: Plane, point: complex) -> list[Strip]:
    """Return the auxiliary curve through a point between those that are drawn.

    There is none if one that is drawn leads through it, or if they do not follow from each other by a
    shift along the axis of displacement, as they do where the damper does not depend on it; nor where
    a spring yields, with curves for each of its branches.
    """
    named = [curve for curve in drawing.curves if curve.role == "auxiliary" and curve.label]
    level = f"{plane.displacement.label} = "
    of_plane = [np.array(c.vertices) for c in named if c.label.startswith(level)]
    if len(of_plane) < 2 or not all(" = " in curve.label for curve in named):
        return []
    family = [curve[np.argsort(curve.imag, kind="stable")] for curve in of_plane]
    low, high = max(curve[0].imag for curve in family), min(curve[-1].imag for curve in family)
    heights = np.linspace(low, high, _LEVELS)
    places = np.array([np.interp(heights, curve.imag, curve.real) for curve in family])
    apart = places - places[0]
    near = _SAME * (np.ptp(places) or 1.0)
    there = np.array([np.interp(point.imag, curve.imag, curve.real) for curve in family])
    shifts = point.real - there
    if np.ptp(apart, axis=1).max() > near or abs(shifts).min() <= near:
        return []
    return [tuple(family[0] + shifts[0])]


def _name_line(page: Page, curve: Curve, levels: Set[float]) -> None:
    """Write the name of line I or II as far right as no axis crosses it.

    It stands above or below the line, away from the nearest of the levels of other lines and of y axes.
    """
    end = curve.vertices[-1]
    nearest = min((y - end.imag for y in levels if y != end.imag), key=abs, default=0.0)
    side = -0.75j if nearest > 0.0 else 0.75j
    low, high = (z.real for z in page.view.corners)
    edge = min(high - 0.04 * (high - low), end.real - 0.5 * page.em)
    arrows = [(arrow.start, arrow.tip) for arrow in page.of(Arrow) if arrow.role == "axis"]
    axes = np.array(arrows, complex).reshape(-1, 2).T
    name = Text("line", typeset(curve.label), complex(edge, end.imag) + side * page.em)
    centres = np.asarray(name.centre - np.arange(0, 40, 2) * page.em, complex)
    struck = Box(centres[:, None], np.array(name.box(page.em).half)).inside(*axes).any(axis=1)
    page.write_first(replace(name, centre=complex(z)) for z in centres[~struck])


def words_at_end(curve: Curve, curves: Sequence[Curve]) -> str:
    """Return the names of all curves of its role that end with a curve; empty if it is not the first."""
    end = curve.vertices[-1]
    near = 0.01 * abs(end - curve.vertices[0])
    alike = [c for c in curves if c.role == curve.role and abs(c.vertices[-1] - end) <= near]
    return ", ".join(typeset(c.label) for c in alike) if alike[0] is curve else ""


def _along(page: Page, curve: Curve, clear: Points) -> None:
    """Write the label of a curve beyond its end, or else on it, as near to its end as there is room."""
    named, planes = curve.label.partition(" =")[0], page.drawing.planes
    plane = next((p for p in planes if p.displacement.label == named), planes[0])
    words = level_text(curve.label, *page.units[plane.name])
    ends = np.asarray(curve.vertices, complex)
    part = np.linspace(0.0, 1.0, _PLACES)[:, None]
    places = ends[:-1] + part * (ends[1:] - ends[:-1])
    text = Text("auxiliary", words, 0j, VALUE)
    plate = text.box(page.em).grown(PLATE * page.em).half
    way = (ends[-1] - ends[-2]) / abs(ends[-1] - ends[-2])
    beyond = ends[-1] + way * away(plate, way)
    centres = np.array([beyond, *reversed(places.T.ravel().tolist())])
    struck = Box(centres[:, None], np.array(plate)).inside(*clear.T).any(axis=1)
    ranked = centres[np.argsort(struck, kind="stable")].tolist()
    page.write_first(replace(text, centre=z) for z in ranked)


def draw_trails(
    page: Page, steps: int | None = None, strength: float = 1.0, most: int | None = None,
    recent: int = RECENT, *, whole: bool = True,
) -> None:  # fmt: skip
    """Draw the motion in all planes, up to a number of steps, in curves of at most so many vertices.

    Of a long one that would be a blot only the recent steps are drawn in full; the others are faint, and
    if not the whole motion is to be seen, only its last turns are.
    """
    known = min(map(len, page.subject.ways), default=0)
    last = known if steps is None else min(steps, known)
    since = last - recent if last > 2 * RECENT and page.subject.winds else 0
    close = STRAIGHT * page.em
    if since:
        first = 0 if whole else page.subject.last_turns(since)
        page.lines("trail", page.subject.past(since, close, most, first), 0.4, 0.5 * strength)
    if 0 < since < last:
        lately = [joined(way[since:last]) for way in page.subject.ways]
        if most:
            lately = [z[telling_vertices(z, close, len(z))] for z in lately]
        page.lines("trail", lately, 1.0, strength)
    elif since < last:
        page.lines("trail", page.subject.past(last, close, most), 1.0, strength)


def draw_missed(page: Page) -> None:
    """Draw the steps that miss the next state point, as those over a known motion do."""
    for plane, motion in zip(page.drawing.planes, page.subject.motions, strict=True):
        frames = page.drawing.frames[: len(motion) - 1]
        end = columns(frames, [f"{plane.state}'"])[:, 0]
        beside = np.flatnonzero(abs(end - motion[1:]) > SEEN)
        strips: list[Strip] = []
        for i in beside.tolist():
            frame = frames[i]
            centre = centre_of(page.drawing.schemes[frame.scheme], plane)
            if centre:
                strips.append(arcs(frame.points[centre], motion[i], end[i]))
            else:
                strips.append((motion[i], end[i]))
        page.lines("arc", strips, 0.6)
        page.dots("successor", end[beside].tolist(), 0.6)
