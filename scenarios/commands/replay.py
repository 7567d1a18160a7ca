"""`phaseplane replay`: draw the construction of a scene, or of a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import click
from phaseplane.suspension.units import counted

from phaseplane import figures, recording

from ..draw.constructions import draw_scene, drawing_summary, overlay_run
from ..draw.live import show_in
from ..draw.pictures import RULES_SHOWN, draw, refuse_choice
from ..draw.recording_content import of_results, of_scene
from ..errors import MOVING, InputError, RunError, blaming, check_recording
from ..look import FigureFile
from ..results.folder import DAMAGED, read_results, read_summary
from ..results.plain import as_json
from ..results.report import format_missed
from ..results.tables import ENDINGS, read_table
from ..scene.fields import one_of
from ..scene.layers import Setting, find_scene
from ..scene.loading import construction_settings, load_scene
from ..scene.sections import CONSTRUCTION_FIGURES, Show
from .console import json_option, progress_bar, set_option
from .viewing import (
    figure_options,
    page,
    refuse_without_figure,
    save_option,
    until_interrupted,
    viewer_options,
)  # fmt: skip

if TYPE_CHECKING:
    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content

    from ..draw.constructions import Check

_KIND = "phase_planes"  # of a figure


@click.command()
@click.argument("what", metavar="SCENE|RESULTS")
@set_option
@click.option(
    "--over",
    type=click.Path(path_type=Path),
    metavar="TABLE",
    help="Lay the construction of SCENE over the motion in this table, e.g. motion.csv.",
)
@click.option(
    "--construction",
    "rule",
    metavar="RULE",
    help="Step rule of Liénard's construction, e.g. delta; `phaseplane schema` explains the rules.",
)
@click.option("--step", metavar="TIME", help="Step of the construction, e.g. '2.5 ms'.")
@save_option
@figure_options("the phase planes, or of another --kind", MOVING)
@click.option(
    "--kind",
    default=_KIND,
    show_default=True,
    metavar="NAME",
    help="Figure to draw: phase_planes, construction_sheet, storyboard, or a figure of AP57: "
    "figure1 to figure16 (figure4a and figure4b for 4).",
)
@click.option("--at-step", type=int, metavar="N", help="Step to show in a figure of a single step.")
@viewer_options
@json_option
def replay(
    *,
    what: str,
    overrides: tuple[str, ...],
    over: Path | None,
    rule: str | None,
    step: str | None,
    save: Path | None,
    figure: FigureFile | None,
    viewer: str,
    served: bool,
    address: str,
    as_data: bool,
    **which: Any,
) -> None:
    """Draw the construction of a SCENE or of a run's RESULTS."""
    if save is None and figure is None and not viewer and not served:
        raise InputError(
            "replay: nothing to do; give one or more of --save F.rrd, --figure F.png, --connect URL "
            "and --serve"
        )
    extra = (
        Setting("construction.rule", rule, "--construction"),
        Setting("construction.step", step, "--step"),
    )
    settings: tuple[str | Setting, ...] = (
        *overrides, *(setting for setting in extra if setting.value is not None)
    )  # fmt: skip
    with page(served, address, viewer=viewer) as server:
        shown_in = viewer or (server.url if server else "")
        with progress_bar(f"construction of {what}"):
            summary = replay_construction(what, settings, save, figure, shown_in, over, **which)
        places = ", ".join([*summary["files"], *([viewer] if viewer else [])])
        with until_interrupted(server):
            click.echo(
                as_json(summary)
                if as_data
                else f"{summary['title']}: {counted(summary['steps'], 'step')}"
                + (f" in {places}" if places else "")
                + format_missed(summary)
            )


def replay_construction(
    what: str,
    overrides: Sequence[str | Setting],
    save: Path | None,
    figure: FigureFile | None,
    viewer: str = "",
    over: Path | None = None,
    *,
    kind: str = _KIND,
    at_step: int | None = None,
) -> dict[str, Any]:
    """Construct a scene, or lay the construction over the results of a run, and write files.

    Parameters
    ----------
    what : a scene, a results folder, or the table in one
    over : a table with the motion that the construction of the scene is laid over
    overrides : `key=value` texts; for results only those of `construction`
    save, figure : files to write
    viewer : address of a running viewer to show it in
    kind : name of the figure; its rule is used unless overrides give one
    at_step : step that a figure of one step shows; default: one whose letters have room

    Raises
    ------
    InputError : if the scene, the folder or a file name is not valid.
    RunError : if the construction diverges, or the viewer refuses the recording.
    """
    check_recording(save)
    if figure is None:
        refuse_without_figure({"--kind": kind != _KIND, "--at-step": at_step is not None})
    with blaming(f"--kind {kind!r}"):
        one_of(CONSTRUCTION_FIGURES).read(kind)
    started = perf_counter()
    if figure is not None:
        with blaming(f"--kind {kind}"):
            refuse_choice(kind, step=at_step, moving=figure.path.suffix in MOVING)
        if kind in RULES_SHOWN:
            overrides = (Setting("construction.rule", RULES_SHOWN[kind], "--kind"), *overrides)

    def check(first: Drawing) -> None:
        if figure is not None:
            with blaming(f"--kind {kind}"):
                figures.refuse_unsuited(kind, first)

    folder = _results_folder(Path(what)) if over is None else None
    if folder is not None:
        title, drawing, content_of = _over_run(folder, overrides, check)
    else:
        title, drawing, content_of = _of_scene(what, overrides, over, check)
    with blaming(what):
        if save is not None or viewer:
            content = content_of()
            if save is not None:
                recording.record(content, save)
            if viewer:
                show_in(content, viewer)
    last = len(drawing.frames) - 1
    if at_step is not None and not 0 <= at_step <= last:
        raise InputError(f"--at-step {at_step}: the drawing has steps 0 to {last}")
    files = [] if save is None else [save]
    if figure is not None:
        with blaming(f"--kind {kind}"):  # the drawing lacks what the figure shows
            files += draw(kind, figure.path, drawing, title=title, look=figure.look, step=at_step)
    told = drawing_summary(drawing, perf_counter() - started)
    return {**told, "files": [str(path) for path in files]}


def _over_run(
    folder: Path, overrides: Sequence[str | Setting], check: Check
) -> tuple[str, Drawing, Callable[[], Content]]:
    """Return the construction over the results of a run: title, drawing, and content of a recording."""
    results = read_results(folder)
    run = results.summary
    if not run.keys() >= {"construction", "model", "parameters"}:
        raise InputError(f"{folder}: {DAMAGED}")
    settings = construction_settings(run["construction"], overrides)
    drawing = overlay_run(results.columns, run["model"], run["parameters"], settings, check)
    return run["title"] or run["scene"], drawing, partial(of_results, results, drawing, Show())


def _of_scene(
    what: str, overrides: Sequence[str | Setting], over: Path | None, check: Check
) -> tuple[str, Drawing, Callable[[], Content]]:
    """Return the construction of a scene as `_over_run`; over the motion in a table, if one is given."""
    scene = load_scene(_scene_or_folder(what), overrides, expect=False)
    columns = None if over is None else read_table(over)[0]
    try:
        if columns is None:
            scene.check_construction()
            drawing = draw_scene(scene, check)
        else:
            settings = asdict(scene.construction)
            model, parameters = scene.fmu.model, scene.all_parameters
            drawing = overlay_run(columns, model, parameters, settings, check)
    except ArithmeticError as error:
        raise RunError(f"the construction cannot be drawn: {error}") from None
    return scene.title or scene.name, drawing, partial(of_scene, scene, drawing, columns)


def _results_folder(path: Path) -> Path | None:
    """Return the results folder at this path, or the one that contains the table at this path."""
    if path.is_dir():
        return path
    return path.parent if path.is_file() and read_summary(path.parent) is not None else None


def _scene_or_folder(what: str) -> str:
    """Return the reference of a scene, after checking that it exists."""
    if Path(what).suffix in ENDINGS:
        raise InputError(
            f"{what} is a table without a model; give its scene too: replay SCENE --over {what}"
        )
    try:
        find_scene(what)
    except InputError as error:
        file = "the path of a .toml file"
        raise InputError(str(error).replace(file, f"{file} or of a results folder")) from None
    return what
