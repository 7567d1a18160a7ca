"""Motions whose equations switch: DOP853 from switch to switch, each located.

A problem keeps its branch until the room it has left there falls below zero, which is looked for at
eight instants of every step; the switch is located on the dense output, and the next run starts there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

Array = NDArray[np.float64]

LONGEST = 2.5e-4  # s: so short a step that the dense output is as good as the steps
ENDLESS = 50  # switches in which no time passes


class Switch(NamedTuple):
    """An element changes branch: instant in s, name of the element, branch entered."""

    time: float
    element: str
    branch: str


class Problem(Protocol):
    """Equations of motion that switch."""

    def derivative(self, t: float, state: Array) -> Sequence[float]:
        """Rates of the state in the present branch."""

    def rooms(self, t: Array, states: Array) -> list[Array]:
        """What is left until each switch of the present branch, at some instants: >= 0 inside."""

    def enter(self, exit_: int, t: float, state: Array) -> tuple[str, str]:
        """Go over to the branch behind that exit; names of the element and of its new branch."""

    def stretch(self, start: float, end: float) -> None:
        """From now on the excitation is that between these two joints."""


def integrate(
    problem: Problem, state: Sequence[float], times: Array, joints: Sequence[float]
) -> tuple[Array, Array, list[Switch]]:
    """States at the given instants and their rates, (len(times), len(state)), and every switch.

    Parameters
    ----------
    state : at the first instant
    times : ascending, s
    joints : instants at which the excitation changes its law, s

    Raises
    ------
    RuntimeError : switches follow each other without end.
    """
    rows, switches = np.empty((2, len(times), len(state))), []
    now = np.array(state, dtype=float)
    inside = sorted({t for t in joints if times[0] < t < times[-1]})
    for start, end in pairwise([times[0], *inside, times[-1]]):
        problem.stretch(start, end)
        t = start
        while t < end:
            t, now, left = _branch(problem, t, now, end, times, rows)
            if left >= 0:
                switches.append(Switch(t, *problem.enter(left, t, now)))
            if len(switches) > ENDLESS and switches[-ENDLESS].time == t:
                raise RuntimeError(f"switches follow one another without end at {t} s")
    rows[:, -1] = now, problem.derivative(end, now)
    return *rows, switches


def _branch(
    problem: Problem, t: float, state: Array, end: float, times: Array, rows: Array
) -> tuple[float, Array, int]:
    """On to the end of the branch: instant, state, and the exit taken, or -1 at `end`."""
    solver = DOP853(problem.derivative, t, state, end, max_step=LONGEST, rtol=1e-12, atol=1e-15)
    while solver.status == "running":
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"DOP853 stopped at {solver.t} s: {message}")
        dense = solver.dense_output()
        upto, left = _first_exit(problem, dense, solver.t_old, solver.t)
        first, last = np.searchsorted(times, [solver.t_old, upto])
        for k in range(first, last):
            there = dense(times[k])
            rows[:, k] = there, problem.derivative(times[k], there)
        if left >= 0:
            return upto, dense(upto), left
    return solver.t, solver.y, -1


def _first_exit(problem: Problem, dense: DOP853, start: float, end: float) -> tuple[float, int]:
    """The first instant in a step at which a room is used up, and which; else its end, and -1."""
    instants = np.linspace(start, end, 9)
    rooms = problem.rooms(instants, dense(instants))
    best, left = end, -1
    for k, room in enumerate(rooms):
        outside = np.flatnonzero(room[1:] < 0.0)
        if not len(outside) or instants[outside[0]] > best:
            continue
        low, high = instants[outside[0]], instants[outside[0] + 1]

        def at(t: float, k: int = k) -> float:
            return float(problem.rooms(np.array([t]), dense(np.array([t])))[k][0])

        t = low if at(low) <= 0.0 else brentq(at, low, high, xtol=1e-16, rtol=1e-15)
        if left < 0 or t < best:
            best, left = t, k
    return best, left
