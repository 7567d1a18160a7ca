"""Descriptions of the steps of a construction, in Markdown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from operator import mul

from phaseplane.constructions.primitives import Drawing, Frame, Scheme
from phaseplane.constructions.sheet import Event, events_of

from .quantities import in_words, quantity_of
from .styles import legible, typeset

# The lettering of an event of an axle, and its description.
_EVENTS = {
    "lift_off": ("U {}lift-off", "The {}wheel leaves the road (U)."),
    "touchdown": ("V {}touchdown", "The {}wheel touches down (V)."),
}


_HEAD = "| read off the sheet | |\n|---|---|\n"


def event_texts(event: Event) -> tuple[str, str]:
    """Return the lettering of an event, and its description."""
    if event.kind not in _EVENTS:
        return in_words(event.name), in_words(event.name)
    mark, sentence = _EVENTS[event.kind]
    axle = in_words(event.axle)
    return mark.format(axle), sentence.format(axle)


def step_text(drawing: Drawing, frame: Frame) -> str:
    """Return the description and the readings of a step, in Markdown."""
    events = (event_texts(event)[1] for event in events_of(frame, drawing.planes))
    state = f", {_words(frame.scheme)}" if len(drawing.schemes) > 1 else ""
    return (
        f"**Step {frame.step} of {len(drawing.frames)}{state}**: "
        f"t = {frame.time:.5f} s, lasts {1e3 * frame.duration:.4g} ms. "
        f"{_plain(legible(' '.join(events)))}\n\n" + readings_table(frame.readings)
    )


@lru_cache
def _words(name: str) -> str:
    return _plain(legible(in_words(name)))


def stage_texts(scheme: Scheme) -> tuple[str, ...]:
    """Return how a step is drawn, in Markdown: all stages together, then each stage alone."""
    stages = [_plain(typeset(words)) for words in scheme.stages]
    return (
        "\n".join(f"{i}. {words}" for i, words in enumerate(stages, 1)),
        *(f"**{i} of {len(stages)}**: {words}" for i, words in enumerate(stages, 1)),
    )


def readings_table(readings: Mapping[str, float]) -> str:
    """Return the readings as a Markdown table."""
    if not readings:
        return ""
    form, factors = _table_form(tuple(readings))
    values = tuple(map(mul, factors, readings.values()))
    return _HEAD + (form % values).replace("-", "\N{MINUS SIGN}")


@lru_cache
def _table_form(names: tuple[str, ...]) -> tuple[str, tuple[float, ...]]:
    """Return the rows of a table with a place for each value, and the factors of the values."""
    rows, factors = [], []
    for name in names:
        quantity = quantity_of(name)
        unit = quantity.unit if quantity else ""
        rows.append(f"| {_words(name).replace('%', '%%')} | %.4g {unit} |")
        factors.append(quantity.factor if quantity else 1.0)
    return "\n".join(rows), tuple(factors)


@lru_cache
def _plain(text: str) -> str:
    """Return the text with Markdown's special characters escaped, as in A*."""
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", text)
