"""The lines, points and letters of a step on a page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Mark
from phaseplane.constructions.sheet import events_of
from phaseplane.constructions.storage import Frame

from .items import VALUE, Dots
from .layers import TURN_POINTS, Layer, is_main
from .page import Page
from .paper import SEEN
from .text import LETTER_OF_EVENT, number

MOST_LETTERED = 24  # events that are lettered; more of them are small dots
_SHARED = 3.0  # em: events of a kind that are nearer to each other share a letter
_RECEDING = 0.45  # opacity of what earlier stages drew


def draw_step(
    page: Page,
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
    layers = page.subject.layers(frame)
    if stage is not None:
        layers = [layer for layer in layers if layer.stage <= stage]
    for layer in layers:
        weight, strength = thin, thin
        if stage is not None:
            weight, strength = (2.0, 1.0) if layer.stage == stage else (0.8, _RECEDING)
        names = enumerate(layer.names)
        wanted = [i for i, name in names if _wanted(layer, name, repeated, turn, sheet)]
        for role in dict.fromkeys(layer.roles[i] for i in wanted):
            chosen = [layer.vertices[0, i] for i in wanted if layer.roles[i] == role]
            if layer.kind == "points":
                seen = [complex(z[0]) for z in chosen if page.view.holds(complex(z[0]))]
                page.dots(role, seen, min(weight, 1.5), strength)
            else:
                page.lines(role, chosen, weight, strength)


def write_letters(page: Page, frame: Frame, marks: Sequence[Mark] | None = None) -> None:
    """Write the letters of marks, at the rim if they are out of view.

    By default they are those of the step itself, and the origins.
    """
    named: list[tuple[complex, str, str]] = []
    far: list[tuple[complex, str, str]] = []
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
    page.letter(
        named + [at for at in origins if page.view.holds(at[0])],
        others=[z for z in others if z not in own],
    )
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
    named = [
        (frame.points[plane.state], LETTER_OF_EVENT.get(event.kind, event.kind), "event")
        for i in page.drawing.frames[:known].events
        for frame in (page.drawing.frames[i],)
        for event in events_of(frame, page.drawing.planes)
        for plane in event.planes
        if page.view.holds(frame.points[plane.state])
    ]
    if named:
        several = len(named) > MOST_LETTERED
        page.dots("event", [z for z, *_ in named], 0.4 if several else 1.0)
        page.letter([] if several else _sharing(named, _SHARED * page.em))


def _sharing(named: list[tuple[complex, str, str]], near: float) -> list[tuple[complex, str, str]]:
    """Return the events without those so near to another one with the same letter that they share it."""
    found: list[tuple[complex, str, str]] = []
    for z, letter, role in named:
        if not any(letter == text and abs(z - at) < near for at, text, _ in found):
            found.append((z, letter, role))
    return found


def event_pages(page: Page) -> dict[int, Page]:
    """Return the marks on a page of all events as one page for each frame with events, by its index."""
    frames, found = page.drawing.frames, {}
    for i in frames.events:
        at = {frames[i].points[plane.state] for plane in page.drawing.planes}
        found[i] = Page(page.subject, page.view, page.em)
        for dots in (dots for dots in page.of(Dots) if dots.role == "event"):
            found[i].dots("event", [z for z in dots.points if z in at], dots.weight)
        for letter in (text for text in page.texts if text.point in at):
            found[i].put(letter)
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


def _wanted(layer: Layer, name: str, repeated: bool, turn: bool, sheet: bool) -> bool:
    if name.startswith(TURN_POINTS):
        return turn and layer.kind != "points"
    return sheet and (repeated or is_main(name))
