"""A quarter car hard-coded for numba: Dormand and Prince's method of order 8, landing on every switch.

It is what an expert would write by hand for this one problem: its numbers compiled in, the stages
unrolled, steps chosen by the two error estimates, output from the method's own polynomial of order 7.
On that polynomial the switches of damper and tyre are located, and the next step starts there.
Method and coefficients: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations
I, 1993, section II.5, as scipy has them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from math import cos, sin, tanh
from typing import Any

import numpy as np
import numpy.typing as npt
from phaseplane.scenarios.studies.workbench import Run, UnableError, Workbench
from scipy.integrate import DOP853

Vector = npt.NDArray[np.float64]

_STATES = range(4)  # both displacements, both velocities
_LAST, _DENSE = 12, 13  # the stage at the end of a step, and the first of those for the polynomial

# Steps over all times: the state y at t, s at the end of the step, v at the part `to` of it. Guards g
# hold at t, b at the look before, c at this one. Names in braces stand for unrolled sums of stages.
_LOOP = """
def go(times, start, passing, valve, rtol, atol, rate_atol, out):
    y0, y1, y2, y3 = start
    out[0, 0], out[0, 1] = y0, y1
    t, wanted, row, end, passed, contact = times[0], 1e-3, 1, times[-1], False, 0
    s0, s1, s2, s3 = y0, y1, y2, y3
    {first}
    for _ in range(1_000_000):
        bound = end if passed else min(end, passing)
        last = t + 1.01 * wanted >= bound
        h = bound - t if last else wanted
        {stages}
        e5 = e3 = 0.0
        {error}
        error = h * e5 / sqrt(4.0 * (e5 + 0.01 * e3)) if e5 > 0.0 else 0.0
        if not error < 1.0:
            wanted = h * max(0.3, 0.9 * error**-0.125)
            if not wanted > 1e-14:
                return False
            continue
        {polynomial}
        part, switched = 1.0, -1
        before = 0.0
        b = guards(t, y0, y1, y2, y3, valve, contact, passed)
        for look in range(1, 5):
            to = 0.25 * look
            {at}
            c = guards(t + to * h, v0, v1, v2, v3, valve, contact, passed)
            for k in range(4):
                if c[k] >= 0.0:
                    continue
                low, at_low, high, at_high, side = before, b[k], 0.25 * look, c[k], 0
                while high - low > 1e-15:  # regula falsi, Illinois variant
                    to = (low * at_high - high * at_low) / (at_high - at_low)
                    if not low < to < high:
                        to = 0.5 * (low + high)
                    {at}
                    value = guards(t + to * h, v0, v1, v2, v3, valve, contact, passed)[k]
                    if value > 1e-15:
                        low, at_low = to, value
                        at_high *= 0.5 if side > 0 else 1.0
                        side = 1
                    else:
                        high, at_high = to, value
                        at_low *= 0.5 if side < 0 else 1.0
                        side = -1
                        if value > -1e-15:
                            break
                if switched < 0 or high < part:
                    part, switched = high, k
            if switched >= 0:
                break
            before, b = 0.25 * look, c
        then = bound if last and switched < 0 else t + part * h
        while times[row] <= then:
            to = (times[row] - t) / h
            {at}
            out[row, 0], out[row, 1] = v0, v1
            row += 1
            if row == len(times):
                return True
        larger = h * min(6.0, 0.9 * error**-0.125) if error > 1e-7 else 6.0 * h
        wanted = max(wanted, larger) if last else larger
        if switched >= 0:
            to = part
            {at}
            s0, s1, s2, s3 = v0, v1, v2, v3
            valve, contact = switch(switched, valve, contact)
        y0, y1, y2, y3 = s0, s1, s2, s3
        t, passed = then, then >= passing
        {first}
    return False
"""


def landing(bench: Workbench, tolerance: float) -> Run:
    """Return a run of the hard-coded method, with the tolerances that other peers are given.

    Raises
    ------
    UnableError : if the problem is not a quarter car over a bump.
    """
    problem = bench.problem
    elements = [element.name for element in problem.system.elements]
    road = problem.system.signals["road"].segments if "road" in problem.system.signals else ()
    if elements != ["spring", "damper", "tyre"] or len(road) != 3 or road[1].start != 0.0:
        raise UnableError("only a quarter car over a bump at its start is hard-coded")
    go, valve = _compiled(bench)
    times, start = problem.times, tuple(problem.start.tolist())
    atol, rate_atol = (tolerance * float(x) for x in (bench.scale[0], bench.scale[-1]))

    def run() -> Vector:
        out = np.empty((len(times), 2))
        if not go(times, start, road[2].start, valve, tolerance, atol, rate_atol, out):
            raise ArithmeticError("gave up")
        return out

    return run


def _compiled(bench: Workbench) -> tuple[Callable[..., bool], int]:
    """Return the compiled loop with the numbers of a car, and the piece of its damper at the start."""
    from numba import njit  # noqa: PLC0415  (heavy, optional)

    known = bench.compiled
    if "landing" not in known:
        valve, functions = _car(bench)
        space: dict[str, Any] = {name: njit(f) for name, f in functions.items()}
        space["sqrt"] = math.sqrt
        exec(compile(_source(), "<dop853>", "exec"), space)
        known["landing"] = njit(space["go"]), valve
    made: tuple[Callable[..., bool], int] = known["landing"]
    return made


def _car(bench: Workbench) -> tuple[int, dict[str, Callable[..., Any]]]:
    """Return the damper's piece at the start, and acceleration, guards and switch of a quarter car.

    Guards are positive within a branch: two of the damper, two of the tyre. The tyre touches the road
    (0); or it does not, still shorter than its free length (1), or across a gap (2).
    """
    from numba import njit  # noqa: PLC0415  (heavy, optional)

    system = bench.problem.system
    spring, damper, tyre = system.elements
    (body, _), (_, wheel) = system.mass
    hump = system.signals["road"].segments[1]
    half, rate = hump.coefficients[0], hump.phase[1]
    _, c1, _, c3 = spring.spring.pieces[0].coefficients
    c2, k2, weight, opening = (
        tyre.spring.tangent(0.0), tyre.damper.tangent(0.0), tyre.limit, tyre.opening
    )  # fmt: skip
    pieces = damper.damper.pieces
    corners = np.array([*(piece.start for piece in pieces), np.inf])
    origins = np.array([piece.origin for piece in pieces])
    levels = np.array([piece.coefficients[0] for piece in pieces])
    slopes = np.array([piece.coefficients[1] for piece in pieces])
    heights = np.array([piece.saturation for piece in pieces])
    steepness = np.array([1.0 / piece.scale for piece in pieces])
    saturates = bool(heights.any())

    @njit
    def tyre_state(t, x2, v2, passed):  # type: ignore[no-untyped-def]
        if passed:
            return x2, c2 * x2 + k2 * v2
        d = x2 - half * (1.0 - cos(rate * t))
        return d, c2 * d + k2 * (v2 - half * rate * sin(rate * t))

    def acceleration(t, x1, x2, v1, v2, valve, contact, passed):  # type: ignore[no-untyped-def]
        y, s = x1 - x2, v1 - v2 - origins[valve]
        strut = y * (c1 + c3 * y * y) + levels[valve] + slopes[valve] * s
        if saturates:
            strut += heights[valve] * tanh(s * steepness[valve])
        pull = tyre_state(t, x2, v2, passed)[1] if contact == 0 else weight
        return -strut / body, (strut - pull) / wheel

    def guards(t, x1, x2, v1, v2, valve, contact, passed):  # type: ignore[no-untyped-def]
        d, force = tyre_state(t, x2, v2, passed)
        above, below = v1 - v2 - corners[valve], corners[valve + 1] - (v1 - v2)
        if contact == 0:
            return above, below, 1.0 - force / weight, 1.0
        if contact == 1:
            return above, below, force / weight - 1.0, 1.0 - d / opening
        return above, below, d / opening - 1.0, 1.0

    def switch(guard, valve, contact):  # type: ignore[no-untyped-def]
        if guard < 2:
            return valve + 2 * guard - 1, contact
        if contact == 0:
            return valve, 1
        return valve, 0 if guard == 2 else 2

    rising = float(np.dot(damper.direction, bench.problem.start[2:]))
    valve = int(np.searchsorted(corners[:-1], rising)) - 1
    return valve, {"acceleration": acceleration, "guards": guards, "switch": switch}


# -- unrolling -----------------------------------------------------------------------------------


def _source() -> str:
    """Return the loop with its stages unrolled."""
    parts = {
        "first": _stage(0, "t"),
        "stages": _stages(1, [*DOP853.A[1:], DOP853.B], [*DOP853.C[1:], 1.0]),
        "error": _error(),
        "polynomial": _polynomial(),
        "at": _value(),
    }
    texts = {f"{{{name}}}": list(lines) for name, lines in parts.items()}
    written = []
    for line in _LOOP.splitlines():
        indent = line[: len(line) - len(line.lstrip())]
        written += [indent + text for text in texts.get(line.strip(), [line.strip()])]
    return "\n".join(written)


def _sum(weights: Iterable[float], m: int) -> str:
    """Return sum weights[k] k_m of the stages k as text, without the zeros."""
    return " + ".join(f"{float(w)!r} * k{k}_{m}" for k, w in enumerate(weights) if w != 0.0)


def _stage(k: int, time: str) -> Iterator[str]:
    """Yield the right-hand side at time and state s, as stage k."""
    yield f"k{k}_0, k{k}_1 = s2, s3"
    yield f"k{k}_2, k{k}_3 = acceleration({time}, s0, s1, s2, s3, valve, contact, passed)"


def _stages(first: int, rows: Iterable[Vector], nodes: Iterable[float]) -> Iterator[str]:
    """Yield the stages from `first` on, each from a sum of earlier ones."""
    for k, (row, node) in enumerate(zip(rows, nodes, strict=True), first):
        yield from (f"s{m} = y{m} + h * ({_sum(row, m)})" for m in _STATES)
        yield from _stage(k, f"t + {float(node)!r} * h")


def _error() -> Iterator[str]:
    """Yield the sums of squares e5, e3 of both error estimates, over the tolerance."""
    for m in _STATES:
        floor = "atol" if m < 2 else "rate_atol"
        yield f"bar = {floor} + rtol * max(abs(y{m}), abs(s{m}))"
        yield f"e5 += (({_sum(DOP853.E5, m)}) / bar) ** 2"
        yield f"e3 += (({_sum(DOP853.E3, m)}) / bar) ** 2"


def _polynomial() -> Iterator[str]:
    """Yield three more stages and the coefficients; the state at the end stays in s."""
    yield from (f"e{m} = s{m}" for m in _STATES)
    yield from _stages(_DENSE, DOP853.A_EXTRA, DOP853.C_EXTRA)
    for m in _STATES:
        yield f"s{m} = e{m}"
        yield f"f0_{m} = s{m} - y{m}"
        yield f"f1_{m} = h * k0_{m} - f0_{m}"
        yield f"f2_{m} = 2.0 * f0_{m} - h * (k{_LAST}_{m} + k0_{m})"
        yield from (f"f{3 + i}_{m} = h * ({_sum(row, m)})" for i, row in enumerate(DOP853.D))


def _value() -> Iterator[str]:
    """Yield the polynomial at the part `to` of the step."""
    yield "rest = 1.0 - to"
    for m in _STATES:
        text = f"f6_{m}"
        for i in range(5, -1, -1):
            text = f"f{i}_{m} + {'to' if i % 2 else 'rest'} * ({text})"
        yield f"v{m} = y{m} + to * ({text})"
