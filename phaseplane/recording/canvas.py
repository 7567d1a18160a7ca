"""A picture in rerun: the page that stays, the ticks of a story, and the curves that grow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.canvas import Canvas
from phaseplane.picture.page import Arrow, Dots, Lines, Page, Text
from phaseplane.picture.paper import Points, Strip
from phaseplane.picture.styles import style_of

from .columns import (
    LINE_UP,
    UPRIGHT,
    Integers,
    colours,
    legible,
    line_style,
    radii,
    rgba,
    strips,
    xy,
)

BLOCK = 128
"""Steps in a block of a long curve, which the viewer draws as one row."""
RECENT = 200
"""Steps of a curve that are drawn in full, more than a block."""
_FAINT = 0.35  # opacity of older steps
_HEAD = 0.5  # length of the head of an arrow, em


class Viewer(Canvas):
    """A canvas of the viewer, under the path `root`.

    Parameters
    ----------
    recording : to which it is logged
    root : path of its entities
    columns : returns the time columns of the steps with some numbers, for `curve`
    """

    def __init__(
        self,
        recording: rr.RecordingStream,
        root: str,
        columns: Callable[[Integers], Sequence[rr.TimeColumn]],
    ) -> None:
        self.recording = recording
        self.root = root
        self.columns = columns
        self.ticks = 0
        self._begun: set[str] = set()
        self._held: dict[str, tuple[int, Points]] = {}  # the block under way of each curve

    def begin(self, page: Page) -> None:
        """Log what stays."""
        self.recording.log(self.root, UPRIGHT, static=True)
        self._page(page, "paper", static=True)

    def frame(self, page: Page) -> None:
        """Log the next tick of the timeline `stage`."""
        self.recording.set_time("stage", sequence=self.ticks)
        self._page(page, "story", static=False)
        self.ticks += 1

    def curve(self, name: str, role: str, ways: Points, first: int) -> None:
        """Log the ways of some steps, each as a row, and finished blocks of steps as one row each."""
        path = f"{self.root}/{role}/{name}"
        if path not in self._begun:
            self._begun.add(path)
            self.recording.log(f"{path}/recent", line_style([role]), static=True)
            self.recording.log(f"{path}/past", line_style([role], [_FAINT], 0.4), static=True)
        if not len(ways):
            return
        rows = first + 1 + np.arange(len(ways))
        self.recording.send_columns(
            f"{path}/recent", self.columns(rows), rr.LineStrips2D.columns(strips=strips(ways))
        )
        start, held = self._held.get(path, (first, ways[:0]))
        if held.shape[1:] != ways.shape[1:]:
            held = ways[:0]
            start = first
        held = np.concatenate([held, ways])
        whole = len(held) // BLOCK
        if whole:
            blocks = held[: whole * BLOCK].reshape(whole, -1)
            ends = start + BLOCK * (1 + np.arange(whole))
            self.recording.send_columns(
                f"{path}/past", self.columns(ends), rr.LineStrips2D.columns(strips=strips(blocks))
            )
        self._held[path] = start + whole * BLOCK, held[whole * BLOCK :]

    def end(self) -> None:
        """Leave the last tick."""
        self.recording.reset_time()

    def _page(self, page: Page, name: str, *, static: bool) -> None:
        lines = [item for item in page.items if isinstance(item, Lines)]
        flat = [(strip, line) for line in lines for strip in line.strips]
        arrows = [item for item in page.items if isinstance(item, Arrow)]
        drawn = [xy(strip) for strip, _ in flat] + [
            xy(strip) for arrow in arrows for strip in _arrow(arrow, page.em)
        ]
        looks = [(line.role, line.weight, line.strength) for _, line in flat] + [
            (arrow.role, 1.0, 1.0) for arrow in arrows for _ in _arrow(arrow, page.em)
        ]
        self._log(
            f"{name}/lines",
            rr.LineStrips2D(
                drawn,
                colors=colours([rgba(style_of(r).hue, s) for r, _, s in looks]),
                radii=radii([style_of(r).width * w for r, w, _ in looks]),
            ),
            static=static,
        )
        dots = [(z, item) for item in page.items if isinstance(item, Dots) for z in item.points]
        self._log(
            f"{name}/points",
            rr.Points2D(
                xy([z for z, _ in dots]).reshape(-1, 2),
                colors=colours([rgba(style_of(d.role).hue, d.strength) for _, d in dots]),
                radii=radii([style_of(d.role).size * d.weight for _, d in dots]),
            ),
            static=static,
        )
        self._log(f"{name}/letters", letters(page.texts, page.em), static=static)

    def _log(self, name: str, what: Any, *, static: bool) -> None:
        self.recording.log(f"{self.root}/{name}", what, static=static)


def letters(texts: Sequence[Text], em: float) -> rr.Points2D:
    """Return texts as points without size; the viewer centres a text just below its anchor."""
    places = [text.centre + LINE_UP * 1j * em for text in texts]
    return rr.Points2D(
        xy(places).reshape(-1, 2),
        colors=colours([rgba(style_of(text.role).hue) for text in texts]),
        radii=0.0,
        labels=[legible(text.text) for text in texts],
        show_labels=True,
    )


def placed_letters(
    centres: Points, shown: npt.NDArray[np.bool_], texts: Sequence[str], em: float
) -> tuple[Any, Any]:
    """Return the columns of letters that move with the steps, and how many there are in each."""
    place = (centres + LINE_UP * 1j * em)[shown]
    labels = np.broadcast_to(np.array([legible(text) for text in texts], object), centres.shape)
    return (
        rr.Points2D.columns(positions=xy(place), labels=labels[shown].tolist()),
        shown.sum(axis=1),
    )


def _arrow(arrow: Arrow, em: float) -> list[Strip]:
    """Return the lines of an arrow."""
    way = arrow.tip - arrow.start
    if way == 0.0:
        return []
    along = _HEAD * em * way / abs(way)
    heads = [(arrow.tip, along)] + ([(arrow.start, -along)] if arrow.both else [])
    strips: list[Strip] = [(arrow.start, arrow.tip)] if arrow.shaft else []
    return strips + [(z - a + 0.35j * a, z, z - a - 0.35j * a) for z, a in heads]
