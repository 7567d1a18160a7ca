"""`phaseplane exercise`: sheets to construct on, and the marking of readings."""

from __future__ import annotations

from pathlib import Path

import click

from ..draw import exercises
from ..errors import InputError, blaming, read_text
from ..results.folder import Place, replace_folder, write_summary
from ..results.plain import as_json
from ..scene.loading import load_scene
from .console import DONE, FAILED, FiniteRange, json_option, output_option, progress_bar, set_option


@click.command()
@click.argument("scene")
@set_option
@output_option("out/exercises/SCENE")
@click.option(
    "--steps",
    type=int,
    default=10,
    show_default=True,
    help="Steps of construction.step to construct; a switch divides its step and adds a point.",
)
@click.option(
    "--paper",
    type=click.Choice(["A4", "A3"]),
    default="A4",
    show_default=True,
    help="Size of paper.",
)
@click.option(
    "--mark",
    "readings",
    type=click.Path(path_type=Path),
    metavar="READINGS",
    help="Mark these readings (CSV) instead of writing the sheets.",
)
@click.option(
    "--tolerance",
    type=FiniteRange(min=0.0, min_open=True),
    default=1.0,
    show_default=True,
    help="Allowed error of a point when marking, mm of paper.",
)
@json_option
def exercise(
    *,
    scene: str,
    overrides: tuple[str, ...],
    output: Path | None,
    steps: int,
    paper: str,
    readings: Path | None,
    tolerance: float,
    as_data: bool,
) -> int:
    """Write an exercise: construct the first steps of SCENE by hand.

    The folder contains a sheet at true scale, a sheet with the solution, a table for the readings, a page
    on which the points can be clicked instead, the protocol and a GeoGebra file. With --mark, each point
    is judged from the student's previous point; the exit status is 1 unless all points are right.
    """
    loaded = load_scene(scene, overrides, expect=False)
    with progress_bar(f"exercise of {loaded.name}"):
        made = exercises.exercise(loaded, steps, paper)
    if readings is not None:
        place = None if output is None else Place(output, "exercise", loaded.file)
        if place is not None:
            place.check_apart("--mark", readings)
            _keep_readings(place.folder)
        text = read_text(readings)
        with blaming(f"--mark {readings}"):
            summary = exercises.marked(made, text, 1e-3 * tolerance)
        if place is not None:
            with replace_folder(place) as draft:
                exercises.write_marked_sheet(made, summary, draft / "marked.pdf")
                write_summary({**summary, "origin": place.origin}, draft)
        click.echo(as_json(summary) if as_data else exercises.format_marks(summary))
        return DONE if summary["right"] == made.steps else FAILED
    place = Place.chosen(output, f"exercises/{loaded.name}", "exercise", loaded.file)
    _keep_readings(place.folder)
    with progress_bar(f"sheets of {loaded.name}"), replace_folder(place) as draft:
        exercises.write_sheets(made, draft)
        write_summary({"scene": loaded.name, "steps": made.steps, "origin": place.origin}, draft)
        names = [str(place.folder / path.name) for path in sorted(draft.iterdir())]
    if as_data:
        click.echo(as_json({"scene": loaded.name, "steps": made.steps, "files": names}))
    else:
        click.echo(f"{loaded.title or loaded.name}: {made.extent} on {paper}")
        click.echo("\n".join(f"file  {name}" for name in names))
    return DONE


def _keep_readings(folder: Path) -> None:
    """Refuse to replace an exercise whose table of readings has been filled in."""
    if exercises.has_readings(folder):
        raise InputError(
            f"{folder / exercises.READINGS} has been filled in, and a new exercise would replace it; "
            "move it, or give another folder with -o"
        )
