"""Plots of a run's columns, grouped by quantity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import rerun as rr

from .columns import Clock, Reals, colours, seconds
from .content import Content
from .quantities import QUANTITIES, Quantity, in_words, quantity_of
from .styles import SERIES_COLOURS, legible

HISTORIES = "/histories"


@dataclass(frozen=True, slots=True)
class Panel:
    """The columns of one quantity."""

    quantity: Quantity
    names: tuple[str, ...]

    @property
    def path(self) -> str:
        """Its path in the recording."""
        return f"{HISTORIES}/{self.quantity.name}"

    @property
    def labels(self) -> list[str]:
        """Names in the legend."""
        return [legible(in_words(name)) for name in self.names]

    @property
    def title(self) -> str:
        """The quantity and its unit."""
        return f"{self.quantity.name} [{self.quantity.unit}]"

    def values(self, histories: Mapping[str, npt.ArrayLike]) -> Reals:
        """Return its columns in the display unit, shape (n, columns)."""
        columns = [np.asarray(histories[name], float) for name in self.names]
        return self.quantity.factor * np.column_stack(columns)


def panels(content: Content) -> list[Panel]:
    """Return the columns by quantity, without those of unknown quantity."""
    wanted = [
        quantity
        for quantity in QUANTITIES
        if content.shows("energies" if quantity.name == "energy" else "histories")
    ]
    found = [
        Panel(
            quantity,
            tuple(
                name
                for name in content.histories
                if quantity_of(name, content.units) is quantity and not name.endswith("_residual")
            ),
        )
        for quantity in wanted
    ]
    return [panel for panel in found if panel.names]


def send_histories(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Send curves over `t` as given, over `step` and `stage` at the steps."""
    times = np.asarray(content.histories.get("time", ()), float)
    for panel in panels(content) if len(times) else ():
        values = panel.values(content.histories)
        recording.send_columns(panel.path, [seconds(times)], rr.Scalars.columns(scalars=values))
        if len(clock.times):
            at_steps = np.column_stack(
                [
                    np.interp(clock.times, times, column, left=np.nan, right=np.nan)
                    for column in values.T
                ]
            )
            recording.send_columns(
                panel.path, clock.counted(), rr.Scalars.columns(scalars=at_steps)
            )


def log_series(recording: rr.RecordingStream, panel: Panel) -> None:
    """Log names and colours of the curves of a panel."""
    palette = [SERIES_COLOURS[i % len(SERIES_COLOURS)] for i in range(len(panel.names))]
    recording.log(
        panel.path,
        rr.SeriesLines(names=panel.labels, colors=colours(palette), widths=1.5),
        static=True,
    )
