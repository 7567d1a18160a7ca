"""Pictures of the constructions and of the motions, by matplotlib.

Figures are made with its object interface alone: no window, no global state, no backend to choose.
"""

from __future__ import annotations

from phaseplane.figures.animation import animation
from phaseplane.figures.characteristics import characteristics_sheet
from phaseplane.figures.columns import columns, comparison
from phaseplane.figures.histories import time_histories
from phaseplane.figures.planes import construction_sheet, phase_planes
from phaseplane.figures.portrait import portrait
from phaseplane.figures.published import (
    figure7,
    figure9,
    figure10,
    figure12,
    figure13,
    figure14,
    figure15,
    figure16,
)
from phaseplane.figures.single_steps import figure4a, figure4b, figure8
from phaseplane.figures.stability import stability_sheet
from phaseplane.figures.style import save
from phaseplane.figures.sweeps import sweep
from phaseplane.figures.work_precision import work_precision

__all__ = [
    "animation",
    "characteristics_sheet",
    "columns",
    "comparison",
    "construction_sheet",
    "figure4a",
    "figure4b",
    "figure7",
    "figure8",
    "figure9",
    "figure10",
    "figure12",
    "figure13",
    "figure14",
    "figure15",
    "figure16",
    "phase_planes",
    "portrait",
    "save",
    "stability_sheet",
    "sweep",
    "time_histories",
    "work_precision",
]
