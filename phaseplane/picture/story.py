"""A construction shown stage by stage: the empty sheet, some steps in full, and the whole motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat
from math import ceil
from operator import add

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing, Mark, Plane, Scheme
from phaseplane.constructions.sheet import events_of
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.equations.typeset import number
from phaseplane.suspension.units import counted

from . import dimensions, text
from .curves import CURVES, draw_curves, draw_own_curves, draw_trails, words_at_end
from .frames import columns, table
from .layers import Part
from .letters import PLATE, text_box
from .page import TYPE, Arrow, Page
from .paper import Box, around
from .protocol import protocol
from .quantities import rate_unit
from .readings import Readings
from .step import draw_step, mark_events, write_letters
from .styles import MOVING_POINT, style_of
from .subject import Subject
from .views import room_for_letters, with_arm

VERTICES = 16_000  # most vertices of a motion in a plane
MOST = 60  # ticks of a story, where the schemes allow it
# least distance of a state point from its origin in a step that is told, of the largest in its plane
_AWAY = 0.25
_MOVES = 0.03  # least way of it in such a step, of the largest in its plane
_ROUNDED = 1e-6  # of the state: a drift below it is one of rounding
_SHORT = 0.1  # least duration of a step that is told, of the longest, where there are others
_TELLING = 6  # fewest steps from which those are chosen
_CANDIDATES = 1000  # most of them
_NEARLY_ALL, _FAR = 0.99, 1.5  # share of the normals, and how much longer ones fit on their arm
_ARMS = 13.5 + 5.7j  # width and height of the pane of the turn angles, em
_RING = 0.8  # size of the ring of a state point, relative to that of a moving one
_TOLD = ("jolt", "lift_off", "touchdown", "yielding", "unloading", "sticking")  # a jump comes first
_WHOLE: tuple[Part, ...] = ("step", "repeated")
_EMPTY = "The empty sheet: axes and auxiliary curves"
_MOST_DRIFT = 0.5  # root mean square over the motion, in parts of that of the state
_LEFT = "**The construction has left the run.** Choose a shorter step."
_HELP = text.HELP.format(
    " The timeline *stage* shows how a few steps are drawn, *step* and *t* go through all of them."
)


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick of a story: the page that replaces that of the tick before, and its text."""

    page: Page  # the sheet, without what stays
    arms: Page  # the turn angles on their common arm
    text: str  # in Markdown
    caption: str  # the same in one sentence of plain text
    step: int  # index of the step; that of the end after the last one
    time: float  # s


def arms_page(drawing: Drawing, frames: StoredFrames | None = None, height: float = 1.0) -> Page:
    """Return the common arm of the turn angles, divided in centimetres of paper.

    It is for nearly all normals, of some steps or of all: at an impact a foot may be far away. The values
    keep clear of each other in a pane of this relative height, too, in which type is as large.
    """
    frames = drawing.frames if frames is None else frames
    if any(curve.role == "construction" for curve in drawing.curves):
        feet = table(frames, [f"N{plane.number}" for plane in drawing.planes])
        normals = (feet - table(frames, ["W"])).real.max(axis=1)
        most = _FAR * np.quantile(normals, _NEARLY_ALL)
        drawing = with_arm(drawing, min(normals.max(), most))
    curves = [curve for curve in drawing.curves if curve.role not in CURVES]
    vertices = [z for curve in curves for z in curve.vertices]
    arms = around(vertices, 1e-6) if vertices else Box(0j, 0.1 + 0.1j)
    names = [words_at_end(curve, curves) for curve in curves if curve.role != "axis"]
    room = max((2.0 * text_box(0j, name, 1.0).half.real for name in names), default=0.0) + 0.5
    size = 2.0 * arms.half
    em = max(size.real / (_ARMS.real - room - 1.0), size.imag / (_ARMS.imag - 3.8))
    # room for the names beside the arms, and for the values below them
    low, high = arms.corners
    low, high = low - (0.5 + 1.8j) * em, high + (room + 0.5 + 2j) * em
    page = Page(Subject(drawing), Box((low + high) / 2.0, (high - low) / 2.0), em)
    draw_curves(page, list(dict.fromkeys(c.role for c in curves)))
    kept: list[Box] = []
    for value in [each for each in page.texts if each.kind == "value"]:
        plate = text_box(value.centre, value.text, em / height).grown(PLATE * em / height)
        if (plate.overlap(Box.of(kept)) > 0.0).any():
            page.items.remove(value)
        else:
            kept.append(plate)
    return page


def story_of(stays: Page, arms: Page, steps: Sequence[int] = (), title: str = "") -> Iterator[Tick]:
    """Yield the ticks of a story of these steps; by default representative ones and those of events.

    What stays on the sheet and on the arm of the turn angles is on pages of its own. The title of the
    empty sheet is that of the drawing by default.
    """
    drawing = stays.drawing
    first, last = drawing.frames[0], drawing.frames[-1]
    words = _introduction(drawing, title)
    yield Tick(stays.following(), arms.following(), words, _EMPTY, 0, first.time)
    for index in told_steps(drawing, steps):
        frame = drawing.frames[index]
        for event in events_of(frame, drawing.planes):
            page = _page(stays, index)
            mark_events(page, index + 1)
            happened = text.event_text(event)
            said = f"{text.step_head(drawing, frame)}\n\n# {text.markdown(happened)}"
            caption = f"{text.format_time(frame.time)}: {happened}"
            yield Tick(page, arms.following(), said, caption, index, frame.time)
        yield from staged(stays, arms, index)
    count = len(drawing.frames)
    page = _page(stays, count)
    mark_events(page)
    for role in MOVING_POINT:
        page.dots(role, [motion[-1] for motion in stays.subject.motions], 1.2)
    # what checks a motion would not have room here
    at_end = (drawing.end or last).readings
    told_here = {name: value for name, value in at_end.items() if not name.startswith("control_")}
    readings = Readings(drawing)
    caption = f"The whole motion: {counted(count, 'step')}"
    marks = text.marks_text(drawing)
    told = [
        f"**The whole motion**: {counted(count, 'step')}. The timelines *step* and *t* go through all of "
        "them.",
        *_drift(stays),
        f"Red points: {marks}." if marks else "",
        readings.control,
        readings.table(told_here),
    ]
    said = "\n\n".join(filter(None, told))
    yield Tick(page, arms.following(), said, caption, count, last.time + last.duration)


def stage_captions(drawing: Drawing, frame: Frame) -> list[str]:
    """Return the caption of each stage of a step."""
    stages = drawing.schemes[frame.scheme].stages
    return [
        f"Step {frame.step}, {k} of {len(stages)}: {typeset(words)}"
        for k, words in enumerate(stages, 1)
    ]


def staged(stays: Page, arms: Page, index: int) -> Iterator[Tick]:
    """Yield the ticks of one step: its stages, one after the other."""
    drawing = stays.drawing
    frame = drawing.frames[index]
    scheme = drawing.schemes[frame.scheme]
    lettered = _page(stays, index)  # with P and D, which keep their places through its stages
    draw_step(lettered, frame, _WHOLE)
    ring = 0.5 * _RING * style_of(MOVING_POINT[0]).size / TYPE * stays.em * (1 + 1j)
    lettered.taken += [Box(frame.points[plane.state], ring) for plane in drawing.planes]
    write_letters(lettered, frame, _kept(scheme, len(scheme.stages)))
    for stage, caption in enumerate(stage_captions(drawing, frame)):
        beside = arms.following()
        draw_step(beside, frame, ["turn"], stage=stage)
        beside.items = [item for item in beside.items if item.role == "arc"]
        said = f"{text.step_head(drawing, frame)}\n\n{protocol(stays, frame, stage)}"
        page = _stage(stays, lettered, index, stage)
        yield Tick(page, beside, said, caption, index, frame.time)


def _drift(stays: Page) -> list[str]:
    """Return how far a construction gets from a motion with which it is compared, and whether it follows.

    It does not if the drift over all steps is more than half as large as the state; at impacts it may be.
    One that is laid over the motion cannot leave it.
    """
    frames, found, follows = stays.drawing.frames, [], True
    for plane in stays.drawing.planes:
        name, axis = f"{plane.name}_drift", plane.displacement
        if name not in frames[0].readings:
            return []
        drift = columns(frames, [name], "readings")[:, 0]
        state = abs(table(frames, [plane.state])[:, 0] - axis.origin) / axis.scale
        unit, factor = stays.units[plane.name]
        largest = drift.max() if drift.max() > _ROUNDED * state.max() else 0.0
        found.append(f"{typeset(axis.label)} {number(factor * largest, 3)} {unit}".rstrip())
        follows = follows and bool((drift**2).mean() < _MOST_DRIFT**2 * (state**2).mean())
    if text.is_laid_over(stays.drawing):
        return [f"A step misses the motion by at most {', '.join(found)}."]
    words = [f"Largest drift from the run: {', '.join(found)}."]
    return words if follows else [*words, _LEFT]


def told_steps(drawing: Drawing, steps: Sequence[int] = ()) -> list[int]:
    """Return the indices of the steps that a story shows, in order."""
    count = len(drawing.frames)
    if steps:
        return sorted({step for step in steps if 0 <= step < count})

    def cost(index: int) -> int:
        frame = drawing.frames[index]
        return len(drawing.schemes[frame.scheme].stages) + bool(frame.event)

    found: list[int] = []
    for kind in _TOLD:  # the first event that can be seen on the sheet, and then those after it
        of_kind = [i for i, event in sorted(drawing.frames.events.items()) if kind in event]
        later = [i for i in of_kind if i > max(found, default=-1)]
        later = _long(drawing, later) or later
        found += ([] if found else _away(drawing, later)[:1]) or later[:1]
    schemes = drawing.frames.schemes
    told = {schemes[i] for i in found}
    usual = next((key for key in schemes if key not in told), schemes[0])
    ordinary = [i for i, key in enumerate(schemes) if key == usual and i not in found]
    ordinary = ordinary or found
    ordinary = _moving(drawing, _long(drawing, ordinary) or ordinary)
    ordinary = ordinary[:: ceil(len(ordinary) / _CANDIDATES)]
    room = room_for_letters(drawing, drawing.frames.at(ordinary))
    room = np.nan_to_num(room, nan=0.0, posinf=0.0)
    left = MOST - 2 - sum(map(cost, found))
    parts = max(3, min(12, left // max(1, cost(ordinary[0]))))
    spans = np.array_split(np.arange(len(ordinary)), min(parts, len(ordinary)))
    for span in spans:
        best = ordinary[int(span[room[span].argmax()])]
        if best not in found and (left >= cost(best) or len(found) < 3):
            found.append(best)
            left -= cost(best)
    return sorted(set(found))


def _long(drawing: Drawing, steps: list[int]) -> list[int]:
    """Return the steps whose arcs can be seen: of a step with an event, but a rest may be left."""
    durations = drawing.frames.durations
    least = _SHORT * max(durations)
    return [i for i in steps if durations[i] >= least]


def _moving(drawing: Drawing, steps: list[int]) -> list[int]:
    """Return the steps in which some state point moves, well away from its origin; all if few are."""
    names = [plane.state for plane in drawing.planes]
    arcs = abs(table(drawing.frames, [f"{n}'" for n in names]) - table(drawing.frames, names))
    seen = (arcs >= _MOVES * np.nanmax(arcs, axis=0, initial=1e-9)).any(axis=1)
    moving = [i for i in _away(drawing, steps) if seen[i]]
    return moving if len(moving) >= _TELLING else steps


def _away(drawing: Drawing, steps: list[int]) -> list[int]:
    """Return the steps in which some state point is well away from its origin, for its whole motion."""
    origins = np.array([plane.displacement.origin for plane in drawing.planes])
    names = [plane.state for plane in drawing.planes]
    size = abs(table(drawing.frames, names) - origins)
    away = (size >= _AWAY * np.nanmax(size, axis=0, initial=1e-9)).any(axis=1)
    return [i for i in steps if away[i]]


def _introduction(drawing: Drawing, title: str) -> str:
    axis = drawing.planes[0].displacement
    curves = [curve.label for curve in drawing.curves if curve.role == "auxiliary"]
    sheet = f"the axes of the phase plane{'s' * (len(drawing.planes) > 1)}"
    sheet += " and the auxiliary curves" * bool(curves)
    sheet += ", each with its value of the displacement" * any(curves)
    words = [f"# {text.markdown(typeset(title or drawing.title))}", f"The empty sheet: {sheet}."]
    distances = ", ".join(
        f"{typeset(c.label)} {number(100 * abs(axis.origin.imag - c.vertices[0].imag), 4)} cm"
        for c in drawing.curves if c.role == "line"
    )  # fmt: skip
    if distances:
        words.append(f"The projection lines, from the {typeset(axis.label)} axis: {distances}.")
    if any(c.role == "trail" for c in drawing.curves):
        units = f", in {axis.unit} and {rate_unit(axis.unit, 1)}" if axis.unit else ""
        words.append(
            "Motions from other starts are there, too, each with the displacement and the velocity, not "
            f"divided by Ω, at which it begins{units}."
        )
    said = " ".join(stage for scheme in drawing.schemes.values() for stage in scheme.stages)
    letters = (" (a)", " (b)") if "by b " in said else repeat("")  # as the instructions call them
    scales = ", ".join(map(add, map(_scale, drawing.planes), letters))
    rates = ", ".join(
        f"Ω{p.number} = {number(p.angular_frequency, 4)} rad/s" for p in drawing.planes
    )
    words.append(f"Scales: {scales}; {typeset(rates)}.")
    return "\n\n".join([*filter(None, words), _HELP])


def _scale(plane: Plane) -> str:
    """Return the scale of a plane: lengths over lengths, or the length of a unit."""
    axis = plane.displacement
    letter = typeset(axis.label)
    if axis.unit == "m":
        return f"{letter} {number(axis.scale, 4)} : 1"
    return f"{letter} {number(100.0 * axis.scale, 4)} cm for 1 {axis.unit}".rstrip()


def _page(stays: Page, index: int) -> Page:
    page = stays.following()
    draw_trails(page, index, 0.8, VERTICES, whole=index == len(stays.drawing.frames))
    return page


def _kept(scheme: Scheme, stages: int) -> list[Mark]:
    """Return the points whose letters stay once they are drawn: P and D."""
    return [m for m in scheme.marks if m.stage < stages and m.role in ("state", "normal")]


def _stage(stays: Page, lettered: Page, index: int, stage: int) -> Page:
    """Return the page of a stage; P and D of the step are lettered as on a page of their own."""
    drawing = stays.drawing
    frame = drawing.frames[index]
    scheme = drawing.schemes[frame.scheme]
    page = _page(stays, index)
    draw_own_curves(page, frame, stage)
    draw_step(page, frame, _WHOLE, stage=stage)
    arrives = any(mark.stage == stage and mark.role == "successor" for mark in scheme.marks)
    for role in MOVING_POINT[2 if arrives else 0 :]:  # the ring would hide a short step
        states = [frame.points[plane.state] for plane in drawing.planes]
        page.dots(role, states, 1.3 if role == "state" else _RING)
    kept = {typeset(mark.label) for mark in _kept(scheme, stage + 1)}
    drawn = [letter for letter in lettered.texts if letter.text.split(" ")[0] in kept]
    for letter in drawn:
        page.put(letter)
    # at the rim, to what is out of view
    page.items += [a for a in lettered.of(Arrow) if a.start in [letter.point for letter in drawn]]
    # the letters of points from which this stage is drawn return for it
    used = {arc.centre for arc in scheme.arcs if arc.stage == stage}
    used |= {z for s in scheme.strokes if s.stage == stage for z in (s.start, s.end)}
    new = [m for m in scheme.marks if m.stage == stage or m.point in used]
    fresh = lettered.following()
    write_letters(fresh, frame, [m for m in new if typeset(m.label) not in kept])
    for letter in fresh.texts:
        page.put(letter)
    page.items += fresh.of(Arrow)
    if any(arc.stage == stage and arc.start.startswith("N") for arc in scheme.arcs):
        for plane in drawing.planes:
            dimensions.turn_angle(page, plane, frame, "", 0.4)
    return page
