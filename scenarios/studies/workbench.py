"""The data of a problem that solvers need, computed once, and the timing of a run."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from time import perf_counter
from typing import Any

import numpy as np

from .branches import Branches
from .equations import Equations, Vector
from .problems import Problem
from .reference import Margin, Rates, plain, until

Run = Callable[[], "Vector"]
"""One whole run: returns the displacements at the output times, (len(times), n), m."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """A run whose solver is reset first, outside the timing."""

    reset: Callable[[], object]
    go: Run

    def __call__(self) -> Vector:
        self.reset()
        return self.go()


def timed(run: Callable[[], object], clock: Callable[[], float] | None = None) -> tuple[Any, float]:
    """Return the result of a run and its time by a clock, s; elapsed time if no clock is given."""
    clock = clock or perf_counter
    if isinstance(run, Prepared):
        run.reset()
        run = run.go
    started = clock()
    found = run()
    return found, clock() - started


@contextmanager
def silenced() -> Iterator[None]:
    """Discard what compiled libraries print, as the output may be JSON."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        with suppress(OSError, TypeError):  # the process has no C library to flush
            ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


class UnableError(Exception):
    """A solver cannot solve a problem; the message says why."""


@dataclass(frozen=True, slots=True)
class Segmented:
    """A run up to a joint of the road: its p, its times with both ends, its number of outputs."""

    end: float
    p: Vector
    instants: Vector
    wanted: int


class Workbench:
    """The compiled equations of a problem and the scales of its motion, computed once.

    Parameters
    ----------
    problem : the problem to solve
    true : true displacements at its output times, (len(times), n), m
    """

    def __init__(self, problem: Problem, true: Vector) -> None:
        self.problem = problem
        self.true = true
        self.equations = Equations(problem.system)

    @cached_property
    def scale(self) -> Vector:
        """Largest displacement and largest velocity, for each coordinate's two tolerances."""
        rates = np.gradient(self.true, self.problem.times, axis=0)
        n = self.equations.n
        largest = [np.abs(self.true).max(), np.abs(rates).max()]
        return np.repeat(largest, n)

    @cached_property
    def branches(self) -> Branches:
        """The branches at the start."""
        guards = self.compiled["guards"] if self.compiled else None
        return Branches(self.equations, 0.0, self.problem.start, guards)

    @cached_property
    def compiled(self) -> dict[str, Any]:
        """`rhs` and `guards` by numba, and `choosing` if no element has memory; {} without numba."""
        if find_spec("numba") is None:
            return {}
        from numba import njit  # noqa: PLC0415  (heavy, optional)

        made = {name: njit(f) for name, f in self.equations.functions().items()}
        if not self.equations.memory:
            made["choosing"] = njit(self.equations.functions(choosing=True)["rhs"])
        return made

    @cached_property
    def returning(self) -> tuple[Rates, Margin | None]:
        """Right-hand side and smallest guard as functions that return their result."""
        if not self.compiled:
            return plain(self.equations)
        from numba import njit  # noqa: PLC0415  (heavy, optional)

        fill, fill_guards = self.compiled["rhs"], self.compiled["guards"]
        size, guards = 2 * self.equations.n, len(self.equations.guards)

        @njit
        def rhs(t: float, y: Vector, p: Vector) -> Vector:
            dy = np.empty(size)
            fill(t, y, dy, p)
            return dy

        @njit
        def margin(t: float, y: Vector, p: Vector) -> float:
            g = np.empty(guards)
            fill_guards(t, y, g, p)
            return g.min()

        return rhs, margin if guards else None

    def choosing(self) -> Any:
        """Return the compiled right-hand side that chooses its branches from the state.

        Raises
        ------
        UnableError : if an element has memory.
        """
        if self.equations.memory:
            raise UnableError(f"cannot locate switches ({self.equations.memory})")
        return self.compiled["choosing"]

    def stretches(self) -> list[Segmented]:
        """Return the run, split at the joints of the road."""
        times, y, t, k = self.problem.times, self.problem.start, 0.0, 1
        branches = self.branches.copy()
        found = []
        while k < len(times):
            end = min(branches.next_joint(t), times[-1])
            wanted = until(times[k:], end)
            ends = [] if len(wanted) and wanted[-1] == end else [end]
            found.append(
                Segmented(end, branches.p.copy(), np.array([t, *wanted, *ends]), len(wanted))
            )
            branches.pass_joint(end, y.copy())
            t, k = end, k + len(wanted)
        return found
