"""Solutions to hold drawn systems against: every switch located, none of the package's kernel.

The equations are those of `studies.equations`, the branches those of `studies.branches`. Where all
forces are straight within the present branches, the motion goes on by matrix exponentials (exact to
rounding, however stiff); elsewhere by scipy's DOP853 (`switched`). Either way a guard is looked at every
quarter of a millisecond and, between two such instants, where it has a minimum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import ceil, inf, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray
from phaseplane.scenarios.studies.branches import Branches
from phaseplane.scenarios.studies.equations import Equations
from phaseplane.scenarios.studies.expressions import Law
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.pieces import Piece
from phaseplane.suspension.systems import System
from scipy.linalg import expm
from scipy.optimize import brentq
from switched import Leg, NoTruthError, advance

Array = NDArray[np.float64]

LONGEST = 2.5e-4  # s between two looks at the guards
_BLOCK = 64  # looks at once
_TERMS = 40  # of a Taylor series over a time in which no mode turns or decays by more than _SHORT
_SHORT = 4.0
_HALVINGS = 60  # of a time too long for that
_SAME = 1e-12  # s; as in studies.reference
_MOST_STEPS = 200_000  # of DOP853 in one run
_MOST_SWITCHES = 20_000


@dataclass(frozen=True)
class Truth:
    """The motion at some instants, one row each: m, m/s, m/s^2, and N for each element.

    `switches` are instants, elements and kinds; `jumps` the instants at which the law of the road or of
    a load changes.
    """

    times: Array
    displacements: Array
    velocities: Array
    accelerations: Array
    forces: Array
    switches: list[tuple[float, str, str]]
    jumps: list[float]


def solve(
    system: System,
    state: Array,
    times: Array,
    kick: tuple[int, Array] | None = None,
) -> Truth:
    """The motion of a system from a state at times[0].

    Parameters
    ----------
    state : displacements and velocities at times[0]
    times : ascending, s
    kick : k and what is added to the state at times[k], from which it is read then

    Raises
    ------
    NoTruthError : too stiff for an explicit method, or switches without end.
    """
    equations = _Equations(system)
    n = equations.n
    relaxed = np.zeros(len(equations.series))
    y, t, k = np.concatenate([state, relaxed]), float(times[0]), 1
    branches = Branches(equations, t, y)
    straight, curved = _Straight(equations), _Curved(equations)
    functions = equations.functions()
    rows = np.empty((len(times), 3 * n + len(system.elements)))

    def read(k: int, t: float, row: Array) -> None:
        rate, force = [0.0] * equations.order, [0.0] * len(system.elements)
        functions["rhs"](t, row.tolist(), rate, branches.p)
        functions["forces"](t, row.tolist(), force, branches.p)
        rows[k] = [*row[: 2 * n], *rate[n : 2 * n], *force]

    read(0, t, y)
    jumps: list[float] = []
    while k < len(times):
        if times[k] - t < _SAME:  # a switch fell on it
            read(k, t, y)
            k += 1
            continue
        joint = branches.next_joint(t)
        at = kick[0] if kick and k <= kick[0] else -1
        end = min(joint, float(times[at]))
        last = int(times.searchsorted(end + _SAME))
        wanted = np.minimum(times[k:last], end)
        method = straight if straight.enters(branches, t) else curved
        leg = method.advance(t, end, y, branches, wanted)
        for row in leg.rows:
            if kick and k == kick[0]:
                leg = leg._replace(state=leg.state + np.concatenate([kick[1], relaxed]))
            read(k, float(times[k]), leg.state if kick and k == kick[0] else row)
            k += 1
        t, y = leg.end, leg.state.copy()
        if leg.left >= 0:
            branches.leave(t, y)
        elif t == joint:
            jumps.append(t)
            branches.pass_joint(t, y)
        elif at >= 0:
            branches.settle(t, y)
        if len(branches.events) > _MOST_SWITCHES:
            raise NoTruthError(f"more than {_MOST_SWITCHES} switches by {t:.6g} s")
    parts = np.split(rows, [n, 2 * n, 3 * n], axis=1)
    return Truth(times, *parts, branches.events, jumps)


@dataclass(frozen=True, slots=True)
class _AnyLaw(Law):
    """A law with a power of |s|, and with a function of that name."""

    own: str = ""

    def numbers(self, piece: Piece) -> list[float]:
        *polynomial, height, steepness = super(_AnyLaw, self).numbers(piece)
        more = [piece.power, piece.exponent, float(piece.own is not None)]
        return [*polynomial, *more, height, steepness]

    def text(self, x: str) -> str:
        count = len(self.numbers(self.pieces[0]))
        origin, *_, power, exponent, own, _, _ = (f"p[{self.at + k}]" for k in range(count))
        s = f"({x} - {origin})"
        text = f"{super(_AnyLaw, self).text(x)} + {power} * copysign(abs({s}) ** {exponent}, {s})"
        return f"{text} + {own} * {self.own}({s})" if self.own else text


@dataclass(frozen=True, slots=True)
class _InSeries(Law):
    """A damper with a spring in series, whose extension is a state of its own."""

    force: str = ""

    def text(self, x: str) -> str:
        return self.force


class _Equations(Equations):
    """The equations with all elements: power laws, functions, springs in series with dampers."""

    def __init__(self, system: System) -> None:
        self.own: dict[str, Callable[[Any], Any]] = {}
        self.series = [i for i, e in enumerate(system.elements) if e.series < inf]
        plain = tuple(replace(e, series=inf) for e in system.elements)
        super().__init__(replace(system, elements=plain))
        self.order = 2 * self.n + len(self.series)  # of the state
        self._mounted = [system.elements[i] for i in self.series]
        for j, (i, e) in enumerate(zip(self.series, self._mounted, strict=True)):
            force = f"{e.series!r} * y[{2 * self.n + j}]"
            self.laws["damper"][i] = _InSeries(e.damper.pieces, (), False, force=force)

    def _law(self, law: Characteristic, *, yields: bool = False) -> Law:
        if not any(piece.power or piece.own for piece in law.pieces):
            return super()._law(law, yields=yields)
        own = next((piece.own for piece in law.pieces if piece.own), None)
        name = f"own{len(self.own)}" if own else ""
        if own:
            self.own[name] = np.vectorize(own.force, otypes=[float])
        made = _AnyLaw(law.pieces, (0, 1, 2, 3), True, own=name)
        return replace(made, at=self._take(len(made.numbers(law.pieces[0]))))

    def _written(self, *, choosing: bool) -> str:
        rhs, *others = super()._written(choosing=choosing).split("\n\n")
        for j, (i, e) in enumerate(zip(self.series, self._mounted, strict=True)):
            at, row = 2 * self.n + j, self._row(self.system.elements[i])
            slip = e.series / e.damper.tangent(0.0)
            rhs += f"\n    dy[{at}] = w{row} - {slip!r} * y[{at}]"
        return "\n\n".join([rhs, *others])

    def functions(self, **given: Any) -> dict[str, Callable[[Any, Any, Any, Any], None]]:
        return super().functions(copysign=np.copysign, **self.own, **given)


class _Sampled(_Equations):
    """The equations as functions of value, rate and second derivative of each signal in turn, for t."""

    def _signal_lines(self) -> Iterable[str]:
        for k, course in enumerate(self.courses):
            if not course.is_zero:
                yield f"u{k}, du{k}, ddu{k} = t[{3 * k}], t[{3 * k + 1}], t[{3 * k + 2}]"


class _Straight:
    """Motion by matrix exponentials: z' = G z, with z the state, 1, and each signal with its derivatives.

    A signal is the sum of a cubic p, carried as p, p', p'', p''', and of a cosine c, as c and c'.
    """

    def __init__(self, equations: _Equations) -> None:
        self.equations = equations
        functions = _Sampled(equations.system).functions()
        self._rhs, self._guards = functions["rhs"], functions["guards"]
        self._moving = [k for k, course in enumerate(equations.courses) if not course.is_zero]
        # the numbers of p before this one are those of signals
        self._first = min([equations.bounds, *self._places()])
        self._known: dict[Any, _Flow | None] = {}

    def _places(self) -> list[int]:
        e = self.equations
        laws = [law.at for laws in e.laws.values() for law in laws if law.at >= 0]
        return [*laws, *e.contacts.values(), *e.slips.values(), e.sticking]

    def enters(self, branches: Branches, t: float) -> bool:
        """Whether all is straight in the present branches, on the present segments of the signals."""
        if self.equations.series:
            return False
        segments = self._segments(branches)
        if any(s.amplitude and s.phase[2] for s in segments):
            return False
        turns = tuple(s.phase[1] if s.amplitude else 0.0 for s in segments)
        key = (branches.p[self._first :].tobytes(), turns)
        if key not in self._known:
            if len(self._known) > 400:
                self._known.clear()
            self._known[key] = self._flow(branches.p, turns)
        self._now = self._known[key]
        return self._now is not None

    def _segments(self, branches: Branches) -> list[Any]:
        return [self.equations.courses[k].segments[branches.segment[k]] for k in self._moving]

    def _flow(self, p: Array, turns: tuple[float, ...]) -> _Flow | None:
        e, n = self.equations, self.equations.n
        signals, guards = 3 * len(e.courses), len(e.guards)

        def at(x: Array) -> Array:
            rate, room = [0.0] * (2 * n), [0.0] * guards
            self._rhs(x[2 * n :].tolist(), x[: 2 * n].tolist(), rate, p)
            self._guards(x[2 * n :].tolist(), x[: 2 * n].tolist(), room, p)
            return np.array(rate + room)

        size = 2 * n + signals
        zero = at(np.zeros(size))
        columns = np.array([0.5 * (at(x) - at(-x)) for x in np.eye(size)]).T
        probe = np.cos(np.arange(1.0, size + 1.0))  # no number of it is 0
        one, two = at(probe), at(2.0 * probe)
        terms = np.abs(columns) @ np.abs(probe) + np.abs(zero)
        if (np.abs(two - 2.0 * one + zero) > 1e-9 * terms).any():
            return None
        if (np.abs(one - zero - columns @ probe) > 1e-9 * terms).any():
            return None
        whole = 2 * n + 1 + 6 * len(turns)
        generator, rooms = np.zeros((whole, whole)), np.zeros((guards, whole))
        for target, part in ((generator[: 2 * n], slice(0, 2 * n)), (rooms, slice(2 * n, None))):
            target[:, : 2 * n] = columns[part, : 2 * n]
            target[:, 2 * n] = zero[part]
        for j, (k, turn) in enumerate(zip(self._moving, turns, strict=True)):
            first, source = 2 * n + 1 + 6 * j, 2 * n + 3 * k
            for target, part in (
                (generator[: 2 * n], slice(0, 2 * n)),
                (rooms, slice(2 * n, None)),
            ):
                value, rate, second = columns[part, source : source + 3].T
                target[:, first : first + 3] = np.column_stack([value, rate, second])
                target[:, first + 4] = value - turn**2 * second
                target[:, first + 5] = rate
            for i in range(3):
                generator[first + i, first + i + 1] = 1.0
            generator[first + 4, first + 5], generator[first + 5, first + 4] = 1.0, -(turn**2)
        return _Flow(generator, rooms, n)

    def advance(self, t: float, end: float, y: Array, branches: Branches, wanted: Array) -> Leg:
        flow = self._now
        z = np.concatenate([y, [1.0], *(_parts(s, t) for s in self._segments(branches))])
        rows = np.empty((len(wanted), len(y)))
        filled = 0

        def fill(since: float, upto: float, z: Array) -> None:
            nonlocal filled
            while filled < len(wanted) and wanted[filled] <= upto:
                rows[filled] = flow.after(wanted[filled] - since, z)[: len(y)]
                filled += 1

        while t < end:
            looks = min(_BLOCK, ceil((end - t) / flow.span))
            states = flow.looks(z, looks)
            instants = t + flow.span * np.arange(looks + 1)
            if instants[-1] > end:
                states[-1] = flow.after(end - instants[-2], states[-2])
            instants[-1] = min(instants[-1], end)
            for j in flow.suspects(states):
                width = float(instants[j + 1] - instants[j])
                late = flow.first_exit(states[j], width)
                if late is None:
                    continue
                for i in range(j):
                    fill(instants[i], instants[i + 1], states[i])
                fill(instants[j], instants[j] + late, states[j])
                state = flow.after(late, states[j])[: len(y)]
                return Leg(float(instants[j]) + late, state, rows[:filled], 0)
            for i in range(looks):
                if filled < len(wanted) and wanted[filled] <= instants[i + 1]:
                    fill(instants[i], instants[i + 1], states[i])
            t, z = float(instants[-1]), states[-1]
        return Leg(end, z[: len(y)], rows, -1)


def _parts(segment: Any, t: float) -> Array:
    """The cubic of a signal with its derivatives, its cosine with its rate."""
    both = np.array([*segment.derivatives(t)])
    cubic = np.array([*segment._replace(amplitude=0.0).derivatives(t)])
    return np.array([*cubic, *(both - cubic)[:2]])


class _Flow:
    """exp(G s) of one set of branches, and the guards C z."""

    def __init__(self, generator: Array, guards: Array, n: int) -> None:
        self.generator, self.guards = generator, guards
        self.falling = guards @ generator
        a = np.abs(generator[n : 2 * n, : 2 * n])
        fast = max(np.sqrt(a[:, :n].sum(axis=1).max()), a[:, n:].sum(axis=1).max(), 1e-9)
        waves = np.sqrt(np.abs(generator[2 * n :, 2 * n :]).max(initial=0.0))
        self.span = LONGEST if fast > 20.0 * _SHORT / LONGEST else min(LONGEST, _SHORT / fast)
        self.smooth = max(fast, waves) * self.span <= 1.01 * _SHORT
        one = expm(generator * self.span)
        powers = [one]
        for _ in range(_BLOCK - 1):
            powers.append(powers[-1] @ one)
        self._powers = np.array(powers)
        self.half = lru_cache(None)(lambda k: expm(generator * (self.span * 0.5**k)))

    def looks(self, z: Array, count: int) -> Array:
        """States after 0, 1, ..., count spans."""
        return np.concatenate([z[None], self._powers[:count] @ z])

    def suspects(self, states: Array) -> Array:
        """Numbers of the spans in which a guard may fall below zero."""
        rooms, rates = states @ self.guards.T, states @ self.falling.T
        outside = (rooms[1:] < 0.0).any(axis=1)
        dips = ((rates[:-1] < 0.0) & (rates[1:] > 0.0)).any(axis=1)
        return np.flatnonzero(outside | dips if self.smooth else outside)

    def series(self, z: Array) -> Array:
        """Taylor coefficients of z, highest first."""
        terms = [z]
        for k in range(1, _TERMS):
            terms.append(self.generator @ terms[-1] / k)
        return np.array(terms[::-1])

    def after(self, s: float, z: Array) -> Array:
        """The state after s, at most one span."""
        if s == self.span:
            return self._powers[0] @ z
        if not self.smooth:
            return expm(self.generator * s) @ z
        return np.polyval(self.series(z), s) if s > 0.0 else z

    def first_exit(self, z: Array, width: float) -> float | None:
        """The first time within the span at which a guard is below zero; None if there is none."""
        if not self.smooth:
            return self._descend(z, width)
        series = self.series(z)
        rooms = series @ self.guards.T
        grid = np.linspace(0.0, width, 9)
        found = None
        for k in range(rooms.shape[1]):
            line = rooms[:, k]
            values = np.polyval(line, grid)
            rates = np.polyval(np.polyder(line), grid)
            for j in range(8):
                low, high = grid[j], grid[j + 1]
                if values[j + 1] >= 0.0:
                    if not (rates[j] < 0.0 < rates[j + 1]):
                        continue
                    high = brentq(lambda s, line=line: np.polyval(np.polyder(line), s), low, high)
                    if np.polyval(line, high) >= 0.0:
                        continue
                if np.polyval(line, low) > 0.0:
                    high = brentq(lambda s, line=line: np.polyval(line, s), low, high, xtol=1e-18)
                else:
                    high = low
                found = high if found is None else min(found, high)
                break
        return found

    def _descend(self, z: Array, width: float) -> float | None:
        """Bisection by ever shorter exponentials, from the first half that ends outside."""
        last, shorter = z, 0.0
        for k in range(_HALVINGS, -1, -1):  # quick changes right after a switch
            s = self.span * 0.5**k
            if s > width:
                break
            state = self.half(k) @ z
            if (self.guards @ state < 0.0).any():
                break
            last, shorter = state, s
        else:
            return None
        since, z = shorter, last
        for j in range(k, _HALVINGS + 1):
            s = self.span * 0.5**j
            if since + s > width:
                continue
            state = self.half(j) @ z
            if not (self.guards @ state < 0.0).any():
                since, z = since + s, state
        return since if since < width else None


class _Curved:
    """Motion by DOP853."""

    def __init__(self, equations: _Equations) -> None:
        self._rhs = equations.functions()["rhs"]
        self._guards = equations.functions(cos=np.cos, sin=np.sin, tanh=np.tanh)["guards"]
        self._size, self._count = equations.order, len(equations.guards)

    def advance(self, t: float, end: float, y: Array, branches: Branches, wanted: Array) -> Leg:
        self._p = branches.p.tolist()
        return advance(
            self, t, y, end, wanted, longest=1e-3, tolerance=3e-13, most_steps=_MOST_STEPS
        )

    def derivative(self, t: float, state: Array) -> list[float]:
        found = [0.0] * self._size
        try:
            self._rhs(t, state.tolist(), found, self._p)
        except OverflowError:  # of a step too long for a power law: it is tried shorter
            return [nan] * self._size
        return found

    def rooms(self, t: Array, states: Array) -> list[Array]:
        found: list[Any] = [0.0] * self._count
        self._guards(t, states, found, self._p)
        return [x + 0.0 * t for x in found]


__all__ = ["NoTruthError", "Truth", "solve"]
