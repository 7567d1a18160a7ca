"""`phaseplane run`: a scene run into its folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import click

from ..draw.constructions import constructed, drifting, told_of
from ..draw.live import shown_live
from ..draw.pictures import draw_all
from ..draw.planes import CONSTRUCTED
from ..errors import DrawingError, InputError, check_recording, one_line
from ..results.folder import (
    OUTPUT,
    Results,
    as_json,
    check_replaceable,
    read_summary,
    replaced_whole,
    write_results,
)
from ..results.report import failures, report
from ..scene.loading import load_scene
from ..simulate import runner
from .console import (
    DONE,
    FAILED,
    complain,
    json_option,
    output_option,
    progress_bar,
    set_option,
)
from .viewing import page, save_option, until_interrupted, viewer_options


@click.command()
@click.argument("scene")
@set_option
@output_option
@viewer_options
@save_option
@click.option("--realtime", is_flag=True, help="Let the run wait for the clock.")
@click.option(
    "--plane", "planes", multiple=True, metavar="A,B",
    help="Show the phase plane of two outputs, displacement and rate. Repeatable.",
)  # fmt: skip
@json_option
def run(
    *,
    scene: str,
    overrides: tuple[str, ...],
    output: Path | None,
    viewer: str,
    served: bool,
    address: str,
    save: Path | None,
    realtime: bool,
    planes: tuple[str, ...],
    as_data: bool,
) -> int:
    """Run SCENE: a case (see `list`), a scene file, or any .fmu file.

    With --connect, --serve or --save it is shown or recorded while it goes on.
    """
    shown = [f"show.planes={list(planes)}", "show.recording=stages"] if planes else []
    with page(served, address) as server:
        with progress_bar(scene) as progress:
            summary, folder = run_scene(
                scene,
                (*shown, *overrides),
                output,
                progress,
                viewer=viewer or (server.url if server else ""),
                save=save,
                realtime=realtime,
            )
        click.echo(as_json(summary) if as_data else report(summary, folder))
        told = failures(summary)
        if told:
            more = f" (and {len(told) - 1} more)" if len(told) > 1 else ""
            complain(f"{summary['scene']}: {told[0]}{more}")
        until_interrupted(server)
    return FAILED if told else DONE


def run_scene(
    reference: str,
    overrides: Sequence[str] = (),
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    viewer: str = "",
    save: Path | None = None,
    realtime: bool = False,
) -> tuple[dict[str, Any], Path]:
    """Run a scene and leave results, pictures and recording in a folder, which is replaced whole.

    Parameters
    ----------
    reference : name of a case, or path of a scene file
    overrides : `key=value` texts
    folder : None for `out/<scene>`
    viewer : address of a running viewer that shows the run while it goes on; whatever becomes of
        it, the run does not notice
    save : a recording (.rrd) that is written while the run goes on, and whole at its end
    realtime : whether the run waits for the clock

    Returns
    -------
    The summary as it was written, and the folder.

    Raises
    ------
    InputError : a scene that cannot be read or drawn, a folder that must not be replaced.
    RunError : the run could not begin.
    """
    check_recording(save)
    scene = load_scene(reference, overrides)
    folder = folder or OUTPUT / scene.name
    check_replaceable(folder)
    problems: list[str] = []
    drawing, told = None, None
    known = scene.fmu.model in CONSTRUCTED
    if scene.show.figures_construction or (known and scene.show.records_construction):
        started = perf_counter()
        try:
            drawing = constructed(
                scene.fmu.model,
                scene.all_parameters,
                scene.construction.model_dump(),
                scene.construction_time,
            )
            drawing_time = perf_counter() - started
        except (ArithmeticError, DrawingError) as error:
            problems.append(f"the construction cannot be drawn: {one_line(error)}")
        except InputError:
            if scene.show.figures_construction:
                raise
            # a recording alone does without, as of any model that has no construction
    with shown_live(scene, drawing, viewer, save) as live:
        watch = live.watch if live is not None else None
        results = runner.run(scene, progress=progress, watch=watch, realtime=realtime)
        if live is not None:
            problems += live.complete(results)
    if drawing is not None:
        drawing = drifting(drawing, results.columns)
        told = told_of(drawing, drawing_time)
    with replaced_whole(folder) as draft:
        problems += draw_all(scene, results, drawing, draft)
        results = Results(results.columns, {**results.summary, "drawn": told, "problems": problems})
        write_results(results, draft)
    return read_summary(folder) or {}, folder
