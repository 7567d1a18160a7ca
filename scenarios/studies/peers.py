"""Other integrators on the same problems, each set up as well as possible.

Right-hand sides and guards are compiled by numba if it is installed; every run is split at the joints
of the road; solvers with event location locate the switches. The others raise `UnableError` if a problem
needs that.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .branches import Branches
from .equations import Vector
from .reference import Stretch, by_scipy, drive, until
from .workbench import Prepared, Run, Segmented, Workbench

_MOST_STEPS = 1_000_000


# -- with events ---------------------------------------------------------------------------------


def scipy_method(method: str, bench: Workbench, tolerance: float) -> Run:
    """Return a run of `solve_ivp`, with the smallest guard as its event."""
    rhs, margin = bench.returning
    options = {"rtol": max(tolerance, 3e-14), "atol": tolerance * bench.scale}
    advance = by_scipy(rhs, margin, method, **options)
    return partial(drive, bench.problem, bench.branches, advance)


def cvode(method: str, bench: Workbench, tolerance: float) -> Run:
    """Return a run of SUNDIALS' CVODE by scikit-sundae, with the smallest guard as its event."""
    from sksundae.cvode import CVODE  # noqa: PLC0415  (optional)

    _, margin = bench.returning
    fill = bench.compiled["rhs"] if bench.compiled else bench.equations.functions()["rhs"]
    p = bench.branches.p.copy()

    def rhs(t: float, y: Vector, dy: Vector) -> None:
        fill(t, y, dy, p)

    options: dict[str, Any] = {}
    if margin is not None:

        def events(t: float, y: Vector, g: Vector) -> None:
            g[0] = margin(t, y, p)

        events.terminal, events.direction = [True], [-1]  # type: ignore[attr-defined]
        options = {"eventsfn": events, "num_events": 1}
    solver = CVODE(
        rhs,
        method=method,
        rtol=tolerance,
        atol=tolerance * bench.scale,
        max_num_steps=_MOST_STEPS,
        **options,
    )

    def advance(t: float, end: float, y: Vector, now: Vector, wanted: Vector) -> Stretch:
        p[:] = now
        # with only two times it would return all of its steps; hence a third one
        instants = [t, 0.5 * (t + (wanted[0] if len(wanted) else end)), *wanted]
        if not (len(wanted) and wanted[-1] == end):
            instants.append(end)
        run = solver.solve(np.array(instants), y)
        if not run.success:
            raise ArithmeticError(str(run.message))
        switched = run.status == 2
        rows = run.y[2:-1] if switched else run.y[2:]
        return Stretch(float(run.t[-1]), run.y[-1], rows[: len(wanted)], switched)

    return partial(drive, bench.problem, bench.branches, advance)


def heyoka(bench: Workbench, tolerance: float) -> Run:
    """Return a run of an adaptive Taylor integrator, compiled once; its events change p."""
    import heyoka as hy  # noqa: PLC0415  (heavy, optional)

    equations, problem, n = bench.equations, bench.problem, bench.equations.n
    par = [hy.par[k] for k in range(equations.size)]
    symbols = hy.make_vars(*(f"y{k}" for k in range(2 * n)))
    functions = equations.functions(cos=hy.cos, sin=hy.sin, tanh=hy.tanh)
    rates: list[Any] = [0.0] * (2 * n)
    functions["rhs"](hy.time, symbols, rates, par)
    guards: list[Any] = [0.0] * len(equations.guards)
    functions["guards"](hy.time, symbols, guards, par)
    course: list[Branches] = [bench.branches]

    def passed(guard: Any) -> Callable[[Any, int], bool]:
        def switch(ta: Any, _direction: int) -> bool:
            branches = course[0]
            branches.switch(guard, ta.time, ta.state)
            branches.settle(ta.time, ta.state)
            ta.pars[:] = branches.p
            return True

        return switch

    events = [
        hy.t_event(
            expression,
            direction=hy.event_direction.negative,
            callback=passed(guard),
            cooldown=0.0,  # the automatic value could miss the next switch of the same side
        )
        for expression, guard in zip(guards, equations.guards, strict=True)
    ]
    integrator = hy.taylor_adaptive(
        list(zip(symbols, rates, strict=True)),
        problem.start,
        pars=bench.branches.p,
        tol=tolerance,
        t_events=events,
    )
    times, start = problem.times, problem.start

    def reset() -> None:
        course[0] = bench.branches.copy()
        integrator.time = 0.0
        integrator.state[:] = start
        integrator.pars[:] = course[0].p
        if events:
            integrator.reset_cooldowns()

    def run() -> Vector:
        branches = course[0]
        out = np.empty((len(times), n))
        out[0] = start[:n]
        t, k = 0.0, 1
        while k < len(times):
            joint = branches.next_joint(t)
            end = min(joint, times[-1])
            wanted = until(times[k:], end)
            at_end = len(wanted) > 0 and wanted[-1] == end
            grid = np.array([t, *wanted] if at_end else [t, *wanted, end])
            result = integrator.propagate_grid(grid)
            rows = result[-1]
            if len(rows) < len(grid) or not np.isfinite(rows[-1]).all():
                raise ArithmeticError(f"stopped at {integrator.time:.9g} s: {result[0]}")
            out[k : k + len(wanted)] = rows[1 : 1 + len(wanted), :n]
            k, t = k + len(wanted), end
            if t == joint:
                integrator.time, integrator.state[:] = t, rows[-1]
                branches.pass_joint(t, integrator.state)
                integrator.pars[:] = branches.p
        return out

    return Prepared(reset, run)


# -- without events ------------------------------------------------------------------------------


def _from_joint_to_joint(bench: Workbench, advance: Callable[[Vector, Segmented], Vector]) -> Run:
    """Return a run that is advanced from joint to joint of the road.

    Parameters
    ----------
    bench : the problem
    advance : returns the states at the instants after the first of a stretch; may change the state given
    """
    stretches, n = bench.stretches(), bench.equations.n
    times, start = bench.problem.times, bench.problem.start

    def run() -> Vector:
        out = np.empty((len(times), n))
        y = start.copy()
        out[0], k = y[:n], 1
        for stretch in stretches:
            rows = advance(y, stretch)
            out[k : k + stretch.wanted] = rows[: stretch.wanted, :n]
            k, y = k + stretch.wanted, rows[-1].copy()
        return out

    return run


def numbalsoda(name: str, bench: Workbench, tolerance: float) -> Run:
    """Return a run of `lsoda` or `dop853` of numbalsoda, split at the joints of the road."""
    from numba import carray, cfunc  # noqa: PLC0415  (heavy, optional)
    from numbalsoda import dop853, lsoda, lsoda_sig  # noqa: PLC0415  (optional)

    choosing = bench.choosing()
    solve = {"lsoda": lsoda, "dop853": dop853}[name]
    size, numbers = 2 * bench.equations.n, max(bench.equations.size, 1)

    @cfunc(lsoda_sig)
    def rhs(t, y, dy, p):  # type: ignore[no-untyped-def]
        choosing(t, carray(y, (size,)), carray(dy, (size,)), carray(p, (numbers,)))

    rtol, atol = tolerance, tolerance * float(bench.scale[0])

    def advance(y: Vector, stretch: Segmented) -> Vector:
        rows, success = solve(rhs.address, y, stretch.instants, stretch.p, rtol, atol, _MOST_STEPS)
        if not success:
            raise ArithmeticError(f"gave up before {stretch.end:.6g} s")
        return rows[1:]

    return _from_joint_to_joint(bench, advance)


def runge_kutta(bench: Workbench, step: float) -> Run:
    """Return a run of the classical order-4 method with fixed steps, in one compiled function."""
    from numba import njit  # noqa: PLC0415  (heavy, optional)

    rhs = bench.choosing()
    size = 2 * bench.equations.n

    @njit
    def go(y: Vector, instants: Vector, p: Vector, out: Vector, longest: float) -> None:
        k1, k2, k3, k4 = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
        z = np.empty(size)
        for i in range(len(instants) - 1):
            span = instants[i + 1] - instants[i]
            count = int(np.ceil(span / longest - 1e-9))
            h = span / count
            for k in range(count):
                t = instants[i] + k * h
                rhs(t, y, k1, p)
                for m in range(size):
                    z[m] = y[m] + 0.5 * h * k1[m]
                rhs(t + 0.5 * h, z, k2, p)
                for m in range(size):
                    z[m] = y[m] + 0.5 * h * k2[m]
                rhs(t + 0.5 * h, z, k3, p)
                for m in range(size):
                    z[m] = y[m] + h * k3[m]
                rhs(t + h, z, k4, p)
                for m in range(size):
                    y[m] += h / 6.0 * (k1[m] + 2.0 * k2[m] + 2.0 * k3[m] + k4[m])
            for m in range(size):
                out[i, m] = y[m]

    def advance(y: Vector, stretch: Segmented) -> Vector:
        rows = np.empty((len(stretch.instants) - 1, size))
        go(y, stretch.instants, stretch.p, rows, step)
        return rows

    return _from_joint_to_joint(bench, advance)
