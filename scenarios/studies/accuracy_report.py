"""Error against run time as plain data, as tables, and as the curves of a picture."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from phaseplane.suspension import engine

from phaseplane import figures

from ..simulate.versions import versions
from .accuracy import Point
from .problems import Problem

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)  # errors at which run times are compared
_FAMILIES = ("incremental", "FMU", "construction", "peer")
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
    mine = [point for point in points if point.problem == problem.name]
    for family in _FAMILIES:
        for solver in dict.fromkeys(p.solver for p in mine if p.family == family):
            reached = [p for p in mine if (p.solver, p.family) == (solver, family)]
            if any(p.error is not None for p in reached):
                times = (time_to_reach(reached, level) for level in LEVELS)
                cells = ("-" if s is None else f"{1e6 * s:.0f}" for s in times)
                lines.append(f"{_label(solver, family):<34}{''.join(f'{c:>9}' for c in cells)}")
    return "\n".join([*lines, *_failures(mine)])


def _label(solver: str, family: str) -> str:
    return solver if family in ("incremental", "peer") else f"{family}: {solver}"


def _failures(points: Sequence[Point]) -> Iterator[str]:
    """Yield each kind of failure once, with its solvers; a whole family is named as such."""
    kinds = {point: _NUMBERS.sub("", point.failure) for point in points if point.failure}
    for kind in dict.fromkeys(kinds.values()):
        who = []
        for family in _FAMILIES:
            members = dict.fromkeys(p.solver for p in points if p.family == family)
            counts = {}
            for solver in members:
                runs = [p for p in points if (p.solver, p.family) == (solver, family)]
                failed = [p for p in runs if kinds.get(p) == kind]
                if failed:
                    whole = len(failed) == len(runs)
                    counts[solver] = "" if whole else f" ({len(failed)} of {len(runs)} runs)"
            if len(members) > 1 and len(counts) == len(members) and not any(counts.values()):
                who.append(f"all {family}s")
            else:
                who += [f"{_label(solver, family)}{count}" for solver, count in counts.items()]
        yield f"no result: {', '.join(who)}: {kind}"


def panels(problems: Sequence[Problem], points: Sequence[Point]) -> list[tuple[str, list[Any]]]:
    """Return the input of `phaseplane.figures.work_precision`: title and curves of each problem."""
    drawn = []
    for problem in problems:
        curves: dict[tuple[str, str], list[Point]] = {}
        for point in points:
            if point.problem == problem.name and point.seconds is not None:
                curves.setdefault((point.solver, point.family), []).append(point)
        drawn.append(
            (
                f"{problem.name.replace('_', ' ')} ({problem.kind})",
                [
                    figures.Curve(
                        solver,
                        family,
                        tuple(
                            (p.error, p.seconds)
                            for p in mine
                            if p.error is not None and p.seconds is not None
                        ),
                        tuple(p.seconds for p in mine if p.error is None and p.seconds is not None),
                    )
                    for (solver, family), mine in curves.items()
                ],
            )
        )
    return drawn
