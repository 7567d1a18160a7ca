"""Run a design study and write its folder: runs, picture, and a scene with the parameters found."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension import engine
from phaseplane.suspension.roads import extent

from phaseplane import figures

from ..draw.pictures import draws_or_tells
from ..errors import InputError, NoResultError
from ..progress import Progress, silent
from ..results.folder import Place, replace_folder, write_summary
from ..results.report import UNCOMPILED
from ..results.tables import write_table
from ..scene.names import SCENE_FILES, meant
from . import report
from .fit import fit, read_task
from .optimum import read_problem, solve
from .space import Space

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure

SCENE, TABLE, PICTURE = "scene.toml", "runs.csv", "study.png"


@dataclass(frozen=True)
class Study:
    """The result of a design study.

    Parameters
    ----------
    values : the parameters found, in SI
    summary : the summary as plain data
    report : the report in words
    folder : the folder with the runs, the picture and `scene.toml`, a scene with the parameters found
    """

    values: Mapping[str, float]
    summary: Mapping[str, Any]
    report: str
    folder: Path

    def __str__(self) -> str:
        return self.report


def optimise(
    file: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Study:
    """Find the parameters that minimise or maximise a measure while others keep their bounds.

    Parameters
    ----------
    file : a file with `scene`, `minimise` or `maximise`, `vary` and, if wanted, `constrain`, `against`
    folder : folder to write to, replaced as a whole; `out/studies/<file>` if None
    progress : called with the fraction done, 0 to 1

    Raises
    ------
    InputError : if the file is not valid, or the folder must not be replaced.
    RunError : if no run has all measures.
    """
    path = _file(file)
    problem = read_problem(path)
    place = _place(path, folder, "optimise", problem.space)
    with _journal(place) as journal:
        found = solve(problem, journal, progress or silent)
        facts, words = report.optimum_data(found), report.format_optimum(found)
        runs = report.optimum_runs(found)
        return _written(
            place, problem.space, found.best, facts, words, runs,
            lambda: report.draw_optimum(found, runs),
        )  # fmt: skip


def fit_parameters(
    file: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Study:
    """Fit parameters of a scene to measured signals by least squares, with their confidence.

    Parameters
    ----------
    file : a file with `scene`, `vary` and `measured`
    folder, progress : as for `optimise`

    Raises
    ------
    InputError : if the file or its signals are not valid, or the folder must not be replaced.
    RunError : if no run succeeds.
    """
    path = _file(file)
    task = read_task(path)
    place = _place(path, folder, "fit", task.space)
    with _journal(place) as journal:
        found = fit(task, journal, progress or silent)
        shares = task.space.shares(found.values.tolist())
        facts, words = report.fit_data(found), report.format_fit(found)
        return _written(
            place, task.space, shares, facts, words, report.fit_signals(found),
            lambda: report.draw_fit(found),
        )  # fmt: skip


def _file(file: str | os.PathLike[str]) -> Path:
    path = Path(file)
    if path.is_dir():
        raise InputError(f"{path} is a folder; give a study's file, such as study.toml")
    if not path.is_file():
        hint = meant(str(path), "study") or "; give the path of a study's file, such as study.toml"
        raise InputError(f"no such file: {path}{hint}")
    return path


def _place(path: Path, folder: str | os.PathLike[str] | None, kind: str, space: Space) -> Place:
    place = Place.chosen(Path(folder) if folder else None, f"studies/{path.stem}", kind, path)
    place.check_apart(f"{path}: scene =", Path(space.plan.reference))
    return place


@contextmanager
def _journal(place: Place) -> Iterator[Path]:
    """Yield the file of the runs so far; it stays if the study may be continued."""
    journal = place.folder.with_name(f".{place.folder.name}.{place.kind}.journal")
    try:
        yield journal
    except NoResultError:
        journal.unlink()
        raise
    journal.unlink()


def _written(
    place: Place, space: Space, shares: Any, facts: Mapping[str, Any], words: list[str],
    columns: dict[str, Any], draw: Callable[[], Figure],
) -> Study:  # fmt: skip
    values = dict(zip(space.plan.keys, space.values(shares).tolist(), strict=True))
    problems: list[str] = []
    slow = [] if engine.compiled else [f"run in this process{UNCOMPILED}"]
    with replace_folder(place) as draft:
        (draft / SCENE).write_text(_scene(space, values, place.folder), encoding="utf-8")
        write_table(columns, {}, draft / TABLE)
        with draws_or_tells(PICTURE, problems):
            figures.save(draw(), draft / PICTURE)
        summary = {
            **facts, "title": space.plan.title, "scene": space.plan.scene.name, "values": values,
            "units": dict(zip(space.plan.keys, space.plan.units, strict=True)),
            "problems": problems, "origin": place.origin,
        }  # fmt: skip
        summary["files"] = write_summary(summary, draft)
    lines = [space.plan.title or space.plan.name, "", *words, *slow, *problems, ""]
    lines += [str(place.folder / name) for name in summary["files"]]
    return Study(values, summary, "\n".join(lines), place.folder)


def _scene(space: Space, values: Mapping[str, float], folder: Path) -> str:
    """Return a scene file with the parameters found, on the road of the study's runs."""
    base, plan = space.plan.reference, space.plan
    if plan.road_length is not None:
        given = {k: v for k, v in plan.scene.parameters.items() if k != extent.LENGTH}
        own = plan.scene.fmu.road_length({**given, **values}, plan.scene.duration)
        if own.get(extent.LENGTH) != plan.road_length:
            values = {**values, extent.LENGTH: plan.road_length}
    if base.endswith(SCENE_FILES) and Path(base).is_file():
        base = Path(os.path.relpath(Path(base).resolve(), folder.resolve())).as_posix()
    lines = [f'extends = "{base}"', "", "[parameters]"]
    return "\n".join([*lines, *(f"{key} = {value!r}" for key, value in values.items()), ""])
