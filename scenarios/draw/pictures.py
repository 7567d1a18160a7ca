"""Pictures and recordings of results and constructions.

Drawing libraries are imported only when they are needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import nearest

from phaseplane import figures, recording

from ..errors import MOVING, PICTURES, InputError, one_line, shown
from ..measures.motion import start_of
from ..scene.sections import FIGURES
from .recording_content import of_results

if TYPE_CHECKING:
    from phaseplane.constructions.primitives import Drawing
    from phaseplane.figures.style import Figure

    from ..columns import Column
    from ..results.folder import Results
    from ..scene.schema import Scene

RECORDING = "construction.rrd"
RULES_SHOWN = {name: need.rule for name, need in figures.REQUIREMENTS.items() if need.rule}
"""The step rule of each figure that shows a single rule."""


def pictures_of(
    scene: Scene, results: Results, drawing: Drawing | None
) -> dict[str, Callable[[Path], None]]:
    """Return a function for each picture or recording of a scene, by file name, that writes it.

    Parameters
    ----------
    drawing : the construction; if None, the pictures that need it are left out
    """
    title = scene.title or scene.name
    pictures: dict[str, Callable[[Path], None]] = {}

    def draw_figure(name: str, path: Path) -> None:
        look = figures.Look(dark=scene.show.dark)
        draw(name, path, drawing=drawing, results=results, title=title, look=look)

    def draw_plane(names: tuple[str, str], path: Path) -> None:
        look = figures.Look(dark=scene.show.dark)
        x, y = (results.columns[name] for name in names)
        drawn = figures.plane_of_columns({"": (x, y)}, names, results.units, title=title, look=look)
        figures.save(drawn, path)

    def draw_recording(path: Path) -> None:
        content = of_results(results, drawing, scene.shown)  # says so if rerun cannot be loaded
        recording.record(content, path)

    for name in scene.show.figures:
        if name == "time_histories" or drawing is not None:
            pictures[f"{name}.png"] = partial(draw_figure, name)
    for k, names in enumerate(scene.show.planes, 1):
        pictures["plane.png" if k == 1 else f"plane_{k}.png"] = partial(draw_plane, names)
    if scene.show.recording:
        pictures[RECORDING] = draw_recording
    return pictures


@contextmanager
def draws_or_tells(name: str, problems: list[str]) -> Iterator[None]:
    """Add a line to the problems if a picture cannot be drawn, which must not cost the results."""
    try:
        yield
    except Exception as error:  # also where the drawing library cannot be imported
        why: object = error
        if isinstance(error, OSError) and isinstance(error.__cause__, OSError):
            # without the path that it cannot be written to: a draft's, which the user does not see
            why = error.__cause__.strerror or error.__cause__
        problems.append(f"{name} was not drawn: {one_line(why)}")


def draw(
    name: str,
    path: Path,
    drawing: Drawing | None,
    results: Results | None = None,
    *,
    title: str,
    look: figures.Look,
    step: int | None = None,
) -> list[Path]:
    """Draw one picture: `time_histories` from results, the others from a construction.

    The phase planes are animated if the file is a .gif or an .mp4.

    Parameters
    ----------
    look : how it is printed
    step : index of the step that is shown, in figures of one step

    Returns
    -------
    The files, several if the picture has several pages.

    Raises
    ------
    ValueError : if the construction lacks what the picture shows.
    """
    if path.suffix in MOVING:
        assert drawing is not None
        return [figures.animation(drawing, path, title=title, look=look)]
    figure = figure_of(name, drawing, results, title=title, look=look, step=step)
    figures.save(figure, path)
    return figures.files_of(figure, path)


def refuse_choice(name: str, *, step: int | None, moving: bool = False) -> None:
    """Reject an unknown picture, or one that is not animated or does not show a single step.

    Raises
    ------
    InputError : if there is no picture of that name.
    ValueError : the message says what to do instead.
    """
    if name not in FIGURES:
        raise InputError(
            f"no picture {shown(name)}; pictures are {', '.join(FIGURES)}{nearest(name, FIGURES)}"
        )
    if moving and name != "phase_planes":
        raise ValueError(f"only phase_planes can be animated; write {', '.join(PICTURES)}")
    if moving and step is not None:
        raise ValueError("an animation chooses its steps; leave --at-step out")
    if step is not None and "frame" not in signature(getattr(figures, name)).parameters:
        raise ValueError(f"{name} shows no single step; leave --at-step out")


def figure_of(
    name: str,
    drawing: Drawing | None,
    results: Results | None = None,
    *,
    title: str = "",
    look: figures.Look | None = None,
    step: int | None = None,
) -> Figure:
    """Return one picture as `draw` writes it.

    Raises
    ------
    InputError : if there is no picture of that name.
    ValueError : if the construction or the results lack what the picture shows.
    """
    refuse_choice(name, step=step)
    printed = look or figures.Look()
    if name == "time_histories":
        if results is None:
            raise ValueError("time_histories shows a run, and not a construction")
        return _time_histories(results, title, printed)
    chosen = {} if step is None else {"frame": step}
    return getattr(figures, name)(drawing, **chosen, title=title, look=printed)


def _time_histories(results: Results, title: str, look: figures.Look) -> Figure:
    """Return the outputs of a run over time: axle by axle, of one axle, or any one below the other."""
    if "front_suspension_deflection" in results.columns:
        centre = {
            name.replace("body", "body_centre"): column
            for name, column in results.columns.items()
            if name.startswith("body_")
        }
        axles = {axle: centre | histories(results, f"{axle}_") for axle in ("front", "rear")}
        return figures.axle_histories(axles, title=title, look=look)
    columns = histories(results)
    motions = [name for name in columns if name.endswith("_displacement")]
    known = [name for name in motions if figures.has_histories({name: 0})]
    if known == motions and figures.has_histories(columns):
        return figures.time_histories(columns, title=title, look=look)
    # an FMU of others, an equation, or a system with more than a body and a wheel
    return figures.runs(_by_starts(results), results.units, title=title, look=look)


def _by_starts(results: Results) -> dict[str, dict[str, tuple[Any, Any]]]:
    """Return the columns over time, those of the same name from several starts together."""
    found: dict[str, dict[str, tuple[Any, Any]]] = {}
    time = results.columns["time"]
    for name, column in results.columns.items():
        start, own = start_of(name)
        if name != "time":
            found.setdefault(own, {})[f"start {start}"] = time, column
    return found


def histories(results: Results, axle: str = "") -> dict[str, Column]:
    """Return the columns under their names in pictures and recordings; those of one axle, if given."""
    renamed = {"ground_elevation": "road_elevation", "ground_velocity": "road_velocity"}
    own = {
        name.removeprefix(axle): column
        for name, column in results.columns.items()
        if name.startswith(axle) or name == "time"
    }
    columns = {renamed.get(name, name): column for name, column in own.items()}
    if {"body_acceleration", "wheel_acceleration"} <= columns.keys():
        deflection = columns["body_acceleration"] - columns["wheel_acceleration"]
        columns["suspension_deflection_acceleration"] = deflection
    return columns
