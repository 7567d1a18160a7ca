"""Equations whose right-hand side switches: f is smooth while the signs of its guards last.

On a guard g = 0 at which f jumps, a motion either goes through or, if both sides lead back to it, slides
along it. The acceleration is then the one between those of both sides with which g stays zero (A. F.
Filippov, Differential equations with discontinuous righthand sides, 1988). Dry friction at rest is the
sliding on v = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import isfinite, isnan, nan

Signs = Sequence[float]
_Function = Callable[..., float]

Mode = tuple[int, ...]
"""The sign of each guard; 0 of one on which the motion slides. Two zeros or more are rest."""

_NEAR = 1e-6  # for difference quotients, relative to the state
_PROBE = 1e-7  # relative length of the steps that show to which side a motion goes
_REST = 1e-9  # of the scale of velocity: on a guard of x alone the motion rests


@dataclass(frozen=True)
class Switching:
    """f(v, x, t) as a function of the signs of guards, between which it is smooth.

    Parameters
    ----------
    function : f(v, x, t, signs), which may be called beyond the guards that its signs belong to
    guards : g(v, x, t, signs), each independent of its own sign and of those after it
    autonomous : whether f and the guards are independent of t
    jumps : whether f may jump on a guard, rather than have a corner there
    """

    function: _Function
    guards: tuple[_Function, ...] = ()
    autonomous: bool = False
    jumps: bool = True

    def signs(self, v: float, x: float, t: float) -> list[float]:
        """Return the signs of all guards at a state; 0 on a guard, nan where it is undefined."""
        found = [0.0] * len(self.guards)
        for k, guard in enumerate(self.guards):
            value = guard(v, x, t, found)
            found[k] = nan if isnan(value) else float((value > 0.0) - (value < 0.0))
        return found

    def is_defined(self, mode: Mode, v: float, x: float, t: float) -> bool:
        """Return whether all guards are numbers at a state."""
        return not any(isnan(guard(v, x, t, mode)) for guard in self.guards)

    @cached_property
    def reversed(self) -> Switching:
        """The equation in reversed time, in which velocities have the other sign."""
        return self._changed(lambda f: lambda v, x, t, signs: f(-v, x, -t, signs))

    def frozen(self, time: float) -> Switching:
        """Return the equation with t held at a time, s."""
        held = self._changed(lambda f: lambda v, x, _t, signs: f(v, x, time, signs))
        return replace(held, autonomous=True)

    def _changed(self, change: Callable[[_Function], _Function]) -> Switching:
        """Return the equation with f and all guards changed alike."""
        return replace(self, function=change(self.function), guards=tuple(map(change, self.guards)))

    def value(self, v: float, x: float, t: float) -> float:
        """Return f by the signs that hold at a state."""
        return self.function(v, x, t, self.signs(v, x, t))

    def acceleration(self, mode: Mode, v: float, x: float, t: float) -> float:
        """Return x'' in a mode; between the accelerations of both sides on a guard, 0 at rest."""
        zeros = mode.count(0)
        if zeros == 0:
            return -self.function(v, x, t, mode)
        if zeros > 1:
            return 0.0
        _, g_x, g_t = self.gradient(mode.index(0), mode, v, x, t)
        if g_x == g_t == 0.0:
            return 0.0  # on a guard of the velocity alone, without rounding
        low, high = self.sides(mode, v, x, t)
        if low is None or high is None:
            return 0.0
        (below, g_below), (above, g_above) = low, high
        apart = g_below - g_above
        return above + (below - above) * (-g_above / apart) if apart else 0.0

    def sides(
        self, mode: Mode, v: float, x: float, t: float
    ) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
        """Return x'' and the rate of the guard below and above the guard that a mode slides on.

        None if the guard does not depend on v: then there is no sliding but at rest.
        """
        k = mode.index(0)
        g_v, g_x, g_t = self.gradient(k, mode, v, x, t)
        if abs(g_v) * (1.0 + abs(v)) <= 1e-9 * abs(g_x) * (1.0 + abs(x)):
            return None, None
        found = []
        for side in (-1, 1):
            a = -self.function(v, x, t, _with(mode, k, side))
            found.append((a, g_x * v + g_v * a + g_t))
        return found[0], found[1]

    def gradient(
        self, k: int, signs: Signs, v: float, x: float, t: float
    ) -> tuple[float, float, float]:
        """Return the derivatives of a guard with respect to v, x and t."""
        guard = self.guards[k]
        return (
            slope(lambda v: guard(v, x, t, signs), v),
            slope(lambda x: guard(v, x, t, signs), x),
            0.0 if self.autonomous else slope(lambda t: guard(v, x, t, signs), t),
        )

    def margins(self, mode: Mode, v: float, x: float, t: float) -> list[float]:
        """Return for each guard how far the mode is from its end there: below zero it has ended.

        For a guard on which the motion slides: the lesser of the rates at which both sides lead back.
        """
        found = []
        for k, sign in enumerate(mode):
            if sign:
                found.append(sign * self.guards[k](v, x, t, mode))
                continue
            low, high = self.sides(mode, v, x, t) if mode.count(0) == 1 else (None, None)
            if low is None or high is None:
                found.append(self._firmness(k, mode, x, t))
            else:
                found.append(min(low[1], -high[1]))
        return found

    def rests(self, mode: Mode, x: float, t: float) -> bool:
        """Return whether a motion on several guards, or on that of the velocity, can stay at rest."""
        return 0 in mode and all(
            sign or self._firmness(k, mode, x, t) >= 0.0 for k, sign in enumerate(mode)
        )

    def _firmness(self, k: int, mode: Mode, x: float, t: float) -> float:
        """Return the margin of a rest on several guards, of which one may move on with time.

        Above 0 the rest lasts: 0 is within the range of f over the free signs, and the guard stays.
        """
        forces = [self.function(0.0, x, t, signs) for signs in _all(mode)]
        return min(max(forces), -min(forces), self._nearness(k, mode, x, t))

    def _nearness(self, k: int, signs: Signs, x: float, t: float) -> float:
        """Return by how much a guard is close enough at rest, there and right after."""
        size = _REST * (1.0 + abs(x)) * self._steepness(k, signs, 0.0, x, t)
        return size - abs(self.guards[k](0.0, x, t + _PROBE, signs))

    def project(self, mode: Mode, v: float, x: float, t: float) -> tuple[float, float]:
        """Return the velocity and displacement moved back onto the guards on which a mode is 0."""
        zeros = [k for k, sign in enumerate(mode) if not sign]
        rests = len(zeros) > 1  # and is moved along x alone
        v = 0.0 if rests else v
        for k in zeros:
            g_v, g_x, _ = self.gradient(k, mode, v, x, t)
            g_v = 0.0 if rests else g_v
            size = g_v * g_v + g_x * g_x
            if size > 0.0:
                off = self.guards[k](v, x, t, mode) / size
                v, x = v - off * g_v, x - off * g_x
        return v, x

    def settled(
        self, v: float, x: float, t: float, on: Iterable[int] = (), before: Mode = ()
    ) -> Mode:
        """Return the mode in which a motion continues from a state.

        Parameters
        ----------
        on : guards on which the state lies, even if they are not exactly zero
        before : the mode until then; where both sides lead away, its sign is kept, and what was held on
            one of `on` is held no longer
        """
        on = set(on)
        found = [0] * len(self.guards)
        free = []
        for k, guard in enumerate(self.guards):
            value = guard(v, x, t, found)
            scale = 1e-12 * (1.0 + abs(v) + abs(x))
            if k in on or abs(value) <= scale * self._steepness(k, found, v, x, t):
                free.append(k)
                found[k] = before[k] if before and before[k] else 1
            else:
                found[k] = 1 if value > 0.0 else -1
        for k in free:
            found[k] = self._side(k, tuple(found), v, x, t, before, loose=k in on)
        if len(free) > 1:  # each may depend on what the others have become
            for k in free:
                found[k] = self._side(k, tuple(found), v, x, t, tuple(found))
            # one that moves with time goes on
            held = [k for k in free if self._nearness(k, found, x, t) > 0.0]
            if len(held) > 1 and abs(v) <= _REST * (1.0 + abs(x)):
                rest = tuple(0 if k in held else sign for k, sign in enumerate(found))
                if self.rests(rest, x, t) and self._held(rest, held, x, t):
                    return rest
        sliding = [k for k in free if not found[k]]
        for k in sliding[1:]:  # two guards that coincide: the first holds the motion
            found[k] = before[k] if before and before[k] else 1
        return tuple(found)

    def _held(self, rest: Mode, free: Sequence[int], x: float, t: float) -> bool:
        """Return whether a motion stays at rest: whether every direction leads back to rest."""
        for signs in _all(rest):
            a = -self.function(0.0, x, t, signs)
            h = _PROBE
            ahead = (a * h, x + 0.5 * a * h * h, t + h)
            if all(signs[k] * self.guards[k](*ahead, signs) > 0.0 for k in free):
                return False
        return True

    def _beside(self, signs: Mode, v: float, x: float, t: float) -> float:
        """Return x'' on a side of a guard: along others, if they hold the motion."""
        if 0 in signs:
            return self.acceleration(signs, v, x, t)
        return -self.function(v, x, t, signs)

    def _steepness(self, k: int, signs: Signs, v: float, x: float, t: float) -> float:
        g_v, g_x, _ = self.gradient(k, signs, v, x, t)
        return abs(g_v) + abs(g_x) if isfinite(g_v + g_x) else 0.0

    def _side(
        self, k: int, mode: Mode, v: float, x: float, t: float, before: Mode, *, loose: bool = False
    ) -> int:
        """Return the side of a guard to which the motion leaves it, or 0 if neither leads away.

        Parameters
        ----------
        loose : whether the guard no longer holds the motion, which then leaves it to the side that is
            nearer to leading away, even if rounding hides that it does
        """
        away: list[int] = []
        outwards: dict[int, float] = {}
        for side in (-1, 1):
            signs = _with(mode, k, side)
            a = self._beside(signs, v, x, t)
            g_v, g_x, g_t = self.gradient(k, signs, v, x, t)
            rate = g_x * v + g_v * a + g_t
            size = abs(g_x * v) + abs(g_v * a) + abs(g_t)
            if abs(rate) <= 1e-9 * (size or 1.0) and abs(v) <= _REST * (1.0 + abs(x)):
                # at rest beside it: the guard follows from the acceleration
                rate = g_x * a if abs(g_v * a) <= 1e-9 * abs(g_x * a) else rate
            outwards[side] = side * rate
            if side * rate > 0.0:
                away.append(side)
        if len(away) == 1:
            return away[0]
        if not away and loose and before and before.count(0) == 1 and not before[k]:
            return max(outwards, key=outwards.__getitem__)
        if not away:
            below, above = (self.function(v, x, t, _with(mode, k, side)) for side in (-1, 1))
            if abs(above - below) > 1e-12 * (1.0 + abs(above)):
                return 0
        return before[k] if before and before[k] else 1


def slope(of: Callable[[float], float], at: float) -> float:
    """Return a derivative; one-sided at the edge of where the function is defined."""
    d = _NEAR * (1.0 + abs(at))
    below, above = of(at - d), of(at + d)
    if isfinite(above - below):
        return (above - below) / (2.0 * d)
    here = of(at)
    return (above - here) / d if isfinite(above) else (here - below) / d


def _with(mode: Mode, k: int, side: int) -> Mode:
    return (*mode[:k], side, *mode[k + 1 :])


def _all(mode: Mode) -> list[Mode]:
    """Return the modes with all combinations of signs in place of the zeros."""
    return list(product(*((sign,) if sign else (-1, 1) for sign in mode)))


def smooth(function: Callable[[float, float, float], float], autonomous: bool) -> Switching:
    """Return an equation without switches."""
    return Switching(lambda v, x, t, _signs: function(v, x, t), (), autonomous)
