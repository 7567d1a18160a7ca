"""The studies with their data, tables and pictures, each in a folder of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane import figures

from ..draw.pictures import draws_or_tells
from ..errors import InputError
from ..progress import Progress, part_of, silent
from ..results.folder import Place, replace_folder, write_summary
from . import stability as study
from .accuracy import measure, solvers
from .accuracy_report import as_data, panels, table
from .equations import Equations
from .problems import PROBLEMS, Problem, find_problem

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure


def study_accuracy(
    references: Sequence[str],
    with_peers: bool,
    repeats: int,
    folder: Path | None = None,
    progress: Progress = silent,
) -> tuple[dict[str, Any], str, Path]:
    """Measure error against run time, and write data, tables and a picture to a folder.

    Parameters
    ----------
    references : names of problems or scenes; all problems if empty
    repeats : number of timings of each run
    folder : folder to write to, replaced as a whole; `out/accuracy` if None

    Returns
    -------
    The data as written, the tables as text, and the folder.

    Raises
    ------
    InputError : if there is no such problem or scene, its model is not of this package, or there is no
        independent solution.
    """
    place = Place.chosen(folder, "accuracy", "accuracy")
    problems = [find_problem(name) for name in references or PROBLEMS]
    for problem in problems:
        _check_solved(problem)
    compared = solvers(with_peers=with_peers)
    points, width = [], 1.0 / len(problems)
    for k, problem in enumerate(problems):
        points += measure(problem, compared, repeats, part_of(progress, k * width, width))
    data = as_data(problems, points, repeats)
    tables = "\n\n".join(table(problem, points) for problem in problems)

    def draw() -> Figure:
        return figures.work_precision(panels(problems, points), title="Error against run time")

    return _write(place, data, tables, draw), tables, place.folder


def study_stability(
    references: Sequence[str],
    folder: Path | None = None,
    progress: Progress = silent,
    size: int = 32,
) -> tuple[dict[str, Any], str, Path]:
    """Find the largest stable steps, and write data, a table and a picture to a folder.

    Parameters
    ----------
    references : names of problems or scenes; all non-smooth problems if empty
    folder : folder to write to, replaced as a whole; `out/stability` if None
    size : points along each side of the maps

    Returns
    -------
    The data as written, the table as text, and the folder.

    Raises
    ------
    InputError : if there is no such problem or scene, its model is not of this package, or nothing in it
        oscillates.
    """
    place = Place.chosen(folder, "stability", "stability")
    problems = [find_problem(name) for name in references or PROBLEMS]
    if not references:
        problems = [problem for problem in problems if problem.kind == "non-smooth"]

    found = study.limits(problems, part_of(progress, 0.0, 0.3))
    made = study.maps(size, part_of(progress, 0.3, 0.5))
    happened = study.extremes(part_of(progress, 0.8, 0.2))
    data, table = study.as_data(made, found, happened), study.table(found, happened)

    def draw() -> Figure:
        return figures.stability_sheet(
            {name: (made.phases, curve) for name, curve in made.curves.items()},
            {"2√3": study.LINEAR, "order 8: 3.2": study.EIGHTH},
            [
                figures.GrowthMap("Order 8, spectral radius of a step", made.grid,
                          made.damping_ratios, "damping ratio", made.damped, study.EIGHTH),
                figures.GrowthMap("Linear acceleration, two masses: of a step", made.grid, made.ratios,
                          "ratio of the springs", made.coupled, study.LINEAR),
                figures.GrowthMap("Linear acceleration between stops: energy", made.grid, made.ratios,
                          "stop over spring", made.bounced, study.LINEAR, of_runs=True),
            ],
            [
                (one.problem, one.method, one.theory, one.measured)
                for one in found
                if one.theory is not None
            ],
        )  # fmt: skip

    return _write(place, data, table, draw), table, place.folder


def _check_solved(problem: Problem) -> None:
    """Refuse a problem without an independent solution, before any is solved."""
    try:
        Equations(problem.system)
    except ValueError as error:
        raise InputError(f"{problem.name}: errors cannot be measured, as {error}") from None


def _write(
    place: Place, data: Mapping[str, Any], text: str, draw: Callable[[], Figure]
) -> dict[str, Any]:
    """Write the picture, the text and the data of a study to its folder; return the data as written.

    They say in `not_drawn` what is wrong with the picture, a line each.
    """
    problems: list[str] = []
    with replace_folder(place) as draft:
        (draft / f"{place.kind}.txt").write_text(f"{text}\n", encoding="utf-8")
        picture = f"{place.kind}.png"
        with draws_or_tells(picture, problems):
            figures.save(draw(), draft / picture)
        written = {**data, "not_drawn": problems, "origin": place.origin}
        write_summary(written, draft)
    return written
