"""Words of a picture: times, events, the heads of steps, and how to use the viewer."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from math import floor, log10

from phaseplane.constructions.construction import CONTACT, FLIGHT
from phaseplane.constructions.letters import LEVEL, typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.sheet import Event, events_of
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.constructions.two_planes import STUCK
from phaseplane.equations.typeset import number

from .quantities import unit_text

# of each kind of event: a sentence with room for its axle, and the letter and the words of its mark
_EVENTS = {
    "lift_off": ("The {}wheel leaves the road (U).", "U", "lift-off"),
    "touchdown": ("The {}wheel touches down (V).", "V", "touchdown"),
    "sticking": ("Dry friction holds the {}suspension (F).", "F", "dry friction begins to hold"),
    "jolt": ("The road jumps, and so do the state points (J).", "J", "jump of the road"),
    "yielding": ("The spring yields.", "", "yielding"),
    "unloading": ("The spring unloads.", "", "unloading"),
}
LETTER_OF_EVENT = {kind: letter for kind, (_, letter, _) in _EVENTS.items() if letter}
ROUNDING = 1e-12
"""Of the largest reading of its kind in a motion, or its largest length: smaller ones are rounding."""

_DECIMALS = 5  # fewest decimals of a time in s
_SHORTEST = 1e-11  # s: shorter steps add no decimals

HELP = (
    "**How to use this view.** Space plays and pauses, the arrow keys go one tick back or forward.{} "
    "Drag to move the sheet, turn the mouse wheel to zoom, double-click to reset the view. Ctrl and + "
    "makes all type larger, as for a projector."
)
"""How to use the viewer, with room for a sentence on timelines."""


def level_text(label: str, unit: str, factor: float) -> str:
    """Return the value on the label of a curve of equal y, in a display unit with this factor.

    The label of curves that coincide, joined by " and ", becomes ±2.
    """
    values = []
    for part in label.split(" and "):
        found = LEVEL.fullmatch(part)
        if found is None:
            return typeset(label)
        metres = float(found[1]) / (100.0 if found[2] == "cm" else 1.0)
        values.append(metres * factor if found[2] else metres)
    opposite = len(values) == 2 and values[0] == -values[1]
    text = "±" + number(abs(values[0])) if opposite else ", ".join(map(number, values))
    return f"{text} {unit}".rstrip()


def in_words(name: str) -> str:
    """Return a variable's name in words."""
    return name.replace("_", " ")


def bracketed(unit: str) -> str:
    """Return a unit to follow a name, as it is printed; empty for a plain number."""
    return f" [{unit_text(unit)}]" if unit not in ("", "1") else ""


def format_time(time: float) -> str:
    """Return a time in s as text."""
    return f"t = {number(time, 4)} s" if time >= 1.0 else f"t = {number(1e3 * time, 4)} ms"


def format_instant(time: float, step: float) -> str:
    """Return a time in s as text, with the decimals that tell it from the time one step later."""
    decimals = max(_DECIMALS, 1 - floor(log10(max(step, _SHORTEST))))
    return f"t = {time:.{decimals}f} s"


def event_text(event: Event) -> str:
    """Return what happens in an event, as a sentence if its kind is known."""
    sentence, *_ = _EVENTS.get(event.kind, (in_words(event.name),))
    return sentence.format(in_words(event.axle))


def marks_text(drawing: Drawing) -> str:
    """Return what the marks of events in a whole motion mean, and how often each was; empty if none."""
    frames = drawing.frames.at([*drawing.frames.events])
    kinds = Counter(event.kind for frame in frames for event in events_of(frame, ()))
    marks = []
    for kind, count in kinds.items():
        _, letter, words = _EVENTS.get(kind, ("", "", kind))
        marks.append(" ".join(filter(None, (words, letter, f"({count})"))))
    return ", ".join(marks)


def markdown(text: str) -> str:
    """Return the text with Markdown's special characters escaped, as in A*."""
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", text)


def is_laid_over(drawing: Drawing) -> bool:
    """Whether all steps start from a known motion, so that no drift accumulates."""
    return not drawing.frames[0].mode


def step_head(drawing: Drawing, frame: Frame) -> str:
    """Return number, mode, time and events of a step, in Markdown."""
    return next(step_heads(drawing, StoredFrames([frame])))


def step_heads(drawing: Drawing, frames: StoredFrames) -> Iterator[str]:
    """Yield the heads of several steps."""
    flies = any(FLIGHT in key for key in drawing.schemes)
    modes = {
        # contact is told only where there is flight
        key: f", {markdown(in_words(key.replace(STUCK, f',{STUCK}')))}" * (key != CONTACT or flies)
        for key in drawing.schemes
    }
    events = {place: events_of(frames[place], drawing.planes) for place in frames.events}
    of = zip(frames.steps, frames.schemes, frames.times, frames.durations, strict=True)
    for place, (step, scheme, time, duration) in enumerate(of):
        head = f"**Step {step} (0 to {len(drawing.frames) - 1}){modes[scheme]}**: "
        lasts = f"lasts {number(1e3 * duration, 4)} ms."
        happened = [markdown(event_text(event)) for event in events.get(place, ())]
        yield " ".join([f"{head}{format_instant(time, duration)}, {lasts}", *happened])


def motion_text(*, planes: bool, vehicle: bool, plots: bool) -> str:
    """Return what is seen of a motion without the description of its steps, in Markdown."""
    seen = [
        "A plane shows one quantity over another, a phase plane a rate over its displacement; the disc "
        "is the present state, and the curve the motion up to it." * planes,
        "The side view is to scale and travels with the vehicle." * vehicle,
        "The line across plots stands at the present time." * plots,
    ]
    return "\n\n".join([" ".join(filter(None, seen)), HELP.format("")])
