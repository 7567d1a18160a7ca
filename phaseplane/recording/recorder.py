"""The whole content of a recording, logged part by part to any sink."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.chart import Chart
from phaseplane.picture.curves import draw_trails
from phaseplane.picture.letters import Room
from phaseplane.picture.page import Page
from phaseplane.picture.readings import Readings
from phaseplane.picture.step import event_pages, mark_events
from phaseplane.picture.story import VERTICES, Tick, arms_page, story_of
from phaseplane.picture.subject import joined
from phaseplane.picture.text import motion_text

from .canvas import Viewer, legible, send
from .clock import Clock, seconds
from .content import Content
from .histories import log_series, panels_of, send_at_ticks, send_histories, send_readings
from .lanes import lanes_shown, send_lanes
from .motion import is_narrow, pages_of, state_planes, thinned
from .side_view import log_vehicle, send_vehicle, vehicle_of
from .steps import ARMS, CHART, SHEET, SLICE, WORDS, send_steps

_PATIENCE = 60.0  # s; once its writer has failed, rerun may wait for it for ever
# heights of the pane of the turn angles, relative to that for which they are drawn: above so many lanes,
# and in a column beside the text
_ABOVE_LANES, _APART = (1.0, 0.8, 0.73), 1.3
MOST_ROWS = 4000
"""Rows of a run that are drawn in its planes."""


class Recorder:
    """Logs a content: the permanent parts, then steps and rows in order, then the story.

    Raises
    ------
    ValueError : see `Content.check`.
    """

    def __init__(self, recording: rr.RecordingStream, content: Content) -> None:
        content.check()
        self.recording, self.content = recording, content
        self.sheet, self.arms, self.over_time = (
            Viewer(recording, root) for root in (SHEET, ARMS, CHART)
        )
        self.panels = panels_of(content)
        self.pages = pages_of(content)  # those that stay: the whole sheet, and one for each plane
        self.ticks: list[Tick] = []
        if content.detail == "stages" and self.arms_page is not None:
            story = story_of(self.pages[0], self.arms_page, content.staged, content.heading)
            self.ticks = list(story)
        self.clock = Clock.of(content.drawing, [tick.time for tick in self.ticks])

    @cached_property
    def lettered(self) -> Page:
        """The whole motion with the letters of its events, which all others keep clear of."""
        page = self.pages[0].following()
        if page.drawing.frames.events:
            draw_trails(page, most=VERTICES)
            mark_events(page)
        return page

    @cached_property
    def room(self) -> Room:
        """The room for the letters of steps: neither on texts nor on the whole motion."""
        page = self.lettered
        return Room(page.view, page.em, page.taken, map(joined, page.subject.ways))

    @cached_property
    def arms_page(self) -> Page | None:
        """The arm of the turn angles, if steps are drawn."""
        drawing = self.content.constructed if self.content.detail != "trail" else None
        if drawing is None:
            return None
        content = self.content
        high = _APART if is_narrow(content) else _ABOVE_LANES[lanes_shown(content)]
        return arms_page(drawing, height=high)

    @cached_property
    def readings(self) -> Readings:
        """The readings of the construction."""
        assert self.content.drawing is not None
        return Readings(self.content.drawing)

    @cached_property
    def chart(self) -> Chart | None:
        """The displacements, or else other readings, over the time of the construction."""
        content = self.content
        drawing = content.constructed if content.shows("histories") and not content.live else None
        drawn = [panel for panel in self.panels if panel.drawn]
        if drawing is None or not drawn:
            return None
        planes = [plane.name for plane in drawing.planes]
        wanted = (p for p in drawn if p.quantity.si == "m" or planes[0] in p.drawn)
        shown = next(wanted, drawn[0])
        names = tuple(sorted(shown.drawn, key=lambda name: name not in planes))
        return Chart(drawing, content.histories, names, shown.quantity)

    @property
    def words(self) -> bool:
        """Whether steps are described."""
        content = self.content
        return content.drawing is not None and content.shows("words") and content.detail != "trail"

    @property
    def note(self) -> str:
        """What is seen where no steps are described; empty if no words are wanted."""
        if self.words or not self.content.shows("words"):
            return ""
        return motion_text(
            planes=bool(self.pages), vehicle=vehicle_of(self.content) is not None,
            plots=bool(self.panels),
        )  # fmt: skip

    def all(self) -> None:
        """Log the whole content, and wait until it is written.

        Raises
        ------
        RuntimeError : if it cannot be written or sent.
        """
        self.begin()
        drawing = self.content.drawing
        self.steps(0, len(drawing.frames) if drawing is not None else 0)
        self.run({name: self.content.column(name) for name in self.content.histories})
        self.story()
        self.recording.flush(timeout_sec=_PATIENCE)

    def begin(self) -> None:
        """Log everything that is known before a run: axes, curves, shapes, names."""
        content = self.content
        # in the list of recordings, below the title
        self.recording.send_recording_name(legible(content.manner or content.title))
        if self.pages:
            self._lay(content)
        if self.arms_page is not None:
            self.arms.begin(self.arms_page)
        if self.chart is not None:
            self.over_time.begin(self.chart.stays)
        log_vehicle(self.recording, content)
        if self.note:
            words = rr.TextDocument(self.note, media_type=rr.MediaType.MARKDOWN)
            self.recording.log(WORDS, words, static=True)
        for panel in self.panels:
            log_series(self.recording, panel, content)

    def steps(self, first: int, last: int) -> None:
        """Log a range of the steps of the construction."""
        for start, end in self._slices(first, last):
            self._slice(start, end)

    def describe(self, first: int, last: int) -> None:
        """Log the descriptions of a range of steps anew, as they are with a drift that is known now."""
        for start, end in self._slices(first, last):
            self._describe(start, end)

    def _slices(self, first: int, last: int) -> Iterator[tuple[int, int]]:
        """Yield parts of a range of steps, each written before the next: memory does not grow."""
        for start in range(first, last, SLICE):
            yield start, min(last, start + SLICE)
            self.recording.flush(timeout_sec=_PATIENCE)

    def _slice(self, start: int, end: int) -> None:
        drawing = self.content.drawing
        assert drawing is not None
        ends = end == len(drawing.frames)
        if self.content.constructed is not None:
            subject = self.pages[0].subject
            for plane, way in zip(drawing.planes, subject.ways, strict=True):
                self.sheet.curve(
                    plane.name, "trail", way[start:end],
                    lambda rows: self.clock.columns(start + rows), winds=subject.winds,
                )  # fmt: skip
            here = np.stack(subject.motions, 1)[start : None if ends else end]
            now = self.clock.columns(start + np.arange(len(here)))
            self.sheet.move("steps/here", here, now)
            marked = [i for i in drawing.frames.events if start <= i < end]
            if marked:
                marks = event_pages(self.lettered, marked)
                self.sheet.show("events", marks, self.clock.columns(np.array(marked)))
            if self.content.detail != "trail":
                send_steps(self.recording, drawing, self.room, self.clock, start, end)
        self._describe(start, end)
        if self.chart is not None:
            cursors = np.array([self.chart.cursor(t) for t in self.clock.times[start:end]])
            now = self.clock.columns(np.arange(start, end))
            self.over_time.line("cursor", "value", cursors, now)
        send_readings(self.recording, self.panels, drawing, self.clock, start, end)

    def _describe(self, start: int, end: int) -> None:
        """Log the descriptions of some steps, and what the construction comes to in the end."""
        drawing = self.content.drawing
        if not self.words or drawing is None:
            return
        texts = self.readings.step_texts(drawing.frames[start:end])
        if end == len(drawing.frames):
            run = float(np.max(self.content.times, initial=0.0))
            texts.append(self.readings.end_text(run))
        self._say(texts, self.clock.columns(start + np.arange(len(texts))))

    def run(self, histories: dict[str, np.ndarray]) -> None:
        """Log the motion given by the columns of a run, or by some of their rows."""
        part = replace(self.content, histories=histories)
        few = thinned(histories, MOST_ROWS)
        if len(few.get("time", ())) > 1:
            self._send_run(few)
        send_vehicle(self.recording, part, self.clock)
        send_histories(self.recording, self.panels, part)
        send_lanes(self.recording, part, self.clock)

    def _send_run(self, histories: dict[str, np.ndarray]) -> None:
        """Log the motion in all planes; its steps are those between rows, on `t`.

        Without a construction it is in the units of its columns, and the planes place it on the sheet.
        """
        times, drawn = histories["time"], self.content.constructed is not None
        for plane in state_planes(self.content):
            z = plane.motion(histories) if drawn else plane.states(histories)
            self.sheet.curve(
                plane.path, "run" if drawn else "trail", np.stack([z[:-1], z[1:]], 1),
                lambda rows: [seconds(times[rows])],
            )  # fmt: skip
            if not drawn:
                self.sheet.move(f"trail/{plane.path}/here", z[:, None], [seconds(times)])

    def redraw(self, histories: Mapping[str, npt.ArrayLike]) -> None:
        """Log the axes and the places of planes anew, for columns that reach beyond them."""
        whole = {name: histories.get(name, np.zeros(2)) for name in self.content.histories}
        content = replace(self.content, histories=whole)
        self.pages = pages_of(content)
        self._lay(content)

    def _lay(self, content: Content) -> None:
        """Log the sheet, and the places on it of the planes in which a run is drawn by itself."""
        self.sheet.begin(self.pages[0])
        for plane in state_planes(content) if content.constructed is None else ():
            self.recording.log(f"{SHEET}/trail/{plane.path}", plane.transform, static=True)

    def story(self) -> None:
        """Log the story on the timeline `stage`, and the plots of a whole run at all ticks."""
        send_at_ticks(self.recording, self.panels, self.content, self.clock)
        if not self.ticks:
            return
        times = self.clock.story
        self.sheet.show("story", [tick.page for tick in self.ticks], times)
        self.arms.show("story", [tick.arms for tick in self.ticks], times)
        if self.chart is not None:
            self.over_time.show("story", [self.chart.upto(tick.step) for tick in self.ticks], times)
        if self.words:
            self._say([tick.text for tick in self.ticks], times)

    def _say(self, texts: Sequence[str], times: Sequence[rr.TimeColumn]) -> None:
        style = rr.TextDocument.from_fields(media_type=rr.MediaType.MARKDOWN)
        columns = rr.TextDocument.columns(text=[legible(text) for text in texts])
        send(self.recording, WORDS, style, times, columns)
