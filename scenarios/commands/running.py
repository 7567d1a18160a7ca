"""Scenes run, FMUs packed, constructions replayed."""

from __future__ import annotations

from pathlib import Path

import click

from ..console import (
    DONE,
    FAILED,
    complain,
    dark_option,
    figure_option,
    json_option,
    output_option,
    progress_bar,
    set_option,
)
from ..errors import InputError
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
    """Run SCENE: the name of a case (see `list`), a scene file, or any .fmu file.

    With --connect, --serve or --save it is shown or recorded while it goes on.
    """
    from ..job import run_scene  # noqa: PLC0415
    from ..report import failures, report  # noqa: PLC0415
    from ..results import as_json  # noqa: PLC0415

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


@click.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    metavar="DIR",
    help="Folder for the FMUs.",
)
@click.option("--ssp", is_flag=True, help="Also pack each vehicle on its road as an SSP system.")
@json_option
def build(models: tuple[str, ...], output: Path, ssp: bool, as_data: bool) -> None:
    """Pack FMUs: the MODELs named, or all; with a reference result beside each."""
    from ..job import build_models  # noqa: PLC0415
    from ..results import as_json  # noqa: PLC0415

    files = [str(path) for path in build_models(models, output, ssp)]
    click.echo(as_json({"files": files}) if as_data else "\n".join(files))


@click.command("list")
@json_option
def list_cases(as_data: bool) -> None:
    """List the scenes and the sweeps that come with the package."""
    from ..layers import case_titles  # noqa: PLC0415
    from ..results import as_json  # noqa: PLC0415
    from ..sweeps.plan import sweep_titles  # noqa: PLC0415

    titles = {"scenes": case_titles(), "sweeps": sweep_titles()}
    if as_data:
        click.echo(as_json(titles))
        return
    width = max(len(name) for named in titles.values() for name in named)
    for command, named in zip(("run", "sweep"), titles.values(), strict=True):
        click.echo(f"phaseplane {command}")
        for name, title in named.items():
            click.echo(f"  {name:<{width}}  {title}")


@click.command()
@click.argument("what", metavar="SCENE|RESULTS")
@set_option
@click.option(
    "--over",
    type=click.Path(path_type=Path),
    metavar="TABLE",
    help="Lay the construction of SCENE over the motion in a table, e.g. motion.csv.",
)
@click.option("--construction", "rule", metavar="RULE", help="How a step is made, e.g. delta.")
@click.option("--step", metavar="TIME", help="Step of the construction, e.g. '2.5 ms'.")
@save_option
@figure_option("the phase planes, or of another --kind", ", moving as .gif or .mp4")
@click.option(
    "--kind",
    default="phase_planes",
    show_default=True,
    metavar="NAME",
    help="Which figure: phase_planes, construction_sheet, or one of AP57's: figure4a, figure4b, "
    "figure7 to figure10, figure12 to figure16.",
)
@dark_option
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
    figure: Path | None,
    kind: str,
    dark: bool,
    viewer: str,
    served: bool,
    address: str,
    as_data: bool,
) -> None:
    """Replay the graphical construction of a SCENE, or lay it over the RESULTS of a run."""
    from ..job import replay as make  # noqa: PLC0415
    from ..report import drift_words  # noqa: PLC0415
    from ..results import as_json  # noqa: PLC0415

    if save is None and figure is None and not viewer and not served:
        raise InputError(
            "replay: nothing to do; give one or more of --save F.rrd, --figure F.png, --connect URL "
            "and --serve"
        )
    extra = (("construction.rule", rule), ("construction.step", step))
    settings = (*overrides, *(f"{key}={value}" for key, value in extra if value is not None))
    with page(served, address) as server:
        shown_in = viewer or (server.url if server else "")
        told = make(what, settings, save, figure, shown_in, over, kind=kind, dark=dark)
        places = ", ".join([*told["files"], *([viewer] if viewer else [])])
        click.echo(
            as_json(told)
            if as_data
            else f"{told['title']}: {told['steps']} steps"
            + (f" in {places}" if places else "")
            + drift_words(told)
        )
        until_interrupted(server)
