"""Error against run time: every method of this package, and other integrators, on the same problems.

Error: the largest difference of any displacement from the reference solution over all times, relative to
the largest displacement. Run time: that of one whole run called from Python, without set-up and
compilation; the shortest of repeated runs, in which the solvers take turns.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from time import perf_counter
from typing import Any, Literal

from phaseplane.suspension.variables import METHODS

from ..errors import one_line
from ..progress import Progress, silent
from ..scene.sections import RULES
from . import peers, project_solvers
from .problems import Problem
from .reference import largest_error, truth
from .workbench import Run, UnableError, Workbench, silenced, timed

Family = Literal["incremental", "FMU", "construction", "peer"]
Knob = Literal["tolerance", "step"]

REPEATS = 7
_TOLERANCES = tuple(10.0**-k for k in range(1, 13))
_FRACTIONS = tuple(0.5**k for k in range(8))  # of the output interval, for fixed steps
_DRAWN_FRACTIONS = tuple(0.5**k for k in range(1, 4))
_NO_SOLUTION = 0.3  # relative error from which a result does not count as a solution
_EXACT = 3e-12  # relative error of the reference solution; finer settings reveal nothing more
_SLOW = 1.5  # s; after a longer run no finer setting is tried
_LONG_ENOUGH = 0.3  # s of repeated runs of one setting, after which it is not repeated further
_PACKAGES = {
    "numbalsoda": ("numba", "numbalsoda"), "cvode": ("sksundae",), "heyoka": ("heyoka",),
    "rk4": ("numba",),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Solver:
    """One way to solve a problem, at several settings.

    Parameters
    ----------
    knob : the setting that is varied
    values : tolerances, or steps as fractions of the output interval; from coarse to fine
    prepare : sets up a run for one value
    needs : packages that must be installed
    """

    name: str
    family: Family
    knob: Knob
    values: tuple[float, ...]
    prepare: Callable[[Workbench, float], Run]
    needs: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The packages that are not installed."""
        return tuple(name for name in self.needs if find_spec(name) is None)


@dataclass(frozen=True, slots=True)
class Point:
    """The result of one solver at one setting.

    Parameters
    ----------
    value : the tolerance, or the step in s
    error, seconds : None if there is no result
    failure : why there is none, or empty
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
    """Return all solvers to compare."""
    return (*_project(), *(_peers() if with_peers else ()))


def _project() -> Iterator[Solver]:
    def incremental(name: str, knob: Knob, values: tuple[float, ...], **options: Any) -> Solver:
        return Solver(
            name, "incremental", knob, values,
            lambda bench, value: project_solvers.in_process(bench, **options, **{knob: value}),
        )  # fmt: skip

    yield incremental("extrapolated", "tolerance", _TOLERANCES)
    for order in (4, 6, 8):
        yield incremental(f"extrapolated, order {order}", "step", _FRACTIONS, order=order)
    for method in METHODS:
        if method != "extrapolated":
            yield incremental(method, "step", _FRACTIONS, method=method)
    yield Solver("extrapolated", "FMU", "tolerance", _TOLERANCES[::2], project_solvers.through_fmu)
    for rule in RULES:
        prepare = partial(project_solvers.drawn, rule)
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
    """A successful run, its error, and its shortest time so far."""

    point: Callable[[float], Point]
    run: Run
    seconds: float
    spent: float

    def again(self) -> None:
        """Repeat the run twice; the first repetition refills the processor's caches."""
        for _ in range(2):
            _, took = timed(self.run)
            self.seconds, self.spent = min(self.seconds, took), self.spent + took


def measure(
    problem: Problem,
    compared: Sequence[Solver],
    repeats: int = REPEATS,
    progress: Progress = silent,
) -> list[Point]:
    """Run every solver on one problem.

    Parameters
    ----------
    repeats : number of timings of each run
    progress : called with the fraction done, 0 to 1

    Returns
    -------
    A point for each setting, up to the first at rounding error; settings finer than one that was too
    slow are failures.
    """
    bench = Workbench(problem, truth(problem))
    points: list[Point] = []
    timed: list[_Timed] = []
    with silenced() if any(s.family == "peer" for s in compared) else nullcontext():
        for k, solver in enumerate(compared):
            for found in _tried(bench, solver):
                (timed if isinstance(found, _Timed) else points).append(found)  # type: ignore[arg-type]
            progress(0.7 * (k + 1) / len(compared))
        for k in range(repeats):
            for one in timed:
                if one.spent < _LONG_ENOUGH:
                    one.again()
            progress(0.7 + 0.3 * (k + 1) / repeats)
    points += [one.point(one.seconds) for one in timed]
    order = {(solver.name, solver.family): k for k, solver in enumerate(compared)}
    return sorted(points, key=lambda p: (order[p.solver, p.family], -p.value))


def _tried(bench: Workbench, solver: Solver) -> Iterator[_Timed | Point]:
    """Find the error of each setting, from coarse to fine, until one is too slow or not possible."""
    problem = bench.problem
    interval = problem.duration / problem.intervals
    stop = f"not installed: {', '.join(solver.missing)}" if solver.missing else ""
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
        except Exception as error:  # any failure of a solver is a result
            took = perf_counter() - started
            yield point(None, took, one_line(error) or type(error).__name__)
            continue
        error_found = largest_error(found, bench.true)
        if not error_found < _NO_SOLUTION:
            yield point(None, seconds, f"no solution: error of {error_found:.2g} of the peak")
            continue
        yield _Timed(partial(point, error_found), run, seconds, seconds)
        if error_found < _EXACT:
            return
        if seconds > _SLOW:
            stop = f"not tried: a coarser run took {seconds:.1f} s"


def _run(run: Run, *, again: bool) -> tuple[Any, float]:
    """Return the result and its time; those of a second run if the first may have compiled something."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # solvers warn of inaccuracy, which is measured here
        if again:
            run()
        return timed(run)
