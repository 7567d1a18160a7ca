"""Error against run time as plain data, as tables, and as the curves of a picture."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, get_args

from phaseplane.suspension import engine

from phaseplane import figures

from ..simulate.versions import versions
from .accuracy import Family, Point
from .problems import Problem

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)  # errors at which run times are compared
_FAMILIES: tuple[Family, ...] = get_args(Family)
# the numbers in a failure's text: its time, or the size of the error
_NUMBERS = re.compile(r"( (at|after) [-+.e0-9]+ s\b.*|: error of .*)$")


def machine() -> dict[str, Any]:
    """Return the machine of the study."""
    name = platform.processor()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next(
            line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")
        )
    except (OSError, StopIteration):
        pass
    return {
        "processor": name or platform.machine(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "compiled": engine.compiled,
    }


def compared_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages compared."""
    return versions("scipy", "numba", "numbalsoda", "scikit-sundae", "heyoka")


def as_data(problems: Sequence[Problem], points: Sequence[Point], repeats: int) -> dict[str, Any]:
    """Return the whole study as plain data."""
    return {
        "study": "error against run time",
        "machine": machine(),
        "versions": compared_versions(),
        "repeats": repeats,
        "problems": [
            {
                "name": p.name,
                "title": p.title,
                "kind": p.kind,
                "degrees_of_freedom": len(p.system.mass),
                "duration": p.duration,
                "instants": p.intervals + 1,
            }
            for p in problems
        ],
        "points": [asdict(point) for point in points],
    }


def time_to_reach(points: Sequence[Point], level: float) -> float | None:
    """Return the shortest run time with an error of at most `level`, s, or None."""
    times = [
        point.seconds
        for point in points
        if point.error is not None and point.seconds is not None and point.error <= level
    ]
    return min(times, default=None)


def table(problem: Problem, points: Sequence[Point]) -> str:
    """Return the microseconds to reach each error level, one line per solver, then the failures."""
    lines = [f"{problem.name}: {problem.title} ({problem.kind})", ""]
    heads = "".join(f"{f'{level:.0e}':>9}" for level in LEVELS)
    lines.append(f"{'us to an error of':<34}{heads}")
    solvers = _by_solver(problem, points)
    for solver, reached in solvers.items():
        if any(p.error is not None for p in reached):
            times = (time_to_reach(reached, level) for level in LEVELS)
            cells = ("-" if s is None else f"{1e6 * s:.0f}" for s in times)
            lines.append(f"{_label(*solver):<34}{''.join(f'{c:>9}' for c in cells)}")
    return "\n".join([*lines, *_failures(solvers)])


def _by_solver(problem: Problem, points: Sequence[Point]) -> dict[tuple[str, Family], list[Point]]:
    """Return the points of a problem by solver, those of the same family one after the other."""
    found: dict[tuple[str, Family], list[Point]] = {}
    for point in sorted(points, key=lambda p: _FAMILIES.index(p.family)):
        if point.problem == problem.name:
            found.setdefault((point.solver, point.family), []).append(point)
    return found


def _label(solver: str, family: Family) -> str:
    return solver if family in ("incremental", "peer") else f"{family}: {solver}"


def _failures(solvers: Mapping[tuple[str, Family], Sequence[Point]]) -> Iterator[str]:
    """Yield each kind of failure once, with its solvers; a whole family is named as such."""
    kinds = {
        solver: [_NUMBERS.sub("", point.failure) for point in runs]
        for solver, runs in solvers.items()
    }
    for kind in dict.fromkeys(kind for found in kinds.values() for kind in found if kind):
        who = []
        for family in _FAMILIES:
            members = [solver for solver in solvers if solver[1] == family]
            counts = {solver: kinds[solver].count(kind) for solver in members}
            if len(members) > 1 and all(counts[s] == len(solvers[s]) for s in members):
                who.append(f"all {family}s")
                continue
            for solver, count in counts.items():
                whole = count == len(solvers[solver])
                part = "" if whole else f" ({count} of {len(solvers[solver])} runs)"
                who += [f"{_label(*solver)}{part}"] if count else []
        yield f"no result: {', '.join(who)}: {kind}"


def panels(problems: Sequence[Problem], points: Sequence[Point]) -> list[tuple[str, list[Any]]]:
    """Return the input of `phaseplane.figures.work_precision`: title and curves of each problem.

    Solvers that did not run, such as those that are not installed, have no curve.
    """
    ran = [point for point in points if point.seconds is not None]
    return [
        (
            f"{problem.name.replace('_', ' ')} ({problem.kind})",
            [_curve(*of, runs) for of, runs in _by_solver(problem, ran).items()],
        )
        for problem in problems
    ]


def _curve(solver: str, family: Family, runs: Sequence[Point]) -> figures.Curve:
    """Return the curve of a solver: error and time of its results, and the times of its failures."""
    took = [(p.error, p.seconds) for p in runs if p.seconds is not None]
    return figures.Curve(
        solver,
        family,
        tuple((error, seconds) for error, seconds in took if error is not None),
        tuple(seconds for error, seconds in took if error is None),
    )
