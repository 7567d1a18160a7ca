"""The process that draws a run live; its failure does not affect the run.

It reads pickled orders from its standard input, `Begin`, then some rows of the run at a time, then the
content of the whole run, and answers each with a byte. `live` starts it.
"""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from uuid import uuid4

import numpy as np
import rerun as rr
from rerun.experimental import ViewerClient

from phaseplane.picture.paper import Reals

from .content import Content
from .histories import panels_of
from .lanes import send_lanes
from .layout import blueprint
from .recorder import Recorder
from .sinks import new_recording, record

DONE, FILED = b"d", b"f"  # filed: written, but no longer shown


@dataclass(frozen=True, slots=True)
class Begin:
    """The data known before the run, and the sinks of the drawing."""

    content: Content
    url: str
    draft: str
    path: str


class Drawer:
    """Draws the rows that it receives, and the steps of the construction that they have passed."""

    def __init__(self, order: Begin) -> None:
        self.order = order
        self.recording = new_recording(order.content, uuid4().hex)
        self.recording.set_sinks(
            *([rr.GrpcSink(order.url)] if order.url else []),
            *([rr.FileSink(order.draft)] if order.draft else []),
        )
        self._begin(order.content)
        self.viewer: ViewerClient | None = None
        if order.url:
            with suppress(RuntimeError, ConnectionError, ValueError):  # if none answers there
                self.viewer = ViewerClient(order.url)
        self.shown = True
        self.last: dict[str, Reals] = {}
        self.reach: dict[str, Reals] = {}

    def _begin(self, content: Content) -> None:
        self.recorder = Recorder(self.recording, content)
        self.recording.send_blueprint(blueprint(self.recorder))
        self.recorder.begin()
        self.recording.flush()
        self.steps = 0  # of the construction that are drawn

    def take(self, rows: dict[str, Reals]) -> None:
        """Draw more rows of the run."""
        if self.shown:
            self._unless_filed(self._go_on, rows)

    def _go_on(self, rows: dict[str, Reals]) -> None:
        """Continue drawing from the last row before these."""
        columns = {
            name: np.concatenate([self.last.get(name, column[:0]), column])
            for name, column in rows.items()
            if name in self.order.content.histories
        }
        self.last = {name: column[-1:] for name, column in columns.items()}
        self._reach_out(columns)
        self.recorder.run(columns)
        self._construct(float(columns["time"][-1]))
        self.recording.flush()
        if self.viewer is not None:  # until it has drawn, so that late rows are skipped, not queued
            try:
                self.viewer.get_state()
            except (RuntimeError, ConnectionError):  # a server of recordings draws nothing
                self.viewer = None

    def _construct(self, time: float) -> None:
        """Draw the steps that have ended by a time: nothing that has not happened."""
        times = self.recorder.clock.times
        passed = int(np.searchsorted(times, time * (1.0 + 1e-12), side="right")) - 1
        if passed > self.steps:
            self.recorder.steps(self.steps, passed)
            self.steps = passed

    def _reach_out(self, columns: dict[str, Reals]) -> None:
        """Redraw the axes if the motion goes beyond them."""
        content = self.order.content
        if content.constructed is not None or not self.recorder.pages:
            return
        grown = False
        for name in (name for pair in content.pairs for name in pair):
            before = self.reach.get(name, np.zeros(2))
            seen = np.concatenate([before, columns[name]])
            self.reach[name] = np.array([np.nanmin(seen), np.nanmax(seen)])
            grown |= bool((self.reach[name] != before).any())
        if grown:
            self.recorder.redraw(self.reach)

    def complete(self, whole: Content) -> None:
        """Draw the rest of the construction and its story, and rewrite the file of the whole run."""
        if self.order.url and self.shown:
            self._unless_filed(self._tell, whole)
        if self.order.path:
            record(whole, self.order.path)
            os.unlink(self.order.draft)

    def _tell(self, whole: Content) -> None:
        """Draw what is left, and the story on its own timeline.

        The view stays where it is, unless all its plots are of what is known only now, as energies are.
        """
        if panels_of(whole) and not self.recorder.panels:
            self._begin(whole)
        content = self.recorder.content
        columns = {n: np.asarray(whole.histories[n], float) for n in content.histories}
        if content.live:
            late = columns["time"] > (self.last["time"] if self.last else -np.inf)
            if late.any():  # rows that came after those that were taken last
                self._go_on({name: column[late] for name, column in columns.items()})
        self._construct(np.inf)
        if content.live:
            content = replace(content, drawing=whole.drawing)
            self.recorder = Recorder(self.recording, content)  # whose story knows the drift
            self.recorder.content = replace(content, histories=columns)
            self.recorder.describe(0, self.steps)  # with the drift, and the end of the run
            known = replace(self.recorder.content, live=False)
            send_lanes(self.recording, known, self.recorder.clock)  # at all ticks
        else:
            self.recorder.run(columns)
        self.recorder.story()
        self.recording.flush()

    def _unless_filed(self, draw: Callable[..., None], *what: object) -> None:
        """Draw; ignore the loss of the viewer if a file remains to be written."""
        try:
            draw(*what)
        except Exception:  # any error of rerun when the viewer has gone
            if not (self.order.url and self.order.path):
                raise
            self.shown = False


def main() -> None:
    """Follow orders until the input ends; only answers go to standard output."""
    answers = os.dup(1)
    os.dup2(2, 1)
    drawer: Drawer | None = None
    while True:
        try:
            order = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        if drawer is None:
            drawer = Drawer(order)
        elif isinstance(order, Content):
            drawer.complete(order)
        else:
            drawer.take(order)
        filed = isinstance(order, Content) and not drawer.shown
        os.write(answers, FILED if filed else DONE)
