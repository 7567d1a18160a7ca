"""How the viewer lays the recording out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy.typing as npt
import rerun.blueprint as rrb

from phaseplane.constructions.primitives import Drawing

from . import sheet
from .histories import panels
from .replay import EVENTS, HISTORIES, SHEET, WORDS, Detail, check, trail_path
from .styles import legible

_KINDS = {"t": "seconds", "step": "seq", "stage": "seq"}


def blueprint(
    drawing: Drawing,
    histories: Mapping[str, npt.ArrayLike] | None = None,
    *,
    detail: Detail = "stages",
) -> rrb.Blueprint:
    """The phase planes on the left; the histories and the step in words on the right.

    Parameters and what is raised are those of `log`.
    """
    check(drawing, detail)
    beside: list[rrb.View] = [
        rrb.TimeSeriesView(
            origin=f"{HISTORIES}/{panel.quantity.name}",
            name=f"{panel.quantity.name} [{panel.quantity.unit}]",
            plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop),
        )
        for panel in panels(histories)
    ]
    if detail != "trail":
        beside.append(rrb.TextDocumentView(origin=WORDS, name="this step"))
    planes = _planes(drawing)
    return rrb.Blueprint(
        rrb.Horizontal(planes, rrb.Vertical(*beside), column_shares=[2, 1]) if beside else planes,
        rrb.TimePanel(
            state="collapsed",
            timeline="stage" if detail == "stages" else "step",
            fps=4.0,
            play_state="playing",
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def _planes(drawing: Drawing) -> rrb.Spatial2DView:
    box = sheet.bounds(drawing)
    past = rrb.VisibleTimeRanges(
        [
            rrb.VisibleTimeRange(
                timeline,
                start=rrb.TimeRangeBoundary.infinite(),
                end=rrb.TimeRangeBoundary.cursor_relative(**{kind: 0}),
            )
            for timeline, kind in _KINDS.items()
        ]
    )
    return rrb.Spatial2DView(
        origin="/",
        contents=f"{SHEET}/**",
        name=legible(drawing.title),
        # The sheet is turned over (y up), the bounds are those of the screen (y down).
        visual_bounds=rrb.VisualBounds2D(
            x_range=[box.left, box.right], y_range=[-box.top, -box.bottom]
        ),
        overrides=dict.fromkeys((EVENTS, *map(trail_path, drawing.planes)), past),
    )
