"""The studies with their data, tables and pictures, each in a folder of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from phaseplane import figures

from ..results.folder import OUTPUT, Place, check_replaceable, replace_folder, write_summary
from . import stability as study
from .accuracy import measure, solvers
from .accuracy_report import as_data, panels, table
from .problems import PROBLEMS, find_problem


def study_accuracy(
    references: Sequence[str],
    with_peers: bool,
    repeats: int,
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> tuple[dict[str, Any], str, Path]:
    """Measure error against run time, and write data, tables and a picture to a folder.

    Parameters
    ----------
    references : names of problems or scenes; all problems if empty
    repeats : number of timings of each run
    folder : folder to write to, replaced as a whole; `out/accuracy` if None

    Returns
    -------
    The data, the tables as text, and the folder.

    Raises
    ------
    InputError : if there is no such problem or scene, or its model is not of this package.
    """
    place = Place(folder or OUTPUT / "accuracy", "accuracy", named=folder is not None)
    check_replaceable(place)
    problems = [find_problem(name) for name in references or PROBLEMS]
    compared = solvers(with_peers=with_peers)
    points = []
    for k, problem in enumerate(problems):

        def part(done: float, k: int = k) -> None:
            if progress is not None:
                progress((k + done) / len(problems))

        points += measure(problem, compared, repeats, part)
    data = as_data(problems, points, repeats)
    tables = "\n\n".join(table(problem, points) for problem in problems)
    with replace_folder(place) as draft:
        figure = figures.work_precision(panels(problems, points), title="Error against run time")
        figures.save(figure, draft / "accuracy.png")
        (draft / "accuracy.txt").write_text(f"{tables}\n", encoding="utf-8")
        write_summary({**data, "origin": place.origin}, draft)
    return data, tables, place.folder


def study_stability(
    references: Sequence[str],
    folder: Path | None = None,
    progress: Callable[[float], None] | None = None,
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
    The data, the table as text, and the folder.

    Raises
    ------
    InputError : if there is no such problem or scene, or its model is not of this package.
    """
    place = Place(folder or OUTPUT / "stability", "stability", named=folder is not None)
    check_replaceable(place)
    problems = [find_problem(name) for name in references or PROBLEMS]
    if not references:
        problems = [problem for problem in problems if problem.kind == "non-smooth"]

    def part(first: float, width: float) -> Callable[[float], None]:
        return lambda done: progress(first + width * done) if progress is not None else None

    made = study.maps(size, part(0.0, 0.5))
    found = study.limits(problems, part(0.5, 0.3))
    happened = study.extremes(part(0.8, 0.2))
    data, table = study.as_data(made, found, happened), study.table(found, happened)
    figure = figures.stability_sheet(
        {name: (made.phases, curve) for name, curve in made.curves.items()},
        {"2√3": study.LINEAR, "order 8: 3.2": study.EIGHTH},
        [
            figures.GrowthMap("Order 8, spectral radius of a step", made.grid, made.damping_ratios,
                      "damping ratio", made.damped, study.EIGHTH),
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
    with replace_folder(place) as draft:
        figures.save(figure, draft / "stability.png")
        (draft / "stability.txt").write_text(f"{table}\n", encoding="utf-8")
        write_summary({**data, "origin": place.origin}, draft)
    return data, table, place.folder
