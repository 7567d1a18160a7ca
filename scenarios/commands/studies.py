"""`phaseplane accuracy`, `rules` and `stability`: studies of the integrator and the constructions."""

from __future__ import annotations

from pathlib import Path

import click

from ..results.plain import as_json
from ..scene.loading import load_scene
from ..studies import rules as study
from ..studies.accuracy import REPEATS
from ..studies.problems import PROBLEMS
from ..studies.reports import study_accuracy, study_stability
from .console import failed, json_option, output_option, progress_bar, set_option, warn


@click.command(
    help=f"""Measure error against run time.

    Each SCENE is a scene or a test problem of the package. By default these are run:
    {", ".join(PROBLEMS)}.
    """
)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option("--peers", is_flag=True, help="Compare with other installed integrators too.")
@click.option(
    "--repeats",
    type=click.IntRange(1, 1000),
    default=REPEATS,
    show_default=True,
    help="Number of timings of each run.",
)
@output_option("out/accuracy")
@json_option
def accuracy(
    *, scenes: tuple[str, ...], peers: bool, repeats: int, output: Path | None, as_data: bool
) -> int:
    """Measure error against run time."""
    with progress_bar("accuracy") as progress:
        data, tables, folder = study_accuracy(scenes, peers, repeats, output, progress)
    click.echo(as_json(data) if as_data else f"{tables}\n\nfiles  {folder}")
    return failed("accuracy", data["not_drawn"])


@click.command()
@click.argument("scene", default="ap57_figure13")
@set_option
@json_option
def rules(scene: str, overrides: tuple[str, ...], as_data: bool) -> None:
    """Compare the step rules with the exact motion.

    The rules are those of the graphical construction; the integrator is compared too. [default of
    SCENE: ap57_figure13, the 60 points of the worked example]
    """
    loaded = load_scene(scene, overrides, expect=False)
    warn(loaded.warnings)
    with progress_bar("rules"):
        results = study.measure_rules(loaded)
    click.echo(
        as_json(study.as_data(loaded, results)) if as_data else study.rules_table(loaded, results)
    )


@click.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@output_option("out/stability")
@json_option
def stability(*, scenes: tuple[str, ...], output: Path | None, as_data: bool) -> int:
    """Find the largest stable steps, in theory and in runs.

    Each SCENE is a scene or a test problem of the package; default: all test problems with switches.
    A table of extreme cases is run, too; the exit status is 1 if one of them fails.
    """
    with progress_bar("stability") as progress:
        data, table, folder = study_stability(scenes, output, progress)
    click.echo(as_json(data) if as_data else f"{table}\n\nfiles  {folder}")
    wrong = [case["name"] for case in data["extremes"] if case["outcome"] == "wrong"]
    reasons = [f"wrong results: {', '.join(wrong)}"] if wrong else []
    return failed("stability", [*reasons, *data["not_drawn"]])
