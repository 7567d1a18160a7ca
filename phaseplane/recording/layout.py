"""The layout of a recording in the viewer."""

from __future__ import annotations

from typing import Literal

import numpy as np
import rerun.blueprint as rrb

from . import sheet
from .columns import TIMELINES
from .content import Content
from .histories import Panel, panels
from .motion import LIVE, state_planes
from .replay import EVENTS, SHEET, STAGES, WORDS, trail_path
from .side_view import VEHICLE, vehicle_of, view_box
from .styles import legible
from .whole import state_box


def blueprint(content: Content) -> rrb.Blueprint:
    """Return the layout: phase planes, then vehicle and description of the step, then histories.

    During a live run the viewer stays at the latest time.

    Raises
    ------
    ValueError : see `Content.check`.
    """
    content.check()
    vehicle = vehicle_of(content)
    beside: list[tuple[float, rrb.View]] = []
    if vehicle is not None:
        beside.append((3.0, _view([f"+ {VEHICLE}/**"], "from the side", view_box(vehicle))))
    if content.drawing is not None and content.shows("words") and content.detail != "trail":
        beside.append((1.5, rrb.TextDocumentView(origin=STAGES, name="how it is drawn")))
        beside.append((3.0, rrb.TextDocumentView(origin=WORDS, name="this step")))
    columns: list[tuple[float, rrb.View | rrb.Container]] = []
    planes = _planes(content)
    if planes is not None:
        columns.append((5.0, planes))
    if beside:
        heights, views = zip(*beside, strict=True)
        columns.append((3.0, rrb.Vertical(*views, row_shares=list(heights))))
    plots = [_plot(panel, content) for panel in panels(content)]
    if plots:
        columns.append((3.0, rrb.Vertical(*plots)))
    shares, parts = zip(*columns, strict=True) if columns else ((), ())
    timeline = "t"
    if content.drawing is not None and not content.live:
        timeline = "stage" if content.detail == "stages" else "step"
    state: Literal["following", "playing"] = "following" if content.live else "playing"
    return rrb.Blueprint(
        rrb.Horizontal(*parts, column_shares=list(shares)),
        rrb.TimePanel(state="collapsed", timeline=timeline, fps=4.0, play_state=state),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _planes(content: Content) -> rrb.Spatial2DView | None:
    drawing, runs = content.constructed, state_planes(content)
    if drawing is None and not runs:
        return None
    past = rrb.VisibleTimeRanges(
        [
            rrb.VisibleTimeRange(
                timeline,
                start=rrb.TimeRangeBoundary.infinite(),
                end=rrb.TimeRangeBoundary.cursor_relative(**{kind: 0}),
            )
            for timeline, kind in TIMELINES.items()
        ]
    )
    kept = [run.path for run in runs]
    if drawing is not None:
        kept += [EVENTS, *map(trail_path, drawing.planes)]
    box = content.box if drawing is not None else state_box(runs, content)
    manner = drawing.title.partition(": ")[2] if drawing is not None else ""
    name = f"{content.title}: {manner}" if manner else content.title
    contents = [f"+ {SHEET}/**"] + ([] if content.live else [f"- {LIVE}/**"])
    return _view(contents, legible(name), box, overrides=dict.fromkeys(kept, past))


def _view(contents: list[str], name: str, box: sheet.Bounds, **more: object) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        origin="/",
        contents=contents,
        name=name,
        # Sheet and vehicle are flipped (y up); the bounds are those of the screen (y down).
        visual_bounds=rrb.VisualBounds2D(
            x_range=[box.left, box.right], y_range=[-box.top, -box.bottom]
        ),
        **more,  # type: ignore[arg-type]
    )


def _plot(panel: Panel, content: Content) -> rrb.TimeSeriesView:
    values = panel.values(content.histories)
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    margin = 0.05 * (high - low) or 1.0
    return rrb.TimeSeriesView(
        origin=panel.path,
        name=panel.title,
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop),
        axis_y=rrb.ScalarAxis(range=(low - margin, high + margin)) if finite.size else None,
    )
