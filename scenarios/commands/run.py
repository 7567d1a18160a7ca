"""`phaseplane run`: a scene run into its folder."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from signal import SIGTERM
from time import perf_counter
from typing import Any

import click

from ..draw.constructions import constructed, drifting, told_of
from ..draw.live import shown_live
from ..draw.pictures import pictures_of
from ..draw.planes import CONSTRUCTED
from ..errors import DrawingError, InputError, RunError, check_recording, one_line
from ..results.folder import (
    OUTPUT,
    Place,
    Results,
    as_json,
    check_replaceable,
    read_summary,
    replaced_whole,
    write_results,
)
from ..results.report import failures, report
from ..results.standing import Standing
from ..scene.layers import Setting
from ..scene.loading import load_scene
from ..simulate import runner
from ..simulate.measuring import read_at
from .console import (
    DONE,
    FAILED,
    TERMINATED,
    complain,
    json_option,
    output_option,
    progress_bar,
    set_option,
    warn,
)
from .viewing import page, save_option, until_interrupted, viewer_options

Progress = Callable[[str], AbstractContextManager[Callable[[float], None] | None]]


def _silent(_label: str) -> AbstractContextManager[None]:
    return nullcontext()


@click.command()
@click.argument("scene")
@set_option
@click.option(
    "--no-expect", is_flag=True, help="Do not check what SCENE expects; only what --set expects."
)
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
    no_expect: bool,
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
    shown = (
        [Setting("show.planes", list(planes), "--plane"), Setting("show.recording", "stages")]
        if planes
        else []
    )
    with page(served, address) as server:
        summary, folder = run_scene(
            scene,
            (*shown, *overrides),
            output,
            progress_bar,
            viewer=viewer or (server.url if server else ""),
            save=save,
            realtime=realtime,
            expect=not no_expect,
        )
        warn(summary["warnings"])
        click.echo(as_json(summary) if as_data else report(summary, folder))
        told = failures(summary)
        if told:
            more = f" (and {len(told) - 1} more)" if len(told) > 1 else ""
            complain(f"{summary['scene']}: {told[0]}{more}")
        until_interrupted(server)
    return FAILED if told else DONE


def run_scene(
    reference: str,
    overrides: Sequence[str | Setting] = (),
    folder: Path | None = None,
    progress: Progress = _silent,
    *,
    viewer: str = "",
    save: Path | None = None,
    realtime: bool = False,
    expect: bool = True,
) -> tuple[dict[str, Any], Path]:
    """Run a scene and leave results, pictures and recording in a folder, which is replaced whole.

    Results are there before anything is drawn; pictures are added one by one.

    Parameters
    ----------
    reference : name of a case, or path of a scene file
    overrides : `key=value` texts
    folder : None for `out/<scene>`
    progress : given a label, a context for what takes time; it may give a function that is told the
        part done, 0 to 1
    viewer : address of a running viewer that shows the run while it goes on; whatever becomes of
        it, the run does not notice
    save : a recording (.rrd) that is written while the run goes on, and whole at its end
    realtime : whether the run waits for the clock
    expect : whether what the scene expects is checked; what overrides expect is in any case

    Returns
    -------
    The summary as it was written, and the folder.

    Raises
    ------
    InputError : a scene that cannot be read or drawn, a folder that must not be replaced.
    RunError : the run could not begin.
    KeyboardInterrupt, SystemExit : Ctrl-C or SIGTERM; what was computed and drawn until then has been
        written.
    """
    check_recording(save)
    scene = load_scene(reference, overrides, expect=expect)
    place = Place(folder or OUTPUT / scene.name, "run", scene.file, named=folder is not None)
    check_replaceable(place)
    problems: list[str] = []
    told: dict[str, Any] = {"drawn": None, "problems": problems}
    drawing = None
    known = scene.fmu.model in CONSTRUCTED
    if scene.show.figures_construction or (known and scene.show.records_construction):
        started = perf_counter()
        try:
            with progress(f"construction of {scene.name}"):
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
        try:
            with progress(scene.name) as part:
                results = runner.run(scene, progress=part, watch=watch, realtime=realtime)
        except runner.Interrupted as interrupted:
            _written(
                interrupted.results, pictures_of(scene, interrupted.results, drawing), told, place
            )
            if interrupted.number == SIGTERM:
                sys.exit(TERMINATED)
            raise KeyboardInterrupt(_kept_words(interrupted.results, place)) from None
        if drawing is not None:
            drawing = drifting(drawing, results.columns, partial(read_at, scene))
            told["drawn"] = told_of(drawing, drawing_time)
        pictures = pictures_of(scene, results, drawing)
        standing = _written(results, pictures, told, place)
        if live is not None:
            with progress(f"showing {scene.name}"):
                unwritten, unshown = live.complete(results)
            problems += unwritten
            told["warnings"] = [*results.summary["warnings"], *unshown]
    problems += _drawn(pictures, standing, progress)
    standing.tell(**told)
    return read_summary(place.folder) or {}, place.folder


def _written(
    results: Results, pictures: Iterable[str], told: Mapping[str, Any], place: Place
) -> Standing:
    """Write results before anything of them is drawn."""
    told = {"origin": place.origin, **told, "undrawn": list(pictures)}
    with replaced_whole(place) as draft:
        write_results(Results(results.columns, {**results.summary, **told}), draft)
    return Standing(place.folder)


def _drawn(
    pictures: Mapping[str, Callable[[Path], None]], standing: Standing, progress: Progress
) -> Iterator[str]:
    """Add the pictures to the results; yields a line for what could not be drawn."""
    for name, draw in pictures.items():
        try:
            with progress(f"drawing {name}"), standing.added(name) as path:
                draw(path)
        except RunError:
            raise
        except Exception as error:  # a picture that fails must not cost the others
            yield f"{name} was not drawn: {one_line(error)}"
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"while drawing {name}; results and what was drawn before are in {standing.folder}"
            ) from None


def _kept_words(results: Results, place: Place) -> str:
    stopped = results.stopped
    until = (
        f"at {stopped['time']:.6g} s of {results.summary['duration']:g} s"
        if stopped
        else "at its end"
    )
    return f"{until}; what was computed until then is in {place.folder}"
