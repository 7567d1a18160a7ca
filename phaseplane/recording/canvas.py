"""A picture in rerun: the page that stays, the ticks of a story, and the curves that grow."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any

import numpy as np
import rerun as rr

from phaseplane.picture.items import Arrow, Dots, Lines
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Points, Strip
from phaseplane.picture.styles import MOVING_POINT, style_of

from .columns import (
    LETTERS_FIRST,
    LINE_UP,
    UPRIGHT,
    Clock,
    Integers,
    legible,
    line_style,
    point_style,
    radii,
    ragged,
    send,
    shades,
    strips,
    xy,
)

BLOCK = 128  # steps in a block of a long curve, which the viewer draws as one row
PARTS = ("lines", "points", "letters")  # the entities of a page
# the draw order of the lines of each page; those of `stage` have neighbouring depths
_ORDER = {"paper": 11.0, "story": 13.0, "events": 21.0}
_FAINT = 0.35  # opacity of older steps
_HEAD = 0.5  # length of the head of an arrow, em


class Viewer:
    """A canvas of the viewer, whose entities are under the path `root`."""

    def __init__(self, recording: rr.RecordingStream, root: str, clock: Clock) -> None:
        self.recording, self.root, self.clock = recording, root, clock
        self._ticks: list[Page] = []
        self._begun: set[str] = set()

    def begin(self, page: Page) -> None:
        """Log what stays."""
        self.recording.log(self.root, UPRIGHT, static=True)
        self._send("paper", [page], [])

    def frame(self, page: Page) -> None:
        """Store the next tick of the timeline `stage`; `end` logs all of them at once, to save time."""
        self._ticks.append(page)

    def curve(
        self, name: str, role: str, ways: Points, first: int,
        columns: Callable[[Integers], Sequence[rr.TimeColumn]], *, winds: bool = True,
    ) -> None:  # fmt: skip
        """Log more of a growing curve: each step as a row, and blocks of steps as one row each.

        Parameters
        ----------
        ways : of some steps, shape (steps, vertices)
        first : number of the first of these steps
        columns : returns the time columns of the steps with some numbers
        winds : whether the curve is so long that its older parts must be faint
        """
        path = f"{self.root}/{role}/{name}"
        if path not in self._begun:
            self._begun.add(path)
            past = (_FAINT, 0.4) if winds else (1.0, 1.0)
            for part, strength, weight in (("recent", 1.0, 1.0), ("past", *past)):
                style = line_style([role], [strength], weight, beneath=role == "run")
                self.recording.log(f"{path}/{part}", style, static=True)
        if not len(ways):
            return
        rows = first + 1 + np.arange(len(ways))
        self.recording.send_columns(
            f"{path}/recent", columns(rows), rr.LineStrips2D.columns(strips=strips(ways))
        )
        starts = np.arange(0, len(ways), BLOCK)
        ends = np.minimum(starts + BLOCK, len(ways))
        blocks = [ways[start:end].ravel() for start, end in zip(starts, ends, strict=True)]
        self.recording.send_columns(
            f"{path}/past", columns(first + ends), rr.LineStrips2D.columns(strips=ragged(blocks))
        )

    def move(self, name: str, z: Points, times: Sequence[rr.TimeColumn]) -> None:
        """Log moving points, shape (times, points)."""
        roles = [role for role in MOVING_POINT for _ in range(z.shape[1])]
        discs = rr.Points2D.columns(positions=xy(np.tile(z, len(MOVING_POINT)).ravel()))
        columns = discs.partition([len(roles)] * len(z))
        send(self.recording, f"{self.root}/{name}", point_style(roles, 1.2), times, columns)

    def line(self, name: str, role: str, z: Points, times: Sequence[rr.TimeColumn]) -> None:
        """Log a moving line, shape (times, vertices)."""
        columns = rr.LineStrips2D.columns(strips=strips(z))
        send(self.recording, f"{self.root}/{name}", line_style([role]), times, columns)

    def mark(self, pages: Sequence[Page], times: Sequence[rr.TimeColumn]) -> None:
        """Log marks that stay once their time has come, a page for each time."""
        self._send("events", pages, times)

    def end(self) -> None:
        """Log the ticks."""
        if self._ticks:
            self._send("story", self._ticks, self.clock.staged())

    def _send(self, name: str, pages: Sequence[Page], times: Sequence[rr.TimeColumn]) -> None:
        """Log pages, each at one of these times; without times it stays."""
        lines = _ORDER[name]
        of = (_lines(pages, lines), _points(pages, lines + 1.0), _letters(pages))
        for part, columns in zip(PARTS, of, strict=True):
            self.recording.send_columns(f"{self.root}/{name}/{part}", times, columns)


def _lines(pages: Sequence[Page], order: float) -> list[Any]:
    """Return the lines of pages, a row for each, the arrows behind all others; and their draw order."""
    rows = [
        [(strip, i.role, i.weight, i.strength) for i in page.of(Lines) for strip in i.strips]
        + [(strip, i.role, 1.0, 1.0) for i in page.of(Arrow) for strip in _arrow(i, page.em)]
        for page in pages
    ]
    every = list(chain.from_iterable(rows))
    return _columns(
        rr.LineStrips2D, rows, {"draw_order": order},
        strips=ragged([strip for strip, *_ in every]),
        colors=shades([role for _, role, *_ in every], [strength for *_, strength in every]),
        radii=radii([style_of(role).width * weight for _, role, weight, _ in every]),
    )  # fmt: skip


def _points(pages: Sequence[Page], order: float) -> list[Any]:
    """Return the points of pages, a row for each, and their draw order."""
    rows = [[(z, dots) for dots in page.of(Dots) for z in dots.points] for page in pages]
    every = list(chain.from_iterable(rows))
    return _columns(
        rr.Points2D, rows, {"draw_order": order},
        positions=xy([z for z, _ in every]).reshape(-1, 2),
        colors=shades([dots.role for _, dots in every], [dots.strength for _, dots in every]),
        radii=radii([style_of(dots.role).size * dots.weight for _, dots in every]),
    )  # fmt: skip


def _letters(pages: Sequence[Page]) -> list[Any]:
    """Return the texts of pages, a row for each, as points without size.

    The viewer centres a text just below its anchor.
    """
    rows = [[(text, page.em) for text in page.texts] for page in pages]
    every = list(chain.from_iterable(rows))
    up = [LINE_UP * (1 + text.text.count("\n")) * 1j * em for text, em in every]
    return _columns(
        rr.Points2D, rows, {"radii": 0.0, "show_labels": True, "draw_order": LETTERS_FIRST},
        positions=xy([text.centre + z for (text, _), z in zip(every, up, strict=True)]).reshape(-1, 2),
        colors=shades([text.role for text, _ in every], [text.strength for text, _ in every]),
        labels=[legible(text.text) for text, _ in every],
    )  # fmt: skip


def _columns(
    kind: Any, rows: Sequence[Sequence[object]], each: Mapping[str, object], **items: object
) -> list[Any]:
    """Return the columns of the items in all rows, and of what each row has once."""
    once = {name: [value] * len(rows) for name, value in each.items()}
    return [*kind.columns(**items).partition([len(row) for row in rows]), *kind.columns(**once)]


def _arrow(arrow: Arrow, em: float) -> list[Strip]:
    way = arrow.tip - arrow.start
    if way == 0.0:
        return []
    along = _HEAD * em * way / abs(way)
    heads = [(arrow.tip, along)] + ([(arrow.start, -along)] if arrow.both else [])
    strips: list[Strip] = [(arrow.start, arrow.tip)] if arrow.shaft else []
    return strips + [(z - a + 0.35j * a, z, z - a - 0.35j * a) for z, a in heads]
