"""Error against run time: every method of the project, and other integrators, on the same problems.

Error: the largest difference of any displacement from the truth over all instants, relative to the
largest displacement. Time: of one whole run called from Python, set-up and compilation outside, the
least of repeated runs that the solvers take in turn.
"""

from __future__ import annotations

import os
import platform
import re
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

from suspension import engine
from suspension.variables import MODELS

from ..errors import one_line
from . import own, peers
from .peers import Run, UnableError, Workbench, timed
from .problems import Problem
from .reference import largest_error, truth

Family = Literal["incremental", "FMU", "construction", "peer"]
Progress = Callable[[float], None]

LEVELS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)  # errors at which run times are compared
REPEATS = 7
_TOLERANCES = tuple(10.0**-k for k in range(2, 13))
_FRACTIONS = tuple(0.5**k for k in range(8))  # of the output interval, for fixed steps
_DRAWN_FRACTIONS = tuple(0.5**k for k in range(1, 4))
_NO_SOLUTION = 0.3  # an error of this part of the largest displacement is none
_EXACT = 3e-12  # an error as small as that of the truth; what is finer shows nothing more
_SLOW = 1.5  # s; after a run that took longer, the next finer one is not tried
_LONG_ENOUGH = 0.3  # s of repeated runs of one solver, after which it is not repeated further
_PACKAGES = {
    "numbalsoda": ("numba", "numbalsoda"), "cvode": ("sksundae",), "heyoka": ("heyoka",),
    "rk4": ("numba",),
}  # fmt: skip
_DISTRIBUTIONS = (
    "phaseplane", "numpy", "scipy", "fmpy", "numba", "numbalsoda", "scikit-sundae", "heyoka",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Solver:
    """One way to solve a problem, at several settings.

    Parameters
    ----------
    knob : what is varied
    values : tolerances, or steps as parts of the output interval; from coarse to fine
    prepare : sets a run up for one of them
    needs : packages that must be installed
    """

    name: str
    family: Family
    knob: Literal["tolerance", "step"]
    values: tuple[float, ...]
    prepare: Callable[[Workbench, float], Run]
    needs: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """Those that are not."""
        return tuple(name for name in self.needs if find_spec(name) is None)


@dataclass(frozen=True, slots=True)
class Point:
    """What one solver came to at one setting.

    Parameters
    ----------
    value : the tolerance, or the step in s
    error, seconds : None where there is none
    failure : why not, or empty
    """

    problem: str
    solver: str
    family: Family
    knob: str
    value: float
    error: float | None
    seconds: float | None
    failure: str = ""


def solvers(*, with_peers: bool) -> tuple[Solver, ...]:
    """All solvers that are compared."""
    return (*_own(), *(_peers() if with_peers else ()))


def _own() -> Iterator[Solver]:
    from ..schema import RULES  # noqa: PLC0415

    def tolerant(method: str) -> Callable[[Workbench, float], Run]:
        return lambda bench, value: own.in_process(bench, method=method, tolerance=value)

    def stepping(method: str, **options: Any) -> Callable[[Workbench, float], Run]:
        return lambda bench, value: own.in_process(bench, method=method, step=value, **options)

    yield Solver("extrapolated", "incremental", "tolerance", _TOLERANCES, tolerant("extrapolated"))
    methods = next(v.choices for v in MODELS["QuarterCar"] if v.name == "solver.method")
    for order in (4, 6, 8):
        name = f"extrapolated, order {order}"
        prepare = stepping("extrapolated", order=order)
        yield Solver(name, "incremental", "step", _FRACTIONS, prepare)
    for method in methods:
        if method != "extrapolated":
            yield Solver(method, "incremental", "step", _FRACTIONS, stepping(method))
    yield Solver("extrapolated", "FMU", "tolerance", _TOLERANCES[::2], own.through_fmu)
    for rule in RULES:
        prepare = partial(own.drawn, rule)
        yield Solver(rule.replace("_", " "), "construction", "step", _DRAWN_FRACTIONS, prepare)


def _peers() -> Iterator[Solver]:
    makers: list[tuple[str, Callable[[Workbench, float], Run]]] = [
        *(
            (f"scipy {m}", partial(peers.scipy_method, m))
            for m in ("RK45", "DOP853", "LSODA", "Radau")
        ),
        *((f"numbalsoda {m}", partial(peers.numbalsoda, m)) for m in ("dop853", "lsoda")),
        *((f"cvode {m}", partial(peers.cvode, m)) for m in ("Adams", "BDF")),
        ("heyoka", peers.heyoka),
    ]
    for name, prepare in makers:
        needs = _PACKAGES.get(name.split()[0], ())
        yield Solver(name, "peer", "tolerance", _TOLERANCES, prepare, needs)
    yield Solver("rk4, numba", "peer", "step", _FRACTIONS, peers.runge_kutta, _PACKAGES["rk4"])


# -- measuring -----------------------------------------------------------------------------------


@dataclass(slots=True)
class _Timed:
    """A run that works, its error, and its least time so far."""

    point: Callable[[float], Point]
    run: Run
    seconds: float
    spent: float

    def again(self) -> None:
        _, took = timed(self.run)
        self.seconds, self.spent = min(self.seconds, took), self.spent + took


def measure(
    problem: Problem,
    compared: Sequence[Solver],
    repeats: int = REPEATS,
    progress: Progress | None = None,
) -> list[Point]:
    """Put every solver to one problem.

    Parameters
    ----------
    repeats : how often each run is timed
    progress : called with the part done, 0 to 1

    Returns
    -------
    A point for each setting, but for those finer than an error of rounding; settings finer than one
    that was too slow are failures.
    """
    bench = Workbench(problem, truth(problem))
    points: list[Point] = []
    timed: list[_Timed] = []
    for k, solver in enumerate(compared):
        for found in _tried(bench, solver):
            (timed if isinstance(found, _Timed) else points).append(found)  # type: ignore[arg-type]
        if progress is not None:
            progress(0.7 * (k + 1) / len(compared))
    for k in range(repeats):
        for one in timed:
            if one.spent < _LONG_ENOUGH:
                one.again()
        if progress is not None:
            progress(0.7 + 0.3 * (k + 1) / repeats)
    points += [one.point(one.seconds) for one in timed]
    order = {(solver.name, solver.family): k for k, solver in enumerate(compared)}
    return sorted(points, key=lambda p: (order[p.solver, p.family], -p.value))


def _tried(bench: Workbench, solver: Solver) -> Iterator[_Timed | Point]:
    """Each setting run for its error, coarse to fine, until one is too slow or cannot be."""
    problem = bench.problem
    interval = problem.duration / problem.intervals
    stop = ""
    if solver.missing:
        stop = f"not installed: {', '.join(solver.missing)}"
    for part in solver.values:
        value = part * interval if solver.knob == "step" else part
        point = partial(Point, problem.name, solver.name, solver.family, solver.knob, value)
        started = perf_counter()
        if stop:
            yield point(None, None, stop)
            continue
        try:
            run = solver.prepare(bench, value)
            found, seconds = _run(run, again=solver.family == "peer")
        except UnableError as error:
            stop = one_line(error)
            yield point(None, None, stop)
            continue
        except Exception as error:  # whatever a solver does when it fails is a result
            took = perf_counter() - started
            yield point(None, took, one_line(error) or type(error).__name__)
            continue
        error_found = largest_error(found, bench.true)
        if not error_found < _NO_SOLUTION:
            yield point(None, seconds, f"no solution: wrong by {error_found:.2g} of the peak")
            continue
        if error_found < _EXACT:
            yield _Timed(partial(point, error_found), run, seconds, seconds)
            return
        if seconds > _SLOW:
            stop = f"not tried: a coarser run took {seconds:.1f} s"
        yield _Timed(partial(point, error_found), run, seconds, seconds)


def _run(run: Run, *, again: bool) -> tuple[Any, float]:
    """The result and its time; of a second run if the first may have compiled something."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # solvers warn of what shows in their error
        if again:
            run()
        return timed(run)


# -- what is said --------------------------------------------------------------------------------


def machine() -> dict[str, Any]:
    """What it ran on."""
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


def versions() -> dict[str, str]:
    """Python and the packages that count."""
    found = {"python": platform.python_version()}
    for name in _DISTRIBUTIONS:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def as_data(problems: Sequence[Problem], points: Sequence[Point], repeats: int) -> dict[str, Any]:
    """The whole study as plain data."""
    return {
        "study": "error against run time",
        "machine": machine(),
        "versions": versions(),
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
    """The shortest run time among those whose error is at most `level`, s."""
    times = [
        point.seconds
        for point in points
        if point.error is not None and point.seconds is not None and point.error <= level
    ]
    return min(times, default=None)


def table(problem: Problem, points: Sequence[Point]) -> str:
    """Microseconds to reach each error level, a line for each solver; then what failed."""
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
    """Each kind of failure once, with those that failed so; a whole family by its name."""
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
        yield f"failed: {', '.join(who)}: {kind}"


# where it happened, and by how much
_NUMBERS = re.compile(r"( (at|after) [-+.e0-9]+ s\b.*|: wrong by .*)$")
_FAMILIES = ("incremental", "FMU", "construction", "peer")


def panels(problems: Sequence[Problem], points: Sequence[Point]) -> list[tuple[str, list[Any]]]:
    """What `phaseplane.figures.work_precision` draws: for each problem a title and its curves."""
    from phaseplane.figures.work_precision import Curve  # noqa: PLC0415  (imports matplotlib)

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
                    Curve(
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
