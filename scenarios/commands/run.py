"""`phaseplane run`: run a scene and write its folder."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from signal import SIGTERM
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click

from .. import draw
from ..errors import DrawingError, InputError, check_recording, one_line
from ..progress import Progress, silent
from ..results.finished import FinishedFolder
from ..results.folder import (
    Place,
    Results,
    read_summary,
    replace_folder,
    write_results,
)
from ..results.plain import as_json
from ..results.report import failures, report
from ..scene.layers import Setting
from ..scene.loading import load_scene
from ..simulate import runner
from ..simulate.evaluation import read_at
from .console import (
    DONE,
    FAILED,
    TERMINATED,
    failed,
    json_option,
    output_option,
    pair,
    progress_bar,
    set_option,
    warn,
)
from .viewing import page, save_option, until_interrupted, viewer_options

if TYPE_CHECKING:
    from phaseplane.constructions.primitives import Drawing

    from ..scene.schema import Scene

ProgressBar = Callable[[str], AbstractContextManager[Progress]]


@click.command()
@click.argument("scene")
@set_option
@click.option(
    "--no-expect", is_flag=True, help="Skip the expectations of SCENE; check only those of --set."
)
@output_option("out/SCENE")
@viewer_options
@save_option
@click.option("--realtime", is_flag=True, help="Run in real time.")
@click.option(
    "--plane", "planes", multiple=True, type=pair, metavar="A,B",
    help="Draw and record the plane of two outputs, a displacement and its rate. Repeatable.",
)  # fmt: skip
@json_option
def run(
    *,
    scene: str,
    overrides: tuple[str | Setting, ...],
    no_expect: bool,
    output: Path | None,
    viewer: str,
    served: bool,
    address: str,
    planes: tuple[tuple[str, str], ...],
    as_data: bool,
    **how: Any,
) -> int:
    """Run a scene, a system or an FMU, and write its results.

    SCENE is a built-in scene (see `list`), a scene or system file (.toml, .py), or an .fmu file.

    --connect, --serve and --save show or record the run while it is under way.
    """
    if planes:
        shown = Setting("show.planes", list(planes), "--plane"), Setting("show.recording", "stages")
        overrides = (*shown, *overrides)
    with page(served, address, viewer=viewer) as server:
        how |= {"viewer": viewer or (server.url if server else ""), "expect": not no_expect}
        summary, folder = run_scene(scene, overrides, output, progress_bar, **how)
        reasons = failures(summary)
        with until_interrupted(server):
            warn(summary["warnings"])
            click.echo(as_json(summary) if as_data else report(summary, folder))
            failed(summary["scene"], reasons)
    return FAILED if reasons else DONE


def run_scene(
    reference: str,
    overrides: Sequence[str | Setting] = (),
    folder: Path | None = None,
    progress: ProgressBar = lambda _label: nullcontext(silent),
    *,
    viewer: str = "",
    save: Path | None = None,
    realtime: bool = False,
    expect: bool = True,
) -> tuple[dict[str, Any], Path]:
    """Run a scene and write results, pictures and recording to a folder, replaced as a whole.

    The results are written first; then pictures are added one by one.

    Parameters
    ----------
    reference : name of a built-in scene, or path of a scene file
    overrides : `key=value` texts
    folder : folder to write to; `out/<scene>` if None
    progress : makes a context for a slow task from its label
    viewer : address of a running viewer that shows the run while it is under way; a failing viewer
        does not disturb the run
    save : a recording (.rrd) that is written during the run and completed at its end
    realtime : whether to run in real time
    expect : whether to check the scene's expectations; those of `overrides` are always checked

    Returns
    -------
    The summary as written, and the folder.

    Raises
    ------
    InputError : if the scene cannot be read or drawn, or the folder must not be replaced.
    RunError : if the run could not start.
    KeyboardInterrupt, SystemExit : on Ctrl-C or SIGTERM; results and pictures until then have been
        written.
    """
    check_recording(save)
    scene = load_scene(reference, overrides, expect=expect)
    place = Place.chosen(folder, scene.name, "run", scene.file)
    if save is not None:
        place.check_apart("--save", save)
    if scene.reference is not None:
        place.check_apart(f"{scene.name}: reference.file =", scene.reference.path)
    problems: list[str] = []
    facts: dict[str, Any] = {"drawn": None, "problems": problems}
    started = perf_counter()
    drawing = _constructed(scene, problems, progress)
    drawing_time = perf_counter() - started
    with (
        draw.live.show_live(scene, drawing, viewer, save) if viewer or save else nullcontext()
    ) as live:
        watch = live.watch if live is not None else None
        try:
            with progress(scene.name) as part:
                results = runner.run(scene, progress=part, watch=watch, realtime=realtime)
        except runner.Interrupted as interrupted:
            undrawn = _pictures(scene, interrupted.results, drawing)
            _written(interrupted.results, undrawn, facts, place)
            if interrupted.number == SIGTERM:
                sys.exit(TERMINATED)
            raise KeyboardInterrupt(_format_place(interrupted.results, place)) from None
        if drawing is not None:
            if scene.controller is None:
                drawing = draw.constructions.with_drift(
                    drawing, results.columns, partial(read_at, scene)
                )
            facts["drawn"] = draw.constructions.drawing_summary(drawing, drawing_time)
        pictures = _pictures(scene, results, drawing)
        standing = _written(results, pictures, facts, place)
        if live is not None:
            with progress(f"showing {scene.name}"):
                unwritten, unshown = live.complete(results, drawing)
            problems += unwritten
            if save is not None and not unwritten:
                facts["saved"] = str(save)
            facts["warnings"] = [*results.summary["warnings"], *unshown]
    _draw_into(standing, pictures, problems, progress)
    standing.update_summary(**facts)
    return read_summary(place.folder) or {}, place.folder


def _constructed(scene: Scene, problems: list[str], progress: ProgressBar) -> Drawing | None:
    """Return the construction of a scene if something that is shown needs it.

    A line is added to the problems if it cannot be drawn.

    Raises
    ------
    InputError : if a figure needs it, but the model has none.
    KeyboardInterrupt : on Ctrl-C, with what has been written.
    """
    needed = scene.show.figures_construction
    wanted = (
        scene.show.records_construction
        and scene.fmu.model in draw.planes.CONSTRUCTED
        and scene.controller is None
    )
    if not (needed or wanted):
        return None
    try:
        with progress(f"construction of {scene.name}"):
            return draw.constructions.draw_scene(scene)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            "while the construction was drawn, before the run; nothing was written"
        ) from None
    except ArithmeticError as error:
        problems.append(f"the construction cannot be drawn: {one_line(error)}")
    except DrawingError as error:
        problems.append(one_line(error))
    except InputError:
        if needed:
            raise
        # a recording is complete without it, as for models that have no construction
    return None


def _pictures(
    scene: Scene, results: Results, drawing: Drawing | None
) -> dict[str, Callable[[Path], None]]:
    """Return what writes each picture and recording of a scene; see `pictures_of`."""
    if not (scene.show.figures or scene.show.recording or scene.show.planes):
        return {}
    return draw.pictures.pictures_of(scene, results, drawing)


def _written(
    results: Results, pictures: Iterable[str], facts: Mapping[str, Any], place: Place
) -> FinishedFolder:
    """Write the results, before their pictures are drawn."""
    facts = {"origin": place.origin, **facts, "undrawn": list(pictures)}
    with replace_folder(place) as draft:
        write_results(Results(results.columns, {**results.summary, **facts}), draft)
    return FinishedFolder(place.folder)


def _draw_into(
    standing: FinishedFolder,
    pictures: Mapping[str, Callable[[Path], None]],
    problems: list[str],
    progress: ProgressBar,
) -> None:
    """Add the pictures to the results, and a line to the problems for each that could not be drawn."""
    for name, write in pictures.items():
        try:
            with (
                progress(f"drawing {name}"),
                draw.pictures.draws_or_tells(name, problems),
                standing.added(name) as path,
            ):
                write(path)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"while drawing {name}; the results and earlier pictures are in {standing.folder}"
            ) from None


def _format_place(results: Results, place: Place) -> str:
    stopped = results.stopped
    until = (
        f"at {stopped['time']:.6g} s of {results.summary['duration']:g} s"
        if stopped
        else "at its end"
    )
    return f"{until}; the results until then are in {place.folder}"
