"""Motions whose equations switch: DOP853 from switch to switch, each located.

A problem keeps its branch until the room it has left there falls below zero, which is looked for at
eight instants of every step; the switch is located on the dense output, and the next run starts there.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

Array = NDArray[np.float64]

LONGEST = 2.5e-4  # s: so short a step that the dense output is as good as the steps
ENDLESS = 50  # switches in which no time passes


class NoTruthError(Exception):
    """No solution within reach; the message says why."""


class Leg(NamedTuple):
    """A part of a motion: its end, the state there, the states at the instants asked for, and the exit
    by which it ends, or -1.
    """

    end: float
    state: Array
    rows: Array
    left: int


class Switch(NamedTuple):
    """An element changes branch: instant in s, name of the element, branch entered."""

    time: float
    element: str
    branch: str


class Branch(Protocol):
    """Equations of motion up to the next switch."""

    def derivative(self, t: float, state: Array) -> Sequence[float]:
        """Rates of the state in the present branch."""

    def rooms(self, t: Array, states: Array) -> list[Array]:
        """What is left until each switch of the present branch, at some instants: >= 0 inside."""


class Problem(Branch, Protocol):
    """Equations of motion that switch."""

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
    NoTruthError : switches follow each other without end.
    """
    now, switches = np.array(state, dtype=float), []
    rows, rates = [now], []
    inside = sorted({t for t in joints if times[0] < t < times[-1]})
    for start, end in pairwise([times[0], *inside, times[-1]]):
        problem.stretch(start, end)
        if not rates:
            rates.append(problem.derivative(start, now))
        t = start
        while t < end:
            wanted = times[len(rows) : int(times.searchsorted(end, side="right"))]
            leg = advance(problem, t, now, end, wanted)
            rows += [*leg.rows]
            rates += [
                problem.derivative(at, row) for at, row in zip(wanted, leg.rows, strict=False)
            ]
            t, now = leg.end, leg.state
            if leg.left >= 0:
                switches.append(Switch(t, *problem.enter(leg.left, t, now)))
            if len(switches) > ENDLESS and switches[-ENDLESS].time == t:
                raise NoTruthError(f"switches follow one another without end at {t} s")
    return np.array(rows), np.array(rates), switches


def advance(
    problem: Branch,
    t: float,
    state: Array,
    end: float,
    wanted: Array,
    *,
    longest: float = LONGEST,
    tolerance: float = 1e-12,
    most_steps: float = inf,
) -> Leg:
    """On to the end of the branch, with the states at the instants wanted up to there."""
    solver = DOP853(problem.derivative, t, state, end, max_step=longest, rtol=tolerance, atol=1e-15)
    rows: list[Array] = []
    steps = 0
    while solver.status == "running":
        steps += 1
        with np.errstate(all="ignore"):  # of what runs away
            message = solver.step()
        if not np.isfinite(solver.y).all():
            raise NoTruthError(f"the motion runs away at {solver.t:.6g} s")
        if solver.status == "failed" or steps > most_steps:
            raise NoTruthError(f"DOP853 stopped at {solver.t:.6g} s: {message or 'too stiff'}")
        dense = solver.dense_output()
        upto, left = _first_exit(problem, dense, solver.t_old, solver.t)
        while len(rows) < len(wanted) and wanted[len(rows)] <= upto:
            rows.append(dense(wanted[len(rows)]))
        if left >= 0:
            return Leg(upto, dense(upto), np.reshape(rows, (-1, len(state))), left)
    return Leg(end, solver.y, np.reshape(rows, (-1, len(state))), -1)


def _first_exit(problem: Branch, dense: DOP853, start: float, end: float) -> tuple[float, int]:
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
