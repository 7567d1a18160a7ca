"""Run a design study and write its folder: runs, picture, and a scene with the parameters found."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension import engine
from phaseplane.suspension.roads import extent
from phaseplane.suspension.units import counted
from phaseplane.suspension.variables import Value

from phaseplane import figures
from phaseplane.picture.text import bracketed, in_words

from ..draw.pictures import draws_or_tells
from ..errors import InputError, NoResultError
from ..measures import catalogue, has_sign
from ..progress import Progress, silent
from ..results.folder import Place, replace_folder, write_summary
from ..results.quantities import quantity, shown_in, sizes, with_unit
from ..results.report import UNCOMPILED, aligned
from ..results.tables import write_table
from ..scene.expectations import Bounds
from ..scene.names import SCENE_FILES, meant
from ..sweeps.job import picture_of
from .fit import Fit, fit, read_task
from .optimum import Optimum, read_problem, solve
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
        return _written(
            place, problem.space, found.best, _optimum_data(found), _format_optimum(found),
            _optimum_runs(found), lambda runs: _draw_optimum(found, runs),
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
        return _written(
            place, task.space, shares, _fit_data(found), _format_fit(found), _fit_signals(found),
            lambda _: _draw_fit(found),
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
    columns: dict[str, Any], draw: Callable[[dict[str, Any]], Figure],
) -> Study:  # fmt: skip
    values = dict(zip(space.plan.keys, space.values(shares).tolist(), strict=True))
    problems: list[str] = []
    slow = [] if engine.compiled else [f"run in this process{UNCOMPILED}"]
    with replace_folder(place) as draft:
        (draft / SCENE).write_text(_scene(space, values, place.folder), encoding="utf-8")
        write_table(columns, {}, draft / TABLE)
        with draws_or_tells(PICTURE, problems):
            figures.save(draw(columns), draft / PICTURE)
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


def _value(space: Space, k: int, value: float) -> str:
    unit, size = space.plan.shown[k]
    return with_unit(f"{value / size:.5g}", unit)


# -- optimum ---------------------------------------------------------------------------------------


def _optimum_data(found: Optimum) -> dict[str, Any]:
    measures = found.problem.measures
    return {
        "objective": found.problem.objective,
        "sense": "minimise" if found.problem.sign > 0 else "maximise",
        "feasible": found.feasible,
        "without_effect": list(found.without_effect),
        "at_bound": _at_bound(found),
        "runs": len(found.points),
        "made": found.made,
        "measures": {
            name: {"before": float(a), "found": float(b)}
            for name, a, b in zip(measures, found.numbers_before, found.numbers, strict=True)
        },
        "trade_off": [
            {
                **dict(zip(found.problem.space.plan.keys, point, strict=True)),
                **dict(zip(measures, numbers, strict=True)),
            }
            for point, numbers in zip(
                found.problem.space.values(found.front[0]).tolist(), found.front[1].tolist(),
                strict=True,
            )
        ],
    }  # fmt: skip


def _format_optimum(found: Optimum) -> list[str]:
    problem, space = found.problem, found.problem.space
    known = catalogue(space.plan.scene.fmu.outputs())
    rows: list[tuple[str, ...]] = [("parameter", "before", "found", "from", "to")]
    for k, key in enumerate(space.plan.keys):
        ends = (space.lows[k], space.lows[k] + space.widths[k])
        points = (space.values(found.before)[k], space.values(found.best)[k], *ends)
        rows.append((key, *(_value(space, k, float(x)) for x in points)))
    measured: list[tuple[str, ...]] = [("measure", "before", "found", "bound")]
    units = {name: known[name].unit_of_one for name in problem.measures}
    both = (found.numbers_before, found.numbers)
    size = [sizes((n, units[n], x[k].item()) for k, n in enumerate(problem.measures)) for x in both]
    for k, (name, unit) in enumerate(units.items()):
        bound = problem.bounds.get(name)
        limits = [] if bound is None else [
            f"{word} {quantity(limit, unit)}"
            for word, limit in (("at least", bound.min), ("at most", bound.max)) if limit is not None
        ]  # fmt: skip
        role = ("least" if problem.sign > 0 else "largest") if name == problem.objective else ""
        values = (
            quantity(x[k].item() if isfinite(x[k]) else None, unit, of[name])
            for x, of in zip(both, size, strict=True)
        )
        measured.append((name, *values, ", ".join([*([role] if role else []), *limits])))
    lacking = int(np.isnan(found.measured).any(axis=1).sum())
    made = counted(len(found.points), "run")
    if lacking:
        made = f"{made}, of which {lacking} failed or lack a measure"
    lines = [*aligned(rows), "", *aligned(measured), "", made]
    scene = space.plan.scene.all_parameters
    lines += [
        f"{key} of the scene, {_value(space, k, float(scene[key]))}, is outside its range; before is at "
        "the nearest end"
        for k, key in enumerate(space.plan.keys)
        if abs((float(scene[key]) - space.lows[k]) / space.widths[k] - 0.5) > 0.5 + 1e-9
    ]
    lines += [
        f"{name} has no effect on the measures at both ends and in the middle of its range"
        for name in found.without_effect
    ]
    lines += [f"{name} ends at a bound of its range" for name in _at_bound(found)]
    if not found.feasible:
        lines.append("no point satisfies all bounds; the one found violates them least")
    return lines


def _at_bound(found: Optimum) -> list[str]:
    """Return the parameters with an effect whose range the optimum might lie beyond."""
    ends = found.problem.space.at_bound(found.best)
    return [name for name in ends if name not in found.without_effect]


def _optimum_runs(found: Optimum) -> dict[str, Any]:
    """Return the parameters and the measures of all runs."""
    runs = np.column_stack([found.problem.space.values(found.points), found.measured])
    names = (*found.problem.space.plan.keys, *found.problem.measures)
    return dict(zip(names, runs.T, strict=True))


def _draw_optimum(found: Optimum, columns: Mapping[str, Any]) -> Figure:
    problem, space = found.problem, found.problem.space
    measures = problem.measures
    known = catalogue(space.plan.scene.fmu.outputs())
    others = [name for name in (problem.against, *problem.bounds) if name]
    if not others or others[0] == problem.objective:
        points = space.values(found.points).tolist()
        return picture_of(space.plan, points, {problem.objective: columns[problem.objective]})
    pair = (problem.objective, others[0])
    shown = [shown_in(known[name].unit_of_one) for name in pair]
    labels = [
        "magnitude of " * has_sign(name) + in_words(name) + bracketed(unit)
        for name, (unit, _) in zip(pair, shown, strict=True)
    ]

    def size(k: int, values: Any) -> Any:
        """Return values of a measure of the pair as they are drawn and compared."""
        sized = shown[k][1] * np.asarray(values, float)
        return abs(sized) if has_sign(pair[k]) else sized

    def scaled(numbers: Any) -> Any:
        table = np.atleast_2d(numbers)
        return tuple(size(k, table[:, measures.index(name)]) for k, name in enumerate(pair))

    bounds = [problem.bounds.get(name, Bounds()) for name in pair]
    limits = [
        sorted({float(size(k, limit)) for limit in (bound.min, bound.max) if limit is not None})
        for k, bound in enumerate(bounds)
    ]
    marked = {}
    for label, numbers in (("before", found.numbers_before), ("found", found.numbers)):
        x, y = scaled(numbers)
        marked[label] = (float(x[0]), float(y[0]))
    return figures.pareto(
        scaled(found.measured), (labels[0], labels[1]), front=scaled(found.envelope),
        marked=marked, limits=(limits[0], limits[1]), title=space.plan.title,
    )  # fmt: skip


# -- fit ---------------------------------------------------------------------------------------------


def _fit_data(found: Fit) -> dict[str, Any]:
    keys = found.task.space.plan.keys
    return {
        "half_widths": dict(zip(keys, found.errors.tolist(), strict=True)),
        "confidence": 0.95,
        "correlation": found.correlation.tolist(),
        "residual": dict(found.residual),
        "at_bound": list(found.at_bound),
        "samples": len(found.task.time),
        "made": found.made,
    }


def _format_fit(found: Fit) -> list[str]:
    space = found.task.space
    given: Mapping[str, Value] = space.plan.scene.all_parameters
    rows: list[tuple[str, ...]] = [("parameter", "before", "fitted", "within (95 %)")]
    for k, key in enumerate(space.plan.keys):
        unit, size = space.plan.shown[k]
        within = with_unit(f"+- {found.errors[k] / size:.2g}", unit)
        values = (_value(space, k, float(x)) for x in (given[key], found.values[k]))
        rows.append((key, *values, within if isfinite(found.errors[k]) else "not known"))
    left = [("signal", "difference left")]
    left += [(name, f"{100.0 * share:.3g} %") for name, share in found.residual.items()]
    lines = [*aligned(rows), "", *aligned(left)]
    lines += [f"{name} ends at a bound of its range" for name in found.at_bound]
    lines += [
        f"{key} is not known: the signals do not depend on it"
        for key, error in zip(space.plan.keys, found.errors, strict=True)
        if not isfinite(error)
    ]
    lines += [
        f"the signals hardly distinguish {a} and {b}: their correlation is {r:.3f}"
        for a, b, r in found.alike()
    ]
    return lines


def _fit_signals(found: Fit) -> dict[str, Any]:
    """Return every signal as measured and as fitted."""
    columns = {"time": found.task.time}
    for name, signal in found.task.signals.items():
        columns |= {f"{name}.measured": signal, f"{name}.fitted": found.columns[name]}
    return columns


def _draw_fit(found: Fit) -> Figure:
    task, time = found.task, found.task.time
    units = {n: v.unit for n, v in task.space.plan.scene.fmu.outputs().items()}
    each = {
        name: {"measured": (time, signal), "fitted": (time, found.columns[name])}
        for name, signal in task.signals.items()
    }
    return figures.runs(each, units, title=task.space.plan.title)
