"""The content of a results file, and the difference between two of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import counted, nearest

from phaseplane import figures

from ..errors import InputError, blaming, shown
from ..look import FigureFile
from ..toml_files import read_content
from .comparison import check_ascending, compared, format_extent
from .folder import DAMAGED, Results, read_results
from .quantities import quantity, rounded, sizes
from .report import aligned, report
from .signals import signals_in

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure

_MOST_COMPARED = 6  # columns in the picture of a comparison


def contents(
    results: Results,
    what: Path,
    names: Sequence[str] = (),
    figure: FigureFile | None = None,
    plane: tuple[str, str] | None = None,
    others: Sequence[Path] = (),
) -> dict[str, Any]:
    """Return the summary of results and the range of each column; draw them if asked.

    Parameters
    ----------
    what : the folder or the table that they are from
    names : columns to list and draw; all if empty
    figure : picture to write, of the columns over time
    plane : two columns that the picture shows one over the other instead, the abscissa first
    others : further results that the picture shows too, or TOML files with a table [measured]

    Raises
    ------
    InputError : if there is no such column, or the others are no results.
    """
    columns = _chosen(results, names, what)
    units = results.units
    if not isinstance(units, Mapping):
        raise InputError(f"{what}: {DAMAGED}")
    data = {
        "file": str(what),
        "summary": results.summary,
        "rows": len(next(iter(results.columns.values()))),
        "columns": {
            name: {
                "unit": units.get(name, ""),
                "first": float(column[0]),
                "last": float(column[-1]),
                "min": float(column.min()),
                "max": float(column.max()),
            }
            for name, column in columns.items()
        },
    }
    if figure is not None:
        drawn = {what: results, **{path: results_in(path, results) for path in others}}
        data["files"] = figure.save(_picture(drawn, names, plane, units, figure.look))
    return data


def results_in(path: Path, run: Results | None = None) -> Results:
    """Return results, or the measured signals of outputs of a run that a TOML file describes.

    The first column of a table is the time if no other is called so and it is in a unit of time.
    """
    if path.suffix != ".toml":
        found = read_results(path)
        units, first = found.units, next(iter(found.columns))
        if "time" in found.columns or not isinstance(units, Mapping) or units.get(first) != "s":
            return found
        columns = {"time" if name == first else name: x for name, x in found.columns.items()}
        return Results(columns, {**found.summary, "units": {**units, "time": "s"}})
    if run is None:
        raise InputError(f"{path}: give the results of a run first, then the measured signals")
    known = {name: run.units.get(name) or "1" for name in run.columns if name != "time"}
    columns = signals_in(path, read_content(path), known)
    return Results(columns, {"units": {"time": "s", **known}})


def _title(drawn: Mapping[Path, Results]) -> str:
    """Return the titles of results, or the names of those that have none."""
    titles = (str(one.summary.get("title", path.name)) for path, one in drawn.items())
    return "; ".join(dict.fromkeys(titles))


def _labels(paths: Iterable[Path]) -> dict[Path, str]:
    """Return the names of results in a legend: their last parts, if these differ."""
    paths = list(paths)
    short = len({path.name for path in paths}) == len(paths)
    return {path: path.name if short else str(path) for path in paths}


def _picture(
    drawn: Mapping[Path, Results],
    names: Sequence[str],
    plane: tuple[str, str] | None,
    units: Mapping[str, str],
    look: figures.Look,
) -> Figure:
    """Return the picture of one or more results, over time or one column over another."""
    labels, title = _labels(drawn), _title(drawn)
    if plane is not None:
        curves = {}
        for path, results in drawn.items():
            chosen = _chosen(results, plane, path)
            curves[labels[path]] = (chosen[plane[0]], chosen[plane[1]])
        return figures.plane_of_columns(curves, plane, units, title=title, look=look)
    values: dict[str, dict[str, Any]] = {}
    first = next(iter(drawn))
    for path, results in drawn.items():
        time = _time(results, path, "--plane X,Y draws a column over another")
        columns = _chosen(results, names, path)
        if values and path != first and values.keys().isdisjoint(columns):
            raise InputError(f"--figure: {path} has none of the columns of {first} to draw")
        for name, column in columns.items():
            if name != "time" and (path == first or name in values):
                values.setdefault(name, {})[labels[path]] = (time, column)
    if not values:
        raise InputError(f"--figure: {first} has no column but time to draw")
    return figures.runs(values, units, title=title, look=look)


def format_contents(data: Mapping[str, Any], what: Path) -> str:
    """Return the contents of a results folder, or of the table in one, as text for a terminal."""
    lines = []
    if data["summary"].get("measures"):
        try:
            lines += [report(data["summary"], what if what.is_dir() else what.parent), ""]
        except (KeyError, TypeError, AttributeError, ValueError):
            raise InputError(f"{what}: {DAMAGED}") from None
    lines += [f"warning: {warning}" for warning in data["summary"].get("warnings", ())]
    heading = ("column", "unit", "first", "last", "smallest", "largest")
    of_run = bool(data["summary"])  # of another table nothing is known, and it is told as it is
    rows = [(name, c["unit"], *_read_off(c, of_run)) for name, c in data["columns"].items()]
    lines += [counted(data["rows"], "row"), *aligned([heading, *rows])]
    return "\n".join([*lines, *data.get("files", ())])


def _read_off(column: Mapping[str, Any], of_run: bool) -> Iterator[str]:
    """Yield the first, last, smallest and largest value of a column; rounding errors of a run as 0."""
    size = max(abs(column["min"]), abs(column["max"])) if of_run else 0.0
    for key in ("first", "last", "min", "max"):
        yield f"{rounded(column[key], size):.6g}"


def difference(
    ours: Path,
    other: Path,
    tolerance: float,
    names: Sequence[str] = (),
    figure: FigureFile | None = None,
    *,
    common: bool = False,
) -> dict[str, Any]:
    """Return the differences of two results column by column, and what only one of them has.

    Parameters
    ----------
    ours, other : results folders, or single tables; the other may be a TOML file with a table [measured]
    tolerance : largest difference over the peak that counts as equal
    names : columns to compare; all if empty
    figure : picture of the columns that differ most
    common : whether to ignore rows, times and columns that only one of them has

    Raises
    ------
    InputError : if there are no results, nothing in common or no such column.
    """
    first = results_in(ours)
    second = results_in(other, first)
    for results, path in ((first, ours), (second, other)):
        _time(results, path, "a TOML file with a table [measured] can say which it is")
        _chosen(results, names, path)
    with blaming(f"{ours} and {other}"):
        found = compared(first.columns, second.columns, names or None)
    unshared = [] if common else found.unshared(str(ours), str(other))
    data: dict[str, Any] = {
        "ours": str(ours),
        "other": str(other),
        "tolerance": tolerance,
        "equal": not unshared and all(d.relative <= tolerance for d in found.differences),
        "compared": found.as_data(),
        "unshared": unshared,
        "differences": [{**asdict(d), "relative": d.relative} for d in found.differences],
        "measures": _side_by_side(first.summary, second.summary),
    }
    if figure is not None:
        drawn = {ours: first, other: second}
        worst = [d.name for d in found.differences[:_MOST_COMPARED]]
        data["files"] = figure.save(_picture(drawn, worst, None, first.units, figure.look))
    return data


def format_difference(data: Mapping[str, Any]) -> str:
    """Return the differences as text for a terminal."""
    heading = ("column", "largest difference", "relative to its peak", "at")
    rows = [
        (d["name"], f"{d['largest']:.3g}", f"{d['relative']:.3g}", f"{d['time']:.6g} s")
        for d in data["differences"]
    ]
    both = ("ours", "other")
    size = {
        one: sizes((name, m["unit"], m[one]) for name, m in data["measures"].items())
        for one in both
    }
    measured = [
        (name, *(quantity(m[one], m["unit"], size[one][name]) for one in both))
        for name, m in data["measures"].items()
    ]
    beside = (
        [*aligned([("measure", data["ours"], data["other"]), *measured]), ""] if measured else []
    )
    verdict = "equal" if data["equal"] else "different"
    lines = [
        *beside,
        *aligned([heading, *rows]),
        f"compared: {format_extent(data['compared'])}",
        *data["unshared"],
        verdict if data["unshared"] else f"{verdict} (tolerance {data['tolerance']:g})",
    ]
    return "\n".join([*lines, *data.get("files", ())])


def _side_by_side(ours: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return the measures that both runs have, with their units."""
    a, b = (dict(summary.get("measures") or {}) for summary in (ours, other))
    return {
        name: {"unit": a[name]["unit"], "ours": a[name]["value"], "other": b[name]["value"]}
        for name in a
        if name in b
    }


def first_difference(data: Mapping[str, Any]) -> str:
    """Return why two results are not equal, in one line."""
    if data["unshared"]:
        return f"{'; '.join(data['unshared'])}; --common compares only what both have"
    worst = data["differences"][0]
    if worst["largest"] == inf:
        return f"{worst['name']} is not a number in one of the two at {worst['time']:g} s"
    return (
        f"{data['ours']} and {data['other']} differ: {worst['name']} by {worst['relative']:.3g} of "
        f"its peak; allowed: {data['tolerance']:g}"
    )


def timed(
    results: Results, path: Path, names: Sequence[str], plane: tuple[str, str] | None
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return `time` and the chosen columns of results with their units; all columns if none is chosen.

    Raises
    ------
    InputError : as `contents`, and if there is no column `time`.
    """
    columns = {"time": _time(results, path, "a recording needs one")}
    columns |= _chosen(results, names, path) | (_chosen(results, plane, path) if plane else {})
    return columns, {name: results.units.get(name, "") for name in columns}


def _time(results: Results, path: Path, hint: str) -> Any:
    if "time" not in results.columns:
        raise InputError(f"{path}: no column time; {hint}")
    time = results.columns["time"]
    with blaming(path):
        check_ascending(time.astype(float))
    return time


def _chosen(results: Results, names: Sequence[str], path: Path) -> dict[str, Any]:
    for name in names:
        if name not in results.columns:
            raise InputError(f"{path}: no column {shown(name)}{nearest(name, results.columns)}")
    return {name: results.columns[name] for name in (names or results.columns)}
