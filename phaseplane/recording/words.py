"""A step of the construction in words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from phaseplane.constructions.primitives import Drawing, Frame

from .quantities import in_words, quantity_of
from .styles import legible, typeset

# What an event, named after its axle, is called: beside its mark, and in words.
_EVENTS = {
    "lift_off": ("U {}lift-off", "The {}wheel leaves the road (U)."),
    "touchdown": ("V {}touchdown", "The {}wheel is back (V)."),
}


def event_texts(event: str) -> tuple[str, str]:
    """What is written beside the mark of an event, and what is said of it."""
    for ending, texts in _EVENTS.items():
        if event.endswith(ending):
            axle = in_words(event.removesuffix(ending))
            return texts[0].format(axle), texts[1].format(axle)
    return in_words(event), in_words(event)


@dataclass(frozen=True, slots=True)
class StepTexts:
    """What is said of a step: once it is complete, and at each of its stages."""

    complete: str
    stages: tuple[str, ...]


def step_texts(drawing: Drawing, frame: Frame) -> StepTexts:
    """The words and numbers of a step, in Markdown."""
    stages = drawing.schemes[frame.scheme].stages
    event = _plain(legible(event_texts(frame.event)[1]))
    heading = (
        f"**Step {frame.step} of {len(drawing.frames)}, {_plain(legible(in_words(frame.scheme)))}**: "
        f"t = {frame.time:.5f} s, lasts {1e3 * frame.duration:.4g} ms. {event}\n\n"
    )
    table = readings_table(frame.readings)
    return StepTexts(
        heading + table,
        tuple(
            f"{heading}{i} of {len(stages)}: {_plain(typeset(words))}\n\n{table}"
            for i, words in enumerate(stages, 1)
        ),
    )


def readings_table(readings: Mapping[str, float]) -> str:
    """What is read off the sheet, as a Markdown table."""
    rows = "\n".join(
        f"| {_plain(legible(in_words(name)))} | {_value(name, value)} |"
        for name, value in readings.items()
    )
    return f"| read off the sheet | |\n|---|---|\n{rows}" if rows else ""


def _value(name: str, value: float) -> str:
    quantity = quantity_of(name)
    factor, unit = (quantity.factor, quantity.unit) if quantity else (1.0, "")
    return f"{factor * value:.4g} {unit}".strip().replace("-", "\N{MINUS SIGN}")


@lru_cache
def _plain(text: str) -> str:
    """The text with Markdown's signs made ordinary: A* and its like."""
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", text)
