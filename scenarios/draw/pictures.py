"""From results and constructions to pictures and recordings.

Only what is asked for is imported and made.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from phaseplane import figures, recording

from ..errors import MOVING, PICTURES, one_line
from .recording_content import of_results

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content

    from ..results.folder import Results
    from ..scene.schema import Scene

RECORDING = "construction.rrd"
RULES_SHOWN = {"figure4a": "mean_normal", "figure4b": "osculating_circle", "figure8": "tangent"}
"""The step rule that a figure shows, where it shows a single one."""


def draw_all(
    scene: Scene, results: Results, drawing: Drawing | None, folder: Path
) -> Iterator[str]:
    """Draw what the scene shows into the folder; yields a line for what could not be drawn."""
    makers = {name: f"{name}.png" for name in scene.show.figures}
    for name, file in makers.items():
        if name == "time_histories" or drawing is not None:
            try:
                draw(
                    name,
                    folder / file,
                    drawing,
                    results,
                    title=scene.title or scene.name,
                    dark=scene.show.dark,
                )
            except Exception as error:  # a picture that fails must not cost the results
                yield f"{file} was not drawn: {one_line(error)}"
    if scene.show.recording:
        try:
            record(of_results(results, drawing, scene.show.model_dump()), folder / RECORDING)
        except Exception as error:
            yield f"{RECORDING} was not written: {one_line(error)}"


def draw(
    name: str,
    path: Path,
    drawing: Drawing | None,
    results: Results | None = None,
    *,
    title: str = "",
    dark: bool = False,
) -> None:
    """Draw one picture: `time_histories` from results, the others from a construction.

    The phase planes are moving where the file is a .gif or an .mp4.

    Raises
    ------
    ValueError : a construction that has not got what the picture shows.
    """
    if path.suffix in MOVING:
        if name != "phase_planes":
            raise ValueError(f"only phase_planes is moving; write it as {', '.join(PICTURES)}")
        assert drawing is not None
        figures.animation(drawing, path, title=title, dark=dark)
        return
    if name == "time_histories":
        assert results is not None
        figure = figures.time_histories(histories(results), title=title, dark=dark)
    else:
        figure = getattr(figures, name)(drawing, title=title, dark=dark)
    figures.save(figure, path)


def record(shown: Content, path: Path) -> None:
    """Write a recording."""
    recording.record(shown, path)


def histories(results: Results) -> dict[str, npt.NDArray[np.float64]]:
    """The columns under the names that pictures and recordings know."""
    renamed = {"ground_elevation": "road_elevation", "ground_velocity": "road_velocity"}
    columns = {renamed.get(name, name): column for name, column in results.columns.items()}
    if {"body_acceleration", "wheel_acceleration"} <= columns.keys():
        deflection = columns["body_acceleration"] - columns["wheel_acceleration"]
        columns["suspension_deflection_acceleration"] = deflection
    return columns
