"""Plots of a run's columns, grouped by quantity, with the points of the construction on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import rerun as rr

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.frames import read_over
from phaseplane.picture.paper import Reals
from phaseplane.picture.quantities import (
    QUANTITIES,
    RADIANS,
    Quantity,
    in_range,
    quantity_of,
)
from phaseplane.picture.readings import Readings
from phaseplane.picture.styles import hue_of, strength_of, weight_of
from phaseplane.picture.text import in_words

from .canvas import colours, legible, rgba
from .clock import Clock, seconds
from .content import Content

HISTORIES = "/histories"
MOST_NAMED = 8  # curves of a plot that are named in it; more names would hide them
_WIDTH = 2.0  # of a curve, in points of the screen
_THICK = 2.0  # relative width of a curve between two of its hue
_MOST_MARKED = 300  # points on a curve; more of them are small, for they would be a band
_PLACES = ("front", "rear", "left", "right")


@dataclass(frozen=True, slots=True)
class Panel:
    """The columns of one quantity by name, and those that the construction has, too."""

    quantity: Quantity
    names: tuple[str, ...]
    drawn: tuple[str, ...] = ()

    @property
    def path(self) -> str:
        """Its path in the recording."""
        return f"{HISTORIES}/{rr.escape_entity_path_part(self.quantity.name)}"

    def entity(self, name: str) -> str:
        """Return the path of a column."""
        return f"{self.path}/{rr.escape_entity_path_part(name)}"

    def points(self, name: str) -> str:
        """Return the path of the points of the construction on a column."""
        return f"{self.entity(name)}/drawn"

    @property
    def title(self) -> str:
        """The quantity and its unit."""
        quantity = self.quantity
        if quantity.name == quantity.unit:
            return f"[{quantity.unit}]"
        return f"{quantity.name} [{quantity.unit}]" if quantity.unit else quantity.name

    def values(self, content: Content, name: str) -> Reals:
        """Return a column in the display unit."""
        return self.quantity.factor * content.column(name)


def panels_of(content: Content) -> list[Panel]:
    """Return the columns by quantity: those of the table first, then other units, then bare numbers.

    Lengths are in the unit of the axes of a construction, or in one for the largest range. Without a
    construction, those of more than `MOST_NAMED` columns are split by the part of the car.
    """
    drawing = content.drawing
    known = Readings(drawing).quantities if drawing is not None else {}
    read = {quantity.name: quantity for quantity in known.values() if quantity is not None}
    axes = (
        [plane.displacement.unit for plane in drawing.planes]
        if drawing is not None
        else [content.units.get(name) for name, _ in content.pairs]
    )
    if "rad" in axes:  # angles elsewhere are in degrees
        read["angle"] = RADIANS
    found: dict[Quantity, list[str]] = {read.get(q.name, q): [] for q in QUANTITIES}
    for name in content.histories:
        quantity = quantity_of(name, content.units)
        if quantity in QUANTITIES:
            quantity = read.get(quantity.name, quantity)
        if name == "time" or name.endswith("_residual"):
            continue
        if quantity is None and name in content.numbers:
            quantity = Quantity(in_words(name), "", 1.0, "")
        if quantity is not None and content.shows(
            "energies" if quantity.name == "energy" else "histories"
        ):
            found.setdefault(quantity, []).append(name)
    parts = [(quantity, names) for quantity, names in found.items() if names]
    if drawing is None:
        parts = [part for of, names in parts for part in _by_part(content, of, names)]
    return [
        Panel(quantity, tuple(names), tuple(name for name in names if name in known))
        for quantity, names in parts
    ]


def _by_part(
    content: Content, quantity: Quantity, names: list[str]
) -> list[tuple[Quantity, list[str]]]:
    """Return columns of a quantity together, or many of them by the parts of several wheels.

    Lengths are in a unit for their range, once it is known.
    """
    if len(content.times):
        quantity = in_range(quantity, map(content.column, names))
    parts: dict[str, list[str]] = {}
    for name in names:
        part = "_".join(word for word in name.split("_") if word not in _PLACES)
        parts.setdefault(in_words(part), []).append(name)
    if len(names) <= MOST_NAMED or len(parts) > len(names) / 2:
        return [(quantity, names)]
    largest = sorted(parts.items(), key=lambda item: -len(item[1]))
    return [(replace(quantity, name=part), several) for part, several in largest]


def _curves(panels: Sequence[Panel], content: Content) -> Iterator[tuple[str, Reals]]:
    for panel in panels if len(content.times) else ():
        for name in panel.names:
            yield panel.entity(name), panel.values(content, name)


def _send(
    recording: rr.RecordingStream, path: str, times: list[rr.TimeColumn], values: Reals
) -> None:
    recording.send_columns(path, times, rr.Scalars.columns(scalars=values))


def send_histories(
    recording: rr.RecordingStream, panels: Sequence[Panel], content: Content
) -> None:
    """Send curves over `t` as given."""
    for path, values in _curves(panels, content):
        _send(recording, path, [seconds(content.times)], values)


def send_at_ticks(
    recording: rr.RecordingStream, panels: Sequence[Panel], content: Content, clock: Clock
) -> None:
    """Send the curves of a whole run over `step` and `stage`, at their ticks."""
    steps = [clock.counts(np.arange(len(clock.steps)))]
    for path, values in _curves(panels, content):
        for when, times in ((clock.times, steps), (clock.ticks, clock.story)):
            if len(when):
                at = np.interp(when, content.times, values, left=np.nan, right=np.nan)
                _send(recording, path, times, at)


def send_readings(
    recording: rr.RecordingStream, panels: Sequence[Panel], drawing: Drawing, clock: Clock,
    first: int, last: int,
) -> None:  # fmt: skip
    """Send what was read off the construction in a range of steps, as points on the curves."""
    for panel in panels:
        _, read = read_over(drawing, panel.drawn, first, last)
        times = clock.columns(first + np.arange(len(read)))
        for name, values in zip(panel.drawn, panel.quantity.factor * read.T, strict=True):
            _send(recording, panel.points(name), times, values)


def log_series(recording: rr.RecordingStream, panel: Panel, content: Content) -> None:
    """Log names and looks of the curves of a panel.

    Those of a right wheel are fainter, of a rear one thin, and of a whole body thick beside its ends.
    """
    several = content.drawing is not None and len(content.drawing.frames) > _MOST_MARKED
    for number, name in enumerate(panel.names):
        words = legible(in_words(name))
        colour = colours([rgba(hue_of(name, number), strength_of(name))])
        weight = _THICK if f"front_{name}" in panel.names else weight_of(name)
        line = rr.SeriesLines(names=words, colors=colour, widths=_WIDTH * weight)
        recording.log(panel.entity(name), line, static=True)
        if name in panel.drawn:
            points = rr.SeriesPoints(
                names=f"{words}, drawn", colors=colour, markers="circle",
                marker_sizes=0.8 if several else 2.5,
            )  # fmt: skip
            recording.log(panel.points(name), points, static=True)
