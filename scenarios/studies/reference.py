"""The reference solution that errors are measured from: scipy's DOP853, restarted at every switch."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .branches import Branches
from .equations import Equations, Vector
from .problems import Problem

_TOLERANCE = 1e-13
_SAME = 1e-12  # s; times that differ by less are the same, as 0.05 and 20 times 0.0025
_LONGEST = 1e-3  # s; the longest step, so that no step has two switches
_CHATTERS = 100, 3e-5  # so many switches within this part of the duration


@dataclass(frozen=True, slots=True)
class Stretch:
    """A run between two switches or joints.

    Parameters
    ----------
    time, state : time and state at its end
    rows : states at the output times up to its end, (k, 2n)
    switched : whether a guard ended it
    """

    time: float
    state: Vector
    rows: Vector
    switched: bool


Rates = Callable[[float, "Vector", "Vector"], "Vector"]
"""y' at (t, y, p)."""

Margin = Callable[[float, "Vector", "Vector"], float]
"""The smallest guard at (t, y, p), whose zero ends a stretch."""

Advance = Callable[[float, float, "Vector", "Vector", "Vector"], Stretch]
"""Advances from t to t_end or the first switch: (t, t_end, state y, numbers p, output times)."""


def drive(problem: Problem, start: Branches, advance: Advance) -> Vector:
    """Return the displacements of a problem, found by a solver that locates the switches.

    Parameters
    ----------
    start : the branches at the start; not changed

    Returns
    -------
    Displacements, m, shape (len(times), n).

    Raises
    ------
    ArithmeticError : if the solver makes no progress, or chatters: an inaccurate one may end each step
        on the wrong side of its switch.
    """
    times, n = problem.times, len(problem.system.mass)
    most, part = _CHATTERS
    switches: deque[float] = deque(maxlen=most)
    t, y = 0.0, problem.start
    branches = start.copy()
    out = np.empty((len(times), n))
    out[0] = y[:n]
    k = 1
    while k < len(times):
        if times[k] - t < _SAME:  # a switch at this output time
            out[k] = y[:n]
            k += 1
            continue
        joint = branches.next_joint(t)
        end = min(joint, times[-1])
        stretch = advance(t, end, y, branches.p, until(times[k:], end))
        if not (np.isfinite(stretch.state).all() and stretch.time >= t):
            raise ArithmeticError(f"no progress from {t:.9g} s on")
        out[k : k + len(stretch.rows)] = stretch.rows[:, :n]
        k += len(stretch.rows)
        t, y = stretch.time, stretch.state.copy()
        if stretch.switched:
            switches.append(t)
            if len(switches) == most and t - switches[0] < part * problem.duration:
                raise ArithmeticError(
                    f"chatters: {most} switches from {switches[0]:.6g} to {t:.6g} s"
                )
            branches.leave(t, y)
        elif t == joint:
            branches.pass_joint(t, y)
    return out


def until(times: Vector, end: float) -> Vector:
    """Return the times up to the end; a time that differs from the end by rounding becomes the end."""
    wanted = times[: int(times.searchsorted(end + _SAME))].copy()
    if len(wanted) and wanted[-1] > end - _SAME:
        wanted[-1] = end
    return wanted


def by_scipy(rhs: Rates, margin: Margin | None, method: str, **options: Any) -> Advance:
    """Return a function that advances by `scipy.integrate.solve_ivp`.

    Parameters
    ----------
    margin : None if there are no guards
    """
    from scipy.integrate import solve_ivp  # noqa: PLC0415  (heavy)

    def advance(t: float, end: float, y: Vector, p: Vector, wanted: Vector) -> Stretch:
        events: list[Any] = []
        if margin is not None:

            def event(t: float, y: Vector) -> float:
                return margin(t, y, p)

            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
            events = [event]
        # the end is an output too, to continue from there
        at_end = len(wanted) > 0 and wanted[-1] == end
        instants = wanted if at_end else np.append(wanted, end)
        run = solve_ivp(
            lambda t, y: rhs(t, y, p),
            (t, end),
            y,
            method,
            t_eval=instants,
            events=events,
            **options,
        )
        if run.status < 0:
            raise ArithmeticError(run.message)
        rows = np.reshape(run.y, (len(y), -1)).T
        if run.status == 1:
            return Stretch(float(run.t_events[0][-1]), run.y_events[0][-1], rows, True)
        return Stretch(end, rows[-1], rows[: len(wanted)], False)

    return advance


def plain(equations: Equations) -> tuple[Rates, Margin | None]:
    """Return the right-hand side and the smallest guard in plain Python."""
    functions = equations.functions()
    size, guards = 2 * equations.n, len(equations.guards)

    def rhs(t: float, y: Vector, p: Vector) -> Vector:
        dy = [0.0] * size
        functions["rhs"](t, y.tolist(), dy, p.tolist())
        return np.array(dy)

    def margin(t: float, y: Vector, p: Vector) -> float:
        g = [0.0] * guards
        functions["guards"](t, y.tolist(), g, p.tolist())
        return min(g)

    return rhs, margin if guards else None


def truth(problem: Problem, method: str = "DOP853") -> Vector:
    """Return the displacements of a problem to about twelve digits, (len(times), n), m."""
    equations = Equations(problem.system)
    rhs, margin = plain(equations)
    advance = by_scipy(
        rhs, margin, method, rtol=_TOLERANCE, atol=1e-2 * _TOLERANCE, max_step=_LONGEST
    )
    return drive(problem, Branches(equations, 0.0, problem.start), advance)


def largest_error(found: Vector, true: Vector) -> float:
    """Return the largest difference of all displacements and times, over the largest displacement."""
    return float(np.abs(found - true).max() / np.abs(true).max())
