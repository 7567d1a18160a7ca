"""The lines, points and letters of a step on a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Mark
from phaseplane.constructions.sheet import events_of
from phaseplane.constructions.storage import Frame
from phaseplane.equations.typeset import number

from .layers import Part, is_main, part_of
from .page import VALUE, Dots, Named, Page
from .paper import SEEN
from .text import LETTER_OF_EVENT

MOST_LETTERED = 24  # events that are lettered; more of them are small dots
_SHARED = 3.0  # em: events of a kind that are nearer to each other share a letter
_TOGETHER, _MOST_TOGETHER = 1.5, 4  # em: points about a point, and how many of them are lettered
_RECEDING = 0.45  # opacity of what earlier stages drew


def draw_step(
    page: Page, frame: Frame, parts: Sequence[Part] = ("step",), *, stage: int | None = None,
    thin: float = 1.0,
) -> None:  # fmt: skip
    """Draw the lines and points of one step, all widths and opacities times `thin`.

    With a present stage, that stands out, and later ones are left out.
    """
    for layer in page.subject.layers(frame):
        weight, strength = thin, thin
        if stage is not None:
            if layer.stage > stage:
                continue
            weight, strength = (2.0, 1.0) if layer.stage == stage else (0.8, _RECEDING)
        # points on the arm are the ends of lines
        drawn = {*parts} - {"turn"} if layer.kind == "points" else parts
        wanted = [i for i, name in enumerate(layer.names) if part_of(name) in drawn]
        for role in dict.fromkeys(layer.roles[i] for i in wanted):
            chosen = [layer.vertices[0, i] for i in wanted if layer.roles[i] == role]
            if layer.kind == "points":
                seen = [complex(z[0]) for z in chosen if page.view.holds(complex(z[0]))]
                page.dots(role, seen, min(weight, 1.5), strength)
            else:
                page.lines(role, chosen, weight, strength)


def write_letters(page: Page, frame: Frame, marks: Sequence[Mark] | None = None) -> None:
    """Write the letters of marks, at the rim if they are out of view.

    By default they are those of the step itself, and the origins. Of many points that lie together, as in
    a plane at rest, only the state point has its letter.
    """
    named: list[Named] = []
    far: list[Named] = []
    for mark in page.drawing.schemes[frame.scheme].marks if marks is None else marks:
        z = frame.points[mark.point]
        if mark.label and (marks is not None or is_main(mark.point)):
            (named if page.view.holds(z) else far).append((z, typeset(mark.label), mark.role))
    origins = [
        (plane.displacement.origin, typeset("O" + plane.number), "axis")
        for plane in (page.drawing.planes if marks is None else ())
    ]
    of_step = page.drawing.schemes[frame.scheme].marks
    others = [frame.points[m.point] for m in of_step if m.label and is_main(m.point)]
    own = [at for at, *_ in named]
    named += [at for at in origins if page.view.holds(at[0])]
    points = np.array([z for z, *_ in named])
    together = (abs(points[:, None] - points) < _TOGETHER * page.em).sum(axis=1)
    page.letter(
        [at for at, near in zip(named, together, strict=True)
         if near <= _MOST_TOGETHER or at[2] == "state"],
        others=[z for z in others if z not in own],
    )  # fmt: skip
    for z, text, role in far:
        _at_the_rim(page, z, text, role)


def _at_the_rim(page: Page, z: complex, text: str, role: str) -> None:
    """Mark a point out of view with an arrow at the rim, its letter and its value on its axis."""
    rim = page.view.grown(-0.4 * page.em).nearest(z)
    if not np.isfinite(z):
        return
    inwards = 1.4 * page.em * (z - rim) / abs(z - rim)
    page.arrow(role, rim - inwards, rim)
    for plane in page.drawing.planes:
        axis, (unit, factor) = plane.displacement, page.units[plane.name]
        if abs(z.imag - axis.origin.imag) < SEEN:  # on this axis, as a foot is
            text = f"{text} at {number(factor * axis.read(z), 3)} {unit}".rstrip()
    page.letter([(rim - inwards, text, role)], 1.0, lines=False)


def mark_events(page: Page, known: int | None = None) -> None:
    """Mark the events of the first `known` frames in every plane, or of all."""
    named: list[Named] = [
        (frame.points[plane.state], LETTER_OF_EVENT.get(event.kind, event.kind), "event")
        for i in page.drawing.frames[:known].events
        for frame in (page.drawing.frames[i],)
        for event in events_of(frame, page.drawing.planes)
        for plane in event.planes
        if page.view.holds(frame.points[plane.state])
    ]
    if not named:
        return
    few = len(named) <= MOST_LETTERED
    page.dots("event", [z for z, *_ in named], 1.0 if few else 0.4)
    lettered: list[Named] = []
    for z, letter, role in named if few else ():
        if not any(letter == of and abs(z - at) < _SHARED * page.em for at, of, _ in lettered):
            lettered.append((z, letter, role))
    page.letter(lettered)


def event_pages(page: Page, frames: Sequence[int]) -> list[Page]:
    """Return the marks on a page of all events as one page for each of these frames with events."""
    found = []
    for i in frames:
        at = {page.drawing.frames[i].points[plane.state] for plane in page.drawing.planes}
        one = Page(page.subject, page.view, page.em)
        for dots in (dots for dots in page.of(Dots) if dots.role == "event"):
            one.dots("event", [z for z in dots.points if z in at], dots.weight)
        for letter in (text for text in page.texts if text.point in at):
            one.put(letter)
        found.append(one)
    return found


def write_numbers(page: Page, frames: Sequence[Frame], *, end: bool = True) -> None:
    """Write the numbers of the state points, and of the successors of the last step if it is the end.

    Points that cannot be told apart, as those of a motion that has not begun, share a text.
    """
    last = frames[-1]
    for plane in page.drawing.planes:
        points = [(frame.points[plane.state], frame.step) for frame in frames]
        if end:
            points.append((last.points[plane.state + "'"], last.step + 1))
        runs = [[points[0]]]
        for at in points[1:]:
            if abs(at[0] - runs[-1][0][0]) < SEEN:
                runs[-1].append(at)
            else:
                runs.append([at])
        page.dots("state", [z for z, _ in points], 0.6)
        named = [
            (run[-1][0], "–".join(dict.fromkeys((str(run[0][1]), str(run[-1][1])))), "state")
            for run in runs
        ]
        # lines are everywhere here, so numbers avoid only letters and points
        page.letter(named, VALUE, lines=False)
