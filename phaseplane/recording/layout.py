"""The layout of a recording in the viewer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from phaseplane.constructions.letters import typeset
from phaseplane.equations.typeset import number
from phaseplane.picture.curves import RECENT
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Box
from phaseplane.picture.text import in_words

from .canvas import PARTS, legible
from .content import Content
from .histories import MOST_NAMED, Panel
from .lanes import LANES, lanes_height
from .motion import SHEET_HEIGHT, SHEET_WIDTH, WINDOW_WIDTH, is_narrow, state_planes
from .recorder import MOST_ROWS, Recorder
from .side_view import VEHICLE, vehicle_of, view_box
from .steps import ARMS, CHART, SHEET, WORDS

_STAGES_PER_SECOND = 1.0
_LONGEST = 60.0  # s that the viewer takes to play the motion
_LIVE = 1.0  # s of a live run that are drawn in full
_NOTE = 0.44  # height of a note of seven rows, relative to what is below it
_ROUNDING = 1e-6  # of the range of a plot: an end that is as good as zero

# heights in a window of 1366x768, pixels: of the side view and the turn angles, and of the plots, each
# without and with the text of steps; and of that text; together they fill what lanes leave of a column
_BESIDE, _PLOTS, _WORDS = (280.0, 108.0), (420.0, 145.0), 388.0
_TEXT_WIDTH = 470.0  # of that text beside a narrow sheet, with a table of five columns
_FRAME, _NAME = 60.0, 23.0  # heights of what is around the names in a plot, and of a name

Part = tuple[float, rrb.View | rrb.Container]
"""A part of a column with its share of the height."""


def blueprint(recorder: Recorder) -> rrb.Blueprint:
    """Return the layout: the sheet, and next to it the text, the side view, the plots and the lanes.

    Beside a narrow sheet, the text of steps has a column of its own, with the plots, whose names need
    its width. During a live run the viewer stays at the latest time.

    Raises
    ------
    ValueError : if there is nothing to see, and no run under way that may add it.
    """
    content, narrow = recorder.content, is_narrow(recorder.content)
    sheet: list[Part] = []
    if recorder.pages:
        sheet.append((SHEET_HEIGHT, _sheets(content, recorder.pages)))
    text: list[Part] = []
    others = _views(recorder)
    plots = _plots(recorder, alone=not (recorder.words or others))
    apart = narrow and recorder.words and bool(others)
    if not apart:
        others += plots
    if recorder.words:
        text.append((_WORDS, rrb.TextDocumentView(origin=WORDS, name="construction step")))
    elif recorder.note:  # a few lines, above what they are about
        height = _NOTE * sum(share for share, _ in others)
        text.append((height or 1.0, rrb.TextDocumentView(origin=WORDS, name="what is seen")))
    width = SHEET_WIDTH[narrow]
    beside = {WINDOW_WIDTH - width: text + others}
    if apart:
        beside = {_TEXT_WIDTH: text + plots, WINDOW_WIDTH - width - _TEXT_WIDTH: others}
    columns = {width: parts for width, parts in ({width: sheet} | beside).items() if parts}
    height = lanes_height(content)
    if height:
        *_, above = columns.values() or [columns.setdefault(width, [])]
        time = None if content.live else _whole_time()
        lanes = rrb.StateTimelineView(origin=LANES, name="lanes", time_view=time)
        above.append((_share(height, above), lanes))
    if not columns and not content.live:
        views = ", ".join(content.views) or "none"
        raise ValueError(f"nothing of {content.title!r} is to be seen in its views: {views}")
    return rrb.Blueprint(
        rrb.Horizontal(*map(_column, columns.values()), column_shares=list(columns)),
        _time_panel(recorder),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _column(parts: Sequence[Part]) -> rrb.View | rrb.Container:
    shares, views = zip(*parts, strict=True)
    return views[0] if len(views) == 1 else rrb.Vertical(*views, row_shares=list(shares))


def _share(height: float, above: Sequence[Part]) -> float:
    """Return the share of a height in pixels below parts that fill the rest of a column."""
    return height * (sum(share for share, _ in above) or 1.0) / (SHEET_HEIGHT - height)


def _views(recorder: Recorder) -> list[Part]:
    """Return the side view with the turn angles."""
    content = recorder.content
    views: list[rrb.View] = []
    vehicle = vehicle_of(content)
    if vehicle is not None:
        views.append(_view(VEHICLE, "side view", view_box(vehicle, content)))
    if recorder.arms_page is not None:
        views.append(_view(ARMS, "turn angles", recorder.arms_page.view))
    height = _BESIDE[recorder.words]
    if views and is_narrow(content):
        return [(height * len(views), rrb.Vertical(*views))]
    return [(height, rrb.Horizontal(*views))] if views else []


def _plots(recorder: Recorder, *, alone: bool) -> list[Part]:
    """Return the chart and the plots in tabs; alone, as many below each other as have room for names."""
    content = recorder.content
    plots: list[Part] = [(_height(p.names), _plot(p, content)) for p in recorder.panels]
    if (chart := recorder.chart) is not None:
        plots.insert(0, (_height(chart.names), _view(CHART, "over time", chart.stays.view)))
    if not plots:
        return []
    if not alone:
        return [(_PLOTS[recorder.words], rrb.Tabs(*(view for _, view in plots)))]
    for below in (2, 1, 0):
        parts, tabs = plots[:below], plots[below:]
        if tabs:
            parts = [*parts, _tabs(tabs)]
        if sum(height for height, _ in parts) <= _PLOTS[False]:
            break
    return [(_PLOTS[False], _column(parts))]


def _height(names: Sequence[str]) -> float:
    """Return the height of a plot in which the names of its curves have room, pixels."""
    return _FRAME + (_NAME * len(names) if len(names) <= MOST_NAMED else 0.0)


def _tabs(plots: Sequence[Part]) -> Part:
    """Return plots in tabs, as high as the one in front, which is that of the road."""
    heights, views = zip(*plots, strict=True)
    front = next((k for k, view in enumerate(views) if str(view.name).startswith("road")), 0)
    return heights[front], rrb.Tabs(*views, active_tab=front)


def _time_panel(recorder: Recorder) -> rrb.TimePanel:
    content = recorder.content
    if content.live or content.drawing is None:
        duration = float(np.max(content.times, initial=0.0))
        speed = 1.0 if content.live else min(1.0, duration / 10.0) or 1.0
        return rrb.TimePanel(
            state="collapsed", timeline="t", playback_speed=speed, fps=_STAGES_PER_SECOND / speed,
            play_state="following" if content.live else "playing",
        )  # fmt: skip
    if recorder.ticks:
        rate = _STAGES_PER_SECOND * recorder.clock.stride
    else:
        rate = max(_STAGES_PER_SECOND, len(content.drawing.frames) / _LONGEST)
    # the speed makes the motion on `t` last as long; stages and steps pass at fps times the speed
    speed = float(np.ptp(recorder.clock.times)) / _LONGEST
    return rrb.TimePanel(
        state="collapsed", timeline="stage" if recorder.ticks else "step", playback_speed=speed,
        fps=rate / speed, play_state="playing", loop_mode="all",
    )  # fmt: skip


def _sheets(content: Content, pages: Sequence[Page]) -> rrb.View | rrb.Container:
    """Return the view of the whole sheet, and with several planes one of each, or a grid of them."""
    together = is_narrow(content)  # one below the other on the sheet, they are small
    shared = Counter(displacement for displacement, _ in content.pairs)
    names = [in_words(f"{y}, {rate}" if shared[y] > 1 else y) for y, rate in content.pairs]
    if content.constructed is not None:
        names = [
            typeset(plane.displacement.label) + f", {in_words(plane.name)}" * together
            for plane in content.constructed.planes
        ]
    names.insert(0, (content.manner if together else "") or content.heading)
    whole, *single = (_sheet(content, page, name) for page, name in zip(pages, names, strict=False))
    if together:
        return rrb.Tabs(whole, rrb.Grid(*single, grid_columns=2, name="each plane"), active_tab=0)
    return rrb.Tabs(whole, *single, active_tab=0) if single else whole


def _sheet(content: Content, page: Page, name: str) -> rrb.Spatial2DView:
    times, drawing = content.times, content.constructed
    rows = min(len(times), MOST_ROWS) - 1
    step = (float(np.ptp(times)) if len(times) else _LIVE) / max(rows, RECENT)  # s
    run = [plane.path for plane in state_planes(content)]
    curves = [("trail", run, rows, step)]
    overrides: dict[str, rrb.VisibleTimeRanges] = {}
    if drawing is not None:
        frames = drawing.frames
        lasts = frames[-1].time + frames[-1].duration - frames[0].time
        drawn = lasts / max(len(frames), RECENT)
        # no run is seen in full where the construction over it is faint
        curves = [
            ("trail", [plane.name for plane in drawing.planes], len(frames), drawn),
            ("run", run, rows, min(step, drawn)),
        ]
        overrides |= {f"{SHEET}/events/{part}": _ranges(None) for part in PARTS}
    for role, paths, steps, step in curves:
        recent = _ranges(None if 0 < steps <= RECENT else RECENT, step)
        for path in (f"{SHEET}/{role}/{path}" for path in paths):
            overrides |= {f"{path}/past": _ranges(None), f"{path}/recent": recent}
    return _view(SHEET, legible(name), page.view, overrides=overrides)


def _ranges(steps: int | None, step: float = 0.0) -> rrb.VisibleTimeRanges:
    """Return the last steps, of this duration, or all, up to the cursor on `t` and `step`."""
    relative, infinite = rrb.TimeRangeBoundary.cursor_relative, rrb.TimeRangeBoundary.infinite()
    starts = {"t": infinite, "step": infinite}
    if steps is not None:
        starts = {"t": relative(seconds=-steps * step), "step": relative(seq=-steps)}
    ends = {"t": relative(seconds=0), "step": relative(seq=0)}
    return rrb.VisibleTimeRanges(
        [rrb.VisibleTimeRange(name, start=starts[name], end=ends[name]) for name in starts]
    )


def _view(root: str, name: str, box: Box, **more: Any) -> rrb.Spatial2DView:
    low, high = box.corners
    # what is drawn is turned up; the bounds are those of the screen (y down)
    bounds = rrb.VisualBounds2D(x_range=[low.real, high.real], y_range=[-high.imag, -low.imag])
    return rrb.Spatial2DView(
        origin="/", contents=[f"+ {root}/**"], name=name, visual_bounds=bounds, **more
    )


def _whole_time() -> rrb.TimeAxis:
    end = rrb.TimeRangeBoundary.infinite()
    return rrb.TimeAxis(view_range=rr.encodings.TimeRange(start=end, end=end))


def _plot(panel: Panel, content: Content) -> rrb.TimeSeriesView:
    values = np.concatenate([panel.values(content, name) for name in panel.names])
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    margin = 0.05 * (high - low) or 1.0
    named = MOST_NAMED // 2 if content.drawing is not None else MOST_NAMED  # where plots are low
    # the latest values of a live run are on the right, and must be seen
    corner = rrb.Corner2D.LeftTop if content.live else rrb.Corner2D.RightTop
    ends = (number(end if abs(end) > _ROUNDING * (high - low) else 0.0, 3) for end in (low, high))
    return rrb.TimeSeriesView(
        origin=panel.path,
        name=f"{panel.title}, {' to '.join(ends)}" if high > low else panel.title,
        plot_legend=rrb.PlotLegend(corner=corner, visible=len(panel.names) <= named),
        axis_x=None if content.live else _whole_time(),
        axis_y=rrb.ScalarAxis(range=(low - margin, high + margin)) if finite.size else None,
        overrides={panel.points(name): rr.SeriesPoints() for name in panel.drawn},
    )
