"""The constructions of the cases that come along."""

from __future__ import annotations

from dataclasses import asdict
from functools import cache

from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import case_names

from phaseplane.constructions.primitives import Drawing

LONGEST = 1.0  # s of each case
SYSTEMS_OF_ONES_OWN = {"double_pendulum", "full_car"}
REFUSED = {"light_wheel": "try 1.4e-05 s"}
DRAWN = sorted({*case_names()} - SYSTEMS_OF_ONES_OWN - {*REFUSED})
# of the sheet, wide and narrow, in windows of 1366 x 768 and 2560 x 1440
PANES = ((860, 670), (1610, 1340)), ((600, 670), (1125, 1340))


@cache
def drawing_of(name: str, longest: float = LONGEST, rule: str | None = None) -> Drawing:
    """The construction of a case, or of its first second."""
    scene = load_scene(name, [f"construction.rule={rule}"] if rule else [], expect=False)
    time = min(scene.construction_time, longest)
    settings = asdict(scene.construction)
    return draw_construction(scene.fmu.model, scene.all_parameters, settings, time)
